"""What a page may send and a link may hold, by someone who means harm: no module is imported, no file is opened, and
nothing is said about this machine."""

import json
import os
import random
import socket
import sys
import time
import tracemalloc

import numpy as np
import pytest

from gelcone import InputError
from gelcone.devices.files import shipped_devices
from gelcone.motion.settle import MOST_STRETCHES, clocks
from gelcone.studio import exports, look, settled
from gelcone.studio.grids import Source, kinds
from gelcone.studio.pool import Pool, work
from gelcone.studio.setting import Setting, Shelf
from tests.studio.test_frames import unpack
from tests.studio.test_server import PUMP, Running

PUMP_TEXT = shipped_devices()["biased-pump"].read_text(encoding="utf-8")


def pump_with(line):
    """The text of a device file with a line in place of the one of that name; at its end where it is a table."""
    name = line.partition(" ")[0]
    rows = [row for row in PUMP_TEXT.splitlines() if not row.startswith(f"{name} ")]
    at = rows.index("[material]") if "[material]" in rows else len(rows)
    return "\n".join([*rows, line] if line.startswith("[") else [*rows[:at], line, *rows[at:]])


@pytest.fixture
def trap(tmp_path, monkeypatch):
    """A module that leaves a file where it is imported, in any process that finds it; it never should be."""
    marker = tmp_path / "imported"
    (tmp_path / "evilmod.py").write_text(
        f"open({str(marker)!r}, 'w').close()\nimport gelcone\nclass K(gelcone.Waveform): name = 'k'\n"
    )
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(sys.path))
    monkeypatch.chdir(tmp_path)
    yield marker
    sys.modules.pop("evilmod", None)


NAMES = [
    {"waveform=evilmod:K": "1"},
    {"waveform=evilmod:K,voltage": "1"},
    {"waveform": "evilmod:K"},
    {"waveform": "sine+evilmod:K"},
    {"waveform": "sine\n--set waveform=evilmod:K"},
    {"bias": "spring+evilmod:K"},
    {"bias=spring+evilmod:K #": "1"},
    {"bias": "+"},
    {"bias": ""},
    {"circuit": "evilmod:K"},
    {"film": "evilmod:K"},
    {"film": "/etc/passwd"},
    {"film": "film.json"},
    {"film": "continuum"},
    {"film": '{"gelcone_film": 3, "law": "evilmod:K"}'},
    {"film=/dev/zero;x": "1"},
    {" film": "evilmod:K"},
    {"film ": "evilmod:K"},
    {"film.film": "taut"},
    {"evilmod:K.film": "taut"},
    {"film.x": "/etc/passwd"},
    {"law": "evilmod:K"},
    {"second_film": "evilmod:K"},
    {"second_drive": "evilmod:K"},
    {"pull_in": "evilmod:K"},
    {"material": "/etc/passwd"},
    {"material": "evilmod:K"},
    {"material.law": "evilmod:K"},
    {"material.name": "evilmod:K"},
    {"material.sources": "evilmod:K"},
    {"material=PVC-DBA 6:1\nfilm": "/etc/passwd"},
    {"name": "evilmod:K"},
    {"--film": "/etc/passwd"},
    {"preset": "evilmod:K"},
    {"component": "evilmod:K"},
    {"displacement=0,0 --film": "1"},
    {"voltage": "evilmod:K"},
    {"voltage_amplitude": "evilmod:K"},
    {"frequency": "1 Hz,2 Hz"},
    {"frequency": "1 Hz:2 Hz:3"},
    {"frequency": "1 Hz\nwaveform=evilmod:K"},
    {"": "1"},
    {"=": "1"},
    {"x" * 60_000: "1"},
]


@pytest.mark.parametrize("subject", [{"device": "biased-pump"}, {"preset": "base"}, {"file": PUMP_TEXT}])
@pytest.mark.parametrize("values", NAMES, ids=lambda values: str(values)[:40])
def test_a_link_names_only_controls_that_exist_and_their_choices(trap, subject, values):
    with pytest.raises(InputError) as refused:
        Shelf().subject(Setting.read({**subject, "values": values}))
    assert len(str(refused.value)) < 1000
    assert not trap.exists()


def test_a_control_of_another_choice_does_not_exist_until_it_is_chosen():
    shelf = Shelf()
    numbers = {"material.yeoh_c2": "0.1"}
    with pytest.raises(InputError, match=r"material\.yeoh_c2.*is not a control"):
        shelf.subject(Setting.read({**PUMP, "values": numbers}))
    found = shelf.subject(Setting.read({**PUMP, "values": {"material.law": "yeoh", "film": "taut"} | numbers}))
    assert found.device.material.yeoh_c2 == 0.1


FILES = [
    'film = "/etc/shadow"',
    'film = "/etc/passwd"',
    'film = "/dev/zero"',
    'film = "/no/such/file"',
    'film = "pipe"',
    'film = "film.json"',
    'film = "evilmod:K"',
    'film = "C:evilmod"',
    'film = ["taut", "/etc/passwd"]',
    'film = {component = "evilmod:K"}',
    'film = \'{"gelcone_film": 3, "law": "evilmod:K"}\'',
    '[film]\ncomponent = "evilmod:K"',
    '[[film]]\ncomponent = "evilmod:K"',
    '[film.nested]\ncomponent = "evilmod:K"',
    'film.component = "evilmod:K"',
    'material = "/etc/passwd"',
    'material = "evilmod:K"',
    'material.law = "evilmod:K"',
    'material.file = "/etc/passwd"',
    '[[material]]\nlaw = "evilmod:K"',
    'waveform = "evilmod:K"',
    '[waveform]\ncomponent = "evilmod:K"',
    'bias = "evilmod:K"',
    '[[bias]]\ncomponent = "evilmod:K"',
    'circuit = "evilmod:K"',
    'second_film = "evilmod:K"',
    'second_film = "/etc/passwd"',
    'second_drive = "evilmod:K"',
    'pull_in = "evilmod:K"',
    'prestretch_mode = "evilmod:K"',
    '[film]\ncomponent = "wrinkling"\nlaw = "evilmod:K"',
    '[film]\ncomponent = "wrinkling"\nlaw = {nested = {component = "evilmod:K"}}',
    '[bias]\ncomponent = "gelcone.physics.bias:Together"\nparts = [{nested = "evilmod:K"}]',
    'law = "evilmod:K"',
    'include = "/etc/passwd"',
    'component = "evilmod:K"',
]


@pytest.mark.parametrize("line", FILES)
def test_a_file_from_a_page_opens_no_other_and_imports_nothing(trap, line):
    os.mkfifo(trap.parent / "pipe")
    (trap.parent / "film.json").write_text('{"gelcone_film": 3, "law": "evilmod:K"}')
    with pytest.raises(InputError) as refused:
        Shelf().subject(Setting.read({"file": pump_with(line)}))
    message = str(refused.value)
    assert not trap.exists()
    assert "root:" not in message
    assert "/tmp" not in message.replace(line.partition('"')[2].rstrip('"'), "")


def test_a_refusal_does_not_say_whether_there_is_such_a_file(trap):
    (trap.parent / "there").write_text("")
    messages = []
    for path in ("/etc/passwd", "/dev/zero", "/root/secret", "/no/such/file", "there", "."):
        with pytest.raises(InputError) as refused:
            Shelf().subject(Setting.read({"file": pump_with(f'film = "{path}"')}))
        messages.append(str(refused.value).replace(repr(path), "PATH"))
    assert len(set(messages)) == 1


def in_worker(names, function, *arguments):
    """What a worker of a pool does with a task, here."""
    pool = Pool(1, background=False, names=names)
    try:
        return work(pool._task(0, 0, function, arguments))
    finally:
        pool.close()


def test_a_worker_follows_no_name_either(trap):
    source = Source(None, None, {"preset": "base", "settings": ["waveform=evilmod:K"]})
    with pytest.raises(InputError, match="does not ship"):
        in_worker(frozenset(), kinds, source, {"voltage": ["1"]})
    assert not trap.exists()


DATA = {
    "terms that overflow": 'component = "harmonics"\nterms = [[1, 1e300, 0]]',
    "a term of texts": 'component = "harmonics"\nterms = [["a", "b", "c"]]',
    "a harmonic of 40 digits": f'component = "harmonics"\nterms = [[{10**40}, 1, 0]]',
    "no terms": 'component = "harmonics"\nterms = 3',
    "nested levels": 'component = "staircase"\nlevels = [[1, 2], [3, 4]]',
    "levels in and out of lists": 'component = "staircase"\nlevels = [1, [2]]',
    "levels that overflow": 'component = "staircase"\nlevels = [1e308, -1e308]',
    "samples too close": 'component = "samples"\nshares = [0, 1e-300, 1]\nvalues = [0, 1, 0]\ninterpolation = "pchip"',
    "samples that overflow": 'component = "samples"\nshares = [0, 0.5, 1]\nvalues = [0, 1e300, 0]',
}


@pytest.mark.parametrize("data", DATA.values(), ids=DATA)
def test_data_of_a_waveform_that_cannot_be_computed_with_are_refused_in_words(data):
    setting = Setting.read({"file": pump_with(f"[waveform]\n{data}")})
    with pytest.raises(InputError, match=r"waveform: (harmonics|staircase|samples)") as refused:
        Shelf().subject(setting)
    assert len(str(refused.value)) < 300
    assert "ufunc" not in str(refused.value)


def test_a_drive_with_millions_of_corners_takes_no_memory():
    values = {"waveform": "square", "frequency": "100 kHz", "film": "taut"}
    subject = Shelf().subject(Setting.read({"device": "biased-pump", "values": values}))
    look.response(subject, 1)
    tracemalloc.start()
    try:
        found = settled.kind(subject)
        assert tracemalloc.get_traced_memory()[1] < 2e8
    finally:
        tracemalloc.stop()
    assert "corners too often" in " ".join(found.words["lines"])


def test_a_motion_far_faster_than_its_drive_takes_no_memory():
    values = {"material.relative_permittivity": "1e20", "film": "taut"}
    members = Shelf().subject(Setting.read({"device": "biased-pump", "values": values})).model.members()
    assert members.forcing_period[0] * members.fastest[0] > 1e9
    ((_, clock),) = clocks(members)
    assert clock.per_repeat == MOST_STRETCHES


# --- by messages ------------------------------------------------------------------------------------------------------

PRESET = {"preset": "base"}
EVIL = {"preset": "base", "values": {"waveform=evilmod:K": "1"}}
MESSAGES = [
    {"kind": "look", "side": "a", "setting": EVIL},
    {"kind": "look", "side": "b", "setting": EVIL},
    {"kind": "look", "side": "a", "setting": EVIL, "controls": True, "panels": ["spectrum", "statics"]},
    {"kind": "look", "side": "a", "setting": {"file": pump_with('film = "/etc/passwd"')}, "controls": True},
    {"kind": "map", "setting": EVIL, "x": ["voltage", 0, 1], "y": ["damping_ratio", 0, 1]},
    {"kind": "map", "setting": PRESET, "x": ["waveform=evilmod:K", 0, 1], "y": ["voltage", 0, 1]},
    {"kind": "map", "setting": PRESET, "x": ["voltage", 0, 1], "y": [["waveform", "evilmod:K"], 0, 1]},
    {"kind": "map", "setting": PRESET, "x": ["x" * 60_000, 0, 1], "y": ["voltage", 0, 1]},
    {"kind": "strip", "setting": PRESET, "over": ["voltage"] * 5000},
    {"kind": "map", "setting": PRESET, "x": ["voltage", "evilmod:K", 1], "y": ["damping_ratio", 0, 1]},
    {"kind": "map", "setting": PRESET, "x": ["waveform", 0, 1], "y": ["film", 0, 1]},
    {"kind": "strip", "setting": EVIL, "over": ["voltage", 0, 1]},
    {"kind": "strip", "setting": PRESET, "over": ["film=/etc/passwd", 0, 1]},
    {"kind": "envelope", "setting": EVIL},
    {"kind": "envelope", "setting": {"file": pump_with('film = "evilmod:K"')}},
    {"kind": "export", "setting": EVIL, "what": "simulate", "format": "nc"},
    {"kind": "export", "setting": PRESET, "what": "evilmod:K", "format": "nc"},
    {"kind": "export", "setting": PRESET, "what": "simulate", "format": "../../evil"},
    {"kind": "export", "setting": PRESET, "what": "simulate", "options": {"film": "evilmod:K"}, "format": "nc"},
    {"kind": "export", "setting": PRESET, "what": "map", "x": ["film", 0, 1], "y": ["voltage", 0, 1], "format": "nc"},
    {"kind": "code", "setting": EVIL, "what": "simulate"},
    {"kind": "code", "setting": {"preset": '"; import evilmod #'}, "what": "simulate"},
    {"kind": "code", "setting": {"device": "x'); import evilmod #"}, "what": "simulate"},
    {"kind": "code", "setting": PRESET, "what": "__import__"},
    {"kind": "device", "setting": EVIL},
    {"kind": "device", "setting": {"file": pump_with('film = "/etc/passwd"')}},
    {"kind": "cancel", "grid": "evilmod:K"},
    {"kind": "look", "side": "evilmod:K", "setting": PRESET},
    {"kind": "evilmod:K", "setting": PRESET},
]


def test_no_message_leads_to_an_import_or_a_file(trap, caplog):
    running = Running()
    try:
        with running.page() as page:
            for number, message in enumerate(MESSAGES):
                page.send(json.dumps({"id": number, **message}))
                head = unpack(page.recv(timeout=60))[0]
                assert head["kind"] == "error", (message, head)
                assert "terminal" not in head["message"], message
                assert len(head["message"]) < 1000
                assert not any(word in head["message"] for word in ("root:", "/tmp", "No such file", "Permission"))
    finally:
        running.close()
    assert not trap.exists()
    assert not caplog.records


# --- by numbers, names and requests -----------------------------------------------------------------------------------


def test_any_number_of_any_control_is_shown_or_refused_in_words():
    draw, shelf = random.Random(26), Shelf()
    makers = (
        lambda: f"{10.0 ** draw.uniform(-320, 307):g}",
        lambda: f"-{10.0 ** draw.uniform(-10, 10):g}",
        lambda: draw.choice(["0", "inf", "-inf", "+5", "...", "1.2.3", "1e400", "1e-400", "nan", "0x10", "1_000"]),
    )
    shown = 0
    for base in (Setting(device="paper-table1"), Setting(preset="base")):
        controls = [control for control in shelf.controls(base) if control.kind == "number"]
        for _ in range(40):
            control = draw.choice(controls)
            values = {control.name: f"{draw.choice(makers)()} {control.unit}".strip()}
            try:
                with np.errstate(all="ignore"):
                    subject = shelf.subject(Setting(base.device, base.preset, None, values))
                    look.response(subject, 20)
                    shown += 1
            except InputError:
                continue
    assert shown > 10


def test_the_name_of_a_device_is_no_part_of_a_command_or_of_lines_to_run():
    shelf = Shelf()
    for name in ('x"; import evilmod #', "x'); __import__('evilmod') #", "$(id)", "`id`", "a\\nb", "--out /etc/passwd"):
        setting = Setting.read({"file": pump_with(f"name = {json.dumps(name)}"), "values": {"frequency": "9 Hz"}})
        shelf.subject(setting)
        wanted = exports.Wanted.read("simulate", {"periods": 20}, ())
        text = exports.command(setting, wanted, shelf.called(setting))
        lines = exports.lines(setting, wanted, shelf.called(setting))
        assert name not in text + lines
        assert "evilmod" not in text + lines


def test_requests_that_no_browser_sends_are_refused():
    running = Running()
    port, token = running.studio.port, running.studio.token

    def status(text):
        with socket.create_connection(("127.0.0.1", port), timeout=10) as own:
            own.sendall(text.replace("PORT", str(port)).replace("TOKEN", token).encode())
            return int(own.recv(4096).split()[1])

    def got(path="/?token=TOKEN", host="127.0.0.1:PORT", method="GET"):
        return status(f"{method} {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n")

    try:
        assert got() == got(host="LOCALHOST:PORT") == 200
        for host in ("127.1:PORT", "localhost.:PORT", "127.0.0.1", "evil.example@127.0.0.1:PORT", "0.0.0.0:PORT",
                     "127.0.0.1:PORT.evil.example", "127.0.0.1:PORT, evil.example", "evil.example:PORT"):  # fmt: skip
            assert got(host=host) == 421, host
        for double in ("evil.example:PORT\r\nHost: 127.0.0.1:PORT", "127.0.0.1:PORT\r\nHost: evil.example:PORT"):
            assert got(host=double) == 400
        for path in ("/static/../server.py", "/static/%2e%2e%2fserver.py", "/static//etc/passwd", "//evil.example/"):
            assert got(path) == 404, path
        for path in ("/", "/?token=", "/?token=TOKENx", "/?TOKEN=TOKEN"):
            assert got(path) == 403, path
        for method in ("POST", "PUT", "DELETE", "TRACE", "OPTIONS"):
            assert got(method=method) == 405, method
    finally:
        running.close()


def test_a_file_of_a_thousand_unknown_fields_is_refused_at_once_in_few_lines():
    text = "\n".join(f"a{number}.b.c.d = 1" for number in range(1500))
    began = time.monotonic()
    with pytest.raises(InputError) as raised:
        Shelf().subject(Setting.read({"file": text}))
    assert time.monotonic() - began < 2.0
    assert len(str(raised.value).splitlines()) < 60
