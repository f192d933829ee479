"""The taut film of the source paper: a homogeneous cone, in tension or compression alike.

A disc in the middle of a gel film is pushed out of plane; x is its height over the width of the film, q = 1 + x^2 the
square of the cone's slant over that width. With the meridional and hoop pre-stretches lm and lh the film's stretches
are l1 = lm sqrt(q), l2 = lh, l3 = 1/(l1 l2), and with A = lm^2, B = lh^2, G = 1/(A B)

    I1 - 3 = A q + B + G/q - 3.

Film and field pull the disc back with x (h(q) - V), where h comes from the strain-energy law and V is the squared
voltage.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gelcone.physics.component import Numbers
from gelcone.physics.film.film import FilmState, TracedState
from gelcone.physics.film.gel import RADIUS_RATIO, BranchedFilm, cone_reach


@dataclass(frozen=True)
class TautCone(BranchedFilm):
    """The homogeneous cone that bears compression. Its statics are those of the relaxed film.

    The parameter ``radius_ratio`` does not change the motion: where it is given, results state for which share of the
    motion the membrane, for which the cone stands, would have pulled in.

    Parameters
    ----------
    law : its strain-energy law. Default Gent.
    prestretch_mode : what one pre-stretch lp means: ``"radial"`` (lm = 1, lh = lp; default) or ``"equibiaxial"``
        (lm = lh = lp).
    branches : number of Maxwell branches, which relax parallel to the law (`gelcone.physics.film.branches`). Default 0.
    flow : their rule, ``"log"`` (default) or ``"linear"``.
    flow_exponent : odd exponent of the logarithmic rule under stress. Default 1.
    rested : where the branches have relaxed before a run, on the film as mounted (``"flat"``, default) or at its start
        (``"raised"``).
    reduced : numbers, from 1, of branches that relax within 0.02 and become dampers without states. The motion is right
        to second order; the film's stresses leave the damper out. Default none.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(film=gelcone.TautCone(gelcone.NeoHookean(), "equibiaxial"), prestretch=1.2)
    >>> gelcone.pitchfork_voltage(model).pitchfork_voltage.round(4).item()
    1.5677
    """

    name = "taut"
    linear_charge = True
    traced_charge = True

    def resting_lengths(self, x: Any, squared: Any, n: Numbers) -> tuple[Any, Any]:
        return 1.0 + np.square(x), 1.0

    def complete(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Check the parameters of the gel, and the radius ratio if it is given."""
        ratio = given.get("radius_ratio")
        known = {} if ratio is None else {"radius_ratio": RADIUS_RATIO["radius_ratio"].check("radius_ratio", ratio)}
        return super().complete(given) | known

    def numbers(self, parameters: Numbers) -> dict[str, Any]:
        return super().numbers(parameters) | self.viscous.numbers(parameters)

    def branch_lengths(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        return 1.0 + x * x, 1.0

    def force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> tuple[Any, Any]:
        """x k and k + 2 x^2 dh/dq, with k = h - V; h includes the branches."""
        xx = x * x
        h, h_slope = self.law.film_stiffness(1.0 + xx, n["A"], n["B"], n["G"], n, xp)
        if self.branches and y:
            pull, steeper = self.viscous.pull(1.0 + xx, y, n)
            h, h_slope = h + pull, h_slope + steeper
        k = h - squared
        return x * k, k + 2.0 * xx * h_slope

    def voltage_force(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        return squared * x

    def voltage_gain(self, x: Any, squared: Any, n: Numbers) -> Any:
        return x

    def strain(self, x: Any, n: Numbers) -> Any:
        """I1 - 3."""
        return self.cone_strain(x, n)

    def strain_limit(self, n: Numbers) -> Any:
        return self.law.strain_limit(n)

    def reach(self, n: Numbers) -> tuple[float, float]:
        least, most = cone_reach(self.strain_limit(n), n)
        return float(least), float(most)

    def outside(self, x: float, n: Numbers) -> str:
        limit, strain = float(self.strain_limit(n)), float(self.strain(x, n))
        if math.isinf(limit):
            return f"initial displacement {x:g}: its strain is beyond what doubles hold; start lower"
        return (
            f"stretch_limit = {limit:g}: must exceed I1 - 3 = {strain:.4g} at the initial displacement {x:g}; start "
            "lower or raise it"
        )

    def unreachable(self, n: Numbers) -> str:
        """The message for a single film that exceeds its stretch limit at every displacement, with the remedy."""
        A, B, G = (float(n[name]) for name in "ABG")
        least = 2.0 * math.sqrt(A * G) + B - 3.0 if G > A else A + B + G - 3.0
        return (
            f"stretch_limit = {float(self.strain_limit(n)):g}: must exceed the smallest I1 - 3 = {least:.4g} that the "
            "pre-stretch leaves at any displacement; raise the limit or bring the pre-stretch closer to 1"
        )

    def turning(self, x: Any, squared: Any, n: Numbers) -> Any:
        """2 x^3 dh/dq."""
        return 2.0 * x * x * x * self.law.film_stiffness(1.0 + x * x, n["A"], n["B"], n["G"], n)[1]

    def balancing(self, x: Any, pull: Any, n: Numbers) -> Any:
        """h - pull."""
        return self.law.film_stiffness(1.0 + np.square(x), n["A"], n["B"], n["G"], n)[0] - pull

    def work(self, x: Any, squared: Any, y: list[Any], n: Numbers) -> Any:
        """W - V x^2/2, plus the energy of the branches."""
        energy = self.law.energy(self.cone_strain(x, n), n) - 0.5 * squared * x * x
        return energy + self.viscous.energy(1.0 + x * x, 1.0, y, n) if self.branches and y else energy

    def capacitance(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any = np) -> Any:
        """q."""
        return 1.0 + x * x

    def describe(self) -> str:
        return "taut film: a homogeneous cone that bears compression" + self.viscous.words

    def limit_share(self, x: Any, voltage: Any, y: list[Any], n: Numbers, state: FilmState | None = None) -> Any:
        share = super().limit_share(x, voltage, y, n)
        return (
            np.maximum(share, self.viscous.limit_share(1.0 + np.square(x), 1.0, y, n)) if self.branches and y else share
        )

    def traced_state(self, x: Any, squared: Any, y: list[Any], n: Numbers, xp: Any) -> TracedState | None:
        q = 1.0 + x * x
        ring = self.traced_ring(q, 1.0, squared, n, xp, self.viscous.stresses(q, 1.0, y, n))
        if not self.branches:
            return ring
        return ring._replace(limit_share=xp.maximum(ring.limit_share, self.viscous.limit_share(q, 1.0, y, n, xp)))

    def state(self, x: Any, voltage: Any, y: list[Any], n: Numbers) -> FilmState:
        q, width = 1.0 + np.square(x), 1.0 + 0.0 * x
        branch_stress = self.viscous.stresses(q, width, y, n) if self.branches and y else (0.0, 0.0)
        return self.ring_state(q, width, voltage, n, branch_stress)
