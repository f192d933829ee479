"""Current and power that a settled motion takes from its source, from even samples over whole periods."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.motion.corners import Weighted, between_corners, root_mean_squares, sampled_evenly
from gelcone.motion.delivery import APPARENT, JUMPS, lost_in_jumps
from gelcone.motion.flow import integrate
from gelcone.motion.jumps import jumping
from gelcone.motion.peaks import largest
from gelcone.motion.response import HEAT, HEATS, LOSSES, heat_of, heats
from gelcone.physics.members import Members
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array

SMALLEST_POWER = 1e-9
"""Share of the power that goes back and forth below which a mean power is rounding."""
MEANINGS: Mapping[str, tuple[str, dataset.Of]] = {
    "current": ("largest current of a source", dataset.absent("current", infinite=JUMPS)),
    "power": ("mean power that the source gives", "power"),
    "damper_power": ("mean power dissipated by the damping of the disc, or taken by a load that acts as one", "power"),
    "film_power": ("mean power dissipated in the film", "power"),
    "resistor_power": ("mean power dissipated in the circuit's resistance, or where a voltage jumps", "power"),
    "leak_power": ("mean power dissipated by leakage through the film", "power"),
    "dielectric_power": ("mean power dissipated by a permittivity that follows late", "power"),
    "apparent_power": (APPARENT, dataset.absent("apparent power", infinite=JUMPS)),
    "field": ("largest true field in a film", "field"),
    **HEAT,
}
"""Variables of `electrical` -> meaning and quantity."""


def electrical(members: Members, times: Array, states: Array, begin: Array, **flow: Any) -> dict[str, Array]:
    """The numbers of `MEANINGS`, (members,) each; NaN for a motion that has ended.

    ``times`` (members, samples) and ``states`` (members, samples, N) are even samples over whole periods of drive and
    motion without the first, from ``begin`` (members, N) at phase 0; ``flow`` are options of the integration.
    """
    means, jumps = mean_deliveries(members, times, states, begin, **flow)
    path = path_of(members, times, states, begin, _lasts(times), **flow)
    current = largest(members, path, current_of, **flow)
    return {
        "current": np.where(jumps, np.inf, current),
        **{name: mean if name == "apparent_power" else mean + 0.0 * current for name, mean in means.items()},
        "field": largest(members, path, field_of, **flow),
    }


def _lasts(times: Array) -> Array:
    """The time that even samples last, (members,)."""
    return np.asarray((times[:, 1] - times[:, 0]) * times.shape[1])


def mean_deliveries(
    members: Members, times: Array, states: Array, begin: Array, **flow: Any
) -> tuple[dict[str, Array], npt.NDArray[np.bool_]]:
    """The averages among the numbers of `MEANINGS`, (members,) each, and the mask of members whose voltage jumps.
    Arguments as in `electrical`.

    The mean power of a periodic motion equals its losses. These are integrated, which is more accurate than the mean of
    voltage times current: most of that goes back and forth, and the current may peak between two samples.
    """
    lasts = _lasts(times)
    work = integrate(members, begin, lasts[:, None], keep="work", **flow).work
    assert work is not None
    system = members.system
    with np.errstate(all="ignore"):  # of a motion that has ended
        voltages, currents = members.voltages(times, states), members.along(system.currents, times, states)
        back_and_forth = np.abs(sum(v * i for v, i in zip(voltages, currents, strict=True))).max(axis=1)
        means = {
            cause: work[:, 0, system.causes.index(cause)] / lasts if cause in system.causes else np.zeros(len(times))
            for cause in LOSSES
        }
        rounding = SMALLEST_POWER * np.where(back_and_forth > 0.0, back_and_forth, np.inf)  # without voltage all is
        jumps = lost_in_jumps(members, begin, lasts, **flow)
        means["resistor"] = means["resistor"] + jumps / lasts
        lost = sum(means.values())
    path = path_of(members, times, states, begin, lasts, **flow)
    heat = heat_of(system, work)[:, 0] / lasts
    averages = {
        "power": np.where(np.abs(lost) <= rounding, 0.0, lost),
        **{f"{cause}_power": mean for cause, mean in means.items()},
        "apparent_power": np.where(jumps > 0.0, np.inf, apparent_power(members, path)),
        "heat": heat,
        "heating": heat,
    }
    return averages, jumps > 0.0


def known_of(system: ConeSystem) -> list[str]:
    """The names in `MEANINGS` that a system has: losses, unless only the damper has some, and heat."""
    lossy = {cause for cause in LOSSES if cause in system.causes} | ({"resistor"} if jumping(system) else set())
    absent = {f"{cause}_power" for cause in LOSSES if cause not in lossy or len(lossy) == 1}
    return [name for name in MEANINGS if name not in absent and (heats(system) or name not in HEAT)]


def heating(powers: Mapping[str, Array], shape: tuple[int, ...]) -> Array:
    """The power that heats the films, from the powers by cause (`ConeSystem.powers`)."""
    return np.sum([np.broadcast_to(powers[cause], shape) for cause in HEATS if cause in powers] or [np.zeros(shape)], 0)


def path_of(members: Members, times: Array, states: Array, begin: Array, spans: Array, **flow: Any) -> Weighted:
    """The samples (members, samples), or, for a voltage with corners, the motions from ``begin`` at phase 0 over
    ``spans`` sampled between these."""
    if members.system.waveform.pieced:
        return between_corners(members, begin, 0.0 * spans, spans, **flow)
    return sampled_evenly(times, states, begin, 0.0 * spans, spans)


def apparent_power(members: Members, path: Weighted) -> Array:
    """Rms voltage times rms current of each source, summed over the sources, (members,)."""
    return np.asarray(sum(voltage * current for voltage, current in root_mean_squares(members, path)))


def current_of(members: Members, times: Array, states: Array) -> Array:
    """The largest current of a source at ``times`` (members, samples) and ``states`` (members, samples, N)."""
    return np.asarray(np.abs(members.along(members.system.source_currents, times, states)).max(axis=0))


def field_of(members: Members, times: Array, states: Array) -> Array:
    """The largest true field in a film at ``times`` (members, samples) and ``states`` (members, samples, N)."""
    films = members.film_states(states, members.voltages(times, states))
    return np.asarray(np.max([np.broadcast_to(film.true_field, times.shape) for film in films], axis=0))


def charge_of(members: Members, times: Array, states: Array) -> Array:
    """The largest charge of a source at ``times`` (members, samples) and ``states`` (members, samples, N)."""
    return np.asarray(np.abs(members.along(members.system.source_charges, times, states)).max(axis=0))
