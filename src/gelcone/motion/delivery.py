"""Voltage, current and power that the source delivers in a run, for which an amplifier must be built."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone.dataset import Variable, absent
from gelcone.motion.corners import Weighted, between_corners, root_mean_squares, sampled_evenly
from gelcone.motion.dwell import Path, dwell_times
from gelcone.motion.flow import integrate
from gelcone.motion.jumps import increasing, jumping, jumps_between
from gelcone.motion.peaks import largest
from gelcone.physics.members import Members
from gelcone.physics.structure import Line
from gelcone.quantity import Array

JUMPS = "the voltage jumps"
APPARENT = "apparent power, rms voltage times rms current of the sources"
LIMITED = {"slew_rate": ("slew_limited", "slew rate"), "current_limit": ("current_limited", "current limit")}
"""Limit of an amplifier -> name of the share of time at it, and words for it."""
NO_CURRENT = 1e-14
"""Share of the charge moved in a unit of time below which a current is rounding, as under a constant charge."""


def delivered(members: Members, times: Array, states: Array, lost: Array) -> dict[str, Variable]:
    """Deliveries of each source in motions at ``times`` and ``states`` (members, samples, N).

    These are root mean squares over the second half, computed between the corners of the voltage if it has some; peaks
    over the whole motion, also between samples; and the shares of the time at the limits of the amplifier. The names of
    a second film's source begin with ``second_``; the apparent power is the sum over the sources. Currents are infinite
    where the voltage jumps, so that energy is ``lost`` (members, samples).
    """
    jumped = lost[:, -1] > 0.0
    half = halfway(times)
    late = lost[:, -1] > lost[:, half]
    ran, whole = ~np.isnan(states[..., 0]), np.isfinite(states[:, -1, 0])
    variables, blocks = dict[str, Variable](), _between_corners(members, times, states, half)
    apparent, sources = np.zeros(len(times)), len(members.system.lines)
    sampled = sampled_evenly(times[:, 1:], states[:, 1:], states[:, 0], times[:, 0], times[:, -1])
    for index, line in enumerate(members.system.lines):
        source = "the source" if sources == 1 else f"the {'second' if line.prefix else 'first'} film's source"
        sizes = partial(_sizes, line)
        with np.errstate(all="ignore"):
            signals = np.where(ran, _of_source(line, members, times, states), np.nan)
            highest, rms = np.fmax.reduce(np.abs(signals[1:]), axis=-1), _root_mean_squares(times, signals[[0, 2]])
            between = largest(members, sampled, sizes, np.abs(signals[1:]))
            highest = np.where(whole, np.maximum(highest, between), highest)
            for rows, halves in blocks:
                block, to_the_end = members.take(rows), whole[rows]
                for path in halves:
                    peaks = np.maximum(highest[:, rows], largest(block, path, sizes))
                    highest[:, rows] = np.where(to_the_end, peaks, highest[:, rows])
                rms[:, rows] = np.where(to_the_end, root_mean_squares(block, halves[1])[index], rms[:, rows])
        charge, current, rate = highest
        if line.circuit.jumps and line.drive != "constant":
            current, rate = (np.where(jumped, np.inf, peak) for peak in (current, rate))
            rms[1] = np.where(late, np.inf, rms[1])
        line_variables: dict[str, tuple[Array, str, Any]] = {
            "rms_voltage": (rms[0], f"root mean square voltage of {source} in the second half", absent("voltage")),
            "rms_current": (
                rms[1],
                f"root mean square current of {source} in the second half",
                absent("current", infinite=JUMPS),
            ),
            "peak_charge": (charge, f"largest charge of {source}", absent("charge")),
            "peak_current": (current, f"largest current of {source}", absent("current", infinite=JUMPS)),
            "peak_slew_rate": (rate, f"fastest change of {source}", absent("slew rate", infinite=JUMPS)),
        }
        variables |= {line.prefix + name: ((), *variable) for name, variable in line_variables.items()}
        variables |= _limited(members, line, times, states)
        apparent = apparent + rms[0] * rms[1]
    return variables | {"apparent_power": ((), apparent, APPARENT, absent("apparent power", infinite=JUMPS))}


def halfway(times: Array) -> int:
    """The index of the sample at which the second half of the time of runs at ``times`` (members, samples) begins."""
    begin, end = times[:, :1], times[:, -1:]
    return int((times < begin + (0.5 - AT_END) * (end - begin)).sum(axis=1).max())


MOST_CORNERS = 4000
"""Most corners of a member between which its run is integrated again, and of the members at a time."""


def _between_corners(
    members: Members, times: Array, states: Array, half: int
) -> list[tuple[npt.NDArray[np.intp], list[Weighted]]]:
    """Blocks of the members with corners of their voltage, but not too many, and both halves of their runs between
    these. Which members are among them does not depend on the others."""
    waveform, ends = members.system.waveform, ((0, half), (half, -1))
    if not waveform.pieced:
        return []
    corners = waveform.corner_count(times[:, 0], times[:, -1], members.own_numbers)
    few = np.flatnonzero(corners <= MOST_CORNERS)
    size = max(1, int(MOST_CORNERS / corners[few].max(initial=1.0)))
    blocks = []
    for first in range(0, few.size, size):
        rows = few[first : first + size]
        begins = [
            (members.take(rows), states[rows, a], times[rows, a], times[rows, b] - times[rows, a]) for a, b in ends
        ]
        blocks.append((rows, [between_corners(*begin) for begin in begins]))
    return blocks


def _of_source(line: Line, members: Members, times: Array, states: Array) -> Array:
    """Voltage of a source, charge on its films, current into them and rate of the voltage, (4, members, samples), at
    ``times`` (members, samples) and ``states`` (members, samples, N). A current within rounding is 0."""
    system = members.system
    values = (system.source_voltages, system.source_charges, system.source_currents, system.source_rates)
    voltages, charges, currents, rates = (members.along(value, times, states) for value in values)
    first, index = line.films[0], system.lines.index(line)
    charge, current = charges[index], currents[index]
    rounding = np.abs(current) <= NO_CURRENT * np.abs(charge)
    return np.stack([voltages[first], charge, np.where(rounding, 0.0, current), rates[first]])


def _sizes(line: Line, members: Members, times: Array, states: Array) -> Array:
    """Magnitudes of charge, current and rate of the voltage of a source, (3, members, samples)."""
    return np.abs(_of_source(line, members, times, states)[1:])


def _root_mean_squares(times: Array, values: Array) -> Array:
    """The root mean squares of samples (..., members, samples) in the second half of the time, by trapezoids."""
    half = halfway(times)
    along, squares = times[:, half:], np.square(values[..., half:])
    return np.asarray(np.sqrt(np.trapezoid(squares, along, axis=-1) / (along[:, -1] - along[:, 0])))


def _limited(members: Members, line: Line, times: Array, states: Array) -> dict[str, Variable]:
    """The shares of the time of a run at the limits of a line's amplifier, by the times at which it meets them."""

    def excess(some: Members, at: Array, z: Array) -> dict[str, Array]:
        return dict(some.system.saturations(line, at, list(np.moveaxis(z, -1, 0)), some.numbers(at.ndim - 1)))

    excesses = excess(members, times, states)
    if not excesses:
        return {}
    ran = ~np.isnan(states[..., 0])
    spans = np.where(ran[:, :-1] & ran[:, 1:], np.diff(times, axis=1), 0.0).sum(axis=1)
    values = np.stack(
        [np.where(ran, np.broadcast_to(saturation, ran.shape), np.nan) for saturation in excesses.values()]
    )
    lasted, _ = dwell_times(
        Path(members, times, states), lambda some, at, z: np.stack([*excess(some, at, z).values()]), values
    )
    lasted = np.where(np.isnan(lasted), 0.0, lasted).sum(axis=-1)
    named = [LIMITED.get(name, (f"{name}_limited", f"limit {name.replace('_', ' ')}")) for name in excesses]
    return {
        line.prefix + variable: ((), duration / spans, f"share of the time at the {words}", "share")
        for (variable, words), duration in zip(named, lasted, strict=True)
    }


AT_END = 1e-9
"""Share of a span within which a corner lies at its end."""


def switched(members: Members, states: Array, times: Array, **flow: Any) -> Array:
    """Work of sources whose voltage jumps, and the energy lost of it, (2, members, samples), until ``times`` (members,
    samples) of motions from ``states`` (members, N) at time 0.

    The charge follows at once. v (Q+ - Q-) less the energy that film and field store is lost without a resistance:
    C (v+ - v-)^2/2 for a capacitance that does not depend on the voltage. Both are 0 behind a resistance or a filter.
    """
    system = members.system
    energies = np.zeros((2, *times.shape))
    lines = jumping(system)
    if not lines:
        return energies
    corners, before, after, jumps = jumps_between(members, np.zeros(members.size), times[:, -1])
    if not jumps.any():
        return energies
    wide, every = members.numbers(trailing=1), increasing(corners, times[:, -1])
    z = list(np.moveaxis(integrate(members, states, every, **flow).states, -1, 0))
    work, lost = np.zeros(corners.shape), np.zeros(corners.shape)
    for line in lines:
        pair = [system.command_of(line, voltage, wide) for voltage in (before, after)]
        for k in line.films:
            film, y = system.films[k], system.states_of(z, "film", k)
            charges = [v * film.capacitance(z[0], v * v, y, wide) for v in pair]
            stored = [
                film.work(z[0], v * v, y, wide) - 0.5 * v * v + v * charge
                for v, charge in zip(pair, charges, strict=True)
            ]
            supplied = pair[1] * (charges[1] - charges[0])
            # the rest of the charge follows late
            share = 1.0 - wide["dielectric_share"] if line.circuit.delays else 1.0
            work, lost = work + share * supplied, lost + share * (supplied - (stored[1] - stored[0]))
    sums = [np.cumsum(np.where(jumps, energy, 0.0), axis=1) for energy in (work, lost)]
    for row, passed in enumerate(corners):
        count = np.searchsorted(passed, times[row], side="right")
        for k, energy in enumerate(sums):
            energies[k, row] = np.append(0.0, energy[row])[count]
    return energies


def lost_in_jumps(members: Members, begin: Array, spans: Array, **flow: Any) -> Array:
    """Energy (members,) lost where voltages jump, in motions from ``begin`` (members, N) at phase 0 over whole repeats
    that last ``spans`` (members,). The jump at the end counts, the one at the start does not."""
    return switched(members, begin, (spans * (1.0 + AT_END))[:, None], **flow)[1][:, 0]
