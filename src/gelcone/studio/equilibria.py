"""The equilibria of one actuator under constant voltages and its pull-in, stored for many drives."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Generic, TypeVar

import numpy as np

from gelcone.analyses.request import Subject
from gelcone.motion.equilibrium import static
from gelcone.physics.model import ConeModel
from gelcone.studio import performance
from gelcone.studio.look import Parts, pull_in_film, scales

if TYPE_CHECKING:
    import xarray as xr

STATIC_LEVELS = 2
DRIVEN = ("voltage", "drive_frequency", "damping_ratio", "waveform", "circuit")
"""Parameters that do not affect the equilibria under a constant voltage."""
MOST_STATICS = 32


def _body(model: ConeModel) -> str:
    """A text that identifies a model up to its drive."""
    return repr(sorted((name, value) for name, value in model.parameters().items() if name not in DRIVEN))


def _levels(model: ConeModel) -> float:
    """The next power of two above the peak voltage, so that neighbouring settings share their statics."""
    return float(2.0 ** np.ceil(np.log2(max(float(model.peak_voltage), 1e-3))))


T = TypeVar("T")


class Answers(Generic[T]):
    """Answers about models, found by ``find`` and cached by ``key`` for up to `MOST_STATICS` keys."""

    def __init__(self, key: Callable[[ConeModel], str], find: Callable[[ConeModel], T]) -> None:
        self._key, self._find = key, find
        self.stored: dict[str, T] = {}

    def of(self, model: ConeModel) -> T:
        """The answer for a model, cached."""
        if not self.has(model):
            self.keep(model, self._find(model))
        return self.stored[self._key(model)]

    def keep(self, model: ConeModel, found: T) -> None:
        """Stores an answer that was computed elsewhere."""
        if len(self.stored) >= MOST_STATICS:
            self.stored.clear()
        self.stored[self._key(model)] = found

    def has(self, model: ConeModel) -> bool:
        """Whether the answer is cached."""
        return self._key(model) in self.stored


STATICS: Answers[xr.Dataset] = Answers(
    lambda model: f"{_levels(model)} {_body(model)}",
    lambda model: static(model, np.linspace(0.0, _levels(model), STATIC_LEVELS)),
)
"""`gelcone.static` up to beyond the peak voltage; takes seconds for films that wrinkle."""
PULL_INS: Answers[float] = Answers(_body, performance.pull_in)
"""`performance.pull_in`; like the statics, it does not depend on the drive."""


def margins(subject: Subject) -> Parts:
    """The static pull-in voltage, and the drive's peak as a share of it."""
    numbers = {performance.PULL_INS[pull_in_film(subject.model)]: PULL_INS.of(subject.model)}
    return Parts({}, {"numbers": performance.in_words(numbers, subject)})


def statics(subject: Subject) -> Parts:
    """The equilibria over a constant voltage with their stability, and the voltages of pitchfork and pull-in."""
    result = STATICS.of(subject.model)
    by = scales(subject)
    voltage, place, slope = (result[f"branch_{name}"].values for name in ("voltage", "displacement", "slope"))
    marks = {
        name: float(result[f"{name}_voltage"]) * by["voltage"]
        for name in ("pitchfork", "pull_in")
        if np.isfinite(float(result[f"{name}_voltage"]))
    }
    waveform, n = subject.model.system.waveform, subject.model.own_numbers
    swing = np.ravel(waveform.samples(n))
    return Parts(
        {
            "voltage": voltage * by["voltage"],
            "x": place * by["length"],
            "stable": (np.nan_to_num(slope) > 0.0).astype(np.uint8),
        },
        {"marks": marks, "swing": [float(swing.min()) * by["voltage"], float(swing.max()) * by["voltage"]]},
    )
