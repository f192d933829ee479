"""Predictions of a fitted device with their standard deviations, and experiments that would reduce these."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gelcone import dataset
from gelcone.devices.units import FieldError, parse
from gelcone.errors import InputError, check_name
from gelcone.lab.bench import Variants
from gelcone.lab.device_fit import STEP, Problem, next_experiments
from gelcone.motion.static_bifurcations import pull_in_voltage
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

PREDICTIONS = {"stroke": "m", "blocked force": "N", "natural frequency": "Hz", "pull-in": "V"}
"""Quantities that can be predicted -> SI unit; all but the last at a voltage, as in ``stroke@1.5 kV``."""


class Asked(NamedTuple):
    """A prediction: its ``kind``, a key of `PREDICTIONS`, at a ``voltage``, and the ``text`` of the request."""

    text: str
    kind: str
    voltage: float


def read_predictions(texts: Sequence[str]) -> list[Asked]:
    """Read predictions from texts such as ``stroke@1.5 kV`` and ``pull-in``."""
    predictions = []
    for text in texts:
        kind, at, voltage = (part.strip() for part in text.partition("@"))
        check_name("prediction", kind, PREDICTIONS)
        if bool(at) == (kind == "pull-in"):
            raise InputError(f"predict {text!r}: {'takes no voltage' if at else f'give a voltage, {kind}@1 kV'}")
        try:
            predictions.append(Asked(text, kind, parse(f"predict {kind}", voltage, "V", above=0.0) if at else 0.0))
        except FieldError as error:
            raise InputError(str(error)) from None
    return predictions


def predictions_of(problem: Problem, logs: Array, covariance: Array, asked: Sequence[Asked]) -> xr.Dataset:
    """Compute predictions with their standard deviations, and the shares of these that further experiments would
    leave."""
    import xarray as xr

    if not asked:
        return xr.Dataset()
    count = len(problem.free)
    around = np.concatenate([np.zeros((1, count)), STEP * np.eye(count)]) + logs[:count]
    values = np.stack([predicted_values(problem, around, one) for one in asked])
    slopes = np.concatenate([(values[:, 1:] - values[:, :1]) / STEP, np.zeros((len(asked), logs.size - count))], axis=1)
    spread = np.sqrt(np.einsum("pi,ij,pj->p", slopes, covariance, slopes))
    gains = [next_experiments(problem, row, logs) if np.isfinite(row).all() else [] for row in slopes]
    prior = np.sqrt((slopes**2) @ problem.priors**2)
    return xr.Dataset(
        dataset.columns("prediction", {
            "predicted_value": (values[:, 0], "prediction in SI", "share"),
            "predicted_spread": (spread, "standard deviation of the prediction, in SI", "share"),
            "predicted_prior": (prior, "standard deviation of the prediction from the priors alone, in SI", "share"),
        }),
        coords={"prediction": [one.text for one in asked]},
        attrs={"next": json.dumps(gains)},
    )  # fmt: skip


def predicted_values(problem: Problem, logs: Array, asked: Asked) -> Array:
    """Compute a prediction for variants without gains, (variants,)."""
    variants = Variants(problem.device, list(problem.free), np.exp(logs), {})
    if asked.kind == "pull-in":
        volts = pull_in_voltage(variants.device)["pull_in_voltage"].values
        return np.where(np.isfinite(volts), volts, np.nan)
    if asked.kind == "stroke":
        return variants.stroke(np.array([asked.voltage]))[:, 0]
    if asked.kind == "natural frequency":
        return variants.natural_frequency(asked.voltage)
    squared = variants.squared(np.array([asked.voltage]))
    added = variants.force(variants.rest, 0.0)[0] - variants.force(variants.rest, squared)[0]
    return np.asarray((added * variants.scale("force"))[:, 0])
