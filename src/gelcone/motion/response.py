"""Time response: motion of the actuator, load on the film, and validity of the model."""

from __future__ import annotations

import os
import reprlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import FilmPullIn
from gelcone.devices.analysis import analysis
from gelcone.errors import InputError
from gelcone.motion.delivery import delivered, halfway, switched
from gelcone.motion.flow import DEFAULT_TOLERANCE, integrate
from gelcone.motion.job import Trajectories, to_the_end
from gelcone.motion.settle import LONGEST_TIME
from gelcone.motion.start import start_states
from gelcone.motion.validity import ASSUMPTIONS, broken, validity_of_run, validity_variables
from gelcone.physics.circuit import IdealSource
from gelcone.physics.film.film import FilmState
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.physics.system import ConeSystem
from gelcone.progress import Progress, advance, weighted
from gelcone.quantity import Array, Times
from gelcone.register.analysis import Axis

if TYPE_CHECKING:
    import xarray as xr

LOSSES = ("damper", "film", "resistor", "leak", "dielectric")
HEATS = ("film", "leak", "dielectric")
"""Losses that heat the films: creep of their branches, leakage, and dielectric relaxation."""
HEAT: Mapping[str, tuple[str, dataset.Of]] = {
    "heat": ("mean heat in the films over their volume", "power density"),
    "heating": ("rate of the temperature of films that lose no heat", "heating"),
}
"""Meaning and quantity of each variable of films with losses."""
MOST_SERIES = 19
"""Number of time series of a single cone with an ideal source."""
SAMPLES_PER_PERIOD = 100
SAMPLES_PER_OSCILLATION = 20
MOST_SAMPLES = 20_000


@analysis(
    axes={"times": Axis("time", "time", least=1)},
    answers="trajectories",
    examples=("--set voltage=1.04 --set drive_frequency=0.1 --json", "paper-table1 --periods 30 --out results"),
)
def simulate(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    periods: float | None = None,
    times: Times | None = None,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute motion, stretches, stresses, field, energies and powers of each member, and the model's validity.

    Parameters
    ----------
    model : one actuator or an ensemble.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    periods : length of the run in periods 2 pi/omega of the voltage, when ``times`` is not given. Default 20, or the
        whole of a drive that does not repeat.
    times : sample times, increasing from 0 or later; default even ones, at least 100 a drive period and
        20 an oscillation at the fastest rate (at most 20,000 in all).
    tolerance : relative error of one step. Default 1e-15.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the ensemble's dims and ``time`` (``sample`` if the members' drive frequencies differ):
    ``displacement`` and ``velocity`` of the disc; the commanded ``drive_voltage``, and behind a circuit the
    ``film_voltage``; ``current`` and ``true_field`` of the film, ``meridional_stretch``, ``hoop_stretch`` and
    ``thickness_stretch``, the true ``meridional_stress`` and ``hoop_stress``; ``kinetic_energy``, ``film_energy``,
    ``spring_energy`` and ``field_energy``; ``input_power`` and ``dissipated_power``; and for a wrinkling film
    ``film_state``.

    Energies and powers are per mu Vol; stored energy includes the field energy v^2 q/2, and ``supplied_energy`` is
    the work of the voltage source, integrated along the motion. ``dissipated_energy`` is the loss in the damping of
    the disc, the film and the circuit; if there is more than the damping, ``damper_dissipation``,
    ``film_dissipation``, ``resistor_dissipation`` and ``leak_dissipation`` are its parts. ``energy_residual`` is the
    error of the energy balance. For a film whose charge is not known during a run, the supplied energy follows from
    the first law, and the residual compares the disc's energies alone; NaN if such a film has states.

    Flags mark samples at which the model is not valid: ``hoop_slack``, ``meridional_slack`` (a true stress is
    negative), ``breakdown`` (the true field exceeds the model's ``dielectric_strength``), ``near_limit`` (the strain
    is within 1 % of the stretch limit) and of a cone ``beyond_membrane`` (its membrane would have pulled in).
    ``validity_*`` are their shares of the run's time, between the times at which they begin and end, and
    ``validity_error`` the error of these; NaN for breakdown at an unknown strength. ``validity_pulled_in`` is 1 for a
    run that ended with a pull-in.

    ``rms_voltage`` and ``rms_current`` are those of the source in the second half of the run, ``apparent_power`` is
    their product, summed over the sources, ``peak_current``, ``peak_charge`` and ``peak_slew_rate`` its largest ones,
    which an amplifier must deliver (currents are infinite if the voltage of an ideal source jumps); ``slew_limited``
    and ``current_limited`` are the shares of the time at the limits of a limited source. For films that creep or leak
    ``heat`` is the mean heat in them over their volume in the second half, and ``heating`` the rate at which their
    temperature then rises while they give no heat away.

    In a double cone energies, powers and flags are those of both films together; voltage, current, stretches,
    stresses and field of the second film have the prefix ``second_``.

    For a wrinkling film ``film_state_*`` are the shares of the time in each of its states, between the exact times of
    their changes; ``pull_in_time``, ``pull_in_displacement``, ``pull_in_film_voltage`` and ``pull_in_kind``
    (`FilmPullIn`) describe a pull-in, which ends the run (NaN and 0: none). ``outcome`` is how the run ended.

    Raises
    ------
    InputError : for a run of no length or more than the memory holds, both periods and times, times that do not
        increase, or an initial state of which no member lies inside its stretch limit.

    Examples
    --------
    >>> import gelcone
    >>> device = gelcone.find_device("biased-pump").replace(film="taut", frequency="9 Hz")
    >>> response = gelcone.simulate(device, periods=20)
    >>> response.sizes["time"], response.displacement.units, response.outcome.item()
    (2001, 'mm', 0)
    >>> f"from rest at {response.displacement.values[0]:.2f} mm"
    'from rest at 12.59 mm'
    """
    if periods is not None and times is not None:
        raise InputError("periods and times are both given; give one of them")
    if periods is None:
        periods = 20.0 if model.system.waveform.repeat else 1.0
    if not (isinstance(periods, float | int | np.number) and np.isfinite(periods) and periods > 0.0):
        shown = f"{periods:g}" if isinstance(periods, float) else repr(periods)
        raise InputError(f"periods = {shown}: must be a positive number of drive periods")
    states0 = start_states(model, initial)
    if times is None:
        longest = float(np.max(periods * model.drive_period))
        if longest > LONGEST_TIME:
            raise InputError(
                f"periods = {periods:g}: last too long; a run takes a time of at most {LONGEST_TIME:g}, which is "
                f"{periods * LONGEST_TIME / longest:.3g} of them; give fewer"
            )
        sampled = even_times(model, periods * model.drive_period)
        kept = checked = np.arange(sampled.shape[1])
    else:
        wanted = _wanted_times(times)
        even = even_times(model, wanted[-1])[0]
        sampled = np.union1d(even, wanted)[None]
        kept, checked = (np.searchsorted(sampled[0], subset) for subset in (wanted, even))
    sampled = np.broadcast_to(sampled, (model.size, sampled.shape[1]))
    _check_memory(*sampled.shape)
    flow: dict[str, Any] = {"tolerance": tolerance, "threads": threads}
    run = integrate(model, states0, sampled, keep="work", **flow, progress=weighted(progress, 0.4))
    members = model.members()
    with np.errstate(over="ignore", invalid="ignore"):
        jumps = switched(members, states0, run.times, **flow)
        variables, film_states = _variables(members, run, *jumps)
        voltages = members.voltages(run.times, run.states)
        fails = broken(members, run.states, voltages, film_states)
    advance(progress, 0.2)
    valid = validity_variables(validity_of_run(members, run, checked), run.outcome, members.system, of="time")
    films = {film.prefix: film for film in members.system.films}
    kinds = {
        film.prefix: film_state.kind for film, film_state in zip(films.values(), film_states, strict=True) if film.kinds
    }
    shared_times = (sampled == sampled[0]).all()
    dim = "time" if shared_times else "sample"
    meanings = (
        _MEANINGS | _OF_SECOND_FILM | {state.name: (state.meaning, state.quantity) for state in model.system.states[2:]}
    )
    result = dataset.label(
        model,
        {n: ((dim,), v[:, kept], *meanings[n]) for n, v in variables.items()}
        | {n: ((dim,), v[:, kept], f"is there {ASSUMPTIONS[n]}", "flag") for n, v in fails.items()}
        | {
            f"{n}film_state": ((dim,), v[:, kept], f"state of the {n.replace('_', ' ')}film", "flag")
            for n, v in kinds.items()
        }
        | valid
        | ends_of_films(members, run)
        | _heat(members, run)
        | delivered(members, *to_the_end(run), jumps[1]),
        coords={"time": ((dim,), sampled[0, kept] if shared_times else sampled[:, kept], "time", "time")},
        outcome=run.outcome,
        # given times are the coordinate of the result
        options={"periods": periods if times is None else None, "tolerance": tolerance},
        title="time response",
    )
    advance(progress, 0.4)
    for name in kinds:
        result[f"{name}film_state"].attrs |= dataset.flags_of(films[name].kinds)
    return dataset.with_initial(result, model, states0)


def heats(system: ConeSystem) -> bool:
    """True if films have losses that heat them."""
    return bool(set(HEATS) & set(system.causes))


def _heat(members: Members, run: Trajectories) -> dict[str, dataset.Variable]:
    """Variables of the mean heat in the films in the second half of a run; none for films without losses."""
    if not heats(members.system):
        return {}
    assert run.work is not None
    lost, half = heat_of(members.system, run.work), halfway(run.times)
    mean = (lost[:, -1] - lost[:, half]) / (run.times[:, -1] - run.times[:, half])
    return {name: ((), mean, f"{words}, in the second half", of) for name, (words, of) in HEAT.items()}


def _check_memory(members: int, samples: int) -> None:
    """Raises `InputError` for a run that exceeds the memory: the machine would stall before it fails."""
    needed = 16 * MOST_SERIES * members * samples
    here = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") if hasattr(os, "sysconf") else np.inf
    if needed > here:
        raise InputError(
            f"{members} members of {samples} samples need about {needed / 1e9:.3g} GB of memory, this machine has "
            f"{here / 1e9:.3g}; take fewer members or samples"
        )


def even_times(model: ConeModel, spans: npt.ArrayLike) -> Array:
    """Even times (spans, samples) from 0 to each of the spans, the same number for all."""
    members = model.members()
    span = np.broadcast_to(spans, model.shape).ravel() if np.ndim(spans) else np.full(1, spans)
    detail = members.system.waveform.detail(members.own_numbers)
    spacing = min(
        float((members.drive_period / SAMPLES_PER_PERIOD / detail / span).min()),
        float((2.0 * np.pi / members.rate / SAMPLES_PER_OSCILLATION / span).min()),
    )
    count = int(np.clip(np.ceil(1.0 / spacing), 2, MOST_SAMPLES))
    _check_memory(model.size, count)
    return span[:, None] * np.linspace(0.0, 1.0, count + 1)


def _wanted_times(times: npt.ArrayLike) -> Array:
    """The sample times as an array; raises `InputError` for times that cannot be sampled."""
    try:
        wanted = np.atleast_1d(np.asarray(times, dtype=float))
    except (TypeError, ValueError):
        raise InputError(f"times = {' '.join(reprlib.repr(times).split())}: must be numbers") from None
    if wanted.ndim > 1 or wanted.size == 0:
        raise InputError(f"times: must be a list of at least one number, not of shape {wanted.shape}")
    if not np.isfinite(wanted).all() or wanted[0] < 0.0:
        wrong = wanted[~np.isfinite(wanted) | (wanted < 0.0)][0]
        raise InputError(f"times: {wrong:g} is among them; they must be finite and not before 0")
    falls = np.flatnonzero(np.diff(wanted) <= 0.0)
    if falls.size:
        raise InputError(
            f"times: {wanted[falls[0] + 1]:g} comes after {wanted[falls[0]]:g}; they must increase, sort them"
        )
    if wanted[-1] > LONGEST_TIME:
        raise InputError(
            f"times: {wanted[-1]:g} is among them; a run takes a time of at most {LONGEST_TIME:g}; leave later ones out"
        )
    if wanted[-1] == 0.0:
        raise InputError("times = 0: the run has no length; give at least one later time")
    return wanted


_MEANINGS = {
    "displacement": ("displacement x = h/(b-a)", "length"),
    "velocity": ("velocity of the disc", "velocity"),
    "drive_voltage": ("commanded voltage v(tau)", "voltage"),
    "film_voltage": ("voltage on the film", "voltage"),
    "meridional_stretch": ("meridional stretch l1", "stretch"),
    "hoop_stretch": ("hoop stretch l2", "stretch"),
    "thickness_stretch": ("thickness stretch l3", "stretch"),
    "meridional_stress": ("true meridional stress s1", "stress"),
    "hoop_stress": ("true hoop stress s2", "stress"),
    "true_field": ("true electric field", "field"),
    "kinetic_energy": ("kinetic energy", "energy"),
    "film_energy": ("strain energy of the film", "energy"),
    "spring_energy": ("energy of the spring, or of what else acts on the disc", "energy"),
    "field_energy": ("energy of the electric field", "energy"),
    "supplied_energy": ("energy put in by the voltage source since the start", "energy"),
    "dissipated_energy": ("energy dissipated since the start", "energy"),
    "current": ("current into the film", "current"),
    "damper_dissipation": ("energy dissipated by the damping of the disc since the start", "energy"),
    "film_dissipation": ("energy dissipated in the film since the start", "energy"),
    "resistor_dissipation": (
        "energy dissipated in the circuit's resistance, or where a voltage jumps, since the start",
        "energy",
    ),
    "leak_dissipation": ("energy dissipated by leakage through the film since the start", "energy"),
    "dielectric_dissipation": ("energy dissipated by the permittivity that follows late, since the start", "energy"),
    "input_power": ("power of the voltage source", "power"),
    "dissipated_power": ("power dissipated", "power"),
    "energy_residual": ("energy put in less stored and dissipated (zero in exact arithmetic)", "energy"),
}
_OF_EACH_FILM = (
    "meridional_stretch",
    "hoop_stretch",
    "thickness_stretch",
    "meridional_stress",
    "hoop_stress",
    "true_field",
)
_OF_SECOND_FILM = {
    f"second_{name}": (f"second film: {_MEANINGS[name][0]}", _MEANINGS[name][1])
    for name in ("drive_voltage", "film_voltage", "current", *_OF_EACH_FILM)
}


def _variables(
    members: Members, run: Trajectories, jumped: Array, lost: Array
) -> tuple[dict[str, Array], list[FilmState]]:
    """All time series (members, samples) by name, and the state of each film.

    ``jumped`` and ``lost`` (members, samples): work at jumps of an ideal source's voltage, and the loss of it.
    """
    assert run.work is not None
    x, u, z = run.states[..., 0], run.states[..., 1], list(np.moveaxis(run.states, -1, 0))
    system, n = members.system, members.numbers(trailing=1)
    currents = members.along(system.currents, run.times, run.states)
    voltages = members.voltages(run.times, run.states)
    bias = np.broadcast_to(system.bias.energy(x, n), x.shape)
    series = {s.name: run.states[..., i] for i, s in enumerate(system.states) if i > 1}
    states, energies = members.film_states(run.states, voltages), list[tuple[Array, Array, Array]]()
    squares = [v * v for v in voltages] if not system.circuit.delays else system.squares(run.times, z, n)
    commands = members.along(system.commands, run.times, run.states)
    for k, (film, v, current, state) in enumerate(zip(system.films, voltages, currents, states, strict=True)):
        y, squared = system.states_of(z, "film", k), squares[k]
        field = 0.5 * squared * np.broadcast_to(film.capacitance(x, squared, y, n), x.shape)
        strain = film.work(x, squared, y, n) + field - 0.5 * squared
        energies.append((strain, field, v * current))
        film_series = {"drive_voltage": commands[k], "current": current}
        if not isinstance(system.film_lines[k].circuit, IdealSource):
            film_series["film_voltage"] = v
        film_series |= {name: getattr(state, name) for name in _OF_EACH_FILM}
        series |= {film.prefix + name: value for name, value in film_series.items()}
    strain, field, power_in = (sum(parts[1:], parts[0]) for parts in zip(*energies, strict=True))
    mechanical, stored = 0.5 * u * u + bias, strain + field
    work = dict(zip(system.causes, np.moveaxis(run.work, -1, 0), strict=True))
    powers = dict(zip(system.causes, members.along(system.powers, run.times, run.states), strict=True))
    losses = [cause for cause in LOSSES if cause in work]
    dissipated = dissipated_energy(system, run.work) + lost
    if "source" in work:
        supplied = work["source"] + jumped
        residual = supplied - dissipated - (mechanical + stored - (mechanical + stored)[:, :1])
        power_in = powers["source"]
    else:
        # programs do not know the charge of this film well: first law; NaN if the film's energy is unknown
        supplied = work["motion"] + stored - stored[:, :1] + work.get("film", 0.0) + lost
        residual = work["motion"] - work["damper"] - (mechanical - mechanical[:, :1]) + 0.0 * stored
    if len(losses) > 1 or lost.any():
        series |= {f"{cause}_dissipation": work[cause] for cause in losses}
    if lost.any():
        series["resistor_dissipation"] = lost
    series |= {
        "displacement": x,
        "velocity": u,
        "kinetic_energy": 0.5 * u * u,
        "film_energy": strain,
        "spring_energy": bias,
        "field_energy": field,
        "supplied_energy": supplied,
        "dissipated_energy": dissipated,
        "input_power": power_in,
        "dissipated_power": sum((powers[cause] for cause in losses[1:]), powers[losses[0]]),
        "energy_residual": residual,
    }
    order = sorted(series, key=lambda name: list(_MEANINGS).index(name) if name in _MEANINGS else -1)
    return {name: np.broadcast_to(series[name], x.shape) for name in order}, states


def dissipated_energy(system: ConeSystem, work: Array) -> Array:
    """Energy of all losses since the start, from the integrals of a system's powers (members, samples, causes)."""
    first, *others = (work[..., system.causes.index(cause)] for cause in LOSSES if cause in system.causes)
    return np.asarray(sum(others, first))


def heat_of(system: ConeSystem, work: Array) -> Array:
    """Heat in the films since the start over their volume, from these integrals; 0 for films without losses."""
    lost = [work[..., system.causes.index(cause)] for cause in HEATS if cause in system.causes]
    return np.asarray(sum(lost, np.zeros(work.shape[:-1]))) / len(system.films)


def ends_of_films(members: Members, run: Trajectories) -> dict[str, dataset.Variable]:
    """Variables of the pull-ins that end runs; none for films without states."""
    variables: dict[str, dataset.Variable] = {}
    voltages = members.voltages(run.end_times[:, None], run.end_states[:, None])
    for k, (film, voltage) in enumerate(zip(members.system.films, voltages, strict=True)):
        if not film.kinds:
            continue
        pull_in = run.pull_in[:, k]
        ends = {
            "time": (run.end_times, "time", "time"),
            "displacement": (run.end_states[:, 0], "displacement", "length"),
            "film_voltage": (voltage[:, 0], "voltage on the film", "voltage"),
        }
        for name, (value, meaning, quantity) in ends.items():
            value = np.where(pull_in > 0, value, np.nan)
            variables[f"{film.prefix}pull_in_{name}"] = (
                (),
                value,
                f"{meaning} at which {film.words} pulls in",
                quantity,
            )
        variables[f"{film.prefix}pull_in_kind"] = ((), pull_in, f"how {film.words} pulls in", FilmPullIn)
    return variables
