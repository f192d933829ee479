"""The record of a sweep: its plan and device in a store, its totals, and its labelled result."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone._version import __version__
from gelcone.atlas.plan import Plan, about
from gelcone.atlas.store import FILM_ERRORS, Field, Status, Store, read_plan
from gelcone.codes import Outcome
from gelcone.devices.analysis import analysis, device_words, scaled
from gelcone.devices.device import Device
from gelcone.devices.points import at
from gelcone.devices.si import DRAWN, device_attributes, to_si
from gelcone.earlier import with_names_of_today
from gelcone.errors import InputError, check_path
from gelcone.motion.start import complete
from gelcone.register.analyses import find_analysis
from gelcone.register.analysis import Analysis

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Tally:
    """Counts of cells, and the progress of a sweep.

    ``asked`` counts the cells requested up to now, ``computed`` those of them that are computed, ``found`` those that
    were in the store before, and ``chaotic`` the chaotic ones, None without kinds of motion. Known at the end:
    ``inferred``; ``checked`` and ``missed`` as in `Refined`; and ``border``, the dimension of the borders between kinds
    with its error.
    """

    cells: int
    asked: int = 0
    computed: int = 0
    found: int = 0
    inferred: int = 0
    failed: int = 0
    chaotic: int | None = None
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


def plan_record(
    plan: Plan,
    analysis: Analysis,
    coarsest: int | None,
    keep: Sequence[str] = (),
    errors: Mapping[str, float] | None = None,
) -> dict[str, Any]:
    """All that determines the numbers, as plain data; with all options, also those left at their defaults, and the
    stated ``errors`` of the films of all cells."""
    record = {
        "gelcone_version": __version__,
        "analysis": analysis.name,
        "device": None if plan.device is None else plan.device.parameters(),
        "model": dataset.single_values(plan.cone),
        "over": {name: values.tolist() for name, values in plan.over.items()},
        "draws": {name: values.tolist() for name, values in plan.draws.items()},
        "initial": plan.initial,
        "options": analysis.settings(plan.options),
        "coarsest": coarsest,
        "keep": list(keep),
        FILM_ERRORS: dict(errors or {}),
    }
    plain: dict[str, Any] = json.loads(json.dumps(record))
    return plain


@dataclass(frozen=True)
class StoredSweep:
    """The arguments of `gelcone.sweep` with which a store can be resumed."""

    plan: Plan
    analysis: str
    coarsest: int | None
    keep: tuple[str, ...]
    film_errors: Mapping[str, float] = field(default_factory=dict)


def stored_sweep(path: str | Path) -> StoredSweep:
    """The sweep of a store. Raises `InputError` as `read_plan`, and for a store of another version."""
    record = read_plan(Path(path))
    import xarray as xr

    names = ("analysis", "model", "device", "over", "draws", "initial", "options", "coarsest", "keep")
    if record.get("analysis") == "continue_branch":
        raise InputError(f"{path}: holds branches, no sweep; continue with the same `gelcone continue` command")
    if missing := [name for name in names if name not in record]:
        raise InputError(
            f"{path}: its plan lacks {missing[0]}; it was made by another version ({record.get('gelcone_version')}): "
            "use that one, or choose another store"
        )
    model = dataset.model_of(xr.Dataset(attrs={"model": json.dumps(record["model"])}))
    subject = model if record["device"] is None else Device(**record["device"])
    options = {name: scaled(value) for name, value in record["options"].items()}
    plan = Plan(subject, record["over"], record["initial"], record["draws"], options)
    errors = record.get(FILM_ERRORS, {})
    return StoredSweep(plan, record["analysis"], record["coarsest"], tuple(record["keep"]), errors)


@analysis(takes="store", answers="grids", examples=("map.zarr --out results",))
def show(path: str | Path) -> xr.Dataset:
    """Load what a store holds by now, also while its run continues, labelled as by `gelcone.sweep`.

    Parameters
    ----------
    path : the folder of the store.

    Returns
    -------
    Dataset as of `gelcone.sweep`, in SI units for a device, without ``source``. Cells that are missing hold NaN, -1 or
    0; ``status`` says which.

    Raises
    ------
    InputError : for a folder that is not a complete store, one of another version, or one that holds no cell yet.

    Examples
    --------
    >>> import gelcone, tempfile
    >>> plan = gelcone.Plan(gelcone.ConeModel(), {"voltage": [0.4, 0.8], "spring_stiffness": [0.5, 1.0]})
    >>> store = tempfile.mkdtemp() + "/map.zarr"
    >>> cells = gelcone.sweep(plan, "limits", store=store)
    >>> gelcone.show(store).pitchfork_voltage.values[0].round(4).tolist()
    [0.7071, 1.0]
    """
    check_path("show", path)
    stored = stored_sweep(path)
    plan = stored.plan
    fields = Store(Path(path), {}, plan.dims, plan.shape).read()
    if not fields:
        raise InputError(f"{path}: holds no cell yet; try again when its run has computed some")
    status = fields["status"].values
    computed, inferred = (status == kind for kind in (Status.COMPUTED, Status.INFERRED))
    failed = computed & (fields["outcome"].values != Outcome.OK)
    tally = Tally(plan.size, computed=int(computed.sum()), inferred=int(inferred.sum()), failed=int(failed.sum()))
    title = f"sweep: {stored.analysis}"
    cells = label(plan, find_analysis(stored.analysis), fields, None, tally, title, stored.film_errors)
    cells = with_names_of_today(cells)
    return cells if plan.device is None else to_si(cells, plan.device)


def coordinates(plan: Plan) -> dict[str, Field]:
    """The axes of a plan, and the draws of its uncertain parameters."""
    axes = {name: Field((name,), values, about(plan, name)) for name, values in plan.over.items()}
    drawn = {
        f"{DRAWN}{name}": Field(
            ("draw",), values, about(plan, name) | ({} if plan.device is not None else {"quantity": "code"})
        )
        for name, values in plan.draws.items()
    }
    return axes | drawn


def label(
    plan: Plan,
    analysis: Analysis,
    fields: Mapping[str, Field],
    sources: npt.NDArray[np.intp] | None,
    tally: Tally,
    title: str,
    errors: Mapping[str, float],
) -> xr.Dataset:
    """The cells of a sweep as a Dataset over the plan's axes, with all that is needed to run it again and the stated
    ``errors`` of their films."""
    options = {"initial": plan.initial, **analysis.settings(plan.options)}
    if sources is not None:
        whose = dataset.attributes("flattened index of the cell whose values it carries", "code")
        fields = {**fields, "source": Field((), sources, whose)}
    variables = {
        name: (plan.dims + f.dims, f.values.reshape(plan.shape + f.values.shape[1:]), dict(f.attributes))
        for name, f in fields.items()
    }
    result = over_axes(plan, variables, options, title, errors)
    refused = (fields["outcome"].values == Outcome.IMPOSSIBLE) & (fields["status"].values == Status.COMPUTED)
    extra_attributes = {"impossible": refusal(plan, analysis, int(refused.argmax()))} if refused.any() else {}
    return result.assign_attrs(analysis=analysis.name, totals=json.dumps(tally.record()), **extra_attributes)


def refusal(plan: Plan, analysis: Analysis, cell: int) -> str:
    """The reason why a cell makes no actuator, or why the analysis refuses the one that it makes; empty if neither."""
    if reason := plan.refusal(cell):
        return reason
    values = plan.values(np.array([cell]))
    model, states = plan.at(values)
    members = model.members()
    try:
        with device_words(None if plan.device is None else at(plan.device, values)):
            analysis.compute(members, complete(members, states), threads=1, **analysis.settings(plan.options))
    except InputError as error:
        return str(error)
    return ""


def over_axes(
    plan: Plan, variables: Mapping[str, Any], options: Mapping[str, Any], title: str, errors: Mapping[str, float]
) -> xr.Dataset:
    """Variables over a plan's axes as a Dataset with its model, options, device and the ``errors`` of its films."""
    result = dataset.label(plan.cone, {}, options=options, title=title, errors=errors)
    axes = {name: (f.dims, f.values, dict(f.attributes)) for name, f in coordinates(plan).items()}
    result = dataset.name_dims(result.assign_coords(axes).assign(variables), plan.cone.system)
    return result if plan.device is None else result.assign_attrs(device_attributes(plan.device))
