"""What is known of the motion of each member, and how it is labelled."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Regime
from gelcone.dataset import Findings, Variable
from gelcone.motion.cycle import RETURNS
from gelcone.motion.validity import unknown, validity_variables
from gelcone.physics.members import Ensemble
from gelcone.physics.system import ConeSystem
from gelcone.quantity import Array
from gelcone.statistics import wilson

if TYPE_CHECKING:
    import xarray as xr

FATES = 3
"""Attractors that are told apart, at most, among those that nearby starts end on."""


@dataclass
class Evidence:
    """All that is known of each member; arrays (members, ...).

    ``regime`` (a `Regime`), ``period`` in forcing periods (0: none), ``symmetric`` under x -> -x, ``return_distance``
    and ``cycle_distance`` over the motion's size, ``exponents`` and ``standard_error`` (members, N) with the
    ``averaged_time`` behind them and the ``sign`` of the largest (0: uncertain), ``zero_one`` with the sample
    ``test_phase`` of a forcing period at which it is taken, ``coexisting`` (nearby starts end on a cycle or rest that
    others never reach), ``under_way`` (the motion still leaves an unstable cycle, or has returned at last), ``lowest``
    and ``highest`` displacement, ``section`` (members, points, N), ``settled_time``, ``validity``,
    see `gelcone.motion.validity.validity`, ``outcome``, ``final`` states (members, N), and ``doubtful`` (the evidence
    does not agree).

    Of chaos, whether it lasts (see `gelcone.motion.lasting`): ``seen_until``, the time to which the motion was seen to
    be chaotic; ``share_chaotic`` of the nearby starts; the mean ``lifetime`` between ``lifetime_low`` and
    ``lifetime_high`` (NaN: no chaos; infinite: no end was seen). Where nearby starts end (members, `FATES`), the most
    frequent first: ``fate_regime`` (-1: none), ``fate_period`` and ``fate_share``, of as many starts as were
    ``followed``.
    """

    regime: npt.NDArray[np.int8]
    period: npt.NDArray[np.int64]
    symmetric: npt.NDArray[np.bool_]
    return_distance: Array
    cycle_distance: Array
    exponents: Array
    standard_error: Array
    averaged_time: Array
    sign: npt.NDArray[np.int8]
    zero_one: Array
    test_phase: npt.NDArray[np.int64]
    coexisting: npt.NDArray[np.bool_]
    under_way: npt.NDArray[np.bool_]
    lowest: Array
    highest: Array
    section: Array
    settled_time: Array
    validity: Array
    outcome: npt.NDArray[np.int8]
    final: Array
    doubtful: npt.NDArray[np.bool_]
    seen_until: Array
    share_chaotic: Array
    lifetime: Array
    lifetime_low: Array
    lifetime_high: Array
    fate_regime: npt.NDArray[np.int8]
    fate_period: npt.NDArray[np.int64]
    fate_share: Array
    followed: npt.NDArray[np.int64]

    @classmethod
    def blank(cls, count: int, states: int = 2) -> Evidence:
        """Nothing known yet of ``count`` members with so many states."""

        def nan(*shape: int) -> Array:
            return np.full((count, *shape), np.nan)

        return cls(
            regime=np.full(count, Regime.TRANSIENT, dtype=np.int8),
            period=np.zeros(count, dtype=np.int64),
            symmetric=np.zeros(count, dtype=bool),
            return_distance=nan(),
            cycle_distance=nan(),
            exponents=nan(states),
            standard_error=nan(states),
            averaged_time=np.zeros(count),
            sign=np.zeros(count, dtype=np.int8),
            zero_one=nan(),
            test_phase=np.zeros(count, dtype=np.int64),
            coexisting=np.zeros(count, dtype=bool),
            under_way=np.zeros(count, dtype=bool),
            lowest=nan(),
            highest=nan(),
            section=nan(RETURNS, states),
            settled_time=np.zeros(count),
            validity=unknown(count),
            outcome=np.zeros(count, dtype=np.int8),
            final=nan(states),
            doubtful=np.zeros(count, dtype=bool),
            seen_until=nan(),
            share_chaotic=nan(),
            lifetime=nan(),
            lifetime_low=nan(),
            lifetime_high=nan(),
            fate_regime=np.full((count, FATES), -1, dtype=np.int8),
            fate_period=np.zeros((count, FATES), dtype=np.int64),
            fate_share=np.zeros((count, FATES)),
            followed=np.ones(count, dtype=np.int64),
        )

    def take(self, rows: Any) -> Evidence:
        """The evidence of some members."""
        return Evidence(**{f.name: getattr(self, f.name)[rows] for f in fields(self)})

    @classmethod
    def join(cls, parts: list[Evidence]) -> Evidence:
        """The evidence of several groups of members, one after the other."""
        return cls(**{f.name: np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(cls)})

    def findings(self, system: ConeSystem) -> Findings:
        """The evidence as labelled variables and outcomes."""
        return Findings(self._variables(system), self.outcome)

    def _variables(self, system: ConeSystem) -> dict[str, Variable]:
        def code(values: npt.NDArray[Any]) -> npt.NDArray[np.int8]:
            return values.astype(np.int8)

        fate_low, fate_high = wilson(self.fate_share, self.followed[:, None])
        return {
            "regime": ((), self.regime, "kind of motion", "code"),
            "period": ((), self.period, "period in forcing periods, 0 if none", "count"),
            "symmetric": ((), code(self.symmetric), "1 if the motion equals its mirror image", "code"),
            "doubtful": ((), code(self.doubtful), "1 if the evidence does not agree", "code"),
            "lyapunov": (("exponent",), self.exponents, "Lyapunov exponents per unit time", "rate"),
            "standard_error": (("exponent",), self.standard_error, "standard error of the exponents", "rate"),
            "sign": ((), self.sign, "sign of the largest exponent, 0 if uncertain", "code"),
            "averaged_time": ((), self.averaged_time, "averaging time behind the exponents", "time"),
            "return_distance": ((), self.return_distance, "distance of returning points over size", "share"),
            "cycle_distance": ((), self.cycle_distance, "distance from the cycle over size", "share"),
            "zero_one": ((), self.zero_one, "0-1 test, 1 for chaos", "share"),
            "coexisting": (
                (),
                code(self.coexisting),
                "1 if nearby starts end on a cycle or rest that others never reach",
                "code",
            ),
            "lowest": ((), self.lowest, "lowest displacement", "length"),
            "highest": ((), self.highest, "highest displacement", "length"),
            "section": (("point", "state"), self.section, "states once every forcing period", "state"),
            "settled_time": ((), self.settled_time, "time before the motion was examined", "time"),
            **validity_variables(self.validity, self.outcome, system),
            "seen_until": ((), self.seen_until, "time to which the motion was seen to be chaotic", "time"),
            "share_chaotic": ((), self.share_chaotic, "share of the nearby starts that are still chaotic", "share"),
            "lifetime": ((), self.lifetime, "mean lifetime of chaos, infinite if no end was seen", "time"),
            "lifetime_low": ((), self.lifetime_low, "lower end of its 95 % interval", "time"),
            "lifetime_high": ((), self.lifetime_high, "upper end of its 95 % interval", "time"),
            "starts": ((), self.followed, "nearby starts that were followed, the motion's own among them", "count"),
            "fate_regime": (("fate",), self.fate_regime, "where nearby starts end: the regime, -1 if none", "code"),
            "fate_period": (("fate",), self.fate_period, "and its period in forcing periods", "count"),
            "fate_share": (("fate",), self.fate_share, "and the share of the starts that do", "share"),
            "fate_share_low": (("fate",), fate_low, "lower end of the share's 95 % interval", "share"),
            "fate_share_high": (("fate",), fate_high, "upper end of the share's 95 % interval", "share"),
        }


def label_evidence(model: Ensemble, evidence: Evidence, options: dict[str, Any], title: str) -> xr.Dataset:
    """Evidence of all members as a Dataset over the ensemble's dims."""
    return label_regimes(model, evidence.findings(model.system), options, title)


def label_regimes(model: Ensemble, found: Findings, options: dict[str, Any], title: str) -> xr.Dataset:
    """The same from its findings."""
    result = dataset.label(model, found.variables, outcome=found.outcome, options=options, title=title)
    result["regime"].attrs |= {
        "flag_values": np.array([r.value for r in Regime], dtype=np.int8),
        "flag_meanings": " ".join(r.name.lower() for r in Regime),
    }
    return result
