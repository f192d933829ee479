"""A sweep in words: its plan and device as a store keeps them, its totals, and its labelled result."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone._version import __version__
from gelcone.atlas.plan import Plan, meaning_of, quantity_of
from gelcone.atlas.store import Field, Status, Store, read_attribute, read_plan
from gelcone.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.devices.device import Device

DEVICE = "gelcone_device"
"""Attribute of a store that holds the device behind its plan, if there is one."""


@dataclass(frozen=True)
class Tally:
    """How far a sweep is. ``asked`` counts the cells asked for up to now, of which ``computed`` are there (``found`` of
    them from before, in the store). Known at the end: ``inferred``; ``checked`` and ``missed`` as in `Refined`; and
    ``border``, the dimension of the borders between kinds with its error."""

    cells: int
    asked: int = 0
    computed: int = 0
    found: int = 0
    inferred: int = 0
    failed: int = 0
    chaotic: int = 0
    steps: int = 0
    seconds: float = 0.0
    checked: int = 0
    missed: int = 0
    border: tuple[float, float] | None = None

    def record(self) -> dict[str, Any]:
        """The totals as plain data."""
        return {
            "cells": self.cells,
            "computed": self.computed,
            "computed_before": self.found,
            "inferred": self.inferred,
            "failed": self.failed,
            "integrator_steps": self.steps,
            "wall_time_s": round(self.seconds, 3),
            "checked": self.checked,
            "missed": self.missed,
            "border_dimension": self.border and [round(number, 3) for number in self.border],
        }


def plan_record(plan: Plan, analysis: str, coarsest: int | None) -> dict[str, Any]:
    """All that decides the numbers, as plain data."""
    return {
        "gelcone_version": __version__,
        "analysis": analysis,
        "model": json.loads(dataset.label(plan.model, {}, options={}, title="").attrs["model"]),
        "over": {name: values.tolist() for name, values in plan.over.items()},
        "draws": {name: values.tolist() for name, values in plan.draws.items()},
        "coarsest": coarsest,
        **json.loads(json.dumps(plan.options())),
    }


def stored_plan(path: str | Path) -> tuple[Plan, str, int | None]:
    """Plan, analysis and coarsest lattice that a store was made for; `InputError` as `read_plan`."""
    record = read_plan(Path(path))
    import xarray as xr

    names = ("over", "draws", "initial", "transient", "budget", "tolerance", "rounds", "field_limit")
    if missing := [name for name in ("analysis", "coarsest", "model", *names) if name not in record]:
        raise InputError(
            f"{path}: its plan lacks {missing[0]}; it was made by another version ({record.get('gelcone_version')}): "
            "use that one, or choose another store"
        )
    model = dataset.model_of(xr.Dataset(attrs={"model": json.dumps(record["model"])}))
    options = {name: record[name] for name in names} | {"initial": tuple(record["initial"])}
    return Plan(model, **options), record["analysis"], record["coarsest"]


def device_record(device: Device | None) -> dict[str, Any]:
    """What a store keeps of the device behind a plan; nothing when there is none."""
    return {} if device is None else {DEVICE: json.dumps(device.parameters())}


def stored_device(path: str | Path) -> Device | None:
    """The device that a store was made for, None for a dimensionless one; `InputError` as `stored_plan`."""
    record = read_attribute(Path(path), DEVICE)
    if record is None:
        return None
    from gelcone.devices.device import Device

    return Device(**record)


def look(path: str | Path) -> xr.Dataset:
    """What a store holds by now, whether its run goes on or not, as `survey` labels it.

    Cells that are missing hold NaN, -1 or 0; ``status`` tells them. Raises `InputError` for what is no whole store.
    """
    plan, analysis, _ = stored_plan(path)
    fields = Store(Path(path), {}, plan.dims, plan.shape).read()
    if not fields:
        raise InputError(f"{path}: holds no cell yet; look again when its run has come further")
    status = fields["status"].values
    tally = Tally(
        plan.size, computed=int((status == Status.COMPUTED).sum()), inferred=int((status == Status.INFERRED).sum())
    )
    return label(plan, fields, None, tally, f"sweep: {analysis}")


def coordinates(plan: Plan) -> dict[str, Field]:
    coordinates = {
        name: Field((name,), values, {"long_name": meaning_of(name), "units": "1", "quantity": quantity_of(name)})
        for name, values in plan.over.items()
    }
    drawn = {
        f"drawn_{name}": Field(("draw",), values, {"long_name": meaning_of(name), "units": "1", "quantity": "code"})
        for name, values in plan.draws.items()
    }
    return coordinates | drawn


def label(
    plan: Plan, fields: Mapping[str, Field], sources: npt.NDArray[np.intp] | None, tally: Tally, title: str
) -> xr.Dataset:
    result = dataset.label(plan.model, {}, options=plan.options(), title=title)
    if sources is not None:
        about = {"long_name": "flattened index of the cell whose values it carries", "units": "1", "quantity": "code"}
        fields = {**fields, "source": Field((), sources, about)}
    variables = {
        name: (plan.dims + f.dims, f.values.reshape(plan.shape + f.values.shape[1:]), dict(f.attributes))
        for name, f in fields.items()
    }
    axes = {name: (f.dims, f.values, dict(f.attributes)) for name, f in coordinates(plan).items()}
    result = result.assign_coords(axes).assign(variables)
    return result.assign_attrs(totals=json.dumps(tally.record()))
