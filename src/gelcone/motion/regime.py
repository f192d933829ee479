"""What kind of motion it is - rest, periodic, quasi-periodic, chaotic, not settled, left the domain - with evidence.

The motion settles, and a damped one is then looked for among cycles: one that returns and is on a cycle that attracts,
which Newton's method finds, has arrived. A start beside it (`gelcone.motion.lasting`) tells whether chaos takes part;
where it does, or where nothing settles soon, more starts show where they end and how long the chaos lasts. What none of
them leaves is followed for as long as there is patience and then measured: does the largest Lyapunov exponent have a
certain sign, and what does the 0-1 test say? Chaos that ends has a name of its own, and the exponents of what it ends
in.

With two states and damping, a quasi-periodic motion is impossible: its section points would lie on a closed curve, and
the map that carries the curve onto itself shrinks the area inside by exp(-2 zeta T). With more states it is possible,
and a damped motion whose largest exponent is zero within its error and whose 0-1 test is regular is named so.
"""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone.dataset import Findings
from gelcone.devices.analysis import analysis
from gelcone.motion.arrival import find_ended, follow_starts, tell_how_long
from gelcone.motion.evidence import Evidence, label_regimes
from gelcone.motion.examination import alive, examine, examine_returns, judge, look, measure, second_opinion
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.lasting import Nearby
from gelcone.motion.settle import check_budgets, repeats_lasting, settle, start_states, transient_of
from gelcone.physics.members import Members
from gelcone.physics.model import ConeModel
from gelcone.progress import Counted, Progress
from gelcone.quantity import Array, Time

if TYPE_CHECKING:
    import xarray as xr

PATIENCE, PATIENCE_PERIODS = 1e5, 300
"""Time, and forcing periods, for which chaos is followed by default: the longer of both."""
FOLLOW_TOLERANCE = 1e-6
"""Tolerance of damped motions once chaos has pulled nearby starts apart: one that settles forgets the error, and is
then polished; of chaos only times and averages are taken, which are uncertain by far more."""
MEASURE_TOLERANCE = 1e-8
"""The same while exponents are averaged."""


def classify(
    members: Members,
    states: Array,
    *,
    transient: float | None = None,
    patience: float | None = None,
    budget: float = 20_000.0,
    progress: Progress = None,
    **flow_options: Any,
) -> Evidence:
    """The regime of every member of a flattened ensemble from its initial state (members, N), with the evidence.

    The workhorse behind `regime`, bifurcation diagrams and maps: a member's result depends on nothing but itself.
    Options as in `regime`.
    """
    evidence = Evidence.blank(members.size, len(members.system.states))
    evidence.final[:] = states
    counted = Counted(progress)
    duration = transient_of(members, transient)
    longest = patience_of(members, patience)
    loose, averaging = (
        flow_options | {"tolerance": max(flow_options.get("tolerance", 0.0), least)}
        for least in (FOLLOW_TOLERANCE, MEASURE_TOLERANCE)
    )
    losing = np.flatnonzero(members.damped)
    _settle(members, np.flatnonzero(~members.damped), duration, evidence, flow_options)
    examine((examine_returns,), members, np.flatnonzero(~members.damped), evidence, flow_options)
    nearby = Nearby.at(evidence.final)
    follow_starts(members, losing, duration, longest, nearby, evidence, loose, flow_options, counted)
    wandering = alive(np.flatnonzero(np.isnan(evidence.cycle_distance)), evidence)
    measures = (partial(measure, budget=budget), second_opinion)
    damped = members.damped[wandering]
    examine(measures, members, wandering[~damped], evidence, flow_options)
    wandering = examine((look, *measures), members, wandering[damped], evidence, averaging)
    find_ended(members, wandering, nearby, evidence, flow_options)
    judge(members, evidence)
    tell_how_long(members, losing, duration, nearby, evidence)
    counted.finish()
    return evidence


def patience_of(members: Members, patience: float | None) -> Array:
    """For how long chaos is followed, (members,): ``patience``, or by default `PATIENCE` or `PATIENCE_PERIODS`."""
    if patience is not None:
        return np.full(members.size, float(patience))
    return np.maximum(PATIENCE, PATIENCE_PERIODS * members.forcing_period)


def _settle(
    members: Members,
    rows: npt.NDArray[np.intp],
    duration: Array,
    evidence: Evidence,
    options: dict[str, Any],
) -> None:
    """Lets ``duration`` (of all members) pass."""
    if not rows.size:
        return
    part = members.take(rows)
    evidence.final[rows], evidence.outcome[rows] = settle(
        part, evidence.final[rows], repeats_lasting(part, duration[rows]), **options
    )
    evidence.settled_time[rows] = duration[rows]


@analysis(
    swept=True,
    answers="motions",
    kinds=("regime", "sign"),
    bulky=("section",),
    examples=(
        "--set voltage=1.04 --set drive_frequency=0.1 --json",
        'paper-table1 --set "voltage_amplitude=5 kV,8 kV" --out results',
    ),
)
def regime(
    model: ConeModel,
    initial: npt.ArrayLike = (1.0, 0.0),
    *,
    transient: Time | None = None,
    patience: Time | None = None,
    budget: Time = 20_000.0,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Names the motion of every member after a transient, with the evidence.

    Parameters
    ----------
    model : one actuator or an ensemble.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    transient : time after which the motion is first examined; default by damping and drive
        (`gelcone.motion.settle.default_transient`).
    patience : time for which a damped motion that does not settle is followed before it is called chaotic, and all
        starts beside it together. Default 100,000, or 300 forcing periods where those are longer.
    budget : longest averaging time of the exponents. Default 20,000.
    tolerance : relative error of one integration step. Default 1e-15. Once chaos has pulled nearby starts
        apart, a damped motion is followed with at least 1e-6: it forgets the error, and is polished when it has
        settled. Chaos is measured with at least 1e-8.
    threads : worker threads; default one a core. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset with ``regime`` (codes of `Regime`, as CF flags), ``period`` in forcing periods (0: none), ``symmetric``
    (maps onto itself under x -> -x), and the evidence: ``lyapunov`` and ``standard_error`` (..., exponent) per unit
    time, from the Floquet multipliers of the cycle where there is one and averaged elsewhere, ``averaged_time``,
    ``return_distance`` (of the motion a period later, over its size), ``cycle_distance`` (of the motion from the cycle,
    over its size; with damping, where there is one), ``zero_one`` (only where the motion does not return),
    ``section`` (..., point, state), ``lowest`` and ``highest`` displacement, ``settled_time``, ``doubtful`` (1 where
    the evidence does not agree: read it before you believe the name), ``outcome``.
    Of chaos: ``seen_until``, the time to which the motion was seen to be chaotic; of 16 ``starts`` within 1e-9 the
    ``share_chaotic`` that still is, and the mean ``lifetime`` (infinite where none has ended) between ``lifetime_low``
    and ``lifetime_high``. Chaos that ends is ``transient chaos``; its period, section and exponents are those of what
    most of the starts end in. Over ``fate``, the most frequent first, where the starts end: ``fate_regime`` (-1:
    none), ``fate_period`` and ``fate_share`` between ``fate_share_low`` and ``fate_share_high``; ``coexisting`` is 1
    where some end and the others seem to last.

    Raises
    ------
    InputError : for a transient or budget that is not positive, no rounds, or when no member can start.
    """
    options: dict[str, Any] = {
        "transient": transient,
        "patience": patience,
        "budget": budget,
        "tolerance": tolerance,
    }
    states = start_states(model, initial)
    found = regime_cells(model.members(), states, **options, threads=threads, progress=progress)
    return label_regimes(model, found, options, "regime of motion")


def regime_cells(
    members: Members,
    states: Array,
    *,
    transient: float | None = None,
    patience: float | None = None,
    budget: float = 20_000.0,
    tolerance: float = DEFAULT_TOLERANCE,
    threads: int | None = None,
    progress: Progress = None,
) -> Findings:
    """What `regime` finds of every member of a flattened ensemble from its state (members, N); options as there."""
    check_budgets(transient=transient, patience=patience, budget=budget)
    evidence = classify(
        members,
        states,
        transient=transient,
        patience=patience,
        budget=budget,
        tolerance=tolerance,
        threads=threads,
        progress=progress,
    )
    return evidence.findings(members.system)
