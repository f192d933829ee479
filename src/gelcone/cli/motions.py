"""What the commands about kinds of motion share: their budgets, exponents and regimes in JSON, counts in text."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, Any, TypeVar

import click
import numpy as np

from gelcone.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.cli.options import Subject

F = TypeVar("F", bound=Callable[..., Any])
MOST_PRINTED = 20
"""Most lines of a list on the terminal; the rest are counted."""


def budget_options(function: F) -> F:
    """--transient and --budget."""
    for decorate in (
        click.option(
            "--budget",
            type=float,
            default=20_000.0,
            show_default=True,
            help="Longest averaging time of the exponents, dimensionless.",
        ),
        click.option(
            "--transient",
            type=float,
            metavar="TIME",
            help="Time to let pass before, dimensionless. [default: by damping and drive]",
        ),
    ):
        function = decorate(function)
    return function


def single(subject: Subject, command: str) -> Subject:
    """The subject, refused where it is an ensemble."""
    if subject.model.shape:
        raise InputError(f"{command} starts from one actuator, not {subject.model.size}; sweep a parameter with --over")
    return subject


def regime_names(codes: Any) -> Any:
    """Codes of `Regime` as names, nested lists for arrays."""
    from gelcone.codes import Regime

    return np.vectorize(lambda code: Regime(code).label, otypes=[object])(np.asarray(codes)).tolist()


def periods_json(periods: Any) -> Any:
    """Periods in drive repeats, null where a motion has none."""
    return np.vectorize(lambda period: int(period) or None, otypes=[object])(np.asarray(periods)).tolist()


def regime_counts(result: xr.Dataset) -> dict[str, int]:
    """How many cells move in each way that occurs; failed ones are counted by `outcome_lines`."""
    from gelcone.codes import Regime

    codes = result["regime"].values.ravel()
    return {kind.label: int((codes == kind).sum()) for kind in Regime if (codes == kind).any()}


def counts_text(counts: dict[str, int]) -> str:
    """Counts in one line."""
    return ", ".join(f"{name} {count}" for name, count in counts.items())


def marked_cells(result: xr.Dataset) -> dict[str, list[dict[str, Any]]]:
    """The cells that failed, each with its outcome, and those whose evidence does not agree, each with its regime."""
    from gelcone.codes import Outcome, Regime

    def cells(which: Any, kind: str, name: Callable[[int], str]) -> list[dict[str, Any]]:
        places = [np.nonzero(which)[axis] for axis in range(which.ndim)]
        columns: dict[str, Any] = {
            str(dim): result[dim].values[at] for dim, at in zip(result["outcome"].dims, places, strict=True)
        }
        columns[kind] = [name(int(code)) for code in result[kind].values[which]]
        return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]

    failed = result["outcome"].values != 0
    flagged = (result["doubtful"].values != 0) & ~failed
    return {
        "failed": cells(failed, "outcome", lambda code: Outcome(code).name.lower()),
        "flagged": cells(flagged, "regime", lambda code: Regime(code).label),
    }


def flag_line(result: xr.Dataset) -> list[str]:
    """How many results need a second look."""
    flagged = (result["doubtful"].values != 0) & (result["outcome"].values == 0)
    count = int(flagged.sum())
    return [f"{count} of {flagged.size} flagged: the evidence does not agree, look before you believe"] * bool(count)


def member_labels(result: xr.Dataset, most: int | None = None) -> list[tuple[str, xr.Dataset]]:
    """The first ``most`` members of an ensemble (default all) with their varied parameters as names; one without a name
    for a single run."""
    dims = list(result["outcome"].dims)
    if not dims:
        return [("", result)]
    stacked = result.stack(flat=dims)
    names = [str(n) for n, c in result.coords.items() if c.attrs.get("quantity") == "parameter"]
    chosen = [stacked.isel(flat=i) for i in range(stacked.sizes["flat"])[:most]]
    return [(", ".join(f"{n} {float(m[n]):.4g}" for n in names), m) for m in chosen]


def member_lines(result: xr.Dataset, describe: Callable[[xr.Dataset], str]) -> list[str]:
    """One line for each of the first members of an ensemble, beginning with its varied parameters."""
    lines = [f"  {name}: {describe(member)}" for name, member in member_labels(result, MOST_PRINTED)]
    return shortened(lines, result["outcome"].size)


def shortened(lines: list[str], count: int | None = None) -> list[str]:
    """At most `MOST_PRINTED` lines, and how many more there are of ``count`` in all (default: of the lines)."""
    more = (len(lines) if count is None else count) - MOST_PRINTED
    return lines if more <= 0 else [*lines[:MOST_PRINTED], f"  and {more} more (all with --json or --out)"]


def first(variable: xr.DataArray) -> xr.DataArray:
    """The largest exponent of a variable that holds both; another variable as it is."""
    return variable.isel(exponent=0) if "exponent" in variable.dims else variable


def grid_text(shown: xr.Dataset, names: Iterable[Any]) -> str:
    """The swept coordinates in one line."""
    spans = []
    for dim in names:
        in_si = f" ({_ends(shown[f'{dim}_si'])})" if f"{dim}_si" in shown.coords else ""
        spans.append(f"{dim} {_ends(shown[dim])}{in_si}, {shown.sizes[dim]} values")
    return "; ".join(spans)


def _ends(coordinate: xr.DataArray) -> str:
    from gelcone.words import unit_of

    return f"{float(coordinate[0]):.6g} to {float(coordinate[-1]):.6g}{unit_of(coordinate)}"
