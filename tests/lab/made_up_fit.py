"""A made-up fit: predictions are powers of the fields, and do not depend on the gain of an instrument."""

from types import SimpleNamespace

import numpy as np

import gelcone
from gelcone.lab import predictions
from gelcone.lab.device_fit import Gain

PUMP = gelcone.find_device("biased-pump").replace(film="taut")
FREE = {"spring_rate": 0.1, "film_thickness": 0.2}
POWERS = {"stroke": np.array([1.0, -2.0]), "pull-in": np.array([-0.5, 1.0])}
COVARIANCE = np.array([[0.04, 0.006, 0.5], [0.006, 0.01, 0.4], [0.5, 0.4, 9.0]])
"""Of both fields and of a gain, on which no prediction depends."""


def made_up_problem(**own):
    tests = own.pop("tests", [])
    values = np.zeros(8)
    return SimpleNamespace(
        device=PUMP, free=FREE, names=[*FREE, "gain of balance"], priors=np.array([0.1, 0.2, 5.0]), tests=tests,
        values=values, **own,
    )  # fmt: skip


def by_powers(monkeypatch):
    """Predictions of 2 (kind 1) or 3 times their powers; ``asked``, which slopes next experiments are sought for."""
    asked = []

    def values(problem, logs, one):
        return (2.0 if one.kind == "stroke" else 3.0) * np.exp(logs @ POWERS[one.kind])

    def experiments(problem, row, logs):
        asked.append(row)
        return [Gain(f"do {len(asked)}", 0.5 / len(asked))]

    monkeypatch.setattr(predictions, "predicted_values", values)
    monkeypatch.setattr(predictions, "next_experiments", experiments)
    return asked
