"""Figures of exponents, regimes, bifurcation diagrams, maps and basins: drawn from Datasets alone, failures visible."""

import numpy as np
import pytest
from matplotlib.collections import PolyCollection, QuadMesh
from matplotlib.colors import to_rgb

from gelcone import (
    ConeModel,
    InputError,
    Outcome,
    Plan,
    Regime,
    basin,
    bifurcation,
    find_device,
    lyapunov,
    map,
    regime,
    sweep,
    to_si,
)
from gelcone.plots.basin import SHADES, attractor_colours, basin_figure, shade
from gelcone.plots.bifurcation import bifurcation_figure, refined_edges
from gelcone.plots.lyapunov import lyapunov_figure
from gelcone.plots.map import exponent_bar, exponent_map, map_figure
from gelcone.plots.regime import REGIME_COLOURS, edges, regime_figure
from gelcone.plots.style import save_figure
from gelcone.plots.sweep import sweep_figure
from gelcone.words import attractor_in_words, motion_in_words, with_error

QUICK = {"transient": 60.0, "budget": 100.0}
MODEL = ConeModel(damping_ratio=0.3, stretch_limit=5.0)


@pytest.fixture(scope="module")
def device():
    return find_device("soft-film")


@pytest.fixture(scope="module")
def diagram():
    return bifurcation(MODEL, "voltage", [1.0, 1.5, 2.0], bisections=2, **QUICK)


@pytest.fixture(scope="module")
def cells():
    """A map of 3 by 4 cells, the last row of which starts beyond the stretch limit."""
    return map(MODEL, {"voltage": [0.5, 1.0, 2.0], "prestretch": [0.7, 1.0, 1.3, 2.8]}, **QUICK)


@pytest.fixture(scope="module")
def states():
    """A basin with rest, two cycles that mirror each other, and starts beyond the stretch limit."""
    grid = {"displacement": np.linspace(-2.6, 2.6, 7), "velocity": np.linspace(-1.0, 1.0, 4)}
    return basin(MODEL.replace(voltage=2.0), grid, **QUICK)


@pytest.fixture(scope="module")
def ensembles():
    """An ensemble of which the last member fails, as exponents and as regimes."""
    model = MODEL.replace(voltage=[0.5, 1.0, 2.0])
    initial = [[1.0, 0.0], [1.0, 0.0], [9.0, 0.0]]
    return lyapunov(model, initial, window=30.0, **QUICK), regime(model, initial, **QUICK)


def drawn(figure, tmp_path):
    """Draws and saves a figure, as PNG; the warnings that this may give are errors."""
    save_figure(figure, tmp_path / "figure.png")
    return figure


def texts(figure):
    """Everything that is written in a figure."""
    return " | ".join(t.get_text() for t in figure.findobj(lambda a: hasattr(a, "get_text")) if t.get_text())


# --- in words ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (0.0310, 0.0061, "+0.0310 ± 0.0061"),
        (-0.1, 1e-8, "-0.100000 ± 1e-08"),
        (1234.5, 12.0, "+1234 ± 12"),
        (0.05, 0.5, "+0.05 ± 0.50"),
        (3e-9, 1e-9, "+3.000e-09 ± 1.0e-09"),
        (0.25, 0.0, "+0.25"),
        (np.nan, 1.0, "unknown"),
        (0.25, np.nan, "+0.25"),
    ],
)
def test_a_value_shows_the_digits_that_its_error_leaves(value, error, text):
    assert with_error(value, error) == text


def test_motions_in_words():
    assert motion_in_words(Regime.PERIODIC, 2, True) == "periodic, period 2, symmetric"
    assert motion_in_words(Regime.PERIODIC, 3) == "periodic, period 3"
    assert motion_in_words(Regime.QUASI_PERIODIC) == "quasi-periodic"


# --- colours -----------------------------------------------------------------------------------------------------


def test_every_regime_has_its_own_colour_and_chaos_is_far_from_rest():
    rgb = {kind: np.array(to_rgb(colour)) for kind, colour in REGIME_COLOURS.items()}
    assert set(rgb) == set(Regime)
    apart = [np.linalg.norm(rgb[a] - rgb[b]) for a in Regime for b in Regime if a < b]
    assert min(apart) > 0.3
    assert np.linalg.norm(rgb[Regime.CHAOTIC] - rgb[Regime.REST]) > 1.0


def test_shades_of_a_colour_differ():
    assert shade("#0072B2", 0.0) == "#0072b2"
    assert len({shade("#0072B2", share) for share in SHADES}) == len(SHADES)


# --- exponents and regimes ---------------------------------------------------------------------------------------


def test_exponents_of_an_ensemble_with_a_failed_member(ensembles, device, tmp_path):
    exponents, _ = ensembles
    written = texts(drawn(lyapunov_figure(exponents), tmp_path))
    assert "voltage 0.5" in written
    assert "failed: outside" in written
    assert "per unit time" in written
    in_si = texts(lyapunov_figure(to_si(exponents, device)))
    assert "per second" in in_si
    assert "window length (ms)" in in_si
    assert device.name in in_si


def test_exponents_of_one_run(ensembles, tmp_path):
    figure = drawn(lyapunov_figure(ensembles[0].isel(member=0)), tmp_path)
    low, high = figure.axes[0].get_ylim()
    assert low < 0.0 < high


def test_exponents_when_every_run_failed(ensembles, tmp_path):
    drawn(lyapunov_figure(ensembles[0].isel(member=[2, 2])), tmp_path)


def test_regimes_of_an_ensemble_with_a_failed_member(ensembles, device, tmp_path):
    _, regimes = ensembles
    figure = drawn(regime_figure(regimes), tmp_path)
    written = texts(figure)
    assert "rest" in written
    assert "failed: outside" in written
    assert "largest exponent" in written
    labels = figure.axes[0].get_xlabel(), regime_figure(to_si(regimes, device)).axes[0].get_xlabel()
    assert labels[0] == "displacement"
    assert labels[1] != "displacement"


def test_the_regime_of_one_run_and_one_that_needs_a_second_look(ensembles, tmp_path):
    single = ensembles[1].isel(member=0).copy(deep=True)
    single["doubtful"] = single["doubtful"] * 0 + 1
    assert "does not agree" in texts(drawn(regime_figure(single), tmp_path))


# --- bifurcation diagrams ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("middle", ["exponent", "extent"])
def test_bifurcation_diagram(diagram, middle, tmp_path):
    figure = drawn(bifurcation_figure(diagram, middle), tmp_path)
    written = texts(figure)
    for told in ("up", "down", "from 1,0", "rest", "voltage", "displacement"):
        assert told in written
    assert ("largest exponent" in written) == (middle == "exponent")


def test_up_and_down_sweeps_differ_in_colour_and_marker(diagram):
    legend = bifurcation_figure(diagram).axes[0].get_legend()
    marks = {
        text.get_text(): (line.get_color(), line.get_marker())
        for text, line in zip(legend.get_texts(), legend.legend_handles, strict=True)
    }
    assert marks.keys() == {"up", "down", "from 1,0"}
    assert len({colour for colour, _ in marks.values()}) == 3
    assert len({marker for _, marker in marks.values()}) == 3


def test_the_strip_changes_colour_where_bisection_found_the_threshold(diagram):
    for branch in diagram["branch"].values:
        borders = refined_edges(diagram, str(branch))
        own = diagram["threshold_branch"].values == branch
        middles = 0.5 * (diagram["threshold_low"] + diagram["threshold_high"]).values[own]
        assert middles.size
        assert np.isin(middles, borders).all()
        assert (np.diff(borders) > 0.0).all()


def test_bifurcation_diagram_with_failed_cells_one_branch_and_no_threshold(diagram, tmp_path):
    failed = diagram.sel(branch=["up"]).isel(threshold=slice(0)).copy(deep=True)
    failed["outcome"].values[:, 1] = Outcome.STRETCH_LIMIT
    failed["regime"].values[:, 1] = Regime.LEFT_THE_DOMAIN
    for name in ("section", "lyapunov", "standard_error", "lowest", "highest"):
        failed[name].values[:, 1] = np.nan
    failed["doubtful"].values[:, 2] = 1
    written = texts(drawn(bifurcation_figure(failed), tmp_path))
    assert "a run failed" in written
    assert "run failed" in written
    assert "evidence disagrees" in written
    assert "changes of regime" not in written


def test_bifurcation_diagram_in_si_has_a_second_axis_where_the_parameter_has_a_scale(diagram, device, tmp_path):
    in_si = to_si(diagram, device)
    assert "voltage (V)" not in texts(bifurcation_figure(in_si))
    in_si = in_si.assign_coords(voltage_si=("voltage", 800.0 * in_si["voltage"].values, {"units": "V"}))
    written = texts(drawn(bifurcation_figure(in_si, "extent"), tmp_path))
    assert "voltage (V)" in written
    assert "displacement (mm)" in written


# --- maps --------------------------------------------------------------------------------------------------------


def test_map_shows_failed_cells_and_lines(cells, tmp_path):
    lines = {"onset": ([0.5, 2.0], [0.7, 1.3]), "pitchfork": ([1.0, 1.2], [0.7, 1.3])}
    figure = drawn(map_figure(cells, lines), tmp_path)
    written = texts(figure)
    for told in ("run failed", "onset", "pitchfork", "voltage", "prestretch", "per unit time", "rest"):
        assert told in written
    hatched = [c for axes in figure.axes[:2] for c in axes.collections if isinstance(c, PolyCollection)]
    assert [len(c.get_paths()) for c in hatched if c.get_hatch()] == [3, 3]


def test_the_colours_of_a_map_are_centred_on_zero(cells):
    figure = map_figure(cells)
    mesh = next(c for c in figure.axes[0].collections if isinstance(c, QuadMesh))
    middle = mesh.cmap(mesh.norm(0.0))
    assert min(middle[:3]) > 0.9
    assert mesh.norm.vmin < 0.0 < mesh.norm.vmax


def test_map_in_si_and_without_any_cell_that_ran(cells, device, tmp_path):
    assert "per second" in texts(drawn(map_figure(to_si(cells, device)), tmp_path))
    lost = cells.copy(deep=True)
    lost["outcome"][:] = Outcome.STEP_LIMIT
    lost["lyapunov"][:] = np.nan
    drawn(map_figure(lost), tmp_path / "lost")


def test_map_of_one_parameter_is_refused(cells):
    with pytest.raises(InputError, match=r"two parameters, not 1; draw one with bifurcation_figure"):
        map_figure(cells.isel(voltage=0))


def test_the_first_parameter_lies_along_x(cells):
    from matplotlib.figure import Figure

    axes = Figure().add_subplot()
    mesh = exponent_map(cells, axes)
    assert axes.get_xlabel() == "voltage"
    assert np.ma.getdata(mesh.get_array()).shape == (4, 3)
    np.testing.assert_array_equal(edges([1.0, 2.0, 4.0]), [0.5, 1.5, 3.0, 5.0])


def test_equal_exponents_of_both_signs_have_equal_depth(cells):
    """Also where one side is far smaller: it is seen, and zero is neutral; the bar shows what occurs."""
    from matplotlib.figure import Figure

    low = cells.copy(deep=True)
    low["lyapunov"][..., 0] = np.linspace(-0.01, 0.08, 12).reshape(cells["regime"].shape)
    figure = Figure()
    axes = figure.add_subplot()
    mesh = exponent_map(low, axes)
    exponent_bar(mesh, axes, figure)
    depth = {value: np.asarray(mesh.to_rgba([value]))[0, :3].min() for value in (0.0, 0.01, -0.01, 0.08)}
    assert mesh.norm(0.0) == pytest.approx(0.5)
    assert mesh.norm(0.02) + mesh.norm(-0.02) == pytest.approx(1.0)
    assert depth[0.0] > 0.95
    assert depth[-0.01] == pytest.approx(depth[0.01], abs=0.1)
    assert depth[0.08] < 0.2 < depth[-0.01] < 0.85
    bar = figure.axes[1]
    np.testing.assert_allclose(bar.get_ylim(), (-0.01, 0.08))
    np.testing.assert_allclose(bar.get_yticks(), [-0.01, -0.005, 0.0, 0.005, 0.01, 0.02, 0.05])


# --- basins ------------------------------------------------------------------------------------------------------


def test_basin_names_every_attractor(states, device, tmp_path):
    written = texts(drawn(basin_figure(states), tmp_path))
    assert "run failed" in written
    assert "initial displacement" in written
    for number in range(states.sizes["attractor_number"]):
        assert attractor_in_words(states.isel(attractor_number=number)) in written
    in_si = texts(drawn(basin_figure(to_si(states, device)), tmp_path / "si"))
    assert "initial displacement (mm)" in in_si
    assert "initial velocity (m/s)" in in_si


def test_basin_with_velocity_along_the_first_dim(states, tmp_path):
    drawn(basin_figure(states.transpose("velocity", "displacement", ...)), tmp_path)


def test_mirrored_attractors_have_different_colours(states):
    colours = attractor_colours(states)
    assert len(set(colours)) == len(colours) == states.sizes["attractor_number"] > 1


def test_basin_with_many_attractors_and_with_none(states, tmp_path):
    one = states.isel(attractor_number=0)
    many = states.drop_dims("attractor_number").assign(
        {str(n): v.expand_dims(attractor_number=11) for n, v in one.items() if str(n).startswith("attractor_")}
    )
    assert "3 more attractors" in texts(drawn(basin_figure(many), tmp_path))
    none = states.isel(attractor_number=slice(0)).copy(deep=True)
    none["attractor"][:] = -1
    none["regime"][:] = Regime.TRANSIENT
    assert "transient" in texts(drawn(basin_figure(none), tmp_path / "none"))


def test_an_unstable_rest_is_told(states):
    attractor = states.isel(attractor_number=0).assign(attractor_regime=0, attractor_lyapunov=0.2)
    attractor["attractor_lowest"].values[()] = attractor["attractor_highest"].values[()] = -1e-9
    assert attractor_in_words(attractor).startswith("rest, unstable: ")
    assert attractor_in_words(attractor).endswith("at 0")


def test_a_sweep_of_few_values_has_a_tick_for_each():
    over = {"voltage": [0.0, 0.1, 0.2], "damping_ratio": [0.3, 0.4]}
    cells = sweep(Plan(MODEL, over), "settled")
    bars = [axes for axes in sweep_figure(cells).axes if axes.get_label() == "<colorbar>"]
    values = [float(v) for bar in bars for v in bar.get_yticks() if len(bar.get_yticks()) == 1]
    assert 0.0 in values  # the period: rest everywhere
