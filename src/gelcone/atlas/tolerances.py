"""Tolerances: risks, quantiles of the stroke and Sobol indices from draws of uncertain parameters."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.atlas.probability import UNDECIDED, check_draws
from gelcone.codes import Outcome, Regime
from gelcone.quantity import Array
from gelcone.statistics import CONFIDENCE, share_interval

if TYPE_CHECKING:
    import xarray as xr

RISKS = ("pull-in", "breakdown", "chaos")
QUANTILES = (0.05, 0.5, 0.95)
RESAMPLES = 400
"""Bootstrapped samples behind the ends of Sobol indices (Archer et al., J. Stat. Comput. Simul. 58 (1997) 99)."""
AT_ONCE = 2**20
"""Strokes of all samples in memory at a time."""
Kinds = npt.NDArray[np.bool_]


def tolerances(cells: xr.Dataset) -> xr.Dataset:
    """Report risks, quantiles of the stroke and sensitivities at every point of a grid, by the draws made there.

    Parameters
    ----------
    cells : what `gelcone.sweep` gives of a plan with draws and the analysis ``"regime"``.

    Returns
    -------
    Dataset over the grid: over ``risk`` (``pull-in``, ``breakdown`` - the field exceeds the dielectric strength at some
    time - and ``chaos``) ``probability``, the share of the ``decided`` draws, with the ends ``low`` and ``high`` of its
    95 % interval (Clopper and Pearson, Biometrika 26 (1934) 404); over ``quantile`` ``stroke``, peak to peak, of the
    draws that have a long run, with ``stroke_low`` and ``stroke_high`` (by ranks, which needs no distribution); for
    draws that `gelcone.draw` arranged for it, over ``parameter`` and ``end`` the Sobol indices of the stroke,
    ``first_order`` and ``total_order`` (Saltelli et al., Comput. Phys. Commun. 181 (2010) 259), with bootstrapped ends.
    NaN: not known, as the indices where a draw has no stroke or all have the same one.

    Raises
    ------
    InputError : for a sweep without draws or regimes.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
    >>> draws = gelcone.draw({"damping_ratio": gelcone.Uniform(0.05, 0.1)}, 4)
    >>> cells = gelcone.sweep(gelcone.Plan(model, {"drive_frequency": [0.6, 0.8]}, draws=draws))
    >>> gelcone.tolerances(cells).probability.sel(risk="chaos").values.tolist()
    [0.0, 0.0]
    """
    check_draws("tolerances", cells)
    drawn = {str(name).removeprefix("drawn_"): cells[name].values for name in cells.coords if "drawn_" in str(name)}
    dims = [str(dim) for dim in cells["regime"].dims if dim != "draw"]
    base = base_draws(cells)
    hits, decided = _risks(base.transpose(*dims, "draw", ...))
    count, total = hits.sum(axis=-1), decided.sum(axis=-1)
    low, high = share_interval(count, total)
    at = (*dims, "risk")
    table: dataset.Table = {
        "probability": (np.where(total > 0, count / np.maximum(total, 1), np.nan), "probability of the event", "share"),
        "low": (low, "lower end of the 95 % interval of the probability", "share"),
        "high": (high, "upper end of the 95 % interval of the probability", "share"),
        "decided": (total, "draws that are decided", "count"),
    }
    strokes = strokes_of(cells).transpose(*dims, "draw")
    quantiles = _over_grid(stroke_quantiles, strokes_of(base).transpose(*dims, "draw").values, (3, len(QUANTILES)))
    of = dict(strokes.attrs)
    named = ("stroke", "stroke_low", "stroke_high")
    ends = (f"{end} end of the 95 % interval of the stroke" for end in ("lower", "upper"))
    meanings = ("stroke, peak to peak", *ends)
    errors = dataset.film_errors_of(cells)
    result = dataset.label(dataset.model_of(cells), {}, options={}, title="tolerances", errors=errors)
    result = result.assign(dataset.columns(at, table)).assign(
        {
            name: ((*dims, "quantile"), quantiles[..., k, :], of | {"long_name": meaning})
            for k, (name, meaning) in enumerate(zip(named, meanings, strict=True))
        }
    )
    if arranged(drawn):
        indices = _over_grid(lambda row: sobol(row, len(drawn)), strokes.values, (2, len(drawn), 3))
        for k, name in enumerate(("first_order", "total_order")):
            described = dataset.attributes(f"{name.replace('_', '-')} Sobol index of the stroke", "share")
            result[name] = ((*dims, "parameter", "end"), indices[..., k, :, :], described)
        result = result.assign_coords(_named("parameter", drawn, "uncertain parameter"))
        result = result.assign_coords(_named("end", ["value", "low", "high"], "the index, or an end of its interval"))
    coords: dict[str, Any] = {dim: cells[dim] for dim in dims if dim in cells.coords}
    return result.assign_coords(
        coords | _named("risk", RISKS, "what may happen") | _named("quantile", QUANTILES, "share of the draws below")
    )


def _named(dim: str, values: Iterable[Any], meaning: str) -> dict[str, Any]:
    """A coordinate along a dim of its own name."""
    entries = list(values)
    return {dim: (dim, entries, dataset.attributes(meaning, "share" if isinstance(entries[0], float) else "code"))}


def base_draws(cells: xr.Dataset) -> xr.Dataset:
    """The independent draws of a sweep, without those that serve only for Sobol indices."""
    drawn = {str(name): cells[name].values for name in cells.coords if str(name).startswith("drawn_")}
    count = arranged(drawn)
    return cells.isel(draw=slice(2 * count)) if count else cells


def arranged(drawn: Mapping[str, Array]) -> int:
    """The rows of each block of draws that are arranged for Sobol indices; 0 for draws that are not.

    The blocks are A, B, and for each parameter A with that parameter from B.
    """
    table = np.array(list(drawn.values()))
    blocks = len(table) + 2
    count, left = divmod(table.shape[-1], blocks) if table.size else (0, 1)
    if left or len(table) < 2:
        return 0
    first, second, *mixed = np.split(table, blocks, axis=1)
    expected = [np.where(np.arange(len(table))[:, None] == k, second, first) for k in range(len(table))]
    return count if all(np.array_equal(*pair) for pair in zip(mixed, expected, strict=True)) else 0


def _risks(own: xr.Dataset) -> tuple[Kinds, Kinds]:
    """Masks of the draws that meet each risk, and of those for which it is known, (grid..., risk, draws)."""
    outcome, regime = own["outcome"].values, own["regime"].values
    decided = ~np.isin(outcome, UNDECIDED) & (regime >= 0)
    field = own["validity_breakdown"].values if "validity_breakdown" in own else np.full(outcome.shape, np.nan)
    pulled = outcome == Outcome.PULLED_IN
    hits = [pulled, field > 0.0, regime == Regime.CHAOTIC]
    known = [decided, decided & np.isfinite(field), decided & (regime != Regime.TRANSIENT)]
    return np.stack(hits, axis=-2) & np.stack(known, axis=-2), np.stack(known, axis=-2)


def strokes_of(cells: xr.Dataset) -> xr.DataArray:
    """Stroke peak to peak of every draw, 0 at rest; NaN for one without a long run."""
    stroke = (cells["highest"] - cells["lowest"]).where(cells["regime"] != Regime.REST, 0.0)
    strokes: xr.DataArray = stroke.where(cells["outcome"] == Outcome.OK)
    return strokes.assign_attrs(cells["highest"].attrs)


def _over_grid(function: Any, values: Array, shape: tuple[int, ...]) -> Array:
    """A function of the draws at every point of the grid, (grid..., *shape)."""
    flat = values.reshape(-1, values.shape[-1])
    return np.array([function(row) for row in flat]).reshape((*values.shape[:-1], *shape))


def stroke_quantiles(strokes: Array) -> Array:
    """Quantiles of finite numbers and the ends of their intervals, (3, quantiles); NaN for fewer than two numbers."""
    from scipy.stats import quantile_test

    there = strokes[np.isfinite(strokes)]
    if there.size < 2:
        return np.full((3, len(QUANTILES)), np.nan)
    ends = [quantile_test(there, p=p).confidence_interval(CONFIDENCE) for p in QUANTILES]
    # with few draws an end lies beyond all of them, at an unknown value
    return np.array([np.quantile(there, QUANTILES), [e.low for e in ends], [e.high for e in ends]])


def sobol(strokes: Array, parameters: int) -> Array:
    """First-order and total indices of arranged draws with their ends, (2, parameters, 3); NaN where there are none."""
    from scipy.stats import sobol_indices

    if not np.isfinite(strokes).all() or np.ptp(strokes) <= 1e-9 * np.abs(strokes).max():
        return np.full((2, parameters, 3), np.nan)
    blocks = strokes.reshape(parameters + 2, -1)
    count, rng = blocks.shape[1], np.random.default_rng(0)

    def indices(rows: Any) -> Array:
        """First-order and total indices (2, parameters, samples) of samples (samples, draws)."""
        first, second, *mixed = blocks[:, rows]
        outputs = {"f_A": first, "f_B": second, "f_AB": np.array(mixed)}
        with np.errstate(invalid="ignore", divide="ignore"):  # samples of equal strokes have no variance
            orders = sobol_indices(func=outputs, n=count)
        return np.stack([np.atleast_2d(orders.first_order).T, np.atleast_2d(orders.total_order).T])

    parts, left = [], RESAMPLES
    while left:
        size = min(left, max(1, AT_ONCE // strokes.size))
        parts.append(indices(rng.integers(count, size=(size, count))))
        left -= size
    tail = 50.0 * (1.0 - CONFIDENCE)
    ends = np.nanpercentile(np.concatenate(parts, axis=-1), [tail, 100.0 - tail], axis=-1)
    return np.stack([indices(np.arange(count)[None])[..., 0], *ends], axis=-1)
