"""Study behind figure 9: a device at practical voltages, in volts and millimetres."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone import dataset
from gelcone.devices.device import Device
from gelcone.devices.si import to_si
from gelcone.motion.attractor.classification import classify
from gelcone.motion.floquet import onset_voltage
from gelcone.motion.regime import label_evidence
from gelcone.motion.response import simulate
from gelcone.motion.start import start_states
from gelcone.motion.static_bifurcations import pitchfork_voltages, pull_in_voltage
from gelcone.motion.swing import swing
from gelcone.paper.effort import Effort
from gelcone.paper.films import OTHER_FILMS, film_of_device
from gelcone.paper.studies.study import Progress, Study, about, merged
from gelcone.paper.studies.triples import SPACING
from gelcone.physics.model import ConeModel
from gelcone.physics.statics import every_balance
from gelcone.progress import Progress as MaybeProgress
from gelcone.progress import advance, weighted

if TYPE_CHECKING:
    import xarray as xr

VOLTS = np.linspace(10.0, 50.0, 9)
HEIGHTS = (0.0, 0.02)
SETTLED_DECAYS = 40.0
"""Decay times before the late amplitude is measured, when the initial swing is lost to rounding."""


def practical(effort: Effort, progress: Progress) -> xr.Dataset:
    """A device of the paper's Table 1 at 10 to 50 V, in SI units, over ``initial_height`` and ``voltage_amplitude``.

    ``displacement`` over ``time`` from the release; ``window_amplitude`` (half its range) from the start and
    ``late_amplitude`` in the long run, about ``late_middle``; ``pitchfork_voltage`` and ``onset_voltage`` (Floquet) for
    a flat rest, ``pull_in_voltage`` for any; ``rest_displacement`` without voltage;
    ``largest_field`` and ``dielectric_strength`` (assumed); the shares ``window_validity_*``; and the variables of
    `gelcone.regime`, for which swings of less than a millionth of b - a are rest.
    """
    import xarray as xr

    base = film_of_device(effort.film)
    parts = [
        _practical(base.replace(initial_height=height, voltage_amplitude=VOLTS), effort, weighted(progress, 0.5))
        for height in HEIGHTS
    ]
    heights = xr.DataArray(1e3 * np.array(HEIGHTS), dims="initial_height", name="initial_height")
    result = xr.concat(parts, heights, join="exact", combine_attrs="override")
    result["initial_height"].attrs = {"long_name": "height at which the spring is free", "units": "mm"}
    single = dataset.label(base.to_model(), {}, options={}, title="")
    options = {"release_height_mm": 40.0, "window": effort.window, "settled_decays": SETTLED_DECAYS}
    result = about(result, single, "table1", "voltage_amplitude", effort, options, "a device at practical voltages")
    return result.assign_attrs(device=base.name)


def _practical(device: Device, effort: Effort, progress: MaybeProgress) -> xr.Dataset:
    model, state = device.to_model(), device.initial_state()
    times = np.linspace(0.0, effort.window, round(effort.window / SPACING) + 1)
    run = simulate(model, state, times=times, progress=weighted(progress, 0.3))
    settle = SETTLED_DECAYS / float(np.min(model.damping_ratio))
    evidence = classify(model.members(), start_states(model, state), transient=settle, patience=effort.patience)
    late = swing(model.members(), evidence.final)
    kinds = label_evidence(model, evidence, {}, "").drop_vars(["section", "lowest", "highest"])
    shares = {str(n): f"window_{n}" for n in run if str(n).startswith("validity_")}
    window = run["displacement"]
    numbers: dict[str, dataset.Variable] = {
        "window_amplitude": ((), 0.5 * np.ptp(window.values, axis=1), "half the swing from the start", "length"),
        "late_amplitude": ((), late.amplitude, "half the swing in the long run", "length"),
        "late_middle": ((), late.middle, "middle of the swing in the long run", "length"),
        "largest_field": ((), run["true_field"].max("time").values, "largest true field from the start", "field"),
        "dielectric_strength": ((), np.asarray(device.breakdown_field()), "dielectric strength (assumed)", "field"),
    }
    result = merged(
        kinds.assign(displacement=window),
        run[list(shares)].rename(shares),
        dataset.label(model, numbers | _thresholds(model), options={}, title=""),
    )
    advance(progress, 0.7)
    in_volts = {"long_name": "voltage amplitude", "units": "V"}
    volts = np.asarray(device.voltage_amplitude)
    in_si = to_si(result, device).assign_coords(voltage_amplitude=("member", volts, in_volts))
    return in_si.swap_dims(member="voltage_amplitude")


def _thresholds(model: ConeModel) -> dict[str, dataset.Variable]:
    """Voltages at which rest is lost, one for all members, which differ in their voltage alone."""
    one = model.take([0])
    flat = bool(one.members().symmetric.all())
    lost, pitchfork = pull_in_voltage(one), pitchfork_voltages(every_balance(one))
    onset = onset_voltage(one)["onset_voltage"].values[0] if flat else np.nan
    return {
        "pitchfork_voltage": ((), pitchfork[0], "constant voltage at which flat rest is lost", "voltage"),
        "onset_voltage": ((), onset, "drive voltage at which flat rest is lost (Floquet)", "voltage"),
        "pull_in_voltage": ((), lost["pull_in_voltage"].values[0], "voltage at which a slow ramp is lost", "voltage"),
        "rest_displacement": ((), lost["rest_displacement"].values[0], "rest without voltage", "length"),
    }


STUDIES = (Study("practical", practical, work=0.5, films=OTHER_FILMS),)
