"""The maps of figure 14: what is asked of sweep, windows and theory, and where their numbers come to stand."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from gelcone.paper.effort import QUICK
from gelcone.paper.studies import diagrams
from gelcone.paper.studies import maps as module
from gelcone.paper.studies.maps import STUDIES
from gelcone.presets import find_preset

TINY = replace(QUICK, map_shape=(3, 17), window=40.0, patience=77.0)
VOLTAGES, STRETCHES = np.array([0.0, 1.0, 2.0]), np.linspace(0.4, 2.0, 17)


@pytest.mark.parametrize("mode", ["radial", "equibiaxial"])
def test_a_map_has_the_sweep_the_window_and_the_theory_of_each_cell(monkeypatch, mode):
    """Every part gives numbers by which its cells are known; sections are stored of some rows."""
    asked, shares = {}, []
    cells = VOLTAGES[:, None] + 100.0 * STRETCHES

    def sweep(plan, keep, progress):
        asked.update(plan=plan, keep=keep)
        progress(1.0)
        own = {"voltage": plan.over["voltage"], "prestretch": plan.over["prestretch"]}
        section = cells[..., None, None] + np.array([0.25, 0.5])
        data = {"regime": (tuple(own), cells), "status": 1, "source": 2}
        return xr.Dataset(data | {"section": ((*own, "point", "state"), section)}, coords=own)

    def finite(members, states, window, options):
        asked.update(states=states, window=window, options=options, mode=members.system.film.prestretch_mode)
        n = members.values
        return np.stack([n["voltage"] + 100.0 * n["prestretch"], n["voltage"] - 1.0], axis=1), "running"

    def theory(members, dims, shape):
        asked.update(dims=dims, theory=members.system.film.prestretch_mode)
        here = (members.values["voltage"] + 100.0 * members.values["prestretch"]).reshape(shape)
        return {
            name: (dims, sign * here, {"long_name": name})
            for name, sign in (("rest_growth", 2.0), ("static_stiffness", -1.0))
        }

    monkeypatch.setattr(module, "sweep", sweep)
    monkeypatch.setattr(diagrams, "finite_exponents", finite)
    monkeypatch.setattr(diagrams, "rest_stability", theory)
    (study,) = (study for study in STUDIES if study.name == f"map-{mode}")
    found = study.compute(TINY, shares.append)
    assert sum(shares) == pytest.approx(1.0)
    base, plan = find_preset("base"), asked["plan"]
    assert (asked["keep"], asked["window"], asked["options"]) == (["section"], 40.0, {})
    assert plan.options == {"patience": 77.0}
    assert plan.model.prestretch_mode == asked["mode"] == mode
    np.testing.assert_allclose(plan.over["voltage"], VOLTAGES)
    np.testing.assert_allclose(plan.over["prestretch"], STRETCHES)
    np.testing.assert_array_equal(asked["states"], np.broadcast_to(base.initial, (51, 2)))
    assert asked["theory"] == mode
    assert asked["dims"] == ("voltage", "prestretch")
    assert float(plan.model.damping_ratio) == float(base.model.damping_ratio)
    assert found["finite"].dims == ("voltage", "prestretch", "exponent")
    np.testing.assert_allclose(found["finite"][..., 0], cells)
    np.testing.assert_allclose(found["finite"][..., 1], np.broadcast_to(VOLTAGES[:, None] - 1.0, cells.shape))
    assert found["finite"].attrs["quantity"] == "rate"
    np.testing.assert_allclose(found["rest_growth"], 2.0 * cells)
    np.testing.assert_allclose(found["static_stiffness"], -cells)
    np.testing.assert_allclose(found["regime"], cells)
    near = [0.6, 0.8, 1.0, 1.2, 1.5]
    np.testing.assert_allclose(found["stacked_prestretch"], near)
    section = found["section"].transpose("voltage", "stacked_prestretch", "point", "state")[:, :, 0]
    np.testing.assert_allclose(section[..., 0], VOLTAGES[:, None] + 100.0 * np.array(near) + 0.25)
    np.testing.assert_allclose(section[..., 1] - section[..., 0], 0.25)
    assert not {"status", "source"} & set(found.variables)
    title = {"title": "parameter map", "preset": "base", "prestretch_mode": mode, "window": 40.0}
    assert found.attrs == title
