"""Energy, forces and tangent of the film as a geometrically exact membrane, cut into rings.

Lengths are in b - a, energies per mu Vol with Vol = pi (b^2 - a^2) H, so that forces compare with `ConeModel.force`.
The mounted film is the flat annulus a <= R <= b under the model's pre-stretches. It moves to the radius r = R + u and
the height w, with the stretches from the mounted state

    squared, m = (1 + u')^2 + w'^2 along the meridian and n = (1 + u/R)^2 along the hoop.

The true stretches are l1 = lm sqrt(m), l2 = lh sqrt(n), l3 = 1/(l1 l2), and with A = lm^2, B = lh^2, G = 1/(A B)

    energy = integral of W(I1 - 3) - v^2 m n/2 over 2 R dR/(b^2 - a^2),    I1 - 3 = A m + B n + G/(m n) - 3.

The voltage enters as in the cone: v = Phi sqrt(eps/mu)/H with the mounted thickness H, and m n is the square of the
deformed over the mounted area. A homogeneous cone has m = q and n = 1 and has the energy of the cone model.

The rings are quadratic finite elements (scikit-fem's mesh, shape functions and quadrature). Unknowns are u and w of
every node from the disc outwards, interleaved, so that the tangent is a band matrix.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gelcone.continuum import density
from gelcone.continuum.density import Derivatives
from gelcone.devices.analysis import check_one
from gelcone.errors import InputError, MissingDependency
from gelcone.physics.component import Numbers
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

BAND = 5
"""Half bandwidth of the tangent: three nodes per element, two unknowns per node."""
QUADRATURE_ORDER = 6
"""Degree of polynomials that are integrated exactly; less than 5 would lower the order of the elements."""
SLACK_STIFFNESS = 1e-6
"""Stiffness over mu of the net that determines the position of slack rings; forces of its size count as zero."""
VOLTAGE_STEP = 1e-7
"""Step of v^2 for derivatives by differences."""
NARROWEST = 1e-9
"""Smallest 1 - a/b and a/b: beyond, the radii cannot be distinguished in double precision."""


class Forces(NamedTuple):
    """Forces on the nodes: ``internal`` (unknowns,), the derivative of the energy; ``scale``, the largest force of one
    ring on a node; ``least`` and ``most``, the extremes of the meridional force over its stretch, negative under
    compression; ``density``, the derivatives of the energy density, (elements, points)."""

    internal: Array
    scale: float
    least: float
    most: float
    density: Derivatives


@dataclass(frozen=True, eq=False)
class Film:
    """A film cut into rings; `mesh_film` makes one.

    ``model`` is a single actuator, ``coefficients`` its numbers in the formulas. A ``relaxed`` film wrinkles rather
    than bear compression, on a net of stiffness ``net``. ``place`` (nodes,) is (R - a)/(b - a).
    ``gradient`` (elements, points, 3, 6) maps an element's unknowns to u', w' and u/R; ``weight`` (elements, points)
    integrates over the film's volume; ``unknowns`` (elements, 6). ``at_nodes`` is ``gradient`` at an element's nodes.
    """

    model: ConeModel
    coefficients: Numbers
    relaxed: bool
    net: float
    radius_ratio: float
    place: Array
    gradient: Array
    weight: Array
    unknowns: Any
    at_nodes: Array

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return 2 * self.place.size

    @property
    def disc(self) -> float:
        """Radius of the disc in b - a."""
        return self.radius_ratio / (1.0 - self.radius_ratio)

    @property
    def radius(self) -> Array:
        """Mounted radius of the nodes in b - a."""
        return self.disc + self.place


def import_skfem() -> Any:
    """The scikit-fem module; raises `MissingDependency` with the command that installs it."""
    try:
        import skfem
    except ImportError as error:
        raise MissingDependency(f"the finite elements need scikit-fem ({error}); pip install 'gelcone[fem]'") from None
    return skfem


def check_radius_ratio(value: Any) -> float:
    """a/b as a float; `InputError` when the disc is not smaller than the film."""
    if isinstance(value, str | bytes | bool) or np.ndim(value) > 0 or np.asarray(value).dtype.kind not in "iuf":
        raise InputError(f"radius_ratio = {value!r}: must be one number, the disc's radius over the film's")
    ratio = float(value)
    if not NARROWEST <= ratio <= 1.0 - NARROWEST:
        raise InputError(
            f"radius_ratio = {ratio:g}: must lie between 0 and 1, for a disc of radius a in a film clamped at a "
            "larger radius b"
        )
    return ratio


def mesh_film(model: ConeModel, radius_ratio: float = 0.2, elements: int = 200, *, relaxed: bool = False) -> Film:
    """The flat film as mounted, cut into rings whose radii grow by a constant factor.

    Raises `InputError` for an ensemble, a disc as large as the film or fewer than 2 elements.
    """
    skfem = import_skfem()
    check_one(model, "mesh_film")
    ratio = check_radius_ratio(radius_ratio)
    if not isinstance(elements, int | np.integer) or isinstance(elements, bool) or elements < 2:
        raise InputError(f"elements = {elements!r}: must be a whole number, at least 2")
    disc = ratio / (1.0 - ratio)
    # stresses grow as 1/R towards the disc, hence the finer rings there; expm1 keeps the places exact for a narrow film
    ends = disc * np.expm1(np.linspace(0.0, 1.0, elements + 1) * np.log1p(1.0 / disc))
    ends[-1] = 1.0
    mesh = skfem.MeshLine(ends)
    basis = skfem.Basis(mesh, skfem.ElementLineP2(), intorder=QUADRATURE_ORDER)
    nodal = skfem.Basis(mesh, skfem.ElementLineP2(), quadrature=(np.array([[0.0, 1.0, 0.5]]), np.ones(3)))
    rank = np.argsort(np.argsort(basis.doflocs[0]))[basis.element_dofs].T
    radius = disc + basis.mapping.F(basis.X)[0]
    return Film(
        model=model,
        coefficients=model.numbers(),
        relaxed=relaxed,
        net=SLACK_STIFFNESS,
        radius_ratio=ratio,
        place=np.sort(basis.doflocs[0]),
        gradient=_gradient(basis, disc),
        weight=basis.dx * 2.0 * radius / (2.0 * disc + 1.0),
        unknowns=np.stack([2 * rank, 2 * rank + 1], axis=2).reshape(len(rank), 6),
        at_nodes=_gradient(nodal, disc),
    )


def _gradient(basis: Any, disc: float) -> Array:
    """u', w' and u/R of the unknowns of each element, shape (elements, points, 3, 6)."""
    radius = disc + basis.mapping.F(basis.X)[0]
    gradient = np.zeros((*radius.shape, 3, 6))
    for k, (shape,) in enumerate(basis.basis):
        gradient[..., 0, 2 * k] = gradient[..., 1, 2 * k + 1] = shape.grad[0]
        gradient[..., 2, 2 * k] = np.asarray(shape) / radius
    return gradient


def interpolated(film: Film, values: Array, places: Array) -> Array:
    """Nodal values of quadratic elements at other places."""
    ends = film.place[::2]
    element = np.clip(np.searchsorted(ends, places, side="right") - 1, 0, ends.size - 2)
    t = (places - ends[element]) / (ends[element + 1] - ends[element])
    first, middle, last = (values[2 * element + k] for k in range(3))
    return np.asarray(first * (1 - t) * (1 - 2 * t) + middle * 4 * t * (1 - t) + last * t * (2 * t - 1))


# --- the energy and its derivatives ----------------------------------------------------------------------------------


def strain(film: Film, m: Any, n: Any) -> Any:
    """I1 - 3 at the squared stretches from the mounted state."""
    return density.strain(film.coefficients, m, n)


def derivatives(film: Film, m: Any, n: Any, squared: float) -> Derivatives:
    """Derivatives of the energy density by m and n at v^2 = ``squared``."""
    law, c = film.model.gel_law(), film.coefficients
    if film.relaxed:
        return density.relaxed_derivatives(law, c, m, n, squared, film.net)
    return density.derivatives(law, c, m, n, squared)


def stretches(film: Film, position: Array, gradient: Array | None = None) -> tuple[Any, Any, Any]:
    """1 + u', w' and 1 + u/R, each (elements, points); at the quadrature points unless another gradient is given."""
    gradient = film.gradient if gradient is None else gradient
    moved = np.einsum("epij,ej->epi", gradient, position[film.unknowns])
    return 1.0 + moved[..., 0], moved[..., 1], 1.0 + moved[..., 2]


def reachable(film: Film, position: Array) -> bool:
    """True if every ring is inside the stretch limit and none is turned inside out."""
    along, up, hoop = stretches(film, position)
    if not (np.isfinite(position).all() and hoop.min() > 0.0):
        return False
    m, n = along * along + up * up, hoop * hoop
    with np.errstate(all="ignore"):
        return bool(np.all(strain(film, m, n) < film.model.gel_law().strain_limit(film.coefficients)))


def energy(film: Film, position: Array, squared: float) -> float:
    """Energy of the film per mu Vol, less the work of the voltage source."""
    along, up, hoop = stretches(film, position)
    law, c, m, n = film.model.gel_law(), film.coefficients, along * along + up * up, hoop * hoop
    each = (
        density.relaxed_value(law, c, m, n, squared, film.net) if film.relaxed else density.value(law, c, m, n, squared)
    )
    return float(np.sum(film.weight * each))


def forces(film: Film, position: Array, squared: float) -> Forces:
    """Forces on the nodes: the derivative of `energy` with respect to the unknowns."""
    along, up, hoop = stretches(film, position)
    phi = derivatives(film, along * along + up * up, hoop * hoop, squared)
    return _assembled(film, along, up, hoop, phi)


def _assembled(film: Film, along: Any, up: Any, hoop: Any, phi: Derivatives) -> Forces:
    """Forces of the derivatives ``phi`` at the `stretches`."""
    pull = np.stack([phi.m * along, phi.m * up, phi.n * hoop], axis=-1) * (2.0 * film.weight)[..., None]
    each = np.einsum("epij,epi->ej", film.gradient, pull)
    internal: Array = np.bincount(film.unknowns.ravel(), each.ravel(), film.size).astype(float)
    return Forces(internal, float(np.abs(each).max()), float(phi.m.min()), float(phi.m.max()), phi)


def electric_forces(film: Film, position: Array, squared: float, now: Forces) -> Array:
    """Derivative of `forces` with respect to v^2; ``now`` are the forces at the position."""
    along, up, hoop = stretches(film, position)
    m, n, zero = along * along + up * up, hoop * hoop, np.zeros_like(hoop)
    if film.relaxed:
        # free widths change with the voltage, too; a difference is accurate enough to predict steps along a load
        near, far = now.density, derivatives(film, m, n, squared + VOLTAGE_STEP)
        phi = Derivatives((far.m - near.m) / VOLTAGE_STEP, (far.n - near.n) / VOLTAGE_STEP, zero, zero, zero)
    else:
        phi = Derivatives(-0.5 * n, -0.5 * m, zero, zero, zero)
    return _assembled(film, along, up, hoop, phi).internal


def tangent(film: Film, position: Array, squared: float, now: Forces | None = None) -> Array:
    """Derivative of `forces` with respect to the unknowns, as band matrix (2 BAND + 1, unknowns).

    ``now`` are the forces, if known. The derivative of force i by unknown j is in row BAND + i - j of column j.
    """
    along, up, hoop = stretches(film, position)
    phi = derivatives(film, along * along + up * up, hoop * hoop, squared) if now is None else now.density
    # m = along^2 + up^2 and n = hoop^2, hence these factors of the chain rule
    by = np.stack([2.0 * along, 2.0 * up, 2.0 * hoop], axis=-1)
    second = np.empty((*hoop.shape, 3, 3))
    second[..., :2, :2] = phi.mm[..., None, None]
    second[..., 2, :2] = second[..., :2, 2] = phi.mn[..., None]
    second[..., 2, 2] = phi.nn
    second *= by[..., :, None] * by[..., None, :]
    for k, first in enumerate((phi.m, phi.m, phi.n)):
        second[..., k, k] += 2.0 * first
    count = len(film.gradient)
    mapped = (film.weight[..., None, None] * (second @ film.gradient)).reshape(count, -1, 6)
    each = film.gradient.reshape(count, -1, 6).transpose(0, 2, 1) @ mapped
    row, column = film.unknowns[:, :, None], film.unknowns[:, None, :]
    flat = (BAND + row - column) * film.size + column
    band: Array = np.bincount(flat.ravel(), each.ravel(), (2 * BAND + 1) * film.size).astype(float)
    return band.reshape(2 * BAND + 1, film.size)
