"""Answers about many cells: bifurcation diagrams, maps, sweeps, stores and basins of attraction."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone.amounts import measured, missing, rate_unit, sized, sized_range, unit_of, with_error
from gelcone.analyses.answer import (
    counts_text,
    doubt_lines,
    first,
    grid_text,
    heading,
    outcome_lines,
    result_json,
)
from gelcone.analyses.branches import followed_lines
from gelcone.analyses.swept import example, read_states
from gelcone.analyses.tables import FILM_STATES
from gelcone.codes import Outcome
from gelcone.errors import InputError
from gelcone.statistics import share_interval, spread
from gelcone.words import attractor_in_words, regime_counts, shortened, validity_in_words

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.analyses.request import Subject


# --- bifurcation diagrams ---------------------------------------------------------------------------------------------


def bifurcation_arguments(subject: Subject, given: dict[str, Any]) -> dict[str, Any]:
    """The arguments of `gelcone.bifurcation`."""
    swept = subject.over(given.pop("over", ()))
    if len(swept) != 1:
        one = example(subject.device, "voltage" if subject.device is None else "voltage_amplitude")
        other = "two make a `gelcone map`" if len(swept) == 2 else f"for example {one}"
        raise InputError(f"--over: a bifurcation diagram takes one parameter, not {len(swept)}; {other}")
    ((name, values),) = swept.items()
    if "sweeps" in given:
        given["sweeps"] = read_sweeps(given["sweeps"])
    return {"parameter": name, "values": values, **given}


def read_sweeps(text: str) -> list[str]:
    """``up,down``, one of them, or ``none``."""
    sweeps = [part.strip() for part in text.split(",")]
    if sweeps == ["none"]:
        return []
    if not set(sweeps) <= {"up", "down"} or len(set(sweeps)) < len(sweeps):
        raise InputError(f"--sweeps {text!r}: must be up, down, up,down or none")
    return sweeps


ONE_PATH = "  of one path: another, as one from a start 1e-12 away, may have another range"
"""Line about ranges of changes of regime that depend on the run."""


def bifurcation_words(shown: xr.Dataset, subject: Subject) -> str:
    """A bifurcation diagram as text."""
    name = shown.attrs["parameter"]
    lines = [*heading(subject, [name]), grid_text(shown, [name]), *outcome_lines(shown)]
    for branch in shown["branch"].values:
        sweep = shown.sel(branch=branch)
        lines.append(f"  {branch}: {counts_text(sweep)}")
        lines += [f"    {line}" for line in validity_in_words(sweep)]
    closing_lines = [*doubt_lines(shown), *_threshold_lines(shown), *followed_lines(shown)]
    return "\n".join([*lines, *closing_lines])


def _threshold_lines(shown: xr.Dataset) -> list[str]:
    """List the changes of the regime, each with its branch and the regimes on both sides."""
    from gelcone.atlas.bifurcation import thresholds_of

    name = shown.attrs["parameter"]
    unit = unit_of(shown["threshold_low"])
    lines = []
    found = thresholds_of(shown)
    for row in found:
        at = f"{name} {row['low']:.6g} to {row['high']:.6g}{unit}"
        how = ", by a cascade of period doublings" if row["cascade"] else ""
        once = ", of one path" if row["of_one_path"] else ""
        lines.append(f"  {row['branch']}: {row['from']} -> {row['to']} at {at}{how}{once}")
    more = [ONE_PATH] if any(row["of_one_path"] for row in found) else []
    return ["changes of regime:" if lines else "no change of regime", *shortened(lines), *more]


# --- maps -------------------------------------------------------------------------------------------------------------


def map_words(shown: xr.Dataset, subject: Subject) -> str:
    """A map as text."""
    lines = [*heading(subject, shown["regime"].dims), grid_text(shown, shown["regime"].dims), *outcome_lines(shown)]
    chaotic = regime_counts(shown).get("chaotic", 0) / shown["regime"].size
    lines.append(f"{counts_text(shown)} ({100.0 * chaotic:.3g} % chaotic)")
    lines.append(totals_text(_totals(shown)))
    return "\n".join([*lines, *_exponent_lines(shown), *doubt_lines(shown), *validity_in_words(shown)])


def _exponent_lines(shown: xr.Dataset) -> list[str]:
    """The highest and the lowest of the largest exponents, and where they are; one value where they differ by less than
    their errors."""
    exponent = first(shown["lyapunov"])
    if not exponent.notnull().any():
        return []
    cells = {"highest": shown.isel(exponent.argmax(...)), "lowest": shown.isel(exponent.argmin(...))}
    values, errors = ([float(first(cell[name])) for cell in cells.values()] for name in ("lyapunov", "standard_error"))
    named = [f"{with_error(*estimate)} {rate_unit(exponent)}" for estimate in zip(values, errors, strict=True)]
    if values[0] - values[1] <= sum(errors) or values[0] == values[1]:
        return [f"exponent {named[0]} {'everywhere' if exponent.notnull().all() else 'wherever it is known'}"]
    return [
        f"{word} exponent {value} at {', '.join(_place(cell, exponent.dims))}"
        for (word, cell), value in zip(cells.items(), named, strict=True)
    ]


# --- sweeps and stores ------------------------------------------------------------------------------------------------


def sweep_json(result: xr.Dataset) -> dict[str, Any]:
    """The JSON object of a sweep, with probabilities and tolerances where parameters were drawn."""
    if "draw" not in result.dims or "regime" not in result:
        return result_json(result)
    from gelcone.atlas.probability import probability
    from gelcone.atlas.tolerances import base_draws, tolerances

    summaries = {"probability": probability(base_draws(result)), "tolerances": tolerances(result)}
    return result_json(result) | {name: result_json(summary) for name, summary in summaries.items()}


def sweep_words(shown: xr.Dataset, subject: Subject) -> str:
    """A sweep as text."""
    lines = [*_grid_heading(shown, subject), *_regime_lines(shown), totals_text(_totals(shown))]
    if "draw" in shown.dims and "regime" in shown:
        from gelcone.atlas.tolerances import tolerances

        lines += tolerance_lines(tolerances(shown))
    else:
        lines += number_lines(shown)
    return "\n".join(lines)


def number_lines(shown: xr.Dataset) -> list[str]:
    """The numbers that a sweep asked for, each with its range over the grid or its spread over draws; none where kinds
    of motion were asked for."""
    dims = shown["status"].dims
    if "regime" in shown:
        return []
    names = [str(n) for n, variable in shown.data_vars.items() if variable.dims == dims and variable.dtype.kind == "f"]
    names = [name for name in names if not re.match(APART, name)]
    if "draw" not in dims:
        return [_range_line(shown, name) for name in names]
    return [*spread_lines(shown, names), *membranes_lines(shown)]


APART = rf"{FILM_STATES}|.*_error(_|$)"
"""Names of numbers that have a line of their own, or are the error of another."""


def _range_line(shown: xr.Dataset, name: str) -> str:
    """The range of one number over the cells that are there and of which an actuator can be made, and in how many it
    has none, in the words for that."""
    number, is_counted = shown[name], (shown["status"].values > 0) & _possible(shown)
    lost = Counter(missing(float(value), number) for value in number.values[is_counted & ~np.isfinite(number.values)])
    parts = [f"{words} in {count} of {int(is_counted.sum())} cells" for words, count in lost.items()]
    known_values = np.where(is_counted & np.isfinite(number.values), number.values, np.nan)
    if not np.isnan(known_values).all():
        low, high = (
            shown.isel(dict(zip(number.dims, np.unravel_index(find(known_values), known_values.shape), strict=True)))
            for find in (np.nanargmin, np.nanargmax)
        )
        ends = [f"{sized(cell[name])} ({', '.join(_place(cell, number.dims))})" for cell in (low, high)]
        differ = sized(low[name]) != sized(high[name])
        parts.insert(0, " to ".join(ends) if differ else f"{sized(low[name])}{' in all' * (not lost)}")
    return f"{number.attrs.get('long_name', name)}: {'; '.join(parts)}"


def spread_lines(shown: xr.Dataset, names: Iterable[str]) -> list[str]:
    """The spread over the draws of each number that is known of any draw; on a grid at the points where its median is
    smallest and largest."""
    from gelcone.atlas.tolerances import base_draws

    base_runs = base_draws(shown)
    axes = [dim for dim in base_runs["status"].dims if dim != "draw"]
    places = np.ndindex(*(base_runs.sizes[dim] for dim in axes))
    points = [_known(base_runs.isel(dict(zip(axes, place, strict=True)))) for place in places]
    points = [point.isel(cell=_possible(point)) for point in points]
    known_names = [name for name in names if not all(np.isnan(point[name].values).all() for point in points)]
    if not axes:
        return [spread_line(points[0][name]) for name in known_names]
    return [_spread_range_line([point[name] for point in points], axes) for name in known_names]


def _spread_range_line(points: list[xr.DataArray], axes: list[Any]) -> str:
    """The spread of a number at the points with its smallest and its largest median, and at how many it has none."""
    medians = np.array([spread(point.values)[1] if point.size else np.nan for point in points])
    lost, name = int(np.isnan(medians).sum()), points[0].attrs.get("long_name", points[0].name)
    parts = [f"none in more than half of the draws at {lost} of {len(points)} points"] if lost else []
    if lost < len(points):
        low, high = (points[int(find(medians))] for find in (np.nanargmin, np.nanargmax))
        ends = [f"{spread_in_words(point)} ({', '.join(_place(point, axes))})" for point in (low, high)]
        differ = spread_in_words(low) != spread_in_words(high)
        parts.insert(0, " up to ".join(ends) if differ else spread_in_words(low) + " at all points" * (not lost))
    return f"{name}: {'; '.join(parts)}"


def spread_line(own: xr.DataArray) -> str:
    """Median and 95 % interval of a number over the draws, and in how many it has no value, after its name."""
    return f"{own.attrs.get('long_name', own.name)}: {spread_in_words(own)}"


def spread_in_words(own: xr.DataArray) -> str:
    """Median and 95 % interval of a number over the draws, and in how many it has no value."""
    lost = int(np.isnan(own.values).sum())
    none, quantiles = f"none in {lost} of {own.size} draws", spread(own.values)
    if np.isnan(quantiles).any():
        return none
    lost_text = f"; {none}" * bool(lost)
    low, middle, high = (own[0].copy(data=value) for value in quantiles)
    if np.isinf(quantiles).all():
        return f"{sized(middle)} in {own.size - lost} of {own.size} draws{lost_text}"
    return f"{sized(middle)}, 95 % within {sized_range(low, high)}{lost_text}"


def membranes_lines(shown: xr.Dataset) -> list[str]:
    """A line where the pull-in voltages of films were interpolated."""
    between = json.loads(shown.attrs.get("membranes", "null"))
    if between is None:
        return []
    return [
        f"pull-in of the membrane: {between['made']} membranes made for {between['films']} films, the voltages of the "
        f"others interpolated to {100.0 * between['error']:.2g} % (root mean square)"
    ]


def tolerance_lines(found: xr.Dataset) -> list[str]:
    """A line of risks with their intervals and of quantiles of the stroke for each point of the grid, and what the
    stroke depends on at the last point where that is known."""
    axes = [dim for dim in found["probability"].dims if dim != "risk"]
    points = [found.isel(dict(zip(axes, k, strict=True))) for k in np.ndindex(*(found.sizes[dim] for dim in axes))]
    known = [(at, [*_risk_parts(at), *_quantile_parts(at)]) for at in points]
    if axes:
        lines = shortened([f"  {', '.join(_place(at, axes))}: {'; '.join(parts) or 'unknown'}" for at, parts in known])
    else:
        lines = known[0][1]
    if "first_order" in found and found["stroke"].notnull().any():
        lines += _tornado_lines(points, axes)
    return lines


def _risk_parts(at: xr.Dataset) -> list[str]:
    """The risks of a point, each with its interval and its number of draws."""
    return [
        f"probability of {one['risk'].item()} {float(one['probability']):.3g} [{float(one['low']):.3g}, "
        f"{float(one['high']):.3g}] of {int(one['decided'])} draws"
        for one in (at.isel(risk=k) for k in range(at.sizes["risk"]))
        if one["probability"].notnull()
    ]


def _quantile_parts(at: xr.Dataset) -> list[str]:
    """The quantiles of the stroke at a point, each with its interval; none where it is unknown."""
    if at["stroke"].isnull().all():
        return []
    unit = f" in{unit_of(at['stroke'])}" if unit_of(at["stroke"]) else ""
    columns = (at[name].values for name in ("quantile", "stroke", "stroke_low", "stroke_high"))
    parts = [f"{100.0 * q:.0f} % {v:.3g} [{_end(low)}, {_end(high)}]" for q, v, low, high in zip(*columns, strict=True)]
    return [f"quantiles of the stroke{unit}: {', '.join(parts)}"]


def _end(value: float) -> str:
    """An end of an interval by ranks; with few draws it lies beyond them all."""
    return f"{value:.3g}" if np.isfinite(value) else "unknown"


def _place(at: xr.Dataset | xr.DataArray, dims: Iterable[Any]) -> list[str]:
    """Name and value of each axis of a cell."""
    return [f"{name} {measured(at[name])}" for name in dims]


def _tornado_lines(points: list[xr.Dataset], axes: list[Any]) -> list[str]:
    """The Sobol indices of the parameters at the last point that has them, the largest total one first."""
    known = [at for at in points if np.isfinite(at["total_order"].sel(end="value")).all()]
    if not known:
        return ["Sobol indices of the stroke: none, for some draw has no stroke or all have the same one"]
    at = known[-1]
    total, where = at["total_order"].sel(end="value").values, f" at {', '.join(_place(at, axes))}" if axes else ""
    lines = [f"share of the stroke's variance by each parameter{where} (Sobol indices: alone; with interactions):"]
    for k in np.argsort(-total):
        alone, all_ = (at[name].isel(parameter=int(k)).values for name in ("first_order", "total_order"))
        both = "; ".join(f"{v:.2f} [{low:.2f}, {high:.2f}]" for v, low, high in (alone, all_))
        lines.append(f"  {at['parameter'].values[k]}: {both}")
    return lines


def show_words(shown: xr.Dataset, subject: Subject) -> str:
    """A store as text."""
    totals = json.loads(shown.attrs["totals"])
    lacking = int((shown["status"] == 0).sum())
    counts = (
        f"{totals['computed']} cells computed, {totals['inferred']} inferred, {lacking} missing of {totals['cells']}"
    )
    return "\n".join([*_grid_heading(shown, subject), counts, *_regime_lines(shown), *number_lines(shown)])


def _known(result: xr.Dataset) -> xr.Dataset:
    """The cells that are there, one after the other."""
    flat = result.stack(cell=result["status"].dims)
    return flat.isel(cell=(flat["status"] > 0).values)


def _possible(result: xr.Dataset) -> npt.NDArray[np.bool_]:
    """The mask of the cells of which an actuator can be made: the others are counted among the outcomes alone."""
    return np.asarray(result["outcome"].values != Outcome.IMPOSSIBLE)


def drawn_names(shown: xr.Dataset) -> list[str]:
    """Names of the uncertain parameters."""
    return [str(name)[len("drawn_") :] for name in shown.coords if str(name).startswith("drawn_")]


def _grid_heading(shown: xr.Dataset, subject: Subject) -> list[str]:
    """The subject, axes and draws of a computation, and which cells failed."""
    axes, drawn = [dim for dim in shown["status"].dims if dim in shown.coords], drawn_names(shown)
    lines = [*heading(subject, [*axes, *drawn]), grid_text(shown, axes), *_failures(shown)]
    lines += [_draws_text(shown, drawn)] if drawn else []
    return [line for line in lines if line]


def _failures(shown: xr.Dataset) -> list[str]:
    """Count the runs that failed, those of draws that serve only for Sobol indices apart."""
    from gelcone.atlas.tolerances import base_draws

    base_runs = base_draws(shown) if "draw" in shown["status"].dims else shown
    lines = outcome_lines(_known(base_runs))
    if base_runs is shown:
        return lines
    others = outcome_lines(_known(shown.isel(draw=slice(base_runs.sizes["draw"], None))))
    return lines + [f"of the draws for Sobol indices {line}" for line in others]


def _draws_text(shown: xr.Dataset, drawn: list[str]) -> str:
    from gelcone.atlas.tolerances import base_draws

    base = base_draws(shown).sizes["draw"]
    further = shown.sizes["draw"] - base
    return f"{base} draws of {', '.join(drawn)}" + (f", and {further} for Sobol indices" if further else "")


def _regime_lines(shown: xr.Dataset) -> list[str]:
    """Count the cells of each regime, where regimes were asked for, and those in which the model does not hold."""
    counts = [counts_text(shown)] if "regime" in shown else []
    return counts + validity_in_words(shown)


def _totals(shown: xr.Dataset) -> dict[str, Any]:
    """The totals of a run; cells of which no actuator can be made are not counted as failed."""
    totals: dict[str, Any] = json.loads(shown.attrs["totals"])
    return totals | {"failed": totals["failed"] - int((~_possible(shown)).sum())}


def totals_text(totals: dict[str, Any]) -> str:
    """Summarise a run: the cells computed, the findings of its check, the dimension of the borders."""
    parts = [f"{totals['computed']} of {totals['cells']} cells computed"]
    if totals["computed_before"]:
        parts.append(f"{totals['computed_before']} of them before")
    parts += [f"{totals[kind]} {kind}" for kind in ("inferred", "failed") if totals[kind]]
    lines = [f"{', '.join(parts)}; {totals['integrator_steps']:,} steps in {totals['wall_time_s']:.3g} s"]
    if totals["checked"]:
        checked, missed = totals["checked"], totals["missed"]
        low, high = share_interval(missed, checked)
        lines.append(
            f"check: of {checked} inferred cells, drawn at random and computed, {missed} had another regime or sign: "
            f"{100 * missed / checked:.2g} % [{100 * low:.2g}, {100 * high:.2g}]"
        )
    if totals["border_dimension"] is not None:
        dimension, error = totals["border_dimension"]
        power = "the work of refining grows with that power of the cells a side"
        lines.append(f"borders between regimes: dimension {dimension:.2f} ± {error:.2f} ({power})")
    return "\n".join(lines)


# --- basins -----------------------------------------------------------------------------------------------------------


def basin_arguments(subject: Subject, given: dict[str, Any]) -> dict[str, Any]:
    """The arguments of `gelcone.basin`."""
    subject.without_initial("a basin starts from a grid of states; give --over displacement=... and velocity=...")
    return {**given, "over": read_states(given.get("over", ()), subject.device, subject.model.system)}


def basin_words(shown: xr.Dataset, subject: Subject) -> str:
    """Basins of attraction as text."""
    count = shown.sizes["attractor_number"]
    named = [attractor_in_words(shown.isel(attractor_number=n)).replace("\n", ", ") for n in range(count)]
    lines = [
        *heading(subject),
        f"initial {grid_text(shown, [str(dim) for dim in shown['attractor'].dims])}",
        *outcome_lines(shown),
    ]
    lines.append(f"{count} attractor(s):")
    lines += shortened([f"  {n}: {text}" for n, text in enumerate(named)])
    nowhere = float((shown["attractor"] < 0).mean())
    if nowhere:
        lines.append(f"  none: {100.0 * nowhere:.3g} % (failed or not settled)")
    return "\n".join(lines + doubt_lines(shown) + validity_in_words(shown))
