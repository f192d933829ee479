"""Claims about the voltage."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from gelcone.codes import Regime
from gelcone.paper.claims.claim import Studies, claim
from gelcone.paper.numbers import Number, Truth
from gelcone.paper.reading import (
    SAME,
    about_six,
    chaotic,
    finite_not_positive,
    finite_positive,
    first_chaos,
    fixed_branch,
    largest_in,
    not_positive,
    positive,
    slack_of,
)
from gelcone.paper.sampling import part, share_of
from gelcone.paper.studies.samples import VOLTAGE_THRESHOLD, holds_throughout, rows_about_six, rows_positive
from gelcone.paper.truths import every, share, truth
from gelcone.paper.verdicts import NEARLY_ALL, Finding
from gelcone.presets import find_preset
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

ROUNDED = (1.035, 1.045)
"""Interval that rounds to the paper's threshold."""
BANDWIDTH = 1.94
"""Noise bandwidth of the spectrum's window in bins."""


@claim(
    "voltage-threshold",
    "The largest exponent is at most zero below the voltage 1.04 and positive from there on.",
    13,
    "diagram-base-voltage",
    "diagram-fast-voltage",
    "share-voltage",
    "neighbours",
    "voltage",
)
def voltage_threshold(studies: Studies) -> Finding:
    """Judges the bracket of the threshold, and samples on both sides of it."""
    other = fixed_branch(studies["diagram-fast-voltage"])
    below, above = (part(studies["share-voltage"], name) for name in ("below", "above"))
    threshold = first_chaos(studies["diagram-base-voltage"], "voltage")
    second = first_chaos(studies["diagram-fast-voltage"], "voltage")
    pitchfork = float(np.sqrt(find_preset("base").model.stiffness(0.0)))
    calm, chaos = share_of(below, not_positive(below)), share_of(above, positive(above))
    sets = share(rows_positive(studies["neighbours"]))
    return Finding(
        holds=every(_at(threshold), holds_throughout(calm), chaos.exceeds(NEARLY_ALL)),
        holds_finite=every(
            holds_throughout(share_of(below, finite_not_positive(below))),
            share_of(above, finite_positive(above)).exceeds(NEARLY_ALL),
        ),
        share=sets,
        neighbourhood=f"{sets.count:g} parameter sets near the base set, a positive exponent over voltages from 1.04 "
        "to 2",
        numbers=(
            *(() if threshold is None else (threshold,)),
            chaos.number("share of voltages in 1.04 to 2 with a positive exponent"),
            calm.number("share of voltages below 1.04 with an exponent at most zero"),
            share(positive(other)[other["voltage"].values >= VOLTAGE_THRESHOLD]).number(
                "share of voltages in 1.04 to 2 with a positive exponent, set fast"
            ),
            *(() if second is None else (replace(second, meaning=f"{second.meaning}, set fast"),)),
            Number("static pitchfork voltage, where rest loses its stability at constant voltage", pitchfork),
            *_cascade(studies["diagram-base-voltage"], "base"),
            *_cascade(studies["diagram-fast-voltage"], "fast"),
        ),
        why="Chaos sets in near the stated voltage, above the loss of stability of rest, but windows of periodic "
        f"motion interrupt it all the way up. Needed: chaos first at what rounds to 1.04, no positive exponent below, "
        f"and positive ones above at {NEARLY_ALL:.0%} of the voltages.",
        slack=slack_of(studies["voltage"], "voltage"),
        unseen="The periodic windows: over a short window their transients look chaotic. Instability of rest comes "
        "first and is not chaos.",
    )


def _at(threshold: Number | None) -> Truth:
    """Whether the bracket of chaos's first voltage rounds to 1.04, or overlaps it; false without chaos."""
    if threshold is None or threshold.low is None or threshold.high is None:
        return False
    if threshold.low >= ROUNDED[0] and threshold.high < ROUNDED[1]:
        return True
    return None if threshold.low < ROUNDED[1] and threshold.high >= ROUNDED[0] else False


def _cascade(study: xr.Dataset, name: str) -> tuple[Number, ...]:
    """The end of the period doublings that lead to chaos, and their branch, in words."""
    if "cascade_end" not in study:
        return ()
    born = study["cascade_born"]
    branch = f"the branch from the {born.attrs['born']} at v = {float(born):.4f}"
    end, error = float(study["cascade_end"]), float(study["cascade_end_error"])
    return (Number(f"end of the period doublings of {branch}, set {name}", end, error=error),)


@claim(
    "voltage-amplitude",
    "In the chaotic range the amplitude reaches about 6.",
    7,
    "diagram-base-voltage",
    "neighbours",
    "voltage",
)
def voltage_amplitude(studies: Studies) -> Finding:
    """Judges the largest displacement in chaos, with its error from nearby starts."""
    near, window = studies["neighbours"], studies["voltage"]
    branch = fixed_branch(studies["diagram-base-voltage"])
    chaos = chaotic(branch)
    largest = float(largest_in(chaos, _extent(branch, "lowest", "highest")))
    nearby = largest_in(near["own_regime"].values == Regime.CHAOTIC, near["own_extent"].values)
    spread = float(np.ptp(nearby)) if np.isfinite(nearby).all() else float("inf")
    # left open where nearby starts disagree
    ends = {truth(about_six(np.asarray(largest + off), chaos)) for off in (-spread, 0.0, spread)}
    reached = share(rows_about_six(near))
    seen = largest_in(finite_positive(window), _extent(window, "window_lowest", "window_highest"))
    return Finding(
        holds=ends.pop() if len(ends) == 1 else None,
        holds_finite=truth(about_six(seen, finite_positive(window))),
        share=reached,
        neighbourhood=f"{reached.count:g} parameter sets near the base set",
        numbers=(
            Number("largest displacement in chaos up to v = 2, set base", largest, error=spread),
            Number("largest displacement from the start up to v = 1.7, set base", float(seen)),
            reached.number("share of parameter sets near the base set for which it rounds to 6"),
        ),
        why="What rounds to 6 counts as about 6; the error is how far starts within 1e-9 of one another differ. The "
        "bound is the stretch limit: at J = 50 the film ends at x = 7.1, and a motion that only the limit stops is not "
        "about 6.",
        slack=slack_of(studies["voltage"], "voltage"),
        unseen="An amplitude of 6 is six film widths out of plane; the strain is 70% of the stretch limit and the "
        "hoop slack.",
    )


def _extent(study: xr.Dataset, lowest: str, highest: str) -> Array:
    return np.asarray(np.fmax(np.abs(study[lowest].values), np.abs(study[highest].values)))


@claim(
    "voltage-spectra",
    "At low voltage one line at the excitation frequency dominates; it splits at the threshold; above, the spectrum is "
    "broadband.",
    8,
    "spectra",
    "voltage",
)
def voltage_spectra(studies: Studies) -> Finding:
    """Judges lines and flatness of the spectra at three voltages."""
    study = studies["spectra"]
    late, early = _spectral_order(study, ""), _spectral_order(study, "early_")
    base = list(study["set"].values).index("base")
    low, middle, high = (study.isel(set=base, voltage=i) for i in range(3))
    return Finding(
        holds=late[base],
        holds_finite=early[base],
        share=share(np.delete(late, base), sample=False),
        neighbourhood="the other parameter set",
        numbers=(
            Number(
                "strongest line at low voltage from the start, over the drive's",
                _strongest(low, "early_"),
                error=float(np.diff(study["early_frequency_ratio"].values[:2])[0]),
            ),
            Number("swing left at low voltage in the long run (rms)", float(low["rms"])),
            Number("spectral flatness at high voltage, long run", float(high["flatness"]), error=_flatness_error(high)),
        ),
        details={
            "share of power in lines at the threshold, long run": f"{float(middle['power_in_lines']):.3g}",
        },
        why="Needed: a strongest line at the frequency of the voltage or of its force (twice that) with most of the "
        "power at low voltage, several lines at the threshold, and a flatness above 0.01 at high voltage.",
        slack=slack_of(studies["voltage"], "voltage"),
        unseen="At low voltage the device comes to rest: what its spectrum shows is the free vibration from the start, "
        "at its natural frequency and not at that of the drive.",
    )


def _strongest(spectrum: xr.Dataset, prefix: str) -> float:
    """Frequency of the strongest line over that of the voltage."""
    lines, amplitudes = spectrum[f"{prefix}line_ratio"].values, spectrum[f"{prefix}line_amplitude"].values
    return float(lines[np.nanargmax(amplitudes)]) if np.isfinite(amplitudes).any() else float("nan")


def _flatness_error(spectrum: xr.Dataset) -> float:
    """Standard error of the flatness, with each bin's power taken as noise of the window's bandwidth."""
    amplitude = spectrum["amplitude"].values
    power = amplitude[1:][np.isfinite(amplitude[1:])] ** 2
    if not power.size:
        return float("nan")
    # The logarithm of a noisy power varies by pi/sqrt(6), the power itself by its mean.
    variance = np.pi**2 / 6.0 / power.size + (power**2).sum() / power.sum() ** 2
    return float(spectrum["flatness"]) * float(np.sqrt(BANDWIDTH * variance))


def _spectral_order(study: xr.Dataset, prefix: str) -> list[bool]:
    """Whether the spectra at three voltages change from a driven line over split lines to broadband, for each set."""
    verdicts = []
    for k in range(study.sizes["set"]):
        low, middle, high = (study.isel(set=k, voltage=i) for i in range(3))
        strongest = _strongest(low, prefix)
        driven = min(abs(strongest - 1.0), abs(strongest - 2.0)) < 0.1
        dominant = float(low[f"{prefix}power_in_lines"]) > 0.5
        split = int(np.isfinite(middle[f"{prefix}line_amplitude"].values).sum()) > 1
        verdicts.append(bool(driven and dominant and split and float(high[f"{prefix}flatness"]) > 0.01))
    return verdicts


REST_LOST = {
    "onset_voltage": "loss of stability of rest",
    "pitchfork_voltage": "loss of stability of flat rest at constant voltage",
    "pull_in_voltage": "pull-in on a slow ramp",
}
"""Thresholds of a device at rest in words."""


@claim(
    "practical-voltage",
    "From 10 to 50 V the amplitude is nearly constant; these voltages lie orders of magnitude below any threshold.",
    9,
    "practical",
)
def practical_voltage(studies: Studies) -> Finding:
    """Judges amplitudes and thresholds of the device in volts."""
    study = studies["practical"]
    amplitude = study["window_amplitude"].values
    spread = np.ptp(amplitude, axis=1) / amplitude.mean(axis=1)
    highest = float(study["voltage_amplitude"].values.max())
    thresholds = {words: study[name].values[np.isfinite(study[name].values)] for name, words in REST_LOST.items()}
    lowest, words = min((float(values.min()), words) for words, values in thresholds.items() if values.size)
    late = study["late_amplitude"].values[:, -1]
    return Finding(
        holds=bool((spread < SAME).all() and lowest > 100.0 * highest),
        numbers=(
            Number(f"lowest threshold ({words}) over 50 V", lowest / highest),
            Number("largest relative change of the amplitude over 10 to 50 V", float(spread.max())),
            *(
                Number(f"amplitude left in the long run at 50 V, initial height {h:g} mm", float(a), unit="mm")
                for h, a in zip(study["initial_height"].values, late, strict=True)
            ),
        ),
        why="The electric force goes with the square of the voltage: at 50 V it is smaller than at the threshold "
        "by the square of the ratio.",
        unseen="The amplitude is that of the release, not of the drive: in the long run the drive hardly moves the "
        "disc.",
    )
