"""The film as a solid of finite thickness: its forces, and the membrane that it becomes."""

import numpy as np
import pytest

pytest.importorskip("skfem")

from gelcone.continuum.path import Ending
from gelcone.errors import InputError
from gelcone.physics.model import ConeModel
from tests.continuum.films import EQUIBIAXIAL, MODELS
from tests.continuum.solid import assembled, mesh_solid, solid


@pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)
def test_the_tangent_of_the_solid_is_the_gradient_of_its_forces(model):
    body = mesh_solid(model, 0.3, 0.1, (3, 1))
    size = body.unknowns.max() + 1
    position = 0.01 * np.random.default_rng(5).standard_normal(size)
    _, _, (values, places) = assembled(body, position)
    stiffness = np.zeros((size, size))
    np.add.at(stiffness, places, values)
    np.testing.assert_allclose(stiffness, stiffness.T, atol=1e-12)
    step = 1e-6 * np.random.default_rng(6).standard_normal(size)
    change = assembled(body, position + step)[0] - assembled(body, position - step)[0]
    np.testing.assert_allclose(2.0 * stiffness @ step, change, atol=1e-6 * np.abs(change).max())


@pytest.mark.parametrize("parameters", [{}, EQUIBIAXIAL, {"law": "neo-hookean"}])
def test_the_thin_solid_is_the_membrane(parameters):
    x = [-1.0, 0.5, 1.0, 2.0]
    result = solid(ConeModel(**parameters), 0.2, displacements=x, thickness=[0.008, 0.004])
    assert (result["ending"] == Ending.CONVERGED).all()
    deviation = result["deviation"].values
    assert np.abs(deviation).max() < 0.01
    assert deviation[0, 0] == pytest.approx(deviation[0, 2], rel=1e-9)
    # bending and the held faces add stiffness in proportion to the thickness
    np.testing.assert_allclose(deviation[0] / deviation[1], 2.0, rtol=0.08)
    assert (deviation < 0.0).all()


def test_the_solid_refuses_what_it_cannot_solve():
    for options, told in (
        ({"displacements": 1.0, "thickness": 0.0}, "thickness = 0: must be greater than 0"),
        ({"displacements": 0.0}, "0 needs no force"),
        ({"displacements": 1.0, "elements": (3, 0)}, "must be two whole numbers"),
        ({"displacements": 1.0, "radius_ratio": 1.1}, "must lie between 0 and 1"),
    ):
        with pytest.raises(InputError, match=told):
            solid(ConeModel(), **options)
    with pytest.raises(InputError, match="one actuator is solved at a time"):
        solid(ConeModel(prestretch=[1.0, 1.1]), displacements=1.0)
