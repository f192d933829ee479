"""Motions at three values of a parameter: what is stored of which window, in made-up runs."""

import json

import numpy as np
import pytest
import xarray as xr

from gelcone import ConeModel
from gelcone.codes import Outcome
from gelcone.paper.effort import QUICK
from gelcone.paper.studies import triples as module
from gelcone.paper.studies.diagrams import PANELS, values_of

MODEL = ConeModel(voltage=np.array([0.4, 0.5, 0.6]), voltage_bias=0.1, drive_frequency=2.0)
REPEAT = np.pi
"""Of a forcing with a bias at the frequency 2."""


@pytest.mark.parametrize("name", ["damping", "limit", "voltage", "prestretch"])
def test_three_motions_lie_on_the_diagram_of_their_parameter(name):
    """At its voltage and within its range, so that both show the same motions."""
    preset, parameter, values, changes = module.TRIPLES[name]
    assert changes == ({} if parameter == "voltage" else {"voltage": PANELS[preset, parameter]})
    diagram = values_of(preset, parameter, QUICK)
    assert diagram.min() <= min(values) < max(values) <= diagram.max()


def test_the_long_run_begins_once_all_have_settled_and_the_early_one_at_the_start(monkeypatch):
    asked = {}

    class Stop(Exception):
        """Ends the study where the runs are known."""

    def section(model, initial, *, repeats, discard, progress):
        asked.setdefault("sections", []).append((repeats, discard))
        return "points"

    def finite(members, states, window, options):
        asked["window"] = window
        raise Stop

    settled = xr.Dataset({"settled_time": ("member", [3.0 * REPEAT, 7.2 * REPEAT, 1.0])})
    monkeypatch.setattr(module, "kinds_of", lambda model, initial, effort: settled)
    monkeypatch.setattr(module, "section", section)
    monkeypatch.setattr(module, "finite_exponents", finite)
    with pytest.raises(Stop):
        module.motions(QUICK.preset("base"), MODEL, "voltage", QUICK, lambda share: None)
    early = int(QUICK.window / REPEAT) + 1
    assert asked == {"sections": [(early, 0), (QUICK.section_points, 8)], "window": QUICK.window}


def run_of(model, states, times, progress):
    """The first is slack in a quarter of the time."""
    stress = np.where((np.arange(times.size) < times.size // 4) & (np.arange(3) == 0)[:, None], -1.0, 1.0)
    x = np.asarray(states)[..., :1] * np.ones((3, 1)) + times / times[-1]
    at = ("member", "time")
    return xr.Dataset(
        {
            "displacement": (at, x), "velocity": (at, 2.0 * x), "hoop_stress": (at, stress),
            "meridional_stress": (at, 0.0 * x + 1.0), "validity_near_limit": ("member", [0.1, 0.2, 0.3]),
            "validity_breakdown": ("member", [0.0] * 3), "initial": ("member", [1.0, 2.0, 3.0]),
        },
        coords={"time": times},
    )  # fmt: skip


@pytest.mark.parametrize("name", ["window", "late"])
def test_a_window_has_its_extent_its_validity_and_its_share_of_slack(monkeypatch, name):
    monkeypatch.setattr(module, "simulate", run_of)
    found = module._window(MODEL, [[0.5, 0.0], [0.6, 0.0], [0.7, 0.0]], 4.0, name, None)
    prefix = "late_" if name == "late" else ""
    assert found.sizes[f"{prefix}time"] == 81
    np.testing.assert_allclose(found[f"{name}_lowest"], [0.5, 0.6, 0.7])
    np.testing.assert_allclose(found[f"{name}_highest"], [1.5, 1.6, 1.7])
    np.testing.assert_allclose(found[f"{name}_validity_slack"], [20.0 / 81.0, 0.0, 0.0])
    np.testing.assert_allclose(found[f"{name}_validity_near_limit"], [0.1, 0.2, 0.3])
    assert f"{name}_validity_breakdown" not in found
    np.testing.assert_allclose(found[f"{prefix}velocity"], 2.0 * found[f"{prefix}displacement"])
    assert ("initial" in found) == (name == "window")


def test_a_long_run_goes_on_from_the_last_point_and_is_unknown_of_a_member_that_failed(monkeypatch):
    seen = []
    monkeypatch.setattr(
        module, "_window", lambda model, states, length, name, progress: seen.append((states, length, name))
        or xr.Dataset({"late_lowest": ("member", [1.0, 2.0, 3.0])}),
    )  # fmt: skip
    late = xr.Dataset(
        {
            "displacement": (("member", "repeat"), [[0.1, 0.2], [0.3, 0.4], [0.5, np.nan]]),
            "velocity": (("member", "repeat"), [[1.0, 2.0], [3.0, 4.0], [5.0, np.nan]]),
            "outcome": ("member", [Outcome.OK, Outcome.OK, Outcome.STRETCH_LIMIT]),
        }
    )
    preset = QUICK.preset("base")
    found = module._long_run(MODEL, late, preset, None)
    ((states, length, name),) = seen
    np.testing.assert_array_equal(states, [[0.2, 2.0], [0.4, 4.0], preset.initial])
    assert (length, name) == (pytest.approx(module.LATE_REPEATS * REPEAT), "late")
    np.testing.assert_array_equal(found["late_lowest"], [1.0, 2.0, np.nan])


def test_all_parts_of_a_triple_come_to_stand_under_their_names(monkeypatch):
    """Points and windows of made-up runs: early ones from the start, late ones once all have settled."""
    shares, preset = [], QUICK.preset("base")
    values = np.array([1.0, 2.0, 3.0])

    def kinds(model, initial, effort):
        data = {"settled_time": ("member", [2.5 * REPEAT] * 3), "regime": ("member", values + 10.0)}
        data |= dict.fromkeys(("lowest", "highest", "section"), ("member", values))
        voltage = ("member", np.asarray(model.voltage), {"long_name": "v"})
        return xr.Dataset(data, coords={"voltage": voltage}, attrs={"model": "own"})

    def section(model, initial, *, repeats, discard, progress):
        progress(1.0)
        at = ("member", "repeat")
        points = values[:, None] + 0.1 * discard + np.zeros(4)
        data = {"displacement": (at, points), "velocity": (at, points + 50.0), "outcome": ("member", [0, 0, 0])}
        return xr.Dataset(data, coords={"time": (at, points)})

    def finite(members, states, window, options):
        asked.update(states=states, window=window)
        running = np.stack([values[:, None] * [1.0, 2.0], values[:, None] * [5.0, 6.0]], axis=-1)
        return values[:, None] * [1.0, -1.0], running

    def simulate(model, states, times, progress):
        progress(1.0)
        asked.setdefault("runs", []).append((np.asarray(states), float(times[-1])))
        return run_of(model, np.broadcast_to(states, (3, 2)), times, progress)

    asked = {}
    monkeypatch.setattr(module, "kinds_of", kinds)
    monkeypatch.setattr(module, "section", section)
    monkeypatch.setattr(module, "finite_exponents", finite)
    monkeypatch.setattr(module, "simulate", simulate)
    found = module.motions(preset, MODEL, "voltage", QUICK, shares.append)
    assert sum(shares) == pytest.approx(1.0)
    np.testing.assert_array_equal(asked["states"], [preset.initial] * 3)
    (start, window), (end, late) = asked["runs"]
    np.testing.assert_array_equal(start, preset.initial)
    assert (window, late) == (QUICK.window, pytest.approx(module.LATE_REPEATS * REPEAT))
    np.testing.assert_allclose(end, np.stack([values + 0.3, values + 50.3], axis=1))
    for name, numbers in {
        "early_section_displacement": values, "early_section_velocity": values + 50.0,
        "section_displacement": values + 0.3, "section_velocity": values + 50.3,
    }.items():  # fmt: skip
        np.testing.assert_allclose(found[name][:, 0], numbers)
    assert found["early_section_velocity"].dims == ("voltage", "early_repeat")
    assert found["section_velocity"].dims == ("voltage", "repeat")
    np.testing.assert_array_equal(found["finite"], values[:, None] * [1.0, -1.0])
    np.testing.assert_array_equal(found["finite_time"], values[:, None] * [1.0, 2.0])
    np.testing.assert_array_equal(found["finite_exponent"], values[:, None] * [5.0, 6.0])
    np.testing.assert_array_equal(found["regime"], values + 10.0)
    assert found.attrs["title"] == "motions at three values of voltage"
    assert (found.attrs["preset"], found.attrs["parameter"], found.attrs["model"]) == ("base", "voltage", "own")
    options = {"initial": list(preset.initial), "window": QUICK.window, "settled_repeats": 3}
    assert json.loads(found.attrs["options"]) == options
    assert {"late_displacement", "late_time", "window_lowest", "late_highest"} <= set(found.variables)


def test_a_triple_differs_from_its_set_as_the_table_says(monkeypatch):
    asked = {}
    monkeypatch.setattr(module, "motions", lambda preset, model, parameter, *more: asked.update(
        preset=preset.name, model=model, parameter=parameter))  # fmt: skip
    for name, (preset, parameter, values, changes) in module.TRIPLES.items():
        module.triple(name, QUICK, None)
        assert (asked["preset"], asked["parameter"]) == (preset, parameter)
        np.testing.assert_array_equal(asked["model"].values[parameter], values)
        for changed, value in changes.items():
            assert float(asked["model"].values[changed]) == value


def test_a_film_is_slack_where_either_stress_is_compressive(monkeypatch):
    def run(model, states, times, progress):
        own = run_of(model, states, times, progress)
        stress = np.ones((3, times.size))
        return own.assign(
            hoop_stress=(("member", "time"), np.where(np.arange(times.size) < 8, -1.0, stress)),
            meridional_stress=(("member", "time"), np.where(np.arange(times.size) > 76, -1.0, stress)),
        )

    monkeypatch.setattr(module, "simulate", run)
    found = module._window(MODEL, [[0.5, 0.0]] * 3, 4.0, "window", None)
    np.testing.assert_allclose(found["window_validity_slack"], [12.0 / 81.0] * 3)


def test_as_many_early_points_are_stored_as_the_shortest_forcing_has_in_the_window(monkeypatch):
    asked = []

    class Stop(Exception):
        """Ends the study where the first section is asked for."""

    def section(model, initial, *, repeats, discard, progress):
        asked.append((repeats, discard))
        raise Stop

    model = ConeModel(voltage=0.5, voltage_bias=0.1, drive_frequency=np.array([1.0, 2.0, 4.0]))
    settled = xr.Dataset({"settled_time": ("member", [1.0, 1.0, 1.0])})
    monkeypatch.setattr(module, "kinds_of", lambda model, initial, effort: settled)
    monkeypatch.setattr(module, "section", section)
    with pytest.raises(Stop):
        module.motions(QUICK.preset("base"), model, "drive_frequency", QUICK, lambda share: None)
    assert asked == [(int(QUICK.window / (0.5 * np.pi)) + 1, 0)]


def test_the_long_run_is_as_many_repeats_as_the_slowest_drive_has(monkeypatch):
    """Of members that differ in their frequency."""
    model, seen = ConeModel(voltage=0.5, voltage_bias=0.1, drive_frequency=np.array([1.0, 2.0, 4.0])), []
    at = (("member", "repeat"), np.ones((3, 2)))
    late = xr.Dataset({"displacement": at, "velocity": at, "outcome": ("member", [0, 0, 0])})
    monkeypatch.setattr(module, "_window", lambda *given: seen.append(given) or xr.Dataset())
    module._long_run(model, late, QUICK.preset("base"), None)
    ((_, _, length, name, _),) = seen
    assert (length, name) == (pytest.approx(module.LATE_REPEATS * 2.0 * np.pi), "late")
