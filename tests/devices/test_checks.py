"""What is wrong or hardly meant in the fields of a device together."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone.devices import checks
from gelcone.devices.checks import THICK, doubts
from gelcone.devices.device import find_device
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
    assert "13 mm is no membrane on a ring 21 mm wide" in told


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
