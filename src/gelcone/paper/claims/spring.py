"""Claims about pre-stretch and spring."""

from __future__ import annotations

import numpy as np

from gelcone.codes import Regime
from gelcone.paper.claims.claim import Studies, claim
from gelcone.paper.numbers import Number
from gelcone.paper.reading import SAME, all_of, largest_exponent, ordered, resolution, slack_of
from gelcone.paper.studies.samples import rows_ordered
from gelcone.paper.truths import every, share, truth
from gelcone.paper.verdicts import Finding
from gelcone.quantity import Array


@claim(
    "prestretch-order",
    "A small pre-stretch gives chaos, a moderate one a small limit cycle, a larger one decays to rest.",
    10,
    "prestretch",
    "neighbours",
)
def prestretch_order(studies: Studies) -> Finding:
    """Judges the kinds of motion at three pre-stretches, at the base set and near it."""
    study = studies["prestretch"]
    kinds = study["regime"].values
    finite, resolved = study["finite"].values[:, 0], resolution(study)
    others = share(rows_ordered(studies["neighbours"]))
    return Finding(
        holds=truth(ordered(kinds)),
        holds_finite=bool(finite[0] > resolved and abs(finite[1]) <= resolved and finite[2] < 0.0),
        share=others,
        neighbourhood=f"{others.count:g} parameter sets near the base set",
        numbers=(
            *(
                largest_exponent(
                    f"largest exponent at pre-stretch {lp:g} ({Regime(int(k)).label})", study.isel(prestretch=i)
                )
                for i, (lp, k) in enumerate(zip(study["prestretch"].values, kinds, strict=True))
            ),
            others.number("share of parameter sets near the base set with the same order"),
        ),
        why="Pre-stretch raises the small-signal stiffness of the flat film and with it the voltage at which "
        "rest is lost.",
        slack=slack_of(study, "prestretch"),
        unseen="Which of the thresholds does it: rest at the largest pre-stretch is stable by Floquet theory.",
    )


@claim(
    "spring-frequency",
    "Raising the spring stiffness from 0.1 to 20 moves the resonance up.",
    12,
    "frequency",
)
def spring_frequency(studies: Studies) -> Finding:
    """Judges the intervals of the resonances of neighbouring stiffnesses."""
    study = studies["frequency"].sel(sweep="up")
    stiffness = study["spring_stiffness"].values
    low, high = study["peak_low"].values, study["peak_high"].values
    peaks = study["peak_frequency"].values
    rises = _rises(low, high)
    return Finding(
        holds=truth(all_of(rises)),
        share=share([all_of(rises[:-1]), all_of(rises[1:])], sample=False),
        neighbourhood="the stiffnesses without the smallest or without the largest",
        numbers=tuple(
            Number(f"resonance at spring stiffness {k:g}", float(f), low=float(a), high=float(b))
            for k, f, a, b in zip(stiffness, peaks, low, high, strict=True)
        ),
        why="Between neighbouring stiffnesses the resonance moves up or down where the intervals of the peaks do not "
        "overlap; where they do, nothing is said.",
        unseen="The force goes with the square of the voltage: the peak lies near half the natural frequency, "
        "except where a soft spring allows a large, strongly nonlinear motion.",
    )


def _rises(low: Array, high: Array) -> Array:
    """Truths: each interval lies above the one before; open where the two overlap."""
    return np.where(low[1:] > high[:-1], 1.0, np.where(high[1:] < low[:-1], 0.0, np.nan))


@claim(
    "spring-amplitude",
    "The peak amplitude falls monotonically with the spring stiffness (figure 12) although the amplitude "
    "is not affected by it (figure 11).",
    12,
    "frequency",
    "spring",
)
def spring_amplitude(studies: Studies) -> Finding:
    """Judges the peaks of the resonances, and the amplitude of one motion over the stiffness."""
    study = studies["frequency"].sel(sweep="up")
    peaks, error = study["peak_amplitude"].values, study["peak_amplitude_error"].values
    spring = studies["spring"]
    late = 0.5 * (spring["late_highest"].values - spring["late_lowest"].values)
    start = 0.5 * (spring["window_highest"].values - spring["window_lowest"].values)
    unaffected, from_start = (bool(np.ptp(a) / a.mean() < SAME) for a in (late, start))
    falling = truth(all_of(1.0 - _rises(peaks - error, peaks + error)))
    seen = "from each stiffness to the next where the errors of the peaks do not overlap"
    parts = {
        "peak falls": Finding(holds=falling, numbers=(), why=seen),
        "amplitude not affected": Finding(unaffected, (), "in the long run", holds_finite=from_start),
    }
    return Finding(
        parts=parts,
        holds=every(falling, unaffected),
        holds_finite=every(falling, from_start),
        numbers=(
            *(
                Number(f"peak amplitude at spring stiffness {k:g}", float(a), error=float(e))
                for k, a, e in zip(study["spring_stiffness"].values, peaks, error, strict=True)
            ),
            Number("amplitude from the start at stiffness 10 over that at 1 (figure 11)", float(start[-1] / start[0])),
            Number("the same in the long run", float(late[-1] / late[0])),
        ),
        why="Both halves are needed: peaks that fall from each stiffness to the next, and an amplitude that stays "
        f"within {SAME:.0%}. Of one motion they cannot both be true. "
        + (
            "Over the window from the start the amplitude is that of the release, and not affected; "
            if from_start
            else "Over the window from the start the amplitude changes as well; "
        )
        + ("in the long run it is not affected either." if unaffected else "in the long run it is."),
        unseen="Figure 11 shows the free decay from the initial state, figure 12 the driven motion.",
    )


@claim("spring-no-jump", "There is no jump or hysteresis over the whole range of drive frequency.", 12, "frequency")
def spring_no_jump(studies: Studies) -> Finding:
    """Judges the largest difference between the sweeps up and down."""
    study = studies["frequency"]
    up, down = (study["amplitude"].sel(sweep=s).values for s in ("up", "down"))
    size = np.fmax(np.nanmax(np.fmax(up, down), axis=1), 1e-9)
    gap = np.nanmax(np.abs(up - down), axis=1) / size
    smooth = gap < SAME
    return Finding(
        holds=bool(smooth.all()),
        share=share(smooth, sample=False),
        neighbourhood="single spring stiffnesses of the six",
        numbers=tuple(
            Number(f"largest difference of the sweeps over the peak, spring stiffness {k:g}", float(g))
            for k, g in zip(study["spring_stiffness"].values, gap, strict=True)
        ),
        why="The sweeps up and down count as one while they differ by less than 5 % of the peak.",
        unseen="Two sweeps are needed to see hysteresis at all.",
    )
