"""What leaves gelcone says of itself what is so: options, the description of an FMU, its machines, and the page.

Nothing is compiled: every variable of the description is compared with the device, row by row.
"""

import inspect
import json
import platform
import re
import xml.etree.ElementTree as ET
from pathlib import Path
from types import SimpleNamespace

import pytest

import gelcone
from gelcone.errors import InputError
from gelcone.export import fmu, public, wasm
from gelcone.export.sources import CODES, INPUT_VARIABLES, RATE, Exported
from tests.export.instance import device

OPTIONS = {"fmi": (2, 3), "platforms": (("host",), ["linux"]), "drive": (None, "own"), "tolerance": (1e-7, 1e-9)}
"""Option -> its default and another value."""


@pytest.fixture(scope="module")
def taut():
    return device(film="taut")


@pytest.fixture(scope="module")
def behind():
    """An amplifier adds states, and switches with borders."""
    return Exported(device(film="taut", series_resistance="1 MOhm", current_limit="2 mA"), "pump", False, 1e-9)


# --- options ----------------------------------------------------------------------------------------------------------


@pytest.fixture
def asked(monkeypatch):
    """What is asked of those that write."""
    calls = []
    for name in ("write_fmu", "write_wasm", "_write_c"):
        real = inspect.signature(getattr(public, name))

        def ask(*given, name=name, real=real):
            calls.append((name, real.bind(*given).arguments))
            return [Path("there")]

        monkeypatch.setattr(public, name, ask)
    return calls


def described(call):
    name, given = call
    own = given["exported"]
    found = {"writer": name, "name": own.name, "drive": own.inside, "tolerance": own.tolerance, "force": given["force"]}
    found["path"] = given.get("path", given.get("folder"))
    return found | {n: given[n] for n in ("fmi", "platforms") if n in given}


@pytest.mark.parametrize(("path", "writer"), [("a.fmu", "write_fmu"), ("a.wasm", "write_wasm"), ("a", "_write_c")])
@pytest.mark.parametrize("option", [None, *OPTIONS, "force"])
def test_every_option_of_an_export_reaches_its_writer(path, writer, option, asked, taut, tmp_path):
    values = {n: usual for n, (usual, _) in OPTIONS.items()}
    changed = {} if option is None else {option: True if option == "force" else OPTIONS[option][1]}
    gelcone.export(taut, tmp_path / path, **changed)
    wanted = values | {"force": False} | changed
    wanted["drive"] = wanted["drive"] is not None
    if writer != "write_fmu":
        del wanted["fmi"], wanted["platforms"]
    assert described(asked.pop()) == wanted | {"writer": writer, "name": "a", "path": tmp_path / path}
    parameters = inspect.signature(public.export).parameters
    assert {n: parameters[n].default for n in OPTIONS} == values


def test_a_result_is_written_as_was_asked(monkeypatch, tmp_path):
    import xarray as xr

    asked, result = [], xr.Dataset()
    monkeypatch.setattr(public.interchange, "export", lambda *given, **how: asked.append((given, how)) or ["there"])
    for force in (False, True):
        assert gelcone.export(result, tmp_path / "run.csv", force=force) == ["there"]
        ((what, path), how) = asked.pop()
        assert (what is result, path, how) == (True, tmp_path / "run.csv", {"force": force})


@pytest.mark.parametrize("name", ["a.h", "a.c", "example.c", "test.c", "device.toml"])
def test_files_of_a_folder_are_not_overwritten(name, taut, tmp_path, monkeypatch):
    monkeypatch.setattr(public, "sources", lambda exported: {"a.h": "", "a.c": ""})
    for own in ("example", "test_program"):
        monkeypatch.setattr(public, own, lambda exported: "")
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / name).write_text("mine")
    with pytest.raises(InputError, match="exists already"):
        gelcone.export(taut, tmp_path / "a")
    assert [path.read_text() for path in (tmp_path / "a").iterdir()] == ["mine"]
    assert len(gelcone.export(taut, tmp_path / "a", force=True)) == 5


@pytest.mark.parametrize("name", ["a.wasm", "a.js", "a.html"])
def test_files_next_to_a_module_are_not_overwritten(name, taut, tmp_path, monkeypatch):
    monkeypatch.setattr(wasm, "_compiled", lambda exported: b"")
    (tmp_path / name).write_text("mine")
    with pytest.raises(InputError, match="exists already"):
        gelcone.export(taut, tmp_path / "a.wasm")
    assert (tmp_path / name).read_text() == "mine"
    assert len(gelcone.export(taut, tmp_path / "a.wasm", force=True)) == 3


# --- the description of an FMU ----------------------------------------------------------------------------------------


def rows(exported, fmi):
    """The description as a tree, and its variables by name in one form for both versions."""
    tree = ET.fromstring(fmu.description(exported, fmi, "{token}"))
    found = {}
    for k, row in enumerate(tree.find("ModelVariables"), start=1):
        own = dict(row[0].attrib, kind=row[0].tag) | dict(row.attrib) if fmi == 2 else dict(row.attrib, kind=row.tag)
        found[own["name"]] = own | {"row": k}
    return tree, found


@pytest.mark.parametrize("fmi", [2, 3])
def test_every_variable_is_described_as_what_it_is(fmi, behind):
    found = rows(behind, fmi)[1]
    kinds = ("Real", "Integer", "Boolean") if fmi == 2 else ("Float64", "Int32", "Boolean")
    borders = {f"border_{k}" for k in range(len(behind.program.border_switches))} if fmi == 3 else set()
    assert len(behind.program.border_switches) > 0
    names = {own.name: f"der({own.name.removesuffix(RATE)})" if own.kind == "rate" else own.name
             for own in behind.variables}  # fmt: skip
    assert set(found) == {names[own.name] for own in behind.variables if fmi == 3 or own.kind != "time"} | borders
    start = behind.start()[0]
    states = dict(zip((state.name for state in behind.system.states), start, strict=True))
    for place, own in enumerate(behind.variables):
        if own.kind == "time":
            continue
        row = found[names[own.name]]
        assert (int(row["valueReference"]), row["description"]) == (place, own.meaning)
        assert row.get("unit") == (own.unit or None)
        roles = {"input": "input", "rate": "local", "parameter": "parameter"}
        assert row["causality"] == roles.get(own.kind, "output")
        flag = own.kind == "code" and own.name in ("film_is_slack", "breakdown", "near_limit", "valid")
        assert row["kind"] == (kinds[2] if flag else kinds[1] if own.kind == "code" else kinds[0])
        variability = {"parameter": "tunable", "code": "discrete"}
        assert row["variability"] == variability.get(own.kind, "continuous")
        initial = {"input": None, "state": "exact", "parameter": "exact"}
        assert row.get("initial") == initial.get(own.kind, "calculated")
        if own.kind == "state":
            scale = behind.scale_values[next(s for s in behind.system.states if s.name == own.name).quantity]
            assert float(row["start"]) == pytest.approx(states[own.name] * scale, rel=1e-12)
        elif own.kind == "parameter":
            assert (
                float(row["start"]) == behind.parameters.values[own.name] == float(behind.device.get(own.name) or 0.0)
            )
        elif own.kind == "input":
            assert float(row["start"]) == 0.0
        else:
            assert "start" not in row
        if own.kind == "rate":
            state = found[own.name.removesuffix(RATE)]
            assert int(row["derivative"]) == (state["row"] if fmi == 2 else int(state["valueReference"]))
        else:
            assert "derivative" not in row
    assert {own.name for own in behind.variables if own.kind == "input"} == {own.name for own in INPUT_VARIABLES}
    assert {name for name, _ in CODES} <= set(found)


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_structure_lists_outputs_rates_and_what_is_unknown_at_first(fmi, behind):
    tree, found = rows(behind, fmi)
    key = (lambda row: row["row"]) if fmi == 2 else (lambda row: int(row["valueReference"]))
    of = {kind: {key(found[f"der({own.name.removesuffix(RATE)})" if kind == "rate" else own.name])
                 for own in behind.variables if own.kind == kind}
          for kind in ("state", "output", "code", "rate")}  # fmt: skip
    wanted = [of["state"] | of["output"] | of["code"], of["rate"], of["rate"] | of["output"] | of["code"]]
    structure = tree.find("ModelStructure")
    if fmi == 2:
        listed = [[int(own.get("index")) for own in structure.find(name)]
                  for name in ("Outputs", "Derivatives", "InitialUnknowns")]  # fmt: skip
        assert tree.get("numberOfEventIndicators") == str(len(behind.program.border_switches))
    else:
        names = ("Output", "ContinuousStateDerivative", "InitialUnknown")
        listed = [[int(own.get("valueReference")) for own in structure.findall(name)] for name in names]
        indicators = [int(own.get("valueReference")) for own in structure.findall("EventIndicator")]
        assert indicators == [int(found[f"border_{k}"]["valueReference"]) for k in range(len(indicators))]
        assert len(indicators) == len(behind.program.border_switches)
        assert (found["time"]["causality"], found["time"]["unit"]) == ("independent", "s")
        assert int(found["time"]["valueReference"]) == [own.name for own in behind.variables].index("time")
        assert len({own["valueReference"] for own in found.values()}) == len(found)
    assert [set(own) for own in listed] == wanted
    assert [len(own) for own in listed] == [len(own) for own in wanted]


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_head_of_a_description(fmi, behind):
    tree, found = rows(behind, fmi)
    own = tree.attrib
    assert (own["fmiVersion"], own["modelName"], own["description"]) == (f"{fmi}.0", "pump", behind.device.name)
    assert own["guid" if fmi == 2 else "instantiationToken"] == "{token}"
    assert own["generationTool"] == f"gelcone {gelcone.__version__}"
    experiment = tree.find("DefaultExperiment").attrib
    assert {n: float(v) for n, v in experiment.items()} == {
        "startTime": 0.0, "stopTime": 1.0, "tolerance": behind.tolerance, "stepSize": 1e-3,
    }  # fmt: skip
    exchange, stepped = tree.find("ModelExchange").attrib, tree.find("CoSimulation").attrib
    state = "FMUstate" if fmi == 2 else "FMUState"
    both = {"modelIdentifier": "pump", f"canGetAndSet{state}": "true", f"canSerialize{state}": "true"}
    more = {"canNotUseMemoryManagementFunctions": "true"} if fmi == 2 else {}
    steps = {"canHandleVariableCommunicationStepSize": "true"} | ({"canInterpolateInputs": "true"} if fmi == 2 else {})
    assert exchange == both | more
    assert stepped == both | more | steps
    units = {unit.get("name"): dict(unit[0].attrib) for unit in tree.find("UnitDefinitions")}
    assert set(units) == {row["unit"] for row in found.values() if row.get("unit")} | {"s"}
    for name, powers in units.items():
        known = dict(zip(fmu.BASES, fmu.UNITS[name], strict=True))
        assert powers == {base: str(power) for base, power in known.items() if power}


def test_the_token_is_that_of_the_sources_and_files_are_in_their_places(behind):
    for fmi in (2, 3):
        contents = fmu._contents(behind, fmi)
        names = {"sources/pump.h", "sources/pump.c", "sources/fmu.c", f"sources/fmi{fmi}.c", "resources/device.toml",
                 "modelDescription.xml"}  # fmt: skip
        assert set(contents) == names | ({"sources/buildDescription.xml"} if fmi == 3 else set())
        token = re.search(r'(?:guid|instantiationToken)="(\{\w{32}\})"', contents["modelDescription.xml"])[1]
        assert f'"{token}"' in contents["sources/fmu.c"]
        assert contents["resources/device.toml"] == behind.device.to_toml()
    assert 'modelIdentifier="pump"' in fmu._contents(behind, 3)["sources/buildDescription.xml"]


HOSTS = [
    ("Linux", "x86_64", "linux64", "x86_64-linux", ".so"), ("Linux", "aarch64", "", "aarch64-linux", ".so"),
    ("Windows", "AMD64", "win64", "x86_64-windows", ".dll"), ("Plan9", "x86_64", "", "", ""),
    ("Darwin", "x86_64", "darwin64", "x86_64-darwin", ".dylib"), ("Linux", "riscv64", "", "", ""),
    ("Darwin", "arm64", "", "aarch64-darwin", ".dylib"),
]  # fmt: skip


@pytest.mark.parametrize(("system", "machine", "second", "third", "ending"), HOSTS)
def test_the_library_of_this_machine_is_in_its_folder(system, machine, second, third, ending, monkeypatch):
    monkeypatch.setattr(platform, "system", lambda: system)
    monkeypatch.setattr(platform, "machine", lambda: machine)
    monkeypatch.setattr(fmu, "find_compiler", lambda: ["cc"])
    for fmi, folder in ((2, second), (3, third)):
        found = fmu._compilers("pump", fmi, ["host"])
        assert found == ({f"binaries/{folder}/pump{ending}": ["cc"]} if folder else {})
    monkeypatch.setattr(fmu, "find_compiler", lambda: None)
    assert fmu._compilers("pump", 2, ["host"]) == {}


PLACES = {
    "linux": ("linux64", "x86_64-linux", ".so", "x86_64-linux-gnu.2.17"),
    "linux-arm": ("", "aarch64-linux", ".so", "aarch64-linux-gnu.2.17"),
    "windows": ("win64", "x86_64-windows", ".dll", "x86_64-windows-gnu"),
    "macos": ("darwin64", "x86_64-darwin", ".dylib", "x86_64-macos"),
    "macos-arm": ("", "aarch64-darwin", ".dylib", "aarch64-macos"),
}
"""The folders of the standards, and the targets of the compiler."""


@pytest.mark.parametrize("name", PLACES)
def test_the_library_of_another_machine_is_in_its_folder(name, monkeypatch):
    second, third, ending, target = PLACES[name]
    monkeypatch.setattr(fmu, "cross_compiler", lambda own: ["zig", own])
    assert fmu._compilers("pump", 3, [name]) == {f"binaries/{third}/pump{ending}": ["zig", target]}
    if second:
        assert fmu._compilers("pump", 2, [name]) == {f"binaries/{second}/pump{ending}": ["zig", target]}
    else:
        with pytest.raises(InputError, match=r"has no place in FMI 2\.0; give --fmi 3"):
            fmu._compilers("pump", 2, [name])
    assert set(fmu.PLATFORMS) == set(PLACES)


# --- the page ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_the_page_has_the_numbers_of_its_device(film, tmp_path, monkeypatch):
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


# --- the C ------------------------------------------------------------------------------------------------------------


def test_the_header_numbers_the_variables_and_says_what_they_are(behind):
    from gelcone.export.sources import constant, sources

    header = sources(behind)["pump.h"]
    for place, own in enumerate(behind.variables):
        kind = own.kind if own.kind in ("input", "state", "parameter") else "read"
        unit = "" if own.unit in ("", "1") else f", {own.unit}"
        name = re.sub(r"\W", "_", own.name).upper()
        assert f"  PUMP_{name} = {place}, /* {kind}{unit}: " in header, own.name
        assert constant(own.name) == name
    assert f"PUMP_VARIABLES = {len(behind.variables)} /* how many there are */" in header
    assert "DEVICE" not in header
    n, program = behind.program.sizes, behind.program
    rooms = {
        "parameter": len(behind.parameters.values), "z": n["states"], "switches": len(program.switches),
        "numbers": len(program.numbers) + len(behind.parameters.scales), "out": len(program.outputs),
        "roots": n["roots"], "table": n["held"], "lanes": n["laws"] * n["rows"], "scratch": n["scratch"],
        "store": n["rows"], "words": n["words"], "input": 4,
    }  # fmt: skip
    assert {name: int(size) for name, size in re.findall(r"(\w+)\[(\d+)\]", header)} == {
        name: max(size, 1) for name, size in rooms.items()
    }
    ends = dict(re.findall(r"PUMP_(\w+) = (-?\d+)", header.split("enum pump_outcome {")[1].split("};")[0]))
    known = {own.name: own.value for own in gelcone.Outcome if own.name not in ("OUTSIDE", "ERROR")}
    assert {name: int(value) for name, value in ends.items()} == known | {"REFUSED": -1}


@pytest.mark.parametrize(("resistance", "shown"), [(None, "CURRENT"), ("1 MOhm", "CURRENT")])
@pytest.mark.parametrize("inside", [False, True])
def test_the_example_prints_what_there_is(resistance, shown, inside):
    from gelcone.export.sources import example

    more = {} if resistance is None else {"series_resistance": resistance}
    own = Exported(device(film="taut", voltage_offset=700.0, voltage_amplitude=80.0, **more), "pump", inside, 1e-7)
    text = example(own)
    assert ("current" in own.outputs) == (shown == "CURRENT")
    assert (f"PUMP_{shown}" in text, "current (A)" in text, "velocity (m/s)" in text) == (True, True, False)
    assert ("700.0 + 80.0 * sin(turn * 10.0" in text) == (not inside)
    assert "DEVICE" not in text
    hidden = SimpleNamespace(device=own.device, inside=inside, outputs={}, name="pump")
    assert ("PUMP_CURRENT" in example(hidden), "velocity (m/s)" in example(hidden)) == (False, True)


@pytest.mark.parametrize(("film", "kinds"), [("taut", [0]), ("wrinkling", [1])])
def test_a_film_that_wrinkles_has_kinds(film, kinds):
    from gelcone.export.sources import sources

    source = sources(Exported(device(film=film), "pump", False, 1e-7))["pump.c"]
    found = re.search(r"HAS_KINDS\[\] = \{\s*([\d, ]+)\s*\}", source)[1]
    assert [int(part) for part in found.split(",")] == kinds


@pytest.mark.parametrize(
    ("own", "of_gel", "value"), [(2e7, None, 2e7), (2e7, 4e7, 2e7), (None, 4e7, 4e7), (None, None, 0.0)]
)
def test_the_strength_is_that_of_the_device_else_of_its_gel_else_unknown(own, of_gel, value):
    made = device(film="taut").replace({"dielectric_strength": own, "material.dielectric_strength": of_gel})
    assert Exported(made, "pump", False, 1e-7).parameters.values["dielectric_strength"] == value
