"""Extrema: the maxima and minima of the displacement, a section at zero velocity."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.dataset import with_initial
from gelcone.devices.analysis import analysis
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.settle import STILL, Piece, blocks, check_forcing_periods, pieces, samples_per_repeat, settle
from gelcone.motion.start import start_states
from gelcone.motion.static_results import padded
from gelcone.motion.turning import acceleration_at, turning_points
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.progress import Progress, split_progress
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

SAMPLES_PER_OSCILLATION = 26


@analysis(answers="trajectories", examples=("paper-table1 --json",))
def extrema(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    repeats: int = 200,
    discard: int = 200,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute the section at zero velocity: the maxima and minima of the displacement, with their times.

    The velocity's sign changes are bracketed by at least `SAMPLES_PER_OSCILLATION` samples an oscillation at the
    fastest rate (at most 65,536 a forcing period), and each is refined by integrating to it anew until the velocity
    left is below 1e-11 or the time's rounding. Two extrema closer together than the samples may be missed as a pair.

    Parameters
    ----------
    model, initial, tolerance, threads, progress : as in `section`.
    repeats : length of the run in forcing periods. Default 200.
    discard : forcing periods that pass before it. Default 200.

    Returns
    -------
    Dataset over the ensemble's dims and ``extremum``, in the order of time and padded with NaN where members differ in
    number: ``displacement``, ``velocity`` (the residual of the refinement), ``time`` since the start, ``phase`` within
    the forcing period (0 to 1, as exact late as early), ``maximum`` (1: a maximum, -1: a minimum, 0: padding);
    ``count``; and ``outcome``.

    Raises
    ------
    InputError : for no repeats, a negative discard, or an initial state of which no member lies inside its stretch
        limit.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4)
    >>> found = gelcone.extrema(model, repeats=1)
    >>> found.displacement.values.round(5).tolist(), found.maximum.values.tolist()
    ([0.83547, 0.42499], [1, -1])
    """
    states0, members = start_states(model, initial), model.members()
    check_forcing_periods(members, 1, repeats=repeats)
    check_forcing_periods(members, discard=discard)
    outcome = np.zeros(members.size, dtype=np.int8)
    piece_turns = []
    flow: dict[str, Any] = {"tolerance": tolerance, "threads": threads}
    for (samples,), rows in blocks(samples_per_repeat(members, SAMPLES_PER_OSCILLATION)):
        group = members.take(rows)
        settling, sampling = split_progress(progress, discard, repeats, share=rows.size / members.size)
        states, settled = settle(group, states0[rows], discard, progress=settling, **flow)
        shares = np.arange(samples) / samples
        for piece in pieces(group, states, repeats, shares, outcome=settled, progress=sampling, **flow):
            which, turns = _turning_points(group, piece, flow)
            turns[:, 0] += discard + piece.first
            piece_turns.append((rows[which], turns))
            outcome[rows] = piece.outcome
    which, rows = (np.concatenate(parts) for parts in zip(*piece_turns, strict=True))
    count = np.bincount(which, minlength=members.size)
    table = padded(np.split(rows[np.argsort(which, kind="stable")], np.cumsum(count)[:-1]))
    repeat = members.forcing_period[:, None]
    result = dataset.label(
        model,
        {
            "displacement": (("extremum",), table[..., 1], "displacement x = h/(b-a) at a turning point", "length"),
            "velocity": (("extremum",), table[..., 2], "velocity left at the turning point", "velocity"),
            "phase": (("extremum",), table[..., 0] % 1.0, "phase within the forcing period", "share"),
            "maximum": (
                ("extremum",),
                np.nan_to_num(table[..., 3]).astype(np.int8),
                "1: a maximum, -1: a minimum, 0: padding",
                "flag",
            ),
            "count": ((), count, "number of extrema", "count"),
        },
        coords={"time": (("extremum",), table[..., 0] * repeat, "time", "time")},
        outcome=outcome,
        options={"repeats": repeats, "discard": discard, "tolerance": tolerance},
        title="extrema",
    )
    return with_initial(result, model, states0)


def _turning_points(members: Members, piece: Piece, flow: dict[str, Any]) -> tuple[npt.NDArray[np.intp], Array]:
    """Indices of members, and (time, displacement, velocity, kind) of each turning point, in the order of time.

    The time is in forcing periods since the piece began. A turning point belongs to the samples between which the
    velocity changes its sign, including the later sample.
    """
    x, u = piece.states[..., 0], piece.states[..., 1]
    a = acceleration_at(members, piece.times, piece.states)
    # The sign just after the sample: that of the acceleration where the velocity is exactly zero.
    rising = np.where(u == 0.0, a, u) > 0.0
    moving = np.maximum(np.abs(a[:, :-1]), np.abs(a[:, 1:])) > STILL  # false for NaN
    which, sample = np.nonzero((rising[:, 1:] != rising[:, :-1]) & moving)
    if not which.size:
        return which, np.empty((0, 4))
    both = which[:, None], sample[:, None] + np.arange(2)
    sides = [values[both] for values in (piece.times, x, u, a)]
    kind = np.where(rising[which, sample], 1.0, -1.0)
    turning = members.take(which)
    times, states = turning_points(turning, piece.states[which, sample], sides, kind, **flow)
    return which, np.column_stack([times / turning.forcing_period, states, kind])
