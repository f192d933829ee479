"""What the paper claims about pre-stretch and spring."""

from __future__ import annotations

import numpy as np

from gelcone.codes import Regime
from gelcone.paper.claims.claim import Studies, claim
from gelcone.paper.reading import fixed_branch, share
from gelcone.paper.verdicts import Finding, Number

SAME = 0.05
"""Motions are indistinguishable when they differ by less than this share of their size: what a plot shows."""


@claim(
    "prestretch-order",
    "A small pre-stretch gives chaos, a moderate one a small limit cycle, a larger one decays to rest.",
    10,
    "prestretch",
    "diagram-fast-prestretch",
)
def prestretch_order(studies: Studies) -> Finding:
    study = studies["prestretch"]
    kinds = study["regime"].values
    finite = study["finite"].values[:, 0]
    expected = [Regime.CHAOTIC, Regime.PERIODIC, Regime.REST]
    other = fixed_branch(studies["diagram-fast-prestretch"])
    at = [int(np.argmin(np.abs(other["prestretch"].values - lp))) for lp in study["prestretch"].values]
    second = bool((other["regime"].values[at] == expected).all())
    own = bool((kinds == expected).all())
    return Finding(
        holds=own,
        holds_finite=bool(finite[0] > 0.0 and finite[2] < 0.0),
        share=share([own, second]),
        neighbourhood="the two parameter sets",
        numbers=tuple(
            Number(
                f"largest exponent at pre-stretch {lp:g} ({Regime(int(k)).label})",
                float(study["lyapunov"].values[i, 0]),
                error=float(study["standard_error"].values[i, 0]),
            )
            for i, (lp, k) in enumerate(zip(study["prestretch"].values, kinds, strict=True))
        ),
        why="Pre-stretch raises the small-signal stiffness of the flat film and with it the voltage at which "
        "rest is lost.",
        unseen="Which of the thresholds does it: rest at the largest pre-stretch is stable by Floquet theory.",
    )


@claim(
    "spring-frequency",
    "Raising the spring stiffness from 0.1 to 20 moves the resonance up.",
    12,
    "frequency",
)
def spring_frequency(studies: Studies) -> Finding:
    study = studies["frequency"].sel(sweep="up")
    stiffness = study["spring_stiffness"].values
    low, high = study["peak_low"].values, study["peak_high"].values
    peaks = study["peak_frequency"].values
    rises = low[1:] > high[:-1]
    return Finding(
        holds=bool(rises.all()),
        share=share(rises),
        neighbourhood="neighbouring pairs of spring stiffnesses",
        numbers=tuple(
            Number(f"resonance at spring stiffness {k:g}", float(f), low=float(a), high=float(b))
            for k, f, a, b in zip(stiffness, peaks, low, high, strict=True)
        ),
        why="The intervals of neighbouring peaks do not overlap and rise with the stiffness.",
        unseen="The force goes with the square of the voltage: the peak lies near half the natural frequency, "
        "except where "
        "a soft spring allows a large, strongly nonlinear motion.",
    )


@claim(
    "spring-amplitude",
    "The peak amplitude falls monotonically with the spring stiffness (figure 12) although the amplitude "
    "is not affected "
    "by it (figure 11).",
    12,
    "frequency",
    "spring",
)
def spring_amplitude(studies: Studies) -> Finding:
    study = studies["frequency"].sel(sweep="up")
    peaks, error = study["peak_amplitude"].values, study["peak_amplitude_error"].values
    falls = peaks[1:] + error[1:] < peaks[:-1] - error[:-1]
    spring = studies["spring"]
    late = 0.5 * (spring["late_highest"].values - spring["late_lowest"].values)
    start = 0.5 * (spring["window_highest"].values - spring["window_lowest"].values)
    unaffected = bool(np.ptp(start) / start.mean() < SAME)
    return Finding(
        holds=bool(falls.all()),
        share=share(falls),
        neighbourhood="neighbouring pairs of spring stiffnesses",
        numbers=(
            *(
                Number(f"peak amplitude at spring stiffness {k:g}", float(a), error=float(e))
                for k, a, e in zip(study["spring_stiffness"].values, peaks, error, strict=True)
            ),
            Number(
                "amplitude from the start at stiffness 10 over that at 1 (figure 11)",
                float(start[-1] / start[0]),
                error=1e-3,
            ),
            Number("the same in the long run", float(late[-1] / late[0]), error=1e-3),
        ),
        why="The two statements contradict each other for the driven motion. "
        + (
            "Over the window from the start the amplitude is indeed not affected: it is that of the release."
            if unaffected
            else "Over the window from the start the amplitude changes as well."
        ),
        unseen="Figure 11 shows the free decay from the initial state, figure 12 the driven motion.",
    )


@claim("spring-no-jump", "There is no jump or hysteresis over the whole range of drive frequency.", 12, "frequency")
def spring_no_jump(studies: Studies) -> Finding:
    study = studies["frequency"]
    up, down = (study["amplitude"].sel(sweep=s).values for s in ("up", "down"))
    size = np.fmax(np.nanmax(np.fmax(up, down), axis=1), 1e-9)
    gap = np.nanmax(np.abs(up - down), axis=1) / size
    smooth = gap < SAME
    return Finding(
        holds=bool(smooth.all()),
        share=share(smooth),
        neighbourhood="the six spring stiffnesses",
        numbers=tuple(
            Number(f"largest difference of the sweeps over the peak, spring stiffness {k:g}", float(g), error=1e-3)
            for k, g in zip(study["spring_stiffness"].values, gap, strict=True)
        ),
        why="The sweeps up and down count as one while they differ by less than 5 % of the peak.",
        unseen="Two sweeps are needed to see hysteresis at all.",
    )
