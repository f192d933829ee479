"""The stress of a coupon against closed forms and an independent integration."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar

from gelcone.devices.materials import Material
from gelcone.errors import InputError
from gelcone.lab.coupons import Coupon
from gelcone.lab.stress import SAME_RATE, _pieces, branch_stresses, relaxation_grid, stress_of

EPS0 = 8.8541878188e-12
SOFT = {"shear_modulus": 2e4, "relative_permittivity": 5.0, "law": "neo-hookean"}


def made(time, stretch, mode="uniaxial", **more):
    time, stretch = np.asarray(time, dtype=float), np.asarray(stretch, dtype=float)
    history = (np.concatenate([[0.0], time]), np.concatenate([[1.0], stretch]))
    if time[0] == 0.0:
        history = (time, stretch)
    return Coupon("test", "test.csv", mode, "loading", time, stretch, 0.0 * time, history, **more)


def still(stretch, mode="uniaxial", **more):
    """A quasi-static test."""
    stretch = np.asarray(stretch, dtype=float)
    nothing = np.full(stretch.size, np.nan)
    return Coupon("test", "t.csv", mode, "quasi-static", nothing, stretch, 0.0 * stretch, (np.empty(0),) * 2, **more)


@pytest.mark.parametrize(
    ("mode", "textbook"),
    [
        ("uniaxial", lambda s: s - s**-2.0),
        ("equi-biaxial", lambda s: s - s**-5.0),
        ("pure shear", lambda s: s - s**-3.0),
    ],
)
def test_neo_hookean_coupons(mode, textbook):
    """Treloar, The Physics of Rubber Elasticity."""
    stretch = np.linspace(0.9, 4.0, 9)
    np.testing.assert_allclose(stress_of(still(stretch, mode), Material(**SOFT)), 2e4 * textbook(stretch), rtol=1e-12)


@pytest.mark.parametrize("flow", ["log", "linear"])
def test_small_strains_are_those_of_a_linear_maxwell_element(flow):
    """3 g rate tau (1 - exp(-t/tau)) in uniaxial tension, to the order of the strain."""
    time, rate, tau = np.linspace(0.0, 5.0, 11), 1e-4, np.array([0.3, 2.0])
    found = branch_stresses(made(time, 1.0 + rate * time), tau, flow)
    expected = 3.0 * rate * tau[:, None] * -np.expm1(-time / tau[:, None])
    np.testing.assert_allclose(found, expected, rtol=2e-3, atol=1e-10)


def test_a_held_branch_relaxes_as_certified():
    """The share left after a tenth of the relaxation time at the stretches 1.1, 1.5, 2 and 3."""
    left = []
    for stretch in (1.1, 1.5, 2.0, 3.0):
        test = made([1e-7, 1e-7 + 0.1], [stretch, stretch])
        (own,) = branch_stresses(test, np.array([1.0]), "log")
        left.append(own[1] / own[0])
    np.testing.assert_allclose(left, [0.896, 0.847, 0.773, 0.614], atol=6e-4)
    (own,) = branch_stresses(made([1e-7, 1e-7 + 0.1], [2.0, 2.0]), np.array([1.0]), "linear")
    assert own[1] / own[0] == pytest.approx(np.exp(-0.1), abs=1e-6)


def test_loading_and_unloading_by_another_integrator():
    """The viscous stretch by its own differential equation, at a tight tolerance."""
    rate, tau, top = 0.2, 1.7, 3.0
    turn = (top - 1.0) / rate
    time = np.concatenate([np.linspace(0.5, turn, 8), turn + np.linspace(0.5, 8.0, 8)])
    stretch = np.where(time <= turn, 1.0 + rate * time, top - rate * (time - turn))

    def slope(t, log_viscous):
        e = (1.0 + rate * t if t <= turn else top - rate * (t - turn)) / np.exp(log_viscous)
        return (e * e - 1.0 / e) / (3.0 * tau)

    first = solve_ivp(slope, (0.0, turn), [0.0], "DOP853", rtol=1e-12, atol=1e-13, t_eval=time[:8])
    second = solve_ivp(slope, (turn, time[-1]), first.y[:, -1], "DOP853", rtol=1e-12, atol=1e-13, t_eval=time[8:])
    e = stretch / np.exp(np.concatenate([first.y[0], second.y[0]]))
    (found,) = branch_stresses(made(time, stretch), np.array([tau]), "log")
    np.testing.assert_allclose(found, (e * e - 1.0 / e) / stretch, rtol=0.0, atol=3e-6)


def test_a_stiff_branch_over_hours_is_a_viscous_fluid():
    """A branch of 10 ms at 0.01/s: 3 g tau times the rate of the true strain."""
    time = np.linspace(10.0, 400.0, 5)
    stretch = 1.0 + 0.01 * time
    (found,) = branch_stresses(made(time, stretch), np.array([0.01]), "log")
    np.testing.assert_allclose(found, 3.0 * 0.01 * (0.01 / stretch) / stretch, rtol=1e-3)


def test_under_voltage_with_free_width():
    """Without branches n = 1/sqrt(m (1 - f m)), with f the field's energy over mu: no stress across."""
    stretch, voltage, thickness = np.array([1.1, 1.5, 2.0]), 3e3, 5e-4
    f = 5.0 * EPS0 * (voltage / thickness) ** 2 / 2e4
    m = stretch**2
    n = 1.0 / np.sqrt(m * (1.0 - f * m))
    expected = 2e4 * (m - 1.0 / (m * n) - f * m * n) / stretch
    assert (expected > 0.0).all()
    found = stress_of(still(stretch, voltage=voltage, thickness=thickness), Material(**SOFT))
    np.testing.assert_allclose(found, expected, rtol=1e-9)


@pytest.mark.parametrize("limit", [3.0, 8.0])
def test_under_voltage_a_gel_with_a_limit_takes_the_width_of_least_energy(limit):
    """W(I1)/mu - f m n/2 is least at its squared width n; its slope by the stretch is the stress."""
    stretch, voltage, thickness = np.array([1.05, 1.3, 1.6]), 4e3, 5e-4
    gel = Material(**SOFT | {"law": "gent", "stretch_limit": limit})
    f = 5.0 * EPS0 * (voltage / thickness) ** 2 / 2e4

    def energy(m, n):
        return -0.5 * limit * np.log1p(-(m + n + 1.0 / (m * n) - 3.0) / limit) - 0.5 * f * m * n

    expected = []
    for one in stretch:
        m, h = one * one, 1e-5
        n = minimize_scalar(lambda n, m=m: energy(m, n), bounds=(0.3 / m**0.5, 3.0), options={"xatol": 1e-10}).x
        expected.append(2e4 * (energy((one + h) ** 2, n) - energy((one - h) ** 2, n)) / (2.0 * h))
    assert min(expected) > 0.0
    found = stress_of(still(stretch, voltage=voltage, thickness=thickness), gel)
    np.testing.assert_allclose(found, expected, rtol=1e-6)


def test_under_voltage_with_held_width():
    stretch, f = np.array([1.5, 2.0]), 5.0 * EPS0 * (3e3 / 5e-4) ** 2
    found = stress_of(still(stretch, voltage=3e3, thickness=5e-4, width="held"), Material(**SOFT))
    np.testing.assert_allclose(found, 2e4 * (stretch - stretch**-3.0) - f * stretch, rtol=1e-12)


def test_a_film_that_is_slack_is_not_compressed():
    found = stress_of(still([1.0, 1.01], voltage=6e3, thickness=5e-4), Material(**SOFT))
    np.testing.assert_array_equal(found, [0.0, 0.0])


def test_a_voltage_that_pulls_in_has_no_stress():
    found = stress_of(still([3.0], voltage=2e4, thickness=5e-4), Material(**SOFT))
    assert np.isnan(found).all()


@pytest.mark.parametrize("flow", ["log", "linear"])
def test_with_branches_a_vanishing_voltage_changes_nothing(flow):
    gel = Material(**SOFT, viscous_modulus_1=3e4, relaxation_time_1=0.5, flow=flow)
    time = np.linspace(0.5, 8.0, 6)
    without = stress_of(made(time, 1.0 + 0.1 * time), gel)
    width_found = stress_of(made(time, 1.0 + 0.1 * time, voltage=1e-3, thickness=5e-4), gel)
    np.testing.assert_allclose(width_found, without, rtol=1e-6)
    lower = stress_of(made(time, 1.0 + 0.1 * time, voltage=3e3, thickness=5e-4), gel)
    assert (lower < without - 500.0).all()


def test_a_voltage_needs_a_thickness():
    with pytest.raises(InputError, match="has a voltage and no thickness; add thickness"):
        stress_of(still([1.5], voltage=1e3), Material(**SOFT))


def test_the_grid_spans_what_tests_distinguish():
    grid = relaxation_grid([made([1.0, 2.0], [1.1, 1.2]), made([10.0, 1e4], [1.1, 1.1])])
    assert grid[0] <= 1.0 / 30.0
    assert grid[-1] >= 1e6
    assert relaxation_grid([still([1.0, 2.0])]).size == 0
    uneven = relaxation_grid([made([0.001, 3.0, 6.0, 9.0], [1.1, 1.2, 1.3, 1.4]), made([4.0, 50.0], [1.1, 1.1])])
    assert (uneven[0], uneven[-1]) == pytest.approx(
        (0.1, 5000.0), rel=1e-3
    )  # by the usual step of the test with the shorter one
    assert uneven.size == 58  # 12 a decade
    np.testing.assert_allclose(np.diff(np.log(uneven)), np.log(5e4) / (uneven.size - 1), rtol=1e-3)


@pytest.mark.parametrize("steps", [40, 400])
def test_a_stretch_is_followed_in_pieces_of_one_rate(steps):
    """Of a slowly rising rate too: each piece ends at the next, and leads to the stretch at all its corners."""
    time = np.linspace(0.0, 2.0, steps + 1)
    slowly = 1.0 + 0.1 * (time + 0.25 * SAME_RATE * time**2 / time[1])  # by half of what counts as one in each step
    for stretch in (slowly, 1.0 + 0.1 * time**2, 1.0 + 0.3 * np.minimum(time, 1.0), 1.0 + 1e-8 * np.exp(9.0 * time)):
        pieces = list(_pieces((time, stretch)))
        assert (pieces[0][0], pieces[-1][1]) == (0.0, 2.0)
        assert [piece[0] for piece in pieces[1:]] == [piece[1] for piece in pieces[:-1]]
        np.testing.assert_array_equal(np.concatenate([piece[-1] for piece in pieces]), time[1:])
        fastest = np.abs(np.diff(stretch) / np.diff(time)).max()
        for begin, _, first, rate, corners in pieces:
            expected = np.interp(corners, time, stretch)
            np.testing.assert_allclose(first + rate * (corners - begin), expected, atol=3.0 * SAME_RATE * fastest)
    assert len(list(_pieces((time, 1.0 + 0.3 * np.minimum(time, 1.0))))) == 2
