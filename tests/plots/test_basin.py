"""Figures of basins: attractors in their colours at their initial states, named by what they are."""

import numpy as np
import pytest
from matplotlib.colors import to_hex, to_rgb

from gelcone import ConeModel, Outcome, Regime, basin, find_device, to_si
from gelcone.plots.basin import (
    OTHERS,
    SHADES,
    attractor_colours,
    attractor_in_words,
    attractor_map,
    basin_figure,
    legend,
)
from gelcone.plots.regime import REGIME_COLOURS
from gelcone.plots.style import save_figure, shade
from tests.plots.made_up import DOUBTFUL, blank, cells_of, corners, data_of, result, texts

X, U = np.array([-1.0, 0.0, 1.0]), np.array([0.0, 2.0])
NUMBER = np.array([[0, 1], [2, 0], [-1, -1]])
KINDS = np.array([[1, 1], [0, 1], [int(Regime.TRANSIENT), int(Regime.LEFT_THE_DOMAIN)]])


def states(count=3, units="1", **changed):
    each, own = ("displacement", "velocity"), "attractor_number"
    kinds = [Regime.PERIODIC, Regime.PERIODIC, Regime.REST, *[Regime.CHAOTIC] * 8][:count]
    values = {
        "attractor": (each, NUMBER),
        "regime": (each, KINDS),
        "outcome": (each, [[0, 0], [0, 0], [0, int(Outcome.OUTSIDE)]]),
        DOUBTFUL: (each, [[0, 1], [0, 0], [1, 1]]),
        "attractor_regime": (own, [int(kind) for kind in kinds]),
        "attractor_period": (own, [2, 1, 1, *[0] * 8][:count]),
        "attractor_share": (own, np.array([0.4, 0.2, 0.1, *[0.05] * 8])[:count]),
        "attractor_lowest": (own, np.array([-1.0, 0.2, 3e-8, *[-2.0] * 8])[:count]),
        "attractor_highest": (own, np.array([0.5, 1.2345, -4e-8, *[2.0] * 8])[:count]),
        "attractor_lyapunov": (own, np.array([-0.1, -0.1, 0.2, *[0.1] * 8])[:count]),
    }
    values |= {name: (values[name][0], value) for name, value in changed.items()}
    coords = {"displacement": ("displacement", X), "velocity": ("velocity", U)}
    return result(values, coords, {"attractor_lowest": units})


def test_each_initial_state_has_the_colour_of_its_attractor():
    axes = blank()
    attractor_map(states(), axes)
    regimes, attractors = axes.collections[:2]
    x, y, values = cells_of(attractors)
    np.testing.assert_array_equal(x, [-1.5, -0.5, 0.5, 1.5])
    np.testing.assert_array_equal(y, [-1.0, 1.0, 3.0])
    np.testing.assert_array_equal(values, np.where(NUMBER < 0, np.nan, NUMBER).T)
    np.testing.assert_array_equal(cells_of(regimes)[2], KINDS.T)
    shown = [to_hex(attractors.to_rgba([number])[0]) for number in range(3)]
    assert shown == [colour.lower() for colour in attractor_colours(states())]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("initial displacement", "initial velocity")


def test_failed_starts_are_hatched_and_doubtful_ones_dotted_but_not_transients():
    axes = blank()
    attractor_map(states(), axes)
    np.testing.assert_array_equal(corners(axes.collections[2]), [[0.5, 1.5, 1.0, 3.0]])
    np.testing.assert_array_equal(data_of(axes.lines[0]), [[-1.0], [2.0]])


def test_colours_are_shades_of_the_regime_and_the_ninth_attractor_has_that_of_the_rest():
    colours = attractor_colours(states())
    blue, sky = REGIME_COLOURS[Regime.PERIODIC].lower(), REGIME_COLOURS[Regime.REST].lower()
    assert colours == [blue, shade(blue, 0.55), sky]
    assert attractor_colours(states(8))[-1] != OTHERS
    many = attractor_colours(states(11))
    assert len(many) == 9
    assert many[-1] == OTHERS
    axes, data = blank(), states(11)
    data["attractor"][0, 0] = 10
    attractor_map(data, axes)
    assert to_hex(axes.collections[1].to_rgba(axes.collections[1].get_array()[0, 0])) == OTHERS.lower()


def test_shades_mix_with_white_above_zero_and_with_black_below():
    assert shade("#0072B2", 0.0) == "#0072b2"
    np.testing.assert_allclose(to_rgb(shade("#000000", 0.5)), 0.5, atol=0.01)
    np.testing.assert_allclose(to_rgb(shade("#FFFFFF", -0.5)), 0.5, atol=0.01)
    np.testing.assert_allclose(to_rgb(shade("#FFFFFF", 0.5)), 1.0)
    assert len({shade("#0072B2", share) for share in SHADES}) == len(SHADES)


@pytest.mark.parametrize(
    ("number", "words"),
    [
        (0, "periodic, period 2: 40 %\nfrom -1 to 0.5 mm"),
        (1, "periodic, period 1: 20 %\nfrom 0.2 to 1.23 mm"),
        (2, "rest, unstable: 10 %\nat 0 mm"),
        (3, "chaotic: 5 %\nfrom -2 to 2 mm"),
    ],
)
def test_an_attractor_is_named_by_what_it_is_where_and_how_often(number, words):
    """Chaos is unstable by itself: only what returns and is unstable says so."""
    assert attractor_in_words(states(4, "mm").isel(attractor_number=number)) == words


def test_a_marginal_rest_is_not_called_unstable():
    still = states(attractor_lyapunov=[-0.1, -0.1, 0.0]).isel(attractor_number=2)
    assert attractor_in_words(still).startswith("rest: ")


def test_the_legend_sums_up_what_has_no_line_of_its_own():
    labels = [handle.get_label() for handle in legend(states(11))]
    assert labels[8] == "3 more attractors: 15 %"
    assert labels[9:] == [handle.get_label() for handle in legend(states(3))][3:]
    assert len(legend(states(8))) == 8 + 3


def test_the_legend_of_a_basin_names_transients_failures_and_doubt():
    labels = [handle.get_label() for handle in legend(states())][3:]
    assert labels == [Regime.TRANSIENT.label, "run failed", "evidence disagrees"]
    faces = [handle.get_facecolor()[:3] for handle in legend(states())[:3]]
    assert faces == [to_rgb(colour) for colour in attractor_colours(states())]


def test_a_computed_basin_is_drawn_whatever_the_order_of_its_dims(tmp_path):
    grid = {"displacement": np.linspace(-2.6, 2.6, 5), "velocity": [-1.0, 0.0, 1.0]}
    found = basin(ConeModel(damping_ratio=0.3, stretch_limit=5.0, voltage=2.0), grid, transient=60.0, budget=100.0)
    figure = basin_figure(found.transpose("velocity", "displacement", ...))
    save_figure(figure, tmp_path / "basin.png")
    np.testing.assert_array_equal(
        cells_of(figure.axes[0].collections[1])[2], np.where(found["attractor"] < 0, np.nan, found["attractor"]).T
    )
    in_si = texts(basin_figure(to_si(found, find_device("soft-film"))))
    for said in ("initial displacement (mm)", "initial velocity (m/s)", "run failed"):
        assert said in in_si
    colours = attractor_colours(found)
    assert len(set(colours)) == len(colours) == found.sizes["attractor_number"] > 1
    none = found.isel(attractor_number=slice(0)).copy(deep=True)
    none["attractor"][:], none["regime"][:] = -1, Regime.TRANSIENT
    assert "transient" in texts(basin_figure(none))
