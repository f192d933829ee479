"""Figure of transfer functions: a Bode plot of displacement and current, from linear theory and simulation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.amounts import measured
from gelcone.plots.style import BLACK, CYCLE, GREY, axis_label, log_ticks, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def transfer_figure(result: xr.Dataset) -> Figure:
    """Gain and phase of the displacement (left) and of the current (right): linear theory as lines, simulation as
    markers."""

    def draw(figure: Figure) -> None:
        axes: Any = figure.subplots(2, 2, sharex=True, height_ratios=[1.5, 1.0])
        frequency = result["drive_frequency"]
        for column, gain, words, phase in (
            (0, "gain", "displacement over voltage", "phase"),
            (1, "admittance", "current over voltage", "admittance_phase"),
        ):
            for panel, name, meaning in zip(axes[:, column], (gain, phase), (words, "phase"), strict=True):
                panel.plot(frequency, _shown(result[name]), color=BLACK, label="linear theory")
                for k in range(result.sizes["amplitude"]):
                    simulated = result.isel(amplitude=k)
                    look: dict[str, Any] = {"color": CYCLE[k % len(CYCLE)], "ls": "none", "marker": ".o^s"[k % 4]}
                    label = f"simulated, {measured(simulated['amplitude'])}"
                    shown = _shown(simulated[f"measured_{name}"])
                    panel.plot(result["measured_frequency"], shown, ms=4.0, mfc="none", label=label, **look)
                panel.axvline(float(result["natural_frequency"]), color=GREY, lw=0.6, ls="--")
                panel.set_ylabel(axis_label(result[name], meaning))
            if (result[gain] > 0.0).any():
                axes[0, column].set_yscale("log")
        for panel in axes[1]:
            log_ticks(panel)
            if frequency.size > 1:
                panel.set_xlim(float(frequency.min()), float(frequency.max()))
            panel.set_xlabel(axis_label(frequency, "drive frequency"))
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=3)

    return styled(7.0, 4.4, draw, result)


def _shown(values: xr.DataArray) -> Any:
    """The values; phases unwrapped."""
    if not str(values.name).endswith("phase"):
        return values.values
    is_known = np.isfinite(values.values)
    unwrapped = values.values.copy()
    unwrapped[is_known] = np.degrees(np.unwrap(np.radians(unwrapped[is_known])))
    return unwrapped
