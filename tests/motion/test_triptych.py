"""Motions side by side: the same numbers as each alone."""

import importlib
import json
from types import SimpleNamespace

import numpy as np
import pytest

import gelcone
from gelcone import ConeModel, InputError, Outcome, Regime
from gelcone.dataset import Findings
from gelcone.presets import find_preset
from tests.recorded import numbers, record

module = importlib.import_module("gelcone.motion.triptych")

BASE = ConeModel(damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.3)
"""Rests below a voltage, swings above."""
QUICK = {"periods": 4, "late_periods": 3, "budget": 2000.0}


def test_each_column_is_what_the_analyses_of_its_motion_give():
    found = gelcone.triptych(BASE.replace(voltage=[0.3, 0.9]), **QUICK)
    for voltage in (0.3, 0.9):
        member, model = found.sel(voltage=voltage), BASE.replace(voltage=voltage)
        alone = gelcone.regime(model, budget=2000.0)
        for name in ("regime", "period", "lyapunov", "lowest", "highest"):
            np.testing.assert_array_equal(member[name], alone[name], name)
        run = gelcone.simulate(model, times=member["time"].values)
        np.testing.assert_allclose(member["displacement"], run["displacement"], atol=1e-12)
        np.testing.assert_allclose(member["velocity"], run["velocity"], atol=1e-12)
        assert float(member["late_displacement"].max()) == pytest.approx(float(alone["highest"]), abs=1e-3)
        assert float(member["late_displacement"].min()) == pytest.approx(float(alone["lowest"]), abs=1e-3)
    period = 2.0 * np.pi / 0.3
    assert float(found["time"].max()) == pytest.approx(4.0 * period)
    assert float(found["late_time"].max()) == pytest.approx(3.0 * period)
    assert found["regime"].values.tolist() == [Regime.REST, Regime.PERIODIC]


def test_the_section_lies_on_the_settled_motion_once_every_forcing_period():
    found = gelcone.triptych(BASE.replace(voltage=0.9), **QUICK)
    period = int(found["period"])
    x = found["section_displacement"].values
    known = x[np.isfinite(x)]
    assert known.size > 2 * period
    np.testing.assert_allclose(known[period:], known[:-period], atol=1e-9)
    assert x[0] == pytest.approx(float(found["late_displacement"][0]), abs=1e-12)


def test_chaos_has_its_whole_section_and_a_motion_that_ended_none():
    chaos = gelcone.triptych(find_preset("base").model.replace(voltage=1.7), **QUICK)
    assert int(chaos["regime"]) == Regime.CHAOTIC
    assert int(np.isfinite(chaos["section_displacement"]).sum()) == 600
    pump = gelcone.find_device("biased-pump").replace(film="wrinkling", voltage_amplitude="1700 V")
    ended = gelcone.triptych(pump, periods=4, late_periods=3)
    assert int(ended["outcome"]) == Outcome.PULLED_IN
    assert not np.isfinite(ended["late_displacement"]).any()
    assert not np.isfinite(ended["section_displacement"]).any()
    assert 0 < int(np.isfinite(ended["displacement"]).sum()) < ended["displacement"].size
    assert ended["displacement"].attrs["units"] == "mm"


@pytest.mark.parametrize(
    ("changes", "options", "message"),
    [
        ({"voltage": [0.1, 0.2, 0.3, 0.4, 0.5]}, {}, "was given 5 motions; give at most 4"),
        ({}, {"periods": 0}, "periods = 0: must be at least 1"),
        ({}, {"late_periods": 0.5}, "late_periods = 0.5: must be a whole number"),
    ],
)
def test_what_has_no_room_is_refused(changes, options, message):
    with pytest.raises(InputError, match=message):
        gelcone.triptych(BASE.replace(**changes), **options)


def test_each_panel_holds_what_its_part_was_asked_for(monkeypatch):
    """Of a cycle, chaos, a motion that ended and rest: late runs and sections begin at the last point of the section,
    which is as long as that of the regime where the motion repeats, and empty where it ended."""
    model = BASE.replace(voltage=[0.3, 0.6, 0.9, 0.2])
    section, kinds = (
        numbers(4, 4, 2, at=5.0),
        np.array([Regime.PERIODIC, Regime.CHAOTIC, Regime.LEFT_THE_DOMAIN, Regime.REST]),
    )
    section[2] = np.nan
    variables = {
        "regime": ((), kinds, "kind", "code"), "section": (("point", "state"), section, "points", "state"),
        "lowest": ((), numbers(4, at=6.0), "lowest", "length"),
    }  # fmt: skip
    outcome = np.array([0, 0, int(Outcome.STRETCH_LIMIT), 0], dtype=np.int8)
    points = {
        name: (("repeat",), numbers(4, 600, at=k), name, "length") for k, name in ((7, "displacement"), (9, "velocity"))
    }

    def runs(members, states, times, *, tolerance, threads):
        at = 20.0 if len(asked["integrate"]) == 1 else 40.0
        return SimpleNamespace(times=times, states=numbers(*times.shape, 2, at=at))

    asked = record(
        monkeypatch,
        module,
        regime_cells=Findings(variables, outcome),
        section_cells=Findings(points, outcome),
        integrate=runs,
    )
    budgets, flow, shares = {"transient": 11.0, "patience": 12.0, "budget": 13.0}, {"tolerance": 2e-9, "threads": 5}, []
    found = gelcone.triptych(model, (0.25, 0.5), periods=3, late_periods=2, **budgets, **flow, progress=shares.append)
    start, late = [[0.25, 0.5]] * 4, [*section[:2, -1].tolist(), [0.25, 0.5], section[3, -1].tolist()]
    (kind,), (cut,), (first, after) = asked["regime_cells"], asked["section_cells"], asked["integrate"]
    assert {name: kind[name] for name in budgets | flow} == budgets | flow
    assert {name: cut[name] for name in ("repeats", "discard", *flow)} == {"repeats": 600, "discard": 0} | flow
    for call, states in ((kind, start), (cut, late)):
        np.testing.assert_array_equal(call["states"], states)
    for call, states, periods in ((first, start, 3), (after, late, 2)):
        np.testing.assert_array_equal(call["initial"], states)
        assert call["times"][:, -1].tolist() == pytest.approx([periods * 2.0 * np.pi / 0.3] * 4)
        assert {name: call[name] for name in flow} == flow
    ran = np.array([[True], [True], [False], [True]])
    for k, name in enumerate(("displacement", "velocity")):
        np.testing.assert_array_equal(found[name], numbers(*first["times"].shape, 2, at=20.0)[..., k])
        own = np.where(ran, numbers(*after["times"].shape, 2, at=40.0)[..., k], np.nan)
        np.testing.assert_array_equal(found[f"late_{name}"], own)
        shown = points[name][1].copy()
        shown[[0, 3], 4:], shown[2] = np.nan, np.nan
        np.testing.assert_array_equal(found[f"section_{name}"], shown)
    np.testing.assert_array_equal(found["time"], first["times"])
    np.testing.assert_array_equal(found["late_time"], np.where(ran, after["times"], np.nan))
    np.testing.assert_array_equal(found["lowest"], numbers(4, at=6.0))
    assert "section" not in found
    assert found["outcome"].values.tolist() == outcome.tolist()
    assert json.loads(found.attrs["options"]) == budgets | {"periods": 3, "late_periods": 2, "tolerance": 2e-9}


def test_a_curve_has_as_many_samples_as_the_fastest_member_needs_up_to_a_bound():
    """Over two periods of 4 and 8 with 26 samples a turn of the disc, or 60 a period."""
    found = module._sampled(2, np.array([4.0, 8.0]), np.array([0.1, 2.0 * np.pi]))
    assert found.shape == (2, 16 * module.PER_OSCILLATION + 1)
    np.testing.assert_allclose(found[:, [0, -1]], [[0.0, 8.0], [0.0, 16.0]])
    assert module._sampled(2, np.array([4.0]), np.array([0.1])).shape == (1, 121)
    assert module._sampled(2, np.array([4.0]), np.array([1e6])).shape == (1, module.MOST_SAMPLES + 1)
