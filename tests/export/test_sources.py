"""The text of an exported device: variables with their units, its numbers, and what its example does."""

from __future__ import annotations

import re
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.errors import InputError
from gelcone.export.sources import Exported, constant, example, in_comment, outputs_of, sources
from gelcone.motion.flow import smallest_step
from gelcone.physics.waveforms import Samples
from tests.export.instance import device
from tests.toys import PowerFilm


@pytest.fixture(scope="module")
def behind():
    """An amplifier adds states, and switches with borders."""
    return Exported(device(film="taut", series_resistance="1 MOhm", current_limit="2 mA"), "pump", False, 1e-9)


def test_the_unit_of_a_rate_is_that_of_its_state_over_a_second():
    late = gelcone.load_materials()["PVC-DBA 4:1"].replace(dielectric_share=0.3, dielectric_time=0.1)
    own = Exported(device(film="taut", series_resistance="1 MOhm", material=late), "pump", False, 1e-9).variables
    states = [variable.name for variable in own if variable.kind == "state"]
    units = {variable.name: variable.unit for variable in own}
    assert {units[name]: units[f"{name}_rate"] for name in states} == {
        "m": "m/s", "m/s": "m/s^2", "C": "A", "V": "V/s",
    }  # fmt: skip


def test_the_header_numbers_the_variables_and_says_what_they_are(behind):

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
    known = {own.name: own.value for own in gelcone.Outcome if own.name not in ("OUTSIDE", "ERROR", "IMPOSSIBLE")}
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
    assert ("PUMP_FILM_VOLTAGE)" in text) == ("film voltage (V)" in text) == inside
    assert "DEVICE" not in text
    hidden = SimpleNamespace(device=own.device, inside=inside, outputs={}, name="pump")
    assert ("PUMP_CURRENT" in example(hidden), "velocity (m/s)" in example(hidden)) == (False, True)


@pytest.mark.parametrize(("film", "kinds"), [("taut", [0]), ("wrinkling", [1])])
def test_a_film_that_wrinkles_has_kinds(film, kinds):

    source = sources(Exported(device(film=film), "pump", False, 1e-7))["pump.c"]
    found = re.search(r"HAS_KINDS\[\] = \{\s*([\d, ]+)\s*\}", source)[1]
    assert [int(part) for part in found.split(",")] == kinds


@pytest.mark.parametrize(
    ("own", "of_gel", "value"), [(2e7, None, 2e7), (2e7, 4e7, 2e7), (None, 4e7, 4e7), (None, None, 0.0)]
)
def test_the_strength_is_that_of_the_device_else_of_its_gel_else_unknown(own, of_gel, value):
    made = device(film="taut").replace({"dielectric_strength": own, "material.dielectric_strength": of_gel})
    assert Exported(made, "pump", False, 1e-7).parameters.values["dielectric_strength"] == value


def test_the_example_commands_the_drive_of_the_device():
    own = device(film="taut").replace(voltage_offset="0.7 kV", voltage_amplitude="0.4 kV", frequency="9 Hz")
    text = example(Exported(own, "pump", False, 1e-7))
    drives = re.findall(r"700\.0 \+ 400\.0 \* (\w+)\(turn \* 9\.0 \* ", text)
    assert drives
    assert set(drives) == {"sin"}


@pytest.mark.parametrize("name", ["biased-pump", "paper-table1"])
def test_what_does_not_follow_from_a_parameter_does_not_change_with_it(name):
    """A free field may change only those numbers that are computed anew from it."""
    own = gelcone.find_device(name).replace(film="taut")
    exported = Exported(own, "pump", False, 1e-7)
    before, nodes = exported.numbers(), exported.parameters.nodes
    assert (
        not {"prestretch", "meridional_prestretch", "hoop_prestretch", "disc_radius"}
        & exported.parameters.values.keys()
    )
    for field, value in exported.parameters.values.items():
        if field == "dielectric_strength" or not value:
            continue
        model = own.replace_quietly({field: 1.01 * value}).to_model()
        after = model.system.numbers_of({name: np.asarray(one, float) for name, one in model.values.items()})
        for number in set(exported.program.used) & before.keys() - nodes.keys():
            if number in after:
                assert float(np.ravel(after[number])[0]) == pytest.approx(before[number], rel=1e-12), (field, number)


# --- the tables of numbers --------------------------------------------------------------------------------------------

SECOND = {"film": "wrinkling", "second_film": "taut", "second_flat_height": 0.03, "second_drive": "opposite"}
CREEPING = {"film": "wrinkling", "hoop_prestretch": 1.1, "material.viscous_modulus_1": 1e4,
            "material.relaxation_time_1": 0.1}  # fmt: skip
DELAYED = {"film": "taut", "material.dielectric_share": 0.2, "material.dielectric_time": 0.01}


@pytest.fixture(scope="module")
def pair():
    return Exported(device().replace(SECOND), "pump", True, 1e-7)


def tables_of(exported):
    """The tables of a source by name, and its sizes and places."""
    text = sources(exported)["pump.c"]
    rows = re.findall(r"static const \w+ (\w+)\[\] = \{\s*([^}]*?)\s*\};", text)
    tables = {name: [float(own.strip(" ()")) for own in row.split(",")] for name, row in rows if "step_" not in row
              and "point_" not in row}  # fmt: skip
    return tables, dict(re.findall(r"^#define (\w+) (\S+)$", text, re.MULTILINE))


def test_bounds_are_those_of_the_fields(pair):
    tables, _ = tables_of(pair)
    fields = pair.device.swept_fields()
    for name, least, exclusive in zip(pair.parameters.values, tables["LEAST"], tables["EXCLUSIVE"], strict=True):
        bounds = fields[name].above, fields[name].least
        assert least == next((bound for bound in bounds if bound is not None), -1e20), name
        # a strength of 0 is one that is not known
        assert bool(exclusive) == (bounds[0] is not None and name != "dielectric_strength"), name
    assert {0.0, 1.0} == set(tables["EXCLUSIVE"])


def test_tables_of_films_are_those_of_each_film(pair):
    tables, sizes = tables_of(pair)
    first, second = pair.system.films
    numbers = pair.numbers()
    reach = [*first.film.reach(first.own(numbers)), *second.film.reach(second.own(numbers))]
    np.testing.assert_array_equal(tables["REACH"], reach)
    assert tables["FLAT_HEIGHT"] == [-1, list(pair.program.numbers).index("second_flat_height")]
    assert tables["HAS_KINDS"] == [1, 0]
    assert tables["SLACK"] == [0, 1, 1, 1, 0, 0, 0, 0]  # of a film that wrinkles all kinds but taut
    assert tables["START"] == pair.start()[0].tolist()
    assert float(sizes["SMALLEST_STEP"]) == float(smallest_step(pair.model.members())[0])
    assert (int(sizes["N_FILMS"]), int(sizes["N_KINDS"])) == (2, 4)
    places, scales = list(pair.program.outputs), pair.parameters.scales
    assert [list(scales)[int(place)] for place in tables["STATE_SCALE"]] == ["length", "velocity"]
    for row, (name, (place, quantity, _)) in enumerate(pair.outputs.items()):
        own = "charge_rate" if name == "current" else "second_charge_rate" if name == "second_current" else name
        assert places[int(tables["OUTPUT_PLACE"][row])] == places[place] == own
        assert list(scales)[int(tables["OUTPUT_SCALE"][row])] == quantity


@pytest.mark.parametrize("begin", [None, 0.4])
def test_a_drive_inside_begins_where_its_first_piece_does(begin):
    waveform = "trapezoid" if begin is None else {"component": "square", "rise": 0.0, "duty": begin}
    own = Exported(device(film="taut", waveform=waveform), "pump", True, 1e-7)
    tables, sizes = tables_of(own)
    begins = np.asarray(own.pieces.begins)
    assert float(sizes["FIRST"].strip("()")) == begins[0]
    np.testing.assert_allclose(np.array(tables["PIECE_OFFSETS"]) + begins[0], begins, rtol=1e-15)
    assert (int(sizes["N_PIECES"]), sizes["REPEATS"]) == (begins.size, "1")


@pytest.mark.parametrize("repeat", [False, True])
def test_a_recording_inside_begins_again_where_it_does_so_here(repeat):
    recording = Samples((0.0, 0.5, 1.0), (0.0, 1.0, 0.0), repeat=repeat)
    text = sources(Exported(device(film="taut", waveform=recording), "pump", True, 1e-7))["pump.c"]
    assert f"#define REPEATS {int(repeat)}\n" in text


def test_a_film_without_stresses_has_no_place_for_them():
    """Nor is it slack, broken down or near its limit by the numbers of another output."""
    changes = {"film": PowerFilm(), "meridional_prestretch": None, "hoop_prestretch": None}
    own = Exported(device(**changes), "pump", False, 1e-7)
    assert not {"meridional_stress", "hoop_stress", "true_field", "limit_share"} & set(own.program.outputs)
    assert tables_of(own)[0]["FILM_OUT"] == [-1.0] * 4


# --- variables --------------------------------------------------------------------------------------------------------

UNITS = {
    "displacement": "m", "velocity": "m/s", "film_voltage": "V", "charge": "C", "current": "A", "capacitance": "F",
    "meridional_stress": "Pa", "hoop_stress": "Pa", "true_field": "V/m", "limit_share": "1", "time": "s",
    "displacement_rate": "m/s", "velocity_rate": "m/s^2", "film_voltage_rate": "V/s", "charge_rate": "A",
    "external_force": "N", "external_force_rate": "N/s", "voltage": "V", "voltage_rate": "V/s",
}  # fmt: skip


@pytest.mark.parametrize(
    "changes", [{"film": "taut"}, SECOND, CREEPING, DELAYED, {"film": "taut", "circuit": "charge"}]
)
def test_every_variable_has_its_si_unit(changes):
    own = Exported(device().replace(changes), "pump", False, 1e-7)
    assert {"displacement", "true_field", "limit_share"} < {variable.name for variable in own.variables}
    for variable in own.variables:
        name = variable.name.removeprefix("second_")
        if variable.kind == "parameter":
            assert variable.unit == own.device.swept_fields()[variable.name].unit
        elif variable.kind == "code":
            assert variable.unit == ""
        elif name in UNITS:
            assert variable.unit == UNITS[name], name
        else:
            assert variable.kind in ("state", "rate")
    assert own.variables[4][3] == "height of the disc above the film's plane"


def test_the_outcome_says_each_way_in_which_a_step_ends(pair):
    (outcome,) = (variable for variable in pair.variables if variable.name == "outcome")
    text = sources(pair)["pump.h"].split("enum pump_outcome {")[1].split("};")[0]
    ends = [int(code) for code in re.findall(r"PUMP_\w+ = (\d+)", text)]
    assert outcome.meaning.split(": ")[1] == ", ".join(f"{code} {gelcone.Outcome(code).words}" for code in ends)


@pytest.mark.parametrize("changes", [{"film": "taut"}, {"film": "wrinkling"}, SECOND, DELAYED])
def test_outputs_at_a_point_are_those_of_the_model(changes):
    """Stresses and field by the film's state under its voltage; the charge is what the film holds, of which the
    part that follows the field with a delay is a state of its own."""
    own = Exported(device().replace(changes), "pump", False, 1e-7)
    z, switches = own.start()
    z = z * np.linspace(1.1, 1.3, z.size)
    n = own.numbers() | switches | {"input_voltage": 900.0 / own.scale_values["voltage"]}
    found = outputs_of(own.system, 0.0, [np.float64(value) for value in z], n, np)
    members = own.model.members()
    for k, film in enumerate(own.system.films):
        volts = float(found[f"{film.prefix}film_voltage"][0])
        state = members.film_states(z[None, None], [np.array([[volts]])] * len(own.system.films))[k]
        for name in ("meridional_stress", "hoop_stress", "true_field"):
            assert float(found[film.prefix + name][0]) == pytest.approx(float(getattr(state, name)[0, 0]), rel=1e-9)
        capacitance = float(found[f"{film.prefix}capacitance"][0])
        charge = float(found[f"{film.prefix}charge"][0])
        assert (charge == pytest.approx(volts * capacitance, rel=1e-12)) == (not own.system.circuit.delays)
        assert found[f"{film.prefix}charge"][1] == 0.0  # nothing leaks: its rate is the current
        command = n["input_voltage"]
        right = command if k == 0 else 2.0 * own.device.voltage_offset / own.scale_values["voltage"] - command
        assert volts == pytest.approx(right, rel=1e-12)


def test_the_example_commands_the_drive_of_the_device_with_its_offset():
    own = device(film="taut", voltage_offset=-300.0, voltage_amplitude=400.0, frequency=9.0)
    assert "-300.0 + 400.0 * sin(turn * 9.0 * (" in example(Exported(own, "pump", False, 1e-7))


@pytest.mark.parametrize(
    "text", ["a */ b", "a /* b", "a **// b", "a */* b", "*", "/", "a \\", "a ??/", "a \n b", "a \u2028 b"]
)
def test_no_text_ends_the_comment_in_which_it_stands(text):
    """Nor joins its line with the next."""
    found = in_comment(text)
    assert len(found.splitlines()) == 1
    assert not set("\\?") & set(found)
    assert "/*" not in found
    assert "*/" not in f"/* {found} */"[2:-2]
    for meant in ("Gel, 6:1 (PVC) - ä", "E_b sinh(E/E_b)", "2*pi"):
        assert in_comment(meant) == meant


def test_pieces_that_change_with_what_stays_free_are_refused(pair):
    """Those of a component of one's own whose corners follow the voltage or the frequency."""
    for name in ("voltage_bias", "voltage", "drive_frequency"):

        def table(numbers, name=name):
            return SimpleNamespace(begins=np.array([0.0, 0.5 * float(numbers[name])]), terms=np.zeros((2, 5)))

        own = Exported(pair.device, "pump", True, 1e-7)
        waveform = SimpleNamespace(pieces=SimpleNamespace(name="mine", table=table))
        vars(own)["system"] = SimpleNamespace(waveform=waveform)
        with pytest.raises(InputError, match="the pieces of the waveform mine change with voltage or frequency"):
            _ = own.pieces
