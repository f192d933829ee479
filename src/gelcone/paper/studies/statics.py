"""Studies behind figures 3 and 6: forces and equilibria under constant voltage, and energies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from gelcone import dataset
from gelcone.dataset import attributes
from gelcone.motion.equilibrium import static as static_curves
from gelcone.paper.effort import Effort
from gelcone.paper.studies.study import OF_FORCE, Progress, Study, about, reach_of
from gelcone.physics.model import ConeModel
from gelcone.quantity import Array

if TYPE_CHECKING:
    import xarray as xr

STATIC_VOLTAGES = (0.0, 1.0, 1.5)


def static(effort: Effort, progress: Progress) -> xr.Dataset:
    """Force over displacement and all equilibria at three constant voltages, and where the film is slack."""
    preset = effort.preset("table1")
    result = static_curves(preset.model, STATIC_VOLTAGES)
    x, voltage = result["displacement"].values, result["constant_voltage"].values
    slack = _slack(preset.model, x, voltage[:, None]).astype(np.int8)
    dims = ("constant_voltage", "displacement")
    result["slack"] = (dims, slack, attributes("1 where the film is slack", "code"))
    progress(1.0)
    return result.assign_attrs(preset=preset.name, parameter="constant_voltage")


def _slack(model: ConeModel, x: Array, voltage: Any) -> npt.NDArray[np.bool_]:
    """Mask of the displacements at which a stress of a single actuator is compressive at a constant voltage."""
    state = model.film_state(x, voltage)
    return np.asarray(np.minimum(state.meridional_stress, state.hoop_stress) < 0.0)


LIMITS = (1.0, 1.5, 2.0, 5.0, 10.0, 50.0, 100.0)
SURFACES = (1.0, 100.0)
WIDEST = 4.0


def energy(effort: Effort, progress: Progress) -> xr.Dataset:
    """Strain energy over displacement for seven stretch limits; energy without voltage over the phase plane for two."""
    preset = effort.preset("fast")
    model = preset.model.replace(stretch_limit=np.array(LIMITS))
    reach = reach_of(model)
    # the energy grows logarithmically towards the limit: points must be ever closer to it
    near = (reach[:, None] * (1.0 - np.logspace(-3.0, -12.0, 10))).ravel()
    near = near[near < WIDEST]
    x = np.unique(np.concatenate([np.linspace(-WIDEST, WIDEST, 1601), near, -near]))
    unbiased = model.replace(spring_stiffness=0.0)
    spread = np.broadcast_to(x, (model.size, x.size))
    film, force = unbiased.energy(spread), model.film_force(spread)
    over = {
        "film_energy": (("displacement",), film, "strain energy of the film, NaN beyond the stretch limit", "energy"),
        "film_force": (("displacement",), force, "force of the film: the slope of its strain energy", "force"),
        "reach": ((), reach, "displacement at which the film reaches its stretch limit", "length"),
    }
    coords = {"displacement": (("displacement",), x, "displacement x = h/(b-a)", "length")}
    result = dataset.label(model, over, coords=coords, options={}, title="energies")
    result = result.swap_dims(member="stretch_limit").assign(_surfaces(preset.model))
    progress(1.0)
    return about(result, result, preset.name, "stretch_limit", effort, {}, "energies")


def _surfaces(base: ConeModel) -> dict[str, Any]:
    """Film, spring and kinetic energy over displacement and velocity, for a small and a large stretch limit."""
    x, velocity = np.linspace(-3.0, 3.0, 301), np.linspace(-3.0, 3.0, 121)
    model = base.replace(stretch_limit=np.array(SURFACES))
    displacements = np.broadcast_to(x, (model.size, x.size))
    inside = model.strain(displacements) < np.array(SURFACES)[:, None]
    potential = np.where(inside, model.energy(displacements), np.nan)
    total = potential[:, :, None] + 0.5 * velocity**2
    plane = ("surface_limit", "surface_displacement", "surface_velocity")
    return {
        "surface_energy": (plane, total, attributes("energy of film, spring and motion without voltage", "energy")),
        "surface_limit": ("surface_limit", np.array(SURFACES), attributes("stretch limit", "parameter of a surface")),
        "surface_displacement": ("surface_displacement", x, attributes("displacement x = h/(b-a)", "length")),
        "surface_velocity": ("surface_velocity", velocity, attributes("velocity of the disc", "velocity")),
    }


STUDIES = (Study("static", static, work=0.5, films=OF_FORCE), Study("energy", energy, work=0.1))
