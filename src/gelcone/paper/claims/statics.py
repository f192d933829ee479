"""Claims about statics and the linear limit."""

from __future__ import annotations

import numpy as np

from gelcone.paper.claims.agreement import agreement
from gelcone.paper.claims.claim import Studies, claim
from gelcone.paper.numbers import Number
from gelcone.paper.truths import share
from gelcone.paper.verdicts import Finding

EVEN = 1001
"""Number of evenly spaced initial displacements, from 0 to the paper's own, for the share."""
LINEAR = 0.01
"""An oscillation counts as linear while its period is within this share of the linear one."""


@claim(
    "static-bistable",
    "At the highest of three voltages the static curve meets zero force three times, with slopes +, -, +.",
    3,
    "static",
)
def static_bistable(studies: Studies) -> Finding:
    """Judges the equilibria at the highest voltage."""
    study = studies["static"]
    counts = study["equilibria"].values.ravel()
    highest = study.isel(constant_voltage=-1)
    slopes = highest["slope"].values.ravel()
    slopes = slopes[np.isfinite(slopes)]
    places = highest["equilibrium_displacement"].values.ravel()
    pitchfork = float(study["pitchfork_voltage"])
    return Finding(
        holds=bool(counts[-1] == 3 and (np.sign(slopes) == [1, -1, 1]).all()),
        numbers=(
            Number("equilibria at the highest voltage", float(counts[-1])),
            *(Number(f"slope at x = {x:.4g}", float(s)) for x, s in zip(places, slopes, strict=False)),
            Number("pitchfork voltage, the square root of the small-signal stiffness", pitchfork),
        ),
        why="Above the pitchfork voltage the flat state is unstable between two buckled ones.",
        consequence="The force of a flat, symmetric device is odd in the displacement, grows with it at large ones and "
        "softens with the voltage: three zeros with these slopes follow at any voltage above the pitchfork.",
        unseen="The flat film is slack at these voltages: with pre-stretch 1 the hoop stress is compressive.",
    )


fem_agreement = claim(
    "fem-agreement",
    "The model's force agrees closely with that of commercial finite elements at all three voltages.",
    3,
    "continuum",
    "corrected",
)(agreement)


@claim(
    "linear-limit",
    "Without damping and voltage and with the stretch limit at infinity the device is a linear oscillator.",
    6,
    "linear-limit",
)
def linear_limit(studies: Studies) -> Finding:
    """Judges the period over the amplitude."""
    study = studies["linear-limit"]
    amplitude, ratio = study["amplitude"].values, study["period_ratio"].values
    off = np.abs(ratio - 1.0)
    linear = off < LINEAR
    # The paper's own start is the largest of these; a period is that of an amplitude, whatever the others do.
    reach = float(np.interp(LINEAR, off, amplitude)) if not linear.all() else float(amplitude[-1])
    smaller = amplitude < amplitude[-1]
    even = np.linspace(0.0, amplitude[-1], EVEN, endpoint=False)[1:]
    return Finding(
        holds=bool(linear[-1]),
        share=share(np.interp(even, amplitude[smaller], off[smaller]) < LINEAR, sample=False),
        neighbourhood="smaller initial displacements than the paper's own, 1",
        numbers=(
            Number("largest displacement with the period within 1 % of the linear one", reach),
            Number("period at the displacement 1 over the linear period", float(ratio[-1])),
        ),
        why="The film's force x (1 - 1/q^2) is cubic at the flat state: only small motions are linear, at any stretch "
        "limit.",
        consequence="Any smooth oscillator is linear for small enough motions; the number is how small.",
        unseen="How small the motion must be; at the paper's initial state the oscillator is not linear.",
    )
