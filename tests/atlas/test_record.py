"""The record of a sweep: all that decides its numbers, and its totals."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from gelcone.atlas import record as module
from gelcone.atlas.plan import Plan
from gelcone.atlas.record import Tally, coordinates, plan_record, stored_sweep
from gelcone.atlas.store import Field, Status
from gelcone.codes import Outcome
from gelcone.devices.device import find_device
from gelcone.errors import InputError
from gelcone.physics.model import ConeModel
from gelcone.register.analyses import find_analysis

PUMP = find_device("biased-pump").replace(film="taut")
OVER = {"voltage": [0.1, 0.2]}
REGIME = find_analysis("regime")


def test_each_part_of_a_plan_changes_its_record():
    def of(model=None, over=OVER, initial=None, draws=None, options=None, analysis=REGIME, coarsest=None, keep=()):
        plan = Plan(model or ConeModel(), over, initial, draws or {}, options or {})
        return plan_record(plan, analysis, coarsest, keep)

    own, field = of(), {"voltage_amplitude": [100.0, 200.0]}
    others = [
        of(ConeModel(damping_ratio=0.06)), of(over={"voltage": [0.1, 0.3]}), of(initial=(0.9, 0.0)),
        of(draws={"damping_ratio": [0.1, 0.2]}), of(options={"budget": 100.0}), of(analysis=find_analysis("limits")),
        of(coarsest=5), of(keep=("section",)), of(PUMP, field), of(PUMP.replace(frequency=8.0), field),
    ]  # fmt: skip
    assert own == of()
    assert len({repr(record) for record in [own, *others]}) == len(others) + 1
    assert own["options"] == REGIME.settings({})
    assert own == of(options={"budget": REGIME.settings({})["budget"]})


def test_totals_are_rounded_plain_data():
    tally = Tally(10, computed=6, found=2, inferred=4, failed=1, steps=77, seconds=1.23456, checked=3, missed=1)
    record = tally.record()
    assert record == {
        "cells": 10, "computed": 6, "computed_before": 2, "inferred": 4, "failed": 1, "integrator_steps": 77,
        "wall_time_s": 1.235, "checked": 3, "missed": 1, "border_dimension": None,
    }  # fmt: skip
    assert Tally(1, border=(1.23456, 0.04567)).record()["border_dimension"] == [1.235, 0.046]


@pytest.mark.parametrize(("model", "quantity"), [(ConeModel(), "code"), (PUMP, "device field")])
def test_draws_lie_along_their_own_axis(model, quantity):
    name, drawn = ("voltage", [0.1, 0.3]) if quantity == "code" else ("voltage_amplitude", [90.0, 120.0])
    over = {"drive_frequency": [0.5, 0.6]} if quantity == "code" else {"frequency": [8.0, 9.0]}
    found = coordinates(Plan(model, over, draws={name: drawn}))
    assert set(found) == {*over, f"drawn_{name}"}
    assert found[f"drawn_{name}"].dims == ("draw",)
    assert found[f"drawn_{name}"].values.tolist() == drawn
    assert found[f"drawn_{name}"].attributes["quantity"] == quantity


@pytest.mark.parametrize("model", [ConeModel(damping_ratio=0.07), PUMP])
def test_a_plan_read_back_from_its_record_has_the_same_record(monkeypatch, model):
    """Options of a device stand there without units, and are not scaled once more."""
    over = {"voltage": [0.1, 0.2]} if model is not PUMP else {"frequency": [8.0, 9.0]}
    draws = {"damping_ratio" if model is not PUMP else "spring_rate": [1.0, 2.0, 3.0]}
    options = {"budget": 900.0, "patience": 250.0} if model is not PUMP else {"budget": "40 s", "patience": "9 s"}
    record = plan_record(Plan(model, over, (0.2, 0.1), draws, options), REGIME, None, ("section",))
    monkeypatch.setattr(module, "read_plan", lambda path: record)
    stored = stored_sweep("map.zarr")
    assert (stored.analysis, stored.coarsest, stored.keep) == ("regime", None, ("section",))
    assert plan_record(stored.plan, REGIME, stored.coarsest, stored.keep) == record
    if model is PUMP:
        assert stored.plan.options["budget"] == pytest.approx(40.0 / PUMP.scales.time)


def test_a_record_of_branches_or_of_another_version_is_no_sweep(monkeypatch):
    record = plan_record(Plan(ConeModel(), OVER), REGIME, None)
    for changed, message in (
        (
            record | {"analysis": "continue_branch"},
            "holds branches, no sweep; continue with the same `gelcone continue`",
        ),
        (
            {name: value for name, value in record.items() if name != "keep"},
            "its plan lacks keep; it was made by another",
        ),
    ):
        monkeypatch.setattr(module, "read_plan", lambda path, changed=changed: changed)
        with pytest.raises(InputError, match=message):
            stored_sweep("map.zarr")


def test_what_a_store_holds_is_counted_by_where_it_comes_from(monkeypatch):
    """Computed, inferred and not there yet; a store without any cell is not shown."""
    plan = Plan(ConeModel(), {"voltage": [0.1, 0.2, 0.3]})
    monkeypatch.setattr(module, "read_plan", lambda path: plan_record(plan, REGIME, None))
    status = np.array([Status.COMPUTED, Status.MISSING, Status.INFERRED], dtype=np.uint8)
    held = {
        "status": Field((), status, {}),
        "outcome": Field((), 0 * status, {}),
        "lowest": Field((), np.array([1.0, np.nan, 3.0]), {"units": "1"}),
    }
    monkeypatch.setattr(module.Store, "read", lambda self: held)
    found = module.show("map.zarr")
    totals = json.loads(found.attrs["totals"])
    assert (totals["cells"], totals["computed"], totals["inferred"]) == (3, 1, 1)
    np.testing.assert_array_equal(found["lowest"], [1.0, np.nan, 3.0])
    assert found["voltage"].values.tolist() == [0.1, 0.2, 0.3]
    assert (found.attrs["title"], found.attrs["analysis"]) == ("sweep: regime", "regime")
    held.clear()
    with pytest.raises(InputError, match="holds no cell yet; try again when its run has computed some"):
        module.show("map.zarr")


def test_the_store_of_a_device_is_shown_in_its_units(monkeypatch):
    status, outcome = np.array([Status.COMPUTED, Status.MISSING]), np.array([Outcome.OK, -1])
    fields = {"status": Field((), status, {}), "outcome": Field((), outcome, {})}
    for model in (PUMP, ConeModel()):
        name = "frequency" if model is PUMP else "voltage"
        stored = module.StoredSweep(Plan(model, {name: [0.4, 0.8]}), "limits", None, ())
        monkeypatch.setattr(module, "stored_sweep", lambda path, stored=stored: stored)
        monkeypatch.setattr(module, "Store", lambda *given: SimpleNamespace(read=lambda: fields))
        monkeypatch.setattr(module, "label", lambda *given: "labelled")
        monkeypatch.setattr(module, "with_names_of_today", lambda found: f"{found} today")
        monkeypatch.setattr(module, "to_si", lambda found, device: (found, device))
        assert module.show("map.zarr") == (("labelled today", PUMP) if model is PUMP else "labelled today")


def test_a_sweep_says_where_its_cells_begin_and_what_it_was_asked():
    plan = Plan(ConeModel(), {"voltage": [0.4, 0.8]}, (0.5, 0.25), options={"budget": 99.0})
    fields = {"status": Field((), np.array([Status.COMPUTED] * 2), {}), "outcome": Field((), np.zeros(2), {})}
    found = module.label(
        plan, find_analysis("regime"), fields, np.array([0, 0]), Tally(2), "a title", {"film_error": 0.1}
    )
    options = json.loads(found.attrs["options"])
    assert (options["initial"], options["budget"], found.attrs["title"]) == ([0.5, 0.25], 99.0, "a title")
    assert found["source"].values.tolist() == [0, 0]
    assert (found.attrs["analysis"], found.attrs["film_error"]) == ("regime", 0.1)
