import numpy as np
import pytest

from gelcone.atlas.distribution import Normal, Uniform
from gelcone.atlas.plan import Plan
from gelcone.atlas.sweep import sweep
from gelcone.atlas.uncertain import draw
from gelcone.errors import InputError
from gelcone.motion.regime import regime
from gelcone.physics.model import ConeModel

FAST = ConeModel(damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.3)
QUICK = {"transient": 300.0, "budget": 1500.0, "patience": 300.0}


@pytest.mark.parametrize("method", ["sobol", "latin-hypercube"])
def test_draws_follow_their_distributions(method):
    draws = draw({"voltage": Uniform(0.5, 1.5), "prestretch": Normal(1.0, 0.1)}, 1024, method=method, seed=4)
    assert draws["voltage"].min() >= 0.5 <= 1.5 >= draws["voltage"].max()
    assert draws["voltage"].mean() == pytest.approx(1.0, abs=2e-3)
    assert draws["voltage"].var() == pytest.approx(1.0 / 12.0, rel=1e-2)
    assert draws["prestretch"].mean() == pytest.approx(1.0, abs=1e-3)
    assert draws["prestretch"].std() == pytest.approx(0.1, rel=2e-2)
    assert abs(np.corrcoef(*draws.values())[0, 1]) < 0.07
    again = draw({"voltage": Uniform(0.5, 1.5), "prestretch": Normal(1.0, 0.1)}, 1024, method=method, seed=4)
    np.testing.assert_array_equal(draws["prestretch"], again["prestretch"])


def test_one_draw_of_each_stratum_in_a_latin_hypercube():
    values = draw({"voltage": Uniform(0.0, 1.0)}, 50, method="latin-hypercube")["voltage"]
    assert sorted((values * 50).astype(int)) == list(range(50))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Uniform(1.0, 1.0), "from a lower to a higher"),
        (lambda: Normal(1.0, 0.0), "must be positive"),
        (lambda: draw({}, 4), "is empty"),
        (lambda: draw({"voltage": Uniform(0, 1)}, 1), "count = 1"),
        (lambda: draw({"voltage": Uniform(0, 1)}, 4, method="sobel"), "did you mean 'sobol'"),
        (lambda: Plan(FAST, {"voltage": [0.0, 1.0]}, draws={"voltage": [0.1, 0.2]}), "both swept and drawn"),
        (lambda: Plan(FAST, {}, draws={"voltage": [0.1], "prestretch": [1.0, 1.1]}), "same number of values"),
        (lambda: Plan(FAST, {}, draws={"voltage": [-0.1, 0.2]}), "at least 0"),
        (lambda: Plan(FAST, {}, draws={"volts": [0.1, 0.2]}), "'volts'"),
    ],
)
def test_bad_draws_are_refused(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_draws_are_cells_like_others():
    plan = Plan(FAST, {"voltage": [0.3, 0.9]}, draws={"prestretch": [0.9, 1.0, 1.1]}, options=QUICK)
    result = sweep(plan)
    assert result["regime"].dims == ("voltage", "draw")
    np.testing.assert_array_equal(result["drawn_prestretch"], [0.9, 1.0, 1.1])
    alone = regime(FAST.replace(voltage=0.9, prestretch=1.1), **QUICK)
    assert float(result["highest"][1, 2]) == float(alone["highest"])
    with pytest.raises(InputError, match="draws of uncertain parameters cannot be refined"):
        sweep(plan, coarsest=2)


@pytest.mark.parametrize("method", ["sobol", "latin-hypercube"])
def test_another_seed_gives_other_draws(method):
    one, other, again = (draw({"voltage": Uniform(0.0, 1.0)}, 8, method=method, seed=s)["voltage"] for s in (1, 2, 1))
    np.testing.assert_array_equal(one, again)
    assert (one != other).all()


def test_a_device_is_uncertain_in_texts_with_units():
    spread = {"film_thickness": Normal("0.2 mm", "2.5 %"), "frequency": Uniform("0.009 kHz", "11 Hz")}
    spread |= {"displacement": Uniform("1 mm", "0.2 cm"), "velocity": Normal("20 mm/s", "5 %")}
    in_numbers = {"film_thickness": Normal(2e-4, 5e-6), "frequency": Uniform(9.0, 11.0)}
    in_numbers |= {"displacement": Uniform(1e-3, 2e-3), "velocity": Normal(0.02, 1e-3)}
    for name, values in draw(in_numbers, 16).items():
        np.testing.assert_array_equal(draw(spread, 16)[name], values)


THREE = {"a": Uniform(0.0, 1.0), "b": Normal(0.0, 1.0), "c": Uniform(0.0, 1.0)}


def test_the_first_draws_are_independent_and_follow_their_distributions():
    draws = draw(THREE, 2048, indices=True)
    table = np.array([values[:2048] for values in draws.values()])
    assert np.abs(np.corrcoef(table) - np.eye(3)).max() < 0.05
    assert table[1].mean() == pytest.approx(0.0, abs=0.02)
    assert table[1].std() == pytest.approx(1.0, abs=0.02)
    assert abs(np.corrcoef(table[:, :1024], table[:, 1024:])[0, 3]) < 0.08


@pytest.mark.parametrize(("given", "count"), [({"a": Uniform(0.0, 1.0)}, 64), (THREE, 48)])
def test_indices_need_two_parameters_and_a_power_of_two(given, count):
    with pytest.raises(InputError, match="a power of 2"):
        draw(given, count, indices=True)


def test_indices_add_half_of_the_draws_for_each_parameter():
    """Two halves, and the first with one parameter from the second; a device's two fields alike."""
    for given in (THREE, {"voltage_offset": Normal("1 kV", "10 V"), "film_thickness": Uniform("0.1 mm", "0.2 mm")}):
        draws = draw(given, 16, indices=True)
        table = np.array(list(draws.values())).reshape(len(given), len(given) + 2, 8)
        for k, own in enumerate(table):
            assert not np.intersect1d(own[0], own[1]).size
            for j in range(len(given)):
                np.testing.assert_array_equal(own[2 + j], own[1 if j == k else 0])
