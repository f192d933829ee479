"""A device as WebAssembly: the bits of the integrator in a JavaScript engine, and a page that stays a page."""

from __future__ import annotations

import functools
import json
import re
import shutil
import subprocess
import threading
from contextlib import closing
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import browser
import numpy as np
import pytest

import gelcone
from gelcone.errors import InputError, MissingDependency
from gelcone.export import compiler, wasm
from gelcone.export.reference import Reference
from gelcone.export.sources import Exported
from tests.export.instance import device
from tests.export.test_c import WRINKLING


def is_there():
    """Whether this machine makes and runs WebAssembly."""
    try:
        wasm.find_compiler()
    except MissingDependency:
        return False
    return shutil.which("node") is not None


made_here = pytest.mark.skipif(not is_there(), reason="there is no compiler for WebAssembly, or no node, here")
RUN = """
import { readFile } from "node:fs/promises";
import { device, VARIABLES } from "./pump.js";

const pump = await device(await readFile("pump.wasm"));
const found = [];
for (let k = 0; k < 100; ++k) {
  pump.set("voltage", 900 + 8 * k);
  const outcome = pump.step(5e-3);
  found.push([outcome, pump.get("displacement"), pump.get("velocity"), pump.get("film_state")]);
}
const refused = [];
for (const [name, value] of [["voltage", NaN], ["moving_mass", 0], ["current", 1], ["constructor", 1]]) {
  try { pump.set(name, value); } catch { refused.push(name); }
}
console.log(JSON.stringify({ found, refused, variables: Object.keys(VARIABLES) }));
"""


@made_here
def test_a_javascript_engine_gives_the_bits_of_the_integrator(tmp_path):
    own = device(**WRINKLING)
    paths = gelcone.export(own, tmp_path / "pump.wasm")
    assert [path.name for path in paths] == ["pump.wasm", "pump.js", "pump.html"]
    (tmp_path / "package.json").write_text('{"type": "module"}')
    (tmp_path / "run.js").write_text(RUN)
    done = subprocess.run(["node", "run.js"], cwd=tmp_path, capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)
    exported = Exported(own, "pump", False, 1e-7)
    motion, s = Reference(exported), exported.scale_values
    right = []
    for k in range(100):
        status = motion.step(5e-3, (900.0 + 8.0 * k, 0.0, 0.0, 0.0))
        right.append([status, motion.z[0] * s["length"], motion.z[1] * s["velocity"]])
    assert [row[:3] for row in found["found"]] == np.array(right).tolist()
    assert {row[3] for row in found["found"]} == {0, 1}
    assert found["refused"] == ["voltage", "moving_mass", "current", "constructor"]
    assert found["variables"] == [variable.name for variable in exported.variables]


class Quiet(SimpleHTTPRequestHandler):
    """Serves files, and says nothing."""

    def log_message(self, *_):
        pass


@made_here
@pytest.mark.skipif(browser.find_browser() is None, reason="no Chromium on this machine (Debian: chromium)")
def test_the_page_runs_and_comes_to_rest_where_a_slow_ramp_ends(tmp_path):
    """Its first frame may have begun before the device was there: a step of negative length ended it at once."""
    own = device(**WRINKLING | {"voltage_amplitude": 0.0, "voltage_offset": 700.0, "damping_coefficient": 0.5})
    gelcone.export(own, tmp_path / "pump.wasm")
    server = ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=tmp_path))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    said = "(document.getElementById('said')?.textContent ?? '')"
    with closing(server.socket), browser.Browser() as found:
        found.page.go(f"http://127.0.0.1:{server.server_port}/pump.html")
        found.page.wait(f"parseFloat({said}.split(', ')[1]) > 1.0 || {said}.includes('ended')", 20.0)
        words = found.page.js(said)
        server.shutdown()
    assert "ended" not in words
    height = float(words.removeprefix("height ").split(" ")[0])
    settles = gelcone.static(own, ["700 V"])
    assert height == pytest.approx(float(settles["rest_displacement"] + settles["stroke"][0]), abs=0.02)


PAGE = """
const shown = { volts: {}, said: {}, again: {}, voltage: { value: "650" } }, calls = [], drawn = [];
const paint = new Proxy({}, {
  get: (_, name) => (...given) => drawn.push([name, ...given]),
  set: (_, name, value) => { drawn.push([name, value]); return true; },
});
let frames = [], now = 1000, outcome = 0, made = null;
const canvas = { width: 1200, height: 560, getContext: () => paint };
globalThis.document = { getElementById: (id) => shown[id], querySelector: () => canvas };
globalThis.requestAnimationFrame = (call) => frames.push(call);
globalThis.performance = { now: () => now };
globalThis.fetch = async (name) => ({ arrayBuffer: async () => name });
const values = { displacement: 0.0125, dielectric_strength: 4e7, true_field: 1e7, time: 2.345 };
const device = async (bytes) => {
  made = bytes;
  return {
    init: () => calls.push(["init"]), set: (name, value) => calls.push([name, value]),
    step: (seconds) => { calls.push(["step", seconds]); return outcome; }, get: (name) => values[name],
  };
};
const frame = (passed) => { now += passed; const own = frames; frames = []; own.forEach((call) => call(now)); };
const state = () => [shown.volts.textContent, shown.said.textContent, calls.splice(0), drawn.splice(0)];
await (async () => {
BODY
})();
const found = { made };
frame(16); found.first = state();
frame(500); found.late = state();
outcome = 6; frame(16); found.ended = state();
frame(16); found.after = state();
outcome = 0; shown.again.onclick(); frame(16); found.again = state();
console.log(JSON.stringify(found));
"""
"""The script of a page in a document that only records."""


@pytest.mark.skipif(shutil.which("node") is None, reason="no node on this machine")
def test_the_page_draws_the_cone_and_says_its_height(tmp_path, monkeypatch):
    """Voltage and passed time go to the device; its height is drawn in proportion and its field gives the colour."""
    monkeypatch.setattr(wasm, "_compiled", lambda exported: b"")
    own = device(film="taut")
    gelcone.export(own, tmp_path / "pump.wasm")
    page = (tmp_path / "pump.html").read_text(encoding="utf-8")
    body = page.partition('<script type="module">')[2].partition("</script>")[0]
    line = 'import { device } from "./pump.js";'
    assert line in body
    (tmp_path / "run.mjs").write_text(PAGE.replace("BODY", body.replace(line, "")), encoding="utf-8")
    done = subprocess.run(["node", "run.mjs"], cwd=tmp_path, capture_output=True, text=True, check=True)
    found = json.loads(done.stdout)
    assert found["made"] == "pump.wasm"
    volts, said, calls, drawn = found["first"]
    assert (volts, said) == ("650 V", "height 12.50 mm, 2.3 s")
    assert calls == [["voltage", 650], ["step", pytest.approx(0.016)]]
    scale, middle, rim = 0.46 * 1200 / own.film_radius, 600.0, 0.64 * 560
    inner, height = own.disc_radius * scale, rim - 0.0125 * scale
    edges = [[name, *map(pytest.approx, place)] for name, *place in (
        ("moveTo", middle - 0.46 * 1200, rim), ("lineTo", middle - inner, height),
        ("moveTo", middle + 0.46 * 1200, rim), ("lineTo", middle + inner, height),
    )]  # fmt: skip
    assert [own for own in drawn if own[0] in ("moveTo", "lineTo")] == edges
    assert drawn[0] == ["clearRect", 0, 0, 1200, 560]
    assert ["strokeStyle", f"hsl({215 - 190 * 0.25} 75% 48%)"] in drawn
    disc = next(own for own in drawn if own[0] == "fillRect")
    assert disc[1:4] == pytest.approx([middle - inner, height - 12.0, 2.0 * inner])
    assert found["late"][2] == [["voltage", 650], ["step", 0.05]]
    assert found["ended"][1] == "height 12.50 mm, the film has ended: pulled in, or at its limit"
    assert found["after"][2] == [["voltage", 650]]
    assert found["again"][2] == [["init"], ["voltage", 650], ["step", pytest.approx(0.016)]]


@made_here
def test_a_title_stays_text(tmp_path):
    own = device(film="taut").replace(name='</script><script>alert("*/")</script>')
    gelcone.export(own, tmp_path / "pump.wasm")
    assert "<script>alert" not in (tmp_path / "pump.html").read_text()
    assert (tmp_path / "pump.js").read_text().splitlines()[0].count("*/") == 1
    with pytest.raises(InputError, match="exists already"):
        gelcone.export(own, tmp_path / "pump.wasm")


@pytest.mark.parametrize(("offset", "begin", "most"), [("-1.2 kV", 1200, 2400), ("0 V", 0, 600)])
def test_the_slider_of_the_page_reaches_beyond_the_peak_of_the_drive(tmp_path, monkeypatch, offset, begin, most):
    monkeypatch.setattr(wasm, "_compiled", lambda exported: b"")
    own = device(film="taut").replace(voltage_offset=offset, voltage_amplitude="0.4 kV")
    gelcone.export(own, tmp_path / "pump.wasm")
    page = (tmp_path / "pump.html").read_text(encoding="utf-8")
    (slider,) = (part for part in page.split("<") if part.startswith("input") and "range" in part)
    assert f'max="{most}"' in slider
    assert f'value="{begin}"' in slider


def test_without_a_compiler_the_remedy_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(wasm.importlib.util, "find_spec", lambda _: None)
    monkeypatch.setattr(wasm.shutil, "which", lambda _: None)
    with pytest.raises(MissingDependency, match=r"pip install .gelcone\[platforms\]"):
        gelcone.export(device(film="taut"), tmp_path / "pump.wasm")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("said", "first"), [("one: lost\ntwo", "one: lost"), ("", "no message")])
def test_a_compiler_that_fails_is_named_with_its_first_line(said, first, monkeypatch):
    failed = subprocess.CompletedProcess([], 1, stdout="", stderr=said)
    monkeypatch.setattr(wasm, "find_compiler", lambda: ["my-cc", "-target", "wasm32"])
    monkeypatch.setattr(compiler.subprocess, "run", lambda *given, **how: failed)
    with pytest.raises(InputError) as error:
        wasm._compiled(Exported(device(film="taut"), "pump", False, 1e-7))
    assert str(error.value) == f"my-cc: does not make WebAssembly of the source ({first}); install ziglang"


def test_a_clang_without_its_builtins_is_no_compiler(tmp_path, monkeypatch):
    clang = tmp_path / "clang"
    for printed, whole in (("/nowhere/libclang_rt.builtins-wasm32.a", False), (__file__, True)):
        clang.write_text(f"#!/bin/sh\necho {printed}\n")
        clang.chmod(0o755)
        assert wasm._has_builtins((str(clang), "--target=wasm32-wasi")) is whole


@pytest.mark.parametrize(("inside", "begin"), [(False, 700), (True, 0)])
def test_the_slider_of_the_page_begins_at_the_offset_that_the_drive_inside_does_not_give(
    inside, begin, tmp_path, monkeypatch
):
    """It reaches half as far again as the peak of the device's own drive, whatever the sign of the offset."""
    monkeypatch.setattr(wasm, "_compiled", lambda exported: b"")
    own = device(film="taut", voltage_amplitude=100.0, voltage_offset=-700.0)
    wasm.write_wasm(Exported(own, "pump", inside, 1e-9), tmp_path / "pump.wasm", False)
    assert f'min="0" max="1200" value="{begin}"' in (tmp_path / "pump.html").read_text(encoding="utf-8")


def test_the_name_of_a_device_is_a_text_of_the_page_and_no_part_of_it(tmp_path, monkeypatch):
    monkeypatch.setattr(wasm, "_compiled", lambda exported: b"")
    own = device(film="taut").replace(name="a <script>alert(1)</script> & co")
    gelcone.export(own, tmp_path / "pump.wasm")
    page = (tmp_path / "pump.html").read_text(encoding="utf-8")
    assert "<h1>a &lt;script&gt;alert(1)&lt;/script&gt; &amp; co</h1>" in page
    assert "<script>alert" not in page


@pytest.mark.parametrize("name", ["a.wasm", "a.js", "a.html"])
def test_files_next_to_a_module_are_not_overwritten(name, tmp_path, monkeypatch):
    monkeypatch.setattr(wasm, "_compiled", lambda exported: b"")
    taut = device(film="taut")
    (tmp_path / name).write_text("mine")
    with pytest.raises(InputError, match="exists already"):
        gelcone.export(taut, tmp_path / "a.wasm")
    assert (tmp_path / name).read_text() == "mine"
    assert len(gelcone.export(taut, tmp_path / "a.wasm", force=True)) == 3


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_the_page_and_the_script_have_the_numbers_of_their_device(film, tmp_path, monkeypatch):
    monkeypatch.setattr(wasm, "_compiled", lambda exported: b"module")
    own = Exported(device(film=film), "pump", False, 1e-7)
    paths = wasm.write_wasm(own, tmp_path / "any.wasm", False)
    assert [path.name for path in paths] == ["pump.wasm", "pump.js", "pump.html"]
    module, script, page = (path.read_bytes().decode() for path in paths)
    assert module == "module"
    table = json.loads(re.search(r"VARIABLES = (\{.*?\})", script, re.DOTALL)[1])
    assert table == {variable.name: k for k, variable in enumerate(own.variables)}
    assert gelcone.__version__ in script
    assert own.device.name in script.splitlines()[0]
    assert f"[{own.device.disc_radius}, {own.device.film_radius}]" in page
    assert ('own.get("true_field") / (strength || Infinity)' in page) == ("true_field" in own.outputs)
    assert not re.search("DEVICE|FIELD_READ|GELCONE_VERSION|VARIABLES_TABLE", page + script)
