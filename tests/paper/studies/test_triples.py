"""Motions at three values of a parameter: what is stored of which window, in made-up runs."""

import numpy as np
import pytest
import xarray as xr

from gelcone import ConeModel
from gelcone.codes import Outcome
from gelcone.paper.effort import QUICK
from gelcone.paper.studies import triples as module

MODEL = ConeModel(voltage=np.array([0.4, 0.5, 0.6]), voltage_bias=0.1, drive_frequency=2.0)
REPEAT = np.pi
"""Of a forcing with a bias at the frequency 2."""


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
