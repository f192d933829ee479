"""Distributions: their quantiles, and texts with units as SI numbers."""

import numpy as np
import pytest

from gelcone.atlas.distribution import Normal, Uniform, in_numbers
from gelcone.atlas.uncertain import draw
from gelcone.errors import InputError


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Normal("0.25 mm", 1e-5), "mixes a number and a text"),
        (
            lambda: draw({"film_thickness": 3}, 8),
            r"film_thickness = 3: must be a distribution, such as gelcone\.Uniform",
        ),
        (lambda: Uniform(0.1, None), "None must be a number, or a text such as '0.25 mm'"),
        (lambda: draw({"film_thickness": Normal("0.25 V", "1 V")}, 4), "V is a unit of voltage, not of length"),
        (
            lambda: draw({"film_thickness": Normal("0.25 mm", "-1 um")}, 4),
            "deviation of film_thickness = .-1 um.: must be greater than 0 m",
        ),
        (lambda: draw({"voltage": Normal("0.25 V", "1 V")}, 4), "voltage is not a device's field with one"),
        (lambda: in_numbers("voltage_offset", Normal("0 V", "3 %")), "is a share of 0; give the deviation with a unit"),
        (lambda: Uniform(0.3, 0.3), r"0\.3:0\.3: a uniform distribution goes from a lower to a higher bound"),
        (lambda: Uniform("3 mm", "2 mm") and in_numbers("film_radius", Uniform("3 mm", "2 mm")), "0.003:0.002: a unif"),
        (lambda: Normal(1.0, 0.0), r"1~0: the standard deviation 0 must be positive"),
        (lambda: Normal(np.inf, 1.0), "both numbers finite"),
    ],
)
def test_texts_that_are_no_distribution_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize(
    ("name", "given", "expected"),
    [
        ("frequency", Normal("9 Hz", "3 %"), (9.0, 0.27)), ("frequency", Normal("9 Hz", "0.3 Hz"), (9.0, 0.3)),
        ("voltage_offset", Normal("-0.3 kV", "5 %"), (-300.0, 15.0)),
        ("film_thickness", Normal("0.2 mm", "10 um"), (2e-4, 1e-5)),
        ("film_thickness", Uniform("0.1 mm", "300 um"), (1e-4, 3e-4)),
        ("velocity", Normal("1 m/s", "2 %"), (1.0, 0.02)),
        ("displacement", Uniform("-5 mm", "5 mm"), (-5e-3, 5e-3)), ("voltage", Normal(0.4, 0.1), (0.4, 0.1)),
    ],
)  # fmt: skip
def test_texts_are_si_numbers_and_a_share_is_one_of_the_mean(name, given, expected):
    found = in_numbers(name, given)
    ends = (found.mean, found.deviation) if isinstance(given, Normal) else (found.low, found.high)
    assert ends == pytest.approx(expected, rel=1e-12)


def test_shares_of_a_uniform_distribution_lie_evenly_between_its_bounds():
    np.testing.assert_allclose(Uniform(-1.0, 3.0).at(np.array([0.0, 0.25, 1.0])), [-1.0, 0.0, 3.0])


def test_shares_of_a_normal_distribution_lie_below_its_values():
    np.testing.assert_allclose(Normal(1.0, 2.0).at(np.array([0.5, 0.8413447460685429])), [1.0, 3.0], rtol=1e-12)
