"""Figures of exponents: running estimates, where they end, and the value they settle to with its error."""

import numpy as np
import pytest

from gelcone import ConeModel, Outcome, find_device, lyapunov, to_si
from gelcone.plots.lyapunov import draw_member, lyapunov_figure, running_exponents, set_limits, verdict
from gelcone.plots.style import CYCLE, save_figure
from tests.plots.made_up import LASTING_EXPONENT, blank, data_of, parameter, result, texts

TIME = np.array([10.0, 20.0, 40.0, 80.0])


def exponents(units="1"):
    """Three members; the first chaotic, the second regular, the third failed."""
    each = ("member", "window")
    nothing = [np.nan] * 4
    return parameter(
        result(
            {
                "finite_time": (each, [TIME, TIME, nothing]),
                "finite_exponent": (each, [[9.0, 0.5, 0.4, np.nan], [-0.5, -0.3, -0.2, -0.2], nothing]),
                "running_time": (each, [1e3 * TIME, 1e3 * TIME, nothing]),
                "running_exponent": (each, [[0.3, 0.2, 0.12, 0.1], [-0.1] * 4, nothing]),
                LASTING_EXPONENT: (("member", "exponent"), [[0.1, -0.3], [-0.1, -0.1], [np.nan] * 2]),
                "standard_error": (("member", "exponent"), [[0.02, 0.02], [0.001, 0.001], [np.nan] * 2]),
                "sign": ("member", [1, -1, 0]),
                "outcome": ("member", [0, 0, int(Outcome.OUTSIDE)]),
            },
            {"voltage": ("member", [1.0, 0.5, 2.0])},
            {LASTING_EXPONENT: units} | dict.fromkeys(("finite_time", "running_time"), "ms" if units != "1" else "1"),
        ),
        "voltage",
    )


def test_a_member_is_its_two_running_estimates_and_its_value_with_a_band():
    axes = blank()
    draw_member(exponents().isel(member=0), "name", CYCLE[2], axes)
    start, end, settled, value = axes.lines
    np.testing.assert_array_equal(data_of(start), [TIME[:3], [9.0, 0.5, 0.4]])
    assert start.get_linestyle() == "--"
    np.testing.assert_array_equal(data_of(end), [[40.0], [0.4]])
    np.testing.assert_array_equal(data_of(settled), [1e3 * TIME, [0.3, 0.2, 0.12, 0.1]])
    assert settled.get_linestyle() == "-"
    np.testing.assert_array_equal(data_of(value), [[1e4, 8e4], [0.1, 0.1]])
    (band,) = axes.collections
    x, y = band.get_paths()[0].vertices.T
    np.testing.assert_allclose((x.min(), x.max(), y.min(), y.max()), (1e4, 8e4, 0.08, 0.12))
    assert {one.get_color() for one in axes.lines} == {CYCLE[2]}
    assert settled.get_label() == "name\n+0.100 ± 0.020\ncertainly positive"


def test_a_failed_member_has_no_value_and_says_why():
    axes = blank()
    failed = exponents().isel(member=2)
    draw_member(failed, "name", CYCLE[0], axes)
    assert not axes.collections
    assert len(axes.lines) == 2
    assert verdict(failed) == "failed: outside"
    assert verdict(exponents().isel(member=1)).endswith("certainly negative")
    assert verdict(exponents().isel(member=0).assign(sign=0)).endswith("sign uncertain within the budget")


def test_the_limits_hold_zero_and_all_but_the_shortest_windows():
    axes, data = blank(), exponents()
    set_limits(data, axes)
    low, high = -0.5, 9.0
    assert axes.get_ylim() == pytest.approx((low - 0.08 * 9.5, high + 0.08 * 9.5))
    data["finite_time"][:2, 0] = 3.9  # less than a twentieth of 80
    set_limits(data, axes)
    assert axes.get_ylim() == pytest.approx((-0.3 - 0.064, 0.5 + 0.064))
    data["finite_time"][:2, 0] = 4.1
    set_limits(data, axes)
    assert axes.get_ylim()[1] > 9.0
    set_limits(data.isel(member=[2]), axes)
    assert axes.get_ylim() == (-1.0, 1.0)


def test_the_limits_hold_the_error_of_the_value():
    axes, data = blank(), exponents().isel(member=[1])
    data["finite_exponent"][:] = data["running_exponent"][:] = -0.1
    data["standard_error"][:] = 0.3
    set_limits(data, axes)
    assert axes.get_ylim() == pytest.approx((-0.4 - 0.048, 0.2 + 0.048))


def test_time_is_on_a_log_scale_with_its_unit_and_zero_is_marked():
    axes = blank()
    running_exponents(exponents(), axes)
    assert axes.get_xscale() == "log"
    assert axes.lines[0].get_ydata() == [0.0, 0.0]
    assert axes.get_xlabel() == "window length (dimensionless time)"
    assert axes.get_ylabel() == "largest Lyapunov exponent\n(per unit time)"
    in_si = blank()
    running_exponents(exponents("1/s"), in_si)
    assert in_si.get_xlabel() == "window length (ms)"
    longer = exponents("1/s")
    seconds = blank()
    running_exponents(
        longer.assign({n: 1e3 * longer[n].assign_attrs() for n in ("finite_time", "running_time")}), seconds
    )
    assert seconds.get_xlabel() == "window length (s)"
    np.testing.assert_allclose(seconds.lines[1].get_xdata(), TIME)
    np.testing.assert_allclose(seconds.lines[3].get_xdata(), 1e3 * TIME)  # after the transient
    assert in_si.get_ylabel() == "largest Lyapunov exponent\n(per second)"
    colours = [one.get_color() for one in axes.lines if one.get_label().startswith("voltage")]
    assert colours == list(CYCLE[:3])
    styles = {one.get_label().split(",")[0]: one.get_linestyle() for one in axes.lines[-2:]}
    assert styles == {"from the start": "--", "after the transient": "-"}


def test_exponents_of_an_ensemble_with_a_failed_member(tmp_path):
    device, model = find_device("soft-film"), ConeModel(damping_ratio=0.3, stretch_limit=5.0, voltage=[0.5, 1.0, 2.0])
    initial = [[1.0, 0.0], [1.0, 0.0], [9.0, 0.0]]
    found = lyapunov(model, initial, window=30.0, transient=60.0, budget=100.0)
    figure = lyapunov_figure(found)
    save_figure(figure, tmp_path / "figure.png")
    for said in ("voltage 0.5", "failed: outside", "per unit time"):
        assert said in texts(figure)
    in_si = texts(lyapunov_figure(to_si(found, device)))
    for said in ("per second", "window length (ms)", device.name):
        assert said in in_si
    low, high = lyapunov_figure(found.isel(member=0)).axes[0].get_ylim()
    assert low < 0.0 < high
    save_figure(lyapunov_figure(found.isel(member=[2, 2])), tmp_path / "failed.png")
    assert texts(lyapunov_figure(found.isel(member=[2, 2]))).count("failed: outside") == 2
