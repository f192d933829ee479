"""Studies of figure 13: ranges, names, and what theory says of rest."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from gelcone.paper.effort import FULL, QUICK
from gelcone.paper.studies import diagrams as module
from gelcone.paper.studies.diagrams import PANELS, STUDIES, diagram, diagram_name, rest_stability, values_of
from gelcone.presets import find_preset

TINY = replace(QUICK, name="tiny", diagram_values=3, sweeps=(), patience=300.0, bisections=1, window=40.0)


@pytest.mark.parametrize(
    ("parameter", "low", "high"),
    [("damping_ratio", 0.0, 2.0), ("voltage", 0.0, 2.0), ("prestretch", 0.4, 2.0), ("stretch_limit", 0.52, 100.0)],
)
def test_ranges(parameter, low, high):
    values = values_of("fast", parameter, FULL)
    assert (values[0], values[-1], values.size) == (pytest.approx(low), pytest.approx(high), 201)
    denser = values_of("base", parameter, FULL).size
    assert denser == (401 if parameter == "voltage" else 201)
    steps = np.diff(np.log(values) if parameter == "stretch_limit" else values)
    np.testing.assert_allclose(steps, steps[0])


def test_every_set_has_a_panel_for_every_parameter():
    assert {diagram_name(*panel) for panel in PANELS} == {
        f"diagram-{name}-{parameter}"
        for name in ("base", "fast")
        for parameter in ("damping-ratio", "voltage", "prestretch", "stretch-limit")
    }
    assert PANELS["base", "damping_ratio"] == 0.5
    assert PANELS["base", "stretch_limit"] == 1.04
    assert {voltage for (name, _), voltage in PANELS.items() if name == "fast"} == {1.005}


def test_rest_is_lost_statically_at_the_root_of_the_stiffness():
    kappa = float(find_preset("base").model.spring_stiffness)
    model = find_preset("base").model.replace(voltage=np.array([0.1, 0.99 * kappa**0.5, 1.01 * kappa**0.5]))
    found = rest_stability(model.members(), ("voltage",), model.shape)
    dims, stiffness, attrs = found["static_stiffness"]
    np.testing.assert_allclose(stiffness, kappa - model.voltage**2)
    assert (dims, attrs["quantity"]) == (("voltage",), "stiffness")
    growth = found["rest_growth"][1]
    # a small drive leaves the growth of free motion, the damping
    assert growth[0] == pytest.approx(-float(np.asarray(model.damping_ratio).flat[0]), rel=1e-2)


def test_a_diagram_holds_the_long_run_and_the_window():
    found = diagram("base", "damping_ratio", TINY, lambda share: None)
    assert found["finite"].dims == ("damping_ratio", "exponent")
    np.testing.assert_allclose(found["finite"].sum("exponent"), -2.0 * found["damping_ratio"], atol=1e-6)
    assert found.attrs["preset"] == "base"
    assert found.attrs["window"] == 40.0
    assert [str(name) for name in found["branch"].values] == ["from 1,0"]
    assert "0.5" in found.attrs["model"]


@pytest.mark.parametrize(("parameter", "film"), [("voltage", "taut"), ("voltage", "wrinkling"), ("prestretch", "taut")])
def test_a_panel_asks_for_its_voltage_its_effort_and_over_the_voltage_of_the_papers_film_for_branches(
    monkeypatch, parameter, film
):
    """The doublings are those of the attached branches; theory and window are of the members of the panel."""
    monkeypatch.setitem(PANELS, ("fast", parameter), 0.77)
    asked, shares = {}, []
    effort = replace(TINY, film=film, sweeps=("up",), bisections=7)
    values = values_of("fast", parameter, effort)

    def bifurcation(model, name, values, **options):
        asked.update(model=model, values=values, options=options)
        options.pop("progress")(1.0)
        return xr.Dataset(coords={name: values})

    def finite(members, states, window, options):
        asked.update(members=members, states=states, window=window)
        return np.stack([members.values[parameter], -members.values[parameter]], axis=1), None

    def theory(members, dims, shape):
        asked.update(dims=dims, shape=shape)
        return {"rest_growth": (dims, 2.0 * members.values[parameter])}

    monkeypatch.setattr(module, "bifurcation", bifurcation)
    monkeypatch.setattr(module, "finite_exponents", finite)
    monkeypatch.setattr(module, "rest_stability", theory)
    monkeypatch.setattr(module, "attached_branches", lambda result: "branches" if parameter == "voltage" else None)
    monkeypatch.setattr(module, "cascade", lambda model, followed: {"doubling": ("doubling", [float(model.voltage)])})
    found = diagram("fast", parameter, effort, shares.append)
    preset = effort.preset("fast")
    assert shares == [1.0]
    assert float(asked["model"].voltage) == 0.77
    assert asked["model"].film.name == film
    np.testing.assert_array_equal(asked["values"], values)
    assert asked["options"] == {
        "initial": preset.initial, "sweeps": ("up",), "bisections": 7, "patience": 300.0,
        "branches": (parameter, film) == ("voltage", "taut"),
    }  # fmt: skip
    np.testing.assert_array_equal(asked["states"][:, :2], np.broadcast_to(preset.initial, (values.size, 2)))
    np.testing.assert_array_equal(found["finite"], np.stack([values, -values], axis=1))
    assert (asked["window"], asked["dims"], found.attrs["window"]) == (40.0, (parameter,), 40.0)
    assert asked["shape"] == values.shape
    np.testing.assert_array_equal(found["rest_growth"], 2.0 * values)
    if parameter == "voltage":
        assert found["doubling"].values.tolist() == [0.77]
    assert ("doubling" in found) == (parameter == "voltage")
    assert found.attrs["preset"] == "fast"


def test_panels_that_claims_judge_with_the_film_that_creeps_are_computed_with_it():
    films = {study.name: study.films for study in STUDIES}
    crept = {name for name, own in films.items() if "creeping" in own}
    assert crept == {"diagram-base-voltage", "diagram-fast-voltage", "diagram-base-damping-ratio"}
    assert all("wrinkling" in own for own in films.values())
    assert [study.name for study in STUDIES] == [diagram_name(*panel) for panel in PANELS]
