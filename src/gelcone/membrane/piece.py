"""One piece of a film's force, fitted to states of the film; see `gelcone.membrane.force` for the formulas."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np
from numpy.polynomial import chebyshev, polynomial

from gelcone.membrane import force
from gelcone.membrane.columns import LOWEST_GRID, Columns, columns, longest
from gelcone.membrane.elements import Elements
from gelcone.membrane.force import ALONE, CURVE, END, FLAT, KINK, LENGTH, MAIN, NEVER, SCALE
from gelcone.membrane.gel import Array, Gel
from gelcone.membrane.integrals import integrals
from gelcone.membrane.least_squares import chebyshev_to_powers, line, products, products_with_slope, solved
from gelcone.membrane.refusals import not_made, too_few
from gelcone.membrane.slack import slack_voltages

NODES, CHECKS = {"near": 16, "far": 26}, {"near": 9, "far": 11}
"""Number of heights that are fitted, and of others, at which the fit is checked."""
NEAR_USUAL, FALLING_NODES = (5, 6), 24
"""Degrees of the near piece of films whose hoop is not the stronger; number of heights of the others, which take the
full degrees."""
CHECK_STEPS, CHECK_FINEST = 9, 2e-3
"""Steps and resolution of the columns at which the fit is checked."""
FLOOR_FITTED, FLOOR, LOW = 0.05, 0.1, 0.1
"""Share of the force without voltage that is added to a force before its relative error is taken, in the fit and in the
stated error: of that at the same height or at ``LOW``, whichever is greater."""
GAIN_WEIGHT, GAIN_FLOOR, GAIN_SHARE = 0.04, 0.1, 0.8
"""Weight in the fit of the relative error of the slope of the force by V, on which strokes depend, next to that of the
force; the share of the largest slope at the same height that is added to a slope before; and the share of the last V of
a column up to which slopes take part: near its end they are inaccurate."""
BEFORE = 1e-4
"""Share of the voltage that is left when a column that falls slack ends."""
NOT_MET, NEVER_MET = 1.03, 9.0
"""The q at heights next to those at which a hoop falls slack; and where none does."""
FOLDED = 1e-4
"""Offset of s for films whose hoop is stretched more than their meridian. Their force over the height falls with ln s
towards the flat film; the force at s is taken from s plus this."""
USUAL, FALLING_SLACK, NEVER_SLACK = (1.0, -1.0), (FOLDED, 0.2), (0.03, -0.25)
"""c and e of films whose hoop is not the stronger; of the others at heights at which they fall slack, and where they do
so at none."""
FAR_WEIGHT = 1e-3
"""Weight of the pull-in curve behind its star."""
DIP, LOWEST_STATES = 0.5, 50
"""Share of the end of the lowest column below which the pull-in curve is wrong at the heights under that column, and
takes a lower degree; and the number of these heights."""
LAST, REGULAR = 0.998, 1.1
"""Shares of the voltage at which a film localises, up to which its force is checked, and fitted. The fit goes further,
since the force is regular where another ring than that at an edge localises."""
ABOVE = 1.5
"""Multiple of the lowest voltage at which a ring localises, up to which at least its length is computed."""
LEAST_RISE = 1e-3
"""Share of the largest slope of W that limits from below the slope over which relative errors are taken."""
NEXT = 1e-3
"""Distance of p below the cut at which the pull-in curve turns vertical."""
LOW_FLAT, BEFORE_END = 0.04, 0.98
"""Highest s of states from which the area of a flat film that never falls slack follows, and the share of the end of
their columns up to which they are taken."""


@dataclass
class FittedFilm:
    """A film while its ``numbers`` are fitted, piece by piece.

    ``errors`` are the largest of the force, ``gain_errors`` those of its reduction by voltages, one each for the fitted
    columns and for those that are checked.
    """

    elements: Elements
    numbers: dict[str, float]
    errors: list[float] = field(default_factory=list)
    gain_errors: list[float] = field(default_factory=list)

    @property
    def gel(self) -> Gel:
        """The gel of the elements."""
        return self.elements.gel

    @cached_property
    def slack_at(self) -> Callable[[Array], Array]:
        """The V at which the film loses its tension, a function of x."""
        return slack_voltages(self.gel, self.elements.ratio)

    def squared(self, x: Array) -> Array:
        """The s at which the force over the height is that of states of the height x."""
        return x * x - (FOLDED if self.gel.has_rims else 0.0)

    def height(self, s: Array) -> Array:
        """The height of the states whose force over the height is that at s."""
        height: Array = np.sqrt(np.maximum(s, 0.0) + (FOLDED if self.gel.has_rims else 0.0))
        return height

    @cached_property
    def low(self) -> float:
        """The force without voltage at a low height."""
        elements = self.elements
        return float(np.nan_to_num(elements.measures(elements.unloaded(LOW * np.geomspace(1.0, 4.0, 5))).force[0]))

    def floor(self, found: Columns, which: Array) -> Array:
        """The force of which a share is added to the forces of states before their relative error is taken."""
        largest: Array = np.maximum(found.first[found.column[which]], self.low)
        return largest


def no_piece(film: FittedFilm, piece: str) -> None:
    """Sets the numbers of a piece that the film does not have."""
    for what, shape in force.shapes(piece).items():
        _set(film, piece, what, np.zeros(shape))
    film.numbers |= {f"{piece}_start": 1.0, f"{piece}_shift": 1.0, f"{piece}_exponent": -1.0}
    if piece == "far":
        film.numbers |= {"star_place": 0.0, "end_begin": -1.0, "end_scale": 1.0, "end_offset": 0.0}
        film.numbers |= dict.fromkeys(force.END_NAMES, 0.0)


def fit_piece(film: FittedFilm, piece: str, begin: float, end: float) -> None:
    """Fits the piece between two s, and appends its errors.

    Raises `InputError` where too few states are found, or where the film localises at no voltage.
    """
    n = film.numbers
    variable = USUAL
    if film.gel.has_rims and (piece == "near" or n["cut_squared"] < 0.0):
        variable = FALLING_SLACK if piece == "near" else NEVER_SLACK
    n |= zip((f"{piece}_shift", f"{piece}_exponent"), variable, strict=True)
    low, high = (float(force.place(piece, s, n)[0]) for s in (begin, end))
    n[f"{piece}_scale"] = 2.0 / (high - low)
    n[f"{piece}_offset"] = -1.0 - 2.0 * low / (high - low)
    nodes = FALLING_NODES if piece == "near" and film.gel.has_rims else NODES[piece]
    u = chebyshev.chebpts1(nodes)
    other = np.linspace(-1.0, 1.0, CHECKS[piece] + 2)[1:-1]

    def height(at: Array) -> Array:
        p = low + (high - low) * 0.5 * (at + 1.0)
        return film.height((-p) ** (1.0 / variable[1]) - variable[0])

    u, other = (at[_pulls(film.elements, height(at))] for at in (u, other))
    if u.size < nodes // 2 or not other.size:
        raise too_few(film.gel)
    top, first = _tops(film, piece, height(u))
    fitted = columns(film.elements, height(u), first, top)
    _scale(film, piece, u, fitted)
    top, first = _tops(film, piece, height(other))
    if piece == "far":
        top = np.minimum(top, LAST * force.pull_in(film.squared(height(other)), n))
    checked = columns(film.elements, height(other), first, top, CHECK_STEPS, CHECK_FINEST)
    whole = ~_localise(film.gel, fitted), ~_localise(film.gel, checked)
    inside = np.flatnonzero(whole[0] & _below(film, piece, fitted, REGULAR))
    _curves(film, piece, u, fitted)
    _force(film, piece, fitted, u, inside)
    _lengths(film, piece, fitted, u, inside)
    if piece == "near" or film.numbers["cut_squared"] < 0.0:
        _flat_area(film, piece, fitted)
    for piece_columns, is_whole in zip((fitted, checked), whole, strict=True):
        below = np.flatnonzero(is_whole & _below(film, piece, piece_columns))
        film.errors.append(_error(film, piece, piece_columns, below))
        film.gain_errors.append(_gain_error(film, piece, piece_columns, below))


def _pulls(film: Elements, x: Array) -> Array:
    """Mask of the heights at which a state without voltage is found that pulls."""
    with np.errstate(invalid="ignore"):
        is_pulling: Array = film.measures(film.unloaded(x)).force > 0.0
    return is_pulling


def _tops(film: FittedFilm, piece: str, x: Array) -> tuple[Array, Array]:
    """The V up to which columns go, and the V that they are expected to reach."""
    gel = film.gel
    if piece == "near":
        slack = film.slack_at(x)
        return slack * (1.0 - BEFORE), slack
    n = film.numbers
    lowest = n["lowest_pull_in"]
    limit = n["slack_limit"] if n["slack_limit"] < NEVER else 0.0
    highest = max(limit, n["flat_voltage"], 1.0, ABOVE * lowest)
    states = film.elements.unloaded(x)
    column_lengths = np.sqrt(film.elements.measures(states).disc)
    V = np.geomspace(lowest * 1.0001, highest, 60)
    length = longest(gel, V)
    if not np.isfinite(length).any():
        length = longest(gel, V, LOWEST_GRID)
    is_known = np.isfinite(length)
    if not is_known.any():
        raise not_made(gel, "no voltage is found at which this film localises", "wrinkling")
    expected = np.interp(-column_lengths, -length[is_known], V[is_known], left=lowest, right=V[is_known][-1])
    return 1.3 * expected, expected


def _scale(film: FittedFilm, piece: str, u: Array, fitted: Columns) -> None:
    """Fits W, and for the far piece the pull-in curve."""
    n = film.numbers
    if piece == "near":
        start = float(film.slack_at(film.height(np.array([n["begin_squared"]])))[0])
        rise = (film.slack_at(fitted.heights) - start) / (u + 1.0)
        n["near_start"] = start
        _set(film, piece, "rise", line(u, rise, SCALE[piece], 1.0 / np.maximum(rise, LEAST_RISE * rise.max())))
        return
    inverse = 1.0 / _pull_in(film, u, fitted)
    n["far_start"] = float(inverse[np.argmin(u)])
    _set(film, piece, "rise", line(u, (inverse - n["far_start"]) / (u + 1.0), SCALE[piece], (u + 1.0) / inverse))


def _pull_in(film: FittedFilm, u: Array, fitted: Columns) -> Array:
    """Returns the V at which each column of the far piece ends, and fits the pull-in curve to them."""
    n, lowest = film.numbers, film.numbers["lowest_pull_in"]
    limit = fitted.end.copy()
    # where a film raised in voltage localises at the lowest V of all rings, it is another ring than the innermost
    length = longest(film.gel, np.array([lowest * (1.0 + 1e-6)]), LOWEST_GRID)[0]
    ring_lengths = np.array([np.interp(lowest, *fitted.along(k, np.sqrt(fitted.measures.disc))) for k in range(u.size)])
    place = force.place("far", film.squared(fitted.heights), n)[0]
    order = np.argsort(ring_lengths)
    star = float(np.interp(length, ring_lengths[order], place[order]))
    star = star if ring_lengths.max() > length else float(place.max()) + 1.0
    cut = n["cut_squared"]
    begin = float(force.place("far", max(cut, 0.0), n)[0]) - NEXT
    t = np.sqrt(place - begin)
    scale = 2.0 / (t.max() - t.min())
    n |= {"star_place": star, "end_begin": begin, "end_scale": scale, "end_offset": -1.0 - scale * t.min()}
    before = place < star
    limit = np.where(before, np.maximum(limit, lowest), lowest)
    degree = min(END, int(before.sum()) - 2)
    values = np.zeros(1)
    if degree >= 0:
        below = star - place[before]
        away = 0.5 * (below + np.hypot(below, force.ROUNDED))
        share, weight = np.zeros(place.size), np.full(place.size, FAR_WEIGHT)
        share[before], weight[before] = (limit[before] - lowest) / away, away / limit[before]
        share[~before] = share[before][np.argmin(below)]  # E is not used behind the star, but must not grow there
        values = line(scale * t + n["end_offset"], share, degree, weight)
    _set_end(n, values)
    under = np.linspace(float(film.height(np.array([cut]))[0]), fitted.heights.min(), LOWEST_STATES)
    while degree > 0 and force.pull_in(film.squared(under), n).min() < DIP * limit[np.argmin(fitted.heights)]:
        degree -= 1
        _set_end(n, line(scale * t + n["end_offset"], share, degree, weight))
    return limit


def _set_end(numbers: dict[str, float], values: Array) -> None:
    """Sets the polynomial E of the pull-in curve, by rising powers."""
    numbers |= dict(zip(force.END_NAMES, np.pad(values, (0, END + 1 - values.size)).tolist(), strict=True))


def _localise(gel: Gel, found: Columns) -> Array:
    """Mask of the states in which the ring at an edge has localised."""
    with np.errstate(invalid="ignore"):
        localises: Array = np.sqrt(found.measures.edge) > longest(gel, found.V)
    return localises


def _below(film: FittedFilm, piece: str, found: Columns, beyond: float = 1.0) -> Array:
    """Mask of the states below the V at which the film falls slack, or below ``beyond`` times that of its pull-in."""
    x = found.heights
    limit = film.slack_at(x) if piece == "near" else beyond * force.pull_in(film.squared(x), film.numbers)
    below: Array = limit[found.column] >= found.V
    return below


def _curves(film: FittedFilm, piece: str, u: Array, fitted: Columns) -> None:
    """Fits the q at which the first and the last hoop fall slack."""
    W = _scale_at(film, piece, u)
    for kink, hoop in (("rim_at", fitted.measures.least_hoop), ("whole_at", fitted.measures.largest_hoop)):
        q = force.share(piece, fitted.falls(hoop), W)[0]
        met = q < NOT_MET
        _set(film, piece, kink, np.array([NEVER_MET]) if met.sum() < 2 else _curve(u, q, met))


def _curve(u: Array, q: Array, met: Array) -> Array:
    """The polynomial of u through the q that are ``met``, which stays above 1 at the other u."""
    is_fitted = met | np.roll(met, 1) | np.roll(met, -1)
    while True:
        degree = min(CURVE, int(is_fitted.sum()) - 1)
        values = line(u[is_fitted], np.where(met, q, NOT_MET)[is_fitted], degree, np.ones(int(is_fitted.sum())))
        wrong = ~is_fitted & (polynomial.polyval(u, values) < 1.0)
        if not wrong.any():
            return values
        is_fitted |= wrong


def _scale_at(film: FittedFilm, piece: str, u: Array) -> Array:
    """W at u."""
    rise = [film.numbers[name] for name in force.names(piece, "rise")]
    scale: Array = film.numbers[f"{piece}_start"] + (u + 1.0) * polynomial.polyval(u, rise)
    return scale


def _force(film: FittedFilm, piece: str, fitted: Columns, u: Array, inside: Array) -> None:
    """Fits P, P1 and P2 by least squares of the relative errors of the force and of its slope by V."""
    at, x, q, base = _places(film, piece, fitted, u, inside)
    q_by_v = force.share(piece, fitted.V[inside], _scale_at(film, piece, at))[1]
    main, alone = MAIN[piece], ALONE[piece]
    if piece == "near" and not film.gel.has_rims:
        main, alone = NEAR_USUAL, NEAR_USUAL[0]
    parts = [products_with_slope(at, q, main)]
    if alone > main[0]:
        only_u = chebyshev.chebvander(at, alone)[:, main[0] + 1 :]
        parts.append((only_u, np.zeros_like(only_u)))
    for kink in ("rim_at", "whole_at"):
        curve = [film.numbers[name] for name in force.names(piece, kink)]
        distance = np.maximum(q - polynomial.polyval(at, curve), 0.0)[:, None]
        value, by_q = products_with_slope(at, q, KINK)
        parts.append((value * distance**2, by_q * distance**2 + 2.0 * value * distance))
    sizes = np.cumsum([value.shape[1] for value, _ in parts])[:-1]
    total, by_q = (np.hstack(each) for each in zip(*parts, strict=True))
    slope = base[:, None] * by_q * q_by_v[:, None] - (total if piece == "near" else 0.0)
    forces, (by_v, size) = fitted.measures.force[inside], _slopes(fitted, inside)
    is_known = np.isfinite(by_v)
    matrix = np.vstack([total * (base * x)[:, None], (slope * x[:, None])[is_known]])
    weights = 1.0 / (forces + FLOOR_FITTED * film.floor(fitted, inside)), GAIN_WEIGHT / size[is_known]
    coefficients = solved(matrix, np.concatenate([forces, by_v[is_known]]), np.concatenate(weights))
    values = np.split(coefficients, sizes)
    rows = chebyshev_to_powers(values[0].reshape(main[0] + 1, main[1] + 1))
    if alone > main[0]:
        rows = np.pad(rows, ((0, alone - main[0]), (0, 0)))
        rows[:, 0] += chebyshev.cheb2poly(np.concatenate([np.zeros(main[0] + 1), values[1]]))
    _set(film, piece, "main", rows)
    for kink, part in zip(("rim", "whole"), values[-2:], strict=True):
        _set(film, piece, kink, chebyshev_to_powers(part.reshape(KINK[0] + 1, KINK[1] + 1)))


def _slopes(found: Columns, which: Array) -> tuple[Array, Array]:
    """The slope of the force by V at states, from a spline through their column, and the slope over which its error is
    taken; NaN in columns of fewer than four states."""
    from scipy.interpolate import CubicSpline  # importing it takes as long as starting gelcone

    slope, scale = np.full((2, found.V.size), np.nan)
    for k in range(found.heights.size):
        indices = np.flatnonzero(found.column == k)
        indices = indices[np.argsort(found.V[indices])]
        if indices.size >= 4:
            through = CubicSpline(found.V[indices], found.measures.force[indices])
            indices = indices[found.V[indices] <= GAIN_SHARE * found.V[indices[-1]]]
            slope[indices] = through(found.V[indices], 1)
            scale[indices] = np.abs(slope[indices]) + GAIN_FLOOR * np.max(np.abs(slope[indices]))
    return slope[which], scale[which]


def _lengths(film: FittedFilm, piece: str, fitted: Columns, u: Array, inside: Array) -> None:
    """Fits the squared length of the innermost ring and the largest squared field over V."""
    at, _, q, _ = _places(film, piece, fitted, u, inside)
    for what, values in (("disc", fitted.measures.disc), ("field", fitted.measures.field**2)):
        inside_values = values[inside]
        coefficients = solved(products(at, q, LENGTH), inside_values, 1.0 / inside_values)
        _set(film, piece, what, chebyshev_to_powers(coefficients.reshape(LENGTH[0] + 1, LENGTH[1] + 1)))


def _flat_area(film: FittedFilm, piece: str, fitted: Columns) -> None:
    """Fits the area of the flat film less 1, by powers of V; 0 where no ring moves.

    Data are the states at the lowest height; with a strong hoop also those that fall slack, whose area is that of the
    flat film, or in a film that never does the low states, from which the flat film follows by the fitted force.
    """
    values = np.zeros(FLAT + 1)
    if film.gel.A != film.gel.B:
        V, area = fitted.along(int(np.argmin(fitted.heights)), fitted.measures.area)
        weight = np.ones(V.size)
        if film.gel.has_rims and piece == "near":
            ends = [fitted.along(k, fitted.measures.area) for k in range(fitted.heights.size)]
            near = [(voltages[-1], last[-1]) for voltages, last in ends if voltages.size and voltages[-1] > V[-1]]
            V, area = np.append(V, [level for level, _ in near]), np.append(area, [last_area for _, last_area in near])
            weight = np.ones(V.size)
        elif film.gel.has_rims:
            s = np.square(fitted.heights)[fitted.column]
            low = (s <= LOW_FLAT) & (BEFORE_END * fitted.end[fitted.column] >= fitted.V)
            s, V = s[low], fitted.V[low]
            n, weight = film.numbers, 1.0 / (s + LOW_FLAT)
            gained = integrals(partial(force.pull, piece), np.zeros_like(s), s, V, n, n[f"{piece}_shift"])[1]
            area = fitted.measures.area[low] + gained
        degree = min(FLAT, V.size - 1)
        values[: degree + 1] = polynomial.polyfit(V, area - 1.0, degree, w=weight)
    film.numbers |= {f"flat_area_{i}": float(value) for i, value in enumerate(values)}


def _places(film: FittedFilm, piece: str, fitted: Columns, u: Array, inside: Array) -> tuple[Array, ...]:
    """u, x, q and the base of states."""
    column, V = fitted.column[inside], fitted.V[inside]
    W = _scale_at(film, piece, u[column])
    return u[column], fitted.heights[column], force.share(piece, V, W)[0], W - V if piece == "near" else np.ones_like(V)


def _error(film: FittedFilm, piece: str, found: Columns, inside: Array) -> float:
    """Largest error of the force of states, over the force and a tenth of that without voltage."""
    column, V = found.column[inside], found.V[inside]
    x, forces = found.heights[column], found.measures.force[inside]
    k = force.pull(piece, film.squared(x), V, film.numbers).k
    return float(np.max(np.abs(x * k - forces) / (forces + FLOOR * film.floor(found, inside))))


def _gain_error(film: FittedFilm, piece: str, found: Columns, inside: Array) -> float:
    """Largest relative error of the reduction of the force by voltages, in states that are not low."""
    inside = inside[(found.V[inside] > 0.0) & (found.heights[found.column[inside]] >= LOW)]
    column, V = found.column[inside], found.V[inside]
    x = found.heights[column]
    taken = found.first[column] - found.measures.force[inside]
    without, under_voltage = (force.pull(piece, film.squared(x), at, film.numbers).k for at in (np.zeros_like(V), V))
    return float(np.max(np.abs(x * (without - under_voltage) / taken - 1.0), initial=0.0))


def _set(film: FittedFilm, piece: str, what: str, values: Array) -> None:
    """Sets numbers of a piece; those of higher degrees than ``values`` to zero."""
    name = force.names(piece, what)
    padded = np.zeros(name.shape)
    padded[tuple(map(slice, np.shape(values)))] = values
    film.numbers |= {str(key): float(value) for key, value in zip(name.ravel(), np.ravel(padded), strict=True)}
