"""Figures of sweeps: a probability with its interval, or variables over the first axes."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

import numpy as np

from gelcone.amounts import missing, unit_of
from gelcone.atlas.tolerances import base_draws
from gelcone.codes import Regime
from gelcone.errors import InputError
from gelcone.plots.regime import cell_legend, edges, mark_failed
from gelcone.plots.style import BLUE, CYCLE, GREY, axis_label, coordinate_axis, name_axes, say, styled
from gelcone.plots.values import values_figure
from gelcone.words import evenly

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from gelcone.plots.map import Lines

WIDEST = 6
"""Most variables drawn, and most slices."""
FEW = 6
"""Most distinct whole numbers, such as periods, that each get a tick on the colour bar."""
_BOOKKEEPING = ("status", "source", "outcome")


def probability_figure(result: xr.Dataset) -> Figure:
    """A probability with its interval over one parameter, or over two next to the width of the interval."""
    if result["probability"].ndim == 1:
        return styled(5.2, 3.2, lambda figure: _curve(result, figure.add_subplot()))
    if result["probability"].ndim != 2:
        raise InputError("a probability is drawn over one parameter or two; take a slice of the others")

    def draw(figure: Figure) -> None:
        left, right = figure.subplots(1, 2, sharex=True, sharey=True)
        _cells(result["probability"], left, "cividis", 1.0)
        _cells((result["high"] - result["low"]).assign_attrs(long_name="width of the interval"), right, "Greys")
        right.set_ylabel("")

    return styled(7.2, 3.1, draw)


def _curve(result: xr.Dataset, axes: Axes) -> None:
    (name,) = map(str, result["probability"].dims)
    axes.fill_between(result[name], result["low"], result["high"], color=BLUE, alpha=0.25, lw=0.0, label="interval")
    axes.plot(result[name], result["probability"], color=BLUE, marker="o", ms=2.5, lw=1.2, label="share of the draws")
    axes.set_ylim(-0.03, 1.03)
    axes.set_ylabel(str(result["probability"].attrs["long_name"]))
    coordinate_axis(axes.xaxis, result, name)
    axes.legend(loc="best")


def _cells(values: xr.DataArray, axes: Axes, colours: str, most: float | None = None) -> None:
    across, up = (values[dim] for dim in values.dims)
    mesh = axes.pcolormesh(edges(across), edges(up), values.T, cmap=colours, rasterized=True)
    if most:
        mesh.set_clim(0.0, most)
    bar = axes.figure.colorbar(mesh, ax=axes, pad=0.02)
    there = np.unique(values.values[np.isfinite(values.values)])
    if there.size <= FEW and np.array_equal(there, np.round(there)):
        bar.set_ticks(there.tolist())
    axes.set_title(str(values.attrs["long_name"]), loc="left")
    name_axes(axes, across, up)


def sweep_figure(result: xr.Dataset) -> Figure:
    """The variables of a sweep: maps over two axes, curves over one, densities of draws, slices of three axes."""
    if "status" not in result:  # computed at once, not cell by cell
        return values_figure(result)
    if result["status"].dims == ("draw",):
        result = base_draws(result)
    dims, there = result["status"].dims, result["status"] > 0
    along = str(dims[0])
    numbers = {str(n): v for n, v in result.data_vars.items() if v.dims == dims and not _is_code(str(n), v)}
    full = {name: values.where(there) for name, values in numbers.items()}
    shown = dict([(name, values) for name, values in full.items() if np.isfinite(values).any()][:WIDEST])
    if not shown:
        infinite = [name for name, values in full.items() if np.isinf(values).any()]
        lost = [f"{name.replace('_', ' ')}: {_absent(numbers[name][there], along)}" for name in infinite]
        return styled(5.6, 2.0, lambda figure: _say_alone(figure, "\n".join(lost) or "no cell has a number"), result)
    if _unordered(result):
        return _by_gel(shown, result)
    if len(dims) == 2 and all(dim in result.coords for dim in dims):
        return _maps(shown, result)
    if len(dims) == 3 and all(dim in result.coords for dim in dims):
        return _slices(result, next(iter(shown.values())))
    if dims == ("draw",):
        return _densities(shown, result)

    def draw(figure: Figure) -> None:
        panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (name, variable) in zip(panels, shown.items(), strict=True):
            values = variable.values.reshape(result.sizes[along], -1)
            positions = result[along].values if along in result.coords else np.arange(result.sizes[along])
            axes.plot(positions, values, color=BLUE, ls="-" if values.shape[1] == 1 else "", marker=".", ms=2.5, lw=1.0)
            axes.set_ylabel(axis_label(result[name], name))
        coordinate_axis(panels[-1].xaxis, result, along)

    return styled(5.6, 0.8 + 1.5 * len(shown), draw)


def _unordered(result: xr.Dataset) -> list[str]:
    """Axes of names, such as gels."""
    return [str(dim) for dim in result["status"].dims if dim in result.coords and result[dim].dtype.kind in "OU"]


def _by_gel(shown: dict[str, xr.DataArray], result: xr.Dataset) -> Figure:
    """The variables over the one ordered axis, a line per gel; or one point per gel."""
    (gels,) = _unordered(result)
    others = [str(dim) for dim in result["status"].dims if dim != gels]
    if len(others) > 1:
        raise InputError(
            f"a sweep over gels is drawn over one more parameter, not over {', '.join(others)}; take a slice"
        )

    def draw(figure: Figure) -> None:
        panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
        for axes, (name, values) in zip(panels, shown.items(), strict=True):
            axes.set_ylabel(axis_label(result[name], name), fontsize=8.0)
            if not others:
                axes.plot(np.arange(values.size), values, "o", color=BLUE, ms=4.0)
                axes.set_xticks(np.arange(values.size), [str(gel) for gel in result[gels].values])
                axes.set_xlim(-0.5, values.size - 0.5)
                continue
            for k, gel in enumerate(result[gels].values):
                curve = values.sel({gels: gel})
                axes.plot(result[others[0]], curve, color=CYCLE[k % len(CYCLE)], marker=".", ms=3.0, label=str(gel))
        if others:
            coordinate_axis(panels[-1].xaxis, result, others[0])
            panels[0].legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))

    return styled(5.6, 0.8 + 1.3 * len(shown), draw, result)


def _densities(shown: dict[str, xr.DataArray], result: xr.Dataset) -> Figure:
    from gelcone.plots.tolerances import density

    there = result["status"] > 0

    def draw(figure: Figure) -> None:
        panels = figure.subplots(len(shown), 1, squeeze=False)[:, 0]
        for axes, (name, values) in zip(panels, shown.items(), strict=True):
            density(axes, values.values)
            axes.set_xlabel(axis_label(result[name], name))
            axes.set_title(_absent(result[name][there], "draw"), loc="left", fontsize=8.0)

    return styled(5.6, 0.8 + 1.5 * len(shown), draw, result)


def _say_alone(figure: Figure, words: str) -> None:
    axes = figure.add_subplot()
    axes.set_axis_off()
    say(axes, words)


def _absent(values: xr.DataArray, along: str) -> str:
    """The number of draws or cells without a value, with the reason; empty if all have one."""
    numbers, of = np.ravel(values.values), "draws" if along == "draw" else "cells"
    counts = Counter(missing(float(value), values) for value in numbers[~np.isfinite(numbers)])
    return ", ".join(f"{words} in {count} of {numbers.size} {of}" for words, count in counts.items())


def _is_code(name: str, variable: xr.DataArray) -> bool:
    """Whether a variable is not a number to draw: codes, bookkeeping, validity."""
    coded = variable.attrs.get("quantity") in ("code", "flag") and "regime" not in name and name != "sign"
    return name in _BOOKKEEPING or name.startswith("validity_") or coded


def _slices(result: xr.Dataset, values: xr.DataArray) -> Figure:
    """Maps over the first two axes at up to `WIDEST` values of the third: of the regime, or else of a number."""
    from gelcone.plots.map import legend, regime_map

    x, y, third = map(str, result["status"].dims)
    picks = evenly(result.sizes[third], WIDEST)
    columns = 2 if picks.size in (2, 4) else min(3, picks.size)
    rows = -(-picks.size // columns)
    some = f"{picks.size} of {result.sizes[third]} values of {third.replace('_', ' ')}"

    def draw(figure: Figure) -> None:
        panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True).ravel()
        for axes, pick in zip(panels, picks, strict=False):
            one = result.isel({third: int(pick)})
            if "regime" in one:
                regime_map(one, axes)
            else:
                _cells(values.isel({third: int(pick)}), axes, "viridis")
            place = one[third]
            axes.set_title(f"{third.replace('_', ' ')} {float(place):.4g}{unit_of(place)}", loc="left", fontsize=8.0)
        for axes in panels:
            axes.label_outer()
        for axes in panels[picks.size :]:
            axes.remove()
        if "regime" in result:
            shown = result.isel({third: picks}).stack(flat=(y, third)).transpose("flat", x, ...)
            figure.legend(handles=legend(shown), loc="outside right upper")

    return styled(7.2, 0.5 + 2.2 * rows, draw, result, some if picks.size < result.sizes[third] else "")


def _maps(shown: dict[str, xr.DataArray], result: xr.Dataset) -> Figure:
    from matplotlib.patches import Patch

    rows, failed = -(-len(shown) // 2), result["outcome"] > 0

    def draw(figure: Figure) -> None:
        panels = figure.subplots(rows, 2, squeeze=False).ravel()
        handles = cell_legend(np.full(failed.shape, len(Regime)), failed.values, np.zeros(1), result["outcome"])
        for axes, (name, values) in zip(panels, shown.items(), strict=False):
            _cells(values.where(np.isfinite(values)), axes, "viridis")
            x, y = map(str, values.dims)
            mark_failed(axes, edges(result[x]), edges(result[y]), failed.transpose(y, x).values)
            blank = bool((values.isnull() & ~failed).any())
            axes.set_title(axis_label(result[name], name), loc="left")
            handles += [Patch(facecolor="white", edgecolor=GREY, lw=0.6, label="white: no value")] if blank else []
        for axes in panels[len(shown) :]:
            axes.remove()
        if handles:
            named = {handle.get_label(): handle for handle in handles}
            figure.legend(handles=list(named.values()), loc="outside lower center", ncols=3)

    return styled(7.2, 0.4 + 2.5 * rows + 0.3, draw)


def any_figure(cells: xr.Dataset, lines: Lines | None = None, colour: str = "exponent") -> Figure:
    """The figure of a sweep: a probability, a map with the options of `map_figure`, or `sweep_figure`."""
    if "regime" in cells and "draw" in cells.dims and cells["regime"].ndim <= 3:
        from gelcone.atlas.probability import probability
        from gelcone.plots.tolerances import tolerances_figure

        if cells["regime"].ndim < 3:
            return tolerances_figure(cells)
        return probability_figure(probability(base_draws(cells)))
    if "regime" in cells and cells["regime"].ndim == 2 and not _unordered(cells):
        from gelcone.plots.map import map_figure

        return map_figure(cells, lines, colour)
    return sweep_figure(cells)
