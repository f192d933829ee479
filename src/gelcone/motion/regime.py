"""Regimes of motion, with their evidence: the analysis behind `gelcone.regime`, and its labels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Regime
from gelcone.dataset import Findings, Variable, of_states
from gelcone.devices.analysis import analysis
from gelcone.motion.attractor.classification import Evidence, classify
from gelcone.motion.flow import DEFAULT_TOLERANCE
from gelcone.motion.settle import check_budgets
from gelcone.motion.start import start_states
from gelcone.motion.validity import validity_variables
from gelcone.physics.members import Ensemble, Members
from gelcone.physics.model import ConeModel
from gelcone.physics.system import ConeSystem
from gelcone.progress import Progress
from gelcone.quantity import Array, Time
from gelcone.statistics import wilson

if TYPE_CHECKING:
    import xarray as xr

_UNSEEN = dataset.absent("time", infinite="no end was seen")
"""Meaning of NaN and infinity of a lifetime; it is NaN for motions that are not chaotic."""


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
    """Name the motion of every member after a transient, with the evidence.

    Parameters
    ----------
    model : one actuator or an ensemble.
    initial : displacement and velocity at time 0, shape (2,) or ensemble shape + (2,). Default (1, 0).
    transient : time after which the motion is first examined; default by damping, drive and slow states. Where a film
        creeps so slowly that this is long, the drift is followed by the map over the forcing period instead.
    patience : time for which a damped motion is followed before it counts as chaotic, and limit of the time for all
        starts next to it together. Default the longest of 100,000, 300 forcing periods and 5 default transients.
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
    ``section`` (..., point, state), ``lowest`` and ``highest`` displacement, ``settled_time``, ``sign`` of the largest
    exponent (0: uncertain), ``doubtful`` (1 where the evidence does not agree: read it before you believe the name),
    ``validity_*`` and for a wrinkling film ``film_state_*``, shares of the settled motion's time as in
    `gelcone.simulate`, and ``outcome``.
    Of chaos: ``chaotic_until``, the time to which the motion was observed to be chaotic; of 16 ``starts`` within
    1e-9, without those that may have been settling all the time, the ``share_chaotic`` that still is, and the mean
    ``lifetime`` (infinite if none has ended) between ``lifetime_low`` and ``lifetime_high``. Chaos that ends is
    ``transient chaos``; its period, section and exponents are those of the attractor of most starts. Over ``fate``, the
    attractors of the starts, the most frequent first: ``fate_regime`` (-1: none), ``fate_period`` and ``fate_share``
    between ``fate_share_low`` and ``fate_share_high``;
    ``coexisting`` is 1 where some of the starts end soon on a cycle or rest and the others, against the odds, not at
    all.

    Raises
    ------
    InputError : for a transient, patience or budget that is not positive, or when no member can start.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(spring_stiffness=0.5, drive_frequency=0.3, voltage=[0.4, 0.9])
    >>> found = gelcone.regime(model)
    >>> [gelcone.Regime(code).label for code in found.regime.values], found.period.values.tolist()
    (['rest', 'periodic'], [0, 1])
    """
    options: dict[str, Any] = {"transient": transient, "patience": patience, "budget": budget, "tolerance": tolerance}
    states = start_states(model, initial)
    findings = regime_cells(model.members(), states, **options, threads=threads, progress=progress)
    return dataset.label(model, findings.variables, outcome=findings.outcome, options=options, title="regime of motion")


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
    """Compute `regime` for every member of a flattened ensemble from its state (members, N); options as there."""
    check_budgets(transient=transient, patience=patience, budget=budget)
    budgets: dict[str, Any] = {"transient": transient, "patience": patience, "budget": budget}
    evidence = classify(members, states, **budgets, tolerance=tolerance, threads=threads, progress=progress)
    return _findings(evidence, members.system)


def _findings(evidence: Evidence, system: ConeSystem) -> Findings:
    """The evidence as labelled variables and outcomes."""

    def code(values: npt.NDArray[Any]) -> npt.NDArray[np.int8]:
        return values.astype(np.int8)

    fate_low, fate_high = wilson(evidence.fate_share, evidence.followed[:, None])
    variables: dict[str, Variable] = {
        "regime": ((), evidence.regime, "kind of motion", Regime),
        "period": ((), evidence.period, "period in forcing periods, 0 if none", "count"),
        "symmetric": ((), code(evidence.symmetric), "1 if the motion equals its mirror image", "code"),
        "doubtful": ((), code(evidence.doubtful), "1 if the evidence does not agree", "code"),
        "lyapunov": (("exponent",), evidence.exponents, "Lyapunov exponents per unit time", "rate"),
        "standard_error": (("exponent",), evidence.standard_error, "standard error of the exponents", "rate"),
        "sign": ((), evidence.sign, "sign of the largest exponent, 0 if uncertain", "code"),
        "averaged_time": ((), evidence.averaged_time, "averaging time behind the exponents", "time"),
        "return_distance": ((), evidence.return_distance, "distance of returning points over size", "share"),
        "cycle_distance": ((), evidence.cycle_distance, "distance from the cycle over size", "share"),
        "zero_one": ((), evidence.zero_one, "0-1 test, 1 for chaos", dataset.absent("share")),
        "coexisting": (
            (),
            code(evidence.coexisting),
            "1 if some nearby starts end soon on a cycle or rest, and the others not at all",
            "code",
        ),
        "lowest": ((), evidence.lowest, "lowest displacement", "length"),
        "highest": ((), evidence.highest, "highest displacement", "length"),
        "section": (("point", "state"), evidence.section, "states once every forcing period", of_states(system)),
        "settled_time": ((), evidence.settled_time, "time before the motion was examined", "time"),
        **validity_variables(evidence.validity, evidence.outcome, system),
        "chaotic_until": ((), evidence.chaotic_until, "time to which the motion was observed to be chaotic", "time"),
        "share_chaotic": ((), evidence.share_chaotic, "share of the nearby starts that are still chaotic", "share"),
        "lifetime": ((), evidence.lifetime, "mean lifetime of chaos, infinite if no end was seen", _UNSEEN),
        "lifetime_low": ((), evidence.lifetime_low, "lower end of the 95 % interval of the mean lifetime", _UNSEEN),
        "lifetime_high": ((), evidence.lifetime_high, "upper end of the 95 % interval of the mean lifetime", _UNSEEN),
        "starts": ((), evidence.followed, "nearby starts that were followed, the motion's own among them", "count"),
        "fate_regime": (("fate",), evidence.fate_regime, "where nearby starts end: the regime, -1 if none", Regime),
        "fate_period": (
            ("fate",),
            evidence.fate_period,
            "where nearby starts end: the period in forcing periods",
            "count",
        ),
        "fate_share": (("fate",), evidence.fate_share, "where nearby starts end: the share of the starts", "share"),
        "fate_share_low": (("fate",), fate_low, "lower end of the 95 % interval of the share of the starts", "share"),
        "fate_share_high": (("fate",), fate_high, "upper end of the 95 % interval of the share of the starts", "share"),
    }
    return Findings(variables, evidence.outcome)


def label_evidence(model: Ensemble, evidence: Evidence, options: dict[str, Any], title: str) -> xr.Dataset:
    """Evidence of all members as a Dataset over the ensemble's dims."""
    findings = _findings(evidence, model.system)
    return dataset.label(model, findings.variables, outcome=findings.outcome, options=options, title=title)
