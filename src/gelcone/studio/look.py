"""The numbers behind the live panels of one actuator, as plain arrays in the units of the page.

Labelled Datasets would take several times as long as the integration itself; only saved files use them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone.analyses.request import Subject
from gelcone.codes import Outcome, Regime
from gelcone.devices.checks import doubts
from gelcone.devices.scales import MEASURES
from gelcone.errors import InputError
from gelcone.motion.flow import integrate
from gelcone.motion.job import Trajectories
from gelcone.motion.settle import LONGEST_TIME
from gelcone.motion.start import start_states
from gelcone.motion.validity import broken_by_film
from gelcone.physics.film.film import FilmState
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.physics.records import bias_record
from gelcone.plots.regime import REGIME_COLOURS
from gelcone.quantity import Array
from gelcone.studio.orbit import samples_over

if TYPE_CHECKING:
    pass

MOST_SAMPLES = 200_000
"""Most samples of a run; a run that needs more is shown only as far as these reach."""
PERIODS = 20
"""Drive periods of a run by default."""
FEWEST, MOST = 1, 500
"""Bounds of the drive periods that the page may ask for."""
JUST_BEFORE = 1.0 - 1e-9
MARGIN = 1.006
"""Factor of a lowest frequency in a message, which stays above the true one when rounded to three digits."""
PULLED_IN_COLOUR = "#5b5b5b"
RETURNS = 0.01
"""Distance, as a share of its size, within which a run counts as returned."""
TAUT, HOOP_SLACK, MERIDIONAL_SLACK, CRUMPLED, BREAKDOWN, NEAR_LIMIT, BEYOND_MEMBRANE = range(7)
FILM_STATES = (
    "taut",
    "hoop slack",
    "meridian slack",
    "slack in both directions",
    "above breakdown",
    "near its stretch limit",
    "above membrane pull-in",
)
WRINKLED = (*FILM_STATES[:3], "crumpled", *FILM_STATES[4:])
"""States of a film that wrinkles: it crumples where a taut one would be slack in both directions."""


@dataclass(frozen=True)
class Parts:
    """The arrays of plots and the texts and numbers next to them, by name."""

    arrays: dict[str, Any] = field(default_factory=dict)
    words: dict[str, Any] = field(default_factory=dict)


def check_periods(periods: Any) -> float:
    """The requested drive periods; `InputError` unless a number from `FEWEST` to `MOST`."""
    if isinstance(periods, bool) or not isinstance(periods, int | float) or not FEWEST <= periods <= MOST:
        raise InputError(f"periods: must be a number from {FEWEST} to {MOST}")
    return float(periods)


QUANTITIES = ("length", "time", "velocity", "voltage", "frequency")


def scales(subject: Subject) -> dict[str, float]:
    """Quantity -> one unit of the model in the page's unit."""
    device = subject.device
    return {quantity: 1.0 if device is None else device.scales.shown(quantity) for quantity in QUANTITIES}


def units(subject: Subject) -> dict[str, str]:
    """Quantity -> the name of the page's unit; empty: dimensionless."""
    return {quantity: "" if subject.device is None else MEASURES[quantity].shown for quantity in QUANTITIES}


def axes(subject: Subject) -> dict[str, str]:
    """The axis labels of the plots, with units."""
    unit_names = units(subject)

    def named(name: str, quantity: str) -> str:
        return f"{name} ({unit_names[quantity]})" if unit_names[quantity] else name

    height = "height" if subject.device is not None else "displacement"
    return {
        "time": named("time", "time"),
        "displacement": named(height, "length"),
        "velocity": named("velocity", "velocity"),
        "voltage": named("voltage", "voltage"),
        "constant": named("constant voltage", "voltage"),
        "frequency": named("frequency", "frequency"),
        "amplitude": named("amplitude", "length"),
    }


# --- the run from the start ------------------------------------------------------------------------------------------


def response(subject: Subject, periods: float) -> Parts:
    """The run from the start, with the voltage, the states of the films, and a first impression of the motion in
    words."""
    members = subject.model.members()
    states0 = start_states(members, subject.initial)
    with np.errstate(over="ignore"):
        period = float(members.drive_period[0])
    if not 0.0 < periods * period <= LONGEST_TIME:
        raise InputError(_too_slow(subject, periods))
    wanted = samples_over(members, periods * period)
    count = min(wanted, MOST_SAMPLES)
    span = periods * period * count / wanted
    shares = np.linspace(0.0, 1.0, count + 1)
    whole = run = integrate(members, states0, span * shares, threads=1)
    if whole.outcome[0] and whole.end_times[0] > 0.0:  # sampled again, up to its end
        run = integrate(members, states0, JUST_BEFORE * whole.end_times[0] * shares, threads=1)
    arrays, found_in = curve(members, run, subject)
    outcome = Outcome(int(whole.outcome[0]))
    seems = _ended(subject, whole) if outcome else _seems(members, run.times[0], run.states[0])
    return Parts(
        arrays,
        {
            "seems": seems,
            "ended": outcome.words if outcome else "",
            "shares": found_in,
            "period": period * scales(subject)["time"],
            "shown": span / period,
            "cut": count < wanted,
        },
    )


def _too_slow(subject: Subject, periods: float) -> str:
    """The message that a number of periods lasts too long, with the lowest frequency at which it does not."""
    name = "frequency" if subject.device is not None else "drive_frequency"
    each, unit = scales(subject)["frequency"], units(subject)["frequency"]
    frequency = each * float(np.ravel(subject.model.drive_frequency)[0])
    lowest = MARGIN * each * 2.0 * np.pi * periods / LONGEST_TIME
    texts = [f"{value:.3g} {unit}".rstrip() for value in (frequency, lowest)]
    return f"{name} = {texts[0]}: {periods:g} periods last too long; raise it to {texts[1]} or more"


def curve(members: Members, run: Trajectories, subject: Subject, prefix: str = "") -> tuple[dict[str, Any], Any]:
    """Arrays along the run of a single actuator, and the share of the run in each state of the films.

    Time, height, velocity and voltage; for each film its state, its thickness over the unstretched one, and its true
    field over the dielectric strength (over the largest field where the strength is unknown).
    """
    by = scales(subject)
    x, voltages = run.states[..., 0], members.voltages(run.times, run.states)
    with np.errstate(all="ignore"):
        states = members.film_states(run.states, voltages)
    codes = film_states(members, run.states, voltages, states)
    arrays = {
        "t": run.times[0] * by["time"],
        "x": x[0] * by["length"],
        "u": run.states[0, :, 1] * by["velocity"],
        "v": voltages[0][0] * by["voltage"],
        "film": codes[-1],
        **{f"film{k}": code for k, code in enumerate(codes[:-1], start=1)},
    }
    strength = members.values.get("dielectric_strength")
    for k, state in enumerate(states, start=1):
        suffix = "" if len(states) == 1 else str(k)
        field = np.broadcast_to(state.true_field, x.shape)[0]
        most = np.nanmax(field, initial=0.0) if strength is None else float(strength[0])
        arrays |= {
            f"thin{suffix}": np.broadcast_to(state.thickness_stretch, x.shape)[0],
            f"field{suffix}": field / (most or 1.0),
        }
    return {prefix + name: values for name, values in arrays.items()}, _shares(codes[-1][np.isfinite(x[0])])


def film_states(
    members: Members, states: Array, voltages: Sequence[Array], films: Sequence[FilmState | None] = (None, None)
) -> list[Any]:
    """The state of each film (an index into `FILM_STATES`) along a single run, (samples,); with two films, followed by
    both combined.

    ``voltages``: those across each film; ``films``: states computed before, where known.
    """
    each = broken_by_film(members, states, voltages, films)
    codes = [_coded(fails, states.shape[1]) for fails in each]
    if len(each) > 1:
        names = each[0].keys() | each[1].keys()
        codes.append(
            _coded({name: each[0].get(name, False) | each[1].get(name, False) for name in names}, len(codes[0]))
        )
    return codes


def _coded(fails: Mapping[str, Any], samples: int) -> Any:
    code = np.zeros(samples, dtype=np.uint8)
    for name, value in (("hoop_slack", HOOP_SLACK), ("meridional_slack", MERIDIONAL_SLACK)):
        if name in fails:
            code[fails[name][0]] += np.uint8(value)
    for name, value in (("near_limit", NEAR_LIMIT), ("beyond_membrane", BEYOND_MEMBRANE), ("breakdown", BREAKDOWN)):
        if name in fails:
            code[fails[name][0]] = value
    return code


def _shares(film: Any) -> list[dict[str, Any]]:
    """The share of the run in each state that occurs."""
    counts = np.bincount(film, minlength=len(FILM_STATES)) / max(film.size, 1)
    return [{"code": code, "share": float(share)} for code, share in enumerate(counts) if share > 0.0]


def _ended(subject: Subject, run: Trajectories) -> str:
    """The reason why a run ended early, with time, height and voltage."""
    outcome = Outcome(int(run.outcome[0]))
    if outcome is not Outcome.PULLED_IN:
        return outcome.meaning
    by, unit = scales(subject), units(subject)
    voltage = subject.model.members().voltages(run.end_times[:, None], run.end_states[:, None])[0]
    places = zip((run.end_times[0], run.end_states[0, 0], voltage[0, 0]), ("time", "length", "voltage"), strict=True)
    time, height, volts = (f"{value * by[name]:.4g} {unit[name]}".strip() for value, name in places)
    return f"the film pulls in after {time}, at the height {height}, under {volts}; lower the voltage or the start"


def _seems(members: Members, times: Array, states: Array) -> str:
    """A first impression of the end of a run, from its states once per forcing period: fast, but not reliable."""
    if not members.system.waveform.repeat:
        return "the drive does not repeat"
    period = float(members.forcing_period[0])
    ticks = np.arange(int(times[-1] / period + 0.5) + 1) * period
    points = np.stack([np.interp(ticks, times, states[:, k]) for k in range(2)], axis=1)
    late = points[len(points) // 2 :]
    size = max(float(np.ptp(states[len(states) // 2 :, 0])), 1e-9)
    for repeats in range(1, min(9, len(late))):
        if np.abs(late[-1] - late[-1 - repeats])[0] < RETURNS * size:
            return "seems to repeat" if repeats == 1 else f"seems to repeat every {repeats} periods"
    return "does not repeat yet"


GLANCE_PERIODS, GLANCE_SAMPLES = 4, 240


def glance(subject: Subject) -> Parts:
    """The last periods of a run, sampled for a small picture."""
    whole = response(subject, PERIODS)
    count = len(whole.arrays["t"]) - 1
    first = count - round(count * min(1.0, GLANCE_PERIODS / PERIODS))
    places = np.linspace(first, count, GLANCE_SAMPLES + 1).astype(int)
    arrays = {name: values[places] for name, values in whole.arrays.items()}
    return Parts(arrays | {"t": arrays["t"] - arrays["t"][0]}, {"period": whole.words["period"]})


def legend() -> dict[str, Any]:
    """Names and colours of the kinds of motion."""
    return {
        "regimes": [{"name": regime.label, "colour": REGIME_COLOURS[regime]} for regime in Regime],
        "pulled_in": {"name": Outcome.PULLED_IN.words, "colour": PULLED_IN_COLOUR},
    }


def pull_in_film(model: ConeModel) -> str:
    """The model of the film whose pull-in is used: ``membrane`` or ``cone``."""
    return "membrane" if isinstance(model.film, MembraneFilm) else "cone"


def _acting(model: ConeModel) -> str:
    """The biases on the disc joined by a plus, without a spring of zero stiffness; ``none`` without any."""
    kinds = str(bias_record(model.system.bias)).split("+")
    stiff = bool(np.any(np.asarray(model.values.get("spring_stiffness", 1.0)) != 0.0))
    return "+".join(kind for kind in kinds if kind != "spring" or stiff) or "none"


def about(subject: Subject) -> dict[str, Any]:
    """Data of the pictures in addition to the run: sizes of the cone, its parts, labels."""
    device, model = subject.device, subject.model
    by = scales(subject)
    disc, rim = (0.35, 1.0) if device is None else (device.disc_radius, device.film_radius)
    unit = 1e3 if device is not None else 1.0 / (rim - disc)
    flat = model.values.get("second_flat_height")
    return {
        "disc": disc * unit,
        "rim": rim * unit,
        "bias": _acting(model),
        "film_of": pull_in_film(model),
        "wrinkles": bool(model.system.film.kinds),
        "film": list(WRINKLED if model.system.film.kinds else FILM_STATES),
        "second": None if flat is None else float(np.ravel(flat)[0]) * by["length"],
        "axes": axes(subject),
        "si": device is not None,
        "name": device.name if device is not None else "",
        "strength": "dielectric_strength" in model.values,
        "doubts": [] if device is None else doubts(device),
    }
