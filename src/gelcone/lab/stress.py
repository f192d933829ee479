"""The stress of a coupon with a prescribed stretch, from a strain-energy law and Maxwell branches.

The branches are those of films (`gelcone.physics.film.branches`). The stress of a branch over its modulus depends on
the relaxation time alone, so that a fit integrates each test once over a grid of relaxation times.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np

from gelcone.devices.materials import Material
from gelcone.devices.scales import VACUUM_PERMITTIVITY
from gelcone.errors import InputError
from gelcone.lab.coupons import Coupon
from gelcone.physics.film.branches import Branches
from gelcone.physics.laws import StrainEnergyLaw
from gelcone.quantity import Array

RELATIVE, ABSOLUTE = 1e-7, 1e-9
"""Tolerances of the integration of the branches."""
SAME_RATE = 1e-6
"""Difference of stretch rates, over the largest, below which they count as equal."""
NEWTON_STEPS = 30
PER_DECADE = 12
"""Relaxation times of the grid in a factor of ten."""


def squared_lengths(test: Coupon, stretch: Array | float) -> tuple[Any, Any]:
    """The squared stretches along and across a coupon; NaN across if the width depends on the voltage."""
    m = stretch * stretch
    if test.mode == "equi-biaxial":
        return m, m
    if test.mode == "pure shear" or test.width == "held":
        return m, 1.0 + 0.0 * m
    return m, (1.0 / stretch if known_width(test) else np.nan * m)


def known_width(test: Coupon) -> bool:
    """Whether the width of a coupon follows from its stretch alone, since it is held or there is no voltage."""
    return test.mode != "uniaxial" or test.width == "held" or test.voltage == 0.0


def law_stress(law: StrainEnergyLaw, n: Mapping[str, Any], m: Any, width: Any) -> Any:
    """Nominal stress of a law over its shear modulus, at squared stretches along and across."""
    third = 1.0 / (m * width)
    with np.errstate(all="ignore"):
        return law.response(m + width + third - 3.0, n) * (m - third) / np.sqrt(m)


def field_stress(test: Coupon, permittivity: float, m: Any, width: Any) -> Any:
    """Nominal stress, at most 0, that the voltage adds to a coupon."""
    if test.voltage == 0.0:
        return 0.0 * m
    return -_field_energy(test, permittivity) * m * width / np.sqrt(m)


def _field_energy(test: Coupon, permittivity: float) -> float:
    """Permittivity times the squared field in the unstretched film, Pa."""
    if not test.thickness > 0.0:
        raise InputError(
            f'{test.name}: has a voltage and no thickness; add thickness = "0.5 mm" for its file in tests.toml'
        )
    return permittivity * VACUUM_PERMITTIVITY * (test.voltage / test.thickness) ** 2


def branch_stresses(test: Coupon, times: Array, flow: str) -> Array:
    """Nominal stress over the modulus of branches with the relaxation ``times``, (times, samples).

    The width of the coupon must be known (`known_width`). 0 in a quasi-static test.
    """
    times = np.asarray(times, dtype=float)
    if not test.history[0].size or not times.size:
        return np.zeros((times.size, len(test.stress)))
    one = Branches(1, flow, 1, False)
    n = {"viscous_modulus_1": 1.0, "flow_rate_1": 1.0 / times, "inverse_viscous_limit_1": 0.0}
    size = len(one.states)
    start = np.ones((times.size, size))

    def rates(stretch: float, y: Array) -> Array:
        m, width = squared_lengths(test, stretch)
        branch_states = y.reshape(times.size, size)
        return np.stack(one.rates(m, width, list(branch_states.T), n), axis=-1).ravel()

    states = _integrated(test, rates, start.ravel(), band=size - 1).reshape(-1, times.size, size)
    m, width = squared_lengths(test, test.stretch[:, None])
    along, _ = one.stresses(m, width, list(np.moveaxis(states, -1, 0)), n)
    return (along / test.stretch[:, None]).T


def stress_of(test: Coupon, gel: Material) -> Array:
    """The nominal stress in Pa of a gel with its branches at the samples of a test; NaN where the coupon pulls in."""
    law, count, flow = gel.strain_energy_law, gel.branches, gel.flow or "log"
    n = law.numbers(law.complete(gel.law_parameters))
    moduli = np.array([getattr(gel, f"viscous_modulus_{k}") for k in range(1, count + 1)], dtype=float)
    times = np.array([getattr(gel, f"relaxation_time_{k}") for k in range(1, count + 1)], dtype=float)
    if not known_width(test):
        return _under_voltage(test, gel, law, n)
    m, width = squared_lengths(test, test.stretch)
    stress = gel.shear_modulus * law_stress(law, n, m, width) + moduli @ branch_stresses(test, times, flow)
    stress = stress + field_stress(test, gel.relative_permittivity, m, width)
    return np.maximum(stress, 0.0) if test.voltage > 0.0 else stress


def _under_voltage(test: Coupon, gel: Material, law: StrainEnergyLaw, n: Mapping[str, Any]) -> Array:
    """The nominal stress of a coupon with a free width under a voltage: the stress across it is 0 at all times."""
    mu, count, flow = gel.shear_modulus, gel.branches, gel.flow or "log"
    field = _field_energy(test, gel.relative_permittivity) / mu
    maxwell_branches = Branches(count, flow, 1, False)
    numbers = {
        **{f"viscous_modulus_{k}": getattr(gel, f"viscous_modulus_{k}") / mu for k in range(1, count + 1)},
        **{f"flow_rate_{k}": 1.0 / getattr(gel, f"relaxation_time_{k}") for k in range(1, count + 1)},
        **{f"inverse_viscous_limit_{k}": 0.0 for k in range(1, count + 1)},
    }
    across = partial(_width, law, n, maxwell_branches, numbers, field)

    def rates(stretch: float, y: Array) -> Array:
        m = stretch * stretch
        return np.stack(maxwell_branches.rates(m, across(m, list(y)), list(y), numbers))

    m = test.stretch * test.stretch
    if count and test.history[0].size:
        states = list(_integrated(test, rates, np.ones(len(maxwell_branches.states)), band=None).T)
    else:
        states = []
    width = np.array([across(m[k], [y[k] for y in states]) for k in range(m.size)])
    branches = maxwell_branches.stresses(m, width, states, numbers)[0] if states else 0.0
    true = law_stress(law, n, m, width) * test.stretch + branches - field * m * width
    return mu * np.where(np.isfinite(true), np.maximum(true, 0.0), np.nan) / test.stretch


def _width(
    law: StrainEnergyLaw, n: Mapping[str, Any], own: Branches, numbers: Mapping[str, Any], field: float, m: Any, y: Any
) -> Any:
    """Solve for the squared width without stress across the coupon, by Newton's method; NaN if there is none."""
    width = 1.0 / np.sqrt(m)
    with np.errstate(all="ignore"):
        for _ in range(NEWTON_STEPS):
            third = 1.0 / (m * width)
            strain = m + width + third - 3.0
            response, gap = law.response(strain, n), width - third
            stress = response * gap - field * m * width
            slope = response * (width + third) + law.response_slope(strain, n) * gap * gap - field * m * width
            if y:
                stress = stress + own.stresses(m, width, y, numbers)[1]
                slope = slope + own.slopes(m, width, y, numbers)[2]
            step = -stress / slope
            width = width * np.exp(np.clip(step, -0.5, 0.5)) if slope > 0.0 else np.nan
            if not abs(step) > 1e-12:
                break
    return width


# --- integration over the history of a test ---------------------------------------------------------------------------


def _integrated(test: Coupon, rates: Callable[[float, Array], Array], start: Array, band: int | None) -> Array:
    """Integrate ``rates`` under the prescribed stretch to states (samples, states); their Jacobian has ``band``
    off-diagonals, None for a full one.

    The stretch is linear between the corners of the history; integration stops at every corner where its rate changes.
    """
    from scipy.integrate import solve_ivp

    times, states = [0.0], [start]
    bands = {} if band is None else {"lband": band, "uband": band}
    for begin, end, first, rate, sample_times in _pieces(test.history):

        def slopes(t: float, y: Array, begin: float = begin, first: float = first, rate: float = rate) -> Array:
            return rates(first + rate * (t - begin), y)

        solution = solve_ivp(
            slopes, (begin, end), states[-1], "LSODA", t_eval=sample_times, rtol=RELATIVE, atol=ABSOLUTE, **bands
        )
        if not solution.success:
            raise InputError(
                f"{test.name}: its branches could not be integrated ({solution.message}); check its stretch"
            )
        times += list(solution.t)
        states += list(solution.y.T)
    return np.stack(states)[np.searchsorted(np.array(times), test.time, side="right") - 1]


def _pieces(history: tuple[Array, Array]) -> Iterator[tuple[float, float, float, float, Array]]:
    """Pieces of a history with a constant rate: begin, end, stretch at the begin, rate, and the corners up to the
    end."""
    times, first = np.unique(history[0], return_index=True)
    stretch = history[1][first]
    rate = np.diff(stretch) / np.diff(times)
    limit = SAME_RATE * max(float(np.abs(rate).max(initial=0.0)), 1e-300)
    begin = 0
    for k in range(1, len(times)):
        if k == len(times) - 1 or abs(rate[k] - rate[begin]) > limit:
            yield times[begin], times[k], stretch[begin], float(rate[begin]), times[begin + 1 : k + 1]
            begin = k


def relaxation_grid(tests: list[Coupon]) -> Array:
    """Relaxation times that tests can distinguish, evenly spaced in their logarithm, from a thirtieth of the shortest
    step to a hundred times the longest test."""
    timed = [test.history[0] for test in tests if test.history[0].size]
    if not timed:
        return np.empty(0)
    steps = [float(np.median(np.diff(np.unique(times)))) for times in timed]
    shortest, longest = min(steps) / 30.0, 100.0 * max(float(times[-1]) for times in timed)
    count = int(np.ceil(PER_DECADE * np.log10(longest / shortest))) + 1
    return np.geomspace(shortest, longest, max(count, 4))
