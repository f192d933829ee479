"""What the paper claims about the voltage."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.paper.claims.claim import Studies, claim
from gelcone.paper.reading import chaotic, finite_positive, first_chaos, fixed_branch, positive, share, share_number
from gelcone.paper.verdicts import Finding, Number
from gelcone.presets import find_preset

if TYPE_CHECKING:
    import xarray as xr

VOLTAGE_THRESHOLD = 1.04
"""From the paper's text."""
SAME = 0.05
"""Motions are indistinguishable when they differ by less than this share of their size: what a plot shows."""
NEARLY_ALL = 0.95
BANDWIDTH = 1.94
"""Bins over which the spectrum's window spreads noise."""


@claim(
    "voltage-threshold",
    "The largest exponent is at most zero below the voltage 1.04 and positive from there on.",
    13,
    "diagram-base-voltage",
    "diagram-fast-voltage",
)
def voltage_threshold(studies: Studies) -> Finding:
    branch = fixed_branch(studies["diagram-base-voltage"])
    other = fixed_branch(studies["diagram-fast-voltage"])
    voltage, growing, finite = branch["voltage"].values, positive(branch), finite_positive(branch)
    below, above = voltage < VOLTAGE_THRESHOLD, voltage >= VOLTAGE_THRESHOLD
    threshold = first_chaos(studies["diagram-base-voltage"], "voltage")
    second = first_chaos(studies["diagram-fast-voltage"], "voltage")
    pitchfork = float(np.sqrt(find_preset("base").model.stiffness(0.0)))
    return Finding(
        holds=bool(not growing[below].any() and share(growing[above]) >= NEARLY_ALL),
        holds_finite=bool(share(~finite[below]) >= NEARLY_ALL and share(finite[above]) >= NEARLY_ALL),
        share=share(growing[above]),
        neighbourhood="voltages from 1.04 to 2",
        numbers=(
            *(() if threshold is None else (threshold,)),
            share_number("share of voltages in 1.04 to 2 with a positive exponent", growing[above]),
            share_number("share of voltages below 1.04 with an exponent at most zero", ~growing[below]),
            share_number(
                "share of voltages in 1.04 to 2 with a positive exponent, set fast",
                positive(other)[other["voltage"].values >= VOLTAGE_THRESHOLD],
            ),
            *(
                ()
                if second is None
                else (Number("smallest voltage with chaos, set fast", second.value, low=second.low, high=second.high),)
            ),
            Number(
                "static pitchfork voltage, where rest loses its stability at constant voltage", pitchfork, error=0.0
            ),
        ),
        why="Chaos sets in near the stated voltage, above the loss of stability of rest, but windows of periodic "
        "motion "
        "interrupt it all the way up.",
        unseen="The periodic windows: over a short window their transients look chaotic. Instability of rest comes "
        "first "
        "and is not chaos.",
    )


@claim(
    "voltage-amplitude",
    "In the chaotic range the amplitude reaches about 6.",
    7,
    "diagram-base-voltage",
    "diagram-fast-voltage",
)
def voltage_amplitude(studies: Studies) -> Finding:
    def reach(name: str) -> tuple[float, float]:
        branch = fixed_branch(studies[name])
        size = np.fmax(np.abs(branch["lowest"].values), np.abs(branch["highest"].values))
        mask = chaotic(branch)
        at = int(np.nanargmax(np.where(mask, size, -1.0)))
        return float(size[at]), float(branch["voltage"].values[at])

    base, at = reach("diagram-base-voltage")
    fast, at_fast = reach("diagram-fast-voltage")
    near = [abs(value / 6.0 - 1.0) <= 0.2 for value in (base, fast)]
    return Finding(
        holds=near[0],
        share=share(near),
        neighbourhood="the two parameter sets",
        numbers=(
            Number(f"largest displacement in chaos up to v = 2, set base (at v = {at:.3g})", base, error=0.05 * base),
            Number(
                f"largest displacement in chaos up to v = 2, set fast (at v = {at_fast:.3g})", fast, error=0.05 * fast
            ),
        ),
        why="Within 20 % of 6 counts as about 6. The bound is the stretch limit: at J = 50 the film ends at x = 7.1.",
        unseen="An amplitude of 6 is six film widths out of plane; the film is near its stretch limit and the hoop "
        "slack.",
    )


@claim(
    "voltage-spectra",
    "At low voltage one line at the excitation frequency dominates; it splits at the threshold; above, the spectrum is "
    "broadband.",
    8,
    "spectra",
)
def voltage_spectra(studies: Studies) -> Finding:
    study = studies["spectra"]
    late, early = _spectral_order(study, ""), _spectral_order(study, "early_")
    base = list(study["set"].values).index("base")
    low, middle, high = (study.isel(set=base, voltage=i) for i in range(3))
    return Finding(
        holds=late[base],
        holds_finite=early[base],
        share=share(late),
        neighbourhood="the two parameter sets",
        numbers=(
            Number(
                "strongest line at low voltage from the start, over the drive's",
                _strongest(low, "early_"),
                error=float(np.diff(study["early_frequency_ratio"].values[:2])[0]),
            ),
            Number("swing left at low voltage in the long run (rms)", float(low["rms"]), error=1e-12),
            Number("spectral flatness at high voltage, long run", float(high["flatness"]), error=_flatness_error(high)),
        ),
        details={
            "share of power in lines at the threshold, long run": f"{float(middle['power_in_lines']):.3g}",
        },
        why="Needed: a strongest line at the frequency of the voltage or of its force (twice that) with most of the "
        "power at low voltage, several lines at the threshold, and a flatness above 0.01 at high voltage.",
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
            Number("lowest threshold (loss of stability of rest) over 50 V", lowest / highest, error=1e-3),
            Number("largest relative change of the amplitude over 10 to 50 V", float(spread.max()), error=1e-6),
            *(
                Number(
                    f"amplitude left in the long run at 50 V, initial height {h:g} mm", float(a), error=1e-9, unit="mm"
                )
                for h, a in zip(study["initial_height"].values, late, strict=True)
            ),
        ),
        why="The electric force goes with the square of the voltage: at 50 V it is smaller than at the threshold "
        "by the "
        "square of the ratio.",
        unseen="The amplitude is that of the release, not of the drive: in the long run the drive hardly moves the "
        "disc.",
    )
