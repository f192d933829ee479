"""``gelcone.studio(device)`` in a notebook."""

import subprocess
import sys
import urllib.error
import urllib.request
from types import SimpleNamespace

import pytest

import gelcone
from gelcone.studio import notebook
from gelcone.studio.notebook import elsewhere


@pytest.mark.parametrize("before", ["", "import gelcone.studio.server; "])
def test_it_is_called_by_its_public_name(before):
    code = f"import gelcone; {before}print(callable(gelcone.studio))"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip() == "True"


def test_the_frame_shows_the_page_of_the_device_and_ends():
    device = gelcone.find_device("biased-pump").replace(frequency="9 Hz")
    frame = gelcone.studio(device)
    try:
        shown = frame._repr_html_()
        assert "<iframe" in shown
        token = frame._studio.token
        assert token in frame.address
        assert token not in shown + repr(frame) + str(vars(frame))  # a notebook is stored with what it shows
        assert "frequency" in frame.address
        with urllib.request.urlopen(frame.address.partition("#")[0]) as answer:
            assert b"gelcone studio" in answer.read()
    finally:
        frame.close()
    with pytest.raises(urllib.error.URLError, match="refused"):
        urllib.request.urlopen(frame.address.partition("#")[0])


def test_a_frame_is_as_high_as_it_was_asked_to_be():
    frames = [gelcone.studio(height=300)]
    try:
        given = gelcone.find_device("biased-pump")
        frames += [gelcone.studio(own, height=400 + k) for k, own in enumerate(("snap-cone", given))]
        frames += [gelcone.studio(preset="base", height=500), gelcone.studio("biased-pump")]
        assert [frame.height for frame in frames] == [300, 400, 401, 500, notebook.HEIGHT]
        for frame in frames:
            assert f'height="{frame.height}"' in frame._repr_html_()
    finally:
        frames[0].close()


def test_a_notebook_has_one_server_however_often_it_asks_until_it_is_closed():
    first, second = gelcone.studio("biased-pump"), gelcone.studio(preset="base")
    for name in ("snap-cone", "double-cone"):  # of its own text, and with what ships alone
        assert gelcone.studio(gelcone.find_device(name))._studio is first._studio
    try:
        assert first._studio is second._studio
        assert first.address.partition("#")[0] == second.address.partition("#")[0]
        assert first.address != second.address
        assert first._repr_html_() != first._repr_html_()  # each opens once
    finally:
        second.close()
    first.close()  # it has ended with the other
    third = gelcone.studio("biased-pump")
    try:
        assert third._studio is not first._studio
        with urllib.request.urlopen(third.address.partition("#")[0]) as answer:
            assert answer.status == 200
    finally:
        third.close()


def test_pages_that_may_follow_other_names_have_a_server_of_their_own(monkeypatch):
    made = []

    class Running:
        def __init__(self, names):
            made.append(names)
            self.studio, self.thread = object(), SimpleNamespace(is_alive=lambda: self.lives)
            self.lives = True

    monkeypatch.setattr(notebook, "_Running", Running)
    monkeypatch.setattr(notebook, "_running", {})
    own = frozenset({"mine:Law"})
    frames = [notebook.StudioFrame({}, 700, names) for names in (frozenset(), own, own, frozenset())]
    assert made == [frozenset(), own]
    assert [frame._studio is frames[0]._studio for frame in frames] == [True, False, False, True]
    assert frames[1]._studio is frames[2]._studio
    frames[1]._own.lives = False
    assert notebook.StudioFrame({}, 700, own)._studio is not frames[1]._studio
    assert made == [frozenset(), own, own]


@pytest.mark.parametrize(
    ("variable", "name"),
    [
        ("JUPYTERHUB_SERVICE_PREFIX", "JupyterHub"),
        ("BINDER_SERVICE_HOST", "Binder"),
        ("CODESPACES", "GitHub Codespaces"),
        ("COLAB_RELEASE_TAG", "Colab"),
    ],
)
def test_what_stands_between_a_kernel_and_its_browser_is_named(variable, name, monkeypatch):
    assert elsewhere() == ""
    monkeypatch.setenv(variable, "there")
    assert elsewhere() == name


def test_what_is_no_single_device_is_refused():
    with pytest.raises(gelcone.InputError, match="ensemble"):
        gelcone.studio(gelcone.find_device("biased-pump").replace(frequency=[8.0, 9.0]))
    with pytest.raises(gelcone.InputError, match="one or the other"):
        gelcone.studio("biased-pump", preset="base")
    with pytest.raises(gelcone.InputError):
        gelcone.studio(preset="bse")


def test_gelcone_alone_does_not_load_it():
    code = "import sys, gelcone; print([m for m in sys.modules if 'studio' in m or m in ('uvicorn', 'starlette')])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True).stdout.strip() == "[]"
