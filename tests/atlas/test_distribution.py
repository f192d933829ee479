import numpy as np
import pytest

from gelcone.atlas.distribution import Normal, Uniform
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
        (lambda: draw({"film_thickness": Normal("0.25 mm", "-1 um")}, 4), "must be positive"),
        (lambda: draw({"voltage": Normal("0.25 V", "1 V")}, 4), "voltage is not a device's field with one"),
    ],
)
def test_texts_that_are_no_distribution_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_shares_of_a_normal_distribution_lie_below_its_values():
    np.testing.assert_allclose(Normal(1.0, 2.0).at(np.array([0.5, 0.8413447460685429])), [1.0, 3.0], rtol=1e-12)
