"""The cone model compared with the continuum: force, share of the stretch limit, and the error of the mesh."""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.continuum.membrane import (
    DEFAULT_ELEMENTS,
    check_displacements,
    check_voltages,
    ensemble,
    limit_shares,
    membrane,
    solve,
)
from gelcone.continuum.mesh import Film, interpolated, mesh_film
from gelcone.continuum.path import Ending, Point, cone, flat, newton, reach, slackens
from gelcone.devices.analysis import analysis
from gelcone.errors import InputError
from gelcone.physics.film.gel import cone_reach
from gelcone.physics.film.pull_in import DEFAULT_RADIUS_RATIO
from gelcone.physics.model import ConeModel, single
from gelcone.progress import Progress
from gelcone.quantity import Array, Lengths, Voltages
from gelcone.register.analysis import CONSTANT_VOLTAGE, Axis

if TYPE_CHECKING:
    import xarray as xr

DISPLACEMENTS = (0.1, 2.0, 20)
LIMIT_SHARES = (0.1, 0.5, 0.9)
"""Shares of the stretch limit at which the displacements are determined."""
LIMIT_STEPS = 40
MESHES = (5, 10, 20, 40, 80)
FORCE_ORDER, SHAPE_ORDER = 4, 3
"""Powers of the element size with which the errors of force (an energy) and shape of quadratic elements fall."""

MESH_VARIABLES = {
    "force": ("force of the continuum on the disc", "force"),
    "force_error": ("distance of the force from that of a mesh four times finer than the finest", "force"),
    "force_order": (f"observed order of the force; {FORCE_ORDER} is expected", "count"),
    "shape_error": ("root mean square distance of the rings from those of that finer mesh", "length"),
    "shape_order": (f"observed order of the shape; {SHAPE_ORDER} is expected", "count"),
}
"""Variables of a mesh-convergence table -> meaning and scale."""


@analysis(
    axes={
        "displacements": Axis("displacement", "displacement", least=1),
        "voltages": CONSTANT_VOLTAGE,
    },
    answers="validation",
    examples=(
        "--set radius_ratio=0.2 --over displacement=0.5,1,1.5 --over constant_voltage=0,0.3 --out results",
        "--set radius_ratio=0.05,0.2,0.5 --set prestretch=1.2 --set prestretch_mode=equibiaxial --json",
        'paper-table1 --over "displacement=5 mm:40 mm:8" --over "constant_voltage=0 kV,1 kV" --wrinkles relax',
    ),
)
def validate(
    model: ConeModel,
    displacements: Lengths | None = None,
    voltages: Voltages | None = None,
    *,
    wrinkles: str = "mark",
    elements: int = DEFAULT_ELEMENTS,
    progress: Progress = None,
) -> xr.Dataset:
    """Check the force of the film models against finite elements, at displacements and voltages. Needs scikit-fem.

    Parameters
    ----------
    model : one actuator or an ensemble, of which the first film's law, pre-stretches and ``radius_ratio`` (a/b, default
        0.2) alone play a part, not the film that it names, spring, mass or drive.
    displacements : displacements x = h/(b-a) at which the disc is held, one number or a list. Default 20 from 0.1 to 2.
    voltages : constant voltages v, at least 0, one number or a list. Default none but 0.
    wrinkles : the treatment of wrinkles: with ``"mark"`` the film does not wrinkle, and states in compression are
        marked, with ``"relax"`` it wrinkles (tension-field theory), and the film named membrane is compared, too.
    elements : quadratic finite elements along the radius, at least 2.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    The Dataset of `compare`, and for each member `mesh_convergence` at one of its points, in variables with ``mesh_``
    before their names.

    Raises
    ------
    InputError : for a disc larger than the film, or displacements of which none can be reached within the stretch
        limit.
    MissingDependency : without scikit-fem; pip install 'gelcone[fem]'.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(hoop_prestretch=1.4, meridional_prestretch=1.2)
    >>> found = gelcone.validate(model, [0.4])
    >>> f"the cone is off by {found.deviation.item():.1%}, at a stretch of {found.cone_stretch.item():.3f}"
    'the cone is off by 22.2%, at a stretch of 1.292'
    """
    ratio = model.values.get("radius_ratio", DEFAULT_RADIUS_RATIO)
    film = model.replace(film="taut", radius_ratio=None, second_film=None, voltage=0.0, voltage_bias=0.0)
    x = np.linspace(*DISPLACEMENTS) if displacements is None else displacements
    levels = 0.0 if voltages is None else voltages
    result = compare(
        film, ratio, displacements=x, voltages=levels, wrinkles=wrinkles, elements=elements, progress=progress
    )
    return with_mesh_table(result, ratio).assign_attrs(dataset.film_errors(model))


def compare(
    model: ConeModel,
    radius_ratio: npt.ArrayLike = DEFAULT_RADIUS_RATIO,
    *,
    displacements: npt.ArrayLike,
    voltages: npt.ArrayLike = 0.0,
    wrinkles: str = "mark",
    elements: int = DEFAULT_ELEMENTS,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute the relaxed film by `membrane`, and the cone model of the same film for comparison.

    Parameters and errors are those of `membrane`.

    Returns
    -------
    The Dataset of `membrane`, in which ``continuum_force`` takes the place of ``force``, with ``cone_force``,
    ``cone_stretch`` (along the meridian) and ``cone_limit_share`` of the homogeneous cone. Both forces are those of
    film and field at a constant voltage, -v^2/2 times the squared area ratio included, without the spring.
    ``deviation`` is cone_force/continuum_force - 1: positive where the cone overestimates the force, NaN where the
    film is compressed along its meridian or has pulled in. ``limit_displacement`` and ``cone_limit_displacement``
    over ``share`` are the displacements at which the largest I1 - 3 reaches that share of the stretch limit without
    voltage; NaN for a law without limit. With ``"relax"`` the cone wrinkles too, and ``pull_in_film_voltage`` and
    ``cone_pull_in_film_voltage`` over the displacement state above which voltage each has pulled in: the continuum's is
    NaN where no given voltage was that high. ``membrane_force``, ``membrane_deviation`` and
    ``membrane_pull_in_film_voltage`` are then those of the film that is named membrane, NaN of one that is not
    computed.
    """
    result = membrane(
        model,
        radius_ratio,
        displacements=displacements,
        voltages=voltages,
        wrinkles=wrinkles,
        elements=elements,
        progress=progress,
    )
    model, ratios = ensemble(model, radius_ratio)
    x, levels = result["displacement"].values, result["constant_voltage"].values
    members = [single(model.members(), i) for i in range(model.size)]
    cone = {"film": "wrinkling", "pull_in": "minimum"} if wrinkles == "relax" else {"film": "taut"}
    cones = [member.replace(**cone) for member in members]
    with np.errstate(all="ignore"):
        force = np.array([[member.film_force(x, v) for v in levels] for member in cones])
        share = np.array([np.tile(m.strain(x) / m.strain_limit(), (levels.size, 1)) for m in members])
    cone_stretch = np.array([member.stretches[0] * np.sqrt(1.0 + x * x) for member in members])
    held = result["force"].values.reshape(force.shape)
    ending, folds = (result[name].values.reshape(force.shape) for name in ("ending", "folds"))
    tense = (ending == Ending.CONVERGED) & (folds == 0) & (held * np.sign(x) > 0.0)
    held = np.where(tense, held, np.nan)
    films = [mesh_film(member, ratio, elements) for member, ratio in zip(members, ratios, strict=True)]
    reached = np.array([limit_displacements(film) for film in films])
    cone_reached = np.array([_cone_limit(member, LIMIT_SHARES) for member in members])
    at = ("constant_voltage", "displacement")
    cone_values = dataset.label(
        model,
        {
            "cone_force": (at, force, "static force of the homogeneous cone on the disc", "force"),
            "deviation": (at, force / held - 1.0, "force of the cone over that of the continuum, less 1", "ratio"),
            "cone_stretch": (at[1:], cone_stretch, "true meridional stretch of the cone", "stretch"),
            "cone_limit_share": (at, share, "share of the stretch limit in the cone, (I1-3)/limit", "ratio"),
            "limit_displacement": (("share",), reached, "where the continuum reaches the share", "length"),
            "cone_limit_displacement": (("share",), cone_reached, "where the cone reaches the share", "length"),
        }
        | (_of_wrinkling(result, members, ratios, held) if wrinkles == "relax" else {}),
        coords={"share": (("share",), np.array(LIMIT_SHARES), "share of the stretch limit", "ratio")},
        options={"elements": elements, "wrinkles": wrinkles},
        title="cone and continuum",
    )
    merged = result.rename(force="continuum_force").assign(cone_values.data_vars).assign_coords(cone_values.coords)
    return merged.assign_attrs(cone_values.attrs)


def _of_wrinkling(
    result: xr.Dataset, members: list[ConeModel], ratios: list[float], held: Array
) -> dict[str, dataset.Variable]:
    """Voltages above which continuum, cone and membrane have pulled in, over the displacements, and the force of the
    membrane compared with ``held``. The voltage of the continuum is NaN where no given voltage was that high."""
    x, levels = result["displacement"].values, result["constant_voltage"].values
    force, limit = np.full(held.shape, np.nan), np.full((len(members), x.size), np.nan)
    for i, (member, ratio) in enumerate(zip(members, ratios, strict=True)):
        with contextlib.suppress(InputError):
            membrane = member.replace(film="membrane", radius_ratio=ratio)
            force[i] = [membrane.film_force(x, v) for v in levels]
            limit[i] = np.sqrt(membrane.film.highest_squared(x, membrane.numbers()))
    ending, reached = (result[name].values.reshape(held.shape) for name in ("ending", "reached_voltage"))
    ended = ending == Ending.PULLED_IN
    pull_ins = np.where(ended.any(axis=1), np.min(np.where(ended, reached, np.inf), axis=1), np.nan)
    cones = [member.replace(film="wrinkling") for member in members]
    squared = np.array([cone.film.highest_squared(x, cone.numbers()) for cone in cones])
    along, at = ("displacement",), ("constant_voltage", "displacement")
    return {
        "pull_in_film_voltage": (along, pull_ins, "voltage above which the continuum has pulled in", "voltage"),
        "cone_pull_in_film_voltage": (along, np.sqrt(squared), "voltage above which the cone has pulled in", "voltage"),
        "membrane_pull_in_film_voltage": (
            along,
            limit,
            "voltage above which the film named membrane has pulled in",
            "voltage",
        ),
        "membrane_force": (at, force, "static force of the film named membrane on the disc", "force"),
        "membrane_deviation": (
            at,
            force / held - 1.0,
            "static force of the film named membrane over that of the continuum, less 1",
            "ratio",
        ),
    }


def limit_displacements(film: Film, shares: Sequence[float] = LIMIT_SHARES) -> Array:
    """Displacements at which the largest I1 - 3 of the film reaches shares of its stretch limit, without voltage.

    NaN where it does not: for a film without limit, or where Newton's method does not get that far.
    """
    displacements = np.full(len(shares), np.nan)
    step = 1.2 * float(_cone_limit(film.model, max(shares))) / LIMIT_STEPS
    if not step > 0.0:
        return displacements
    before: Point | None = None
    for k in range(1, LIMIT_STEPS + 1):
        after = _raised_to(film, before, k * step)
        if before is not None and after is None:
            break
        if before is not None and after is not None:
            low, high = (limit_shares(film, point.position).max() for point in (before, after))
            for i in np.flatnonzero((low < np.asarray(shares)) & (np.asarray(shares) <= high)):
                displacements[i] = _crossing(film, before, after.height, shares[int(i)])
        before = after
    return displacements


def _crossing(film: Film, below: Point, highest: float, share: float) -> float:
    """The height between a point and a higher one at which the largest share of the stretch limit is ``share``."""
    from scipy.optimize import brentq

    def excess(height: float) -> float:
        point = below if height == below.height else reach(film, below, "height", height)[0]
        return np.nan if point is None else float(limit_shares(film, point.position).max()) - share

    return float(brentq(excess, below.height, highest, xtol=1e-8))


def _raised_to(film: Film, below: Point | None, height: float) -> Point | None:
    """The film without voltage at a height, started from a lower one, or else from the cone; None without tension."""
    if below is not None:
        return reach(film, below, "height", height)[0]
    point = newton(film, cone(film, height, flat(film, 0.0)), 0.0)
    return point if point is not None and point.stable and not slackens(point) else None


def _cone_limit(model: ConeModel, shares: npt.ArrayLike) -> Array:
    """The displacements at which the cone reaches shares of its stretch limit; NaN where it does not."""
    displacements = cone_reach(np.asarray(shares) * model.strain_limit(), model.own_numbers)[1]
    return np.where(np.isfinite(displacements), displacements, np.nan)


# --- the mesh --------------------------------------------------------------------------------------------------------


def mesh_convergence(
    model: ConeModel,
    radius_ratio: float = DEFAULT_RADIUS_RATIO,
    *,
    displacement: float = 1.0,
    voltage: float = 0.0,
    elements: Sequence[int] = MESHES,
) -> xr.Dataset:
    """Compute how force and shape converge with the number of elements, and the observed order.

    Parameters
    ----------
    model : one actuator.
    radius_ratio, displacement, voltage : as in `membrane`, one number each.
    elements : at least two increasing numbers of elements, each dividing the next. Default 5 to 80, doubled each time.

    Returns
    -------
    Dataset over ``elements``: ``force``, ``force_error`` and ``shape_error`` (root mean square distance of the rings,
    in b - a) against a mesh four times finer than the finest, and ``force_order`` and ``shape_order`` between a mesh
    and the one before (NaN for the first). The theory of quadratic elements gives 4 and 3.

    Raises
    ------
    InputError : if on some mesh no film in tension is found at that displacement and voltage.
    """
    counts = [int(n) for n in elements]
    if len(counts) < 2 or any(b <= a or b % a for a, b in itertools.pairwise(counts)):
        raise InputError(f"elements = {list(elements)}: must be at least two, each a multiple of the one before")
    x, v = float(check_displacements(displacement)[0]), float(check_voltages(voltage)[0])
    meshes = [mesh_film(model, radius_ratio, n) for n in (*counts, 4 * counts[-1])]
    points = [_point(film, x, v) for film in meshes]
    exact, fine = points[-1], meshes[-1]
    force = np.array([point.force for point in points[:-1]])
    force_error = np.abs(force - exact.force)
    shape_error = np.array([_distance(f, p, fine, exact) for f, p in zip(meshes[:-1], points, strict=False)])
    ratio = np.log(np.array(counts[1:]) / np.array(counts[:-1]))
    with np.errstate(divide="ignore", invalid="ignore"):
        orders = [np.append(np.nan, np.log(e[:-1] / e[1:]) / ratio) for e in (force_error, shape_error)]
    along = ("elements",)
    values = dict(zip(MESH_VARIABLES, (force, force_error, orders[0], shape_error, orders[1]), strict=True))
    return dataset.label(
        model,
        {name: (along, values[name], *described) for name, described in MESH_VARIABLES.items()},
        coords={"elements": (along, np.array(counts), "quadratic elements along the radius", "count")},
        options={"radius_ratio": meshes[0].radius_ratio, "displacement": x, "voltage": v},
        title="convergence of the mesh",
    )


def _point(film: Film, x: float, voltage: float) -> Point:
    """The film in tension at a displacement and voltage; raises `InputError` where there is none."""
    state = solve(film, np.array([x]), np.array([voltage]))[0][0]
    if state.ending != Ending.CONVERGED or state.point is None or x == 0.0:
        raise InputError(
            f"displacement = {x:g} at voltage = {voltage:g}, {len(film.unknowns)} elements: {state.ending.meaning}; "
            "choose one at which the film is in tension"
        )
    return state.point


def _distance(film: Film, point: Point, fine: Film, exact: Point) -> float:
    """Root mean square distance of the rings from those of a finer mesh, over the width of the film."""
    shape = np.stack([interpolated(film, point.position[k::2], fine.place) for k in (0, 1)])
    squared = np.sum((shape - exact.position.reshape(-1, 2).T) ** 2, axis=0)
    return float(np.sqrt(np.sum(0.5 * (squared[1:] + squared[:-1]) * np.diff(fine.place))))


def with_mesh_table(result: xr.Dataset, radius_ratio: npt.ArrayLike = DEFAULT_RADIUS_RATIO) -> xr.Dataset:
    """Add to the Dataset of `compare` for each member `mesh_convergence` at one of its points.

    The point is the middle one of those in tension at the lowest voltage; ``mesh_displacement`` and ``mesh_voltage``
    state it. The table's variables have ``mesh_`` before their names and run over ``mesh_elements``. They are NaN for a
    member that is in tension nowhere, or not on all meshes.
    """
    model, ratios = ensemble(dataset.model_of(result), radius_ratio)
    shape = (model.size, result.sizes["constant_voltage"], result.sizes["displacement"])
    held = np.isfinite(result["deviation"].values.reshape(shape))
    rows = []
    for i, ratio in enumerate(ratios):
        row = {name: np.full(len(MESHES), np.nan) for name in MESH_VARIABLES}
        point = np.full(2, np.nan)
        points = np.argwhere(held[i])
        if len(points):
            lowest = points[points[:, 0] == points[0, 0]]
            k, j = lowest[len(lowest) // 2]
            point = np.array([result["displacement"].values[j], result["constant_voltage"].values[k]])
            with contextlib.suppress(InputError):
                member = single(model.members(), i)
                table = mesh_convergence(member, ratio, displacement=abs(point[0]), voltage=point[1])
                row = {name: table[name].values for name in MESH_VARIABLES}
        rows.append(row | {"displacement": point[0], "voltage": point[1]})
    along = ("mesh_elements",)
    variables: dict[str, dataset.Variable] = {
        f"mesh_{name}": (along, np.stack([row[name] for row in rows]), meaning, quantity)
        for name, (meaning, quantity) in MESH_VARIABLES.items()
    }
    for name, quantity in (("displacement", "length"), ("voltage", "voltage")):
        values = np.array([row[name] for row in rows])
        variables[f"mesh_{name}"] = ((), values, f"{name} at which the mesh was varied", quantity)
    table = dataset.label(
        model,
        variables,
        coords={"mesh_elements": (along, np.array(MESHES), "quadratic elements along the radius", "count")},
        options={},
        title="convergence of the mesh",
    )
    return result.assign(table.data_vars).assign_coords(mesh_elements=table["mesh_elements"])
