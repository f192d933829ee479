"""Force curves and energies of the paper by the formulas of a film that is not pre-stretched."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from gelcone.paper.effort import QUICK
from gelcone.paper.studies import statics as module
from gelcone.paper.studies.study import reach_of

MODEL = QUICK.preset("fast").model


@pytest.mark.parametrize("limit", [1.0, 5.0, 100.0])
def test_the_reach_of_a_film_is_where_its_strain_meets_the_limit(limit):
    model = MODEL.replace(stretch_limit=np.array([limit]))
    (reach,) = reach_of(model)
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
        reach = float(reach_of(model.replace(stretch_limit=np.array([limit])))[0])
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
    alone = MODEL.replace(stretch_limit=50.0, spring_stiffness=0.0, film="taut")
    assert float(MODEL.spring_stiffness) > 0.0
    np.testing.assert_allclose(force[row][middle], alone.force(x[middle]), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(energy[row][middle], alone.energy(x[middle]), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(found["reach"], reach_of(MODEL.replace(stretch_limit=np.array(module.LIMITS))))


@pytest.mark.parametrize("film", ["taut", "wrinkling"])
def test_static_curves_are_those_of_the_table_and_slack_is_marked_at_its_voltage(monkeypatch, film):
    asked, shares = {}, []
    x = np.array([-1.0, 0.2, 1.0])

    def curves(model, voltages):
        asked.update(model=model, voltages=voltages)
        return xr.Dataset(coords={"displacement": x, "constant_voltage": list(voltages)})

    def slack(model, x, voltage):
        return (x + voltage) > 1.0

    monkeypatch.setattr(module, "static_curves", curves)
    monkeypatch.setattr(module, "_slack", slack)
    found = module.static(replace(QUICK, film=film), shares.append)
    assert asked["voltages"] == (0.0, 1.0, 1.5)
    assert asked["model"].film.name == film
    assert float(asked["model"].spring_stiffness) == float(QUICK.preset("table1").model.spring_stiffness)
    np.testing.assert_array_equal(found["slack"], [[0, 0, 0], [0, 1, 1], [0, 1, 1]])
    assert found["slack"].dims == ("constant_voltage", "displacement")
    assert (found.attrs["preset"], found.attrs["parameter"], shares) == ("table1", "constant_voltage", [1.0])


def test_surfaces_hold_the_spring_and_no_voltage():
    """At rest and flat nothing; on the axis of the displacement the energy of the model itself, spring included."""
    found = module._surfaces(MODEL)
    x = found["surface_displacement"][1]
    total = found["surface_energy"][1]
    at = int(np.argmin(np.abs(x - 0.5)))
    still = int(np.argmin(np.abs(found["surface_velocity"][1])))
    for k, limit in enumerate((1.0, 100.0)):
        own = MODEL.replace(stretch_limit=limit)
        film = float(own.replace(spring_stiffness=0.0).energy(x[at]))
        spring = 0.5 * float(MODEL.spring_stiffness) * x[at] ** 2
        assert total[k, at, still] == pytest.approx(film + spring, rel=1e-12)
    assert (x[0], x[-1], x.size) == (-3.0, 3.0, 301)
