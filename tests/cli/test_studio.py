"""``gelcone studio``: what it starts the browser with, and where it ends."""

import os
import stat
import webbrowser
from html import unescape
from pathlib import Path

import pytest

from gelcone.studio import server


@pytest.fixture
def started(monkeypatch, command_line):
    """Runs the command without serving: what is printed, and what the browser was started with and finds there; as
    ``err`` what it warns of."""

    def start(*arguments):
        opened = []

        def browse(address):
            page = Path(address.removeprefix("file://"))
            opened.append((address, page.read_text(), stat.S_IMODE(page.stat().st_mode | page.parent.stat().st_mode)))

        def run(studio, listening, first, ready):
            ready()
            for _ in range(200):
                if opened or ready.__name__ == "<lambda>":
                    break
                stop.wait(0.02)
            listening.close()
            studio.stop()

        import threading

        stop = threading.Event()
        monkeypatch.setattr(server, "run", run)
        monkeypatch.setattr(webbrowser, "open", browse)
        monkeypatch.setattr(os, "_exit", lambda code: None)
        code, out, err = command_line("studio", *arguments)
        assert code == 0, err
        start.err = err
        return out, opened

    return start


def test_the_browser_is_started_without_the_token_which_a_page_of_the_user_holds(started):
    out, [(opened, page, mode)] = started("--preset", "base")
    address = out.split()[2]
    token = address.partition("token=")[2].partition("#")[0]
    assert len(token) > 20
    assert token not in opened
    assert address in unescape(page)
    assert not mode & 0o077
    assert not Path(opened.removeprefix("file://")).exists()


@pytest.mark.parametrize(("host", "warned"), [("127.0.0.1", False), ("localhost", False), ("0.0.0.0", True)])
def test_an_address_that_others_can_reach_comes_with_a_warning(host, warned, started):
    started("--no-browser", "--host", host)
    said = f"warning: --host {host}: whoever can reach this machine"
    assert started.err.partition(" and has")[0] == (said if warned else "")


def test_no_browser_is_started_where_none_is_wanted(started):
    assert started("--no-browser")[1] == []
