"""Figure 8 on made-up spectra: both spectra over the frequency, without the mean."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from gelcone.codes import Regime
from gelcone.paper.figures import FIGURES
from gelcone.paper.figures.spectra import SEEN, both_spectra
from gelcone.plots.regime import REGIME_COLOURS
from tests.plots.made_up import data_of

RATIO, EARLY = np.array([0.0, 0.5, 1.0, 1.5]), np.array([0.0, 1.0, 2.0])


def spectra():
    each = ("set", "voltage")
    return xr.Dataset(
        {
            "amplitude": ((*each, "frequency"), np.broadcast_to([9.0, 0.1, 0.0, 0.3], (2, 3, 4))),
            "early_amplitude": ((*each, "early_frequency"), np.broadcast_to([8.0, 0.5, 0.25], (2, 3, 3))),
            "frequency_ratio": ("frequency", RATIO),
            "early_frequency_ratio": ("early_frequency", EARLY),
            "regime": (each, [[int(Regime.REST), int(Regime.PERIODIC), int(Regime.CHAOTIC)]] * 2),
            "period": (each, [[1, 2, 0]] * 2),
        },
        coords={"set": ["base", "fast"], "voltage": [0.5, 1.04, 1.7]},
    )


@pytest.mark.parametrize(("index", "kind"), [(0, Regime.REST), (1, Regime.PERIODIC), (2, Regime.CHAOTIC)])
def test_a_panel_has_the_early_spectrum_in_grey_and_the_late_one_in_the_colour_of_its_motion(index, kind):
    axes = Figure().add_subplot()
    both_spectra(spectra().isel(set=0, voltage=index), axes)
    voltage, force, early, late = axes.lines
    assert (voltage.get_xdata(), force.get_xdata()) == ([1.0, 1.0], [2.0, 2.0])
    assert (voltage.get_linestyle(), force.get_linestyle()) == (":", "--")
    np.testing.assert_array_equal(data_of(early), [[1.0, 2.0], [0.5, 0.25]])
    np.testing.assert_array_equal(data_of(late), [[0.5, 1.5], [0.1, 0.3]])
    assert late.get_color() == REGIME_COLOURS[kind]
    assert bool(axes.texts) == (kind is Regime.REST)
    assert axes.get_yscale() == "log"
    assert axes.get_ylim() == (1e-7, 20.0)


def test_figure_8_has_a_row_for_each_voltage_and_a_column_for_each_set():
    figure = FIGURES[8].draw({"spectra": spectra()})
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles == [f"set {name}, $v$ = {v:g}" for v in (0.5, 1.04, 1.7) for name in ("base", "fast")]
    assert figure.axes[2].get_title(loc="right") == "long run: periodic, period 2"
    assert [axes.get_xlim()[1] for axes in figure.axes[:2]] == [SEEN["base"], SEEN["fast"]]
    assert [bool(axes.get_xlabel()) for axes in figure.axes] == [False] * 4 + [True] * 2
    assert [bool(axes.get_ylabel()) for axes in figure.axes] == [True, False] * 3
