"""Force curves and energies of the paper by the formulas of a film that is not pre-stretched."""

import numpy as np
import pytest

from gelcone.paper.effort import QUICK
from gelcone.paper.studies import statics as module

MODEL = QUICK.preset("fast").model


@pytest.mark.parametrize("limit", [1.0, 5.0, 100.0])
def test_the_reach_of_a_film_is_where_its_strain_meets_the_limit(limit):
    model = MODEL.replace(stretch_limit=np.array([limit]))
    (reach,) = module._reach(model)
    q = 1.0 + reach**2
    assert q + 1.0 / q - 2.0 == pytest.approx(limit, rel=1e-12)


def test_a_film_is_slack_where_either_stress_is_compressive():
    """Flat and not pre-stretched at any voltage; raised by the hoop first."""
    x = np.array([0.0, 0.5, 1.0])
    n = MODEL.own_numbers
    for voltage in (0.2, 0.6):
        state = MODEL.system.film.state(x, voltage, [], n)
        expected = (state.hoop_stress < 0.0) | (state.meridional_stress < 0.0)
        assert module._slack(MODEL, x, voltage).tolist() == expected.tolist()
    assert module._slack(MODEL, np.array([0.0]), 0.2).all()
    assert (state.meridional_stress[2] > 0.0) != (state.hoop_stress[2] > 0.0)


def test_energies_over_the_phase_plane_are_those_of_film_spring_and_motion():
    found = module._surfaces(MODEL)
    dims, total, _ = found["surface_energy"]
    limits, x, velocity = (found[f"surface_{name}"][1] for name in ("limit", "displacement", "velocity"))
    assert total.shape == (limits.size, x.size, velocity.size)
    assert [dim.removeprefix("surface_") for dim in dims] == ["limit", "displacement", "velocity"]
    for k, limit in enumerate(limits):
        model = MODEL.replace(stretch_limit=float(limit))
        reach = float(module._reach(model.replace(stretch_limit=np.array([limit])))[0])
        for i in (0, 75, 150, 180):
            if abs(x[i]) >= reach:
                assert np.isnan(total[k, i]).all()
                continue
            expected = float(model.energy(x[i])) + 0.5 * velocity**2
            np.testing.assert_allclose(total[k, i], expected, rtol=1e-12)


def test_the_force_of_a_film_is_the_slope_of_its_energy_and_leaves_out_the_spring():
    found = module.energy(QUICK, lambda share: None)
    x, energy, force = (found[name].values for name in ("displacement", "film_energy", "film_force"))
    row = int(np.argmax(np.array(module.LIMITS) == 50.0))
    middle = np.abs(x) < 2.0
    slope = np.gradient(energy[row][middle], x[middle])
    np.testing.assert_allclose(slope[5:-5], force[row][middle][5:-5], atol=2e-4)
    np.testing.assert_allclose(found["reach"], module._reach(MODEL.replace(stretch_limit=np.array(module.LIMITS))))
