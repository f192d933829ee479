"""Maps over one or two parameters, and basins over initial states: the regime and its evidence in every cell."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.atlas import workers
from gelcone.atlas.plan import Plan, meaning_of, quantity_of
from gelcone.atlas.record import Tally
from gelcone.atlas.survey import survey
from gelcone.codes import Regime
from gelcone.motion.evidence import Evidence, label_evidence
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.regime import ROUNDS
from gelcone.physics.model import ConeModel

if TYPE_CHECKING:
    import xarray as xr

SAME_ATTRACTOR = 1e-3
"""Two cycles are one when their highest turning points agree to this share of the size of the larger one."""


def parameter_map(
    model: ConeModel,
    over: Mapping[str, npt.ArrayLike],
    initial: tuple[float, float] = (1.0, 0.0),
    *,
    transient: float | None = None,
    budget: float = 20_000.0,
    tolerance: float = DEFAULT_TOLERANCE,
    rounds: int = ROUNDS,
    coarsest: int | None = None,
    store: str | Path | None = None,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Regime, exponents with errors, amplitude and outcome over a grid of parameters (usually two).

    `gelcone.survey` does the same for any analysis, on a cluster too, and goes on with a store.

    Parameters
    ----------
    model : a single model; the swept parameters replace its own.
    over : parameter name -> increasing values, at least two of each.
    initial : displacement and velocity at time 0 in every cell. Default (1, 0).
    transient, budget, tolerance : as in `regime`.
    rounds : how often a motion that has not settled is looked at again. Default 5.
    coarsest, store : as in `gelcone.survey`: refine from a lattice of so many points; keep what comes in a folder.

    Returns
    -------
    Dataset over the swept names with the variables of `regime` but the section, ``status`` and ``source`` as in
    `gelcone.survey`. A cell that fails carries its ``outcome`` and the regime ``left the domain``; the others are not
    touched by it.

    Raises
    ------
    InputError : for unknown names, too few or unsorted values, budgets that are not positive, no cell inside its limit.
    """
    plan = Plan(model, over, initial, transient, budget, tolerance, rounds)
    told = 0.0

    def share(tally: Tally) -> None:
        nonlocal told
        now = (tally.computed + tally.inferred) / tally.cells
        if progress is not None and now > told:
            progress(now - told)
        told = max(now, told)

    result = survey(plan, coarsest=coarsest, store=store, workers=workers.threads(threads), progress=share)
    return result.assign_attrs(title="parameter map")


def basin(
    model: ConeModel,
    over: Mapping[str, npt.ArrayLike],
    *,
    transient: float | None = None,
    budget: float = 20_000.0,
    tolerance: float = DEFAULT_TOLERANCE,
    rounds: int = ROUNDS,
    threads: int | None = None,
    progress: Callable[[float], None] | None = None,
) -> xr.Dataset:
    """Which regimes coexist: the attractor that each initial state ends on, and the attractors' shares.

    Parameters
    ----------
    model : a single model.
    over : ``displacement`` and ``velocity`` -> increasing values.
    transient, budget, tolerance : as in `regime`.
    rounds : how often a motion that has not settled is looked at again. Default 5.

    Returns
    -------
    Dataset over ``displacement`` and ``velocity`` with ``attractor`` (number of the attractor, -1 where the motion has
    left the domain or not settled) and the variables of `regime` but the section; over ``attractor_number`` the
    attractors by falling ``share`` of the grid: ``attractor_regime``, ``attractor_period``, ``attractor_lowest``,
    ``attractor_highest`` and ``attractor_lyapunov``. A motion and its mirror image are two attractors.

    Raises
    ------
    InputError : as `parameter_map`.
    """
    plan = Plan(model, over, (0.0, 0.0), transient, budget, tolerance, rounds)
    evidence = plan.run(threads=threads, progress=progress)
    result = label_cells(plan, evidence, "basins of attraction").drop_vars("section")
    numbers, first = attractors(evidence)
    result["attractor"] = (
        tuple(plan.over),
        numbers.reshape(plan.shape),
        {"long_name": "number of the attractor, -1 if none", "units": "1", "quantity": "code"},
    )
    shares = np.array([(numbers == n).mean() for n in range(len(first))])

    def column(values: Any, long_name: str, quantity: str) -> tuple[str, Any, dict[str, str]]:
        return "attractor_number", values, {"long_name": long_name, "units": "1", "quantity": quantity}

    return result.assign(
        attractor_share=column(shares, "share of the initial states", "share"),
        attractor_regime=column(evidence.regime[first], "kind of motion", "code"),
        attractor_period=column(evidence.period[first], "period in drive repeats, 0 if none", "count"),
        attractor_lowest=column(evidence.lowest[first], "lowest displacement", "length"),
        attractor_highest=column(evidence.highest[first], "highest displacement", "length"),
        attractor_lyapunov=column(evidence.exponents[first, 0], "largest Lyapunov exponent per unit time", "rate"),
    )


def attractors(evidence: Evidence) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.intp]]:
    """Number of the attractor of each cell (-1 for none), the most frequent first, and one cell of each attractor."""
    numbers = np.full(len(evidence.regime), -1)
    found: list[int] = []
    settled = ~np.isin(evidence.regime, (Regime.TRANSIENT, Regime.LEFT_THE_DOMAIN))
    for cell in np.flatnonzero(settled):
        match = next((n for n, other in enumerate(found) if _same(evidence, int(cell), other)), len(found))
        if match == len(found):
            found.append(int(cell))
        numbers[cell] = match
    counts = np.bincount(numbers[numbers >= 0], minlength=len(found))
    order = np.argsort(-counts, kind="stable")
    rank = np.empty(len(found), dtype=int)
    rank[order] = np.arange(len(found))
    return np.where(numbers >= 0, rank[numbers] if found else -1, -1), np.array(found, dtype=int)[order]


def _same(evidence: Evidence, one: int, other: int) -> bool:
    """Whether two settled motions are on one attractor: the same regime and, for rests and cycles, the same extent.

    Chaotic and quasi-periodic motions cover their extent too slowly for that, and count as one a regime.
    """
    if evidence.regime[one] != evidence.regime[other] or evidence.period[one] != evidence.period[other]:
        return False
    if evidence.regime[one] in (Regime.CHAOTIC, Regime.QUASI_PERIODIC):
        return True
    ends = np.array([[evidence.lowest[i], evidence.highest[i]] for i in (one, other)])
    return bool(np.abs(ends[0] - ends[1]).max() <= SAME_ATTRACTOR * max(np.abs(ends).max(), 1e-2))


def label_cells(plan: Plan, evidence: Evidence, title: str) -> xr.Dataset:
    """Evidence of all cells of a plan as a Dataset over the swept names."""
    flat, _ = plan.at(plan.grid)
    result = label_evidence(flat.members(), evidence, plan.options(), title)
    single = dataset.label(plan.model, {}, options=plan.options(), title=title)
    names = [str(n) for n in result.coords]
    result = result.drop_vars(names)
    coords: dict[str, Any] = {
        name: (name, values, {"long_name": meaning_of(name), "units": "1", "quantity": quantity_of(name)})
        for name, values in plan.over.items()
    }
    variables = {
        name: (tuple(plan.over) + v.dims[1:], v.values.reshape(plan.shape + v.shape[1:]), v.attrs)
        for name, v in result.variables.items()
    }
    return single.assign_coords(coords).assign(variables)
