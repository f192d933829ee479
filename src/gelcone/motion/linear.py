"""Linear theory: the response to a drive, linearised about the equilibrium under its mean-square voltage."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.motion.regular import solved_where_regular
from gelcone.motion.rest import COMMAND, circuits_at_rest, films_at_rest, stacked, uncurrented
from gelcone.physics.balance import rest_of
from gelcone.physics.circuit import IdealSource
from gelcone.physics.commanded import command_at
from gelcone.physics.differentiate import gradients
from gelcone.physics.drive import PHASES
from gelcone.physics.members import Ensemble, Members
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import balances_of_films, each, rest_displacements
from gelcone.physics.structure import Line
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array

HARMONICS = 8
"""Multiples of the drive frequency that are taken into account."""
ROUNDING = 1e-13
"""Harmonics below this share of the mean square are rounding."""
NEWTON_STEPS = 20
MOST_TURNS, SAME_VOLTAGE = 12, 1e-13
"""Most fixed-point iterations for the common equilibrium of films and circuits, and the change that ends them."""
RAMP = 33
"""Steps in which the voltages on both films of a double cone rise together."""


@dataclass(frozen=True)
class LinearResponse:
    """``stroke`` (..., frequencies), and the complex amplitudes of the first two ``harmonics`` (..., 2, frequencies) of
    the drive, with the ensemble's axis before where there is one: the displacement is the imaginary part of harmonic
    times exp(i k omega t)."""

    stroke: Array
    harmonics: npt.NDArray[np.complex128]


def linear_response(model: Ensemble, frequencies: Array) -> LinearResponse:
    """The response to the members' own drives, linearised about the equilibria under their mean-square voltages.

    The force is proportional to the square of the film's voltage, whose harmonics drive the disc: for a sine with bias,
    2 v0 v at the drive frequency, and v^2/2 at twice that. With a bias and a small amplitude the response is that of
    `small_signal_response`. NaN without a stable equilibrium. ``frequencies`` are angular, (frequencies,) or (members,
    frequencies).
    """
    members = model.members()
    omega = np.atleast_1d(np.asarray(frequencies, dtype=float))
    omega = np.broadcast_to(omega, (members.size, omega.shape[-1]))
    harmonics = _harmonics(members, omega)
    turn = np.exp(2j * np.pi * np.arange(PHASES) / PHASES)
    orders = np.arange(1, HARMONICS + 1)
    motion = np.einsum("mfk,kp->mfp", harmonics, turn ** orders[:, None]).imag
    found = LinearResponse(np.ptp(motion, axis=2), np.moveaxis(harmonics[..., :2], -1, 1))
    return found if model.shape else LinearResponse(found.stroke[0], found.harmonics[0])


def slopes_of_drive(model: ConeModel) -> tuple[Array, Array]:
    """Slope of the static force, (1, 1), and derivatives of the rates of all states by the states, (1, 1, N, N), at
    rest under the mean squares of a single model's drive, at its own frequency; NaN where there is no equilibrium."""
    at = _operating_point(model.members(), np.full((1, 1), float(model.drive_frequency)))
    return at.stiffness, _slopes(model.system, at)[0]


def slopes_under(members: Members, place: Array, voltages: Sequence[Array]) -> Array:
    """Derivatives of the rates of all states by the states, (members, levels, N, N), at rest at displacements ``place``
    (members, levels) under constant voltages on the films."""
    system, n, shape = members.system, dict(members.numbers(trailing=1)), place.shape
    volts = [np.broadcast_to(voltage, shape) for voltage in voltages]
    commands = [command_at(system, system.line_of(k), place, one, n) for k, one in enumerate(volts)]
    opposite = len(system.films) > 1 and system.films[-1].drive == "opposite"
    n["voltage_bias"] = 0.5 * (commands[0] + commands[-1]) if opposite else commands[0]
    at = _OperatingPoint(place, place, [one[..., None] for one in volts], [], n, commands[0])
    at = _settled(members, at)
    rows = gradients(lambda z, n, xp: system.rates_under(n[COMMAND], z, n, xp), at.z, {**at.n, COMMAND: commands[0]})
    return stacked(rows, shape)


@dataclass(frozen=True)
class _OperatingPoint:
    """Rest under the mean squares of the films' voltages, (members, frequencies) each: ``place``, ``stiffness``, all
    states ``z``, the numbers ``n`` and the constant ``command`` there; and the films' ``voltages`` (members,
    frequencies or 1, PHASES)."""

    place: Array
    stiffness: Array
    voltages: list[Array]
    z: list[Array]
    n: Mapping[str, Any]
    command: Any

    @property
    def mean_squares(self) -> list[Array]:
        """The mean squares of the films' voltages."""
        return [np.mean(voltage**2, axis=-1) for voltage in self.voltages]


def _operating_point(members: Members, omega: Array) -> _OperatingPoint:
    """The operating point at drive frequencies (members, frequencies).

    Films load the circuit, and its voltages determine their equilibrium; both are found by fixed-point iteration.
    """
    system, n = members.system, members.numbers(trailing=1)
    samples = np.asarray(system.waveform.samples(n))
    lines = [system.line_of(film) for film in range(len(system.films))]
    commands = [np.asarray(system.command_of(line, samples, members.numbers(trailing=2))) for line in lines]
    voltages = [np.broadcast_to(command, (members.size, 1, PHASES)) for command in commands]
    if all_ideal(system):
        place, stiffness = _equilibria(members, [np.mean(voltage**2, axis=-1) for voltage in voltages])
        return _settled(members, _OperatingPoint(place, stiffness, voltages, [], n, n["voltage_bias"]))
    voltages = [np.zeros((*omega.shape, PHASES)) for _ in lines]
    for _ in range(MOST_TURNS):
        place, stiffness = _equilibria(members, [np.mean(voltage**2, axis=-1) for voltage in voltages])
        found = _settled(members, _OperatingPoint(place, stiffness, voltages, [], n, n["voltage_bias"]))
        before, voltages = voltages, [_loaded(system, line, found, samples, omega) for line in lines]
        change = [
            np.abs(now - old).max(initial=0.0, where=np.isfinite(now))
            for now, old in zip(voltages, before, strict=True)
        ]
        if max(change) < SAME_VOLTAGE:
            break
    return replace(found, voltages=voltages)


def all_ideal(system: ConeSystem) -> bool:
    """True if all films have the commanded voltages."""
    return all(line.circuit == IdealSource() for line in system.lines)


def _settled(members: Members, at: _OperatingPoint) -> _OperatingPoint:
    """The operating point with the equilibrium of all states there."""
    system, squares = members.system, at.mean_squares
    shape = at.place.shape
    starts = [np.broadcast_to(start, shape) for start in system.starts(at.place, at.n)]
    bias, n = at.command, dict(at.n)
    z = films_at_rest(system, squares, [at.place, np.zeros(shape), *starts], n)
    z = uncurrented(system, bias, z, n)
    with np.errstate(all="ignore"):
        n |= system.switches_under(bias, z, n)
        for k, film in enumerate(system.films):
            n |= film.switches(at.place, squares[k], system.states_of(z, "film", k), n)
    return replace(at, z=circuits_at_rest(system, bias, z, n), n=n)


def _loaded(system: ConeSystem, line: Line, at: _OperatingPoint, samples: Array, omega: Array) -> Array:
    """A film's voltage (members, frequencies, PHASES) through a circuit that is linear about the bias, with the films
    held at the operating point."""
    bias, shape = np.broadcast_to(at.n["voltage_bias"], at.place.shape), omega.shape
    slopes = stacked(_electric_slopes(system, line, at), shape)
    own = [2 + i for i in sorted(system.places_of(line))]
    commanded = np.fft.rfft(np.broadcast_to(samples, (*shape, PHASES)))
    multiples = np.arange(commanded.shape[-1], dtype=float)
    multiples[0] = ROUNDING  # a circuit may hold its charge at a constant voltage
    s = 1j * multiples * omega[..., None]
    gain = slopes[..., 0, 0, None] + s * slopes[..., 0, 1, None]
    if own:
        inner = s[..., None, None] * np.eye(len(own)) - slopes[..., None, 1:, own]
        right = slopes[..., None, 1:, 0] + s[..., None] * slopes[..., None, 1:, 1]
        gain = gain + np.einsum("...j,...kj->...k", slopes[..., 0, own], solved_where_regular(inner, right))
    mean = np.broadcast_to(system.electric(line, bias, 0.0, at.z, at.n)[0], shape)
    swing = gain * (commanded - PHASES * bias[..., None] * (multiples == ROUNDING))
    return np.asarray(mean[..., None] + np.fft.irfft(swing, PHASES))


def _electric_slopes(system: ConeSystem, line: Line, at: _OperatingPoint) -> list[list[Any]]:
    """Derivatives of a line's voltage and of the rates of its circuit's states, by the command, its rate and all
    states."""
    bias = np.broadcast_to(at.n["voltage_bias"], at.place.shape)
    return gradients(lambda v, n, xp: system.electric(line, v[0], v[1], v[2:], n, xp), [bias, 0.0 * bias, *at.z], at.n)


def _equilibria(members: Members, mean_squares: Sequence[Array]) -> tuple[Array, Array]:
    """Displacement and stiffness at rest under the mean squares of the films' voltages, (members, levels) each; NaN
    where there is none."""
    if len(members.system.films) > 1:
        return _under_both(members, mean_squares)
    (squared,) = mean_squares
    balances = balances_of_films(members)
    rests = each(rest_of, balances, [None] * len(balances))
    place = np.stack(
        [balance.along_ramp(rest, own)[0] for balance, rest, own in zip(balances, rests, squared, strict=True)]
    )
    return place, np.asarray(members.stiffness(place, np.sqrt(squared)))


def _harmonics(members: Members, omega: Array) -> npt.NDArray[np.complex128]:
    """Complex amplitudes (members, frequencies, HARMONICS) of the displacement at multiples of drive frequencies."""
    if members.system.circuit.delays:  # the mean square of a delayed voltage is not that of the voltage
        return np.full((*omega.shape, HARMONICS), np.nan + 0j)
    at = _operating_point(members, omega)
    multiples = np.arange(1, HARMONICS + 1) * omega[..., None]
    # amplitudes as multiples of sines: the displacement is the imaginary part of the sum
    drives = []
    for voltage, mean_square in zip(at.voltages, at.mean_squares, strict=True):
        harmonics = 2j * np.fft.fft(voltage**2)[..., 1 : HARMONICS + 1] / PHASES
        harmonics[np.abs(harmonics) < ROUNDING * mean_square[..., None]] = 0.0
        drives.append(harmonics)
    if members.system.planar and all_ideal(members.system):
        drive = np.zeros((*at.place.shape, HARMONICS), dtype=complex)
        for film, mean_square, harmonics in zip(members.system.films, at.mean_squares, drives, strict=True):
            with np.errstate(all="ignore"):
                gain = np.broadcast_to(film.voltage_gain(at.place, mean_square, at.n), at.place.shape)
            drive = drive + gain[..., None] * harmonics
        damping = members.values["damping_ratio"][:, None, None]
        response = drive / (at.stiffness[..., None] - multiples**2 + 2j * damping * multiples)
    else:
        response = _response(members.system, at, drives, multiples)
    stable = np.broadcast_to((at.stiffness > 0.0)[..., None], response.shape)
    return np.where(stable, response, np.nan)


def _response(
    system: ConeSystem, at: _OperatingPoint, drives: Sequence[npt.NDArray[np.complex128]], multiples: Array
) -> npt.NDArray[np.complex128]:
    """The complex amplitudes of the displacement, with the other states and the voltages moving, too.

    The squared voltage on a film is that of the drive with the film at rest, plus twice the mean voltage times the
    change of the voltage by the motion.
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
        for k, voltage in enumerate(at.voltages):
            line = system.line_of(k)
            own = stacked([row[2:] for row in _electric_slopes(system, line, at)], shape)
            film = np.zeros((*shape, count))
            film[..., places] = by[..., count + k]
            slopes += 2.0 * voltage.mean(axis=-1)[..., None, None] * film[..., :, None] * own[..., 0, None, :]
            films.append(film)
            if system.places_of(line):
                slopes[..., sorted(system.places_of(line)), :] = own[..., 1:, :]
    return slopes, films


def _under_both(members: Members, mean_squares: Sequence[Array]) -> tuple[Array, Array]:
    """Equilibria of double cones under constant voltages that rise from 0 in proportion, and their stiffness; NaN where
    stability is lost on the way."""
    system, n = members.system, members.numbers(trailing=1)
    squares = np.broadcast_arrays(*mean_squares)
    x = np.broadcast_to(np.reshape(rest_displacements(members), (-1, 1)), squares[0].shape)
    stiffness = np.full(x.shape, np.nan)
    for share in np.linspace(0.0, 1.0, RAMP):
        with np.errstate(all="ignore"):
            for _ in range(NEWTON_STEPS):
                force, stiffness = system.force_under(x, [share * squared for squared in squares], n)
                x = x - force / stiffness
            x = np.where(np.isfinite(x) & (stiffness > 0.0), x, np.nan)
    return x, np.where(np.isnan(x), np.nan, stiffness)
