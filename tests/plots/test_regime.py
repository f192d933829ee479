"""Figures of regimes: colours and markers by kind of motion, the evidence in words, and grids of cells."""

import numpy as np
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgb
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from gelcone import ConeModel, Outcome, Regime, find_device, regime, to_si
from gelcone.plots.regime import (
    REGIME_COLOURS,
    cell_legend,
    edges,
    invalid_legend,
    keep_in_proportion,
    mark_failed,
    mark_flagged,
    regime_cells,
    regime_figure,
    regime_points,
    state_labels,
)
from gelcone.plots.style import BLACK, GREY, save_figure
from gelcone.words import evidence_in_words
from tests.plots.made_up import DOUBTFUL, EXPONENT, blank, cells_of, corners, data_of, parameter, result, texts


def regimes(units="1", lowest="1", **changed):
    """Four members: rest, periodic, chaotic, failed."""
    kinds = [Regime.REST, Regime.PERIODIC, Regime.CHAOTIC, Regime.LEFT_THE_DOMAIN]
    points = np.arange(4.0)[:, None, None] + np.array([[[0.1, 1.0], [0.2, 2.0]]])
    values = {
        "section": (("member", "point", "state"), points),
        "regime": ("member", [int(kind) for kind in kinds]),
        "period": ("member", [1, 2, 0, 0]),
        "symmetric": ("member", [False, True, False, False]),
        "zero_one": ("member", [np.nan, np.nan, 0.987, np.nan]),
        "cycle_distance": ("member", [2e-5, np.nan, np.nan, np.nan]),
        "return_distance": ("member", [3e-9, 3e-9, np.nan, np.nan]),
        EXPONENT: (("member", "exponent"), [[-0.1, -0.2], [-0.05, -0.1], [0.1, -0.3], [np.nan] * 2]),
        "standard_error": (("member", "exponent"), [[0.001] * 2, [0.01] * 2, [0.02] * 2, [np.nan] * 2]),
        DOUBTFUL: ("member", [0, 0, 1, 0]),
        "lowest": ("member", [0.0] * 4),
        "outcome": ("member", [0, 0, 0, int(Outcome.STRETCH_LIMIT)]),
    }
    values |= {name: (values[name][0], value) for name, value in changed.items()}
    data = result(values, {"voltage": ("member", [0.0, 1.0, 2.0, 3.0])}, {"section": units, "lowest": lowest})
    return parameter(data, "voltage")


def test_points_are_displacement_and_velocity_in_the_colour_of_the_regime():
    axes = blank()
    regime_points(regimes(), axes)
    for k, drawn in enumerate(axes.collections):
        np.testing.assert_allclose(data_of(drawn), [[k + 0.1, k + 0.2], [k + 1.0, k + 2.0]])
    kinds = (Regime.REST, Regime.PERIODIC, Regime.CHAOTIC, Regime.LEFT_THE_DOMAIN)
    assert [tuple(c.get_facecolor()[0][:3]) for c in axes.collections] == [to_rgb(REGIME_COLOURS[k]) for k in kinds]
    paths = {tuple(map(tuple, c.get_paths()[0].vertices)) for c in axes.collections}
    assert len(paths) == 4  # a marker a member
    # what returns is drawn larger, and over what does not
    assert [c.get_sizes()[0] for c in axes.collections] == [28.0, 28.0, 9.0, 28.0]
    assert axes.collections[1].zorder > axes.collections[2].zorder


def test_the_evidence_is_written_line_by_line():
    rest, periodic, chaotic, failed = (evidence_in_words(regimes().isel(member=k)) for k in range(4))
    assert rest == [
        "rest",
        "largest exponent -0.1000 ± 0.0010 per unit time",
        "settled (within 2e-05 of its size)",
    ]
    assert periodic == [
        "periodic, period 2, symmetric",
        "largest exponent -0.050 ± 0.010 per unit time",
        "points return to within 3e-09 of its size",
    ]
    assert chaotic == [
        "chaotic",
        "largest exponent +0.100 ± 0.020 per unit time",
        "0-1 test 0.99",
        "! the evidence disagrees",
    ]
    assert failed == ["failed: stretch limit"]


@pytest.mark.parametrize(
    ("units", "lowest", "labels"),
    [
        ("1", "1", ("displacement", "velocity")),
        ("mm, m/s", "mm", ("displacement (mm)", "velocity (m/s)")),
        ("1", "mm", ("displacement / (b - a)", "velocity / ((b - a) $\\Omega_0$)")),
    ],
)
def test_axes_carry_the_units_of_the_states(units, lowest, labels):
    axes, data = blank(), regimes(units, lowest)
    assert state_labels(data) == labels
    regime_points(data, axes)
    assert (axes.get_xlabel(), axes.get_ylabel()) == labels


@pytest.mark.parametrize(
    ("limits", "kept"),
    [
        ((0.0, 1.0), (0.0, 1.0)),
        ((1.0, 1.0 + 1e-6), (0.9, 1.1)),
        ((-1.0 - 1e-6, -1.0), (-1.1, -0.9)),
        ((-1e-9, 1e-9), (-0.01, 0.01)),
        ((1.0, 1.26), (1.0, 1.26)),
        ((1.0, 1.2), (0.98, 1.22)),
    ],
)
def test_rounding_is_not_blown_up(limits, kept):
    axes = blank()
    axes.set_xlim(*limits)
    axes.set_ylim(*limits)
    keep_in_proportion(axes)
    np.testing.assert_allclose(axes.get_xlim(), kept, rtol=1e-5)
    np.testing.assert_allclose(axes.get_ylim(), kept, rtol=1e-5)


def test_every_regime_has_its_own_colour_and_chaos_is_far_from_rest():
    rgb = {kind: np.array(to_rgb(colour)) for kind, colour in REGIME_COLOURS.items()}
    assert set(rgb) == set(Regime)
    apart = [np.linalg.norm(rgb[a] - rgb[b]) for a in Regime for b in Regime if a < b]
    assert min(apart) > 0.3
    assert np.linalg.norm(rgb[Regime.CHAOTIC] - rgb[Regime.REST]) > 1.0


# --- cells ------------------------------------------------------------------------------------------------------------

EDGES = np.array([0.0, 1.0, 3.0, 6.0]), np.array([10.0, 20.0, 40.0])


@pytest.mark.parametrize(
    ("values", "borders"),
    [([1.0, 2.0, 4.0], [0.5, 1.5, 3.0, 5.0]), ([3.0], [2.5, 3.5]), ([0.0, 10.0], [-5.0, 5.0, 15.0])],
)
def test_borders_lie_halfway_between_the_values(values, borders):
    np.testing.assert_array_equal(edges(values), borders)


def test_a_cell_has_the_colour_of_its_regime_and_a_blank_one_none():
    axes = blank()
    codes = np.array([[-1, 0, 1], [2, 3, 4]])
    regime_cells(axes, *EDGES, codes)
    mesh = axes.collections[0]
    x, y, values = cells_of(mesh)
    np.testing.assert_array_equal(x, EDGES[0])
    np.testing.assert_array_equal(y, EDGES[1])
    np.testing.assert_array_equal(values, [[np.nan, 0, 1], [2, 3, 4]])
    for kind in Regime:
        assert tuple(mesh.to_rgba([int(kind)])[0][:3]) == pytest.approx(to_rgb(REGIME_COLOURS[kind]))


def test_failed_cells_are_hatched_and_doubtful_ones_dotted_where_they_lie():
    axes = blank()
    marked = np.array([[False, False, True], [True, False, False]])
    mark_failed(axes, *EDGES, marked)
    (hatched,) = axes.collections
    assert isinstance(hatched, PolyCollection)
    np.testing.assert_array_equal(corners(hatched), [[3.0, 6.0, 10.0, 20.0], [0.0, 1.0, 20.0, 40.0]])
    assert [len({tuple(v) for v in path.vertices}) for path in hatched.get_paths()] == [4, 4]
    assert hatched.get_hatch() == "////"
    mark_flagged(axes, *EDGES, marked)
    np.testing.assert_array_equal(data_of(axes.lines[0]), [[4.5, 0.5], [15.0, 30.0]])
    none = blank()
    mark_failed(none, *EDGES, ~marked & False)
    assert not none.collections


@pytest.mark.parametrize(("columns", "size"), [(3, 3.0), (75, 2.0), (400, 1.0)])
def test_dots_shrink_with_the_cells(columns, size):
    axes, flagged = blank(), np.ones((1, columns), dtype=bool)
    mark_flagged(axes, np.arange(columns + 1.0), np.array([0.0, 1.0]), flagged)
    assert axes.lines[0].get_markersize() == size


def test_the_legend_names_what_occurs():
    codes = np.array([int(Regime.REST), int(Regime.CHAOTIC), int(Regime.LEFT_THE_DOMAIN)])
    failed, flagged = np.array([False, False, True]), np.array([False, True, False])
    handles = cell_legend(codes, failed, flagged, 2 * failed)
    labels = [handle.get_label() for handle in handles]
    assert labels == [Regime.REST.label, Regime.CHAOTIC.label, "run failed", "evidence disagrees"]
    assert handles[2].get_hatch() == "////"
    assert [to_rgb(h.get_facecolor()) for h in handles[:3]] == [
        to_rgb(c) for c in (REGIME_COLOURS[0], REGIME_COLOURS[3], GREY)
    ]
    assert isinstance(handles[3], Line2D)
    assert to_rgb(handles[3].get_color()) == to_rgb(BLACK)
    assert all(isinstance(handle, Patch) for handle in handles[:3])
    nothing = np.zeros(3, dtype=bool)
    assert [handle.get_label() for handle in cell_legend(codes[:1], nothing[:1], nothing[:1], 0)] == [Regime.REST.label]


def test_the_legend_says_where_the_model_does_not_hold_but_of_failed_cells_which_have_a_mark_of_their_own():
    nothing, first = np.zeros(3, dtype=bool), np.array([True, False, False])
    labels = [
        [handle.get_label() for handle in invalid_legend(where, failed)]
        for where, failed in ((nothing, nothing), (first, nothing), (first, first), (~first, first), (~nothing, first))
    ]
    veiled = ["model does not hold"]
    assert labels == [[], veiled, [], veiled, ["the model holds\nnowhere here"]]


def test_regimes_of_an_ensemble_with_a_failed_member(tmp_path):
    model = ConeModel(damping_ratio=0.3, stretch_limit=5.0, voltage=[0.5, 1.0, 2.0])
    found = regime(model, [[1.0, 0.0], [1.0, 0.0], [9.0, 0.0]], transient=60.0, budget=100.0)
    figure = regime_figure(found)
    save_figure(figure, tmp_path / "figure.png")
    for said in ("rest", "failed: outside", "largest exponent"):
        assert said in texts(figure)
    in_si = regime_figure(to_si(found, find_device("soft-film")))
    assert (figure.axes[0].get_xlabel(), in_si.axes[0].get_xlabel()) == ("displacement", "displacement (mm)")
