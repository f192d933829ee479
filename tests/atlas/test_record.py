"""The record of a sweep: all that decides its numbers, and its totals."""

import pytest

from gelcone.atlas.plan import Plan
from gelcone.atlas.record import Tally, coordinates, plan_record
from gelcone.devices.device import find_device
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
