"""The cascade of period doublings that leads to chaos: where it ends, and the branch it belongs to."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.atlas.branches.branch import EventKind
from gelcone.atlas.branches.continuation import continue_branch
from gelcone.dataset import attributes
from gelcone.physics.model import ConeModel
from gelcone.words import event_label

if TYPE_CHECKING:
    import xarray as xr

FEIGENBAUM = 4.66920160910299
"""Limit of the ratios of distances between doublings: Feigenbaum, Journal of Statistical Physics 19 (1978) 25."""
LEVELS = 4
"""Doublings located after the first one."""
FEWEST = 3
"""Fewest doublings of a cascade."""
SAME = 1e-6
"""Doublings closer than this are the same."""
BEFORE, BEHIND = 0.002, 0.1
"""Interval in which doublings are searched, as shares of the first one before and behind it: short, so that branches
are, too."""


def cascade(model: ConeModel, followed: xr.Dataset) -> dict[str, Any]:
    """The first cascade of doublings that begins on a stable part of a branch of period 1, as variables of a study.

    ``doubling`` holds their values; ``cascade_end`` is their limit by Feigenbaum's ratio, with ``cascade_end_error``
    from the last doubling; ``cascade_born`` is the value at which the branch is born, by the event in its attribute
    ``born``. Empty without a cascade.
    """
    kinds, values = followed["event_kind"].values, followed["event_value"].values
    period = followed["period"].values[followed["event_branch"].values]
    stable = followed["stable"].values[followed["event_branch"].values, followed["event_point"].values] == 1
    first = np.flatnonzero((kinds == EventKind.PERIOD_DOUBLING) & (period == 1) & stable)
    for k in first[np.argsort(values[first])]:
        doublings = _chain(model, followed, int(k))
        if len(doublings) >= FEWEST:
            return _cascade_variables(followed, doublings, _birth(followed, int(followed["event_branch"][k])))
    return {}


def _cascade_variables(followed: xr.Dataset, doublings: list[float], born: int | None) -> dict[str, Any]:
    ends = [b + (b - a) / (FEIGENBAUM - 1.0) for a, b in pairwise(doublings)]
    values = followed["event_value"].values
    birth = {"born": "" if born is None else event_label(followed["event_kind"][born])}
    return {
        "doubling": ("doubling", np.array(doublings), attributes("period doublings of one cascade", "parameter value")),
        "cascade_end": ((), ends[-1], attributes("where the doublings end", "parameter value")),
        "cascade_end_error": ((), abs(ends[-1] - ends[-2]), attributes("error of that", "parameter value")),
        "cascade_born": (
            (),
            np.nan if born is None else float(values[born]),
            attributes("where the branch of the cascade is born", "parameter value") | birth,
        ),
    }


def _chain(model: ConeModel, followed: xr.Dataset, first: int) -> list[float]:
    """A doubling, the next one on the branch that is born there, and so on."""
    start, orbit = float(followed["event_value"][first]), followed["event_orbit"].values[first, 0]
    low, high = start * (1.0 - BEFORE), start * (1.0 + BEHIND)
    local_branches = continue_branch(
        model, str(followed.attrs["parameter"]), low, high, tuple(orbit), start="settled", switch=LEVELS, checks=2
    )
    doubles = local_branches["event_kind"].values == EventKind.PERIOD_DOUBLING
    chain, values = [], local_branches["event_value"].values
    at = np.flatnonzero(doubles & (np.abs(values - start) < SAME))
    while at.size:
        chain.append(float(values[at[0]]))
        born = int(local_branches["event_born_branch"][at[0]])
        at = np.flatnonzero(doubles & (local_branches["event_branch"].values == born))
        at = at[np.argsort(local_branches["event_point"].values[at])]
    return chain


def _birth(followed: xr.Dataset, branch: int) -> int | None:
    """The event at which a branch is born: its bifurcation from another branch, or its first fold."""
    born = int(followed["born"][branch])
    if born >= 0:
        return born
    is_on_branch = followed["event_branch"].values == branch
    folds = np.flatnonzero(is_on_branch & (followed["event_kind"].values == EventKind.FOLD))
    return int(folds[followed["event_value"].values[folds].argmin()]) if folds.size else None
