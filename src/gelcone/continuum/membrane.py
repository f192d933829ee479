"""The film as a continuum: force on the disc, shape of the film, stretches and stresses along it.

The disc is first raised at zero voltage, then the voltage is raised at that height. Where the path of equilibria turns
back in a fold (the film pulls in: it thins and bulges sideways), it is followed along its arc to the wanted voltage. A
film that wrinkles is followed until it falls slack or pulls in, see `gelcone.continuum.charged`.

In equilibrium the meridional force of a membrane has the sign of the force on the disc along the whole length, so that
a film in tension never pushes the disc. Where the voltage has removed the tension, a film without bending stiffness has
no state. Only the compressed, unstable film remains that was flat under that voltage and then raised; it is reported
where it exists, and marked.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.codes import Outcome
from gelcone.continuum import density
from gelcone.continuum.charged import charged, slack_limit
from gelcone.continuum.mesh import (
    SLACK_STIFFNESS,
    Film,
    check_radius_ratio,
    derivatives,
    interpolated,
    mesh_film,
    strain,
    stretches,
)
from gelcone.continuum.path import Ending, Point, arc, cone, flat, newton, reach, settled, slackens
from gelcone.errors import InputError, check_name
from gelcone.physics.film.pull_in import DEFAULT_RADIUS_RATIO
from gelcone.physics.model import PARAMETERS, ConeModel, single
from gelcone.progress import Progress
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

WRINKLES = ("mark", "relax")
DEFAULT_ELEMENTS = 200
COMPRESSION = -1e-9
"""True stress over mu that counts as compression, not as rounding."""
MOST_TO_FOLD = 12
"""Steps along the arc within which a path that cannot be followed by its load must turn."""
RESOLVED = 1e-3
"""Largest relative error of the force by the mesh, of a point that is reported."""
NEAR = 0.2
"""Largest distance, in b - a, between a state and that of a mesh half as fine by which it is confirmed."""
SMALLEST_HEIGHT = 0.02
"""Height at which the compressed branch leaves the flat film, unless less is wanted."""


class State(NamedTuple):
    """The film at one displacement and voltage; ``reached`` is the v^2 at which the path to it ended.

    With an ending other than converged or compressed, ``point`` is the last on the way there.
    """

    point: Point | None
    ending: Ending
    folds: int
    reached: float


def membrane(
    model: ConeModel,
    radius_ratio: npt.ArrayLike = DEFAULT_RADIUS_RATIO,
    *,
    displacements: npt.ArrayLike,
    voltages: npt.ArrayLike = 0.0,
    wrinkles: str = "mark",
    elements: int = DEFAULT_ELEMENTS,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute the force over displacement of the film alone as an axisymmetric membrane, and its state along it.

    Parameters
    ----------
    model : one actuator or an ensemble; only its law and pre-stretches play a part, not the spring, mass or drive.
    radius_ratio : a/b, between 0 and 1, one number or of the ensemble's shape. Default 0.2.
    displacements : x = h/(b-a) at which the disc is held, one number or shape (displacement,), in any order.
    voltages : constant voltages v = Phi sqrt(eps/mu)/H (mounted thickness H), at least 0. Default 0.
    wrinkles : ``"mark"`` (default) leaves the film unwrinkled and marks where a stress is compressive; ``"relax"`` lets
        it wrinkle instead (tension field, see `gelcone.continuum.density`): its stresses are then nowhere negative.
    elements : quadratic finite elements along the radius, at least 2. Default 200.
    progress : called with the share of the work done since its last call.

    Returns
    -------
    Dataset over the ensemble's dims, ``constant_voltage``, ``displacement`` and, along the film, ``ring``: the finite
    elements' nodes, mounted at ``mounted_radius`` R (in b - a).

    ``force`` holds the disc against film and field, per mu Vol/(b-a): it compares with `ConeModel.force` without the
    spring. ``ending`` says for each point how its search ended, see `Ending`; where it is neither ``converged`` nor
    ``compressed`` the numbers are NaN (a ``slack`` film has the force 0), and ``reached_voltage`` is the voltage up to
    which the film could be followed; with ``"relax"`` that at which it fell slack or pulled in, to 0.05 %.
    ``force_error`` estimates the error of the mesh: a 15th of the change from a mesh half as fine. ``folds``
    counts the folds of the voltage passed on the way: after them the film has pulled in. ``stable``: the energy has a
    minimum against all axisymmetric motion of the film. ``hoop_slack`` and ``meridional_slack`` mark a compressive
    stress anywhere - the unwrinkled film that was computed is then not physical - or, with ``"relax"``, wrinkles.
    ``overhangs``: the film bulges sideways over the disc or the rim.

    Along the film run ``radius`` and ``height`` (in b - a), true stretches and true stresses over mu, NaN at and
    beyond the stretch limit. ``limit_share`` is the largest (I1 - 3)/limit of all rings, at the mounted
    ``limit_radius``.

    Raises
    ------
    InputError : for a disc larger than the film, or displacements of which none can be reached within the stretch
        limit.
    MissingDependency : without scikit-fem.

    References
    ----------
    Green and Adkins, Large Elastic Deformations (1960), chapter 4; Suo, Acta Mech. Solida Sin. 23 (2010) 549.
    """
    x, levels = check_displacements(displacements), check_voltages(voltages)
    model, ratios = ensemble(model, radius_ratio)
    check_name("way to treat wrinkles", wrinkles, WRINKLES)
    relaxed = wrinkles == "relax"
    films = [mesh_film(single(model.members(), i), ratio, elements, relaxed=relaxed) for i, ratio in enumerate(ratios)]
    _check_reachable(films, x)
    report = progress or (lambda share: None)
    per_film = [
        _fields(film, mesh_film(film.model, film.radius_ratio, max(2, elements // 2), relaxed=relaxed), x, states)
        for film in films
        for states in [solve(film, x, levels, lambda s: report(s / len(films)))]
    ]
    fields = {name: np.stack([film_fields[name] for film_fields in per_film]) for name in per_film[0]}
    is_computed = np.isfinite(fields["force"]).any(axis=(1, 2))
    return dataset.label(
        model,
        _variables(fields),
        coords={
            "constant_voltage": (("constant_voltage",), levels, "constant voltage", "voltage"),
            "displacement": (("displacement",), x, "displacement x = h/(b-a)", "length"),
            "ring": (("ring",), np.arange(films[0].place.size), "node of the film, from the disc outwards", "count"),
            "mounted_radius": (("ring",), np.stack([f.radius for f in films]), "radius R of the flat film", "length"),
            "radius_ratio": ((), ratios, "radius of the disc over that of the film, a/b", "ratio"),
        },
        outcome=np.where(is_computed, Outcome.OK, Outcome.OUTSIDE),
        options={"elements": elements, "wrinkles": wrinkles},
        title="film as a membrane",
    )


# --- the search ------------------------------------------------------------------------------------------------------


def solve(film: Film, x: Array, levels: Array, progress: Callable[[float], None] = lambda _: None) -> list[list[State]]:
    """The states at every voltage and displacement; a lowered disc has the mirrored state of a raised one."""
    heights, squares = np.unique(np.abs(x)).tolist(), np.unique(levels**2).tolist()
    raised = raised_film(film, heights)
    rows: list[list[State]] = []
    for height in heights:
        rows.append(_charged(film, height, raised.get(height), squares, rows[-1] if rows else None))
        progress(0.5 / len(heights))
    all_states: dict[tuple[float, float], State] = {}
    for k, square in enumerate(squares):
        states = dict(zip(heights, [row[k] for row in rows], strict=True))
        if not film.relaxed:
            states |= _pulled_in(film, states, square)
            states |= _compressed(film, states, square)
        all_states |= {(square, height): state for height, state in states.items()}
        progress(0.5 / len(squares))
    return [[all_states[v * v, abs(h)] for h in x.tolist()] for v in levels.tolist()]


def raised_film(film: Film, heights: list[float]) -> dict[float, Point]:
    """The film without voltage at those heights at which it is in tension."""
    start = flat(film, 0.0)
    points: dict[float, Point] = {}
    point = None
    for height in (h for h in heights if 0.0 < h < highest_span(film)):
        if point is None:
            guess = newton(film, cone(film, height, start), 0.0) or settled(film, cone(film, height), 0.0)
            point = guess if guess is not None and guess.stable and not slackens(guess) else None
        else:
            below = point
            point = reach(film, below, "height", height)[0] or settled(film, cone(film, height, below), 0.0)
            if point is None:
                break
        if point is not None:
            points[height] = point
    return points


def _charged(
    film: Film, height: float, start: Point | None, squares: list[float], below: list[State] | None
) -> list[State]:
    """The film at one height under rising voltage, up to the first fold.

    A step from the next lower height at the same voltage (``below``) leads to the same state, and is tried first since
    it is faster.
    """
    if height == 0.0:
        return [_flat_state(film, square) for square in squares]
    if start is None:
        return [State(None, _why_not_raised(film, height), 0, 0.0)] * len(squares)
    if film.relaxed:
        return _relaxed_states(film, start, squares)
    state = State(start, Ending.CONVERGED, 0, 0.0)
    states = []
    for k, square in enumerate(squares):
        if state.ending == Ending.CONVERGED and state.point is not None:
            lower = below[k] if below else None
            state = _charged_to(film, state.point, square, lower)
        states.append(state)
    return states


def _relaxed_states(film: Film, start: Point, squares: list[float]) -> list[State]:
    """States of a film that wrinkles: in tension, then slack or pulled in; a slack film pulls in at the voltage of a
    free film. ``reached`` is then the middle of the bracket of the V at which the tension ended."""
    state, limit, states = State(start, Ending.CONVERGED, 0, 0.0), slack_limit(film.model), []
    for square in squares:
        if state.ending == Ending.CONVERGED and state.point is not None:
            charge_path = charged(film, state.point, square, square - state.reached)
            ended = charge_path.ending != Ending.CONVERGED
            state = State(charge_path.points[-1], charge_path.ending, 0, charge_path.end if ended else square)
        if state.ending == Ending.SLACK and square > limit:
            state = State(state.point, Ending.PULLED_IN, 0, limit)
        states.append(state)
    return states


def _charged_to(film: Film, start: Point, square: float, lower: State | None) -> State:
    """The state at the V ``square``, reached from the ``lower`` height at that voltage, or else from a lower one."""
    if lower is not None and lower.point is not None and lower.ending == Ending.CONVERGED and square > start.squared:
        point = reach(film, lower.point, "height", start.height)[0] if lower.point.height > 0.0 else None
        if point is not None:
            return State(point, Ending.CONVERGED, 0, square)
    reached, last = reach(film, start, "squared", square)
    return _ended(film, last) if reached is None else State(reached, Ending.CONVERGED, 0, square)


def _flat_state(film: Film, square: float) -> State:
    """The state of the film with the disc at height 0."""
    point = flat(film, square)
    if point is None:
        return State(None, Ending.NOT_CONVERGED, 0, 0.0)
    compressed = point.forces.least < COMPRESSION
    return State(point, Ending.COMPRESSED if compressed else Ending.CONVERGED, 0, square)


def _why_not_raised(film: Film, height: float) -> Ending:
    """The ending of a film without a state in tension at a height and no voltage."""
    if height >= highest_span(film):
        return Ending.BEYOND_LIMIT
    start = flat(film, 0.0)
    return Ending.NOT_CONVERGED if start is None or start.forces.least >= 0.0 else Ending.TENSION_LOST


def _ended(film: Film, last: Point) -> State:
    """The state that holds the last point before the voltage could not be raised further; a few steps along the arc
    determine its ending."""
    reached = last.squared
    for here in itertools.islice(arc(film, last), MOST_TO_FOLD):
        reached = max(reached, here.point.squared)
        if slackens(here.point):
            return State(last, Ending.TENSION_LOST, 0, reached)
        if here.folds:
            return State(last, Ending.PULLED_IN, 0, reached)
    return State(last, Ending.NOT_CONVERGED, 0, reached)


def _pulled_in(film: Film, states: dict[float, State], square: float) -> dict[float, State]:
    """The states past the fold of the voltage, from the highest disc down: along the arc, then by lowering the disc.

    The lower the disc, the sooner a film that has pulled in loses its tension, so that the search ends at the first
    height at which it has.
    """
    lowered_states: dict[float, State] = {}
    above: Point | None = None
    for height, state in sorted(states.items(), reverse=True):
        if state.point is None or state.ending not in (Ending.PULLED_IN, Ending.NOT_CONVERGED):
            above = state.point if state.ending == Ending.CONVERGED else None
            continue
        point = None if above is None else reach(film, above, "height", height)[0]
        if point is None:
            point = _along_arc(film, state.point, square)
        if point is None:
            break
        lowered_states[height] = State(point, Ending.CONVERGED, 2, square)
        above = point
    return lowered_states


def _along_arc(film: Film, start: Point, square: float) -> Point | None:
    """The first stable point at v^2 along the arc from a point before the fold; None if tension is lost before."""
    before = start
    for here in arc(film, start):
        if slackens(here.point):
            return None
        if before.squared < square <= here.point.squared and here.point.stable:
            for near in (before, here.point):
                point = reach(film, near, "squared", square)[0] if near.stable else None
                if point is not None:
                    return point
        before = here.point
    return None


def _compressed(film: Film, states: dict[float, State], square: float) -> dict[float, State]:
    """The film that was flat under v^2 and then raised, as far as all of its meridian stays compressed."""
    lost = (Ending.TENSION_LOST, Ending.PULLED_IN)
    heights = sorted(h for h, state in states.items() if h > 0.0 and state.ending in lost)
    start = flat(film, square) if heights else None
    if start is None or not start.forces.most < 0.0:
        return {}
    compressed_states: dict[float, State] = {}
    point = newton(film, cone(film, min(SMALLEST_HEIGHT, heights[0]), start), square)
    for height in heights:
        point = None if point is None else reach(film, point, "height", height)[0]
        if point is None or not point.forces.most < 0.0:
            break
        compressed_states[height] = State(point, Ending.COMPRESSED, 0, square)
    return compressed_states


def highest_span(film: Film) -> float:
    """A height that no film of this law spans within its stretch limit; infinite without one.

    Somewhere the film is stretched at least by the slant, lm sqrt(1 + x^2). With the hoop free to narrow,
    I1 - 3 = s + 2/sqrt(s) - 3 at the squared stretch s.
    """
    from scipy.optimize import brentq

    limit, lm = float(film.model.strain_limit()), float(film.model.stretches[0])
    if np.isinf(limit):
        return np.inf
    most = brentq(lambda s: s + 2.0 / np.sqrt(s) - 3.0 - limit, 1.0, limit + 4.0, xtol=1e-14)
    return float(np.sqrt(max(most / (lm * lm) - 1.0, 0.0)))


# --- variables of the Dataset ----------------------------------------------------------------------------------------


def _fields(film: Film, coarse: Film, x: Array, states: list[list[State]]) -> dict[str, Array]:
    """All variables, each (voltages, displacements) or (voltages, displacements, rings)."""
    each = [[_field(film, coarse, state, np.sign(h)) for h, state in zip(x, row, strict=True)] for row in states]
    return {name: np.array([[one[name] for one in row] for row in each]) for name in each[0][0]}


def _field(film: Film, coarse: Film, state: State, side: float) -> dict[str, Any]:
    """The variables of one point, the film mirrored for a disc that is pulled down (``side`` -1)."""
    point = state.point if state.ending in (Ending.CONVERGED, Ending.COMPRESSED) else None
    slack = state.ending == Ending.SLACK
    error = np.nan if point is None else force_error(film, point, coarse)
    resolved = point is None or error <= RESOLVED * abs(point.force) + (SLACK_STIFFNESS if film.relaxed else 0.0)
    ending = state.ending if resolved else Ending.UNRESOLVED
    ending_fields = {"ending": ending, "folds": state.folds, "reached_voltage": np.sqrt(state.reached)}
    if point is None or ending == Ending.UNRESOLVED:
        nothing = np.full(film.place.size, np.nan)
        scalars: dict[str, Any] = dict.fromkeys(_SCALARS, np.nan) | dict.fromkeys(_FLAGS, False)
        scalars |= {"force": 0.0, "force_error": 0.0, "hoop_slack": True, "meridional_slack": True} if slack else {}
        return ending_fields | scalars | dict.fromkeys(_PROFILES, nothing)
    position = point.position
    along, hoop, stress, hoop_stress = stress_state(film, position, point.squared)
    slack, hoop_slack = _slack(film, position, point.squared)
    share = limit_shares(film, position)
    overhang = stretches(film, position)[0].min() < 0.0
    return ending_fields | {
        "force": (side or 1.0) * point.force,
        "force_error": error,
        "limit_share": share.max(),
        "limit_radius": film.radius[np.argmax(share)],
        "stable": point.stable,
        "hoop_slack": hoop_slack,
        "meridional_slack": slack,
        "overhangs": overhang,
        "radius": film.radius + position[0::2],
        "height": (side or 1.0) * position[1::2],
        "meridional_stretch": along,
        "hoop_stretch": hoop,
        "meridional_stress": stress,
        "hoop_stress": hoop_stress,
    }


_SCALARS = ("force", "force_error", "limit_share", "limit_radius")
_FLAGS = ("stable", "hoop_slack", "meridional_slack", "overhangs")
_PROFILES = ("radius", "height", "meridional_stretch", "hoop_stretch", "meridional_stress", "hoop_stress")


def force_error(film: Film, point: Point, coarse: Film) -> float:
    """The error of the force, by comparison with a mesh half as fine: at order 4, a 15th of the difference.

    Infinite where the coarse mesh has no such state nearby.
    """
    if point.height == 0.0:
        return 0.0
    guess = np.empty(coarse.size)
    for k in (0, 1):
        guess[k::2] = interpolated(film, point.position[k::2], coarse.place)
    guess[[0, 1, -2, -1]] = point.position[[0, 1, -2, -1]]
    other = newton(coarse, guess, point.squared, NEAR)
    return np.inf if other is None else abs(other.force - point.force) / 15.0


def limit_shares(film: Film, position: Array) -> Array:
    """I1 - 3 over the stretch limit at the nodes (nodes,); 0 for a law without limit."""
    along, up, hoop = (_at_nodes(film, values) for values in stretches(film, position, film.at_nodes))
    return np.asarray(strain(film, along**2 + up**2, hoop**2) / film.model.strain_limit())


def stress_state(film: Film, position: Array, squared: float) -> tuple[Array, ...]:
    """True stretches and true stresses over mu at the nodes, each (nodes,)."""
    along, up, hoop = (_at_nodes(film, values) for values in stretches(film, position, film.at_nodes))
    m, n = along**2 + up**2, hoop**2
    phi, c = derivatives(film, m, n, squared), film.coefficients
    inside = strain(film, m, n) < film.model.strain_limit()
    stress, hoop_stress = (np.where(inside, 2.0 * s * force, np.nan) for s, force in ((m, phi.m), (n, phi.n)))
    return np.sqrt(c["A"] * m), np.sqrt(c["B"] * n), stress, hoop_stress


def _slack(film: Film, position: Array, squared: float) -> tuple[bool, bool]:
    """True if the unwrinkled film would be compressed anywhere, along the meridian and along the hoop."""
    along, up, hoop = (_at_nodes(film, values) for values in stretches(film, position, film.at_nodes))
    m, n = along**2 + up**2, hoop**2
    phi = density.derivatives(film.model.gel_law(), film.coefficients, m, n, squared)
    return bool(np.min(2.0 * m * phi.m) < COMPRESSION), bool(np.min(2.0 * n * phi.n) < COMPRESSION)


def _at_nodes(film: Film, values: Array) -> Array:
    """One value per node from values at the three nodes of each element: the mean where elements meet."""
    nodes = film.unknowns[:, ::2] // 2
    count = np.bincount(nodes.ravel(), minlength=film.place.size)
    return np.bincount(nodes.ravel(), values.ravel(), film.place.size) / count


def _variables(fields: dict[str, Array]) -> dict[str, dataset.Variable]:
    """The fields with dims, long names and units."""
    at, along = ("constant_voltage", "displacement"), ("constant_voltage", "displacement", "ring")
    return {
        "force": (at, fields["force"], "static force that holds the disc against film and field", "force"),
        "force_error": (at, fields["force_error"], "estimated error of the force by the mesh", "force"),
        "ending": (at, fields["ending"].astype(np.int8), "how the search for the point ended", Ending),
        "reached_voltage": (at, fields["reached_voltage"], "voltage up to which the film could be followed", "voltage"),
        "folds": (at, fields["folds"], "folds of the voltage passed on the way; from one on it has pulled in", "count"),
        "stable": (at, fields["stable"] == 1, "whether the energy of the film has a minimum", "flag"),
        "hoop_slack": (at, fields["hoop_slack"] == 1, "hoop stress negative somewhere: wrinkles", "flag"),
        "meridional_slack": (at, fields["meridional_slack"] == 1, "meridional stress negative somewhere", "flag"),
        "overhangs": (at, fields["overhangs"] == 1, "whether the film bulges over the disc or the rim", "flag"),
        "limit_share": (at, fields["limit_share"], "largest share of the stretch limit, (I1-3)/limit", "ratio"),
        "limit_radius": (at, fields["limit_radius"], "mounted radius of that ring", "length"),
        "radius": (along, fields["radius"], "radius of the rings", "length"),
        "height": (along, fields["height"], "height of the rings", "length"),
        "meridional_stretch": (along, fields["meridional_stretch"], "true meridional stretch", "stretch"),
        "hoop_stretch": (along, fields["hoop_stretch"], "true hoop stretch", "stretch"),
        "meridional_stress": (along, fields["meridional_stress"], "true meridional stress", "stress"),
        "hoop_stress": (along, fields["hoop_stress"], "true hoop stress", "stress"),
    }


# --- input -----------------------------------------------------------------------------------------------------------


def check_displacements(values: npt.ArrayLike) -> Array:
    """Displacements as an array (displacement,); `InputError` for what is not finite or given twice."""
    try:
        x = np.atleast_1d(np.asarray(values, dtype=float))
    except (TypeError, ValueError):
        raise InputError(f"displacements = {values!r}: must be numbers x = h/(b-a)") from None
    if x.ndim > 1 or x.size == 0 or not np.isfinite(x).all() or np.unique(x).size < x.size:
        raise InputError(f"displacements = {x.tolist()}: must be finite numbers, each given once")
    return x


def check_voltages(values: npt.ArrayLike) -> Array:
    """Voltages as an array (constant_voltage,); `InputError` for one that is negative, not finite or given twice."""
    levels = np.atleast_1d(np.asarray(PARAMETERS["voltage"].check("voltages", values), dtype=float))
    if levels.ndim > 1 or np.unique(levels).size < levels.size:
        raise InputError(f"voltages = {levels.tolist()}: must be a number or a row of them, each given once")
    return levels


def ensemble(model: ConeModel, radius_ratio: npt.ArrayLike) -> tuple[ConeModel, list[float]]:
    """The model as an ensemble of the shape that its arrays and the radius ratios broadcast to, and the ratios."""
    shape = np.shape(radius_ratio)
    if shape and not model.shape:
        # the film does not depend on the spring, so that broadcasting it makes the ensemble
        model = model.replace(spring_stiffness=np.full(shape, model.spring_stiffness))
    try:
        ratios = np.broadcast_to(np.asarray(radius_ratio), model.shape).ravel()
    except ValueError:
        raise InputError(f"radius_ratio of the shape {shape}: must be a number or of the shape {model.shape}") from None
    return model, [check_radius_ratio(ratio) for ratio in ratios.tolist()]


def _check_reachable(films: list[Film], x: Array) -> None:
    """Raises `InputError` where no film spans any displacement within its stretch limit."""
    flat_strain = [float(film.model.strain(0.0)) for film in films]
    highest = max(highest_span(film) for film in films)
    if all(flat >= float(film.model.strain_limit()) for flat, film in zip(flat_strain, films, strict=True)):
        raise InputError(
            f"the pre-stretch alone gives I1 - 3 = {min(flat_strain):.4g}, which must be less than the stretch limit; "
            "lower the pre-stretch or raise stretch_limit"
        )
    if np.abs(x).min() >= highest:
        raise InputError(
            f"displacements from {np.abs(x).min():g} on: no film spans them within its stretch limit; "
            f"give |x| below {highest:.6g} or raise stretch_limit"
        )
