"""What varies along branches: fields of a device become the model's parameters, or the device makes the model."""

import numpy as np
import pytest

import gelcone
from gelcone import InputError
from gelcone.atlas.branches import varied as varied_module
from gelcone.atlas.branches.varied import vary
from gelcone.presets import find_preset

PUMP = gelcone.find_device("biased-pump").replace(film="taut")


def test_brute_force_does_not_begin_at_rest_in_the_flat_film():
    """From there no voltage moves the disc, and nothing would be checked."""
    flat = gelcone.find_device("paper-table1").replace(release_height=None, release_velocity=None)
    varied = vary(flat, {"voltage_amplitude": (100.0, 200.0)})
    assert flat.initial_state()[0] == 0.0
    assert varied.starts([0.5])[0, 0] > 0.1
    assert vary(PUMP, {"frequency": (9.0, 11.0)}).starts([0.5])[0, 0] == PUMP.initial_state()[0]
    still = vary(find_preset("base").model, {"voltage": (0.9, 1.1)}, (0.0, 0.0))
    np.testing.assert_array_equal(still.starts([1.0]), [[1.0, 0.0]])


@pytest.mark.parametrize("start", [(0.0, 0.2), (-0.4, 0.0), (0.3, -0.1)])
def test_brute_force_begins_where_it_is_told_to_unless_nothing_would_move(start):
    own = vary(find_preset("base").model, {"voltage": (0.9, 1.1)}, start)
    np.testing.assert_array_equal(own.starts([1.0]), [start])
    table1 = gelcone.find_device("paper-table1")
    scales, given = table1.scales, (start[0] * 0.01, start[1] * 0.01)
    found = vary(table1, {"voltage_amplitude": (100.0, 200.0)}, given).starts([0.5])
    np.testing.assert_allclose(found, [[given[0] / scales.length, given[1] / scales.velocity]], rtol=1e-12)


def test_a_field_that_moves_one_parameter_is_followed_as_that():
    varied = vary(PUMP, {"frequency": (9.0, 11.0)})
    assert varied.parameters == ("drive_frequency",)
    model = PUMP.replace(frequency=9.0).to_model()
    assert varied.ends[0][0] == pytest.approx(model.drive_frequency, rel=1e-14)


def test_a_gel_without_a_limit_does_not_disturb_which_parameters_move():
    """A warning would be an error here."""
    unlimited = PUMP.replace({"material.viscous_modulus_1": "4 kPa", "material.relaxation_time_1": "2 s"})
    assert np.isinf(unlimited.to_model().viscous_limit_1)
    assert vary(unlimited, {"frequency": (9.0, 11.0)}).parameters == ("drive_frequency",)


def test_other_fields_are_asked_of_the_device():
    varied = vary(PUMP, {"film_thickness": (1.5e-4, 2.5e-4)})
    assert varied.parameters == ()
    made = varied.settings([0.8])
    model = PUMP.replace(film_thickness=2e-4).to_model()
    assert made["voltage"] == pytest.approx(float(model.voltage), rel=1e-14)
    assert made["damping_ratio"] == pytest.approx(float(model.damping_ratio), rel=1e-14)


def test_two_fields_that_share_a_scale_are_asked_of_the_device():
    assert vary(PUMP, {"film_thickness": (1.5e-4, 2.5e-4), "frequency": (9.0, 11.0)}).parameters == ()
    together = vary(PUMP, {"voltage_amplitude": (100.0, 800.0), "frequency": (9.0, 11.0)})
    assert together.parameters == ("voltage", "drive_frequency")


@pytest.mark.parametrize(
    ("name", "quantity"),
    [
        ("voltage", "voltage"), ("rest_height", "length"), ("drive_frequency", "frequency"),
        ("spring_stiffness", "stiffness"), ("damping_ratio", "parameter value"),
    ],
)  # fmt: skip
def test_values_of_a_parameter_have_its_quantity_and_meaning(name, quantity):
    model = gelcone.ConeModel(rest_height=0.3)
    attributes = vary(model, {name: (0.2, 0.4)}, (1.0, 0.0)).attributes()
    assert attributes == {"quantity": quantity, "units": "1", "long_name": model.system.parameters[name].meaning}


@pytest.fixture(scope="module")
def thickness():
    return gelcone.continue_branch(PUMP, "film_thickness", "0.19 mm", "0.2 mm", start="settled", checks=2)


def test_a_branch_over_a_field_is_that_of_each_device(thickness):
    own = thickness.isel(branch=0)
    assert own["value"].attrs["units"] == "mm"
    assert [float(own["value"].min()), float(own["value"].max())] == pytest.approx([0.19, 0.2])
    k = own.sizes["point"] // 2
    device = PUMP.replace(film_thickness=f"{float(own['value'][k])} mm")
    settled = gelcone.settled(device)
    for name in ("lowest", "highest"):
        assert own[name].attrs["units"] == settled[name].attrs["units"] == "mm"
        assert float(own[name][k]) == pytest.approx(float(settled[name]), abs=1e-5)


def test_a_device_and_its_model_have_the_same_branches():
    """Dimensional twins: each variable is the model's times the scale of its quantity."""
    device = gelcone.find_device("paper-table1")
    model = device.to_model()
    scales = {"V": 9460.0 / float(model.voltage), "mm": 40.0, "1": 1.0}
    own = gelcone.continue_branch(model, "voltage", 0.6, 1.6, switch=1, checks=2)
    found = gelcone.continue_branch(
        device, "voltage_amplitude", *(scales["V"] * np.array([0.6, 1.6])), switch=1, checks=2
    )
    checked = set()
    for name, variable in found.data_vars.items():
        unit = variable.attrs.get("units")
        if variable.dtype.kind == "f" and unit in scales:
            expected = scales[unit] * own[name].values
            np.testing.assert_allclose(variable.values, expected, rtol=1e-6, atol=1e-9, err_msg=str(name))
            checked.add(str(name))
    assert {"value", "event_value", "event_error", "event_curvature", "lowest", "highest", "run_value"} <= checked
    assert (np.isfinite(own["event_curvature"]) & (own["event_curvature"] != 0.0)).any()


def test_a_result_of_a_device_can_be_gone_on_from(thickness):
    result = gelcone.continue_branch(PUMP, "film_thickness", 1.9e-4, 2e-4, start=thickness)
    assert int(result["checked_cycles"]) == thickness.sizes["branch"]
    ends = [np.sort(one["highest"].values[0][[0, -1]]) for one in (result, thickness)]
    np.testing.assert_allclose(*ends, rtol=1e-9)


def test_branches_beside_a_diagram_of_a_device_have_its_units():
    diagram = gelcone.bifurcation(PUMP, "film_thickness", [1.9e-4, 2e-4], sweeps=(), bisections=0, branches=True)
    assert diagram["followed_value"].attrs["units"] == diagram["film_thickness"].attrs["units"] == "mm"
    assert diagram["followed_orbit"].attrs["units"] == diagram["section"].attrs["units"]
    section, orbit = diagram["section"].isel(branch=0)[0, -1, 0], diagram["followed_orbit"][0, 0, 0, 0]
    assert float(orbit) == pytest.approx(float(section), abs=1e-5)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("film_thicknes", 1e-4, 2e-4), "did you mean 'film_thickness'"),
        (("film_thickness", 2e-4, 1e-4), "film_thickness from 200 um to 100 um: .*; swap the ends"),
        (("frequency", 10.0, 5.0), "frequency from 10 Hz to 5 Hz: must be an interval"),
        (("displacement", 0.0, 1.0), "initial state"),
        (("film_thickness", -1e-4, 1e-4), "film_thickness"),
    ],
)
def test_bad_fields_are_refused(arguments, message):
    with pytest.raises(InputError, match=message):
        gelcone.continue_branch(PUMP, *arguments)


def test_a_locus_over_fields():
    device = gelcone.find_device("biased-pump").replace(film="taut", damping_coefficient=None, quality_factor=40.0)
    with pytest.raises(InputError, match="none lies on voltage_amplitude from 10 V to 20 V"):
        gelcone.locus(device, "fold", {"voltage_amplitude": (10.0, 20.0), "frequency": (9.0, 11.0)}, checks=2)


def test_a_model_varies_in_its_own_parameters():
    varied = vary(find_preset("base").model, {"voltage": (0.9, 1.1)})
    assert varied.settings is None
    assert varied.scales == [1.0]


@pytest.mark.parametrize("device", [False, True])
def test_segments_are_enough_for_the_stiffest_and_the_slowest_corner(monkeypatch, device):
    """Where these are two: over a repeat of the lowest frequency with the fastest rate of any corner."""
    made, asked = [], []
    monkeypatch.setattr(varied_module, "Shooting", lambda *given: made.append(given))
    monkeypatch.setattr(varied_module, "segments_for", lambda *given: asked.append(given) or 64)
    if device:
        own = vary(PUMP, {"frequency": (2.0, 11.0), "spring_rate": (5.0, 40.0)})
        models = [PUMP.replace(frequency=f, spring_rate=k).to_model() for f in (2.0, 11.0) for k in (5.0, 40.0)]
    else:
        own = vary(gelcone.ConeModel(), {"drive_frequency": (0.05, 1.0), "spring_stiffness": (0.1, 9.0)}, (1.0, 0.0))
        models = [gelcone.ConeModel(drive_frequency=w, spring_stiffness=k) for w in (0.05, 1.0) for k in (0.1, 9.0)]
    own.shooting(1e-9)
    ((rate, time),) = asked
    fastest = [float(model.members().fastest[0]) for model in models]
    assert max(fastest) > 1.2 * min(fastest)
    assert rate == pytest.approx(max(fastest), rel=1e-9)
    longest = max(float(model.members().forcing_period[0]) for model in models)
    assert time == pytest.approx(longest, rel=1e-9)
    _, names, kind, segments, _, tolerance, *_ = made[0]
    assert (names, kind, segments, tolerance) == (own.parameters or own.names, (1, False), 64, 1e-9)


def test_values_are_said_in_the_unit_of_their_own_field_and_measured_by_its_larger_end():
    """Of two fields that move several parameters, of which the first is negative."""
    ends = {"voltage_offset": (-300.0, 100.0), "film_thickness": (1e-4, 2e-4)}
    own = vary(PUMP, ends)
    assert own.parameters == ()
    np.testing.assert_allclose(own.scales, [300.0, 2e-4])
    assert (own.said(0.5, 0), own.said(0.5, 1)) == ("150 V", "100 um")
    assert own.along("first", "second") == {"along": "voltage_offset=first,film_thickness=second"}
    assert own.attributes(1)["units"] == "m"
    assert vary(gelcone.ConeModel(), {"voltage": (0.1, 0.2)}).along("value") == {}


def test_an_interval_is_cut_before_values_that_make_no_actuator_and_the_reason_is_stated():
    """Found by halves, also where both ends make none, and for each of two parameters."""
    model = gelcone.ConeModel(dielectric_share=0.3, dielectric_time=2.0, rest_height=0.3, drive_frequency=0.5)
    reason = "dielectric_share = 1: must be below 1; lower it"
    cut = vary(model, {"dielectric_share": (0.5, 1.5)})
    assert cut.low.item() == 0.5
    assert cut.high.item() == pytest.approx(1.0, abs=1.0 / 2**10)
    assert cut.high.item() < 1.0
    assert cut.refused == (("1", reason),)
    disc = vary(PUMP, {"disc_radius": ("5 mm", "35 mm")})
    assert disc.high.item() == pytest.approx(30e-3, abs=30e-6)
    ((at, why),) = disc.refused
    assert why.startswith(f"disc_radius = {at}: must be less than film_radius = 30 mm")
    assert vary(model, {"dielectric_share": (0.5, 0.9)}).refused == ()
    with pytest.raises(InputError, match=r"dielectric_share = 1\.2: must be below 1"):
        vary(model, {"dielectric_share": (1.2, 1.4)})
    two = vary(model, {"voltage": (0.1, 0.2), "dielectric_share": (0.5, 1.5)})
    assert two.high.tolist() == [0.2, cut.high.item()]
    assert two.refused == cut.refused
    assert two.shooting().free == ("voltage", "dielectric_share")


def test_corners_of_which_no_actuator_can_be_made_are_left_out():
    """A disc of up to 28 mm fits the own film of 30 mm, and not each film from 24 mm on."""
    own = vary(PUMP, {"disc_radius": ("10 mm", "28 mm"), "film_radius": ("24 mm", "40 mm")})
    assert own.refused == ()
    (discs, films), models = own.corners
    assert discs.size == models.size == 8
    assert (discs < films).all()
    assert own.shooting().segments > 0


def test_branches_up_to_values_that_make_no_actuator_are_returned(monkeypatch):
    late = {"dielectric_share": 0.3, "dielectric_time": 2.0}
    model = gelcone.ConeModel(damping_ratio=0.1, rest_height=0.3, drive_frequency=0.5, voltage=0.9, **late)
    monkeypatch.setattr(varied_module, "HALVINGS", 3)
    found = gelcone.continue_branch(model, "dielectric_share", 0.8, 1.2, start="settled", checks=2, switch=0)
    assert found["value"].max().item() == pytest.approx(0.95)
    assert found.attrs["impossible"] == "at 1: dielectric_share = 1: must be below 1; lower it"
    assert f"no actuator can be made {found.attrs['impossible']}" in gelcone.in_words(found)
