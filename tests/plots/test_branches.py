"""Figures of branches: orbits by stability and period, mirror images, events and flags, of made-up branches."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex

from gelcone.plots import branches as module
from gelcone.plots.style import BLACK, BLUE, GREEN, GREY, VERMILION
from tests.plots.made_up import blank, data_of

VALUES = np.array([1.0, 2.0, 3.0, 4.0])
STABLE = np.array([1, 1, 0, 0])


def branches(**changes):
    """A rest, and an orbit of period 2 at 10 and 20 times the value whose last two points are unstable."""
    orbit = np.zeros((2, 4, 8, 2))
    orbit[1, :, 0, 0], orbit[1, :, 4, 0] = 10.0 * VALUES, 20.0 * VALUES
    orbit[1, :, 1, 0] = 99.0
    at = ("branch", "point")
    data = xr.Dataset(
        {
            "value": (at, [VALUES, VALUES]), "stable": (at, [np.ones(4, dtype=int), STABLE]),
            "lyapunov": (at, [[-1.0, -1.0, -2.0, -2.0], [-0.5, -0.1, 0.2, 0.4]]),
            "orbit": ((*at, "node", "state"), orbit), "resting": ("branch", [1, 0]), "symmetric": ("branch", [1, 0]),
            "period": ("branch", [1, 2]),
            "nodes_per_repeat": ("branch", [4, 4]),
            "event_branch": ("event", [1, 1, 0]), "event_point": ("event", [1, 2, 3]),
            "event_value": ("event", [2.5, 3.5, 4.0]), "event_supercritical": ("event", [-1, 0, 1]),
            "event_kind": ("event", [0, 1, 0], {"flag_values": [0, 1], "flag_meanings": "fold period_doubling"}),
            "event_orbit": (("event", "node", "state"), np.stack([orbit[1, 1], orbit[1, 2], orbit[0, 3]])),
            "flag_value": ("flag", [1.5, 3.0]), "flag_explanation": ("flag", ["", "by its window"]),
            "flag_kind": ("flag", [0, 0], {"flag_values": [0], "flag_meanings": "unseen"}),
        },
        attrs={"mirror": 1},
    )  # fmt: skip
    data["lyapunov"].attrs["units"] = "1"
    return data.assign({name: (data[name].dims, np.array(value), data[name].attrs) for name, value in changes.items()})


def drawn(axes):
    """Colour, style and points of each line that shows any."""
    return [
        (to_hex(one.get_color()), one.get_linestyle(), one.get_alpha(), data_of(one).T.tolist())
        for one in axes.lines
        if data_of(one).size
    ]


def test_a_branch_is_solid_where_stable_and_dashed_from_its_last_stable_point_on():
    inside, outside = module.stability_parts(np.array([0, 0, 1, 1, 1, 0]))
    assert inside.tolist() == [False, False, True, True, True, False]
    assert outside.tolist() == [True, True, True, False, True, True]
    axes = blank()
    module.orbits(branches().assign_attrs(mirror=0), axes)
    rest = [[v, 0.0] for v in VALUES]
    assert drawn(axes)[0] == (BLACK.lower(), "-", 1.0, rest)
    first, second = ([[v, times * v] for v in VALUES] for times in (10.0, 20.0))
    orange = to_hex(VERMILION)
    found = drawn(axes)[1:]
    assert [(colour, style) for colour, style, *_ in found] == [(orange, "-")] * 2 + [(orange, "--")] * 2
    assert [points for *_, points in found] == [first[:2], second[:2], first[1:], second[1:]]


def test_the_mirror_image_of_a_motion_that_is_another_one_is_paler():
    axes = blank()
    module.orbits(branches(), axes)
    images = [points for *_, alpha, points in drawn(axes) if alpha == module.LIGHTER]
    assert images[0] == [[v, -10.0 * v] for v in VALUES[:2]]
    assert len(images) == 4
    for changes in ({"symmetric": [1, 1]}, {"resting": [1, 1]}):
        axes = blank()
        module.orbits(branches(**changes), axes)
        assert module.LIGHTER not in [alpha for *_, alpha, _ in drawn(axes)]
    axes = blank()
    module.orbits(branches().assign_attrs(mirror=0), axes)
    assert module.LIGHTER not in [alpha for *_, alpha, _ in drawn(axes)]


def test_colours_are_those_of_doublings_and_of_rest():
    for period, colour in ((1, BLUE), (2, VERMILION), (3, VERMILION), (4, GREEN), (8, module.CYCLE[3])):
        assert module.colour_of(branches(period=[1, period]).isel(branch=1)) == colour
    assert module.colour_of(branches().isel(branch=0)) == BLACK


def test_events_lie_at_their_orbits_open_where_subcritical_and_end_a_stable_part_or_do_not():
    axes = blank()
    module.events(branches(), axes)
    ends = [module.ends_stability(branches().isel(branch=b), branches().isel(event=k)) for k, b in enumerate((1, 1, 0))]
    assert ends == [True, False, True]
    begins = branches(stable=[np.ones(4, dtype=int), 1 - STABLE])
    for k, ended in enumerate((True, True)):  # between the second point and the third stability begins
        assert module.ends_stability(begins.isel(branch=1), begins.isel(event=k)) == ended
    assert [one.get_xydata().tolist() for one in axes.lines] == [
        [[2.5, 20.0], [2.5, 40.0]], [[3.5, 30.0], [3.5, 60.0]], [[4.0, 0.0]],
    ]  # fmt: skip
    assert [one.get_markerfacecolor() for one in axes.lines] == [VERMILION, "white", BLACK]
    assert [one.get_marker() for one in axes.lines] == ["s", "D", "s"]
    axes = blank()
    module.events(branches(period=[1, 4], orbit=np.zeros((2, 4, 16, 2)), event_orbit=np.zeros((3, 16, 2))), axes)
    assert [one.get_xdata()[0] for one in axes.lines] == [2.5, 4.0]  # of a long period only where stability ends


def test_the_ends_of_stable_parts_are_lines_through_all_panels():
    panels = blank(), blank()
    module.event_ticks(branches(), panels)
    assert [one.get_xdata()[0] for one in panels[0].lines] == [2.5, 4.0]
    assert [one.get_xdata()[0] for one in panels[1].lines] == [2.5, 2.5, 3.5, 4.0, 4.0]


def test_exponents_are_drawn_as_their_branches_over_a_zero_line():
    axes = blank()
    module.exponents(branches(), axes)
    (_, _, _, zero), *rest = drawn(axes)
    assert [y for _, y in zero] == [0.0, 0.0]
    assert rest[0][3] == [[1.0, -1.0], [2.0, -1.0], [3.0, -2.0], [4.0, -2.0]]
    assert [points for *_, points in rest[1:]] == [[[1.0, -0.5], [2.0, -0.1]], [[2.0, -0.1], [3.0, 0.2], [4.0, 0.4]]]
    low, high = axes.get_ylim()
    assert low < -1.9 < 0.38 < high < 0.7
    axes = blank()
    module.exponents(branches(lyapunov=np.full((2, 4), -1.0) - np.arange(4.0)), axes)
    assert axes.get_ylim()[1] > 0.0


def test_contradictions_are_crosses_and_a_plus_where_they_are_explained():
    axes = blank()
    module.flags(branches(), axes)
    assert [(one.get_marker(), one.get_color(), one.get_xdata()[0]) for one in axes.lines] == [
        ("x", VERMILION, 1.5), ("+", GREY, 3.0),
    ]  # fmt: skip


@pytest.mark.parametrize("mirror", [0, 1])
def test_the_legend_names_what_is_drawn(mirror):
    names = [handle.get_label() for handle in module.legend(branches().assign_attrs(mirror=mirror))]
    expected = ["stable", "unstable", "brute force", "period 2", "rest", *(["mirror image"] * mirror)]
    assert names == [*expected, "fold", "period doubling", "open: subcritical", "! unseen"]
    handles = module.legend(branches())
    hollow = [handle.get_label() for handle in handles if handle.get_markerfacecolor() == "white"]
    assert hollow == ["open: subcritical"]
    colours = {handle.get_label(): handle.get_color() for handle in handles}
    assert (colours["period 2"], colours["rest"]) == (VERMILION, BLACK)


def test_brute_force_is_the_displacement_of_settled_motions():
    runs = {
        "run_section": (("run", "repeat", "state"), np.arange(12.0).reshape(2, 3, 2)),
        "run_value": ("run", [5.0, 6.0]),
    }
    axes = blank()
    module.brute_force(xr.Dataset(runs), axes)
    assert axes.lines[0].get_xydata().tolist() == [
        [5.0, 0.0], [5.0, 2.0], [5.0, 4.0], [6.0, 6.0], [6.0, 8.0], [6.0, 10.0],
    ]  # fmt: skip


def test_a_branch_is_faint_where_the_model_does_not_hold_and_reaches_the_points_that_hold():
    """Unless it holds nowhere: then this is written, and the branches stay as they are."""
    fails = np.zeros((2, 4))
    fails[1, 3] = 0.2
    shown = branches().assign(validity_breakdown=(("branch", "point"), fails))
    axes = blank()
    module.exponents(shown, axes)
    strong, faint = drawn(axes)[-2:]
    assert [strong[2:], faint[2:]] == [(1.0, [[2.0, -0.1], [3.0, 0.2]]), (module.UNHELD, [[3.0, 0.2], [4.0, 0.4]])]
    assert module.UNHELD_LABEL in [handle.get_label() for handle in module.legend(shown)]
    nowhere = branches().assign(validity_breakdown=(("branch", "point"), np.ones((2, 4))))
    axes, usual = blank(), blank()
    module.exponents(nowhere, axes)
    module.exponents(branches(), usual)
    assert drawn(axes) == drawn(usual)
    labels = [handle.get_label() for handle in module.legend(nowhere)]
    assert module.NOWHERE in labels
    assert module.UNHELD_LABEL not in labels


def test_the_figure_reaches_over_all_values_of_the_branches():
    runs = {"run_section": (("run", "repeat", "state"), np.zeros((1, 1, 2))), "run_value": ("run", [2.0])}
    made = branches().assign(runs).assign(lowest=(("branch", "point"), np.zeros((2, 4))))
    made["value"].attrs["units"] = made["lowest"].attrs["units"] = "1"
    figure = module.branches_figure(made.assign_attrs(parameter="drive_frequency", title="branches"))
    above, below = figure.axes
    assert above.get_xlim() == below.get_xlim() == (1.0, 4.0)
    assert (above.get_ylabel(), below.get_xlabel()) == ("displacement\nonce per forcing period", "drive frequency")
