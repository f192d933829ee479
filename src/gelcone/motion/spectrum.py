"""Amplitude spectrum of the displacement, its lines, and their share of the power.

The window is cos^4 (the square of Hann's; Rife and Vincent's class I of order 2, Bell Syst. Tech. J. 49 (1970) 197).
Its sidelobes fall by 30 dB an octave, so that weak lines and the floor show next to strong lines. Its transform has a
closed form, which gives the frequency and amplitude of a line between two bins exactly.

For a drive that does not repeat the record is the whole run. A cosine tapers its ends (Tukey's window): a chirp has
each frequency at a time of its own, and cos^4 would fade the lowest and the highest. Such a spectrum has no lines.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.dataset import Findings, with_initial
from gelcone.devices.analysis import analysis
from gelcone.errors import InputError
from gelcone.motion.averages import of_record
from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate
from gelcone.motion.settle import (
    MOST_PER_REPEAT,
    STILL,
    blocks,
    check_forcing_periods,
    next_power_of_two,
    pieces,
    samples_per_repeat,
    settle,
)
from gelcone.motion.start import start_states
from gelcone.motion.static_results import padded
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.progress import Progress, advance, split_progress, weighted
from gelcone.quantity import Array, check_count

if TYPE_CHECKING:
    import xarray as xr

LOBE = 3
"""Half the width of the window's main lobe, in bins; closer lines are not resolved."""
STANDS_OUT = 14.0
"""Least height of a line above the running median around it, in dB: one bin in 3e7 of Gaussian noise, like chaos
without lines, reaches it."""
FEWEST_PERIODS = 16
MOST_LINES = 64
BAND = 2.0
SMALLEST_BAND = 8.0
SAMPLES_PER_OSCILLATION = 13
OVERSAMPLING = 4
"""Least number of samples in a period of the highest frequency of the band."""
FOLDED = 1e-5
"""Largest amplitude at the end of the sampled band, over the largest of all; else the sampling is refined."""
REFINEMENT = 4
MOST_SAMPLES = 2**21
"""Most samples of a record."""
TAPERED = 0.1
"""Share of the run that is tapered for a drive that does not repeat, half of it at each end."""
PERIODS, DISCARD = 256, 200
"""Default length of a record and default time discarded before it, in periods of a drive that repeats."""


@analysis(
    answers="trajectories",
    examples=("--set voltage=1.7 --set drive_frequency=0.1 --out results", "paper-table1 --json"),
)
def spectrum(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    periods: int | None = None,
    discard: int | None = None,
    highest: float | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute the amplitude spectrum of the displacement: a sine of amplitude a is a line of height a.

    For a drive that repeats it is the spectrum of the settled motion, with lines. For one that does not it is that of
    the whole run, and amplitudes are those of sines as long as the record.

    Parameters
    ----------
    model : one actuator or an ensemble.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    periods : length of the record in periods 2 pi/omega of the voltage, at least 16; bins are 1/periods of the drive
        frequency apart, and lines less than 3 bins apart are not resolved. Default 256. For a drive that does not
        repeat, the length in lengths of the drive, at least 1 (default); more record the free motion after it.
    discard : forcing periods (see `section`) before the record, in which the motion settles; the rest of a transient
        shows as broad feet or faint lines next to the others. Default 200; 0 for a drive that does not repeat.
    highest : upper end of the band, in units of the drive frequency, at least 1; default a power of two,
        at least 8, that holds twice the fastest rate of the motion and twice the fastest swing of a drive that does not
        repeat, whose own frequency is one cycle in its length; each member its own, NaN beyond.
    tolerance : relative error of one step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dims, and for some variables one of these dims:

    * ``frequency_ratio``: frequency over that of the voltage (the force of a pure sine lies at 2), along with
      ``frequency``, the same as a dimensionless angular frequency (hertz in SI units). ``amplitude`` is one-sided; at 0
      it is the absolute value of the mean displacement. Noise shows with the window's bandwidth of 1.94 bins.
    * ``line``: the strongest first, at most 64, padded with NaN. ``line_ratio``, ``line_frequency`` and
      ``line_amplitude`` are interpolated between bins; ``line_prominence`` is in dB above the higher of the gaps that
      separate it from stronger lines. A peak counts as a line when it stands 14 dB above those gaps and above the
      running median over one drive frequency, and above ``aliasing_bound``.

    ``power_in_lines`` is the share of the displacement's variance in the main lobes of lines. ``flatness`` is the
    geometric over the arithmetic mean of the power in all bins above 0 up to ``highest``, amplitudes below 1e-12
    counted as 1e-12 (near 0: lines only; 0.56: white noise). ``mean_displacement`` and ``rms`` (about the mean) are
    those of the record, each with its ``..._standard_error``, 0 of a motion that repeats: those of another run of
    one that does not differ by it. A motion of rms below 1e-12 stands still: it has no lines, and shares are NaN.
    ``aliasing_bound`` bounds the error of any amplitude by aliasing: the largest amplitude in the last eighth of the
    sampled band, in which spectra already fall. Records are sampled again, finer, until it is below 1e-5 of the largest
    amplitude or a record has 2,097,152 samples.

    For a drive that does not repeat there is no ``line``, and ``power_in_lines`` is NaN. A cosine tapers 5 % of the
    record at each end (Tukey's window); the rest has equal weight.

    Raises
    ------
    InputError : for too few periods, a negative discard, one of a drive that does not repeat, a band out of range, or
        an initial state of which no member lies inside its stretch limit.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
    >>> lines = gelcone.spectrum(model)
    >>> [f"{a:.5f} at {f:.3f}" for a, f in zip(lines.line_amplitude.values[:2], lines.line_frequency.values[:2])]
    ['0.20463 at 1.000', '0.03230 at 2.000']
    """
    states0, members = start_states(model, initial), model.members()
    periods, discard = _lengths(members, periods, discard)
    options: dict[str, Any] = {"periods": periods, "discard": discard, "highest": highest, "tolerance": tolerance}
    variables, outcome = spectrum_cells(members, states0, **options, threads=threads, progress=progress)
    lines = max(1, int(np.isfinite(variables["line_ratio"][1]).sum(axis=1).max()))
    variables = {name: _cut(variable, lines) for name, variable in variables.items()}
    ratio = np.arange(variables["amplitude"][1].shape[1]) / periods
    omega = members.number("drive_frequency")[:, None]
    shared = bool((omega == omega[0]).all())
    frequency = ratio * omega[0] if shared else ratio * omega
    coords: dict[str, dataset.Variable] = {
        "frequency_ratio": (("frequency_ratio",), ratio, _RATIO, "ratio"),
        "frequency": (("frequency_ratio",), frequency, "angular frequency", "frequency"),
    }
    result = dataset.label(model, variables, coords=coords, outcome=outcome, options=options, title="spectrum")
    result["line_prominence"].attrs["units"] = "dB"
    return with_initial(result, model, states0)


def _cut(variable: dataset.Variable, lines: int) -> dataset.Variable:
    """A variable without the padding beyond a number of lines."""
    dims, values, long_name, quantity = variable
    return (dims, values[:, :lines], long_name, quantity) if dims == ("line",) else variable


def spectrum_cells(
    members: Members,
    states: Array,
    *,
    periods: int | None = None,
    discard: int | None = None,
    highest: float | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> Findings:
    """Compute `spectrum` for every member of a flattened ensemble from its state (members, N); options as there.

    Over ``line`` there are always 64 places; the length of ``frequency_ratio`` depends on the members unless
    ``highest`` is given.
    """
    periods, discard = _lengths(members, periods, discard)
    bands = _bands(members, highest, periods)
    flow: dict[str, Any] = {"tolerance": tolerance, "threads": threads}
    settling, left = split_progress(progress, discard, 2 * periods)
    states, outcome = settle(members, states, discard, progress=settling, **flow)
    samples, most = _sampling(members, bands, periods)
    analysed = analyse if members.system.waveform.repeat else analyse_run
    spectra = [NOTHING] * members.size
    coarse = np.arange(members.size)
    while coarse.size:
        # How many must be sampled anew is not known beforehand, so that each round takes half of the bar that is left.
        now, left = split_progress(left, 1.0, 1.0)
        part = (members.take(coarse), states[coarse], outcome[coarse], periods, samples[coarse])
        for i, record, end in _records(*part, progress=now, **flow):
            spectra[coarse[i]] = analysed(record, periods, bands[coarse[i]])
            outcome[coarse[i]] = end
        folds = np.array([spectra[member].folds for member in coarse])
        coarse = coarse[folds & (REFINEMENT * samples[coarse] <= most[coarse])]
        samples[coarse] *= REFINEMENT
    advance(left, 1.0)
    bins = None if highest is None else int(float(highest) * periods + 1e-6) + 1
    return Findings(_variables(members, spectra, bins), outcome)


def _lengths(members: Members, periods: int | None, discard: int | None) -> tuple[int, int]:
    """The periods of the record and those that pass before it; `InputError` for too few of them."""
    waveform = members.system.waveform
    if waveform.repeat:
        periods, discard = PERIODS if periods is None else periods, DISCARD if discard is None else discard
        check_forcing_periods(members, periods=periods)
        if periods < FEWEST_PERIODS:
            least = f"must be at least {FEWEST_PERIODS}"
            raise InputError(f"periods = {periods}: {least}, or the lines of the spectrum run into each other")
        check_forcing_periods(members, discard=discard)
        return periods, discard
    if discard:
        raise InputError(
            f"discard = {discard}: waveform = {waveform.name} does not repeat: its record begins at the start of the "
            "run; leave discard out"
        )
    check_count("periods", 1 if periods is None else periods, 1)
    return periods or 1, 0


def _bands(members: Members, highest: float | None, periods: int) -> Array:
    """Upper end of each member's band in units of its drive frequency, (members,)."""
    most = (MOST_PER_REPEAT if members.system.waveform.repeat else MOST_SAMPLES // periods) // OVERSAMPLING
    if highest is None:
        fastest = np.maximum(members.rate / members.number("drive_frequency"), SMALLEST_BAND / BAND)
        if not members.system.waveform.repeat:
            fastest = np.maximum(fastest, members.system.waveform.detail(members.numbers()))
        wanted = next_power_of_two(BAND * fastest)
        return np.minimum(wanted, most).astype(float)
    try:
        value = float(highest)
    except (TypeError, ValueError):
        raise InputError(f"highest = {highest!r}: must be a number, in units of the drive frequency") from None
    if not 1.0 <= value <= most:
        raise InputError(f"highest = {value:g}: must be from 1 to {most} times the drive frequency")
    return np.full(members.size, value)


def _sampling(members: Members, bands: Array, periods: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
    """First and largest number of samples in a forcing period, (members,) each; for a drive that does not repeat, in
    its length."""
    if not members.system.waveform.repeat:
        oscillations = SAMPLES_PER_OSCILLATION * members.rate * members.drive_period / (2.0 * np.pi)
        most = np.full(members.size, MOST_SAMPLES // periods)
        return np.minimum(next_power_of_two(np.maximum(oscillations, OVERSAMPLING * bands)), most), most
    per_period = _repeats_per_period(members)
    least = next_power_of_two(OVERSAMPLING * bands / per_period)
    first = np.maximum(samples_per_repeat(members, SAMPLES_PER_OSCILLATION), least)
    return first, np.minimum(MOST_PER_REPEAT, MOST_SAMPLES // (periods * per_period))


def _repeats_per_period(members: Members) -> npt.NDArray[np.int64]:
    """Forcing periods in a period of the voltage, (members,): 2 for a pure sine, 1 with a bias."""
    return np.rint(members.drive_period / members.forcing_period).astype(np.int64)


def _records(
    members: Members,
    states: Array,
    outcome: npt.NDArray[np.int8],
    periods: int,
    samples: npt.NDArray[np.int64],
    progress: Progress,
    **flow: Any,
) -> Iterator[tuple[int, Array, int]]:
    """Number of each member, its displacement sampled evenly over whole drive periods, and its outcome.

    ``samples`` (members,) in a forcing period; ``states`` (members, N) at phase 0, ``outcome`` until then.
    """
    if not members.system.waveform.repeat:
        for (size,), rows in blocks(periods * samples):
            part, share = members.take(rows), weighted(progress, rows.size / members.size)
            times = np.arange(size) / (size // periods) * part.drive_period[:, None]
            run = integrate(part, states[rows], times, progress=share, **flow)
            yield from zip(rows.tolist(), run.states[..., 0], run.outcome.tolist(), strict=True)
        return
    repeats = periods * _repeats_per_period(members)
    for (size, each), rows in blocks(repeats * samples, samples):
        part, share = members.take(rows), weighted(progress, rows.size / members.size)
        ends = outcome[rows]
        record = np.empty((rows.size, size))
        shares = np.arange(each) / each
        for piece in pieces(part, states[rows], size // each, shares, outcome=ends, progress=share, **flow):
            begin = piece.first * each
            record[:, begin : begin + piece.repeats * each] = piece.states[:, :-1, 0]
            ends = piece.outcome
        yield from zip(rows.tolist(), record, ends.tolist(), strict=True)


# --- one record -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Spectrum:
    """Spectrum of one record; frequencies in units of the drive frequency.

    ``amplitude`` (bins,); ``lines`` (lines, 3) with frequency, amplitude and prominence in dB, the strongest first; the
    others as in `spectrum`.
    """

    amplitude: Array
    lines: Array
    power_in_lines: float
    flatness: float
    aliasing_bound: float
    mean: float
    rms: float
    mean_standard_error: float = np.nan
    rms_standard_error: float = np.nan

    @property
    def folds(self) -> bool:
        """True if finer sampling would change the spectrum."""
        return bool(self.aliasing_bound > FOLDED * self.amplitude[1:].max(initial=0.0))


NOTHING = Spectrum(np.empty(0), np.empty((0, 3)), np.nan, np.nan, np.nan, np.nan, np.nan)


def analyse(record: Array, periods: int, highest: float) -> Spectrum:
    """The `Spectrum` of an even record over whole drive periods, up to ``highest``; `NOTHING` if it contains NaN."""
    sampled, without_lines = _windowed(
        record, np.sin(np.pi * np.arange(record.size) / record.size) ** 4, periods, highest
    )
    if not without_lines.rms >= STILL:
        return without_lines
    # a lobe beyond the band is needed to recognise a line at its very end
    bins = without_lines.amplitude.size
    peaks, prominences = _peaks(sampled[: bins + LOBE], periods, without_lines.aliasing_bound)
    kept = peaks < bins
    peaks, prominences = peaks[kept], prominences[kept]
    ratios, heights = _interpolated(sampled, peaks)
    lines = np.column_stack([ratios / periods, heights, prominences])
    power, errors = _power(without_lines.amplitude), of_record(record, periods)
    return replace(
        without_lines,
        lines=lines[np.argsort(-heights, kind="stable")][:MOST_LINES],
        power_in_lines=float(power[_in_lobes(peaks, power.size)].sum() / power.sum()),
        mean_standard_error=errors[0],
        rms_standard_error=errors[1],
    )


def analyse_run(record: Array, periods: int, highest: float) -> Spectrum:
    """The `Spectrum` of an even record of the run of a drive that does not repeat, which has no lines."""
    from scipy.signal.windows import tukey

    return _windowed(record, tukey(record.size, TAPERED, sym=False), periods, highest)[1]


def _windowed(record: Array, window: Array, periods: int, highest: float) -> tuple[Array, Spectrum]:
    """Amplitudes of a windowed record at all frequencies, and its `Spectrum` without lines."""
    if not np.isfinite(record).all():
        return np.empty(0), NOTHING
    total = window.sum()
    mean = float((window * record).sum() / total)
    swing = record - mean
    rms = float(np.sqrt((window * swing * swing).sum() / total))
    sampled = 2.0 * np.abs(np.fft.rfft(window * swing)) / total
    sampled[0] = abs(mean)
    # the small addition corrects the rounding of products such as 0.1 * 30
    without_lines = replace(NOTHING, amplitude=sampled[: int(highest * periods + 1e-6) + 1], mean=mean, rms=rms)
    if rms < STILL:
        return sampled, without_lines
    power = _power(without_lines.amplitude)
    flatness = float(np.exp(np.log(power).mean()) / power.mean())
    return sampled, replace(
        without_lines, flatness=flatness, aliasing_bound=float(sampled[-(sampled.size // 8) :].max())
    )


def _power(amplitude: Array) -> Array:
    """The squares of the amplitudes above frequency 0."""
    return np.maximum(amplitude[1:], STILL) ** 2


def _peaks(amplitude: Array, periods: int, least: float) -> tuple[npt.NDArray[np.intp], Array]:
    """Bins of the lines, and the height of each above the higher of the gaps on its sides, in dB."""
    from scipy.ndimage import median_filter
    from scipy.signal import find_peaks

    level = _decibels(amplitude)
    # a slow drift gives a slope next to the mean that looks like a line
    level[:LOBE] = level[LOBE]
    lowest = np.maximum(median_filter(level, size=periods | 1, mode="reflect") + STANDS_OUT, _decibels(least))
    peaks, properties = find_peaks(level, height=lowest, prominence=STANDS_OUT, distance=LOBE)
    return peaks, properties["prominences"]


def _decibels(amplitude: Any) -> Any:
    return 20.0 * np.log10(np.maximum(amplitude, STILL))


def _interpolated(amplitude: Array, peaks: npt.NDArray[np.intp]) -> tuple[Array, Array]:
    """Frequencies (in bins) and amplitudes of lines between the bins.

    A line d bins above a bin has there W(d) = sin(pi d)/(pi d) / ((1 - d^2)(1 - d^2/4)) of its amplitude, so that the
    ratio r of the next bin to this one is (2 + d)/(3 - d).
    """
    below, here, above = amplitude[peaks - 1], amplitude[peaks], amplitude[peaks + 1]
    r = np.maximum(below, above) / here
    d = np.clip((3.0 * r - 2.0) / (1.0 + r), 0.0, 0.5)
    transform = np.sinc(d) / ((1.0 - d * d) * (1.0 - 0.25 * d * d))
    return peaks.astype(float) + np.where(above > below, d, -d), here / transform


def _in_lobes(peaks: npt.NDArray[np.intp], bins: int) -> npt.NDArray[np.bool_]:
    """Mask of the bins above 0 that lie in the main lobe of a line."""
    inside = np.zeros(bins, dtype=bool)
    for offset in range(-LOBE, LOBE + 1):
        inside[np.clip(peaks - 1 + offset, 0, bins - 1)] = True
    return inside


# --- all members ------------------------------------------------------------------------------------------------------

_RATIO = "frequency over the frequency of the voltage"
_NUMBERS = {
    "power_in_lines": ("share of the displacement's variance that lies in lines", "share"),
    "flatness": ("spectral flatness: geometric over arithmetic mean of the power in the band", "share"),
    "aliasing_bound": ("bound of what aliasing adds to an amplitude", "length"),
    "mean": ("mean displacement", "length"),
    "rms": ("root mean square of the displacement about its mean", "length"),
    "mean_standard_error": ("standard error of the mean displacement, 0 of a motion that repeats", "length"),
    "rms_standard_error": ("standard error of the root mean square, 0 of a motion that repeats", "length"),
}


def _variables(members: Members, spectra: list[Spectrum], bins: int | None) -> dict[str, dataset.Variable]:
    """Variables of all members' spectra, padded with NaN to at least ``bins`` bins and `MOST_LINES` lines."""
    amplitude, lines = padded([s.amplitude for s in spectra], bins or 1), padded([s.lines for s in spectra], MOST_LINES)
    omega = members.number("drive_frequency")[:, None]
    variables: dict[str, dataset.Variable] = {
        "amplitude": (("frequency_ratio",), amplitude, "amplitude of the displacement", "length"),
        "line_ratio": (("line",), lines[..., 0], f"{_RATIO}, of a line", "ratio"),
        "line_frequency": (("line",), lines[..., 0] * omega, "angular frequency of a line", "frequency"),
        "line_amplitude": (("line",), lines[..., 1], "amplitude of a line", "length"),
        "line_prominence": (("line",), lines[..., 2], "height of a line above the gaps on its sides", "level"),
    }
    for name, meaning in _NUMBERS.items():
        values = np.array([getattr(s, name) for s in spectra])
        variables[name.replace("mean", "mean_displacement")] = ((), values, *meaning)
    return variables
