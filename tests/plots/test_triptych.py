"""The figure of motions side by side: each panel has the numbers of its part, in the colour of its motion's regime."""

import numpy as np
import pytest

from gelcone.codes import Outcome, Regime
from gelcone.plots.regime import REGIME_COLOURS
from gelcone.plots.triptych import triptych_figure
from tests.plots.made_up import data_of, parameter, result

UNITS = {name: unit for part in ("", "late_", "section_") for name, unit in (
    (f"{part}time", "s"), (f"{part}displacement", "mm"), (f"{part}velocity", "m/s"))} | {"lyapunov": "1/s"}  # fmt: skip
TITLES = ("from the start\ndisplacement (mm)", "settled\ndisplacement (mm)", "phase portrait\nvelocity (m/s)",
          "section\nvelocity (m/s)")  # fmt: skip


def motions(regimes, points, **changed):
    """Motions of some regimes with ``points`` different ones in each section; every number is another."""
    count, each = len(regimes), np.arange(1.0, len(regimes) + 1.0)[:, None]
    runs = {}
    for part, at in (("", 0.0), ("late_", 100.0)):
        runs[f"{part}time"] = ("member", "sample"), at + np.tile([1.0, 2.0, 4.0], (count, 1))
        runs[f"{part}displacement"] = ("member", "sample"), at + each * [1.0, 5.0, 3.0]
        runs[f"{part}velocity"] = ("member", "sample"), at + each * [-2.0, 7.0, 4.0]
    place = np.where(np.arange(40) < points, np.arange(40.0), np.nan)
    variables = runs | {
        "section_displacement": (("member", "repeat"), 200.0 + each * place),
        "section_velocity": (("member", "repeat"), 300.0 - each * place),
        "regime": ("member", [int(regime) for regime in regimes]),
        "period": ("member", [3] * count),
        "lyapunov": (("member", "exponent"), np.tile([0.0625, -7.0], (count, 1))),
        "standard_error": (("member", "exponent"), np.tile([0.003, 0.5], (count, 1))),
        "outcome": ("member", [0] * count),
    }
    data = result(variables | changed, {"voltage": ("member", 0.5 * np.arange(1, count + 1))}, UNITS)
    return parameter(data, "voltage")


def columns(figure):
    """The four panels of each motion."""
    return np.array(figure.axes).reshape(4, -1).T


def test_each_panel_has_the_numbers_of_its_part():
    data = motions([Regime.PERIODIC, Regime.CHAOTIC], 5)
    for k, (start, settled, plane, section) in enumerate(columns(triptych_figure(data))):
        own, colour = data.isel(member=k), REGIME_COLOURS[(Regime.PERIODIC, Regime.CHAOTIC)[k]]
        for axes, part in ((start, ""), (settled, "late_")):
            (line,) = axes.lines
            np.testing.assert_array_equal(data_of(line), [own[f"{part}time"], own[f"{part}displacement"]])
            assert axes.get_xlim() == (own[f"{part}time"].min(), own[f"{part}time"].max())
        before, after = plane.lines
        np.testing.assert_array_equal(data_of(before), [own["displacement"], own["velocity"]])
        np.testing.assert_array_equal(data_of(after), [own["late_displacement"], own["late_velocity"]])
        (points,) = section.lines
        np.testing.assert_array_equal(data_of(points), [own[f"section_{n}"][:5] for n in ("displacement", "velocity")])
        assert [settled.lines[0].get_color(), after.get_color(), points.get_color()] == [colour] * 3
        assert [start.lines[0].get_color(), before.get_color()] == ["#000000", "#888888"]
        names = ["time (s)", "time, settled (s)", "displacement (mm)", "displacement (mm)"]
        assert [axes.get_xlabel() for axes in (start, settled, plane, section)] == names
    first, second = columns(triptych_figure(data))
    assert [axes.get_ylabel() for axes in first] == list(TITLES)
    assert [axes.get_ylabel() for axes in second] == [""] * 4


def test_a_title_says_the_kind_of_motion_and_its_largest_exponent_with_the_error():
    data = motions([Regime.PERIODIC, Regime.CHAOTIC], 5, outcome=("member", [0, int(Outcome.STEP_LIMIT)]))
    titles = [column[0].get_title(loc="left") for column in columns(triptych_figure(data))]
    assert titles == [
        "voltage 0.5\nperiodic, period 3\n$\\lambda_1$ = 0.0625 ± 0.003 per second",
        "voltage 1\nstep limit",
    ]


@pytest.mark.parametrize(("points", "large"), [(1, True), (16, True), (17, False), (40, False)])
def test_a_section_of_up_to_sixteen_points_is_drawn_large(points, large):
    (axes,) = columns(triptych_figure(motions([Regime.PERIODIC], points)))[:, 3]
    assert axes.lines[0].get_markersize() == (4.0 if large else 1.4)


def test_rest_is_a_dot_where_the_motion_ends():
    (_, _, plane, _), = columns(triptych_figure(motions([Regime.REST], 1)))  # fmt: skip
    dot = plane.lines[2]
    assert (dot.get_marker(), data_of(dot).tolist()) == ("o", [[103.0], [104.0]])
    (_, _, plane, _), = columns(triptych_figure(motions([Regime.PERIODIC], 1)))  # fmt: skip
    assert len(plane.lines) == 2


def test_what_has_no_settled_motion_says_so():
    none = {name: (("member", "sample"), np.full((1, 3), np.nan)) for name in ("late_displacement", "late_velocity")}
    data = motions([Regime.LEFT_THE_DOMAIN], 0, **none)
    ((start, settled, _, section),) = columns(triptych_figure(data))
    assert len(start.lines) == 1
    for axes in (settled, section):
        assert [text.get_text() for text in axes.texts] == ["none: the motion has ended"]
        assert not axes.lines


def test_rest_is_not_magnified():
    still = {f"late_{name}": (("member", "sample"), [[0.3, 0.3 + 1e-12, 0.3]]) for name in ("displacement", "velocity")}
    axes = columns(triptych_figure(motions([Regime.REST], 1, **still)))[0, 1]
    low, high = axes.get_ylim()
    assert high - low > 0.05
