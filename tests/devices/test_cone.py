"""The model of a device: its loads, its damping, its start, and what follows from several fields."""

import numpy as np
import pytest

from gelcone import disk_cache
from gelcone.devices.cone import (
    _model,
    breakdown_field,
    cone_of_device,
    following,
    initial_state,
    model_of_device,
    undamped_cone,
)
from gelcone.devices.device import find_device
from gelcone.physics.film.taut import TautCone
from tests.toys import CubicBias

PUMP = find_device("biased-pump").replace(film="taut")


class Whole(TautCone):
    """A film of one's own."""

    name = "whole"


WHOLE = Whole()


@pytest.mark.parametrize(("name", "value"), [("quality_factor", 8.0), ("damping_ratio", 0.0625)])
def test_a_free_vibration_about_the_rest_without_voltage_decays_as_it_is_given(name, value):
    """c/(2 sqrt(k m)) with the stiffness about the rest: half of one over the quality factor."""
    model = model_of_device(PUMP.replace({name: value}))
    rest, off = initial_state(PUMP)[0], model.replace(voltage=0.0, voltage_bias=0.0)
    pulls = [float(off.system.rates(0.0, [rest + h, 0.0], off.own_numbers)[1]) for h in (1e-5, -1e-5)]
    stiffness = (pulls[1] - pulls[0]) / 2e-5
    assert model.damping_ratio == pytest.approx(0.0625 * np.sqrt(stiffness), rel=1e-7)
    assert undamped_cone(PUMP.replace({name: value})).damping_ratio == 0.0


@pytest.mark.parametrize("payload", [None, "7 g"])
def test_a_damping_coefficient_slows_down_all_of_the_mass(payload):
    """By c u over moving mass and payload, m/s^2: the difference between a disc that moves and one at rest."""
    device = PUMP.replace(payload=payload, damping_coefficient="30 mN s/m")
    model, s = model_of_device(device), device.scales
    still, moving = (float(model.system.rates(0.0, [0.3, u], model.own_numbers)[1]) for u in (0.0, 0.4 / s.velocity))
    mass = device.moving_mass + (0.0 if payload is None else 7e-3)
    assert (moving - still) * s.velocity / s.time == pytest.approx(-0.03 * 0.4 / mass, rel=1e-10)


def test_loads_are_the_fields_that_are_given_and_own_biases_act_besides():
    assert model_of_device(PUMP).system.bias.name == "spring"
    loaded = PUMP.replace(beam_rate=20.0, gravity=9.81, constant_force="5 mN")
    bias = model_of_device(loaded).system.bias
    assert [part.name for part in bias.parts] == ["spring", "beam", "weight", "force"]
    assert (model_of_device(loaded).beam_cubic, model_of_device(loaded).beam_height) == (0.0, 0.0)
    own = model_of_device(PUMP.replace(constant_force="5 mN", bias=CubicBias())).system.bias
    assert [part.name for part in own.parts] == ["spring", "force", "cubic"]


def test_weight_and_filter_follow_from_several_fields():
    device = PUMP.replace(payload="3 g", gravity=9.81, filter_frequency="500 Hz")
    found = following(device, device.get, device.scales)
    assert found["weight"] * device.scales.force == pytest.approx((device.moving_mass + 3e-3) * 9.81)
    assert found["filter_time"] * device.scales.time == pytest.approx(1.0 / (2.0 * np.pi * 500.0))
    assert following(PUMP, PUMP.get, PUMP.scales) == {}


def test_a_release_is_the_start_and_a_rest_where_there_is_none():
    released = PUMP.replace(release_height="6 mm", release_velocity="-0.2 m/s")
    x, u = initial_state(released)
    assert x * released.scales.length == pytest.approx(6e-3)
    assert u * released.scales.velocity == pytest.approx(-0.2)
    at_rest, still = initial_state(PUMP)
    assert still == 0.0
    model = model_of_device(PUMP).replace(voltage=0.0, voltage_bias=0.0)
    rates = model.system.rates(0.0, [at_rest, 0.0], model.own_numbers)
    assert float(rates[1]) == pytest.approx(0.0, abs=1e-12)
    several = initial_state(PUMP.replace(film_thickness=[1.8e-4, 2.2e-4]))
    assert several.shape == (2, 2)
    assert several[0, 0] != several[1, 0]


def test_the_strength_is_the_devices_or_else_its_gels():
    gel = PUMP.replace({"material.dielectric_strength": "10 V/um"}, dielectric_strength=None)
    assert breakdown_field(gel) * gel.scales.field == pytest.approx(10e6)
    both = PUMP.replace({"material.dielectric_strength": "10 V/um"}, dielectric_strength="30 V/um")
    assert breakdown_field(both) * both.scales.field == pytest.approx(30e6)
    assert breakdown_field(PUMP.replace(dielectric_strength=None)) is None


def test_the_quick_cone_has_the_numbers_of_the_model_and_a_taut_film():
    device = PUMP.replace(film="wrinkling", second_film="taut", second_flat_height="20 mm")
    quick, model = cone_of_device(device), model_of_device(device)
    assert (quick.film.name, model.film.name) == ("taut", "wrinkling")
    shared = set(quick.values) & set(model.values) - {"damping_ratio"}
    assert {"voltage", "second_flat_height", "radius_ratio"} <= shared
    for name in shared:
        np.testing.assert_array_equal(quick.values[name], model.values[name])


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_a_gel_that_creeps_has_crept_where_its_device_waits(film):
    branch = {"material.viscous_modulus_1": "2 kPa", "material.relaxation_time_1": "0.3 s", "material.flow": "linear"}
    own = model_of_device(PUMP.replace({"film": film, **branch})).film
    assert (own.branches, own.flow, own.rested) == (1, "linear", "raised")
    assert model_of_device(PUMP.replace(film=film)).film.branches == 0


def test_a_film_with_branches_of_its_own_has_crept_too():
    own = model_of_device(PUMP.replace(film=TautCone(branches=1, flow="linear"))).film
    assert (own.branches, own.flow, own.rested) == (1, "linear", "raised")


@pytest.mark.parametrize(
    ("film", "own", "cone"),
    [("taut", "taut", "taut"), ("wrinkling", "wrinkling", "taut"), (WHOLE, "whole", "whole")],
)
def test_a_film_of_ones_own_has_no_cone_in_its_place(film, own, cone):
    """Of those that ship the taut one stands for each where statics of a cone are asked for."""
    device = PUMP.replace(film=film, second_film="wrinkling")
    for model, names in ((_model(device), [own, "wrinkling"]), (_model(device, cone=True), [cone, "taut"])):
        assert [placed.film.name for placed in model.system.films] == names


def test_the_check_of_a_device_makes_no_membrane():
    pump = PUMP.replace(film="membrane", prestretch=1.2345)  # a film that nothing else asks for
    with disk_cache.unmade_refused():
        pump.replace(second_film="membrane", second_flat_height="20 mm")


def test_a_member_without_a_rest_starts_flat():
    states = initial_state(PUMP.replace(prestretch=[1.1, 9.0]))
    assert states[0, 0] > 0.1
    assert states[1].tolist() == [0.0, 0.0]


def test_the_quick_cone_neither_pulls_in_nor_leaves_states_out():
    """What its device says of both is of the film that ships."""
    device = PUMP.replace(film="wrinkling", pull_in="minimum")
    assert model_of_device(device).film.pull_in == "minimum"
    assert cone_of_device(device).film == TautCone()
    fast = {
        "material.viscous_modulus_1": "2 kPa",
        "material.relaxation_time_1": "10 us",
        "reduced": "relaxation_time_1",
    }
    assert model_of_device(PUMP.replace(fast)).film.reduced == (1,)
    assert cone_of_device(PUMP.replace(fast)).film.reduced == ()
    model = model_of_device(PUMP.replace(circuit="charge", waveform="triangle"))
    assert (model.system.circuit.name, model.system.waveform.name) == ("charge", "triangle")
    assert model_of_device(PUMP).values["radius_ratio"] == pytest.approx(8.0 / 30.0)
    assert model_of_device(PUMP).dielectric_strength == pytest.approx(float(breakdown_field(PUMP)))
