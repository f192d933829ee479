"""Solution of many small linear systems, some without a solution."""

from __future__ import annotations

from typing import Any

import numpy as np


def solved_where_regular(matrices: Any, right: Any) -> Any:
    """Solutions (..., n) of systems (..., n, n) with right-hand sides (..., n); NaN for one that is singular or not
    finite."""
    regular = np.array(np.isfinite(matrices).all(axis=(-2, -1)) & np.isfinite(right).all(axis=-1))
    regular[regular] = np.linalg.slogdet(matrices[regular])[0] != 0.0
    solutions = np.full(right.shape, np.nan, dtype=np.result_type(matrices, right))
    solutions[regular] = np.linalg.solve(matrices[regular], right[regular][..., None])[..., 0]
    return solutions
