"""Energy density of the film over its squared stretches from the mounted state, and its relaxed form with wrinkles.

Per mu and mounted volume, with m along the meridian, n along the hoop and the coefficients A, B, G of the cone model,

    phi(m, n) = W(I1 - 3) - v^2 m n/2,    I1 - 3 = A m + B n + G/(m n) - 3.

True stresses over mu are 2 m phi_m and 2 n phi_n. A film without bending stiffness bears no compression: it wrinkles.
The relaxed energy (tension field) gives a compressed direction the width that it would take freely,

    phi_r(m, n) = min of phi over m* >= m and n* >= n,

so that its stresses are never negative.
Pipkin, IMA J. Appl. Math. 36 (1986) 85; with a voltage, De Tommasi, Puglisi and Zurlo, J. Phys. D: Appl. Phys. 44
(2011) 345303. Under a voltage a free direction may have no such width: the film thins without end, or to the stretch
limit. The derivatives are NaN there. A weak net of elastic threads with the energy net (m + n)/2 is added, which
determines the position of slack rings.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gelcone.physics.component import Numbers
from gelcone.physics.laws import StrainEnergyLaw

STRETCH_ERROR = 1e-12
"""Relative error that Newton's method leaves in a squared stretch."""
MOST_ITERATIONS = 60


class Derivatives(NamedTuple):
    """First and second derivatives of the energy density by the squared stretches."""

    m: Any
    n: Any
    mm: Any
    mn: Any
    nn: Any


def strain(c: Numbers, m: Any, n: Any) -> Any:
    """I1 - 3 at the squared stretches from the mounted state."""
    return c["A"] * m + c["B"] * n + c["G"] / (m * n) - 3.0


def value(law: StrainEnergyLaw, c: Numbers, m: Any, n: Any, squared: float) -> Any:
    """phi(m, n) at v^2 = ``squared``."""
    return law.energy(strain(c, m, n), c) - 0.5 * squared * m * n


def derivatives(law: StrainEnergyLaw, c: Numbers, m: Any, n: Any, squared: float) -> Derivatives:
    """Derivatives of phi(m, n) at v^2 = ``squared``."""
    r = c["G"] / (m * n)
    invariant = c["A"] * m + c["B"] * n + r - 3.0
    by_m, by_n = c["A"] - r / m, c["B"] - r / n
    half = 0.5 * law.response(invariant, c)
    slope = 0.5 * law.response_slope(invariant, c)
    return Derivatives(
        m=half * by_m - 0.5 * squared * n,
        n=half * by_n - 0.5 * squared * m,
        mm=slope * by_m * by_m + 2.0 * half * r / (m * m),
        mn=slope * by_m * by_n + half * r / (m * n) - 0.5 * squared,
        nn=slope * by_n * by_n + 2.0 * half * r / (n * n),
    )


# --- wrinkles --------------------------------------------------------------------------------------------------------


def relaxed_value(law: StrainEnergyLaw, c: Numbers, m: Any, n: Any, squared: float, net: float) -> Any:
    """The sum of phi_r(m, n) and the energy of the net."""
    free_m, free_n = natural(law, c, m, n, squared)
    return value(law, c, free_m, free_n, squared) + 0.5 * net * (m + n)


def relaxed_derivatives(law: StrainEnergyLaw, c: Numbers, m: Any, n: Any, squared: float, net: float) -> Derivatives:
    """Derivatives of `relaxed_value`: zero force along a wrinkled direction, and less stiffness across it."""
    free_m, free_n = natural(law, c, m, n, squared)
    d = derivatives(law, c, free_m, free_n, squared)
    bears_m, bears_n = free_m == m, free_n == n
    taut = bears_m & bears_n
    with np.errstate(all="ignore"):
        relaxed = Derivatives(
            m=np.where(bears_m, d.m, 0.0) + 0.5 * net,
            n=np.where(bears_n, d.n, 0.0) + 0.5 * net,
            mm=np.where(taut, d.mm, np.where(bears_m, d.mm - d.mn * d.mn / d.nn, 0.0)),
            mn=np.where(taut, d.mn, 0.0),
            nn=np.where(taut, d.nn, np.where(bears_n, d.nn - d.mn * d.mn / d.mm, 0.0)),
        )
    lost = np.isnan(free_m) | np.isnan(free_n)
    return Derivatives(*(np.where(lost, np.nan, part) for part in relaxed))


def natural(law: StrainEnergyLaw, c: Numbers, m: Any, n: Any, squared: float) -> tuple[Any, Any]:
    """The squared stretches that the film takes when it may wrinkle: the given ones where the film is in tension, wider
    ones where it would be compressed. NaN where it has pulled in: where a free direction has no width without stress,
    or only one that is too narrow."""
    m, n = np.broadcast_arrays(np.asarray(m, dtype=float), np.asarray(n, dtype=float))
    free_m, free_n = m.copy(), n.copy()
    d = derivatives(law, c, m, n, squared)
    pushed = (d.m < 0.0) | (d.n < 0.0)
    if not pushed.any():
        return free_m, free_n
    p, q = m[pushed], n[pushed]
    hoop, along = np.full_like(p, np.nan), np.full_like(p, np.nan)
    with np.errstate(all="ignore"):
        narrow = d.n[pushed] < 0.0
        hoop[narrow] = _no_shorter(_free(law, c, p[narrow], squared, hoop=True), q[narrow])
        wrinkles_hoop = narrow & ~(derivatives(law, c, p, hoop, squared).m < 0.0)
        short = ~wrinkles_hoop & (d.m[pushed] < 0.0)
        along[short] = _no_shorter(_free(law, c, q[short], squared, hoop=False), p[short])
        wrinkles_along = short & ~(derivatives(law, c, along, q, squared).n < 0.0)
    free_m[pushed] = np.where(wrinkles_hoop, p, along)
    free_n[pushed] = np.where(wrinkles_hoop, hoop, q)
    both = ~wrinkles_hoop & ~wrinkles_along
    if both.any():
        slack = _slack(law, c, squared)
        slack_m, slack_n = (_no_shorter(free, than) for free, than in zip(slack, (p[both], q[both]), strict=True))
        place = np.flatnonzero(pushed)[both]
        free_m.flat[place], free_n.flat[place] = slack_m + 0.0 * slack_n, slack_n + 0.0 * slack_m
    return free_m, free_n


def _no_shorter(free: Any, than: Any) -> Any:
    """Free lengths, NaN where they are shorter than the gap that the film spans: there it has pulled in."""
    return np.where((free >= than * (1.0 - STRETCH_ERROR)) & (free < np.inf), free, np.nan)


def _free(law: StrainEnergyLaw, c: Numbers, held: Any, squared: float, *, hoop: bool) -> Any:
    """The squared stretch of a direction without stress, while the other one is held; NaN if there is none.

    Newton's method starts from the width without voltage, below the root. phi_n is concave there, so that the iterates
    rise to the first root.
    """
    along, across = (c["B"], c["A"]) if hoop else (c["A"], c["B"])
    limit, loss, ratio = law.strain_limit(c), 0.5 * squared * held, c["G"] / held
    free = np.sqrt(ratio / along)
    for _ in range(MOST_ITERATIONS):
        r = ratio / free
        invariant = across * held + along * free + r - 3.0
        free = np.where(invariant < limit, free, np.nan)
        by = along - r / free
        half = 0.5 * law.response(invariant, c)
        second = 0.5 * law.response_slope(invariant, c) * by * by + 2.0 * half * r / (free * free)
        step = -(half * by - loss) / np.where(second > 0.0, second, np.nan)
        free = free + step
        if not (np.abs(step) > 1e-14 * free).any():
            return free
    return np.where(np.abs(step) <= 1e-12 * free, free, np.nan)


def _slack(law: StrainEnergyLaw, c: Numbers, squared: float) -> tuple[float, float]:
    """The squared stretches of a film without any stress; NaN if the voltage leaves none.

    The true stretch t^(1/2) is the same in all directions: response (1 - t^-3) = v^2 G t.
    """
    t = 1.0
    for _ in range(MOST_ITERATIONS):
        response = float(law.response(2.0 * t + t**-2 - 3.0, c))
        slope = float(law.response_slope(2.0 * t + t**-2 - 3.0, c)) * (2.0 - 2.0 * t**-3)
        rate = response * 3.0 * t**-4 + slope * (1.0 - t**-3) - squared * float(c["G"])
        if not rate > 0.0:
            return np.nan, np.nan
        step = -(response * (1.0 - t**-3) - squared * float(c["G"]) * t) / rate
        t += step
        if abs(step) <= 1e-14 * t:
            break
    return t / float(c["A"]), t / float(c["B"])
