"""Studies behind figure 12: amplitude over drive frequency for six stiffnesses, and motions around a resonance."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone.atlas.branches.branch import EventKind
from gelcone.atlas.branches.continuation import continue_branch
from gelcone.atlas.frequency import frequency as frequency_response
from gelcone.dataset import attributes
from gelcone.motion.static_results import padded
from gelcone.paper.effort import Effort
from gelcone.paper.studies.study import Progress, Study, about
from gelcone.paper.studies.triples import motions
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import balances_of
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

CHECKS = 12
LONGEST_PERIOD = 2
"""Longest period of the stored branches."""
STIFFNESSES = (0.1, 0.5, 1.0, 5.0, 10.0, 20.0)
BAND = (0.05, 6.0)
"""Swept drive frequencies: from far below half the lowest natural frequency to above the highest one."""


def frequency(effort: Effort, progress: Progress) -> xr.Dataset:
    """Amplitude over drive frequency for six spring stiffnesses, in a sweep up and one down.

    The variables of `gelcone.frequency` over ``spring_stiffness``, ``sweep`` and ``step``. The drive frequency of a
    step is ``swept_frequency``, denser around the ``natural_frequency`` and half of it.
    """
    preset = effort.preset("spring")
    single = preset.model.replace(spring_stiffness=np.array(STIFFNESSES))
    natural = natural_frequencies(single)
    grid = _frequencies(natural, float(np.asarray(single.damping_ratio)), effort.frequencies)
    result = frequency_response(single, grid, preset.initial, progress=progress)
    variables: dict[str, dataset.Variable] = {
        "natural_frequency": ((), natural, "frequency of small swings at the mean-square voltage", "frequency"),
    }
    result = result.assign(dataset.label(single, variables, options={}, title="").data_vars)
    if effort.film == "taut":
        result = result.assign(_branches(preset.model, preset.initial, grid))
    result = result.swap_dims(member="spring_stiffness").rename(branch="sweep")
    options = {"initial": list(preset.initial)}
    return about(result, result, preset.name, "drive_frequency", effort, options, "amplitude over drive frequency")


def _branches(model: ConeModel, initial: tuple[float, float], grid: Array) -> dict[str, Any]:
    """Branches of periodic orbits of each stiffness over the frequency, joined with NaN between them: half the range of
    each orbit, its stability, and the folds."""
    rows = []
    for stiffness, frequencies in zip(STIFFNESSES, grid, strict=True):
        actuator, ends = model.replace(spring_stiffness=stiffness), (float(frequencies[0]), float(frequencies[-1]))
        branches = continue_branch(actuator, "drive_frequency", *ends, initial, start="settled", checks=CHECKS)
        short = branches.isel(branch=np.flatnonzero(branches["period"].values <= LONGEST_PERIOD))
        is_drawn = np.pad(np.isfinite(short["value"].values), ((0, 0), (0, 1)), constant_values=False)
        is_drawn[:, 1:] |= is_drawn[:, :-1]  # the NaN after each branch makes a gap
        half = 0.5 * (short["highest"] - short["lowest"])
        lines = (short["value"], half, short["stable"].where(short["stable"] >= 0))
        joined = (np.pad(line.values, ((0, 0), (0, 1)), constant_values=np.nan)[is_drawn] for line in lines)
        rows.append((*joined, branches["event_value"].values[branches["event_kind"].values == EventKind.FOLD]))
    frequency, amplitude, stable, fold = map(padded, zip(*rows, strict=True))
    along = ("member", "orbit")
    return {
        "branch_frequency": (along, frequency, attributes("drive frequency along branches", "frequency")),
        "branch_amplitude": (along, amplitude, attributes("half of what the orbit covers", "length")),
        "branch_stable": (along, stable, attributes("whether the orbit is stable", "flag")),
        "branch_fold": (("member", "fold"), fold, attributes("drive frequency of a fold", "frequency")),
    }


def natural_frequencies(model: ConeModel) -> Array:
    """Frequencies of small swings about the stable equilibrium under the drive's mean-square voltage, (members,)."""
    mean_square = np.array([0.5 * float(np.asarray(model.voltage)) ** 2])
    places = [balance.equilibria(mean_square)[0] for balance in balances_of(model)]
    return np.sqrt([max(place.slope for place in equilibria if place.stable) for equilibria in places])


def _frequencies(natural: Array, damping: float, count: int) -> Array:
    """Drive frequencies (members, count): evenly spaced on a log scale, and more around the resonances.

    The force has twice the drive's frequency, so the disc resonates at half its natural frequency; at the natural
    frequency itself the drive excites parametrically.
    """
    near_half, near_whole = int(0.35 * count), int(0.25 * count)
    even = np.geomspace(*BAND, count - near_half - near_whole)
    rows = []
    for resonance in natural:
        half = 0.5 * resonance + _around(min(4.0 * damping, 0.35 * resonance), near_half)
        whole = resonance + _around(min(8.0 * damping, 0.4 * resonance), near_whole)
        rows.append(np.sort(np.concatenate([even, half, whole])))
    return np.stack(rows)


def _around(reach: float, count: int) -> Array:
    """Offsets up to ``reach`` on either side, denser in the middle."""
    u = np.linspace(-1.0, 1.0, count)
    return reach * (0.3 * u + 0.7 * u**3)


RESPONSE_STIFFNESS = 1.0
RESPONSES = (0.7, 1.0, 1.5)
"""Drive frequencies of the responses, relative to the forced resonance at half the natural frequency."""


def frequency_responses(effort: Effort, progress: Progress) -> xr.Dataset:
    """Motions below, at and above the forced resonance of one stiffness, see `motions`."""
    preset = effort.preset("spring")
    one = preset.model.replace(spring_stiffness=np.array([RESPONSE_STIFFNESS]))
    resonance = 0.5 * natural_frequencies(one)[0]
    model = preset.model.replace(spring_stiffness=RESPONSE_STIFFNESS, drive_frequency=resonance * np.array(RESPONSES))
    return motions(preset, model, "drive_frequency", effort, progress)


STUDIES = (Study("frequency", frequency, work=14.0), Study("frequency-responses", frequency_responses, work=0.5))
