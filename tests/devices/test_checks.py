"""What is wrong or hardly meant in the fields of a device together."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.devices import checks
from gelcone.devices.checks import THICK, doubts
from gelcone.devices.device import Device, find_device
from gelcone.devices.units import FieldError
from gelcone.errors import InputError

PUMP = find_device("biased-pump").replace(film="taut")
WIDTH = PUMP.film_radius - PUMP.disc_radius


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_a_film_thicker_than_half_the_width_of_its_ring_is_doubted(share):
    device = PUMP.replace_quietly(film_thickness=share * THICK * WIDTH)
    about = [text for text in doubts(device) if "on a ring" in text or "usual range" in text]
    assert bool(about) == (share > 1.0 or share * THICK * WIDTH > 0.02)
    assert all(text.startswith("film_thickness") for text in about)


def test_the_thickest_of_several_films_is_named_with_its_own_ring():
    device = PUMP.replace_quietly(film_thickness=[1e-4, 0.013], disc_radius=[8e-3, 9e-3])
    (told,) = [text for text in doubts(device) if text.startswith("film_thickness")]
    assert "13 mm is too thick for the membrane model on a ring 21 mm wide" in told


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"frequency": [8.0, 9.0], "film_thickness": [1e-4, 2e-4, 3e-4]}, "give lists of one length"),
        ({"second_flat_height": 0.02}, "there is no second_film; give second_film"),
        ({"second_film": "taut", "second_voltage": 100.0}, 'is taken where second_drive is "constant" alone'),
        ({"second_film": "taut", "second_drive": "same", "second_voltage": 100.0}, "second_voltage"),
        ({"payload": 1e-3, "beam_height": 1e-3}, "beam_height: there is no beam_rate"),
        ({"damping_coefficient": None, "quality_factor": None}, "damping_coefficient: is missing"),
        ({"prestretch": 9.0}, "mounted flat, the film has I1 - 3"),
        ({"release_height": 1.0}, "release_height = 1 m: must be less than"),
        ({"circuit": "charge", "series_resistance": 1e6}, "the circuit 'charge' does not take it"),
    ],
)
def test_fields_that_do_not_fit_are_refused(changes, message):
    with pytest.raises(InputError, match=message):
        PUMP.replace(changes)


def test_a_release_within_the_limit_is_taken_and_the_border_is_named():
    with pytest.raises(InputError) as refused:
        PUMP.replace(release_height=1.0)
    highest = float(str(refused.value).split("must be less than ")[1].split(" mm")[0]) * 1e-3
    assert PUMP.replace(release_height=0.999 * highest).release_height == pytest.approx(0.999 * highest)
    with pytest.raises(InputError, match="release_height"):
        PUMP.replace(release_height=1.001 * highest)


def test_a_constant_second_film_takes_a_voltage_and_usual_devices_raise_no_doubts():
    pair = PUMP.replace(second_film="taut", second_drive="constant", second_voltage=100.0, second_flat_height=0.02)
    assert pair.second_voltage == 100.0
    assert doubts(PUMP) == []
    odd = PUMP.replace_quietly(moving_mass=50.0)
    assert [text.split(" = ")[0] for text in doubts(odd)] == ["moving_mass"]


class Overflowing:
    """A device whose sizes give no scales."""

    def __init__(self, error):
        self.error = error

    @property
    def scales(self):
        raise self.error


def test_scales_are_usable_where_they_are_finite_and_positive_in_all_members():
    usable = gelcone.find_device("biased-pump")
    assert checks._usable_scales(usable)
    for error in (OverflowError(), ZeroDivisionError()):
        assert not checks._usable_scales(Overflowing(error))
    for bad in (0.0, -1.0, np.inf, np.nan):
        scales = replace(usable.scales, force=np.array([1.0, bad]))
        assert not checks._usable_scales(SimpleNamespace(scales=scales))


def test_of_several_discs_too_large_the_worst_is_named_with_its_own_film():
    with pytest.raises(InputError) as refused:
        PUMP.replace(disc_radius=[8e-3, 37e-3, 45e-3], film_radius=[20e-3, 30e-3, 40e-3])
    told = "disc_radius = 37 mm: must be less than film_radius = 30 mm; make the disc smaller or the film larger"
    assert str(refused.value) == told
    with pytest.raises(InputError, match="disc_radius = 30 mm: must be less than film_radius = 30 mm"):
        PUMP.replace(disc_radius=30e-3)
    with pytest.raises(InputError, match="disc_radius = 30 mm: must be less than film_radius = 30 mm"):
        PUMP.replace(disc_radius=30e-3, film_radius=30e-3 * (1.0 + 1e-15))


@pytest.mark.parametrize(
    ("name", "most", "told"),
    [
        ("moving_mass", 5.0, "moving_mass = 5.05 kg is outside the usual range, 0.1 to 500 g; check its unit"),
        ("gravity", 20.0, "gravity = 20.2 m/s^2 is outside the usual range, 0.5 to 20 m/s^2; check its unit"),
        ("series_resistance", 1e8, "series_resistance = 101 Mohm is outside the usual range, 0.001 to 100 Mohm"),
        ("initial_height", 1.0, "initial_height = 1.01 m is outside the usual range, 1 to 100 mm"),
        ("film_thickness", 20e-3, "film_thickness = 20.2 mm is outside the usual range, 0.02 to 2 mm"),
        ("material.shear_modulus", 1e7, "material.shear_modulus = 10.1 MPa is outside the usual range, 0.001 to 1 MPa"),
    ],
)
def test_values_far_beyond_the_usual_are_doubted_from_ten_times_on_and_gravity_and_resistance_at_once(name, most, told):
    """Drives may be as small as one likes; a film that is doubted for its thickness is not doubted for its ring."""
    assert [text for text in doubts(PUMP.replace_quietly({name: 0.99 * most})) if "usual range" in text] == []
    (text,) = doubts(PUMP.replace_quietly({name: 1.01 * most}))
    assert text.startswith(told)
    assert doubts(PUMP.replace_quietly(voltage_amplitude=1e-9, frequency=1e-9, spring_rate=1e9)) == []


def test_of_several_devices_some_may_be_beyond_the_limit():
    """Only where none has a state is the field refused; heights are over the width of each device's own ring."""
    PUMP.replace(prestretch=[1.1, 9.0])
    with pytest.raises(InputError, match="mounted flat"):
        PUMP.replace(prestretch=[9.0, 9.1])
    small, large = {"disc_radius": 8e-3, "film_radius": 12e-3}, {"disc_radius": 8e-3, "film_radius": 60e-3}
    with pytest.raises(InputError, match="release_height"):
        PUMP.replace(small | {"release_height": 0.06})
    several = {name: [small[name], 0.9 * small[name]] for name in small}
    alone = PUMP.replace_quietly(small)
    highest = alone.to_model().film.reach(alone.to_model().members().numbers_at(0))[1] * alone.scales.length
    with pytest.raises(InputError, match=f"release_height = 60 mm: must be less than {1e3 * highest:.4g} mm"):
        PUMP.replace(several | {"release_height": [0.06, 0.07]})
    both = {name: [small[name], large[name]] for name in small}
    assert PUMP.replace(both | {"release_height": 0.06}).shape == (2,)


def test_an_ideal_source_takes_the_fields_of_the_amplifier_and_a_charge_takes_none():
    values = {
        "filter_frequency": 100.0, "series_resistance": 1e6, "material.resistivity": 1e9,
        "material.dielectric_share": 0.1, "material.dielectric_time": 1.0,
    }  # fmt: skip
    assert PUMP.replace(values | {"circuit": "ideal", "slew_rate": 1e5, "current_limit": 1e-3}).circuit == "ideal"
    more = {
        "slew_rate": {"filter_frequency": 100.0}, "current_limit": {"series_resistance": 1e6},
        "material.dielectric_share": {"material.dielectric_time": 1.0},
    }  # fmt: skip
    for name in checks.ELECTRIC:
        given = {**more.get(name, {}), name: values.get(name, 1e-3)}
        with pytest.raises(InputError, match=f"{name}: the circuit 'charge' does not take it; leave out one"):
            PUMP.replace(given | {"circuit": "charge"})


def test_of_two_dampings_the_second_is_one_too_many():
    values = {**PUMP.parameters(), "damping_ratio": 0.1, "quality_factor": 5.0}
    values.pop("damping_coefficient", None)
    with pytest.raises(FieldError, match="damping_ratio and quality_factor are both given; give one of them") as both:
        Device(**values)
    assert both.value.field == "quality_factor"
