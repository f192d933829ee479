"""The films that claims are judged with: the paper's, and others in the same model and device.

The film ``creeping`` is a cone that wrinkles and creeps behind a resistance. We know of no measured branch of a PVC
gel. The branch is the fastest of three of another soft elastomer, VHB 4910, by its modulus over the long-term one and
with its linear flow rule: Wang, Decker, Henann and Chester, J. Mech. Phys. Solids (2016), as used by Stewart and Anand.
The scales of the paper's Table 1 device make its time and the resistance dimensionless.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from types import MappingProxyType
from typing import Any

from gelcone.devices.device import Device, find_device

PAPERS = "taut"
WRINKLING, MEMBRANE, CREEPING = OTHER_FILMS = ("wrinkling", "membrane", "creeping")
"""Films other than the paper's: a cone that cannot push; the true membrane, where a claim is about force or pull-in;
and a cone that also creeps, behind a resistance."""
SERIES_RESISTANCE = "1 MOhm"
LONG_TERM_MODULUS, BRANCH_MODULUS, BRANCH_TIME, FLOW = 15.36, 26.06, "0.6074 s", "linear"
"""Numbers of VHB 4910: moduli in kPa of the relaxed elastomer and of the branch, the branch's time, and its flow
rule."""
TAKEN = ("series_resistance", "viscous_modulus_1", "relaxation_time_1")
"""Dimensionless numbers that a model takes from the device."""


@cache
def film_of_device(film: str) -> Device:
    """The device of the paper's Table 1 with one of these films."""
    device = find_device("paper-table1")
    if film != CREEPING:
        return device.replace(film=film)
    branch = {
        "material.viscous_modulus_1": device.material.shear_modulus * (BRANCH_MODULUS / LONG_TERM_MODULUS),
        "material.relaxation_time_1": BRANCH_TIME,
        "material.flow": FLOW,
    }
    return device.replace(film=WRINKLING, series_resistance=SERIES_RESISTANCE, **branch)


@cache
def film_of_model(film: str) -> Mapping[str, Any]:
    """Model parameters of one of these films."""
    if film != CREEPING:
        return MappingProxyType({"film": film})
    values = film_of_device(film).to_model().values
    return MappingProxyType({"film": WRINKLING, "flow": FLOW} | {name: float(values[name]) for name in TAKEN})


def creeping_in_words() -> str:
    """The film ``creeping`` in words: the source of its numbers, and their dimensionless values."""
    numbers = film_of_model(CREEPING)
    resistance, modulus, time = (numbers[name] for name in TAKEN)
    return (
        f"A cone that wrinkles and creeps behind a series resistance of {SERIES_RESISTANCE} (rho = {resistance:.3g} by "
        f"the scales of the device paper-table1). One Maxwell branch with the linear flow rule, g = {modulus:.4g} and "
        f"tau = {time:.3g}: the fastest of the three of VHB 4910 ({BRANCH_MODULUS:g} kPa over a long-term modulus of "
        f"{LONG_TERM_MODULUS:g} kPa, {BRANCH_TIME}; Wang, Decker, Henann and Chester, J. Mech. Phys. Solids, 2016). "
        "The two slower ones are left out. We know of no measured branch of a PVC gel; this elastomer is an example. "
        "Everything else is as in the paper's film. This film is judged in full runs only, with the sizes of a quick "
        "one, and only for claims whose motions can be computed at an acceptable cost; its statics are those of the "
        "wrinkling film."
    )
