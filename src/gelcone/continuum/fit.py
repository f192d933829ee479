"""The fit of the continuum film: the force of the wrinkling membrane, for a geometry, law and pre-stretch.

The membrane is raised step by step, and at each height charged until it falls slack or pulls in. The least squares are
weighted anew until the largest error is small (Lawson's algorithm). The error is measured at these states and at
others between them, on a finer mesh, which take no part in the least squares.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt
from numpy.polynomial.chebyshev import chebvander

from gelcone import disk_cache, permission
from gelcone.continuum.charged import Charged, charged, flat_squared, follow, slack_limit, slack_squared
from gelcone.continuum.membrane import highest_span, limit_shares, raised_film, stress_state
from gelcone.continuum.mesh import SLACK_STIFFNESS, Film, check_radius_ratio, import_skfem, mesh_film
from gelcone.continuum.path import Ending, Point, reach
from gelcone.errors import InputError
from gelcone.files import write_whole
from gelcone.physics.component import to_record
from gelcone.physics.film.continuum import FADE, ContinuumFilm
from gelcone.physics.film.fitted import FittedFilm, Polynomial
from gelcone.physics.film.pull_in import DEFAULT_RADIUS_RATIO
from gelcone.physics.film.stored import film_from_json, read_film
from gelcone.physics.film.wrinkling import NEVER
from gelcone.physics.laws import LAWS
from gelcone.physics.model import ConeModel
from gelcone.physics.records import FILMS
from gelcone.quantity import Array

ELEMENTS, LOOSE_ELEMENTS = 32, 80
"""More where the film hangs loose in a narrow fold beside the disc."""
FARTHEST = 4.0
"""Largest displacement that is fitted, in b - a, where the stretch limit leaves room for more."""
LIMIT_SHARE = 0.9
"""Of the stretch limit, next to the disc, up to which displacements are fitted."""
STEPS_UP, TOP_TOLERANCE = 24, 1e-4
"""Heights on the way to the largest that is fitted, and how exactly that is found."""
LOW, LOOSE_LOW = 0.02, 0.01
"""Lowest height that is fitted."""
LOOSE, ROUNDING, SOFT = 0.05, 0.02, 0.1
"""Those of a film whose hoop is stretched more than the meridian, which hangs loose beside the disc: the height below
which its mesh is too coarse for the error of a fit, the rounding of the corner of its force at x = 0, and the weight of
the slack film beyond the states."""
HEIGHTS, LOOSE_HEIGHTS = 56, 60
"""How many are fitted, denser near the lowest and the largest."""
CHECKS = 18
"""Heights between those fitted, at which the error is that of states that take no part in the fit, and that of the
mesh: there it has twice the elements."""
WEAKEST = 5e3 * SLACK_STIFFNESS
"""Least force over height, of a film that the net of slack rings does not spoil near slackness."""
STEPS, CHECK_STEPS = 15, 22
"""Of the voltage squared, up to pull-in; at the heights between."""
CHECK_SHARE = 0.4
"""Share of the work that these take."""
MARGIN, LOOSE_MARGIN = 1.5, 2.2
"""The error that a film states over the largest that was found: others lie between. More where it hangs loose."""
SEARCHED = 4.0
"""V over 1/G up to which the end is sought of a film that does not pull in when slack."""
FLOOR = 0.02
"""Share of the force without voltage that is added to a force before its relative error is taken."""
SIZES, GOOD = ((8,) * 8, (10,) * 10, (14,) * 10, (20,) * 12, (30,) * 12), 0.01
"""Coefficients of each sum of the stiffness: more where the error would not be good with few; ``LOCAL``, of the stretch
beside the disc; ``ENDS``, of pull-in; ``SLACK_ENDS``, of H."""
LOCAL = (8, 7, 6, 5)
ENDS, SLACK_ENDS = 13, 17
VARIABLES = (0.3, 1.0, 4.0)
WALLS = (1.1, 1.4, 4.0)
"""Places of the wall over the largest s."""
SMALLEST = 1e-6
"""Singular values below this share of the largest are left out: the coefficients stay small."""
ROUNDS = 30
"""Of Lawson's algorithm."""
FINALISTS = 3
"""Pairs of the variable and the wall, best by least squares, with which that is tried."""
SLACK_ABOVE, LEVEL_ABOVE = 1.06, 1.1
"""H over the V at which the film falls slack, and over the highest of these where it pulls in before."""
NEAR_END = 0.98
"""Share of the highest V from which on the slope is taken with which a force ends."""
BEYOND, LEVEL = 1e-3, 0.1
"""Weight of the slack film, and of H where the film pulls in before."""
LOWER = (0.1, 0.01)
"""Heights squared over the lowest, at which a film without tension while it is flat obeys the same law k = s f(V/s)."""
SCALED = 0.1
"""Weight of what was scaled to lower heights."""
SLACK_MARGIN = 0.995
"""Share of the V at which the film falls slack up to which it is followed."""
NEARLY_SLACK, CHECK_NEARLY_SLACK = (0.95, 0.97, 0.985), (0.94, 0.96, 0.978, 0.99)
"""Shares of that V at which it is looked at besides: there the force bends towards zero."""
NARROWINGS = 4
"""Heights between one at which the film falls slack and one at which it pulls in."""
_ABOVE = Path(__file__).parents[1]
SOURCES = (
    _ABOVE / "continuum",
    _ABOVE / "physics" / "film",
    _ABOVE / "paper" / "unwrinkled.py",
    _ABOVE / "physics" / "laws.py",
    _ABOVE / "physics" / "model.py",
)
"""Sources that a fit depends on, besides that of its law."""
FITS = "films"
"""Kind of the entries of the cache."""
Fitted = TypeVar("Fitted", bound=FittedFilm)


class _Column(NamedTuple):
    """What was found at one height."""

    s: float
    charged: Charged
    start: float
    """k without voltage."""
    disc: Array
    """(Deformed over mounted length along the meridian)^2 - 1 beside the disc, of its points."""
    check: bool
    """Whether it takes no part in the least squares."""

    @property
    def squared(self) -> Array:
        return np.array([point.squared for point in self.charged.points])

    @property
    def stiffness(self) -> Array:
        return np.array([point.force for point in self.charged.points]) / np.sqrt(self.s)

    @property
    def weight(self) -> Array:
        """Of the errors of the stiffness."""
        return 1.0 / (self.stiffness + FLOOR * self.start)

    @property
    def slackens(self) -> bool:
        return self.charged.ending == Ending.SLACK


def fit_film(
    model: ConeModel,
    radius_ratio: float = DEFAULT_RADIUS_RATIO,
    *,
    progress: Callable[[float], None] | None = None,
) -> ContinuumFilm:
    """The continuum film of a model as a smooth force, with its error.

    The film wrinkles rather than bear compression. Displacements are fitted up to 90 % of the stretch limit next to the
    disc or 4 (b - a), voltages up to pull-in.

    Parameters
    ----------
    model : one actuator; its law and pre-stretches alone play a part.
    radius_ratio : a/b, between 0 and 1. Default 0.2.
    progress : called with the share of the work done since its last call.

    Returns
    -------
    A `ContinuumFilm`, for the ``film`` of the model.

    Raises
    ------
    InputError : for an ensemble, a disc larger than the film, or a film that is in tension at no displacement.
    MissingDependency : without scikit-fem.
    """
    if model.shape:
        raise InputError(f"a model of the shape {model.shape}: one film is fitted at a time; take its members")
    ratio = check_radius_ratio(radius_ratio)
    lm, lh = model.stretches
    elements = LOOSE_ELEMENTS if lm < lh else ELEMENTS
    film = mesh_film(model.replace(spring_stiffness=0.0), ratio, elements, relaxed=True)
    finer = mesh_film(film.model, ratio, 2 * elements, relaxed=True)
    columns = _columns(film, finer, progress or (lambda share: None))
    found = _fitted(film, [c for c in columns if not c.check], [c for c in columns if c.check])
    margin = LOOSE_MARGIN if hangs_loose(film) else MARGIN
    errors = {name: margin * error for name, error in _errors(found, columns, _lowest(film)).items()}
    return dataclasses.replace(found, errors=tuple(errors.items()))


def find_film(
    choice: str,
    model: ConeModel,
    radius_ratio: float = DEFAULT_RADIUS_RATIO,
    *,
    starting: Callable[[], None] = lambda: None,
) -> FittedFilm | str:
    """The film for a name: one of `FILMS` (its name), ``continuum`` (fitted on first use, then cached) or a file.

    Films are cached in the folder ``gelcone/films`` of the user's cache, under a name that says what they were fitted
    for. ``starting`` is called before a fit, which takes seconds. Raises `InputError` for a file that cannot be read,
    or a sweep over what a film is fitted for.
    """
    if choice in FILMS:
        return choice
    if choice != "continuum":
        permission.check("film", choice)
        return read_film(choice)
    return cached_film(fit_film, model, radius_ratio, starting=starting)


def cached_film(
    fit: Callable[[ConeModel, float], Fitted],
    model: ConeModel,
    radius_ratio: float,
    *,
    starting: Callable[[], None] = lambda: None,
) -> Fitted:
    """The film that ``fit`` gives, from the disk cache if it is there; otherwise as for `find_film`."""
    alone, parts = _film_alone(model)

    def make() -> bytes:
        import_skfem()
        starting()
        return fit(alone, radius_ratio).to_json().encode()

    own = {"fit": fit.__name__, "radius_ratio": float(radius_ratio)}
    return film_from_json(disk_cache.made(FITS, own | parts, make, (*SOURCES, type(alone.law))).decode())  # type: ignore[return-value]


def _film_alone(model: ConeModel) -> tuple[ConeModel, dict[str, Any]]:
    """The film of a model without a spring, and all numbers that it depends on by name.

    Raises `InputError` for a sweep over one of them.
    """
    law = model.gel_law()
    own = {name: model.values[name] for name in law.parameters}
    fixed = {"prestretch": model.stretches, "law": list(own.values())}
    for name, values in fixed.items():
        if any(np.ndim(value) for value in values):
            raise InputError(f"{name}: a continuum film is fitted for one {name}; sweep it with --film taut")
    lm, lh = model.stretches
    parameters = own | {"meridional_prestretch": lm, "hoop_prestretch": lh}
    alone = ConeModel(law=law, spring_stiffness=0.0, **parameters)
    return alone, {"law": to_record(law, LAWS)} | {name: float(value) for name, value in parameters.items()}


def write_film(film: FittedFilm, path: str | Path, *, force: bool = False) -> None:
    """Writes a film as JSON for `gelcone.read_film`; an existing file is kept unless ``force``."""
    write_whole(Path(path), lambda to: _write_text(to, film.to_json()), force=force)


def _write_text(path: Path, text: str) -> None:
    path.write_text(text + "\n", encoding="utf-8")


def hangs_loose(film: Film) -> bool:
    """Whether the hoop is stretched more than the meridian: the film can lose its tension along the meridian alone."""
    return bool(film.coefficients["A"] < film.coefficients["B"])


def _lowest(film: Film) -> float:
    """The s from which on the fit is judged."""
    return LOOSE**2 * (1.0 - 1e-9) if hangs_loose(film) else 0.0


# --- the states ------------------------------------------------------------------------------------------------------


def _heights(film: Film) -> tuple[list[float], list[float]]:
    """The heights that are fitted, and those between them at which the error is measured."""
    top = _farthest(film)
    middle, loose = min(1.0, 0.5 * top), hangs_loose(film)
    power = 1.0 if loose else 2.0
    low, high = ((x / middle) ** power / (1.0 + (x / middle) ** power) for x in (LOOSE_LOW if loose else LOW, top))
    count = LOOSE_HEIGHTS if loose else HEIGHTS
    places = low + 0.5 * (high - low) * (1.0 - np.cos(np.linspace(0.0, np.pi, count)))
    gaps = np.unique(np.linspace(0, count - 2, CHECKS).astype(int))
    between = 0.5 * (places[gaps] + places[gaps + 1])
    fitted, checks = (middle * (t / (1.0 - t)) ** (1.0 / power) for t in (places, between))
    return fitted.tolist(), checks.tolist()


def _farthest(film: Film) -> float:
    """The largest height that is fitted."""
    heights = np.linspace(0.0, min(highest_span(film), FARTHEST), STEPS_UP + 1)[1:]
    below, low, high = None, 0.0, float(heights[-1])
    for height, point in raised_film(film, heights.tolist()).items():
        if limit_shares(film, point.position).max() > LIMIT_SHARE:
            high = height
            break
        below, low = point, height
    if below is None:
        raise InputError("the film is in tension at no displacement; raise the pre-stretch or the stretch limit")
    while high - low > TOP_TOLERANCE * high:
        middle = reach(film, below, "height", 0.5 * (low + high))[0]
        if middle is None or limit_shares(film, middle.position).max() > LIMIT_SHARE:
            high = 0.5 * (low + high)
        else:
            below, low = middle, middle.height
    return low


def _columns(film: Film, finer: Film, progress: Callable[[float], None]) -> list[_Column]:
    """The film charged at each height. Higher up it has pulled in on the way there at no more than the lowest V at
    which it pulls in below."""
    heights, checks = _heights(film)
    raised = _raised(film, heights)
    columns, lowest, guess = list[_Column](), _highest_fitted(film), 0.0
    for start in raised.values():
        if start.force < WEAKEST * start.height:
            continue
        column = _column(film, start, lowest, guess, check=False)
        if column.charged.ending == Ending.PULLED_IN:
            if not columns or columns[-1].slackens:
                columns += _first_pull_in(film, columns[-1] if columns else None, start, lowest)
            lowest = min(lowest, column.charged.end)
        guess = column.charged.end
        columns.append(column)
        progress((1.0 - CHECK_SHARE) / len(raised))
    if not columns:
        raise InputError("the film is in tension at no displacement; raise the pre-stretch or the stretch limit")
    for height, start in _raised(finer, checks).items():
        below = [c.charged for c in columns if c.s < height * height]
        if below:
            pulled_in = [found.end for found in below if found.ending == Ending.PULLED_IN]
            lowest = min(pulled_in, default=_highest_fitted(film))
            columns.append(_column(finer, start, lowest, below[-1].end, check=True))
        progress(CHECK_SHARE / len(checks))
    return sorted(columns, key=lambda column: column.s)


def _raised(film: Film, heights: list[float]) -> dict[float, Point]:
    """The film without voltage at heights from the lowest up; those at which it is found by lowering the disc alone,
    too."""
    found = raised_film(film, heights)
    point = found[min(found)] if found else None
    for height in sorted((h for h in heights if found and h < min(found)), reverse=True):
        point = reach(film, point, "height", height)[0] if point is not None else None
        if point is not None:
            found = {height: point} | found
    return found


def _highest_fitted(film: Film) -> float:
    """The V up to which a film in tension is fitted, where it does not pull in below."""
    limit = slack_limit(film.model)
    return limit if limit < NEVER else SEARCHED / float(film.coefficients["G"])


def _column(film: Film, start: Point, highest: float, guess: float, *, check: bool) -> _Column:
    """At one height, up to V = ``highest``; ``guess``, an end that is near.

    With a hoop that is stretched no more than the meridian all rings fall slack at once, where the cone does.
    """
    slack = slack_squared(film, start.height)
    near = min(v for v in (highest, slack, 1.1 * guess) if v > 0.0)
    known = not hangs_loose(film)
    step = near / (CHECK_STEPS if check else STEPS)
    found = charged(film, start, min(highest, SLACK_MARGIN * slack) if known else highest, step)
    if known and found.ending == Ending.CONVERGED and SLACK_MARGIN * slack < highest:
        shares = CHECK_NEARLY_SLACK if check else NEARLY_SLACK
        more = _between(film, found.points, [share * slack for share in shares])
        found = found._replace(points=more, end=slack, ending=Ending.SLACK)
    elif known and found.ending == Ending.SLACK:
        found = found._replace(ending=Ending.PULLED_IN)
    c = float(film.coefficients["A"])
    disc = [stress_state(film, point.position, point.squared)[0][0] ** 2 / c - 1.0 for point in found.points]
    return _Column(start.height**2, found, start.force / start.height, np.array(disc), check)


def _between(film: Film, points: list[Point], levels: list[float]) -> list[Point]:
    """The states, with those at more V between them."""
    found = list(points)
    for level in levels:
        below = max((point for point in found if point.squared < level), key=lambda point: point.squared)
        point = follow(film, below, level)
        if point is not None:
            found.append(point)
    return sorted(found, key=lambda point: point.squared)


def _first_pull_in(film: Film, below: _Column | None, above: Point, highest: float) -> list[_Column]:
    """Columns between the last height at which the film falls slack and the first at which it pulls in."""
    if below is None:
        return []
    found, low, high = list[_Column](), below.charged.points[0], above
    for _ in range(NARROWINGS):
        start = reach(film, low, "height", 0.5 * (low.height + high.height))[0]
        if start is None:
            break
        found.append(_column(film, start, highest, 0.0, check=False))
        low, high = (start, high) if found[-1].slackens else (low, start)
    return found


# --- the fit ---------------------------------------------------------------------------------------------------------


class _Rows(NamedTuple):
    """What is fitted: k at s and V, the weights of its errors, and where its largest error counts: where the film is
    neither slack nor too low."""

    s: Array
    squared: Array
    stiffness: Array
    weight: Array
    counts: npt.NDArray[np.bool_]


class _Ends(NamedTuple):
    """The s and V at which the film pulls in."""

    s: Array
    squared: Array


class _Surface(NamedTuple):
    """A fit of k: its largest error, its shape, the polynomials and the strength of the wall."""

    error: float
    shape: _Shape
    slack_above: Polynomial
    stiffness: tuple[Polynomial, ...]
    strength: float


def _fitted(film: Film, columns: list[_Column], checks: list[_Column]) -> ContinuumFilm:
    limit = slack_limit(film.model)
    first = columns[0]
    tension = flat_squared(film.model)
    if hangs_loose(film):
        tension = first.charged.end
    s, squared = (
        np.concatenate(parts)
        for parts in zip(*((np.full(len(c.squared), c.s), c.squared) for c in columns), strict=True)
    )
    farthest = float(s.max())
    ends = [c for c in columns if c.charged.ending in (Ending.PULLED_IN, Ending.CONVERGED)]
    pulled = _Ends(*np.array([(c.s, c.charged.end) for c in ends] or [(0.0, limit)]).T)
    rounding = ROUNDING if hangs_loose(film) else 0.0
    shapes = [_Shape(c, rounding, tension, farthest, wall * farthest) for c in VARIABLES for wall in WALLS]
    surface = _surface(film, columns, checks, shapes, pulled)
    shape = surface.shape
    disc = np.concatenate([column.disc for column in columns])
    local = _least_squares(_basis(s, squared, shape, surface.slack_above, LOCAL), disc, 1.0 / disc)
    slack = [c.s for c in columns if c.slackens]
    model, parameters = film.model, film.model.parameters()
    return ContinuumFilm(
        radius_ratio=film.radius_ratio,
        law=model.gel_law(),
        law_parameters=tuple((name, float(parameters[name])) for name in sorted(model.gel_law().parameters)),
        prestretches=(float(model.stretches[0]), float(model.stretches[1])),
        largest=float(np.sqrt(farthest)),
        variable=shape.variable,
        rounding=shape.rounding,
        flat_tension=shape.tension,
        stiffness=surface.stiffness,
        slack_above=surface.slack_above,
        wall=shape.wall,
        wall_strength=surface.strength,
        disc_stretch=_split(local, LOCAL),
        pull_in=_pull_in(pulled, shape)[1],
        slack_first=0.5 * (max(slack) + float(pulled.s[pulled.s > max(slack)].min(initial=farthest)))
        if slack
        else -1.0,
        slack_limit=limit,
    )


def _rows(film: Film, columns: list[_Column], tension: float) -> _Rows:
    """The states in tension, the ends where the film falls slack, and a little beyond them k as it would go on."""
    rows: list[tuple[float, float, float, float]] = []
    for column in columns:
        rows += [(column.s, *row) for row in zip(column.squared, column.stiffness, column.weight, strict=True)]
        if column.slackens:
            rows += _slack_rows(film, column)
        if column is columns[0] and tension == 0.0:
            rows += _lower_rows(film, rows)
    s, squared, stiffness, weight = np.array(rows).T
    counts = stiffness > 0.0 if hangs_loose(film) else stiffness >= 0.0
    return _Rows(s, squared, stiffness, weight, counts & (s >= _lowest(film)))


def _lower_rows(film: Film, rows: list[tuple[float, float, float, float]]) -> list[tuple[float, float, float, float]]:
    """Those of the lowest height, scaled to lower ones; there the force is too small to be computed."""
    x = float(np.sqrt(rows[0][0]))
    of_slack = {c: slack_squared(film, x * float(np.sqrt(c))) / slack_squared(film, x) for c in LOWER}
    return [(c * s, of_slack[c] * v, c * k, SCALED * w / c) for c in LOWER for s, v, k, w in rows]


def _slack_rows(film: Film, column: _Column) -> list[tuple[float, float, float, float]]:
    """The end of the force, where it is known, and k beyond as it would go on."""
    end, k, squared = slack_end(film, column), column.stiffness, column.squared
    if hangs_loose(film):
        near = min(int(np.searchsorted(squared, NEAR_END * squared[-1])), k.size - 1) - 1
        slope, weight = (k[-1] - k[near]) / (squared[-1] - squared[near]), SOFT / (FLOOR * column.start)
        places = [share * squared[-1] for share in (1.01, 1.03)]
        return [(column.s, v, min(0.0, k[-1] + slope * (v - squared[-1])), weight) for v in places]
    before, beyond = int(np.searchsorted(squared, 0.85 * end)) - 1, 0.5 * (1.0 + SLACK_ABOVE) * end
    k_beyond = -k[before] / (end - squared[before]) * (beyond - end)
    return [(column.s, end, 0.0, 1.0 / (FLOOR * column.start)), (column.s, beyond, k_beyond, -BEYOND / k_beyond)]


def _slack_above(film: Film, columns: list[_Column], shape: _Shape) -> Polynomial:
    """The coefficients of H, which goes on level where the film no longer falls slack."""
    slack = np.array([c.slackens for c in columns])
    ends = np.array([slack_end(film, c) if c.slackens else c.charged.end for c in columns])
    above = SLACK_ABOVE * np.where(slack, ends, LEVEL_ABOVE * ends.max())
    t = shape.place(np.array([c.s for c in columns]))
    terms = (t + shape.tension)[:, None] * chebvander(shape.argument(t), min(SLACK_ENDS, max(1, t.size // 2)) - 1)
    return tuple(_least_squares(terms, above, np.where(slack, 1.0, LEVEL) / above).tolist())


def slack_end(film: Film, column: _Column) -> float:
    """The V at which the film falls slack: known, or where the last states point."""
    k, squared, end = column.stiffness, column.squared, column.charged.end
    if not hangs_loose(film) or len(k) < 2:
        return end
    return float(np.clip(squared[-1] + k[-1] * (squared[-1] - squared[-2]) / (k[-2] - k[-1]), squared[-1], 1.02 * end))


class _Shape(NamedTuple):
    """The numbers of a fit that are chosen: c, e, b, the largest s and the wall."""

    variable: float
    rounding: float
    tension: float
    farthest: float
    wall: float

    def place(self, s: Array) -> Array:
        """t."""
        r = s / (np.sqrt(s + self.rounding**2) + self.rounding) if self.rounding else s
        return np.asarray(r / (r + self.variable))

    def argument(self, t: Array) -> Array:
        """That of the sums over t, between -1 and 1."""
        return np.asarray(2.0 * t / self.place(np.array(self.farthest)) - 1.0)

    def highest(self, t: Array, above: Polynomial) -> Array:
        """H."""
        return np.asarray((t + self.tension) * np.polynomial.chebyshev.chebval(self.argument(t), above))


def _basis(s: Array, squared: Array, shape: _Shape, above: Polynomial, terms: tuple[int, ...]) -> Array:
    """The columns S Ti Tj, those of j = 0 first."""
    t = shape.place(s)
    rest, root = _rest(t, squared, shape, above)
    S = squared + 0.5 * (rest + root)
    along, up = chebvander(shape.argument(t), max(terms) - 1), chebvander(2.0 * squared / S - 1.0, len(terms) - 1)
    return np.concatenate([(S * up[:, j])[:, None] * along[:, :count] for j, count in enumerate(terms)], axis=1)


def _rest(t: Array, squared: Array, shape: _Shape, above: Polynomial) -> tuple[Array, Array]:
    """H - V and M."""
    highest = shape.highest(t, above)
    return highest - squared, np.hypot(highest - squared, FADE * highest)


def _surface(film: Film, columns: list[_Column], checks: list[_Column], shapes: list[_Shape], ends: _Ends) -> _Surface:
    """The smallest largest error, of k at the columns and at those of the check, and of the voltages at which the film
    pulls in, with one of the shapes that are best by least squares."""
    rows, between = (_rows(film, found, shapes[0].tension) for found in (columns, checks))
    pull_in = {shape: _pull_in(ends, shape)[0] for shape in shapes}

    def error(found: _Surface) -> float:
        return max(found.error, pull_in[found.shape])

    best = list[_Surface]()
    for terms in SIZES:
        rough = sorted((_of_shape(film, columns, rows, between, shape, terms, 1) for shape in shapes), key=error)
        fine = [_of_shape(film, columns, rows, between, one.shape, terms, ROUNDS) for one in rough[:FINALISTS]]
        best = [min([*best, *fine], key=error)]
        if best[0].error <= GOOD:
            break
    return best[0]


def _of_shape(
    film: Film,
    columns: list[_Column],
    rows: _Rows,
    checks: _Rows,
    shape: _Shape,
    terms: tuple[int, ...],
    rounds: int,
) -> _Surface:
    above = _slack_above(film, columns, shape)
    basis, other = (_faded_basis(some, shape, above, terms) for some in (rows, checks))
    error, values = _lawson(rows, basis, rounds)
    between = np.abs(other @ values - checks.stiffness) * checks.weight * checks.counts
    return _Surface(
        max(error, float(between.max(initial=0.0))), shape, above, _split(values[:-1], terms), float(values[-1])
    )


def _faded_basis(rows: _Rows, shape: _Shape, above: Polynomial, terms: tuple[int, ...]) -> Array:
    """All of k, over its coefficients."""
    bracket = np.column_stack([_basis(rows.s, rows.squared, shape, above, terms), rows.s / (shape.wall - rows.s)])
    rest, root = _rest(shape.place(rows.s), rows.squared, shape, above)
    return np.asarray(bracket * (rest / root)[:, None])


def _lawson(rows: _Rows, basis: Array, rounds: int) -> tuple[float, Array]:
    """The least largest error and the coefficients: rows with large errors get ever more weight (Lawson's
    algorithm)."""
    more, least, best = np.ones(rows.s.size), np.inf, np.zeros(basis.shape[1])
    for _ in range(rounds):
        found = _least_squares(basis, rows.stiffness, rows.weight * np.sqrt(more))
        error = np.abs(basis @ found - rows.stiffness) * rows.weight * rows.counts
        if error.max() < least:
            least, best = float(error.max()), found
        more = more * (error + 0.1 * error.max())
        more = np.where(rows.counts, more / more[rows.counts].mean(), 1.0)
    return least, best


def _pull_in(ends: _Ends, shape: _Shape) -> tuple[float, Polynomial]:
    """The coefficients of the V at which the film pulls in, and the largest error of the voltage."""
    columns = chebvander(shape.argument(shape.place(ends.s)), min(ENDS, max(1, ends.s.size // 2)) - 1)
    found = _least_squares(columns, ends.squared, 1.0 / ends.squared)
    return float(np.max(np.abs(columns @ found / ends.squared - 1.0))) / 2.0, tuple(found.tolist())


def _least_squares(columns: npt.NDArray[Any], values: Array, weights: Array) -> Array:
    scale = np.sqrt(np.mean((columns * weights[:, None]) ** 2, axis=0))
    found = np.linalg.lstsq(columns * (weights[:, None] / scale), values * weights, rcond=SMALLEST)[0]
    return np.asarray(found / scale)


def _split(values: Array, terms: tuple[int, ...]) -> tuple[Polynomial, ...]:
    return tuple(tuple(part.tolist()) for part in np.split(values, np.cumsum(terms)[:-1]))


# --- its error -------------------------------------------------------------------------------------------------------


def _errors(film: ContinuumFilm, columns: list[_Column], lowest: float) -> dict[str, float]:
    """The largest errors at states from the s ``lowest`` on: of the force over force and 2 % of that without voltage,
    and of the voltages at which the film pulls in."""
    found: dict[str, list[float]] = {}
    for column in columns:
        end = column.charged.end
        off = np.abs(film.pull(column.s, column.squared) - column.stiffness) * column.weight
        if column.s >= lowest:
            found.setdefault("force", []).append(float(off.max()))
        if column.charged.ending == Ending.PULLED_IN:
            own = film.highest_squared_at(column.s)
            found.setdefault("pull-in voltage", []).append(abs(float(np.sqrt(own / end)) - 1.0))
    return {name: max(values) for name, values in found.items()}
