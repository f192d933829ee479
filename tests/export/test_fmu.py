"""A device as an FMU: what FMPy, an independent importer, says of it and gets from it."""

from __future__ import annotations

import ctypes
import importlib.util
import zipfile
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

import gelcone
from gelcone.errors import DoubtfulInput, InputError, MissingDependency
from gelcone.export import fmu
from gelcone.export.compiler import find_compiler
from gelcone.export.fmu import PLATFORMS, UNITS
from gelcone.export.reference import Reference
from gelcone.export.sources import RATE, Exported
from tests.export.instance import device
from tests.export.test_c import WRINKLING

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler here")
STEP = 2e-3
TIMES = STEP * np.arange(151)


@pytest.fixture(scope="module")
def fmus(tmp_path_factory):
    """Files by key, each written once: of a taut pump (2, 3), driven from inside, and of one that wrinkles (wrinkling,
    pulls in)."""
    folder, found = tmp_path_factory.mktemp("fmus"), {}
    made = {
        2: (device(film="taut"), {"fmi": 2}),
        3: (device(film="taut"), {"fmi": 3}),
        "wrinkling": (device(**WRINKLING), {"fmi": 2, "drive": "sine", "tolerance": 1e-15}),
        "wrinkling 3": (device(**WRINKLING), {"fmi": 3, "drive": "sine", "tolerance": 1e-15}),
        "ending": (device(film="wrinkling"), {"fmi": 2}),
        "trapezoid": (device(film="taut", waveform="trapezoid"), {"fmi": 2, "drive": "own"}),
        "trapezoid 3": (device(film="taut", waveform="trapezoid"), {"fmi": 3, "drive": "own"}),
    }

    def of(key):
        if key not in found:
            own, options = made[key]
            (found[key],) = gelcone.export(own, folder / f"fmu {key}.fmu", **options)
        return str(found[key])

    return of


class Stepped:
    """An instance in co-simulation, by names of variables."""

    def __init__(self, path, folder):
        told = fmpy.read_model_description(path)
        self.references = {variable.name: variable.valueReference for variable in told.modelVariables}
        kind = FMU2Slave if told.fmiVersion == "2.0" else FMU3Slave
        self.fmu = kind(
            guid=told.guid,
            unzipDirectory=fmpy.extract(path, str(folder)),
            modelIdentifier=told.coSimulation.modelIdentifier,
            instanceName="one",
        )
        self.fmu.instantiate()
        if kind is FMU2Slave:
            self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        self._set = self.fmu.setReal if kind is FMU2Slave else self.fmu.setFloat64
        self._get = self.fmu.getReal if kind is FMU2Slave else self.fmu.getFloat64

    def __getitem__(self, name):
        return self._get([self.references[name]])[0]

    def __setitem__(self, name, value):
        self._set([self.references[name]], [value])

    def step(self, now, size):
        return self.fmu.doStep(currentCommunicationPoint=now, communicationStepSize=size)

    def close(self):
        self.fmu.terminate()
        self.fmu.freeInstance()


@pytest.fixture
def stepped(fmus, tmp_path):
    """Makes instances, which are freed at the end."""
    made = []

    def of(key):
        made.append(Stepped(fmus(key), tmp_path / f"{len(made)}"))
        return made[-1]

    yield of
    for one in made:
        one.close()


# --- the file ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("key", [2, 3, "wrinkling", "wrinkling 3"])
def test_the_importer_finds_no_problem(fmus, key):
    assert validate_fmu(fmus(key)) == []


def test_a_file_holds_sources_device_and_library(fmus, tmp_path):
    with zipfile.ZipFile(fmus(2)) as archive:
        names = archive.namelist()
        (tmp_path / "device.toml").write_bytes(archive.read("resources/device.toml"))
    assert gelcone.Device.from_toml(tmp_path / "device.toml") == device(film="taut")
    assert {"modelDescription.xml", "sources/fmi2.c", "sources/fmu_2.c", "sources/fmu_2.h", "sources/fmu.c"} <= set(
        names
    )
    assert [name for name in names if name.startswith("binaries/")]
    assert all(not name.startswith("/") and ".." not in name for name in names)


def test_a_motion_starts_where_the_device_does_in_si_units(fmus):
    own = device(film="taut")
    starts = {one.name: one.start for one in fmpy.read_model_description(fmus(2)).modelVariables}
    height, speed = own.initial_state()
    assert float(starts["displacement"]) == pytest.approx(float(height * own.scales.length), rel=1e-12)
    assert float(starts["velocity"]) == speed == 0.0
    assert 0.0 < float(starts["displacement"]) < own.film_radius


def test_the_same_device_makes_the_same_description(fmus, tmp_path):
    (again,) = gelcone.export(device(film="taut"), tmp_path / "fmu 2.fmu")
    texts = [zipfile.ZipFile(path).read("modelDescription.xml") for path in (fmus(2), again)]
    assert texts[0] == texts[1]


def test_without_a_compiler_the_sources_leave_and_a_line_says_so(tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.warns(DoubtfulInput, match="sources only"):
        (path,) = gelcone.export(device(film="taut"), tmp_path / "pump.fmu")
    assert not [name for name in zipfile.ZipFile(path).namelist() if "binaries" in name]
    assert validate_fmu(str(path)) == []


def test_a_file_appears_whole_or_not_at_all(tmp_path, monkeypatch):
    monkeypatch.setenv("CC", "false")
    with pytest.raises(InputError, match="false: does not compile"):
        gelcone.export(device(film="taut"), tmp_path / "pump.fmu")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "pump.fmu").write_text("mine")
    with pytest.raises(InputError, match="exists already"):
        gelcone.export(device(film="taut"), tmp_path / "pump.fmu")
    assert (tmp_path / "pump.fmu").read_text() == "mine"


def test_names_of_devices_stay_text_in_the_description(tmp_path):
    own = device(film="taut").replace(name='a "pump" <&> \x01 \u00e4')
    (path,) = gelcone.export(own, tmp_path / "pump.fmu")
    assert fmpy.read_model_description(str(path)).description == 'a "pump" <&>  \u00e4'


@pytest.mark.parametrize(
    ("options", "match"),
    [({"platforms": ["amiga"]}, "is not a platform"), ({"platforms": ["macos-arm"]}, "give fmi = 3")],
)
def test_machines_that_there_are_not_are_refused(tmp_path, options, match):
    with pytest.raises(InputError, match=match):
        gelcone.export(device(film="taut"), tmp_path / "pump.fmu", **options)
    assert list(tmp_path.iterdir()) == []


def test_libraries_of_other_machines_name_the_compiler_that_they_need(tmp_path, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda _: None)
    with pytest.raises(MissingDependency, match=r"pip install .gelcone\[platforms\]"):
        gelcone.export(device(film="taut"), tmp_path / "pump.fmu", platforms=["host", "windows"])


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("ziglang") is None, reason="ziglang is not installed")
def test_one_command_makes_libraries_for_five_machines(tmp_path):
    (path,) = gelcone.export(device(film="taut"), tmp_path / "pump.fmu", fmi=3, platforms=tuple(PLATFORMS))
    with zipfile.ZipFile(path) as archive:
        found = {name.split("/")[1]: archive.read(name)[:4] for name in archive.namelist() if "binaries" in name}
    assert found.keys() == {own.third for own in PLATFORMS.values()}
    assert found["x86_64-windows"][:2] == b"MZ"
    assert found["aarch64-linux"] == b"\x7fELF"
    assert validate_fmu(str(path)) == []


@pytest.mark.parametrize(("path", "options"), [("a.fmu", {"fmi": 1}), ("a.zip", {})])
def test_what_there_is_not_is_refused(tmp_path, path, options):
    with pytest.raises(InputError, match=r"must be 2 or 3|NAME\.fmu"):
        gelcone.export(device(film="taut"), tmp_path / path, **options)


# --- co-simulation and model exchange ---------------------------------------------------------------------------------


@pytest.mark.parametrize("key", ["wrinkling", "wrinkling 3"])
def test_both_kinds_give_the_motion_of_simulate(fmus, key):
    """Driven from inside, while the hoops of the film fall slack and taut: to 1e-13 of the stroke by the engine's own
    steps, to 1e-6 by the importer's CVODE at 1e-9 with its events."""
    run = gelcone.simulate(device(**WRINKLING), times=TIMES)
    right, states = 1e-3 * run.displacement.values, run.film_state.values
    options = {"stop_time": TIMES[-1], "output_interval": STEP, "output": ["displacement", "film_state", "valid"]}
    found = fmpy.simulate_fmu(fmus(key), fmi_type="CoSimulation", step_size=STEP, **options)
    assert np.abs(found["displacement"] - right).max() < 1e-13 * np.ptp(right)
    np.testing.assert_array_equal(found["film_state"], states)
    assert set(states) == {0, 1}
    assert found["valid"].all()
    found = fmpy.simulate_fmu(fmus(key), fmi_type="ModelExchange", relative_tolerance=1e-9, **options)
    at = np.searchsorted(found["time"], TIMES - 1e-12)
    assert np.abs(found["displacement"][at] - right).max() < 1e-6 * np.ptp(right)
    assert found["time"].size > TIMES.size  # its events


@pytest.mark.parametrize("key", ["trapezoid", "trapezoid 3"])
def test_corners_of_a_drive_inside_are_events_in_time(fmus, key):
    right = 1e-3 * gelcone.simulate(device(film="taut", waveform="trapezoid"), times=TIMES).displacement.values
    options = {"stop_time": TIMES[-1], "output_interval": STEP, "output": ["displacement"]}
    for kind, most in (("CoSimulation", 1e-7), ("ModelExchange", 1e-6)):
        found = fmpy.simulate_fmu(fmus(key), fmi_type=kind, relative_tolerance=1e-9, **options)
        at = np.searchsorted(found["time"], TIMES - 1e-12)
        assert np.abs(found["displacement"][at] - right).max() < most * np.ptp(right), kind
    assert found["time"].size > TIMES.size  # its corners


def test_an_input_with_a_slope_follows_the_drive(stepped):
    """Inputs of a millisecond with their slope, by the standard's own function and by the input of the rate."""
    own, times = device(film="taut"), 1e-3 * np.arange(201)
    volts = own.voltage_offset + own.voltage_amplitude * np.sin(2.0 * np.pi * own.frequency * times)
    right = 1e-3 * gelcone.simulate(own, times=times[1:]).displacement.values
    for key in (2, 3):
        instance, found = stepped(key), []
        for now, (before, after) in zip(times, pairwise(volts), strict=False):
            instance["voltage"] = before
            slope = (after - before) / 1e-3
            if key == 3:
                instance["voltage_rate"] = slope
            else:
                one, order = (ctypes.c_uint * 1)(instance.references["voltage"]), (ctypes.c_int * 1)(1)
                instance.fmu.fmi2SetRealInputDerivatives(
                    instance.fmu.component, one, 1, order, (ctypes.c_double * 1)(slope)
                )
            instance.step(now, 1e-3)
            found.append(instance["displacement"])
        assert np.abs(np.array(found) - right).max() < 5e-4 * np.ptp(right)


@pytest.mark.parametrize("key", [2, 3])
def test_a_stored_state_continues_with_the_same_bits_also_elsewhere(stepped, key):
    first, second = stepped(key), stepped(key)
    first["voltage"] = 900.0
    first["moving_mass"] = 6e-3
    first["dielectric_strength"] = 0.0  # that of a device of which it is not known
    first.step(0.0, 0.05)
    get, put, pack, unpack = (
        (first.fmu.getFMUstate, first.fmu.setFMUstate, first.fmu.serializeFMUstate, second.fmu.deSerializeFMUstate)
        if key == 2
        else (first.fmu.getFMUState, first.fmu.setFMUState, first.fmu.serializeFMUState, second.fmu.deserializeFMUState)
    )
    stored = get()
    first.step(0.05, 0.01)
    after = first["displacement"]
    put(stored)
    first.step(0.05, 0.01)
    assert first["displacement"] == after
    data = pack(stored)
    (second.fmu.setFMUstate if key == 2 else second.fmu.setFMUState)(unpack(data))
    second.step(0.05, 0.01)
    assert second["displacement"] == after
    assert (second["moving_mass"], second["dielectric_strength"]) == (6e-3, 0.0)
    for broken in (data[:-8], data + data, b"\xff" * len(data)):
        with pytest.raises(Exception, match="failed"):
            unpack(broken)
    assert second["displacement"] == after


@pytest.mark.parametrize("key", [2, 3])
def test_a_library_has_the_bits_of_the_integrator(stepped, key):
    """Contracted products and sums, or others in their order, would not."""
    instance = stepped(key)
    motion = Reference(Exported(device(film="taut"), "pump", False, 1e-7))
    instance["voltage"] = 900.0
    for k in range(20):
        instance.step(5e-3 * k, 5e-3)
        motion.time = 5e-3 * k
        motion.step(5e-3, (900.0, 0.0, 0.0, 0.0))
        assert instance["displacement"] == motion.z[0] * motion.exported.scale_values["length"]


def test_pull_in_ends_the_simulation_at_its_time(fmus):
    volts = 2700.0
    right = 1e-3 * float(
        gelcone.simulate(
            device(film="wrinkling", voltage_amplitude=0.0, voltage_offset=volts), times=[0.1]
        ).pull_in_time
    )
    options = {"start_values": {"voltage": volts}, "stop_time": 0.1, "output_interval": 1e-3, "output": ["outcome"]}
    found = fmpy.simulate_fmu(fmus("ending"), fmi_type="CoSimulation", step_size=1e-3, **options)
    assert found["time"][-1] == pytest.approx(right, rel=1e-6)
    found = fmpy.simulate_fmu(fmus("ending"), fmi_type="ModelExchange", relative_tolerance=1e-9, **options)
    assert found["time"][-1] == pytest.approx(right, rel=1e-5)


@pytest.mark.parametrize("key", [2, 3])
def test_what_is_not_a_number_is_an_error_and_changes_nothing(stepped, key):
    instance = stepped(key)
    instance["voltage"] = 700.0
    for name, value in {"voltage": np.nan, "moving_mass": 0.0, "external_force": np.inf, "current": 1.0}.items():
        with pytest.raises(Exception, match="failed"):
            instance[name] = value
    for size in (-1e-3, np.nan):
        with pytest.raises(Exception, match="failed"):
            instance.step(0.0, size)
    assert instance["voltage"] == 700.0
    instance.step(0.0, 0.01)
    assert np.isfinite(instance["displacement"])


def test_a_jump_far_across_pull_in_ends_and_does_not_hang(stepped):
    instance = stepped("ending")
    instance["voltage"] = 1e15
    with pytest.raises(Exception, match="failed"):
        instance.step(0.0, 1.0)
    assert instance.fmu.getBooleanStatus(3)


def test_instances_and_models_share_nothing(stepped, fmus):
    """Eight instances in threads, and two models in one process, each with the numbers that it has alone."""

    def run(instance, volts):
        instance["voltage"] = volts
        for k in range(50):
            instance.step(1e-3 * k, 1e-3)
        return instance["displacement"]

    alone = [run(stepped(2), 500.0 + 50.0 * k) for k in range(8)]
    together = [stepped(2) for _ in range(8)]
    other = stepped("wrinkling")
    with ThreadPoolExecutor(8) as pool:
        found = list(pool.map(run, together, [500.0 + 50.0 * k for k in range(8)]))
    assert found == alone
    run(other, 0.0)
    assert run(stepped(2), 500.0) == alone[0]
    assert len(set(alone)) == 8


def test_every_variable_has_a_unit_that_is_known(fmus):
    told = fmpy.read_model_description(fmus(2))
    exported = Exported(device(film="taut"), "fmu_2", False, 1e-7)
    assert [v.name for v in told.modelVariables if not v.name.startswith("der(")] == [
        v.name for v in exported.variables if v.kind not in ("rate", "time")
    ]
    units = {unit.name for unit in told.unitDefinitions}
    assert {v.unit for v in told.modelVariables if v.unit} <= units


def test_rates_are_those_of_the_states_that_were_set_last(fmus, tmp_path):
    """Also where the time stays what it was."""
    told = fmpy.read_model_description(fmus(2))
    fmu = FMU2Model(
        guid=told.guid,
        unzipDirectory=fmpy.extract(fmus(2), str(tmp_path)),
        modelIdentifier=told.modelExchange.modelIdentifier,
        instanceName="one",
    )
    fmu.instantiate()
    fmu.setupExperiment(startTime=0.0)
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    fmu.newDiscreteStates()
    fmu.enterContinuousTimeMode()
    right, rate = gelcone.rates(device(film="taut")), (ctypes.c_double * 2)()
    for state in ([0.012, 0.0], [0.014, 0.1]):
        fmu.setContinuousStates((ctypes.c_double * 2)(*state), 2)
        fmu.getDerivatives(rate, 2)
        np.testing.assert_allclose(list(rate), right(0.0, state, voltage=0.0), rtol=1e-12)
    fmu.terminate()
    fmu.freeInstance()


# --- units and machines by themselves ---------------------------------------------------------------------------------


def exponents(name):
    """Those of a name that is made of other units: ``N s/m``, ``V/m^2``."""
    over, _, under = name.partition("/")
    found = np.zeros(4)
    for part, sign in ((over, 1), (under, -1)):
        for own in part.split():
            base, _, power = own.partition("^")
            found += sign * int(power or 1) * np.array(UNITS[base])
    return found


def test_a_unit_that_is_made_of_others_has_their_exponents():
    made = [name for name in UNITS if "/" in name or " " in name]
    assert len(made) > 5
    for name in made:
        np.testing.assert_array_equal(UNITS[name], exponents(name), err_msg=name)
    for name, of in (
        ("Pa", "N/m^2"),
        ("J", "N m"),
        ("W", "J/s"),
        ("V", "W/A"),
        ("C", "A s"),
        ("F", "C/V"),
        ("ohm", "V/A"),
    ):
        np.testing.assert_array_equal(UNITS[name], exponents(of), err_msg=name)


def test_the_unit_of_a_rate_is_that_of_its_state_over_a_second():
    """Also of a charge that follows late and of the voltages of an amplifier."""
    late = {"material.dielectric_share": 0.3, "material.dielectric_time": "0.1 s"}
    own = device(film="taut").replace({**late, "filter_frequency": "200 Hz", "series_resistance": "1 MOhm"})
    variables = {one.name: one for one in Exported(own, "late", False, 1e-7).variables}
    rates = [one for one in variables.values() if one.kind == "rate"]
    assert {one.name for one in rates} == {f"{one.name}{RATE}" for one in variables.values() if one.kind == "state"}
    assert "C" in {one.unit for one in variables.values() if one.kind == "state"}
    for one in rates:
        state = variables[one.name.removesuffix(RATE)]
        assert one.unit in UNITS  # or the description has no such unit
        np.testing.assert_array_equal(exponents(one.unit), np.array(UNITS[state.unit]) - UNITS["s"], err_msg=one.name)
    assert {fmu._attributes(one, 0)["variability"] for one in variables.values() if one.kind == "parameter"} == {
        "tunable"
    }


def test_libraries_have_the_ending_of_their_machine():
    endings = {"linux": ".so", "windows": ".dll", "macos": ".dylib"}
    for name, machine in PLATFORMS.items():
        system = name.partition("-")[0]
        assert machine.ending == endings[system]
        assert system in machine.target
        assert ("aarch64" in machine.target) == ("aarch64" in machine.third) == name.endswith("-arm")
