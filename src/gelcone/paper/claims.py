"""The paper's claims: what it says, in our words, and how each is read off the studies.

Every check returns a `Finding` made of numbers; the verdict follows from it by the rules in `verdicts.judge`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.motion.regime import Regime
from gelcone.paper.agreement import agreement
from gelcone.paper.presets import find_preset
from gelcone.paper.reading import (
    chaotic,
    finite_positive,
    first_chaos,
    fixed_branch,
    positive,
    share,
    share_number,
)
from gelcone.paper.verdicts import Finding, Number

if TYPE_CHECKING:
    import xarray as xr

Studies = Mapping[str, "xr.Dataset"]

VOLTAGE_THRESHOLD = 1.04
"""From the paper's text."""
LIMIT_THRESHOLD = 1.5
"""From the paper's text."""
LINEAR = 0.01
"""An oscillation counts as linear while its period is within this share of the linear one."""
SAME = 0.05
"""Motions are indistinguishable when they differ by less than this share of their size: what a plot shows."""
NEARLY_ALL = 0.95
BANDWIDTH = 1.94
"""Bins over which the spectrum's window spreads noise."""


@dataclass(frozen=True)
class Claim:
    """A claim: ``check`` turns the Datasets of its ``studies``, by name, into a finding; ``figure`` shows it."""

    name: str
    statement: str
    figure: int
    studies: tuple[str, ...]
    check: Callable[[Studies], Finding]


CLAIMS: dict[str, Claim] = {}

Check = Callable[[Studies], Finding]


def claim(name: str, statement: str, figure: int, *studies: str) -> Callable[[Check], Check]:
    """Registers a check under the claim's name."""

    def register(check: Check) -> Check:
        CLAIMS[name] = Claim(name, statement, figure, studies, check)
        return check

    return register


@claim(
    "static-bistable",
    "At the highest of three voltages the static curve meets zero force three times, with slopes +, -, +.",
    3,
    "static",
)
def static_bistable(studies: Studies) -> Finding:
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
            Number("equilibria at the highest voltage", float(counts[-1]), error=0.0),
            *(Number(f"slope at x = {x:.4g}", float(s), error=1e-9) for x, s in zip(places, slopes, strict=False)),
            Number("pitchfork voltage, the square root of the small-signal stiffness", pitchfork, error=1e-9),
        ),
        why="Above the pitchfork voltage the flat state is unstable between two buckled ones; this follows from the "
        "energy alone.",
        unseen="The flat film is slack at these voltages: with pre-stretch 1 the hoop stress is compressive.",
    )


claim(
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
    study = studies["linear-limit"]
    amplitude, ratio = study["amplitude"].values, study["period_ratio"].values
    off = np.abs(ratio - 1.0)
    linear = off < LINEAR
    reach = float(np.interp(LINEAR, off, amplitude))
    return Finding(
        holds=bool(linear[-1]),
        share=reach / float(amplitude[-1]),
        neighbourhood="initial displacements from 0 to the paper's own, 1",
        numbers=(
            Number("largest displacement with the period within 1 % of the linear one", reach, error=1e-3),
            Number("period at the displacement 1 over the linear period", float(ratio[-1]), error=1e-5),
        ),
        why="The film's force x (1 - 1/q^2) is cubic at the flat state: linear means small, whatever the stretch "
        "limit.",
        unseen="How small the motion must be; at the paper's own initial state the oscillator is not linear.",
    )


@claim(
    "damping-never-chaotic",
    "Over damping ratios from 0 to 2 no motion is chaotic; the exponent is slightly positive only towards zero.",
    13,
    "diagram-base-damping-ratio",
    "diagram-fast-damping-ratio",
    "damping-map",
)
def damping_never_chaotic(studies: Studies) -> Finding:
    base = fixed_branch(studies["diagram-base-damping-ratio"])
    wide = studies["damping-map"]
    damped = base["damping_ratio"].values > 0.0
    regular = ~chaotic(base)
    by_voltage = {float(v): ~chaotic(wide.sel(voltage=v)).any() for v in wide["voltage"].values}
    undamped = base.isel(damping_ratio=0)
    return Finding(
        holds=bool(regular[damped].all()),
        holds_finite=bool(not finite_positive(base)[damped].any()),
        share=share(list(by_voltage.values())),
        neighbourhood="drive voltages from 0.5 to 2, each over damping ratios from 0.02 to 2",
        numbers=(
            share_number("share of damping ratios in (0, 2] without chaos", regular[damped]),
            Number(
                "largest exponent without damping",
                float(undamped["lyapunov"].values[0]),
                error=float(undamped["standard_error"].values[0]),
            ),
            Number(
                "largest drive voltage without chaos at any damping ratio",
                max([v for v, ok in by_voltage.items() if ok], default=float("nan")),
                error=float(np.diff(wide["voltage"].values)[0]),
            ),
        ),
        why="At this voltage rest is stable and attracts every motion; at a higher one little damping leaves chaos.",
        unseen="That the statement is one about the chosen voltage: it lies below the loss of stability of rest. "
        "Without "
        "damping the exponent over a window T falls like log(T)/T, which looks slightly positive in any window.",
    )


@claim(
    "damping-order",
    "Small damping gives slow decay, large damping an overdamped return.",
    4,
    "diagram-base-damping-ratio",
)
def damping_order(studies: Studies) -> Finding:
    base = fixed_branch(studies["diagram-base-damping-ratio"])
    base = base.sel(damping_ratio=base["damping_ratio"] > 0.0)
    zeta, exponents = base["damping_ratio"].values, base["lyapunov"].values
    error = np.maximum(base["standard_error"].values[:, 0], 1e-6)
    # Overdamped motion has two real decay rates; oscillating motion has -zeta twice.
    overdamped = exponents[:, 0] - exponents[:, 1] > np.maximum(6.0 * error, 0.02 * zeta)
    stiffness = float(find_preset("base").model.stiffness(0.0))
    first = zeta[overdamped].min() if overdamped.any() else float("nan")
    slow = bool((exponents[zeta < 0.3, 0] < 0.0).all())
    at_largest_drawn = bool(np.interp(0.5, zeta, overdamped.astype(float)) > 0.5)
    return Finding(
        holds=slow and at_largest_drawn,
        holds_finite=slow and at_largest_drawn,
        share=share(overdamped),
        neighbourhood="damping ratios up to 2",
        numbers=(
            Number("smallest overdamped damping ratio on the grid", float(first), error=float(np.diff(zeta)[0])),
            Number(
                "square root of the small-signal stiffness: critical damping without voltage", stiffness**0.5, error=0.0
            ),
        ),
        why="The order is right, but the largest damping ratio drawn (0.5) still oscillates about the flat state.",
        unseen="Where overdamping begins: at the root of the small-signal stiffness, less what the voltage takes.",
    )


@claim(
    "limit-threshold",
    "Chaos for stretch limits below about 1.5, stable motion above.",
    13,
    "diagram-fast-stretch-limit",
    "limit-map",
)
def limit_threshold(studies: Studies) -> Finding:
    diagram, plane = studies["diagram-fast-stretch-limit"], studies["limit-map"]
    branch = fixed_branch(diagram)
    limits, chaos = branch["stretch_limit"].values, chaotic(branch)
    threshold = first_chaos(diagram, "stretch_limit", falling=True)
    below = limits < LIMIT_THRESHOLD
    largest = {float(v): _largest(plane, float(v)) for v in plane["voltage"].values}
    lowest = float(plane["stretch_limit"].values.min())
    near = [bool(LIMIT_THRESHOLD / 1.5 <= j <= LIMIT_THRESHOLD * 1.5) for j in largest.values()]
    holds = threshold is not None and abs(threshold.value / LIMIT_THRESHOLD - 1.0) <= 0.2
    finite = finite_positive(branch)
    extra = () if threshold is None else (threshold,)
    return Finding(
        holds=bool(holds),
        holds_finite=bool(share(finite[below]) >= NEARLY_ALL and not finite[~below].any()),
        share=share(near),
        neighbourhood="drive voltages from 0.7 to 1.6 (threshold between 1 and 2.25)",
        numbers=(
            *extra,
            share_number("share of stretch limits below 1.5 with chaos", chaos[below]),
            share_number("share of stretch limits above 1.5 with chaos", chaos[~below]),
        ),
        why="A low stretch limit stiffens the film within reach of the motion; how low it must be follows the voltage.",
        unseen="The largest chaotic stretch limit over voltage: "
        + ", ".join(f"{j:.3g} at v = {v:.3g}" if j == j else f"none at v = {v:.3g}" for v, j in largest.items())
        + ".",
        details={
            f"largest chaotic stretch limit at v = {v:.3g}": f"{j:.3g}" if j == j else f"none from {lowest:.3g} on"
            for v, j in largest.items()
        },
    )


def _largest(plane: xr.Dataset, voltage: float) -> float:
    row = plane.sel(voltage=voltage)
    limits = row["stretch_limit"].values[chaotic(row)]
    return float(limits.max()) if limits.size else float("nan")


@claim("limit-large-same", "Large stretch limits are indistinguishable from one another.", 5, "large-limits")
def limit_large_same(studies: Studies) -> Finding:
    study = studies["large-limits"]
    x = study["displacement"].values
    window = np.abs(x - x[:, -1:]).max(axis=-1) / np.abs(x).max(axis=-1)
    # Mirror images count as the same motion: which of the two a motion ends on is a matter of its start.
    highest = np.fmax(np.abs(study["highest"].values), np.abs(study["lowest"].values))
    extent = np.abs(highest - highest[:, -1:]) / np.maximum(highest[:, -1:], 0.01)
    voltages = study["voltage"].values[:, 0]
    own = int(np.argmin(np.abs(voltages - 1.005)))
    same_long, same_window = (extent < SAME).all(axis=1), (window < SAME).all(axis=1)
    error = 1e-4 / highest[own, -1]
    return Finding(
        holds=bool(same_long[own]),
        holds_finite=bool(same_window[own]),
        share=share(same_long),
        neighbourhood=f"{len(voltages)} drive voltages from {voltages.min():g} to {voltages.max():g}",
        numbers=(
            Number(
                "difference of the extents in the long run, J = 100 against 1000", float(extent[own, 0]), error=error
            ),
            share_number("share of voltages from 0.5 to 1.7 with the same extent in the long run", same_long),
            share_number("share of these voltages with the same time series over the window", same_window),
            Number("difference of the time series over the window, v = 1.005", float(window[own, 0]), error=1e-9),
        ),
        why="While I1 - 3 stays far below J, Gent's film is neo-Hookean to the order (I1 - 3)/J.",
        unseen="In chaos no two stretch limits give the same time series, however large they are. The verdict is that "
        f"of v = {voltages[own]:g}; of all voltages looked at the claim holds on {int(same_long.sum())} of "
        f"{same_long.size}.",
    )


@claim(
    "limit-tiny-negative",
    "As the stretch limit goes to zero the largest exponent is locally negative.",
    13,
    "beyond",
)
def limit_tiny_negative(studies: Studies) -> Finding:
    study = studies["beyond"]
    limits = study["stretch_limit"].values
    needed = float(study["initial_strain"].values[0])
    outside = limits <= needed
    fixed = study["fixed_step_exponent"].values
    inside = study["lyapunov"].values[:, 0]
    error = study["standard_error"].values[:, 0]
    smallest = int(np.argmin(limits))
    negative = inside[outside] < -3.0 * error[outside]
    found = f"{int(negative.sum())} of {negative.size}"
    return Finding(
        holds=False,
        holds_finite=False,
        holds_fixed_step=bool((fixed[outside] < 0.0).any()),
        share=share(negative),
        neighbourhood="stretch limits from 0.02 to 0.5, each with a motion from half the displacement that it allows",
        numbers=(
            Number("smallest stretch limit that the paper's initial state allows", needed, error=0.0),
            share_number("share of smaller ones with a negative exponent, from inside the limit", negative),
            Number("exponent at the smallest limit from inside", float(inside[smallest]), error=float(error[smallest])),
            Number("exponent of the fixed-step run there, beyond the limit", float(fixed[smallest]), error=0.0),
        ),
        why=f"The initial displacement 1 strains the film to I1 - 3 = {needed:g}: for any smaller stretch limit "
        "there is no such motion. A fixed-step integrator starts on the unphysical side all the same and runs off to "
        f"infinity. From inside, {found} stretch limits have a negative exponent: periodic windows, which a finer "
        "search would find more of, so that this verdict says that there are such windows and not how many.",
        unseen="That the initial state lies beyond the stretch limit, where the energy is not defined.",
    )


@claim(
    "energy-steepening",
    "The energy curves steepen as the stretch limit falls; for J = 1 the energy rises sharply near the limit.",
    6,
    "energy",
)
def energy_steepening(studies: Studies) -> Finding:
    study = studies["energy"]
    limits, x = study["stretch_limit"].values, study["displacement"].values
    force = study["film_force"].values[:, x > 0.0]
    steeper = [bool((a[np.isfinite(a)] > b[np.isfinite(a)]).all()) for a, b in pairwise(force)]
    one = int(np.flatnonzero(limits == 1.0)[0])
    reach = float(study["reach"].values[one])
    near = int(np.argmin(np.abs(x[x > 0.0] - 0.95 * reach)))
    sharp = float(force[one, near] / force[-1, near])
    return Finding(
        holds=all(steeper) and sharp > 2.0,
        numbers=(
            share_number("share of neighbouring stretch limits of which the smaller is steeper everywhere", steeper),
            Number("displacement at which the film with J = 1 ends", reach, error=1e-9),
            Number("slope for J = 1 over that for J = 100, at 95 % of that displacement", sharp, error=1e-6),
        ),
        why="The film's force is x (A - G/q^2) over 1 - (I1 - 3)/J, which grows as J falls at every displacement.",
        unseen="The energy grows only like a logarithm at the limit: an integrator without a guard can step across.",
    )


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
        unseen="The amplitude is that of the release, not of the drive: in the long run the drive moves the disc "
        "hardly.",
    )


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
        "a soft spring lets a large, strongly nonlinear motion take over.",
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
    size = np.fmax(np.fmax(up, down).max(axis=1), 1e-9)
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


@claim(
    "map-high-voltage",
    "At high voltage the largest exponent is predominantly positive whatever the pre-stretch.",
    14,
    "map-radial",
    "map-equibiaxial",
)
def map_high_voltage(studies: Studies) -> Finding:
    def shares(mode: str) -> Any:
        plane = studies[f"map-{mode}"]
        high = plane.sel(voltage=plane["voltage"] >= 1.6)
        return np.mean(positive(high), axis=high["regime"].dims.index("voltage"))

    radial, equibiaxial = shares("radial"), shares("equibiaxial")
    return Finding(
        holds=bool(radial.mean() > 0.5),
        share=share(np.concatenate([radial, equibiaxial]) > 0.5),
        neighbourhood="pre-stretches from 0.4 to 2, radial and equi-biaxial, each over v from 1.6 to 2",
        numbers=(
            share_number(
                "share of the radial map above v = 1.6 with a positive exponent", positive(_high(studies["map-radial"]))
            ),
            share_number("the same, equi-biaxial", positive(_high(studies["map-equibiaxial"]))),
            Number(
                "smallest such share of one radial pre-stretch", float(radial.min()), low=0.0, high=float(radial.min())
            ),
        ),
        why="Predominantly means more than half of the voltages above 1.6.",
        unseen="Which pre-stretch was meant: stretched in both directions the film stiffens, and less of the map is "
        "chaotic.",
    )


def _high(plane: xr.Dataset) -> xr.Dataset:
    return plane.sel(voltage=plane["voltage"] >= 1.6)


@claim(
    "map-low-prestretch",
    "At small pre-stretch the motion is chaotic already at moderate voltage.",
    14,
    "map-radial",
    "map-equibiaxial",
)
def map_low_prestretch(studies: Studies) -> Finding:
    def early(mode: str, finite: bool = False) -> Any:
        plane = studies[f"map-{mode}"].transpose("prestretch", "voltage", ...)
        low = plane.sel(prestretch=plane["prestretch"] <= 0.8, voltage=plane["voltage"] < VOLTAGE_THRESHOLD)
        return (finite_positive(low) if finite else chaotic(low)).any(axis=1)

    radial, equibiaxial = early("radial"), early("equibiaxial")
    return Finding(
        holds=bool(radial.mean() > 0.5),
        holds_finite=bool(early("radial", finite=True).mean() > 0.5),
        share=share(np.concatenate([radial, equibiaxial])),
        neighbourhood="pre-stretches from 0.4 to 0.8, radial and equi-biaxial",
        numbers=(
            share_number("share of radial pre-stretches up to 0.8 with chaos below v = 1.04", radial),
            share_number("the same, equi-biaxial", equibiaxial),
        ),
        why="Moderate means below the threshold 1.04 of the film without pre-stretch; a pre-stretch below 1 is a slack "
        "film that buckles out of plane, so that the motion has two sides to choose from without any voltage.",
        unseen="Below 1 the film is compressed when flat, and the membrane model does not hold.",
    )


@claim(
    "map-safe-prestretch",
    "Above some pre-stretch the motion is periodic over the whole range of voltage.",
    14,
    "map-radial",
    "map-equibiaxial",
)
def map_safe_prestretch(studies: Studies) -> Finding:
    def safe(mode: str) -> Any:
        plane = studies[f"map-{mode}"]
        return ~np.any(chaotic(plane), axis=plane["regime"].dims.index("voltage"))

    stretches = studies["map-radial"]["prestretch"].values
    radial, equibiaxial = safe("radial"), safe("equibiaxial")
    calm = np.flatnonzero(~equibiaxial)
    edge = float(stretches[min(calm[-1] + 1, len(stretches) - 1)]) if calm.size else float(stretches[0])
    window = ~np.any(finite_positive(studies["map-radial"]), axis=studies["map-radial"]["regime"].dims.index("voltage"))
    return Finding(
        holds=bool(radial[-1]),
        holds_finite=bool(window[-1]),
        share=share(np.concatenate([radial, equibiaxial])),
        neighbourhood="pre-stretches from 0.4 to 2, radial and equi-biaxial",
        numbers=(
            share_number("share of radial pre-stretches without chaos up to v = 2", radial),
            share_number("share of equi-biaxial pre-stretches without chaos up to v = 2", equibiaxial),
            Number(
                "equi-biaxial pre-stretch from which on there is no chaos up to v = 2",
                edge if equibiaxial[-1] else float("nan"),
                error=float(np.diff(stretches)[0]),
            ),
        ),
        why="The largest pre-stretch of the map decides: chaos-free up to v = 2, or not.",
        unseen="That the answer hangs on what pre-stretch means; the paper's wording fits the radial reading.",
    )


@claim(
    "stable-pocket",
    "A narrow pocket of negative exponents is surrounded by a transitional domain.",
    14,
    "map-radial",
    "map-equibiaxial",
)
def stable_pocket(studies: Studies) -> Finding:
    radial, equibiaxial = (_pockets(studies[f"map-{mode}"]) for mode in ("radial", "equibiaxial"))
    return Finding(
        holds=bool(radial),
        share=share([bool(radial), bool(equibiaxial)]),
        neighbourhood="radial and equi-biaxial pre-stretch",
        numbers=(
            Number("enclosed pockets of negative exponents in the radial map", float(len(radial)), error=0.0),
            Number("cells in the largest of them", float(max(radial, default=0)), error=0.0),
            Number("enclosed pockets in the equi-biaxial map", float(len(equibiaxial)), error=0.0),
        ),
        why="A pocket is a connected set of at least two cells with a certainly negative exponent that touches neither "
        "the edge of the map nor the large regular domain.",
        unseen="How many there are: periodic windows riddle the chaotic domain, and finer maps show more of them.",
    )


def _pockets(plane: xr.Dataset) -> list[int]:
    """Cells of each enclosed pocket of a map."""
    from scipy import ndimage

    regular = (plane["sign"].values < 0) & (plane["regime"].values == Regime.PERIODIC)
    labels, count = ndimage.label(regular)
    edge = {*labels[0], *labels[-1], *labels[:, 0], *labels[:, -1]}
    grown = ndimage.binary_dilation(np.isin(plane["regime"].values, [Regime.REST]))
    pockets = []
    for number in range(1, count + 1):
        cells = labels == number
        if number not in edge and cells.sum() >= 2 and not (cells & grown).any():
            pockets.append(int(cells.sum()))
    return pockets
