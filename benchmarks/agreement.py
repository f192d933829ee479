"""One question has one answer: random devices are asked the same question of several commands.

    python benchmarks/agreement.py [DEVICES] [SEED]      (default 24 and 2026)

Each shipped device that has a film is taken with random springs, sizes, masses, films, materials, circuits and drives.
Every answer that two commands give is compared: stroke, power, apparent power, field, current and charge of the
settled motion with those of the data sheet, the envelope, the regime, maps, bifurcation diagrams, frequency
responses, extremes and a long run; exponents; means and harmonics with those of the spectrum; the response to a small
voltage with the linear one; static forces with those of slow ramps and with where a step ends; pull-in and the other
limits. `QUESTIONS` says how near two answers must be, and why not nearer. Devices that a command refuses are counted
with its reason. A driven limit is compared with runs from rest: one at its voltage meets it, one below by the stated
width does not.

Printed are the number of comparisons of each question, the largest difference, and each one that is too large.
"""

from __future__ import annotations

import sys
import time
import warnings
from collections import defaultdict
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import gelcone
from gelcone.codes import Outcome, Regime
from gelcone.motion.plane import NUDGE

DEVICES = ("biased-pump", "soft-film", "beam-cone", "double-cone", "snap-cone", "weight-cone")
PERIODS, PER_PERIOD = 600, 400
"""Periods of a long run, and samples per period; the last periods show the settled motion."""
RUN = 80
"""Periods of a run from rest to a limit."""
WIDER = 1.05
"""Over the stated width of a limit: so far below it no run may meet it."""
VALIDITY = {"dielectric_breakdown": "breakdown", "stretch_limit": "near_limit"}
"""Assumptions whose names differ from those of the limits."""
AT_REST = 1e-12
"""Stroke in mm that is rounding of a disc at rest; other answers are never as small."""
HIGHEST = 3000.0
"""Voltage used in place of pull-in for devices that never pull in, in volts."""
QUESTIONS = {
    "stroke: settled, data sheet": 1e-9,
    "stroke: settled, regime": 1e-6,
    "stroke: settled, envelope": 1e-6,
    "stroke: settled, long run": 1e-3,  # whose extremes are those of its samples
    "apparent power: settled, data sheet": 1e-9,
    "apparent power: settled, envelope": 1e-4,
    "power: settled, data sheet": 1e-9,
    "power: settled, envelope": 1e-4,
    "power: settled, long run": 1e-4,
    "field: settled, envelope": 1e-6,
    "field: settled, long run": 1e-3,  # of samples
    "current: settled, data sheet": 1e-9,
    "current: settled, long run": 1e-2,  # of samples
    "energies of a long run": 1e-6,
    # behind a resistance the charge of a membrane is a fit: shares of what goes back and forth
    "power of a fitted charge: settled, long run": 1e-3,
    "energies of a long run with a fitted charge": 1e-3,
    "stroke: regime, map": 0.0,
    "stroke: regime, bifurcation": 0.0,
    "stroke: settled, frequency response": 1e-6,
    "stroke: settled, extrema": 1e-6,
    "mean: settled, spectrum": 1e-4,
    "first harmonic: settled, spectrum": 1e-2,
    "exponent: regime, lyapunov": 1e-5,
    "pull-in: static, limits": 1e-9,
    "stroke: static, slow ramp": 1e-9,
    "blocked force: static, slow ramp": 1e-9,
    "displacement: static, end of a step": 1e-3,  # which is taken as settled within 2 % of it
    "limits: operating limits, data sheet": 1e-12,
    "limits: operating limits, runs from rest": 0.0,
    "small stroke: settled, linear": 2e-3,  # second order in the voltage
    "gain: transfer, small signal": 1e-6,
    "gain: transfer, settled": 2e-3,
    "natural frequency: transfer, data sheet": 1e-6,
}
"""Largest allowed difference of two answers, relative to the larger."""

Pair = tuple[str, float, float]


def device(rng: np.random.Generator) -> gelcone.Device:
    """A random device, driven at a fifth to four fifths of its pull-in voltage."""
    base = gelcone.find_device(str(rng.choice(DEVICES)))
    film, changes = str(rng.choice(["membrane", "wrinkling", "taut"], p=[0.4, 0.4, 0.2])), dict[str, Any]()
    for name in ("spring_rate", "film_thickness", "film_radius", "disc_radius", "moving_mass"):
        if (value := base.get(name)) and rng.random() < 0.5:
            changes[name] = float(value * np.exp(rng.normal(0.0, 0.15)))
    changes |= {"film": film} | ({} if base.second_film is None else {"second_film": film})
    if rng.random() < 0.25:
        changes["series_resistance"] = float(10.0 ** rng.uniform(5.0, 8.0))
    if rng.random() < 0.2:
        changes["material"] = str(rng.choice(sorted(gelcone.load_materials())))
    if rng.random() < 0.2:
        changes["material.viscous_modulus_1"] = float(rng.uniform(1e3, 8e3))
        changes["material.relaxation_time_1"] = float(10.0 ** rng.uniform(-2.0, 1.0))
    if rng.random() < 0.3:
        changes["waveform"] = str(rng.choice(["square", "triangle", "trapezoid"]))
    if rng.random() < 0.3:
        changes["voltage_offset"] = float(rng.uniform(0.0, 800.0))
    changes |= {
        "voltage_amplitude": float(rng.uniform(100.0, 900.0)),
        "frequency": float(10.0 ** rng.uniform(0.0, 1.6)),
    }
    return base.replace(changes)


class Asked:
    """The answers of commands about one device: None where a command refuses it, with the reason in ``refused``."""

    def __init__(self, refused: Callable[[str, str], None]) -> None:
        self.refused = refused

    def __call__(self, command: Callable[..., Any], *given: Any, **options: Any) -> Any:
        try:
            return command(*given, **options)
        except gelcone.InputError as error:
            self.refused(command.__name__, str(error))
            return None


def settled_pairs(own: gelcone.Device, settled: Any, ask: Asked) -> Iterator[Pair]:
    """Answers about a settled motion with a period."""
    static, limits = ask(gelcone.static, own), ask(gelcone.limits, own)
    if static is not None and limits is not None:
        yield "pull-in: static, limits", static["pull_in_voltage"], limits["pull_in_voltage"]
    regime = ask(gelcone.regime, own)
    if regime is not None:
        yield "stroke: settled, regime", settled["stroke"], regime["highest"] - regime["lowest"]
        if int(regime["regime"]) == Regime.PERIODIC:
            lyapunov = ask(gelcone.lyapunov, own)
            if lyapunov is not None and int(lyapunov["cycle"]) > 0:
                yield "exponent: regime, lyapunov", regime["lyapunov"].values[0], lyapunov["lyapunov"].values[0]
    sheet = ask(gelcone.datasheet, own)
    if sheet is not None:
        yield "stroke: settled, data sheet", settled["stroke"], sheet["drive_stroke"]
        yield "apparent power: settled, data sheet", settled["apparent_power"], sheet["apparent_power"]
        yield "power: settled, data sheet", settled["power"], sheet["mean_power"]
        yield "current: settled, data sheet", settled["current"], sheet["peak_current"]
        yield from limit_pairs(own, sheet, ask)
    yield from envelope_pairs(own, settled, ask)
    yield from swept_pairs(own, settled, regime, ask)
    if not own.material.branches:
        yield from run_pairs(own, settled, ask)
        yield from ramp_pairs(own, ask)
    spectrum = ask(gelcone.spectrum, own)
    if spectrum is not None:
        yield "mean: settled, spectrum", settled["mean"], spectrum["mean_displacement"]
        lines, first = spectrum["line_frequency"].values, settled["harmonic_amplitude"].values[0]
        near = np.flatnonzero(np.abs(lines / own.frequency - 1.0) < 1e-3)
        if int(settled["period"]) <= 2 and near.size and first > 0.05 * float(settled["stroke"]):
            yield "first harmonic: settled, spectrum", first, spectrum["line_amplitude"].values[near[0]]


def envelope_pairs(own: gelcone.Device, settled: Any, ask: Asked) -> Iterator[Pair]:
    """Answers at the point of an envelope at the device's own drive, if the motion is periodic."""
    peak = (own.voltage_offset or 0.0) + own.voltage_amplitude
    plane = ask(gelcone.envelope, own, peaks=[0.999 * peak, peak], frequencies=[own.frequency, 1.01 * own.frequency])
    if plane is None:
        return
    at = plane.isel(drive_frequency=0)
    k = int(np.abs(at["peak_voltage"].values - peak).argmin())
    found = at.isel(peak_voltage=k) if "peak_voltage" in at.dims else at.isel({at["peak_voltage"].dims[0]: k})
    same = abs(float(found["peak_voltage"]) - peak) < 1e-9 * peak
    if same and float(found["outcome"]) == Outcome.OK and float(found["regime"]) == Regime.PERIODIC:
        for name, other in (
            ("stroke", "stroke"),
            ("apparent power", "apparent_power"),
            ("power", "power"),
            ("field", "field"),
        ):
            yield f"{name}: settled, envelope", settled[other], found[f"driven_{other}"]


def swept_pairs(own: gelcone.Device, settled: Any, regime: Any, ask: Asked) -> Iterator[Pair]:
    """Of analyses that sweep a parameter, at the device's own drive, reached as the device itself reaches it."""
    volts, frequencies = own.voltage_amplitude * np.array([0.99, 1.0]), own.frequency * np.array([1.0, 1.01])
    if regime is not None:
        stroke = regime["highest"] - regime["lowest"]
        map_ = ask(gelcone.map, own, {"voltage_amplitude": volts, "frequency": frequencies})
        if map_ is not None:
            cell = map_.isel(voltage_amplitude=1, frequency=0)
            yield "stroke: regime, map", stroke, cell["highest"] - cell["lowest"]
        diagram = ask(gelcone.bifurcation, own, "voltage_amplitude", volts)
        if diagram is not None:
            point = diagram.isel(voltage_amplitude=1).sel(branch="from its own start")
            yield "stroke: regime, bifurcation", stroke, point["highest"] - point["lowest"]
    if int(settled["resting"]):
        return
    response = ask(gelcone.frequency, own, frequencies)
    if response is not None:
        at = response.isel(drive_frequency=0).sel(branch="up")
        yield "stroke: settled, frequency response", settled["stroke"], at["stroke"]
    extremes = ask(gelcone.extrema, own, discard=PERIODS)
    if extremes is not None and int(extremes["outcome"]) == Outcome.OK and int(extremes["count"]):
        yield "stroke: settled, extrema", settled["stroke"], np.ptp(extremes["displacement"].values)


def ramp_pairs(own: gelcone.Device, ask: Asked) -> Iterator[Pair]:
    """Of constant voltages."""
    volt = 0.5 * own.voltage_amplitude
    static, ramp = ask(gelcone.static, own, [volt]), ask(gelcone.stroke_and_blocked_force, own, [volt])
    if static is None or ramp is None:
        return
    yield "stroke: static, slow ramp", static["stroke"].values[0], ramp["stroke"].values[0]
    yield "blocked force: static, slow ramp", static["blocked_force"].values[0], ramp["blocked_force"].values[0]
    step = ask(gelcone.step, own, [volt])
    if step is not None and int(static["equilibria"].values[0]) == 1 and not int(step["outcome"].values[0]):
        at = static["equilibrium_displacement"].values[0, 0]
        yield "displacement: static, end of a step", at, step["final_displacement"].values[0]


def limit_pairs(own: gelcone.Device, sheet: Any, ask: Asked) -> Iterator[Pair]:
    """Of the limits of operation."""
    limits = ask(gelcone.operating_limits, own)
    if limits is None:
        return
    for name in map(str, limits.data_vars):
        if name.endswith("_voltage"):
            yield "limits: operating limits, data sheet", limits[name], sheet[name]
    if own.material.branches:
        return
    width, rest = float(limits["driven_error_voltage"]), ask(gelcone.static, own, [0.0])["rest_displacement"]
    start = 1e-3 * (float(rest) + NUDGE * float(own.scales.shown("length")))
    for limit in ("pull_in", "dielectric_breakdown", "hoop_slack", "meridional_slack", "stretch_limit"):
        volt = float(limits[f"driven_{limit}_voltage"])
        if np.isfinite(volt):
            below, above = (_meets(own, at, start, limit, ask) for at in (volt, volt + WIDER * width))
            yield "limits: operating limits, runs from rest", volt, volt if above and not below else 0.0


def _meets(own: gelcone.Device, peak: float, start: float, limit: str, ask: Asked) -> bool:
    """Whether a run from the displacement ``start``, in metres, meets a limit at a peak voltage."""
    share = peak / (own.voltage_amplitude + (own.voltage_offset or 0.0))
    drive = {"voltage_amplitude": share * own.voltage_amplitude}
    if own.voltage_offset:
        drive["voltage_offset"] = share * own.voltage_offset
    times = np.arange(RUN * PER_PERIOD + 1) / (PER_PERIOD * own.frequency)
    run = ask(gelcone.simulate, own.replace(drive), (start, 0.0), times=times)
    if run is None:
        return False
    if limit == "pull_in":
        return int(run["outcome"]) != Outcome.OK or float(run.get("validity_beyond_membrane", 0.0)) > 0.0
    return int(run["outcome"]) != Outcome.OK or float(run[f"validity_{VALIDITY.get(limit, limit)}"]) > 0.0


def run_pairs(own: gelcone.Device, settled: Any, ask: Asked) -> Iterator[Pair]:
    """Answers from the last periods of a long run."""
    period = max(int(settled["period"]), 1)  # 0 of a disc at rest
    turn = period * (1 + period % 2)
    times = np.arange((PERIODS + turn) * PER_PERIOD + 1) / (PER_PERIOD * own.frequency)
    run = ask(gelcone.simulate, own, times=times)
    if run is None or int(run["outcome"]) != Outcome.OK:
        return
    late, supplied = run.isel(time=slice(-turn * PER_PERIOD - 1, None)), run["supplied_energy"].values
    if not int(settled["resting"]):
        yield "stroke: settled, long run", settled["stroke"], np.ptp(late["displacement"].values)
    power, residual = (supplied[-1] - supplied[-turn * PER_PERIOD - 1]) * own.frequency / turn, run["energy_residual"]
    size, apparent = np.abs(run["dissipated_energy"].values).max(), float(settled["apparent_power"])
    if own.film == "membrane" and own.series_resistance is not None:
        size = max(size, apparent * times[-1])
        yield "power of a fitted charge: settled, long run", settled["power"] + apparent, power + apparent
        yield "energies of a long run with a fitted charge", size, size + np.abs(residual.values).max()
    else:
        yield "power: settled, long run", settled["power"], power
        yield "energies of a long run", size, size + np.abs(residual.values).max()
    yield "field: settled, long run", settled["field"], np.nanmax(late["true_field"].values)
    if np.isfinite(settled["current"]) and own.waveform == "sine":
        yield "current: settled, long run", settled["current"], np.abs(late["current"].values).max()


def small_pairs(own: gelcone.Device, ask: Asked) -> Iterator[Pair]:
    """Answers about the response to a small voltage on top of the offset."""
    offset = own.voltage_offset
    small = own.replace(voltage_amplitude=1e-4 * offset, waveform="sine")
    settled = ask(gelcone.settled, small)
    transfer = ask(gelcone.transfer, small, [own.frequency])
    signal = ask(gelcone.small_signal_response, small, [own.frequency])
    sheet = ask(gelcone.datasheet, small, [offset])
    if settled is None or int(settled["outcome"]) != Outcome.OK:
        return
    yield "small stroke: settled, linear", settled["stroke"], settled["linear_stroke"]
    if transfer is not None:
        gain = transfer["gain"].values[0]
        yield "gain: transfer, settled", gain, float(settled["stroke"]) / (2e-4 * offset) * 1e3
        if signal is not None:
            yield "gain: transfer, small signal", gain, signal["gain"].values[0]
        if sheet is not None:
            natural = sheet["natural_frequency"].sel(constant_voltage=offset, method="nearest")
            yield "natural frequency: transfer, data sheet", transfer["natural_frequency"], natural


def pairs(own: gelcone.Device, ask: Asked) -> Iterator[Pair]:
    """All answers about a device that two commands give."""
    settled = ask(gelcone.settled, own)
    moves = settled is not None and int(settled["outcome"]) == Outcome.OK
    if not moves or (int(settled["period"]) == 0 and not int(settled["resting"])):
        return
    yield from settled_pairs(own, settled, ask)
    if (own.voltage_offset or 0.0) > 100.0 and not own.material.branches:
        yield from small_pairs(own, ask)


def main(count: int, seed: int) -> int:
    """Compares answers about ``count`` devices, prints differences and returns their number."""
    apart: dict[str, list[float]] = defaultdict(list)
    refused: dict[str, int] = defaultdict(int)
    begun, differences = time.monotonic(), 0

    def refuse(command: str, why: str) -> None:
        refused[f"{command}: {why[:90]}"] += 1

    for number in range(seed, seed + count):
        ask = Asked(refuse)
        own = ask(device, np.random.default_rng(number))
        if own is None:
            continue
        for question, one, other in pairs(own, ask):
            a, b = float(one), float(other)
            same = a == b or (np.isnan(a) and np.isnan(b)) or max(abs(a), abs(b)) < AT_REST
            away = 0.0 if same else abs(a - b) / max(abs(a), abs(b))
            apart[question].append(away)
            if not away <= QUESTIONS[question]:
                differences += 1
                of = f"device {number} ({own.name}, {own.film}, {own.waveform})"
                print(f"{of}: {question}: {a:.12g} and {b:.12g}, {away:.1e}", flush=True)
        print(f"device {number} after {time.monotonic() - begun:.0f} s", file=sys.stderr)
    for question, limit in QUESTIONS.items():
        known = apart[question]
        print(
            f"{question:42} {len(known):4} compared, at most {max(known, default=0.0):.1e} apart (may be {limit:.0e})"
        )
    for why, times in sorted(refused.items()):
        print(f"refused {times} times by {why}")
    return differences


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    given = [int(text) for text in sys.argv[1:]]
    sys.exit(main(*(given + [24, 2026][len(given) :])) > 0)
