"""What the paper claims about the voltage."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.paper.claims.claim import Studies, claim
from gelcone.paper.numbers import Number, Truth
from gelcone.paper.reading import chaotic, finite_positive, first_chaos, fixed_branch, positive, slack_of
from gelcone.paper.truths import every, share
from gelcone.paper.verdicts import NEARLY_ALL, Finding
from gelcone.presets import find_preset
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

VOLTAGE_THRESHOLD = 1.04
"""From the paper's text."""
SAME = 0.05
"""Motions are indistinguishable when they differ by less than this share of their size: what a plot shows."""
BANDWIDTH = 1.94
"""Bins over which the spectrum's window spreads noise."""


@claim(
    "voltage-threshold",
    "The largest exponent is at most zero below the voltage 1.04 and positive from there on.",
    13,
    "diagram-base-voltage",
    "diagram-fast-voltage",
    "neighbours",
    "voltage",
)
def voltage_threshold(studies: Studies) -> Finding:
    branch = fixed_branch(studies["diagram-base-voltage"])
    other = fixed_branch(studies["diagram-fast-voltage"])
    voltage, growing, finite = branch["voltage"].values, positive(branch), finite_positive(branch)
    below, above = voltage < VOLTAGE_THRESHOLD, voltage >= VOLTAGE_THRESHOLD
    threshold = first_chaos(studies["diagram-base-voltage"], "voltage")
    second = first_chaos(studies["diagram-fast-voltage"], "voltage")
    pitchfork = float(np.sqrt(find_preset("base").model.stiffness(0.0)))
    calm, chaos = share(1.0 - growing[below]), share(growing[above])
    sets = [share(row).exceeds(NEARLY_ALL) for row in positive(studies["neighbours"])]
    return Finding(
        holds=every(calm.failing == 0, chaos.exceeds(NEARLY_ALL)),
        holds_finite=every(share(1.0 - finite[below]).exceeds(NEARLY_ALL), share(finite[above]).exceeds(NEARLY_ALL)),
        share=share(sets),
        neighbourhood=f"{len(sets)} parameter sets near the base set, a positive exponent over voltages from 1.04 to 2",
        numbers=(
            *(() if threshold is None else (threshold,)),
            chaos.number("share of voltages in 1.04 to 2 with a positive exponent"),
            calm.number("share of voltages below 1.04 with an exponent at most zero"),
            share(positive(other)[other["voltage"].values >= VOLTAGE_THRESHOLD]).number(
                "share of voltages in 1.04 to 2 with a positive exponent, set fast"
            ),
            *(
                ()
                if second is None
                else (Number("smallest voltage with chaos, set fast", second.value, low=second.low, high=second.high),)
            ),
            Number("static pitchfork voltage, where rest loses its stability at constant voltage", pitchfork),
            *_cascade(studies["diagram-base-voltage"], "base"),
            *_cascade(studies["diagram-fast-voltage"], "fast"),
        ),
        why="Chaos sets in near the stated voltage, above the loss of stability of rest, but windows of periodic "
        f"motion interrupt it all the way up. Needed: no positive exponent below, and positive ones above at "
        f"{NEARLY_ALL:.0%} of the voltages.",
        slack=slack_of(studies["voltage"], "voltage"),
        unseen="The periodic windows: over a short window their transients look chaotic. Instability of rest comes "
        "first and is not chaos.",
    )


def _cascade(study: xr.Dataset, name: str) -> tuple[Number, ...]:
    """Where the doublings end that lead to chaos, and which branch they lie on."""
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
    near = studies["neighbours"]
    branch = fixed_branch(studies["diagram-base-voltage"])
    size = np.fmax(np.abs(branch["lowest"].values), np.abs(branch["highest"].values))
    own = _largest(size, chaotic(branch))
    nearby = [_largest(*row) for row in zip(near["own_extent"].values, _own_chaos(near), strict=True)]
    spread = float(np.ptp(nearby)) if np.isfinite(nearby).all() else float("inf")
    # What nearby starts leave open between them is not said.
    ends = {_about_six(own + off, chaotic(branch)) for off in (-spread, 0.0, spread)} if np.isfinite(own) else set()
    reached = [_about_six(_largest(*row), row[1]) for row in zip(near["extent"].values, chaotic(near), strict=True)]
    return Finding(
        holds=ends.pop() if len(ends) == 1 else None if ends else _about_six(own, chaotic(branch)),
        share=share(reached),
        neighbourhood=f"{len(reached)} parameter sets near the base set",
        numbers=(
            Number("largest displacement in chaos up to v = 2, set base", own, error=spread),
            share(reached).number("share of parameter sets near the base set for which it is within 20 % of 6"),
        ),
        why="Within 20 % of 6 counts as about 6; the error is how far starts within 1e-9 of one another differ. The "
        "bound is the stretch limit: at J = 50 the film ends at x = 7.1.",
        slack=slack_of(studies["voltage"], "voltage"),
        unseen="An amplitude of 6 is six film widths out of plane; the film is near its stretch limit and the hoop "
        "slack.",
    )


def _largest(size: Array, chaos: Array) -> float:
    """Largest extent in chaos; NaN without any."""
    return float(np.nanmax(size[chaos == 1.0])) if (chaos == 1.0).any() else float("nan")


def _own_chaos(near: xr.Dataset) -> Array:
    return chaotic(near[["own_regime"]].rename(own_regime="regime"))


def _about_six(largest: float, chaos: Array) -> Truth:
    """Whether the largest displacement in chaos is within a fifth of 6; without any chaos it is not."""
    if np.isnan(largest):
        return None if np.isnan(chaos).any() else False
    return bool(abs(largest / 6.0 - 1.0) <= 0.2)


@claim(
    "voltage-spectra",
    "At low voltage one line at the excitation frequency dominates; it splits at the threshold; above, the spectrum is "
    "broadband.",
    8,
    "spectra",
    "voltage",
)
def voltage_spectra(studies: Studies) -> Finding:
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
    """Standard error of the flatness, each bin's power taken as that of noise, with the window's bandwidth."""
    amplitude = spectrum["amplitude"].values
    power = amplitude[1:][np.isfinite(amplitude[1:])] ** 2
    if not power.size:
        return float("nan")
    # The logarithm of a noisy power varies by pi/sqrt(6), the power itself by its mean.
    variance = np.pi**2 / 6.0 / power.size + (power**2).sum() / power.sum() ** 2
    return float(spectrum["flatness"]) * float(np.sqrt(BANDWIDTH * variance))


def _spectral_order(study: xr.Dataset, prefix: str) -> list[bool]:
    """Whether the spectra at three voltages go from a driven line over split lines to broadband, for each set."""
    verdicts = []
    for k in range(study.sizes["set"]):
        low, middle, high = (study.isel(set=k, voltage=i) for i in range(3))
        strongest = _strongest(low, prefix)
        driven = min(abs(strongest - 1.0), abs(strongest - 2.0)) < 0.1
        dominant = float(low[f"{prefix}power_in_lines"]) > 0.5
        split = int(np.isfinite(middle[f"{prefix}line_amplitude"].values).sum()) > 1
        verdicts.append(bool(driven and dominant and split and float(high[f"{prefix}flatness"]) > 0.01))
    return verdicts


@claim(
    "practical-voltage",
    "From 10 to 50 V the amplitude is nearly constant; these voltages lie orders of magnitude below any threshold.",
    9,
    "practical",
)
def practical_voltage(studies: Studies) -> Finding:
    study = studies["practical"]
    amplitude = study["window_amplitude"].values
    spread = np.ptp(amplitude, axis=1) / amplitude.mean(axis=1)
    highest = float(study["voltage_amplitude"].values.max())
    onset = float(np.nanmin(study["onset_voltage"].values))
    lowest = min(onset, float(np.nanmin(study["pitchfork_voltage"].values)))
    late = study["late_amplitude"].values[:, -1]
    return Finding(
        holds=bool((spread < SAME).all() and lowest > 100.0 * highest),
        numbers=(
            Number("lowest threshold (loss of stability of rest) over 50 V", lowest / highest),
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
