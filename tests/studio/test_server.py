"""Who may talk to the studio, what it answers, and how it ends."""

import asyncio
import http.client
import json
import operator
import os
import random
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from contextlib import closing
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import uvicorn
from starlette.websockets import WebSocketDisconnect, WebSocketState
from websockets.exceptions import ConnectionClosed, InvalidStatus
from websockets.sync.client import connect

import gelcone.studio.server
from gelcone.atlas.processes import ProcessesEnded
from gelcone.codes import Regime
from gelcone.devices.units import FieldError
from gelcone.errors import InputError
from gelcone.membrane import made as tables
from gelcone.physics import statics
from gelcone.presets import load_presets
from gelcone.progress import Stopped, current_watch
from gelcone.studio import equilibria, exports, look, settled
from gelcone.studio.asked import MAP_CELLS, STRIP_VALUES
from gelcone.studio.page import Page
from gelcone.studio.pool import LANES
from gelcone.studio.server import LARGEST_MESSAGE, MOST_PAGES, Studio
from gelcone.studio.setting import Setting, Shelf
from gelcone.studio.slot import GRACE
from tests.studio.test_frames import unpack

PATIENCE = 120.0
"""Seconds to wait for an answer that will come, on a machine however busy."""

PUMP = {"device": "biased-pump"}
ENDLESS = {**PUMP, "values": {"frequency": "1e999 Hz"}}


class Running:
    """A studio in a thread of its own."""

    def __init__(self, host="127.0.0.1"):
        self.studio = Studio(Shelf(), host)
        listening = self.studio.listen()
        self.loop = asyncio.new_event_loop()

        def run():
            self.loop.run_until_complete(self.studio.serve(listening))
            self.loop.close()

        self.thread = threading.Thread(target=run)
        self.thread.start()
        self.origin = f"http://127.0.0.1:{self.studio.port}"

    def get(self, path, **headers):
        try:
            with urllib.request.urlopen(urllib.request.Request(self.origin + path, headers=headers)) as answer:
                return answer.status, dict(answer.headers), answer.read()
        except urllib.error.HTTPError as error:
            return error.code, dict(error.headers), error.read()

    def page(self, token=None, **options):
        address = f"ws://127.0.0.1:{self.studio.port}/ws?token={self.studio.token if token is None else token}"
        return connect(address, **{"origin": self.origin, "max_size": None} | options)

    def close(self):
        self.loop.call_soon_threadsafe(self.studio.stop)
        self.thread.join(10)
        assert not self.thread.is_alive()


@pytest.fixture(scope="module")
def server():
    running = Running()
    yield running
    running.close()


def ask(page, kind, number=1, **content):
    page.send(json.dumps({"kind": kind, "id": number, **content}))


def answer(page, kind, seconds=PATIENCE):
    """The next answer of a kind, or an error."""
    while True:
        head, arrays = unpack(page.recv(timeout=seconds))
        if head["kind"] in (kind, "error"):
            assert head["kind"] == kind, head
            return head, arrays


class Caller:
    """A connection of a page with the right origin and token, as far as the server asks it."""

    def __init__(self, studio):
        self.scope = {"server": ("127.0.0.1", studio.port)}
        self.headers = {"origin": f"http://127.0.0.1:{studio.port}"}
        self.query_params, self.said = {"token": studio.token}, []

    async def accept(self):
        self.said.append("accepted")

    async def close(self, code, reason):
        self.said.append((code, reason))


@pytest.mark.parametrize("already", [MOST_PAGES - 1, MOST_PAGES])
def test_as_many_pages_as_are_allowed_are_served_and_each_gives_its_place_back(already, monkeypatch):
    class Shown:
        def __init__(self, *given):
            pages.append(self)

        async def run(self):
            assert self in studio.pages
            raise RuntimeError("gone")

        def end(self):
            pages.append("ended")

    pages, studio = [], Studio(Shelf())
    monkeypatch.setattr(gelcone.studio.server, "Page", Shown)
    studio.pages |= set(range(already))
    caller = Caller(studio)
    try:
        if already < MOST_PAGES:
            with pytest.raises(RuntimeError, match="gone"):
                asyncio.run(studio._talk(caller))
            assert caller.said == ["accepted"]
            assert pages[1:] == ["ended"]
        else:
            asyncio.run(studio._talk(caller))
            assert caller.said == ["accepted", (1013, "too many pages")]
            assert pages == []
        assert studio.pages == set(range(already))
    finally:
        studio.pages.clear()
        studio.stop()


@pytest.mark.parametrize(
    ("host", "shown"),
    [
        ("127.0.0.1", "127.0.0.1"), ("::1", "[::1]"), ("here.local", "here.local"), ("0.0.0.0", "this-machine"),
        ("::", "this-machine"),
    ],
)  # fmt: skip
def test_the_address_is_one_that_a_browser_takes(host, shown, monkeypatch):
    """An address of version 6 stands in brackets, all addresses are those of this machine by its name, and what the
    page shows stands behind the token."""
    monkeypatch.setattr(socket, "gethostname", lambda: "this-machine")
    own = SimpleNamespace(host=host, port=8765)
    assert Studio._address(own, "token=abc", "device=pump") == f"http://{shown}:8765/?token=abc#device=pump"
    assert Studio._address(own, "token=abc", "") == f"http://{shown}:8765/?token=abc"


def test_what_is_wrong_with_a_look_is_said_of_its_side(server):
    with server.page() as page:
        for number, side, said in ((1, "a", "a"), (2, "b", "b"), (3, "c", None)):
            ask(page, "look", number, side=side, setting=PUMP, periods="many")
            head = answer(page, "error")[0]
            assert (head["id"], head.get("side")) == (number, said)


def test_a_studio_that_is_stopped_before_it_serves_ends_at_once():
    studio = Studio(Shelf())
    listening = studio.listen()
    studio.stop()
    asyncio.run(asyncio.wait_for(studio.serve(listening), 10.0))
    assert listening.fileno() == -1


def test_a_studio_that_has_ended_takes_no_connection_though_a_process_has_its_socket():
    studio = Studio(Shelf())
    listening = studio.listen()
    with closing(listening.dup()):

        async def main():
            asyncio.get_running_loop().call_later(0.2, studio.stop)
            await studio.serve(listening)

        asyncio.run(main())
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.1", studio.port), timeout=5.0)


def test_the_page_takes_the_token_and_binds_the_browser(server):
    status, headers, body = server.get(f"/?token={server.studio.token}")
    assert (status, b"gelcone studio" in body) == (200, True)
    directives = [part.split() for part in headers["content-security-policy"].split(";")]
    allowed = {name: set(sources) for name, *sources in directives}
    assert allowed.pop("frame-ancestors") == {"'self'", "http://127.0.0.1:*", "http://localhost:*"}
    assert allowed.pop("img-src") == {"'self'", "data:", "blob:"}
    assert all(allowed.pop(name) == {"'self'"} for name in ("script-src", "style-src", "connect-src"))
    assert allowed == {name: {"'none'"} for name in ("default-src", "base-uri", "form-action")}
    assert server.get("/")[0] == server.get("/?token=wrong")[0] == 403


def test_every_file_of_the_page_is_served_and_no_other(server):
    kinds = {".js": "text/javascript", ".css": "text/css", ".html": "text/html", ".svg": "image/svg+xml"}
    static = Path(__file__).parents[2] / "src" / "gelcone" / "studio" / "static"
    for path in static.iterdir():
        status, headers, body = server.get(f"/static/{path.name}")
        assert (status, body) == (200, path.read_bytes())
        assert headers["content-type"].partition(";")[0] == kinds[path.suffix]
        assert headers["x-content-type-options"] == "nosniff"
    for other in ("../server.py", "..%2Fserver.py", "%2Fetc%2Fpasswd", "x.js"):
        assert server.get(f"/static/{other}")[0] == 404


def test_the_page_fetches_nothing_from_elsewhere():
    static = Path(__file__).parents[2] / "src" / "gelcone" / "studio" / "static"
    for path in static.iterdir():
        text = path.read_text(encoding="utf-8").replace("http://www.w3.org/", "")
        assert "http://" not in text.replace("ws://${location.host}", ""), path
        assert "https://" not in text, path
        assert "innerHTML" not in text, path


def test_the_page_names_all_its_modules_so_that_they_load_at_once():
    static = Path(__file__).parents[2] / "src" / "gelcone" / "studio" / "static"
    text = (static / "index.html").read_text(encoding="utf-8")
    for path in static.glob("*.js"):
        assert f'"/static/{path.name}"' in text, path


def test_an_answer_is_not_held_back_until_the_one_before_is_acknowledged():
    studio = Studio(Shelf())
    listening = studio.listen()
    # another studio takes the port at once, and a browser that is gone is noticed
    assert listening.getsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR)
    assert listening.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)

    async def options():
        found = asyncio.get_running_loop().create_future()

        def come(reader, writer):
            own = writer.get_extra_info("socket")
            found.set_result(own.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
            writer.close()

        async with await asyncio.start_server(come, sock=listening):
            _, writer = await asyncio.open_connection("127.0.0.1", studio.port)
            writer.close()
            return await found

    assert asyncio.run(options())
    studio.stop()


def test_those_who_work_and_those_who_save_follow_the_names_that_were_given():
    names = frozenset({"mine:Law"})
    studio = Studio(Shelf(names=names))
    assert studio.pool.names == studio.saving.names == names
    assert (studio.pool.background, studio.saving.background, studio.saving.size) == (True, False, 1)
    studio.stop()


@pytest.mark.parametrize("port", [None, 70_000])
def test_a_port_that_cannot_be_had_is_said_with_what_to_do(server, port):
    port = server.studio.port if port is None else port
    other = Studio(Shelf())
    with pytest.raises(
        InputError, match=rf"^--port {port}: cannot listen on 127\.0\.0\.1 .*; choose another or leave it"
    ):
        other.listen(port)
    other.stop()


def test_a_studio_that_ends_ends_its_pages():
    class Open:
        ended = False

        def end(self):
            self.ended = True

    studio, pages = Studio(Shelf()), [Open(), Open()]
    studio.pages.update(pages)
    studio.stop()
    assert all(page.ended for page in pages)


def test_another_host_is_refused(server):
    for host in (
        "evil.example",
        f"evil.example:{server.studio.port}",
        "127.0.0.1",
        "",
        f"127.0.0.2:{server.studio.port}",
    ):
        assert server.get(f"/?token={server.studio.token}", Host=host)[0] == 421
    with pytest.raises(InvalidStatus) as refused, server.page(additional_headers={"Host": "evil.example"}):
        pass
    assert refused.value.response.status_code in (400, 421)  # two of them are no request at all


def test_a_studio_of_this_machine_alone_answers_to_no_name_that_others_know_it_by(server):
    port = server.studio.port
    assert server.studio.hosts("10.0.0.1") == {f"127.0.0.1:{port}", f"localhost:{port}", f"[::1]:{port}"}


def test_the_case_of_a_name_and_the_version_of_an_address_do_not_count():
    studio = Studio(Shelf(), "Here.Local")
    assert "here.local:0" in studio.hosts("127.0.0.1")
    assert {"10.0.0.1:0", "[::ffff:10.0.0.1]:0"} <= studio.hosts("::ffff:10.0.0.1")  # version 4 over a socket of 6
    studio.stop()


def test_what_is_wrong_with_the_first_setting_is_left_to_the_page(monkeypatch):
    """What it needs is loaded for as many periods as it is shown."""
    studio, asked = Studio(Shelf()), []
    studio.load(Setting(device="no-such-device"))
    monkeypatch.setattr(look, "response", lambda subject, periods: asked.append(periods))
    studio.load(Setting(device="biased-pump", values={"film": "taut"}))
    assert asked == [look.PERIODS]
    studio.stop()


def test_the_address_of_this_machine_is_ours_where_it_listens_on_all():
    running = Running("0.0.0.0")
    try:
        port, token = running.studio.port, running.studio.token
        for host in ("127.0.0.1", "127.0.0.2", "localhost", socket.gethostname()):
            running.origin = f"http://127.0.0.2:{port}"
            assert running.get(f"/?token={token}", Host=f"{host}:{port}")[0] == 200
        with connect(f"ws://127.0.0.2:{port}/ws?token={token}", origin=f"http://127.0.0.2:{port}") as page:
            ask(page, "hello")
            answer(page, "hello")
        for host in ("0.0.0.0", "127.0.0.3", "10.9.8.7", "evil.example"):
            status = running.get(f"/?token={token}", Host=f"{host}:{port}")[0]
            assert status == (200 if host == "0.0.0.0" else 421), host
    finally:
        running.close()


def test_refusals_bind_the_browser_too(server):
    token = server.studio.token
    for path, headers in {
        "/": {},
        "/static/none.js": {},
        "/nowhere": {},
        f"/?token={token}": {"Host": "evil.example"},
        "/ws": {},
    }.items():
        status, found, _ = server.get(path, **headers)
        assert status >= 400
        assert binds(found), path


def binds(headers):
    """Whether an answer holds the policy that binds the browser, and the rest of it."""
    found = {name.lower(): value for name, value in headers.items()}
    rest = {
        "x-content-type-options": "nosniff", "referrer-policy": "no-referrer",
        "cross-origin-resource-policy": "same-origin", "cache-control": "no-cache",
    }  # fmt: skip
    return "default-src 'none'" in found.get("content-security-policy", "") and rest.items() <= found.items()


def test_connections_that_ask_for_nothing_are_closed(monkeypatch):
    monkeypatch.setattr(gelcone.studio.server, "IDLE_SECONDS", 0.3)
    running = Running()
    begun = {
        "nothing": b"",
        "half a request": b"GET / HTTP/1.1\r\nHost: 127.0.0.1",
        "a request, then nothing": f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{running.studio.port}\r\n\r\n".encode(),
        "a request, then half of one": f"GET / HTTP/1.1\r\nHost: 127.0.0.1:{running.studio.port}\r\n\r\nGET".encode(),
    }
    try:
        with running.page() as page:
            sockets = {name: socket.create_connection(("127.0.0.1", running.studio.port)) for name in begun}
            for name, own in sockets.items():
                own.settimeout(3.0)
                own.sendall(begun[name])
            for own in sockets.values():
                while own.recv(65_536):  # until it is closed
                    pass
                own.close()
            ask(page, "hello")
            answer(page, "hello")  # a page that asks for nothing is left alone
    finally:
        running.close()


def test_a_connection_that_is_answered_meanwhile_has_its_time_again(monkeypatch):
    class Connection:
        cycle = None
        transport = SimpleNamespace(close=lambda: closed.append(now))

    closed, own, busy = [], Connection(), SimpleNamespace(response_complete=False)
    running = gelcone.studio.server._Server(uvicorn.Config(lambda: None))
    running.server_state.connections = {own}
    for now, own.cycle in ((0.0, None), (4.0, busy), (8.0, None), (12.9, None), (13.1, None)):
        clock = SimpleNamespace(monotonic=lambda now=now: now)
        monkeypatch.setattr(gelcone.studio.server, "time", clock)
        asyncio.run(running.on_tick(1))
    assert closed == [13.1]


def test_a_studio_ends_at_either_signal_and_leaves_both_as_they_were():
    """The setting that is shown first is loaded meanwhile, in a thread of its own."""
    calls, loaded = [], threading.Event()

    async def serve(listening):
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.raise_signal(number)
            await asyncio.sleep(0.01)
        calls.append(listening)

    studio = SimpleNamespace(load=lambda first: first == "first" and loaded.set(), serve=serve)
    studio.stop = lambda: calls.append("stopped")
    before = {number: signal.signal(number, lambda *_: None) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        own = [signal.getsignal(number) for number in before]
        gelcone.studio.server.run(studio, "listening", "first", lambda: calls.append("ready"))
        assert [signal.getsignal(number) for number in before] == own
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    assert calls == ["ready", "stopped", "stopped", "listening"]
    assert loaded.wait(10)


def test_a_ticket_opens_the_page_once(server):
    address = server.studio.ticket("preset=base")
    assert address.endswith("#preset=base")
    path = address.removeprefix(server.origin).partition("#")[0]
    with closing(http.client.HTTPConnection("127.0.0.1", server.studio.port)) as browser:
        browser.request("GET", path)
        answer = browser.getresponse()
        assert answer.status == 303  # a permanent one a browser would store, and with it the token behind the ticket
        assert answer.headers["location"] == f"/?token={server.studio.token}"
    assert not server.studio.tickets
    with urllib.request.urlopen(
        server.origin + path
    ) as answer:  # what a frame that is loaded again gets: the page, and no token
        assert answer.url.endswith(path)
        assert server.studio.token.encode() not in answer.read()


def test_the_token_is_not_printed(server):
    assert server.studio.token not in repr(server.studio)


@pytest.mark.parametrize(
    "wrong",
    [
        {"origin": "http://evil.example"},
        {"origin": "null"},
        {"origin": None},
        {"origin": "127.0.0.1:PORT"},
        {"origin": "//127.0.0.1:PORT"},
        {"origin": "https://127.0.0.1:PORT"},
        {"origin": "http://127.0.0.1"},
        {"origin": "http://127.0.0.1:PORT.evil.example"},
        {"origin": "http://http://127.0.0.1:PORT"},
        {"token": "wrong"},
        {"token": ""},
    ],
)
def test_a_foreign_page_cannot_talk(server, wrong):
    if wrong.get("origin"):
        wrong = {"origin": wrong["origin"].replace("PORT", str(server.studio.port))}
    with pytest.raises(InvalidStatus) as refused, server.page(**wrong):
        pass
    assert refused.value.response.status_code == 403
    assert binds(refused.value.response.headers)


def test_a_look_is_answered_in_parts(server):
    with server.page() as page:
        ask(page, "look", 7, side="a", setting=PUMP, periods=5, controls=True)
        head, _ = unpack(page.recv(timeout=PATIENCE))  # the controls come first
        assert (head["kind"], head["id"], head["side"]) == ("subject", 7, "a")
        assert {control["name"] for control in head["controls"]} >= {"frequency", "disc_radius"}
        head, arrays = answer(page, "response")
        assert (head["id"], head["side"], arrays["x"].size) == (7, "a", arrays["t"].size)
        head, arrays = answer(page, "kind")
        assert head["words"]["lines"][0] == "periodic, period 1"
        assert arrays["px"].size == 64
        ask(page, "look", 8, side="a", setting={"preset": "base"}, panels=["statics"])
        assert answer(page, "statics")[1]["voltage"].size > 10


def endless(*given):
    """An integration without an end."""
    current_watch().stop.wait(20.0)
    raise Stopped


def test_what_takes_too_long_is_given_up_and_the_next_is_answered(server, monkeypatch):
    monkeypatch.setattr(gelcone.studio.page, "EVIDENCE_SECONDS", 0.1)
    with server.page() as page:
        slow = {**PUMP, "values": {"frequency": "3e-5 Hz"}}
        ask(page, "look", 1, side="a", setting=slow, panels=["spectrum"])
        assert answer(page, "response")[0]["words"]["cut"]
        for stage in ("kind", "spectrum"):
            head = answer(page, "late")[0]
            assert (head["id"], head["side"], head["stage"]) == (1, "a", stage)
            assert "takes more than 0.1 s" in head["message"]
        monkeypatch.setattr(gelcone.studio.page, "RUN_SECONDS", 0.05)
        monkeypatch.setattr(look, "response", endless)
        ask(page, "look", 2, side="a", setting=PUMP)
        head = answer(page, "error")[0]
        assert (head["id"], head["message"].partition(";")[0]) == (2, "the run takes more than 0.05 s")
        monkeypatch.undo()
        ask(page, "look", 3, side="a", setting=PUMP)
        assert answer(page, "kind")[0]["id"] == 3


def test_a_drive_that_does_not_repeat_has_no_evidence_and_the_page_is_told_why_and_gets_the_rest(server):
    with server.page() as page:
        chirp = {"device": "soft-film", "values": {"film": "taut", "waveform": "chirp"}}
        ask(page, "look", 1, side="a", setting=chirp, panels=["spectrum", "statics"])
        answer(page, "response")
        head = answer(page, "late")[0]
        assert (head["stage"], head["message"].partition(",")[0]) == ("kind", "waveform = chirp: does not repeat")
        found = {}  # in either order: equilibria that another drive has found come at once
        while not found.keys() >= {"spectrum", "statics"}:
            head, arrays = unpack(page.recv(timeout=PATIENCE))
            found[head["kind"]] = arrays
        assert found["spectrum"]["amplitude"][1:].max() > 0.0
        assert found["statics"]["voltage"].size > 10


def test_a_fault_in_the_evidence_is_said_too(server, monkeypatch, caplog):
    monkeypatch.setitem(settled.STAGES, "kind", lambda subject: 1 / 0)
    with server.page() as page:
        ask(page, "look", 1, side="a", setting={"preset": "base"})
        head = answer(page, "late")[0]
        assert (head["stage"], head["message"]) == ("kind", "internal error; see the terminal")
    assert "ZeroDivisionError" in caplog.text


def test_current_power_and_pull_in_follow_once_the_hand_rests_and_equilibria_where_they_are_open(server, monkeypatch):
    for answers in (equilibria.PULL_INS, equilibria.STATICS):
        monkeypatch.setattr(answers, "stored", {})
    with server.page() as page:
        ask(page, "look", 1, side="a", setting=PUMP, panels=["statics"])
        names = {own["name"] for _ in range(2) for own in answer(page, "numbers", 60.0)[0]["words"]["numbers"]}
        subject = server.studio.shelf.subject(Setting(**PUMP))
        assert names == {"current", "power", f"static pull-in of the {look.pull_in_film(subject.model)}"}
        marks = answer(page, "statics", 60.0)[0]["words"]["marks"]
        assert equilibria.margins(subject).words["numbers"][0]["value"] == pytest.approx(marks["pull_in"], rel=1e-9)
        # of another drive they are known, and come before it rests
        ask(page, "look", 2, side="a", setting={**PUMP, "values": {"frequency": "9 Hz"}}, panels=["statics"])
        found = []
        while "statics" not in found:
            head, _ = unpack(page.recv(timeout=PATIENCE))
            if head["id"] == 2:
                found.append(head["kind"])
        assert found == ["response", "kind", "numbers", "statics"]


def test_what_takes_long_is_not_begun_while_the_hand_moves(server, monkeypatch):
    monkeypatch.setattr(equilibria.PULL_INS, "stored", {})
    monkeypatch.setattr(gelcone.studio.page, "RESTED_SECONDS", 0.3)
    begun = []
    electrical = settled.electrical
    monkeypatch.setattr(settled, "electrical", lambda subject, run: begun.append(1) or electrical(subject, run))
    with server.page() as page:
        for number in range(10):
            ask(page, "look", number, side="a", setting={**PUMP, "values": {"spring_rate": f"{10 + number} N/m"}})
            while answer(page, "kind")[0]["id"] != number:
                pass
        answer(page, "numbers")
    assert begun == [1]


def test_a_hand_that_waits_for_the_kind_of_motion_has_it_at_once(server, monkeypatch):
    monkeypatch.setattr(gelcone.studio.page, "GRACE", 60.0)
    for name in ("A_PICTURE", "LEAST"):  # nothing is saved up for it
        monkeypatch.setattr(gelcone.studio.page, name, 0.0)
    with server.page() as page:

        def look_at(number):
            ask(page, "look", number, side="a", setting={**PUMP, "values": {"frequency": f"{9 + 0.01 * number} Hz"}})

        look_at(1)
        answer(page, "kind")
        began = time.perf_counter()
        for number in (2, 3):
            look_at(number)
            assert answer(page, "kind")[0]["id"] == number
        assert time.perf_counter() - began < 60.0
        monkeypatch.setattr(gelcone.studio.page, "GRACE", 1.5)
        kind, known, moved_on = settled.STAGES["kind"], threading.Event(), threading.Event()

        def shown_later(subject):  # found, at its cost, and shown once the hand is elsewhere
            found = kind(subject)
            known.set()
            assert moved_on.wait(PATIENCE)
            return found

        monkeypatch.setitem(settled.STAGES, "kind", shown_later)
        for number in (4, 5, 6):  # a hand that moves on meanwhile does not rest
            look_at(number)
            answer(page, "response")
            assert known.wait(PATIENCE)
        began = time.perf_counter()
        moved_on.set()
        while answer(page, "kind")[0]["id"] != 6:
            pass
        assert time.perf_counter() - began > 1.0


def test_the_membrane_for_which_a_cone_stands_is_made_once_the_hand_rests_and_shown(server, monkeypatch):
    made, at_once = [], Shelf.at_once

    def cone_first(shelf, setting, compute, patient=False):
        subject, found, _ = at_once(shelf, setting, compute)
        made.append(patient)
        return subject, found, len(made) == 1

    monkeypatch.setattr(Shelf, "at_once", cone_first)
    monkeypatch.setattr(
        gelcone.studio.page, "make_membrane", operator.is_not
    )  # in a worker, and there is nothing to do
    with server.page() as page:
        ask(page, "look", 1, side="a", setting=PUMP)
        assert [answer(page, "response", 30.0)[0]["about"]["stands"] for _ in range(2)] == [True, False]
        assert answer(page, "kind")[0]["id"] == 1
    assert made == [False, True]  # what is not stored is then made in the studio itself


@pytest.mark.slow
def test_a_membrane_comes_in_the_place_of_its_cone(monkeypatch, tmp_path):
    monkeypatch.setenv("GELCONE_CACHE", str(tmp_path))
    tables._made.cache_clear()  # other tests of this process may have made it
    server = Running()
    with closing(server), server.page() as page:
        setting = {**PUMP, "values": {"film": "membrane", "voltage_amplitude": "500 V"}}
        ask(page, "look", 1, side="a", setting=setting, controls=True)
        found = []
        while not found or found[-1]["about"]["stands"]:
            found.append(answer(page, "response")[0])
        assert [(own["about"]["stands"], own["about"]["film_of"]) for own in found] == [
            (True, "cone"),
            (False, "membrane"),
        ]
        shared = {**setting, "values": setting["values"] | {"meridional_prestretch": "0.5"}}
        ask(page, "look", 2, side="a", setting=shared)
        assert answer(page, "response")[0]["about"]["stands"]


def test_another_rest_is_looked_for_once_the_hand_rests_and_shown(server, monkeypatch):
    monkeypatch.setattr(statics, "_rests", {})
    with server.page() as page:
        snap = {"film": "wrinkling"}
        ask(page, "look", 1, side="a", setting={"device": "snap-cone", "values": {**snap, "initial_height": "2 mm"}})
        while "static pull-in of the cone" not in [
            own["name"] for own in answer(page, "numbers", 60.0)[0]["words"]["numbers"]
        ]:
            pass
        ask(page, "look", 2, side="a", setting={"device": "snap-cone", "values": {**snap, "initial_height": "-2 mm"}})
        first = answer(page, "response")[1]["x"][0]
        assert first > 0.0
        head, arrays = answer(page, "response", 60.0)
        assert head["id"] == 2
        assert arrays["x"][0] == pytest.approx(-first, rel=1e-6)


def test_the_membrane_of_another_geometry_is_computed_once_the_hand_rests(server, monkeypatch):
    monkeypatch.setattr("gelcone.physics.film.pull_in.numbers_of", lambda *given: pytest.fail("under the hand"))
    with server.page() as page:
        values = {"film": "wrinkling", "disc_radius": "8.123 mm"}
        ask(page, "look", 1, side="a", setting={**PUMP, "values": values})
        first = answer(page, "kind")[0]
        again = answer(page, "kind", 60.0)[0]  # with what the membrane adds to the evidence
        assert (first["id"], again["id"]) == (1, 1)
        ask(page, "look", 2, side="a", setting={**PUMP, "values": values | {"frequency": "9 Hz"}})
        assert answer(page, "kind")[0]["id"] == 2  # its membrane is known


def test_an_error_names_its_control_and_the_page_goes_on(server):
    with server.page() as page:
        ask(page, "look", 1, side="a", setting={**PUMP, "values": {"disc_radius": "90 mm"}})
        head = unpack(page.recv(timeout=PATIENCE))[0]
        assert (head["kind"], head["control"]) == ("error", "disc_radius")
        assert "film_radius" in head["message"]
        ask(page, "look", 2, side="a", setting=PUMP)
        assert answer(page, "response")[0]["id"] == 2


def test_the_newest_request_wins_and_is_answered(server):
    with server.page() as page:
        for number in range(60):
            value = {"voltage_amplitude": f"{700 + number} V"}
            ask(page, "look", number, side="a", setting={**PUMP, "values": value})
        answered = []
        while not answered or answered[-1] != 59:
            answered.append(answer(page, "response")[0]["id"])
        assert answered == sorted(answered)
        assert len(answered) < 60


def test_a_picture_that_takes_longer_than_the_grace_comes_while_the_hand_still_moves(server, monkeypatch):
    response = look.response

    def slow(subject, periods):
        time.sleep(1.5 * GRACE)
        return response(subject, periods)

    monkeypatch.setattr(look, "response", slow)
    with server.page() as page:
        for number in range(60):
            ask(page, "look", number, side="a", setting=PUMP)
            time.sleep(0.02)
        answered = []
        while not answered or answered[-1] != 59:
            answered.append(answer(page, "response")[0]["id"])
        assert answered == sorted(answered)
        assert len(answered) >= 3


def test_what_refines_an_older_picture_gives_way_to_a_newer_one_at_once(server, monkeypatch):
    ended, in_time, response = threading.Event(), [], look.response

    def section(subject):
        current_watch().stop.wait(10)
        ended.set()
        raise Stopped

    def first_picture(subject, periods):
        if periods == 6:
            in_time.append(ended.wait(3))
        return response(subject, periods)

    chaotic = settled.Settled({}, {"regime": int(Regime.CHAOTIC), "lines": ["chaotic"], "extent": None})
    monkeypatch.setitem(settled.STAGES, "kind", lambda subject: chaotic)
    monkeypatch.setitem(settled.STAGES, "section", section)
    monkeypatch.setattr(look, "response", first_picture)
    with server.page() as page:
        ask(page, "look", 1, side="a", setting=PUMP, periods=5)
        answer(page, "kind")
        ask(page, "look", 2, side="a", setting=PUMP, periods=6)
        assert answer(page, "response")[0]["id"] == 2
    assert in_time == [True]


def malformed(number):
    """One of many kinds of messages that no page sends."""
    draw = random.Random(number)
    junk = "".join(draw.choice('{}[]":,0123456789eE+-.nulltrueNaN\\ \u00e9') for _ in range(draw.randrange(200)))
    return draw.choice(
        [
            junk,
            b"\x00\xff" * draw.randrange(50),
            "[" * draw.choice([10, 20_000]),
            json.dumps({"kind": "look"}),
            json.dumps(
                {
                    "kind": draw.choice(["hello", "look", "map", "export", "eval"]),
                    "id": draw.choice([-1, 1.5, None, "1", 2**60]),
                }
            ),
            json.dumps({"kind": "look", "id": 1, "side": draw.choice(["c", None, 3]), "setting": PUMP}),
            json.dumps(
                {"kind": "look", "id": 1, "side": "a", "setting": {"device": draw.choice(["/etc/passwd", 3, None])}}
            ),
            json.dumps(
                {"kind": "look", "id": 1, "side": "a", "setting": PUMP, "periods": draw.choice([0, -1, 1e99, "9"])}
            ),
            json.dumps(
                {"kind": "map", "id": 1, "setting": PUMP, "x": draw.choice([1, [], ["frequency", 1], {}]), "y": 3}
            ),
            json.dumps({"kind": "strip", "id": 1, "setting": PUMP, "over": ["frequency", 1e308, -1e308]}),
            json.dumps({"kind": "export", "id": 1, "setting": PUMP, "what": "simulate", "format": "../../x"}),
            json.dumps({"kind": "code", "id": 1, "setting": PUMP, "what": draw.choice(["os", 5, None])}),
            json.dumps({"kind": "cancel", "id": 1, "grid": draw.choice(["x", None, []])}),
            '{"kind": "look", "id": NaN}',
            '{"kind": "look", "id": 1%s}' % ("0" * 400),
            json.dumps({"kind": "look", "id": 1, "side": "a", "setting": PUMP, "periods": 10**400}),
            json.dumps({"kind": "look", "id": 1, "side": "a", "setting": PUMP, "periods": True}),
            '{"kind": "look", "id": 1, "side": "a", "setting": {"device": "biased-pump"}, "periods": 1e999}',
            json.dumps(
                {"kind": "map", "id": 1, "setting": PUMP, "x": ["frequency", 10**400, 1], "y": ["payload", 0, 1]}
            ),
            json.dumps({"kind": "strip", "id": 1, "setting": PUMP, "over": ["frequency", -(10**400), 10**400]}),
            json.dumps(
                {"kind": "export", "id": 1, "setting": PUMP, "what": "simulate", "options": {"periods": 10**400}}
            ),
            json.dumps({"kind": "look", "id": 1, "side": "a", "setting": {"file": "a." * 14_000 + "a=1"}}),
            json.dumps(
                {"kind": "look", "id": 1, "side": "a", "setting": {**PUMP, "values": {"frequency": "1e999 Hz"}}}
            ),
        ]
    )


@pytest.mark.parametrize("count", [30, pytest.param(1000, marks=pytest.mark.slow)])
def test_malformed_messages_are_refused_and_nothing_ends(server, count):
    with server.page() as page:
        for number in range(count):
            page.send(malformed(number))
            head = unpack(page.recv(timeout=PATIENCE))[0]
            assert head["kind"] == "error", (malformed(number), head)
        ask(page, "look", 3, side="a", setting=PUMP)
        assert answer(page, "response")[0]["id"] == 3


def test_a_connection_that_the_server_has_closed_meanwhile_counts_as_gone(server):
    class Closed:
        application_state = WebSocketState.CONNECTED

        async def send_bytes(self, frame):
            raise RuntimeError("Unexpected ASGI message 'websocket.send', after sending 'websocket.close'.")

    studio = server.studio
    page = Page(Closed(), studio.shelf, studio.pool, studio.saving)
    with pytest.raises(WebSocketDisconnect):
        asyncio.run(page.send({"kind": "error"}))
    page.end()


@pytest.mark.parametrize(
    ("kind", "content"),
    [
        ("map", {"x": ["voltage_amplitude", 0, 1500], "y": ["frequency", 1, 20]}),
        ("strip", {"over": ["frequency", 1, 20]}),
        ("envelope", {}),
        ("export", {"what": "simulate", "format": "nc"}),
        ("code", {"what": "simulate"}),
        ("device", {}),
    ],
)
def test_a_setting_that_takes_long_to_read_holds_up_nobody(server, monkeypatch, kind, content):
    begun, go_on = threading.Event(), threading.Event()

    def read(shelf, setting, **options):
        begun.set()
        go_on.wait(20)
        raise InputError("frequency: was read")

    for name in ("subject", "check"):
        monkeypatch.setattr(Shelf, name, read)
    with server.page() as one, server.page() as other:
        ask(one, kind, 5, setting=PUMP, **content)
        assert begun.wait(PATIENCE)
        for page in (one, other):
            ask(page, "hello")
            answer(page, "hello")
        go_on.set()
        head = unpack(one.recv(timeout=PATIENCE))[0]
        assert (head["kind"], head["id"], head["control"]) == ("error", 5, "frequency")


def test_a_page_that_reads_nothing_does_not_keep_the_studio_from_ending():
    running = Running()
    with running.page(close_timeout=0.1) as page:
        ask(page, "hello")
        answer(page, "hello")
        (own,) = running.studio.pages
        much = {"data": np.zeros(2**20, dtype=np.uint8)}
        for _ in range(40):
            asyncio.run_coroutine_threadsafe(own.send({"kind": "file"}, much), running.loop)
        began = time.monotonic()
        running.close()
        assert time.monotonic() - began < 1.0 * max(1.0, os.getloadavg()[0])


def test_messages_within_a_machine_are_not_compressed(server):
    with server.page() as page:
        assert page.protocol.extensions == []


def test_a_page_too_busy_to_answer_a_ping_keeps_its_connection(server):
    assert server.studio._server.config.ws_ping_interval is None


def test_a_message_too_long_ends_its_own_connection_alone(server):
    with server.page() as one, server.page() as other:
        one.send("x" * (LARGEST_MESSAGE + 10))
        with pytest.raises(ConnectionClosed) as closed:
            one.recv(timeout=PATIENCE)
        assert closed.value.rcvd.code == 1009
        ask(other, "hello")
        assert answer(other, "hello")[0]["devices"]


def test_a_page_that_leaves_gives_its_lanes_back(server):
    def all_free():
        end = time.monotonic() + 10
        while server.studio.pages and time.monotonic() < end:
            time.sleep(0.01)
        return not server.studio.pages and len(server.studio.pool._free) == LANES

    assert all_free()
    with server.page() as page:
        ask(page, "hello")
        answer(page, "hello")
        assert len(server.studio.pool._free) < LANES
    assert all_free()


@pytest.mark.slow
def test_ctrl_c_ends_all_within_a_second(tmp_path):
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-m", "gelcone", "studio", "--no-browser", "biased-pump"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    ) as process:
        ends_at_once(process)


def ends_at_once(process):
    address = process.stdout.readline().partition(": ")[2].split("#")[0]
    origin = address.partition("/?")[0]
    with connect(address.replace("http://", "ws://").replace("/?", "/ws?"), origin=origin, max_size=None) as page:
        axes = {"x": ["voltage_amplitude", 0, 1500], "y": ["frequency", 1, 20]}
        ask(page, "map", 1, setting=PUMP, **axes)
        answer(page, "cells", 120)
        workers = children(process.pid)
        assert workers
        began = time.monotonic()
        process.send_signal(signal.SIGINT)
        assert process.wait(10) == 0
        taken = time.monotonic() - began
    assert process.stderr.read() == ""
    end = time.monotonic() + 1.0
    while any(alive(pid) for pid in workers) and time.monotonic() < end:
        time.sleep(0.01)
    assert not [pid for pid in workers if alive(pid)]
    assert taken < 1.0 * max(1.0, os.getloadavg()[0])  # of a machine that others use, a share


def children(pid):
    """The processes that a process has started."""
    return [int(p) for p in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


def alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


# --- what is answered is what the analyses and the command line give -------------------------------------------------


def test_a_small_picture_is_that_of_a_device_or_preset_by_itself(server):
    with server.page() as page:
        for number, setting in enumerate((PUMP, {"device": "double-cone"}, {"preset": "base"})):
            ask(page, "glance", number, setting=setting)
            head, arrays = answer(page, "glance", 60.0)
            assert head["id"] == number
            assert len(arrays["t"]) == len(arrays["x"]) == look.GLANCE_SAMPLES + 1
            assert arrays["t"][0] == 0.0
            assert arrays["t"][-1] == pytest.approx(look.GLANCE_PERIODS * head["words"]["period"], rel=1e-3)
            assert head["about"]["rim"] > head["about"]["disc"] > 0.0
        for setting in ({**PUMP, "values": {"frequency": "9 Hz"}}, {"file": "name = 1"}, {"device": "../pump"}):
            ask(page, "glance", 9, setting=setting)
            assert answer(page, "error")[0]["id"] == 9


def test_files_and_commands_are_those_of_the_setting(server):
    setting = {**PUMP, "values": {"frequency": "9 Hz"}}
    own = Setting.read(setting)
    with server.page() as page:
        ask(page, "device", 3, setting=setting)
        head, arrays = answer(page, "file")
        assert (head["id"], head["name"]) == (3, "device.toml")
        device = gelcone.Device.from_text(arrays["data"].tobytes().decode())
        assert device == gelcone.find_device("biased-pump").replace(frequency="9 Hz")
        for what, options, axes in (
            ("simulate", {"periods": 7}, {}),
            ("regime", {}, {}),
            ("map", {}, {"x": ["voltage_amplitude", 100, 900], "y": ["frequency", 5, 15]}),
            ("bifurcation", {}, {"over": ["voltage_amplitude", 100, 900]}),
        ):
            ask(page, "code", 4, setting=setting, what=what, options=options, **axes)
            answered = answer(page, "code")[0]
            assert answered["command"].startswith(f"gelcone {what} biased-pump")
            assert not answered["own_file"]
            if not axes:
                wanted = exports.Wanted.read(what, options, ())
                assert answered["command"] == exports.command(own, wanted, "biased-pump")
                assert answered["python"] == exports.lines(own, wanted, "biased-pump")
            if what == "map":
                assert f"voltage_amplitude=100 V:900 V:{MAP_CELLS[0]}" in answered["command"]
                assert f"frequency=5 Hz:15 Hz:{MAP_CELLS[1]}" in answered["command"]
                assert "--set" not in answered["command"]  # the frequency is swept
            if what == "bifurcation":
                assert f"voltage_amplitude=100 V:900 V:{STRIP_VALUES}" in answered["command"]
                assert "frequency=9 Hz" in answered["command"]
        ask(page, "code", 5, setting={"file": gelcone.find_device("biased-pump").to_toml()}, what="regime")
        answered = answer(page, "code")[0]
        assert answered["own_file"]
        assert "device.toml" in answered["command"]


def test_the_page_is_told_what_there_is(server):
    with server.page() as page:
        ask(page, "hello", 9)
        head = answer(page, "hello")[0]
    assert (head["id"], head["version"]) == (9, gelcone.__version__)
    assert head["devices"] == list(server.studio.shelf.devices)
    assert head["presets"] == {name: preset.purpose for name, preset in load_presets().items()}
    assert [entry["name"] for entry in head["regimes"]] == [regime.label for regime in Regime]


def test_each_side_gets_its_own_answers_and_the_panels_that_are_open(server):
    with server.page() as page:
        ask(page, "look", 1, side="a", setting={"preset": "base"}, periods=3, panels=["spectrum"])
        ask(page, "look", 2, side="b", setting={"preset": "base", "values": {"voltage": "0.1"}}, periods=3)
        found = []
        while len(found) < 5:
            head, _ = unpack(page.recv(timeout=PATIENCE))
            if head["kind"] != "numbers":  # which come once the hand rests
                found.append((head["side"], head["id"], head["kind"]))
        assert sorted(found) == [
            ("a", 1, "kind"),
            ("a", 1, "response"),
            ("a", 1, "spectrum"),
            ("b", 2, "kind"),
            ("b", 2, "response"),
        ]
        assert "controls" not in head


@pytest.mark.parametrize(
    ("error", "control", "message"),
    [
        (FieldError("frequency", "frequency = 1: is\n  wrong"), "frequency", "frequency = 1: is wrong"),
        (InputError("--set voltage 9: is wrong"), "voltage", "--set voltage 9: is wrong"),
        (InputError("prestretch: must be positive"), "prestretch", "prestretch: must be positive"),
        (
            ProcessesEnded("gone"),
            None,
            "a worker process ended, perhaps for lack of memory; change a setting to try again",
        ),
        (KeyError("/secret/path"), None, "internal error; see the terminal"),
    ],
)
def test_an_error_is_one_line_with_its_control_and_a_fault_says_nothing_of_itself(server, error, control, message):
    sent = []
    page = Page(None, server.studio.shelf, server.studio.pool, server.studio.saving)

    async def send(head, arrays=None):
        sent.append(head)

    page.send = send
    asyncio.run(page.fail(5, error, "b"))
    page.end()
    assert sent == [{"kind": "error", "id": 5, "side": "b", "control": control, "message": message}]
