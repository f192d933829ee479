"""The settled motion of one actuator: its kind with the evidence, its orbit, section and spectrum, and its numbers, as
plain arrays in the units of the page."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gelcone.analyses.request import Subject
from gelcone.codes import Outcome, Regime
from gelcone.dataset import Findings
from gelcone.devices.scales import MEASURES
from gelcone.motion.job import Trajectories
from gelcone.motion.section import section_cells
from gelcone.motion.spectrum import spectrum_cells
from gelcone.motion.start import start_states
from gelcone.quantity import Array
from gelcone.register.analyses import ANALYSES
from gelcone.studio import performance
from gelcone.studio.look import Parts, curve, scales
from gelcone.studio.orbit import settled_orbit
from gelcone.words import evidence_in_words

SECTION_POINTS = 600
"""Section points of a motion that does not repeat."""
SPECTRUM_PERIODS = 64
SHOWN_RATIO = 8.0
"""Highest frequency of a spectrum, over the drive's."""
SHOWN_SHARE = 1e-6
"""A spectrum without lines (the drive does not repeat) is shown up to the last amplitude above this share of the
largest."""


@dataclass(frozen=True)
class Settled(Parts):
    """The kind of motion, and the ``run`` along the settled motion (None without one)."""

    run: Trajectories | None = None


def kind(subject: Subject) -> Settled:
    """The regime with its evidence in words, its section and its settled orbit."""
    analysis = ANALYSES["regime"]
    states = start_states(subject.model.members(), subject.initial)
    answer = analysis.compute(subject.model.members(), states, threads=1)
    member = single(answer, subject)
    outcome = Outcome(int(member["outcome"]))
    regime = Regime(int(member["regime"]))
    by = scales(subject)
    points = np.asarray(answer.variables["section"][1])[0]
    arrays: dict[str, Any] = {}
    run = None
    lines = [*evidence_in_words(member), *([outcome.meaning] if outcome else [])]
    words: dict[str, Any] = {"regime": int(regime), "lines": lines, "numbers": []}
    if not outcome and np.isfinite(points[:2]).all():
        members = subject.model.members()
        # two forcing periods past the start of the cycle: there the drive, too, is at its phase 0
        run, whole = settled_orbit(members, points[1], regime, int(member["period"]))
        words["numbers"] = performance.in_words(
            performance.motion(members, run, regime, whole.stop // whole.step), subject
        )
        arrays, words["shares"] = curve(members, run, subject, "o")
        if regime not in (Regime.REST, Regime.PERIODIC):  # two runs of chaos come apart
            points = run.states[0, whole]
    arrays |= {"px": points[:, 0] * by["length"], "pu": points[:, 1] * by["velocity"]}
    extent = [float(member[name]) for name in ("lowest", "highest")]
    return Settled(arrays, words | {"extent": extent if np.isfinite(extent).all() else None}, run)


def electrical(subject: Subject, run: Trajectories) -> Parts:
    """Current and power along the settled run."""
    numbers = performance.of_source(subject.model.members(), run)
    return Parts({}, {"numbers": performance.in_words(numbers, subject)})


class Reading(np.ndarray):
    """A variable as `gelcone.words` reads it; stands in for xarray, which takes a second to import."""

    attrs: dict[str, str]

    @property
    def values(self) -> Array:
        """The numbers as a plain array, as a DataArray has them."""
        return np.asarray(self)


def single(found: Findings, subject: Subject) -> Any:
    """The findings of a single actuator by name, with units: readable like a Dataset, ten times faster."""
    member: dict[str, Any] = {"outcome": found.outcome[0]}
    for name, (_, values, _, quantity) in found.variables.items():
        scale, unit = 1.0, "1"
        of = str(quantity.get("quantity") if isinstance(quantity, Mapping) else quantity)
        if subject.device is not None and of in MEASURES:
            scale, unit = subject.device.scales.shown(of), MEASURES[of].shown
        value = np.asarray(values)[0]
        member[name] = np.asarray(value * scale if unit != "1" else value).view(Reading)
        member[name].attrs = {"units": unit}
    return member


def section(subject: Subject) -> Parts:
    """More section points of a motion that does not repeat."""
    states = start_states(subject.model.members(), subject.initial)
    points = section_cells(subject.model.members(), states, repeats=SECTION_POINTS, threads=1)
    by = scales(subject)
    x, u = (np.asarray(points.variables[name][1])[0] for name in ("displacement", "velocity"))
    return Parts({"px": x * by["length"], "pu": u * by["velocity"]})


def spectrum(subject: Subject) -> Parts:
    """The amplitude spectrum, and the highest frequency to show. It is that of the settled motion, or of the whole run
    if the drive does not repeat."""
    repeats, states = subject.model.system.waveform.repeat, start_states(subject.model.members(), subject.initial)
    periods = SPECTRUM_PERIODS if repeats else 1
    variables = spectrum_cells(subject.model.members(), states, periods=periods, threads=1).variables
    by = scales(subject)
    amplitude = np.asarray(variables["amplitude"][1])[0]
    ratio = np.arange(amplitude.size) / periods
    lines = np.asarray(variables["line_ratio"][1])[0]
    heights = np.asarray(variables["line_amplitude"][1])[0]
    kept = np.isfinite(lines)
    omega = float(subject.model.drive_frequency) * by["frequency"]
    top = SHOWN_RATIO
    if not repeats:
        top = float(ratio[amplitude >= SHOWN_SHARE * amplitude[1:].max(initial=0.0)].max(initial=SHOWN_RATIO))
    return Parts(
        {
            "frequency": ratio * omega,
            "amplitude": amplitude * by["length"],
            "line": lines[kept] * omega,
            "height": heights[kept] * by["length"],
        },
        {"top": top * omega},
    )


STAGES: Mapping[str, Callable[[Subject], Parts]] = {
    "kind": kind,
    "section": section,
    "spectrum": spectrum,
}
