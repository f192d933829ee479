"""Linear theory: the response to a drive, linearised about the equilibrium under its mean-square voltage."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.motion.regular import solved_where_regular
from gelcone.motion.rest import COMMAND, circuits_at_rest, films_at_rest, stacked, uncurrented
from gelcone.motion.settle import next_power_of_two
from gelcone.physics.balance import rest_of
from gelcone.physics.commanded import command_at
from gelcone.physics.differentiate import Gradients, gradients
from gelcone.physics.drive import PHASES, VOLTAGE
from gelcone.physics.members import Ensemble, Members
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import balances_of_films, each, rest_displacements, stable_near
from gelcone.physics.structure import Line
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array

PER_SWING, PER_RATE, MOST_ORDERS = 64, 32, 2**10 * PHASES
"""Multiples of the drive frequency that are computed: for each swing of the voltage in a period, for each time of the
fastest rate in a period of a waveform with corners, and at most. A corner or jump then has errors below 1e-3."""
CORNERED = 16 * PHASES
"""Least number of samples of a waveform with corners, between which a jump lies anywhere."""
LOADED = 1024
"""Least number of multiples that pass the states of a circuit, or all that the samples have."""
TIMED = ("frequency", "time")
"""Scales of parameters of a waveform, as of a chirp, by which its shape depends on the drive frequency."""
BLOCK = 2**21
"""Most samples of motions that are computed at once."""
SMALLEST_LINEAR_HARMONIC = 1e-13
"""Harmonics below this share of the mean square are rounding."""
UNSTABLE, TOO_MANY = "no stable equilibrium under the drive's mean square", "too many harmonics of the drive"
"""Reasons why there is no linear response."""
MOST_TURNS, SAME_VOLTAGE = 12, 1e-13
"""Most fixed-point iterations for the common equilibrium of films and circuits, and the change that ends them."""
RAMP = 33
"""Steps in which the voltages on both films of a double cone rise together."""
PEAK_ROUNDS, PEAK_FREQUENCIES = 4, 33
"""How often the interval of the largest linear stroke is narrowed, and by how many frequencies."""
PEAK_SAME = 1e-12
"""Relative difference of two of these that are the same but for rounding."""


@dataclass(frozen=True)
class LinearResponse:
    """``stroke`` (..., frequencies), and the complex amplitudes of the first two ``harmonics`` (..., 2, frequencies) of
    the drive, with the ensemble's axis before where there is one: the displacement is the imaginary part of harmonic
    times exp(i k omega t)."""

    stroke: Array
    harmonics: npt.NDArray[np.complex128]


def linear_response(model: Ensemble, frequencies: Array) -> LinearResponse:
    """The response to the members' drives, linearised about the equilibria under their mean-square voltages.

    The force is proportional to the square of the film's voltage, whose harmonics drive the disc: for a sine with bias,
    2 v0 v at the drive frequency, and v^2/2 at twice that. With a bias and a small amplitude the response is that of
    `small_signal_response`. All harmonics are taken that change the stroke by 1e-3 or more. NaN without a stable
    equilibrium, and where these are more than `MOST_ORDERS`. ``frequencies`` are angular, (frequencies,) or (members,
    frequencies).
    """
    members = model.members()
    omega = np.atleast_1d(np.asarray(frequencies, dtype=float))
    omega = np.broadcast_to(omega, (members.size, omega.shape[-1]))
    if set(TIMED) & {
        quantity.scale for name, quantity in members.system.waveform.parameters.items() if name not in VOLTAGE
    }:
        alone = [_responses(members.replace(drive_frequency=frequency), frequency[:, None]) for frequency in omega.T]
        stroke, first = (np.concatenate(parts, axis=-1) for parts in zip(*alone, strict=True))
    else:
        stroke, first = _responses(members, omega)
    return LinearResponse(stroke, first) if model.shape else LinearResponse(stroke[0], first[0])


def linear_peak(members: Members, frequencies: Array, strokes: Array) -> tuple[Array, Array]:
    """The frequency of the largest linear stroke and that stroke, (members,), from those at ``frequencies`` (members,
    frequencies), and between the neighbours of the largest of them; NaN where there is none."""
    rows = np.arange(members.size)
    places, heights = frequencies, np.where(np.isnan(strokes), -1.0, strokes)
    for _ in range(PEAK_ROUNDS):
        best = heights.argmax(axis=1)
        at, height = places[rows, best, None], heights[rows, best, None]
        # neighbours that are the largest but for rounding would end the search
        low = np.where(places < at * (1.0 - PEAK_SAME), places, places[:, :1]).max(axis=1)
        high = np.where(places > at * (1.0 + PEAK_SAME), places, places[:, -1:]).min(axis=1)
        tried = np.sort(np.column_stack([np.linspace(low, high, PEAK_FREQUENCIES, axis=-1), at]), axis=1)
        new_strokes = np.asarray(linear_response(members, tried).stroke)
        places, heights = tried, np.where(tried == at, height, np.where(np.isnan(new_strokes), -1.0, new_strokes))
    best = heights.argmax(axis=1)
    largest = np.where(heights[rows, best] < 0.0, np.nan, heights[rows, best])
    return np.where(np.isnan(largest), np.nan, places[rows, best]), largest


def _responses(members: Members, omega: Array) -> tuple[Array, npt.NDArray[np.complex128]]:
    """Strokes (members, frequencies) and the first two harmonics (members, 2, frequencies)."""
    stroke, first = np.full(omega.shape, np.nan), np.full((members.size, 2, omega.shape[1]), np.nan + 0j)
    needed = _orders(members, omega)
    for orders in np.unique(needed[needed <= MOST_ORDERS]).tolist():
        for rows, columns in _blocks(needed == orders, orders):
            same_orders, at = needed[np.ix_(rows, columns)] == orders, omega[np.ix_(rows, columns)]
            harmonics = _harmonics(members.take(rows), at, orders)
            row, column = np.nonzero(same_orders)
            stroke[rows[row], columns[column]] = _stroke(harmonics)[same_orders]
            first[rows[row], :, columns[column]] = harmonics[..., :2][same_orders]
    return stroke, first


def quantity_of_stroke(members: Members, stroke: Array, frequencies: Array | None = None) -> dict[str, str]:
    """The quantity of linear strokes (members,) or (members, frequencies), with the reasons why there are none. Default
    the frequencies of the members."""
    omega = members.number("drive_frequency")[:, None] if frequencies is None else frequencies
    missing = np.isnan(stroke).reshape(omega.shape)
    many = missing & (_orders(members, omega) > MOST_ORDERS)
    reasons = [reason for reason, at in ((UNSTABLE, missing & ~many), (TOO_MANY, many)) if at.any()]
    return dataset.absent("length", **({"nan": " or ".join(reasons)} if reasons else {}))


def _orders(members: Members, omega: Array) -> npt.NDArray[np.int64]:
    """The number of harmonics to compute at drive frequencies (members, frequencies): a quarter of `PHASES` times a
    power of two, so that four samples of the motion lie in the period of the highest one."""
    waveform = members.system.waveform
    detail = np.broadcast_to(np.asarray(waveform.detail(members.own_numbers), dtype=float), members.shape)[:, None]
    needed = PER_SWING * detail
    if waveform.pieced:
        needed = np.maximum(needed, PER_RATE * members.rate[:, None] / omega)
    return PHASES // 4 * next_power_of_two(np.maximum(np.broadcast_to(needed, omega.shape) / (PHASES // 4), 1.0))


def _blocks(chosen: npt.NDArray[np.bool_], orders: int) -> Iterator[tuple[npt.NDArray[np.intp], npt.NDArray[np.intp]]]:
    """Rows and columns of blocks that cover the ``chosen`` places, none with more than `BLOCK` samples if it can."""
    rows, columns = (np.flatnonzero(chosen.any(axis=axis)) for axis in (1, 0))
    wide = max(1, min(columns.size, BLOCK // (4 * orders)))
    high = max(1, BLOCK // (4 * orders * wide))
    for row in range(0, rows.size, high):
        for column in range(0, columns.size, wide):
            yield rows[row : row + high], columns[column : column + wide]


def _stroke(harmonics: npt.NDArray[np.complex128]) -> Array:
    """The extent of the sums of harmonics (..., orders)."""
    orders = harmonics.shape[-1]
    terms = np.concatenate([np.zeros((*harmonics.shape[:-1], 1)), -0.5j * (4 * orders) * harmonics], axis=-1)
    return np.asarray(np.ptp(np.fft.irfft(terms, 4 * orders), axis=-1))


def slopes_of_drive(model: ConeModel) -> tuple[Array, Array]:
    """Slope of the static force, (1, 1), and derivatives of the rates of all states by the states, (1, 1, N, N), at
    rest under the mean squares of a single model's drive, at its frequency; NaN where there is no equilibrium."""
    members, omega = model.members(), np.full((1, 1), float(model.drive_frequency))
    at = _operating_point(members, omega, min(int(_orders(members, omega).item()), MOST_ORDERS))
    return at.stiffness, _slopes(model.system, at)[0]


def slopes_under(members: Members, place: Array, voltages: Sequence[Array]) -> Array:
    """Derivatives of the rates of all states by the states, (members, levels, N, N), at rest at displacements ``place``
    (members, levels) under constant voltages on the films."""
    system, n, shape = members.system, dict(members.numbers(trailing=1)), place.shape
    volts = [np.broadcast_to(voltage, shape) for voltage in voltages]
    commands = [command_at(system, line, place, v, n) for line, v in zip(system.film_lines, volts, strict=True)]
    n["voltage_bias"] = 0.5 * (commands[0] + commands[-1]) if system.in_opposite_phase else commands[0]
    z, n = _states_at_rest(system, place, [one**2 for one in volts], commands[0], n)
    rows = gradients(lambda z, n, xp: system.under(n[COMMAND], z, n, xp).rates(), z, {**n, COMMAND: commands[0]})
    return stacked(rows, shape)


@dataclass(frozen=True)
class _Rest:
    """Rest under constant voltages on the films, (members, frequencies) each: ``place``, ``stiffness``, all states
    ``z`` and the numbers ``n`` there."""

    place: Array
    stiffness: Array
    z: list[Array]
    n: Mapping[str, Any]


@dataclass(frozen=True)
class _OperatingPoint(_Rest):
    """Rest under the mean squares of the films' voltages: the effective ``squares`` of these voltages (members,
    frequencies or 1, samples), the ``mean`` command, and ``means``, the states with those of circuits at their
    means."""

    squares: list[Array]
    means: list[Array]
    mean: Array

    @property
    def mean_squares(self) -> list[Array]:
        """The means of the effective squares of the films' voltages."""
        return [np.mean(squared, axis=-1) for squared in self.squares]


def _operating_point(members: Members, omega: Array, orders: int) -> _OperatingPoint:
    """The operating point at drive frequencies (members, frequencies), of which ``orders`` multiples are computed.

    Films load the circuit, and its voltages determine their equilibrium; both are found by fixed-point iteration.
    """
    system, n = members.system, members.numbers(trailing=1)
    samples = np.asarray(system.waveform.samples(n, max(4 * orders, CORNERED if system.waveform.pieced else 0)))
    if system.ideal:
        n = members.numbers(trailing=2)
        commands = [np.asarray(system.command_of(line, samples, n)) for line in system.film_lines]
        squares = [np.broadcast_to(command**2, (members.size, 1, samples.shape[-1])) for command in commands]
        rest = _rest(members, squares)
        means = rest.z
    else:
        squares, passed = [np.zeros((*omega.shape, 1)) for _ in system.films], max(orders, LOADED)
        for _ in range(MOST_TURNS):
            rest, before = _rest(members, squares), squares
            squares, means = _loaded(system, rest, samples, omega, passed)
            change = [
                np.abs(now - old).max(initial=0.0, where=np.isfinite(now))
                for now, old in zip(squares, before, strict=True)
            ]
            if max(change) < SAME_VOLTAGE:
                break
    return _OperatingPoint(**vars(rest), squares=squares, means=means, mean=samples.mean(axis=-1))


def _rest(members: Members, squares: Sequence[Array]) -> _Rest:
    """Rest under the means of squared voltages (members, frequencies or 1, samples) on the films."""
    n, mean_squares = members.numbers(trailing=1), [np.mean(squared, axis=-1) for squared in squares]
    place, stiffness = _equilibria(members, mean_squares)
    return _Rest(place, stiffness, *_states_at_rest(members.system, place, mean_squares, n["voltage_bias"], n))


def _states_at_rest(
    system: ConeSystem, place: Array, squares: list[Array], command: Any, n: Mapping[str, Any]
) -> tuple[list[Array], dict[str, Any]]:
    """All states at rest under a constant command, with the disc held at displacements ``place`` and at squared
    voltages on the films, and the numbers ``n`` with the switches there."""
    z = [place, np.zeros(place.shape), *(np.broadcast_to(start, place.shape) for start in system.starts(place, n))]
    z, n = uncurrented(system, command, films_at_rest(system, squares, z, n), n), dict(n)
    with np.errstate(all="ignore"):
        n |= system.under(command, z, n).switches()
        for k, film in enumerate(system.films):
            n |= film.switches(place, squares[k], system.states_of(z, "film", k), n)
    return circuits_at_rest(system, command, z, n), n


def _loaded(
    system: ConeSystem, at: _Rest, samples: Array, omega: Array, orders: int
) -> tuple[list[Array], list[Array]]:
    """The effective squares of the films' voltages (members, frequencies, samples) through circuits that are linear
    about the bias, with the films held at the operating point; and all states, those of circuits at their means."""
    z = [np.broadcast_to(value, omega.shape)[..., None] for value in at.z]
    n = {name: np.asarray(value)[..., None] for name, value in at.n.items()}
    voltages = {}
    for line in system.lines:
        places = sorted(system.places_of(line))
        voltages[line.prefix], *circuit_states = _passed(system, line, at, samples, omega, orders)
        for i, values in zip(places, circuit_states, strict=True):
            z[i] = values
    squares = [system.squared_at(voltages[line.prefix], z, n, k) for k, line in enumerate(system.film_lines)]
    shape = (*omega.shape, samples.shape[-1])
    return [np.broadcast_to(squared, shape) for squared in squares], [value.mean(axis=-1) for value in z]


def _passed(system: ConeSystem, line: Line, at: _Rest, samples: Array, omega: Array, orders: int) -> list[Array]:
    """A line's voltage and the states of its circuit, (members, frequencies, samples) each; the states follow as many
    multiples of the drive frequency as ``orders`` says."""
    bias, shape, count = np.broadcast_to(at.n["voltage_bias"], at.place.shape), omega.shape, samples.shape[-1]
    slopes, places = stacked(_electric_slopes(system, line, at), shape), sorted(system.places_of(line))
    commanded = np.fft.rfft(np.broadcast_to(samples, (*shape, count)) - bias[..., None])
    commanded[np.abs(commanded) < SMALLEST_LINEAR_HARMONIC * count * np.abs(samples).max(axis=-1, keepdims=True)] = 0.0
    multiples = np.arange(commanded.shape[-1], dtype=float)
    multiples[0] = SMALLEST_LINEAR_HARMONIC  # a circuit may hold its charge at a constant voltage
    s = 1j * multiples * omega[..., None]
    rests = system.electric(line, bias, 0.0, at.z, at.n)[:1] + [at.z[i] for i in places]
    swings = [slopes[..., 0, 0, None] * commanded + s * slopes[..., 0, 1, None] * commanded]
    if places:
        low = np.flatnonzero((commanded[..., : orders + 1] != 0.0).any(axis=(0, 1)))
        to, by = s[..., low], [2 + i for i in places]
        inner = to[..., None, None] * np.eye(len(places)) - slopes[..., None, 1:, by]
        right = slopes[..., None, 1:, 0] + to[..., None] * slopes[..., None, 1:, 1]
        states = np.zeros((*commanded.shape, len(places)), dtype=complex)
        states[..., low, :] = solved_where_regular(inner, right) * commanded[..., low, None]
        swings[0] = swings[0] + np.einsum("...j,...kj->...k", slopes[..., 0, by], states)
        swings += list(np.moveaxis(states, -1, 0))
    return [
        np.broadcast_to(rest, shape)[..., None] + np.fft.irfft(swing, count)
        for rest, swing in zip(rests, swings, strict=True)
    ]


def _electric_slopes(system: ConeSystem, line: Line, at: _Rest) -> list[list[Any]]:
    """Derivatives of a line's voltage and of the rates of its circuit's states, by the command, its rate and all
    states."""
    bias = np.broadcast_to(at.n["voltage_bias"], at.place.shape)
    slopes = _electric_slopes_of(system, system.lines.index(line), tuple(at.n))
    return slopes([bias, 0.0 * bias, *at.z], at.n)


@lru_cache(maxsize=64)
def _electric_slopes_of(system: ConeSystem, place: int, names: tuple[str, ...]) -> Gradients:
    """The derivatives for `_electric_slopes` of the line at a place."""
    line = system.lines[place]
    return Gradients(lambda v, n, xp: system.electric(line, v[0], v[1], v[2:], n, xp), 2 + len(system.states), names)


def _equilibria(members: Members, mean_squares: Sequence[Array]) -> tuple[Array, Array]:
    """Displacement and stiffness at rest under the mean squares of the films' voltages, (members, levels) each; NaN
    where there is none."""
    if len(members.system.films) > 1:
        return _under_both(members, mean_squares)
    (squared,) = mean_squares
    balances = balances_of_films(members)
    rests = each(rest_of, balances, [None] * len(balances))
    place = np.stack(
        [balance.along_ramp(rest, squares)[0] for balance, rest, squares in zip(balances, rests, squared, strict=True)]
    )
    return place, np.asarray(members.stiffness(place, np.sqrt(squared)))


def _harmonics(members: Members, omega: Array, orders: int) -> npt.NDArray[np.complex128]:
    """Complex amplitudes (members, frequencies, orders) of the displacement at multiples of drive frequencies."""
    at = _operating_point(members, omega, orders)
    # amplitudes as multiples of sines: the displacement is the imaginary part of the sum
    drives = []
    for squared, mean_square in zip(at.squares, at.mean_squares, strict=True):
        harmonics = 2j * np.fft.rfft(squared)[..., 1 : orders + 1] / squared.shape[-1]
        harmonics[np.abs(harmonics) < SMALLEST_LINEAR_HARMONIC * mean_square[..., None]] = 0.0
        drives.append(np.broadcast_to(harmonics, (*at.place.shape, orders)))
    driven_orders = np.flatnonzero(np.any([(drive != 0.0).any(axis=(0, 1)) for drive in drives], axis=0))
    drives = [drive[..., driven_orders] for drive in drives]
    multiples = (driven_orders + 1) * omega[..., None]
    if members.system.planar and members.system.ideal:
        drive = np.zeros((*at.place.shape, driven_orders.size), dtype=complex)
        for film, mean_square, harmonics in zip(members.system.films, at.mean_squares, drives, strict=True):
            with np.errstate(all="ignore"):
                gain = np.broadcast_to(film.voltage_gain(at.place, mean_square, at.n), at.place.shape)
            drive = drive + gain[..., None] * harmonics
        damping = members.values["damping_ratio"][:, None, None]
        with np.errstate(invalid="ignore"):  # NaN beyond pull-in
            response = drive / (at.stiffness[..., None] - multiples**2 + 2j * damping * multiples)
    else:
        response = _response(members.system, at, drives, multiples)
    amplitudes = np.zeros((*omega.shape, orders), dtype=complex)
    amplitudes[..., driven_orders] = response
    stable = (at.stiffness > 0.0)[..., None]
    return np.where(stable, amplitudes, np.nan)


def _response(
    system: ConeSystem, at: _OperatingPoint, drives: Sequence[npt.NDArray[np.complex128]], multiples: Array
) -> npt.NDArray[np.complex128]:
    """The complex amplitudes of the displacement, with the other states and the voltages moving, too.

    The effective squared voltage on a film is that of the drive with the film at rest, plus its change by the motion at
    the means of the drive.
    """
    slopes, films = _slopes(system, at)
    right = np.zeros((*multiples.shape, len(system.states)), dtype=complex)
    for film, drive in zip(films, drives, strict=True):
        right += film[..., None, :] * drive[..., None]
    matrices = 1j * multiples[..., None, None] * np.eye(len(system.states)) - slopes[..., None, :, :]
    return np.asarray(solved_where_regular(matrices, right)[..., 0])


def _slopes(system: ConeSystem, at: _OperatingPoint) -> tuple[Array, list[Array]]:
    """Derivatives of the rates of all states by the states, (members, frequencies, N, N), and by the squared voltage on
    each film, (members, frequencies, N); at mean voltages."""
    shape, count, places = at.place.shape, len(system.states), system.mechanical
    with np.errstate(all="ignore"):
        held = gradients(
            lambda v, n, xp: system.rates_held(v[count:], v[:count], n, xp), [*at.z, *at.mean_squares], at.n
        )
        by, slopes, films = stacked(held, shape), np.zeros((*shape, count, count)), []
        slopes[..., places, :] = by[..., :count]
        moved = gradients(
            lambda z, n, xp: system.under(n[COMMAND], z, n, xp).squares(), at.means, {**at.n, COMMAND: at.mean}
        )
        for k, row in enumerate(moved):
            film = np.zeros((*shape, count))
            film[..., places] = by[..., count + k]
            slopes += film[..., :, None] * stacked([row], shape)
            films.append(film)
        for line in system.lines:
            if circuit_places := sorted(system.places_of(line)):
                slopes[..., circuit_places, :] = stacked(
                    [row[2:] for row in _electric_slopes(system, line, at)[1:]], shape
                )
    return slopes, films


def _under_both(members: Members, mean_squares: Sequence[Array]) -> tuple[Array, Array]:
    """Equilibria of double cones under constant voltages that rise from 0 in proportion, and their stiffness; NaN where
    stability is lost on the way."""
    system, n = members.system, members.numbers(trailing=1)
    squares = np.broadcast_arrays(*mean_squares)
    x = np.broadcast_to(np.reshape(rest_displacements(members), (-1, 1)), squares[0].shape)
    for share in np.linspace(0.0, 1.0, RAMP):
        x, stiffness = stable_near(x, partial(system.force_under, squares=[share * square for square in squares], n=n))
    return x, stiffness
