"""Results of a device fit: the device, draws of its fields, and the band of its heights over the voltage."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from gelcone import dataset
from gelcone.devices.device import Device
from gelcone.devices.points import field_attributes
from gelcone.errors import InputError, check_result
from gelcone.lab.bench import Variants, field_value
from gelcone.quantity import check_count
from gelcone.statistics import spread

if TYPE_CHECKING:
    import xarray as xr

DRAWS = 64
BAND_DRAWS, BAND_VOLTAGES = 200, 61
"""Number of draws and of voltages of the band."""


def fitted_device(result: xr.Dataset) -> Device:
    """Return the device of a fit.

    Parameters
    ----------
    result : of `fit_device`, also one that `gelcone.load` has read.

    Returns
    -------
    The `Device` with the fitted fields.

    Raises
    ------
    InputError : for a Dataset that is not a device fit.

    Examples
    --------
    >>> import gelcone, pathlib, tempfile
    >>> device = gelcone.find_device("biased-pump").replace(film="taut")
    >>> path = pathlib.Path(tempfile.mkdtemp(), "tests.toml")
    >>> reading = 'frequency = "9 Hz"\\ndecay = "1 1/s"\\nnoise = {frequency = "0.02 Hz", decay = "0.05 1/s"}\\n'
    >>> _ = path.write_text('[[test]]\\nkind = "ring-down"\\n' + reading)
    >>> fit = gelcone.fit_device(device, gelcone.read_device_tests(path), {"moving_mass": 0.5})
    >>> f"{1e3 * gelcone.fitted_device(fit).moving_mass:.2f} g in place of {1e3 * device.moving_mass:.2f} g"
    '8.14 g in place of 5.00 g'
    """
    check_result("fitted_device", result)
    if "fitted" not in result.attrs:
        raise InputError("fitted_device: was given no device fit; give a result of gelcone.fit_device")
    return Device.from_text(result.attrs["fitted"])


def fitted_draws(result: xr.Dataset, count: int = DRAWS, *, seed: int = 0) -> xr.Dataset:
    """Draw fields of a fitted device with the correlations of the fit.

    Parameters
    ----------
    result : of `fit_device`.
    count : number of draws. Default 64.
    seed : of the draws. Default 0.

    Returns
    -------
    Dataset over ``draw`` with a variable for each fitted field, in SI, which `gelcone.over_draws` and `gelcone.design`
    take.

    Raises
    ------
    InputError : for a Dataset that is not a device fit, or fewer than 2 draws.

    Examples
    --------
    >>> import gelcone, pathlib, tempfile
    >>> device = gelcone.find_device("biased-pump").replace(film="taut")
    >>> path = pathlib.Path(tempfile.mkdtemp(), "tests.toml")
    >>> reading = 'frequency = "9 Hz"\\ndecay = "1 1/s"\\nnoise = {frequency = "0.02 Hz", decay = "0.05 1/s"}\\n'
    >>> _ = path.write_text('[[test]]\\nkind = "ring-down"\\n' + reading)
    >>> fit = gelcone.fit_device(device, gelcone.read_device_tests(path), {"moving_mass": 0.5})
    >>> draws = gelcone.fitted_draws(fit, 16)
    >>> draws.sizes["draw"], draws.moving_mass.units
    (16, 'kg')
    """
    import xarray as xr

    device = fitted_device(result)
    check_count("count", count, 2)
    fields = list(map(str, result["field"].values))
    covariance = result["covariance"].values[: len(fields), : len(fields)]
    logs = np.random.default_rng(seed).multivariate_normal(np.zeros(len(fields)), covariance, count, method="cholesky")
    columns = dataset.columns("draw", {
        name: (float(result["value"][k]) * np.exp(logs[:, k]), "", field_attributes(device, name))
        for k, name in enumerate(fields)
    })  # fmt: skip
    attrs = {name: result.attrs[name] for name in ("device", "film", "chi2", "p_value", "refused")}
    return xr.Dataset(columns, attrs=attrs | {"seed": seed, "title": f"draws of {device.name}"})


def fitted_band(result: xr.Dataset) -> str:
    """Write the height of a fitted device over a slow voltage ramp, with its 95 % interval over draws, as a CSV table.

    Draws without a state are left out. The ramp ends at the peak of the drive or at the highest voltage of the tests,
    whichever is larger.
    """
    device, draws = fitted_device(result), fitted_draws(result, BAND_DRAWS)
    names = list(map(str, draws.data_vars))
    factors = np.stack([draws[name].values / field_value(device, name) for name in names], axis=1)
    variants = Variants(device, names, np.concatenate([np.ones((1, len(names))), factors]), {})
    peak = float(device.to_model().peak_voltage) * device.scales.voltage
    volts = np.linspace(0.0, max(peak, float(result.attrs["highest_voltage"])), BAND_VOLTAGES)
    heights = 1e3 * (variants.rest * variants.scale("length") + variants.stroke(volts))
    low, _, high = spread(heights[1:])
    rows = zip(volts, heights[0], low, high, strict=True)
    lines = [",".join(f"{value:.6g}" for value in row) for row in rows if np.isfinite(row).all()]
    return "\n".join(["voltage (V),height (mm),height low (mm),height high (mm)", *lines, ""])
