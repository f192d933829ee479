"""The numbers behind the live panels of one actuator, as plain arrays in the units of the page.

Labelled Datasets would take several times as long as the integration itself; only saved files use them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Generic, TypeVar

import numpy as np

from gelcone.analyses.request import Subject
from gelcone.codes import Outcome, Regime
from gelcone.dataset import Findings
from gelcone.devices.checks import doubts
from gelcone.devices.scales import MEASURES
from gelcone.errors import InputError
from gelcone.motion.equilibrium import static
from gelcone.motion.flow import integrate
from gelcone.motion.job import Trajectories
from gelcone.motion.section import section_cells
from gelcone.motion.settle import LONGEST_TIME
from gelcone.motion.spectrum import spectrum_cells
from gelcone.motion.start import start_states
from gelcone.motion.validity import broken_by_film
from gelcone.physics.film.film import FilmState
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.physics.records import bias_record
from gelcone.plots.regime import REGIME_COLOURS
from gelcone.quantity import Array
from gelcone.register.analyses import ANALYSES
from gelcone.studio import performance
from gelcone.studio.orbit import samples_over, settled_orbit
from gelcone.words import evidence_in_words

if TYPE_CHECKING:
    import xarray as xr

MOST_SAMPLES = 200_000
"""Most samples of a run; a run that needs more is shown only as far as these reach."""
PERIODS = 20
"""Drive periods of a run by default."""
FEWEST, MOST = 1, 500
"""Bounds of the drive periods that the page may ask for."""
JUST_BEFORE = 1.0 - 1e-9
MARGIN = 1.006
"""Factor of a lowest frequency in a message, which stays above the true one when rounded to three digits."""
SECTION_POINTS = 600
"""Section points of a motion that does not repeat."""
SPECTRUM_PERIODS = 64
SHOWN_RATIO = 8.0
"""Highest frequency of a spectrum, over the drive's."""
SHOWN_SHARE = 1e-6
"""A spectrum without lines (the drive does not repeat) is shown up to the last amplitude above this share of the
largest."""
STATIC_LEVELS = 2
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
    own = subject.device
    return {quantity: 1.0 if own is None else own.scales.shown(quantity) for quantity in QUANTITIES}


def units(subject: Subject) -> dict[str, str]:
    """Quantity -> the name of the page's unit; empty: dimensionless."""
    return {quantity: "" if subject.device is None else MEASURES[quantity].shown for quantity in QUANTITIES}


def axes(subject: Subject) -> dict[str, str]:
    """The axis labels of the plots, with units."""
    own = units(subject)

    def named(name: str, quantity: str) -> str:
        return f"{name} ({own[quantity]})" if own[quantity] else name

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
        own = "" if len(states) == 1 else str(k)
        field = np.broadcast_to(state.true_field, x.shape)[0]
        most = np.nanmax(field, initial=0.0) if strength is None else float(strength[0])
        arrays |= {
            f"thin{own}": np.broadcast_to(state.thickness_stretch, x.shape)[0],
            f"field{own}": field / (most or 1.0),
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
    found = [_coded(fails, states.shape[1]) for fails in each]
    if len(each) > 1:
        names = each[0].keys() | each[1].keys()
        found.append(
            _coded({name: each[0].get(name, False) | each[1].get(name, False) for name in names}, len(found[0]))
        )
    return found


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


# --- the kind of motion ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Settled(Parts):
    """The kind of motion, and the ``run`` along the settled motion (None without one)."""

    run: Trajectories | None = None


def kind(subject: Subject) -> Settled:
    """The regime with its evidence in words, its section and its settled orbit."""
    analysis = ANALYSES["regime"]
    states = start_states(subject.model.members(), subject.initial)
    found = analysis.compute(subject.model.members(), states, threads=1)
    member = single(found, subject)
    outcome = Outcome(int(member["outcome"]))
    regime = Regime(int(member["regime"]))
    by = scales(subject)
    points = np.asarray(found.variables["section"][1])[0]
    arrays: dict[str, Any] = {}
    run = None
    lines = [*evidence_in_words(member), *([outcome.meaning] if outcome else [])]
    words: dict[str, Any] = {"regime": int(regime), "lines": lines, "numbers": []}
    if not outcome and np.isfinite(points[:2]).all():
        members = subject.model.members()
        # two forcing periods past the start of the cycle: there the drive, too, is at its phase 0
        run, whole = settled_orbit(members, points[1], regime, int(member["period"]))
        words["numbers"] = performance.in_words(
            performance.motion(members, run, regime, whole.stop // whole.step), subject
        )
        arrays, words["shares"] = curve(members, run, subject, "o")
        if regime not in (Regime.REST, Regime.PERIODIC):  # two runs of chaos come apart
            points = run.states[0, whole]
    arrays |= {"px": points[:, 0] * by["length"], "pu": points[:, 1] * by["velocity"]}
    extent = [float(member[name]) for name in ("lowest", "highest")]
    return Settled(arrays, words | {"extent": extent if np.isfinite(extent).all() else None}, run)


def electrical(subject: Subject, run: Trajectories) -> Parts:
    """Current and power along the settled run."""
    numbers = performance.of_source(subject.model.members(), run)
    return Parts({}, {"numbers": performance.in_words(numbers, subject)})


class Reading(np.ndarray):
    """A variable as `gelcone.words` reads it; stands in for xarray, which takes a second to import."""

    attrs: dict[str, str]

    @property
    def values(self) -> Array:
        """The numbers as a plain array, as a DataArray has them."""
        return np.asarray(self)


def single(found: Findings, subject: Subject) -> Any:
    """The findings of a single actuator by name, with units: readable like a Dataset, ten times faster."""
    member: dict[str, Any] = {"outcome": found.outcome[0]}
    for name, (_, values, _, quantity) in found.variables.items():
        scale, unit = 1.0, "1"
        of = str(quantity.get("quantity") if isinstance(quantity, Mapping) else quantity)
        if subject.device is not None and of in MEASURES:
            scale, unit = subject.device.scales.shown(of), MEASURES[of].shown
        value = np.asarray(values)[0]
        member[name] = np.asarray(value * scale if unit != "1" else value).view(Reading)
        member[name].attrs = {"units": unit}
    return member


def section(subject: Subject) -> Parts:
    """More section points of a motion that does not repeat."""
    states = start_states(subject.model.members(), subject.initial)
    found = section_cells(subject.model.members(), states, repeats=SECTION_POINTS, threads=1)
    by = scales(subject)
    x, u = (np.asarray(found.variables[name][1])[0] for name in ("displacement", "velocity"))
    return Parts({"px": x * by["length"], "pu": u * by["velocity"]})


# --- the other panels ------------------------------------------------------------------------------------------------


def spectrum(subject: Subject) -> Parts:
    """The amplitude spectrum, and the highest frequency to show. It is that of the settled motion, or of the whole run
    if the drive does not repeat."""
    repeats, states = subject.model.system.waveform.repeat, start_states(subject.model.members(), subject.initial)
    periods = SPECTRUM_PERIODS if repeats else 1
    found = spectrum_cells(subject.model.members(), states, periods=periods, threads=1).variables
    by = scales(subject)
    amplitude = np.asarray(found["amplitude"][1])[0]
    ratio = np.arange(amplitude.size) / periods
    lines = np.asarray(found["line_ratio"][1])[0]
    heights = np.asarray(found["line_amplitude"][1])[0]
    kept = np.isfinite(lines)
    omega = float(subject.model.drive_frequency) * by["frequency"]
    top = SHOWN_RATIO
    if not repeats:
        top = float(ratio[amplitude >= SHOWN_SHARE * amplitude[1:].max(initial=0.0)].max(initial=SHOWN_RATIO))
    return Parts(
        {
            "frequency": ratio * omega,
            "amplitude": amplitude * by["length"],
            "line": lines[kept] * omega,
            "height": heights[kept] * by["length"],
        },
        {"top": top * omega},
    )


DRIVEN = ("voltage", "drive_frequency", "damping_ratio", "waveform", "circuit")
"""Parameters that do not affect the equilibria under a constant voltage."""
MOST_STATICS = 32


def _body(model: ConeModel) -> str:
    """A text that identifies a model up to its drive."""
    return repr(sorted((name, value) for name, value in model.parameters().items() if name not in DRIVEN))


def _levels(model: ConeModel) -> float:
    """The next power of two above the peak voltage, so that neighbouring settings share their statics."""
    return float(2.0 ** np.ceil(np.log2(max(float(model.peak_voltage), 1e-3))))


T = TypeVar("T")


class Answers(Generic[T]):
    """Answers about models, found by ``find`` and cached by ``key`` for up to `MOST_STATICS` keys."""

    def __init__(self, key: Callable[[ConeModel], str], find: Callable[[ConeModel], T]) -> None:
        self._key, self._find = key, find
        self.stored: dict[str, T] = {}

    def of(self, model: ConeModel) -> T:
        """The answer for a model, cached."""
        if not self.has(model):
            self.keep(model, self._find(model))
        return self.stored[self._key(model)]

    def keep(self, model: ConeModel, found: T) -> None:
        """Stores an answer that was computed elsewhere."""
        if len(self.stored) >= MOST_STATICS:
            self.stored.clear()
        self.stored[self._key(model)] = found

    def has(self, model: ConeModel) -> bool:
        """Whether the answer is cached."""
        return self._key(model) in self.stored


STATICS: Answers[xr.Dataset] = Answers(
    lambda model: f"{_levels(model)} {_body(model)}",
    lambda model: static(model, np.linspace(0.0, _levels(model), STATIC_LEVELS)),
)
"""`gelcone.static` up to beyond the peak voltage; takes seconds for films that wrinkle."""
PULL_INS: Answers[float] = Answers(_body, performance.pull_in)
"""`performance.pull_in`; like the statics, it does not depend on the drive."""


def margins(subject: Subject) -> Parts:
    """The static pull-in voltage, and the drive's peak as a share of it."""
    numbers = {performance.PULL_INS[pull_in_film(subject.model)]: PULL_INS.of(subject.model)}
    return Parts({}, {"numbers": performance.in_words(numbers, subject)})


def statics(subject: Subject) -> Parts:
    """The equilibria over a constant voltage with their stability, and the voltages of pitchfork and pull-in."""
    result = STATICS.of(subject.model)
    by = scales(subject)
    voltage, place, slope = (result[f"branch_{name}"].values for name in ("voltage", "displacement", "slope"))
    marks = {
        name: float(result[f"{name}_voltage"]) * by["voltage"]
        for name in ("pitchfork", "pull_in")
        if np.isfinite(float(result[f"{name}_voltage"]))
    }
    waveform, n = subject.model.system.waveform, subject.model.own_numbers
    swing = np.ravel(waveform.samples(n))
    return Parts(
        {
            "voltage": voltage * by["voltage"],
            "x": place * by["length"],
            "stable": (np.nan_to_num(slope) > 0.0).astype(np.uint8),
        },
        {"marks": marks, "swing": [float(swing.min()) * by["voltage"], float(swing.max()) * by["voltage"]]},
    )


STAGES: Mapping[str, Callable[[Subject], Parts]] = {
    "kind": kind,
    "section": section,
    "spectrum": spectrum,
}


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
