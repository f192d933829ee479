"""Current and power that a settled motion takes from its source, from even samples over whole periods."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gelcone import dataset
from gelcone.motion.response import HEAT, HEATS, LOSSES
from gelcone.physics.members import Members
from gelcone.quantity import Array

ROUNDING = 1e-9
"""A power of less than this share of what goes back and forth is rounding."""
MEANINGS: Mapping[str, tuple[str, dataset.Of]] = {
    "current": ("largest current into a film", "current"),
    "power": ("mean power that the source gives", "power"),
    "apparent_power": ("apparent power: rms voltage times rms current of the sources", "apparent power"),
    "field": ("largest true field in a film", "field"),
    **HEAT,
}
"""What `electrical` finds, and the quantity of each."""


def electrical(members: Members, times: Array, states: Array) -> dict[str, Array]:
    """The numbers of `MEANINGS`, (members,) each, of motions at ``times`` (members, samples) in ``states`` (members,
    samples, N): even samples over whole periods of drive and motion, one end of which is left out.

    A motion that repeats stores nothing in the mean: the source gives what is lost, which is known better than voltage
    times current, most of which goes back and forth. NaN where a motion ended before.
    """
    z, n, system = list(np.moveaxis(states, -1, 0)), members.numbers(trailing=1), members.system
    with np.errstate(all="ignore"):  # of a motion that has ended
        voltages, currents = members.voltages(times, states), system.currents(times, z, n)
        back_and_forth = np.abs(sum(v * i for v, i in zip(voltages, currents, strict=True))).max(axis=1)
        powers = dict(zip(system.causes, system.powers(times, z, n), strict=True))
        lost = np.broadcast_to(sum(powers[cause] for cause in LOSSES if cause in powers), times.shape).mean(axis=1)
        fields = [np.broadcast_to(film.true_field, times.shape) for film in members.film_states(states, voltages)]
    heat = heating(powers, times.shape) / len(system.films) + 0.0 * z[0]
    return {
        "current": np.max([np.abs(own).max(axis=1) for own in currents], axis=0),
        "power": np.where(np.abs(lost) <= ROUNDING * back_and_forth, 0.0, lost),
        "apparent_power": apparent_power(members, times, states, currents),
        "field": np.max([own.max(axis=1) for own in fields], axis=0),
        "heat": heat.mean(axis=1),
        "heating": heat.mean(axis=1),
    }


def heating(powers: Mapping[str, Array], shape: tuple[int, ...]) -> Array:
    """The power that heats the films, from those by cause (`ConeSystem.powers`)."""
    return np.sum([np.broadcast_to(powers[cause], shape) for cause in HEATS if cause in powers] or [np.zeros(shape)], 0)


def apparent_power(members: Members, times: Array, states: Array, currents: Sequence[Array]) -> Array:
    """Rms voltage times rms current of each source, summed over the sources, (members,); of even samples (members,
    samples) with the ``currents`` into the films."""
    z, n, system = list(np.moveaxis(states, -1, 0)), members.numbers(trailing=1), members.system
    voltages, found = system.source_voltages(times, z, n), []
    for line in system.lines:
        current = sum((currents[k] for k in line.films[1:]), currents[line.films[0]])
        pair = np.broadcast_to(voltages[line.films[0]], times.shape), np.broadcast_to(current, times.shape)
        voltage, current = (np.sqrt(np.mean(own * own, axis=1)) for own in pair)
        found.append(voltage * current)
    return np.asarray(sum(found))
