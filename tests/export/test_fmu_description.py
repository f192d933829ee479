"""The description of an FMU says what is so, and its files are in their places.

Nothing is compiled: every variable of the description is compared with the device, row by row.
"""

import platform
import re
import xml.etree.ElementTree as ET

import pytest

import gelcone
from gelcone.errors import InputError
from gelcone.export import fmu
from gelcone.export.sources import CODES, INPUT_VARIABLES, RATE, Exported
from tests.export.instance import device


@pytest.fixture(scope="module")
def behind():
    """An amplifier adds states, and switches with borders."""
    return Exported(device(film="taut", series_resistance="1 MOhm", current_limit="2 mA"), "pump", False, 1e-9)


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


def test_files_of_devices_that_differ_have_tokens_that_differ(behind):
    """By which an importer notices a library of another description; the same device has the same token."""

    def token(own, **options):
        given = {"name": "pump", "inside": False, "tolerance": 1e-9} | options
        description = fmu._contents(Exported(own, **given), 2)["modelDescription.xml"]
        return ET.fromstring(description).get("guid")

    taut = device(film="taut")
    others = [taut.replace(film_thickness=1.01 * taut.film_thickness), taut.replace(film="wrinkling"), behind.device]
    tokens = [token(own) for own in (taut, *others)]
    tokens += [token(taut, inside=True), token(taut, tolerance=1e-7), token(taut, name="other")]
    assert len(set(tokens)) == len(tokens)
    assert token(device(film="taut")) == tokens[0]


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
        with pytest.raises(InputError, match=r"has no place in FMI 2\.0; give fmi = 3"):
            fmu._compilers("pump", 2, [name])
    assert set(fmu.PLATFORMS) == set(PLACES)
