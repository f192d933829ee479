"""The film as an incompressible axisymmetric solid of finite thickness: an independent check of the membrane.

Mounted, the film fills a <= R <= b, |Z| <= t/2 (lengths in b - a, t = H/(b - a)) under the model's pre-stretches. It
moves by u along the radius and w upwards; clamped and bonded faces keep their shape. With F = grad (R + u, Z + w) in
the plane, the hoop stretch f = 1 + u/R and a pressure p that keeps the volume,

    energy = integral of W(I1 - 3) - p (det F f - 1) over 2 R dR dZ/(t (b^2 - a^2)),
    I1 - 3 = A (F11^2 + F21^2) + G (F12^2 + F22^2) + B f^2 - 3.

Taylor-Hood elements: biquadratic displacements, bilinear pressure. Newton's method starts from the membrane. There is
no voltage here: a film without it, or one in which pre-stretch keeps the tension, tests the same kinematics and law.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.continuum.membrane import check_displacements, membrane
from gelcone.continuum.mesh import check_radius_ratio, import_skfem
from gelcone.continuum.path import Ending
from gelcone.errors import InputError
from gelcone.physics.film.pull_in import DEFAULT_RADIUS_RATIO
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array, Quantity

if TYPE_CHECKING:
    import xarray as xr

THICKNESS = Quantity("t", "mounted thickness over the width of the film, H/(b-a)", 0.01, positive=True)
DEFAULT_ELEMENTS = (60, 2)
"""Along the radius and through the thickness."""
QUADRATURE_ORDER = 5
MOST_ITERATIONS = 30
TOLERANCE = 1e-11
"""Residual forces of an equilibrium, over the largest force of an element on a node."""


@dataclass(frozen=True, eq=False)
class Solid:
    """A film cut into quadrilateral rings.

    ``gradient`` (elements, points, 6, 22) maps an element's unknowns to grad u, f - 1 and p; ``weight`` (elements,
    points) integrates over the film's volume; ``unknowns`` (elements, 22). ``place`` (2, nodes) holds R - a and Z of
    the nodes of u and w, whose unknowns come first; ``corners`` (2, pressures) those of the pressures.
    """

    model: ConeModel
    disc: float
    thickness: float
    gradient: Array
    weight: Array
    unknowns: Any
    place: Array
    corners: Array

    @property
    def free(self) -> Any:
        """The unknowns that are neither on the disc nor on the rim."""
        held = (self.place[0] <= 0.0) | (self.place[0] >= 1.0)
        return np.flatnonzero(~np.concatenate([held, held, np.zeros(self.corners.shape[1], dtype=bool)]))


def solid(
    model: ConeModel,
    radius_ratio: float = DEFAULT_RADIUS_RATIO,
    *,
    displacements: npt.ArrayLike,
    thickness: npt.ArrayLike = THICKNESS.default,
    elements: tuple[int, int] = DEFAULT_ELEMENTS,
) -> xr.Dataset:
    """Force over displacement of the film as a solid, and of the membrane for comparison, without voltage.

    Parameters
    ----------
    model : one actuator; its law and pre-stretches play a part.
    radius_ratio : a/b, between 0 and 1. Default 0.2.
    displacements : x = h/(b-a) at which the disc is held, not 0, one number or shape (displacement,).
    thickness : t = H/(b-a), positive, one number or shape (thickness,). Default 0.01.
    elements : along the radius and through the thickness. Default 60 and 2.

    Returns
    -------
    Dataset over ``thickness`` and ``displacement``: ``force`` per mu Vol/(b-a), ``membrane_force``, ``deviation`` (the
    membrane's force over the solid's, less 1) and ``ending``, `Ending.CONVERGED` or `Ending.NOT_CONVERGED` with NaN.

    Raises
    ------
    InputError : for a thickness that is not positive, an ensemble, or a disc larger than the film.
    MissingDependency : without scikit-fem.
    """
    x = check_displacements(displacements)
    if (x == 0.0).any():
        raise InputError("displacements: 0 needs no force by symmetry; leave it out")
    t = np.atleast_1d(THICKNESS.check("thickness", thickness))
    if model.shape:
        raise InputError(f"a model of the shape {model.shape}: one actuator is solved at a time; take its members")
    shape = membrane(model, radius_ratio, displacements=x).isel(constant_voltage=0)
    force = np.full((t.size, x.size), np.nan)
    for i, thick in enumerate(t):
        body = mesh_solid(model, radius_ratio, float(thick), elements)
        for j, place in enumerate(x):
            force[i, j] = np.sign(place) * held_at(body, shape.isel(displacement=j), abs(float(place)))
    at = ("thickness", "displacement")
    expected = np.broadcast_to(shape["force"].values, force.shape)
    ending = np.where(np.isfinite(force), Ending.CONVERGED, Ending.NOT_CONVERGED).astype(np.int8)
    result = dataset.label(
        model,
        {
            "force": (at, force, "static force of the solid film on the disc", "force"),
            "membrane_force": (at, expected, "static force of the membrane on the disc", "force"),
            "deviation": (at, expected / force - 1.0, "force of the membrane over that of the solid, less 1", "ratio"),
            "ending": (at, ending, "how the search for the point ended", "flag"),
        },
        coords={
            "thickness": (("thickness",), t, THICKNESS.meaning, "length"),
            "displacement": (("displacement",), x, "displacement x = h/(b-a)", "length"),
        },
        options={"radius_ratio": float(radius_ratio), "elements": list(elements)},
        title="film as a solid",
    )
    result["ending"].attrs |= {
        "flag_values": np.array([e.value for e in Ending], dtype=np.int8),
        "flag_meanings": " ".join(e.name.lower() for e in Ending),
    }
    return result


def mesh_solid(model: ConeModel, radius_ratio: float, thickness: float, elements: tuple[int, int]) -> Solid:
    """The flat film as mounted, with finer elements towards disc and rim, where its faces are held."""
    skfem = import_skfem()
    ratio = check_radius_ratio(radius_ratio)
    if len(elements) != 2 or any(not isinstance(n, int) or n < 1 for n in elements):
        raise InputError(
            f"elements = {elements!r}: must be two whole numbers, along the radius and through the thickness"
        )
    disc = ratio / (1.0 - ratio)
    along = 0.5 - 0.5 * np.cos(np.pi * np.linspace(0.0, 1.0, elements[0] + 1))
    mesh = skfem.MeshQuad.init_tensor(along, thickness * np.linspace(-0.5, 0.5, elements[1] + 1))
    wide = skfem.Basis(mesh, skfem.ElementQuad2(), intorder=QUADRATURE_ORDER)
    narrow = skfem.Basis(mesh, skfem.ElementQuad1(), intorder=QUADRATURE_ORDER)
    radius = disc + wide.mapping.F(wide.X)[0]
    gradient = np.zeros((*radius.shape, 6, 22))
    for k, (shape,) in enumerate(wide.basis):
        gradient[..., 0, k] = gradient[..., 2, 9 + k] = shape.grad[0]
        gradient[..., 1, k] = gradient[..., 3, 9 + k] = shape.grad[1]
        gradient[..., 4, k] = np.asarray(shape) / radius
    for k, (shape,) in enumerate(narrow.basis):
        gradient[..., 5, 18 + k] = np.asarray(shape)
    u, p = wide.element_dofs.T, narrow.element_dofs.T
    return Solid(
        model=model,
        disc=disc,
        thickness=thickness,
        gradient=gradient,
        weight=wide.dx * 2.0 * radius / ((2.0 * disc + 1.0) * thickness),
        unknowns=np.concatenate([u, wide.N + u, 2 * wide.N + p], axis=1),
        place=wide.doflocs,
        corners=narrow.doflocs,
    )


def held_at(body: Solid, shape: xr.Dataset, height: float) -> float:
    """The force that holds the disc at a height, by Newton's method from the membrane; NaN if it does not converge."""
    from scipy.sparse import csc_matrix
    from scipy.sparse.linalg import splu

    if int(shape["ending"]) != Ending.CONVERGED:
        return float("nan")
    position, free = membrane_guess(body, shape, height), body.free
    for _ in range(MOST_ITERATIONS):
        found = assembled(body, position)
        if found is None:
            return float("nan")
        internal, scale, entries = found
        if np.abs(internal[free]).max() <= TOLERANCE * scale:
            on_disc = body.place.shape[1] + np.flatnonzero(body.place[0] <= 0.0)
            return float(internal[on_disc].sum())
        stiffness = csc_matrix(entries, shape=(position.size, position.size))[free][:, free]
        step = np.zeros_like(position)
        step[free] = -splu(stiffness).solve(internal[free])
        for _ in range(6):
            if assembled(body, position + step) is not None:
                break
            step *= 0.5
        position = position + step
    return float("nan")


def membrane_guess(body: Solid, shape: xr.Dataset, height: float) -> Array:
    """The membrane's shape, thickened along its normal, and the pressure that leaves its faces free."""
    c = body.model.numbers()
    mounted = shape["mounted_radius"].values
    middle = np.stack([shape["radius"].values - mounted, np.abs(shape["height"].values)])
    meridian = np.gradient(np.stack([mounted, 0.0 * mounted]) + middle, mounted, axis=1)
    m, n = np.sum(meridian**2, axis=0), (1.0 + middle[0] / mounted) ** 2
    thin = 1.0 / np.sqrt(m * n)
    pressure = body.model.gel_law().response(c["A"] * m + c["B"] * n + c["G"] / (m * n) - 3.0, c) * c["G"] * thin**2
    normal = np.stack([-meridian[1], meridian[0]]) / np.sqrt(m)
    s, z = body.place
    # the held faces do not turn: the normal tilts within a thickness of them
    tilt = 1.0 - np.exp(-np.minimum(s, 1.0 - s) / body.thickness)
    u, w, nr, nz = (np.interp(s, mounted - body.disc, v) for v in (*middle, *(thin * normal)))
    w[s <= 0.0] = height
    return np.concatenate(
        [u + z * nr * tilt, w + z * (nz - 1.0) * tilt, np.interp(body.corners[0], mounted - body.disc, pressure)]
    )


def assembled(body: Solid, position: Array) -> tuple[Array, float, Any] | None:
    """Derivative of the energy, the largest force of an element on a node, and the entries of the second derivative;
    None beyond the stretch limit or with an element turned inside out."""
    c, law = body.model.numbers(), body.model.gel_law()
    unmoved = np.array([1.0, 0.0, 0.0, 1.0, 1.0, 0.0])
    e = unmoved + np.einsum("epij,ej->epi", body.gradient, position[body.unknowns])
    f11, f12, f21, f22, hoop, pressure = np.moveaxis(e, 2, 0)
    weights = np.array([c["A"], c["G"], c["A"], c["G"], c["B"], 0.0], dtype=float)
    invariant = np.sum(weights * e**2, axis=2) - 3.0
    plane = f11 * f22 - f12 * f21
    if not (np.isfinite(position).all() and plane.min() > 0.0 and hoop.min() > 0.0):
        return None
    if not (invariant < law.strain_limit(c)).all():
        return None
    response, slope = (np.broadcast_to(g(invariant, c), plane.shape) for g in (law.response, law.response_slope))
    volume = np.stack([f22 * hoop, -f21 * hoop, -f12 * hoop, f11 * hoop, plane, 0.0 * plane], axis=2)
    first = response[..., None] * weights * e - pressure[..., None] * volume
    first[..., 5] = -(plane * hoop - 1.0)
    by = 2.0 * weights * e
    second = 0.5 * slope[..., None, None] * by[..., :, None] * by[..., None, :]
    second += response[..., None, None] * np.diag(weights)
    # second derivatives of det F f, times -p
    for i, j, part in (
        (0, 3, hoop),
        (1, 2, -hoop),
        (0, 4, f22),
        (1, 4, -f21),
        (2, 4, -f12),
        (3, 4, f11),
    ):
        second[..., i, j] -= pressure * part
        second[..., j, i] -= pressure * part
    second[..., 5, :] -= volume
    second[..., :, 5] -= volume
    count = len(e)
    flat = body.gradient.reshape(count, -1, 22)
    each = np.einsum("eij,ei->ej", flat, (body.weight[..., None] * first).reshape(count, -1))
    stiff = flat.transpose(0, 2, 1) @ (body.weight[..., None, None] * (second @ body.gradient)).reshape(count, -1, 22)
    internal: Array = np.bincount(body.unknowns.ravel(), each.ravel(), position.size).astype(float)
    row = np.repeat(body.unknowns[:, :, None], 22, axis=2).ravel()
    column = np.repeat(body.unknowns[:, None, :], 22, axis=1).ravel()
    return internal, float(np.abs(each).max()), (stiff.ravel(), (row, column))
