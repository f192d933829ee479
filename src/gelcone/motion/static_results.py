"""Voltages and starts that static analyses take, and the labels of their results."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.errors import InputError
from gelcone.physics.balance import SEARCH_RANGE, StaticBalance, rest_of
from gelcone.physics.drive import VOLTAGE
from gelcone.physics.members import Ensemble
from gelcone.physics.statics import each
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

PLACE: dataset.Of = dataset.absent("length", nan="none")


def own_levels(model: Ensemble) -> Array:
    """The peaks of the drive and the offsets other than 0, as constant voltages in rising order. Constant voltages of
    films in opposite phase have the sign of the bias: the peaks are those of that sign."""
    peaks, offsets = np.ravel(model.peak_voltage), np.abs(np.ravel(model.offset_voltage))
    if model.system.in_opposite_phase:
        along, against = model.system.waveform.along_bias(model.own_numbers)
        other = np.not_equal(model.voltage_bias, 0.0) & (against > along)
        peaks = np.ravel(np.where(other, along, model.peak_voltage))
    return np.unique([*peaks, *offsets[offsets > 0.0]])


def label_static(
    model: Ensemble,
    balances: list[StaticBalance],
    variables: dict[str, dataset.Variable],
    *,
    coords: dict[str, dataset.Variable] | None = None,
    start: npt.ArrayLike | None = None,
    title: str,
) -> xr.Dataset:
    """The labelled result of a static analysis; members that reach no displacement are `Outcome.OUTSIDE`."""
    options = {"search_range": SEARCH_RANGE, "start": None if start is None else np.asarray(start).tolist()}
    outcome = [Outcome.OK if balance.reachable else Outcome.OUTSIDE for balance in balances]
    return dataset.label(model, variables, coords=coords, outcome=outcome, options=options, title=title)


def constant_voltages(voltages: npt.ArrayLike) -> Array:
    """Constant voltages as an array, (voltages,). Raises `InputError` for values that are not numbers of at least 0."""
    try:
        levels = np.atleast_1d(np.asarray(VOLTAGE["voltage"].check("voltages", voltages), dtype=float))
    except InputError as error:
        refused = str(error).partition("; its default is")[0]
        remedy = "; leave out the sign, on which no force depends" * refused.endswith("must be at least 0")
        raise InputError(refused + remedy) from None
    if levels.ndim > 1:
        raise InputError(f"voltages has the shape {levels.shape}: must be a number or one-dimensional; ravel it")
    return levels


def rests_near(model: Ensemble, balances: list[StaticBalance], start: npt.ArrayLike | None) -> list[float]:
    """The equilibrium without voltage nearest to ``start`` of each member, from which its slow ramp starts."""
    return each(rest_of, balances, _starts(model, start))


def _starts(model: Ensemble, start: npt.ArrayLike | None) -> list[float | None]:
    if start is None:
        return [None] * model.size
    try:
        values = np.broadcast_to(np.asarray(start, dtype=float), model.shape).ravel()
    except (TypeError, ValueError):
        raise InputError(f"start = {start!r}: must be a displacement, or one a member (shape {model.shape})") from None
    if not np.isfinite(values).all():
        raise InputError(f"start = {values[~np.isfinite(values)][0]:g}: must be finite")
    return [float(value) for value in values]


def padded(rows: Sequence[Array], least: int = 1) -> Array:
    """Arrays (rows, ...) of different lengths in one, (arrays, rows, ...), with at least ``least`` rows, padded with
    NaN."""
    table = np.full((len(rows), max(least, *map(len, rows)), *rows[0].shape[1:]), np.nan)
    for slot, row in zip(table, rows, strict=True):
        slot[: len(row)] = row
    return table
