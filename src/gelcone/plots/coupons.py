"""Figure of a material fit: measured stress of each test, fitted stress, and the prediction from the other tests."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.plots.style import BLACK, BLUE, GREY, SKY, VERMILION, styled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS, MOST_PANELS = 4, 24


def coupon_figure(result: xr.Dataset) -> Figure:
    """A panel for each test that is used: measured and fitted stress, and the band of the prediction."""
    shown = [k for k in range(result.sizes["test"]) if str(result["test_use"].values[k]) != "leave out"][:MOST_PANELS]
    columns = min(COLUMNS, len(shown))
    rows = -(-len(shown) // columns)

    def draw(figure: Figure) -> None:
        panels = figure.subplots(rows, columns, squeeze=False).ravel()
        for axes, k in zip(panels, shown, strict=False):
            draw_test(result, k, axes)
        for axes in panels[len(shown) :]:
            axes.set_visible(False)
        for axes in panels[::columns]:
            axes.set_ylabel("stress (kPa)")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
        law, count = result.attrs["chosen_law"], result.attrs["chosen_branches"]
        figure.suptitle(f"{result.attrs['title']}, {law} with {count} branches", fontsize=9.0)

    return styled(1.0 + 1.75 * columns, 0.9 + 1.6 * rows, draw)


def draw_test(result: xr.Dataset, k: int, axes: Axes) -> None:
    """One test over stretch, or over time for relaxation and creep: measured stress (dots), fitted stress (line),
    prediction from the other tests (dashed) with its band."""
    samples = result.isel(sample=np.flatnonzero(result["sample_test"].values == k))
    over_time = str(result["test_kind"].values[k]) in ("relaxation", "creep")
    x = samples["time"].values / 3600.0 if over_time else samples["stretch"].values
    axes.plot(x, samples["stress"], ".", color=BLACK, ms=3.0, label="measured", zorder=3)
    axes.plot(x, samples["predicted"], color=BLUE, label="material")
    left_out = samples["left_out"].values
    band = float(result.attrs["band"]) * float(result["largest_stress"][k])
    axes.plot(x, left_out, "--", color=VERMILION, lw=0.9, label="predicted from the other tests")
    centre = left_out if np.isfinite(left_out).all() else samples["predicted"].values
    if np.isfinite(band) and np.isfinite(centre).all():
        parts = _pieces(x)
        for j, part in enumerate(parts):
            axes.fill_between(
                x[part], centre[part] - band, centre[part] + band, color=SKY, alpha=0.25, lw=0,
                label="95 % band of a prediction" if j == 0 else None,
            )  # fmt: skip
    axes.axhline(0.0, color=GREY, lw=0.5)
    axes.set_title(f"{result['test_name'].values[k]}: {100.0 * float(result['error'][k]):.1f} %", fontsize=6.5)
    axes.set_xlabel("time (h)" if over_time else "stretch", fontsize=7.0)
    axes.tick_params(labelsize=7.0)


def _pieces(x: np.ndarray) -> list[slice]:
    """Ranges of samples along which x only rises or only falls, for bands."""
    turn = int(np.argmax(x))
    return [slice(0, turn + 1), slice(turn, x.size)] if 0 < turn < x.size - 1 else [slice(0, x.size)]
