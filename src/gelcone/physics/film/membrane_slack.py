"""The membrane without tension: it is stretched evenly, by t^(1/2) in both directions, with V G = Vb(t).

Vb is that of `gelcone.membrane.crumpling`. Where the hoop is the more stretched direction the rims of the film
keep their tension, and its area is that of the flat film, ``flat_area_i`` of `gelcone.membrane.table`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from gelcone.bracket import rise
from gelcone.membrane import force as formulas
from gelcone.membrane.crumpling import MOST_STRETCHED, crumpling
from gelcone.membrane.force import FLAT
from gelcone.physics.component import Numbers
from gelcone.physics.implicit import known, root
from gelcone.physics.laws import StrainEnergyLaw


def natural_stretch(law: StrainEnergyLaw, V: Any, n: Numbers) -> Any:
    """Solve V G = Vb(t) for the squared stretch t, of arrays."""
    most = np.minimum(n["hump"], 0.5 * (law.strain_limit(n) + 3.0))
    high = np.minimum(most, MOST_STRETCHED) + 0.0 * V
    return rise(lambda t: crumpling(law, t, n) - V * n["G"], np.ones_like(high), high)


def energy_and_area(law: StrainEnergyLaw, V: Any, n: Numbers) -> tuple[Any, Any]:
    """Energy of film and field less the charge times the voltage, and the squared area ratio t^2 G."""
    t = natural_stretch(law, V, n)
    strain = 2.0 * t + 1.0 / (t * t) - 3.0
    area = t * t * n["G"]
    return law.energy(strain, n) - 0.5 * V * area, area


def area(law: StrainEnergyLaw, V: Any, n: Numbers) -> Any:
    """The capacitance, of arrays: t^2 G, or that of the flat film where the hoop is the more stretched direction."""
    return np.where(n["even_slack"] > 0.0, energy_and_area(law, V, n)[1], _flat_area(V, n))


def _flat_area(V: Any, n: Numbers) -> Any:
    powers = formulas.powers(V, FLAT)
    return 1.0 + sum(n[f"flat_area_{i}"] * power for i, power in enumerate(powers[: FLAT + 1]))


def traced_stretch(law: StrainEnergyLaw, squared: Any, share: Any, n: Numbers, xp: Any) -> Any:
    """The root t of V G = Vb(t) in a program where ``share`` is 1; 1 where it is 0."""

    def residual(t: Any, squared: Any, xp: Any) -> Any:
        inverse = 1.0 / t
        compliance = law.compliance(2.0 * t + inverse * inverse - 3.0, n, xp)
        slack = 1.0 - inverse * inverse * inverse - squared * n["G"] * t * compliance
        return (1.0 - share) * (t - 1.0) + share * slack

    name = f"length of a slack film at {[xp.node(value).index for value in (squared, share, n['G'])]}"
    return root(xp, name, residual, (squared,), lambda squared, xp: 1.0 + 0.0 * squared)


def traced_area(law: StrainEnergyLaw, squared: Any, pulls: Any, n: Numbers, xp: Any) -> Any:
    """The capacitance in a program: t^2 G, with t = 1 where the film ``pulls``; that of the flat film where the hoop is
    the more stretched direction."""
    even = n["even_slack"]
    t = traced_stretch(law, squared, even if known(pulls) == 0.0 else (1.0 - pulls) * even, n, xp)
    return even * (t * t * n["G"]) + (1.0 - even) * _flat_area(squared, n)
