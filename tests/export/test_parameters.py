"""The parameters of an exported device are all its fields that change the motion but those its film is fitted to."""

import dataclasses

import numpy as np
import pytest

from gelcone.errors import InputError
from gelcone.export.parameters import FIXED
from gelcone.export.sources import CODES, INPUT_VARIABLES, Exported
from gelcone.physics.drive import Pieces
from gelcone.physics.waveforms import Triangle
from tests.export.instance import device
from tests.export.test_c import BITS, CREEPING

DEVICES = ["taut", "beam and sine", "creeping", "amplifier", "second film"]


def exported(name):
    changes, inside, _ = BITS[name]
    return Exported(device().replace(changes), "pump", inside, 1e-7)


@pytest.mark.parametrize("name", DEVICES)
def test_every_field_that_changes_the_motion_can_be_changed_later(name):
    """Unless the film's own numbers depend on it, or it is of a drive that stays outside, or of the start alone."""
    own = exported(name)
    before, scales = own.model.numbers(), own.device.scales
    law = {f"material.{one}" for one in own.device.material.law_parameters}
    drive = set() if own.inside else {"voltage_amplitude", "voltage_offset", "frequency"}
    start = {"release_height", "release_velocity"}
    for field in own.device.swept_fields():
        value = own.device.get(field)
        if field in {*FIXED, *law, *drive, *start, "dielectric_strength"} or value is None or not np.isfinite(value):
            assert field not in own.parameters.values or field in ("damping_coefficient", "dielectric_strength")
            continue
        if not value:
            continue
        other = own.device.replace_quietly({field: 1.01 * value})
        after = other.to_model().numbers()
        moved = any(not np.array_equal(before[one], after[one]) for one in before if one in own.program.used)
        moved |= any(
            getattr(scales, one) != getattr(other.scales, one) for one in ("length", "time", "voltage", "force")
        )
        assert (field in own.parameters.values) == moved, field


CHANGED = {
    **{name: BITS[name][:2] for name in DEVICES},
    "payload": ({"film": "taut", "payload": "1 g"}, False),
    "damped otherwise": ({"film": "taut", "payload": "1 g", "damping_coefficient": None, "quality_factor": 9.0}, False),
    "two that creep": ({**CREEPING, "second_film": "taut", "second_flat_height": 0.03}, True),
    "constant voltage on the second": (
        {"film": "wrinkling", "second_film": "taut", "second_drive": "constant", "second_voltage": 300.0}, True,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CHANGED)
def test_numbers_and_units_follow_changed_parameters_as_those_of_the_changed_device(name):
    """All parameters are changed at once, each by a share of its own."""
    changes, inside = CHANGED[name]
    own = Exported(device().replace(changes), "pump", inside, 1e-7)
    values = {n: v * (1.0 + 0.01 * k) for k, (n, v) in enumerate(own.parameters.values.items(), start=1)}
    names = {n: None for n in ("damping_ratio", "quality_factor") if own.device.get(n) is not None}
    other = own.device.replace_quietly(names | {n: v for n, v in values.items() if v})
    vars(own)["parameters"] = dataclasses.replace(own.parameters, values=values)
    right, found = other.to_model().numbers(), own.numbers()
    assert {"damping_ratio", "spring_stiffness"} <= set(own.parameters.nodes)
    for number in set(own.program.used) & right.keys():
        assert found[number] == pytest.approx(float(np.ravel(right[number])[0]), rel=1e-12), number
    for quantity, value in own.scale_values.items():
        if quantity != "1":
            assert value == pytest.approx(float(other.scales.size(quantity)), rel=1e-12), quantity


@pytest.mark.parametrize("name", DEVICES)
def test_the_film_s_geometry_and_pre_stretches_stay_as_they_are(name):
    """The numbers of its force, which leave as they are, hang on them."""
    shape = {"disc_radius", "film_radius", "prestretch", "meridional_prestretch", "hoop_prestretch"}
    shape |= {f"second_{one}" for one in shape}
    assert not shape & set(exported(name).parameters.values)


def test_the_strength_is_the_device_s_own_before_its_gel_s():
    gel = device().material
    assert gel.dielectric_strength is None or gel.dielectric_strength != 12e6
    weak = gel.replace(dielectric_strength="7 MV/m")
    for own, of_device in ((gel.replace(dielectric_strength=None), None), (weak, None), (weak, "12 MV/m")):
        changed = device(film="taut", material=own, dielectric_strength=of_device)
        strength = Exported(changed, "pump", False, 1e-7).parameters.values["dielectric_strength"]
        assert strength == (12e6 if of_device else own.dielectric_strength or 0.0)


@pytest.mark.parametrize("given", [{"damping_ratio": 0.03}, {"quality_factor": 20.0}])
def test_a_damping_that_is_given_otherwise_leaves_as_its_coefficient(given):
    """c = 2 m zeta/T with all that is moved, of which the formulas give zeta back."""
    own = Exported(device(film="taut", payload="1 g", damping_coefficient=None, **given), "pump", False, 1e-7)
    damping, zeta = own.parameters.values["damping_coefficient"], float(own.model.damping_ratio)
    carried = own.device.moving_mass + 1e-3
    assert damping == pytest.approx(2.0 * carried * zeta / float(own.device.scales.time), rel=1e-12)
    assert own.numbers()["damping_ratio"] == pytest.approx(zeta, rel=1e-12)


@pytest.mark.parametrize("name", DEVICES)
def test_units_are_those_of_the_device(name):
    own = exported(name)
    scales = own.device.scales
    assert own.scale_values.pop("1") == 1.0
    assert {"length", "time", "velocity", "force", "voltage", "current", "field", "stress", "charge"} <= set(
        own.scale_values
    )
    for quantity, value in own.scale_values.items():
        assert value == pytest.approx(float(scales.size(quantity)), rel=1e-14), quantity
    for one in own.variables:
        if one.kind == "parameter":
            field = own.device.swept_fields()[one.name]
            assert (one.unit, one.meaning) == (field.unit, field.meaning)


def test_inputs_and_codes_are_in_their_order_with_their_units():
    own = exported("second film")
    kinds = [one.kind for one in own.variables]
    order = ["input", "state", "rate", "output", "code", "time", "parameter"]
    assert [kind for k, kind in enumerate(kinds) if kind not in kinds[:k]] == order
    assert kinds == sorted(kinds, key=order.index)
    assert [(one.name, one.unit) for one in INPUT_VARIABLES] == [
        ("voltage", "V"), ("voltage_rate", "V/s"), ("external_force", "N"), ("external_force_rate", "N/s"),
    ]  # fmt: skip
    codes = [one.name for one in own.variables if one.kind == "code"]
    assert codes == ["film_state", "second_film_state", *(name for name, _ in CODES)]
    said = dict(CODES)["outcome"]
    assert said == ("how the motion ended: 0 ok, 2 stretch limit, 3 step limit, 4 not finite, 6 pulled in")
    outputs = {one.name: one.unit for one in own.variables if one.kind == "output"}
    units = {"film_voltage": "V", "charge": "C", "current": "A", "capacitance": "F", "meridional_stress": "Pa",
             "hoop_stress": "Pa", "true_field": "V/m", "limit_share": "1"}  # fmt: skip
    assert outputs == units | {f"second_{name}": unit for name, unit in units.items()}
    meanings = {one.name: one.meaning for one in own.variables if one.kind == "output"}
    for name, meaning in meanings.items():
        assert ("second film" in meaning) == name.startswith("second_"), name


def test_a_component_whose_numbers_are_not_formulas_is_refused_by_its_name():
    from gelcone import Bias, Quantity

    class Rounded(Bias):
        """A bias whose number is not a formula."""

        name = "rounded"
        parameters = {"rounded_rate": Quantity("k", "rate", 0.5, scale="stiffness")}

        def force(self, x, y, n, xp=np):
            return n["rounded_rate"] * x, n["rounded_rate"] + 0.0 * x

        def numbers(self, parameters):
            return super().numbers(parameters) | {"rounded_rate": np.rint(parameters["rounded_rate"])}

    with pytest.raises(InputError) as error:
        _ = Exported(device(film="taut", bias=Rounded()), "pump", False, 1e-7).parameters
    assert "rounded" in str(error.value)


@pytest.mark.parametrize(("waveform", "count"), [("sine", None), ("triangle", 2), ("trapezoid", 4), ("staircase", 8)])
def test_a_drive_goes_inside_whose_pieces_do_not_change_with_it(waveform, count):
    pieces = Exported(device(film="taut", waveform=waveform), "pump", True, 1e-7).pieces
    assert (None if pieces is None else len(pieces.begins)) == count


class Clipped(Triangle):
    """A triangle whose corners depend on the offset over the amplitude."""

    name = "clipped"

    def table(self, n):
        pieces = super().table(n)
        shift = 0.1 * np.asarray(n["voltage_bias"]) / n["voltage"]
        return Pieces(pieces.begins + shift[..., None], pieces.terms)


@pytest.mark.parametrize("offset", [0.0, 300.0])
@pytest.mark.parametrize(("waveform", "name"), [("chirp", "chirp"), (Clipped(), "clipped")])
def test_a_drive_stays_outside_whose_pieces_change_with_it(waveform, name, offset):
    """With its frequency, or with one of two voltages where both together leave them as they are."""
    with pytest.raises(InputError) as error:
        _ = Exported(device(film="taut", waveform=waveform, voltage_offset=offset), "pump", True, 1e-7).pieces
    assert str(error.value) == (
        f"drive: the pieces of the waveform {name} change with voltage or frequency, which stay free; leave it out "
        "and give the voltage as an input"
    )
