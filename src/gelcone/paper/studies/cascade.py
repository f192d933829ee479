"""Where the doublings of the period end that lead to chaos, and which branch they lie on."""

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
"""Doublings that are located behind the first one."""
FEWEST = 3
"""Doublings that make a cascade."""
SAME = 1e-6
"""Doublings that are closer are one."""
BEFORE, BEHIND = 0.002, 0.1
"""The interval of the doublings, as shares of the first one: short, so that the branches are."""


def cascade(model: ConeModel, followed: xr.Dataset) -> dict[str, Any]:
    """The first cascade of doublings that begins on a stable part of a branch of period 1, as variables of a study.

    ``doubling`` (their values), ``cascade_end`` and ``cascade_end_error`` (where they end, by Feigenbaum's ratio, and
    by how much the last doubling changed that), ``cascade_born``, the value at which the branch is born; its
    attribute ``born`` says at what. Empty without a cascade.
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
    """A doubling of the branches, the one on the branch that is born there, and so on."""
    begin, orbit = float(followed["event_value"][first]), followed["event_orbit"].values[first, 0]
    low, high = begin * (1.0 - BEFORE), begin * (1.0 + BEHIND)
    own = continue_branch(
        model, str(followed.attrs["parameter"]), low, high, tuple(orbit), start="settled", switch=LEVELS, checks=2
    )
    doubles = own["event_kind"].values == EventKind.PERIOD_DOUBLING
    found, values = [], own["event_value"].values
    at = np.flatnonzero(doubles & (np.abs(values - begin) < SAME))
    while at.size:
        found.append(float(values[at[0]]))
        born = int(own["event_born_branch"][at[0]])
        at = np.flatnonzero(doubles & (own["event_branch"].values == born) & (born >= 0))
        at = at[np.argsort(own["event_point"].values[at])]
    return found


def _birth(followed: xr.Dataset, branch: int) -> int | None:
    """The event at which a branch is born: where it left another one, or its first fold."""
    born = int(followed["born"][branch])
    if born >= 0:
        return born
    own = followed["event_branch"].values == branch
    folds = np.flatnonzero(own & (followed["event_kind"].values == EventKind.FOLD))
    return int(folds[followed["event_value"].values[folds].argmin()]) if folds.size else None
