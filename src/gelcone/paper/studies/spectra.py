"""Study behind figure 8: spectra at three voltages, at first and in the long run."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone.motion.spectrum import FEWEST_PERIODS, spectrum
from gelcone.paper.effort import Effort
from gelcone.paper.studies.study import OF_MOTION, Progress, Study, about, kinds_of, merged
from gelcone.paper.studies.triples import TRIPLES
from gelcone.progress import weighted

if TYPE_CHECKING:
    import xarray as xr

SETS = ("base", "fast")


def spectra(effort: Effort, progress: Progress) -> xr.Dataset:
    """Spectra at three voltages of two parameter sets, over ``set`` and ``voltage``: at first and in the long run.

    The variables of `gelcone.spectrum` in the long run, and with the prefix ``early_`` over the first 16 drive periods;
    and those of `gelcone.regime`.
    """
    voltages = np.array(TRIPLES["voltage"][2])
    presets = [effort.preset(name) for name in SETS]
    stiffness = np.array([[preset.model.spring_stiffness] for preset in presets])
    omega = np.array([[preset.model.drive_frequency] for preset in presets])
    initial = presets[0].initial
    model = presets[0].model.replace(spring_stiffness=stiffness, drive_frequency=omega, voltage=voltages)
    kinds = kinds_of(model, initial, effort)
    progress(0.3)
    settled = int(np.ceil((kinds["settled_time"].values.ravel() / model.members().forcing_period).max()))
    early = spectrum(model, initial, periods=FEWEST_PERIODS, discard=0, progress=weighted(progress, 0.1))
    late = spectrum(model, initial, periods=effort.spectrum_periods, discard=settled, progress=weighted(progress, 0.6))
    early = early.drop_vars(["initial", "outcome"])
    early_names = [str(name) for name in (*early.data_vars, "frequency", "frequency_ratio") if name in early]
    early = early.rename({name: f"early_{name}" for name in [*early_names, "line"]})
    parts = [kinds.drop_vars("section"), late.drop_vars("outcome"), early]
    result = merged(*parts).drop_vars("voltage")
    attrs = kinds["voltage"].attrs
    result = result.rename(member_0="set", member_1="voltage").assign_coords(
        voltage=("voltage", voltages, attrs), set=("set", list(SETS), {"long_name": "parameter set"})
    )
    options = {"initial": list(initial), "periods": effort.spectrum_periods, "settled_repeats": settled}
    return about(result, kinds, ", ".join(SETS), "voltage", effort, options, "spectra at three voltages")


STUDIES = (Study("spectra", spectra, work=3.0, films=OF_MOTION),)
