"""A film as sums of Chebyshev polynomials, over the lengthening of its innermost ring and the voltage.

The innermost ring, whose hoop is held, has the squared meridional length 1 + z. Over z and the squared voltage V the
film is smooth, also where it localises: there x^2 = S(z, V) has its maximum at that V. With t = A (1 + z), the share
D = (V_s - V)/(V_s - V_low) of the voltage V_s = Vb(t)/G that slackens the ring, and p of z/(1 + z),

    S = z (e - L Q(p, D)),    F = x (s1/q) P(p, D),

where s1/q is the ring's own meridional tension and F the film's force. e is 1 for a film that falls slack before it
localises: S = z and F = 0 where D = 0 and with it the factor L (see `lowering`), as in the wrinkling cone; and 0 for
one that localises first, with L = -1. Q and P are sums of products of Chebyshev polynomials, plus such sums times the
square of what has fallen slack of the hoop at the rim and beside the disc: where a hoop begins to wrinkle the third
derivatives of the energy jump.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import chebyshev

from gelcone.errors import InputError
from gelcone.membrane.gel import Array, Gel, bisected
from gelcone.membrane.rings import HOOP, LOG
from gelcone.membrane.states import GOOD, LIMIT_SHARE, Film, States

MAIN, KINK, RIM = (9, 8), (4, 3), 5
"""Degrees in p and D of the sums; of those behind a kink; of the D at which the rim falls slack, in p."""
NODES, CHECKS = (18, 17), (9, 9)
"""States that are fitted and others, which take no part in it."""
SMALLEST = 1e-9
"""Singular values below this share of the largest are left out: the coefficients stay small."""
TINY = 1e-9
"""Added to V_s, so that a flat film without stress has a place."""
MOST_STRETCHED = 4.0
"""Largest stretch of the innermost ring, where nothing ends the film before."""
MOST_CHARGED = 3.0
"""Largest V over that of the flat film, or of 1/2, where no voltage ends it."""
AROUND = 1.0 + np.linspace(-0.3, 0.3, 601)
"""Lengthenings of the innermost ring, over that of a state, among which a table's is looked for."""
CORNER = 3.0
"""Weight of z over D where a flat film, in tension or about to fall slack, is two things."""
WEAK = 0.15
"""D below which Q is fitted as well as there."""
FLOOR = 0.02
"""Share of the force without voltage that is added to a force before its relative error is taken."""
LARGEST_ERROR = 0.15
"""Of a film that is still made; the error is largest where the force is weak."""
MARGIN = 1.5
"""The stated error over the largest that was found: others lie between."""


class Place(NamedTuple):
    """Of a ring: z/(1 + z), D, and what is negative where the hoop beside the disc is slack."""

    flatness: Any
    share: Any
    taut: Any


def place(z: Any, V: Any, A: Any, B: Any, G: Any, low: Any, compliance: Callable[[Any], Any]) -> Place:
    """Where the innermost ring stands; numbers, arrays or the expressions of a program."""
    flatness = z / (1.0 + z)
    shrunk = (1.0 - flatness) / A  # 1/t
    cube = A * A * A
    stress = (cube - 1.0 + cube * (z * (3.0 + z * (3.0 + z)))) * (shrunk * shrunk * shrunk)  # 1 - t^-3
    load = (G * A) * (1.0 + z) * compliance((2.0 * A) * (1.0 + z) + shrunk * shrunk - 3.0)
    room = 1.0 / (stress - low * load + TINY)
    r = G - G * flatness
    hoop = (B - r) * (1.0 - flatness) - V * compliance(A * (1.0 + z) + B + r - 3.0)
    return Place(flatness, (stress - V * load) * room, hoop * load * room)


def lowering(at: Place, anchor: Any, corner: Any) -> Any:
    """The factor of Q in S: D, 0 where the film falls slack. With a ``corner`` it is 1 for the flat film in tension;
    without an ``anchor`` it is -1."""
    share = at.share / (corner * (at.share + CORNER * at.flatness) + (1.0 - corner) + TINY)
    return anchor * share + (anchor - 1.0)


def polynomials(argument: Any, count: int) -> list[Any]:
    """T0, T1, T2, ... of an argument between -1 and 1."""
    found = [1.0 + 0.0 * argument, argument]
    while len(found) < count:
        half, rest = len(found) // 2, (len(found) + 1) // 2
        found.append(2.0 * (found[half] * found[rest]) - found[rest - half])
    return found[:count]


def total(coefficients: Sequence[Sequence[Any]], rows: Sequence[Any], columns: Sequence[Any]) -> Any:
    """The sum of c_ij rows_i columns_j."""
    found: Any = 0.0
    for k in range(len(coefficients[0])):
        inner: Any = 0.0
        for row, value in zip(coefficients, rows, strict=False):
            inner = inner + row[k] * value
        found = found + inner * columns[k]
    return found


@dataclass(frozen=True)
class Table:
    """One film: the coefficients of the sums for Q (``slant``) and P (``pull``), each in front of and behind both
    kinks; ``rim``, the D at which the rim falls slack; the range of flatness; V_low; e as ``anchor``, and the
    ``corner`` of `lowering`; the z where the film ends; the largest x^2; and the largest ``error`` of the force, over
    the force and 2 % of that without voltage."""

    slant: tuple[Array, Array, Array]
    pull: tuple[Array, Array, Array]
    rim: Array
    flatness: tuple[float, float]
    low: float
    anchor: float
    corner: float
    longest: float
    reach_squared: float
    error: float

    def numbers(self) -> dict[str, float]:
        """Flat, under the names that `names` lists."""
        values = [*np.concatenate([part.ravel() for part in (*self.slant, *self.pull)]), *self.rim]
        begin, end = self.flatness
        own = [
            begin,
            2.0 / (end - begin),
            self.low,
            self.anchor,
            self.corner,
            self.longest,
            self.reach_squared,
            self.error,
        ]
        return dict(zip(names(), map(float, [*values, *own]), strict=True))


SUMS = ("slant", "slant_rim", "slant_disc", "pull", "pull_rim", "pull_disc")
OWN = ("flatness_begin", "flatness_scale", "low_squared", "anchor", "corner", "longest", "reach_squared", "film_error")


def degrees(name: str) -> tuple[int, int]:
    """Of a sum."""
    return KINK if "_" in name else MAIN


def names() -> list[str]:
    """Of all numbers of a table."""
    sums = [
        f"{name}_{i}_{j}" for name in SUMS for i in range(degrees(name)[0] + 1) for j in range(degrees(name)[1] + 1)
    ]
    return [*sums, *(f"rim_{i}" for i in range(RIM + 1)), *OWN]


def coefficients(name: str, n: Any) -> list[list[Any]]:
    """Those of a sum, from the numbers of a film."""
    rows, columns = degrees(name)
    return [[n[f"{name}_{i}_{j}"] for j in range(columns + 1)] for i in range(rows + 1)]


# --- making one -------------------------------------------------------------------------------------------------------


class _Nodes(NamedTuple):
    states: States
    rim: Array
    """Stress of the hoop at the rim; its sign counts."""


def table(gel: Gel, ratio: float) -> Table:
    """The table of a film with equal pre-stretches.

    Raises `InputError` for a film whose pre-stretches differ, or of which too few states are found.
    """
    if gel.A != gel.B:
        raise InputError(
            "film = membrane: is computed for equal meridional and hoop pre-stretch only; give prestretch_mode = "
            "equibiaxial or a pre-stretch of 1, or film = wrinkling"
        )
    film = Film(gel, ratio)
    begin, end = _range(film)
    low = min(0.0, float(gel.crumpling(gel.A)) / gel.G)
    fitted = _nodes(film, begin, end, NODES, chebyshev.chebpts1)
    checked = _nodes(film, begin, end, CHECKS, lambda count: np.linspace(-1.0, 1.0, count + 2)[1:-1])
    flat = (begin / (1.0 + begin), end / (1.0 + end))
    rim = _rim(gel, fitted, flat, low)
    slant, pull = _fit(film, fitted, flat, low, rim)
    found = Table(slant, pull, rim, flat, low, _anchor(gel), _corner(gel), end, np.inf, 0.0)
    reach = float(_squared_height(found, gel, np.array([end]), np.zeros(1))[0])
    error = MARGIN * max(_error(film, found, nodes) for nodes in (fitted, checked))
    if not error <= LARGEST_ERROR:
        raise InputError(
            f"film = membrane: the force of this film (a/b = {ratio:g}) is known to {error:.0%} only; take film = "
            "wrinkling"
        )
    return Table(slant, pull, rim, flat, low, _anchor(gel), _corner(gel), end, reach, error)


def _range(film: Film) -> tuple[float, float]:
    """The z of the first and last innermost ring: the latter localises at the lowest V at which any ring does."""
    gel = film.gel
    begin = max(1.0, 1.0 / np.sqrt(gel.A))
    l1 = np.linspace(begin, MOST_STRETCHED, 3000)[1:]
    with np.errstate(all="ignore"):
        share = gel.strain(l1 * l1, gel.at(l1, np.ones_like(l1), np.zeros_like(l1)).width) / gel.strain_limit
        # V_s must exist at every ring
        slack = 2.0 * gel.A * l1 * l1 + (gel.A * l1 * l1) ** -2.0 - 3.0
    inside = (share < LIMIT_SHARE) & (slack < LIMIT_SHARE * gel.strain_limit)
    l1 = l1[: np.argmin(inside)] if not inside.all() else l1
    if l1.size < 2:
        raise InputError(
            "stretch_limit: is too close to the pre-stretch for the membrane; raise it, or film = wrinkling"
        )
    hump = gel.hump()
    end = _ends(film, l1)
    behind = gel.A * l1 * l1 > hump
    last = int(np.argmin(np.where(behind, end, np.inf))) if behind.any() else l1.size - 1
    return begin * begin - 1.0, float(l1[last]) ** 2 - 1.0


def _ends(film: Film, l1: Array) -> Array:
    """The V at which an innermost ring of these stretches falls slack or localises."""
    gel, shares = film.gel, np.linspace(0.0, 1.0, 100)
    flat = max(float(gel.crumpling(max(gel.A, 1.0))) / gel.G, 0.5)
    top = np.minimum(gel.crumpling(gel.A * l1 * l1) / gel.G, MOST_CHARGED * flat)
    one = np.ones_like(l1)
    with np.errstate(all="ignore"):
        grid = (l1[:, None] + 0.0 * shares, np.ones((l1.size, shares.size)), top[:, None] * shares)
        lost = gel.at(*grid).firmness <= 0.0
        first = np.maximum(np.argmax(lost, axis=1), 1)
        around = (top * shares[first - 1], top * shares[first])
        found = bisected(lambda V: -gel.at(l1, one, V).firmness, *around)
    return np.where(lost.any(axis=1), found, top)


def _nodes(film: Film, begin: float, end: float, count: tuple[int, int], points: Callable[[int], Array]) -> _Nodes:
    """States on a grid over flatness and V."""
    flat = (begin / (1.0 + begin), end / (1.0 + end))
    rows, columns = 0.5 * (points(count[0]) + 1.0), 0.5 * (points(count[1]) + 1.0)
    l1 = np.sqrt(1.0 / (1.0 - flat[0] - (flat[1] - flat[0]) * rows))
    V = np.maximum(_ends(film, l1), 0.0)[:, None] * columns
    states = film.grid(np.broadcast_to(l1[:, None], V.shape), V)
    good = states.miss < GOOD
    if np.mean(good) < 0.9:
        raise InputError(
            f"film = membrane: {np.sum(good)} of {good.size} states were found, too few for a film; take film = "
            "wrinkling"
        )
    with np.errstate(all="ignore"):
        last = film.shoot(states.l1, states.u, states.V, states.end)[-1]
        rim = film.gel.hoop(np.exp(last.y[LOG]), last.y[HOOP], states.V)
    return _Nodes(states, rim)


def _place(gel: Gel, states: States, low: float) -> Place:
    z = states.l1 * states.l1 - 1.0
    return place(z, states.V, gel.A, gel.B, gel.G, low, lambda strain: gel.law.compliance(strain, gel.numbers))


def _rim(gel: Gel, nodes: _Nodes, flat: tuple[float, float], low: float) -> Array:
    """The D at which the rim falls slack, from where the hoop stress changes its sign along rows; below all D where
    that happens nowhere."""
    at = _place(gel, nodes.states, low)
    p = 2.0 * (at.flatness - flat[0]) / (flat[1] - flat[0]) - 1.0
    stress, share, p = (np.asarray(values).reshape(NODES) for values in (nodes.rim, at.share, p))
    found = []
    for row in range(NODES[0]):
        falls = np.flatnonzero((stress[row, :-1] > 0.0) & (stress[row, 1:] <= 0.0))
        if falls.size:
            near = slice(max(0, falls[0] - 1), falls[0] + 3)
            line = np.polyfit(stress[row, near], share[row, near], min(3, stress[row, near].size - 1))
            found.append((p[row, 0], np.polyval(line, 0.0)))
    none = np.array([-1e3, *[0.0] * RIM])
    if not found:
        return none
    places, values = np.array(found).T
    fitted = chebyshev.chebfit(places, values, min(RIM, len(found) - 1))
    return np.concatenate([fitted, np.zeros(RIM + 1 - fitted.size)])


def _columns(at: Place, flat: tuple[float, float], rim: Array) -> Array:
    """The products of polynomials, in front of and behind both kinks."""
    p = 2.0 * (at.flatness - flat[0]) / (flat[1] - flat[0]) - 1.0
    u = 1.0 - 2.0 * at.share
    slack = np.maximum(chebyshev.chebval(p, rim) - at.share, 0.0) ** 2
    wide = np.maximum(-at.taut, 0.0) ** 2
    kinked = chebyshev.chebvander2d(p, u, KINK)
    return np.hstack([chebyshev.chebvander2d(p, u, MAIN), kinked * slack[:, None], kinked * wide[:, None]])


def _fit(
    film: Film, nodes: _Nodes, flat: tuple[float, float], low: float, rim: Array
) -> tuple[tuple[Array, Array, Array], tuple[Array, Array, Array]]:
    """Q and P by least squares of the relative errors of x^2 and the force."""
    states = nodes.states
    at, z = _place(film.gel, states, low), states.l1 * states.l1 - 1.0
    good = (states.miss < GOOD) & np.isfinite(states.x) & (states.x > 0.0)
    own = _columns(at, flat, rim)[good]
    height = (states.x * states.x / z)[good]
    anchor = _anchor(film.gel)
    share = lowering(at, anchor, _corner(film.gel))[good]
    # a weak force is as wrong as Q is, however small D
    weight = np.where(anchor > 0.0, np.maximum(share, WEAK), 1.0) / height
    slant = _least_squares(own * weight[:, None], weight * (anchor - height) / share)
    pull = _pull(film, states)[good]
    return _parts(slant), _parts(_least_squares(own / pull[:, None], np.ones(pull.size)))


def _anchor(gel: Gel) -> float:
    """1 where a film falls slack before it localises."""
    return 1.0 if gel.hump() > gel.A else 0.0


def _corner(gel: Gel) -> float:
    """1 where the flat film is in tension up to a V above which it falls slack."""
    return 1.0 if gel.A > 1.0 else 0.0


def _pull(film: Film, states: States) -> Array:
    """P: the force over x and the innermost ring's s1/q."""
    found: Array = 2.0 * film.disc / film.mounted * states.l1 / np.cosh(states.u) / states.x
    return found


def _least_squares(matrix: Array, right: Array) -> Array:
    found: Array = np.linalg.lstsq(matrix, right, rcond=SMALLEST)[0]
    return found


def _parts(found: Array) -> tuple[Array, Array, Array]:
    main, kink = (MAIN[0] + 1) * (MAIN[1] + 1), (KINK[0] + 1) * (KINK[1] + 1)
    first, second, third = np.split(found, [main, main + kink])
    shape = (KINK[0] + 1, KINK[1] + 1)
    return first.reshape(MAIN[0] + 1, MAIN[1] + 1), second.reshape(shape), third.reshape(shape)


def _values(found: Table, gel: Gel, z: Array, V: Array) -> tuple[Array, Array]:
    """x^2 and P at innermost rings."""
    at = place(z, V, gel.A, gel.B, gel.G, found.low, lambda strain: gel.law.compliance(strain, gel.numbers))
    own = _columns(at, found.flatness, found.rim)
    slant, pull = (np.concatenate([part.ravel() for part in parts]) for parts in (found.slant, found.pull))
    share = lowering(at, found.anchor, found.corner)
    return z * (found.anchor - share * (own @ slant)), own @ pull


def _squared_height(found: Table, gel: Gel, z: Array, V: Array) -> Array:
    return _values(found, gel, z, V)[0]


def _error(film: Film, found: Table, nodes: _Nodes) -> float:
    """Largest error of the force at the heights of states, over the force and 2 % of that without voltage; and of the
    height of states that are higher than any of the table."""
    states = nodes.states
    good = (states.miss < GOOD) & (states.x > 0.0) & (states.force > 0.0)
    own = states.where(good)
    z = (own.l1 * own.l1 - 1.0)[:, None] * AROUND
    l1, V = np.sqrt(1.0 + z), own.V[:, None] + 0.0 * z
    square, pull = (values.reshape(z.shape) for values in _values(found, film.gel, z.ravel(), V.ravel()))
    with np.errstate(all="ignore"):
        x = np.sqrt(np.maximum(square, 0.0))
        force = x * film.gel.at(l1, np.ones_like(l1), V).meridional / l1 * pull
    middle, wrong = AROUND.size // 2, []
    scale = own.force * (1.0 + FLOOR / np.maximum(_share(film, own), 1e-3))
    for k in range(len(z)):
        first, last = middle, middle
        while first > 0 and x[k, first - 1] < x[k, first]:
            first -= 1
        while last + 1 < AROUND.size and x[k, last + 1] > x[k, last]:
            last += 1
        if x[k, last] < own.x[k]:
            wrong.append(own.x[k] / x[k, last] - 1.0)
        else:
            there = np.interp(own.x[k], x[k, first : last + 1], force[k, first : last + 1])
            wrong.append(abs(there - own.force[k]) / scale[k])
    return float(np.max(wrong))


def _share(film: Film, states: States) -> Array:
    """About the share of the force without voltage that is left: the tension of the ring over that without voltage."""
    one = np.ones_like(states.l1)
    found: Array = film.gel.at(states.l1, one, states.V).meridional / film.gel.at(states.l1, one, 0.0 * one).meridional
    return found
