"""Probability of a kind of motion at every point of a grid, from draws of uncertain parameters."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone import dataset
from gelcone.codes import Outcome, Regime
from gelcone.errors import InputError, check_result
from gelcone.statistics import CONFIDENCE, share_interval

if TYPE_CHECKING:
    import xarray as xr

UNDECIDED = (Outcome.STEP_LIMIT, Outcome.ERROR, Outcome.IMPOSSIBLE)
"""Outcomes of cells of whose motion nothing is known."""


def probability(cells: xr.Dataset, kind: Regime = Regime.CHAOTIC, *, confidence: float = CONFIDENCE) -> xr.Dataset:
    """Compute the probability of a kind of motion at every point of a grid, from the draws made there.

    Parameters
    ----------
    cells : result of `gelcone.sweep` of a plan with draws and the analysis ``"regime"``.
    kind : default chaos.
    confidence : of the interval. Default 0.95.

    Returns
    -------
    Dataset over the grid: ``probability``, the share of the decided draws; ``low`` and ``high``, its interval (Clopper
    and Pearson, Biometrika 26 (1934) 404: exact for independent draws, and wider than it need be for the even ones of
    `draw`); ``decided``, the number of draws behind it: not those that failed or did not settle.

    Raises
    ------
    InputError : for a sweep without draws or regimes, or a confidence that is not between 0 and 1.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
    >>> draws = gelcone.draw({"damping_ratio": gelcone.Uniform(0.05, 0.1)}, 4)
    >>> cells = gelcone.sweep(gelcone.Plan(model, {"drive_frequency": [0.6, 0.8]}, draws=draws))
    >>> found = gelcone.probability(cells, gelcone.Regime.PERIODIC)
    >>> found.probability.values.tolist(), found.low.values.round(3).tolist()
    ([1.0, 1.0], [0.398, 0.398])
    """
    check_draws("probability", cells)
    if not 0.0 < confidence < 1.0:
        raise InputError(f"confidence = {confidence}: must be between 0 and 1")
    regime, failed = cells["regime"], cells["outcome"].isin(list(UNDECIDED))
    decided = ~failed & (regime != Regime.TRANSIENT) & (regime >= 0)
    n = decided.sum("draw")
    k = (decided & (regime == kind)).sum("draw")
    low, high = share_interval(k, n, confidence)
    share = np.where(n > 0, k / np.maximum(n, 1), np.nan)
    options = {"kind": kind.label, "confidence": confidence}
    title, errors = f"probability: {kind.label}", dataset.film_errors_of(cells)
    result = dataset.label(dataset.model_of(cells), {}, options=options, title=title, errors=errors)
    table: dataset.Table = {
        "probability": (share, f"probability that the motion is {kind.label}", "share"),
        "low": (low, f"lower end of its {100.0 * confidence:g} % interval", "share"),
        "high": (high, f"upper end of its {100.0 * confidence:g} % interval", "share"),
        "decided": (n.values, "draws that are decided", "count"),
    }
    coords = {str(dim): cells[dim] for dim in n.dims}
    return result.assign_coords(coords).assign(dataset.columns(tuple(coords), table))


def check_draws(name: str, cells: xr.Dataset) -> None:
    """`InputError` from the function ``name`` unless ``cells`` is a sweep with draws of the regime."""
    check_result(name, cells)
    if "draw" not in cells.dims or "regime" not in cells:
        raise InputError("the sweep has no draws of the regime; give uncertain parameters and the analysis 'regime'")
