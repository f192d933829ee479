"""The study of spectra: two windows of each motion, at three voltages of two sets."""

import json

import numpy as np
import pytest
import xarray as xr

from gelcone.motion.spectrum import FEWEST_PERIODS
from gelcone.paper.effort import QUICK
from gelcone.paper.studies import spectra as module
from gelcone.paper.studies.triples import TRIPLES
from gelcone.presets import find_preset


class Enough(Exception):
    """Both windows have been asked for."""


def test_the_early_window_is_the_shortest_from_the_start_and_the_late_one_the_efforts_once_all_have_settled(
    monkeypatch,
):
    asked = []

    def spectrum(model, initial, *, progress, **options):
        asked.append((model, initial, options))
        if len(asked) == 2:
            raise Enough
        return xr.Dataset()

    settled = np.linspace(10.0, 500.0, 6).reshape(2, 3)
    monkeypatch.setattr(module, "spectrum", spectrum)
    monkeypatch.setattr(module, "kinds_of", lambda *_: xr.Dataset({"settled_time": (("a", "b"), settled)}))
    with pytest.raises(Enough):
        module.spectra(QUICK, lambda share: None)
    (model, initial, early), (_, _, late) = asked
    assert early == {"periods": FEWEST_PERIODS, "discard": 0}
    periods = np.broadcast_to(model.members().forcing_period, (6,))
    assert late == {"periods": QUICK.spectrum_periods, "discard": int(np.ceil((settled.ravel() / periods).max()))}
    assert model.shape == (2, 3)
    np.testing.assert_array_equal(np.broadcast_to(model.voltage, (2, 3)), [TRIPLES["voltage"][2]] * 2)
    for parameter in ("drive_frequency", "spring_stiffness"):
        for row, name in zip(np.broadcast_to(model.values[parameter], (2, 3)), module.SETS, strict=True):
            assert (row == find_preset(name).model.values[parameter]).all()
    assert initial == find_preset(module.SETS[0]).initial


def test_a_study_of_spectra_has_both_windows_by_name_over_set_and_voltage(monkeypatch):
    shares = []

    def spectrum(model, initial, *, periods, discard, progress):
        progress(1.0)
        lines = 5 if discard else 3
        cells = 10.0 * np.arange(2)[:, None, None] + np.arange(3)[:, None] + 0.1 * discard * np.ones(lines)
        at = ("member_0", "member_1")
        return xr.Dataset(
            {"amplitude": ((*at, "line"), cells), "initial": 1.0, "outcome": (at, np.zeros((2, 3)))},
            coords={"frequency": ((*at, "line"), cells + 100.0), "frequency_ratio": ((*at, "line"), cells + 200.0),
                    "voltage": (at, np.asarray(model.voltage) * np.ones((2, 1)))},
        )  # fmt: skip

    def kinds(model, initial, effort):
        at = ("member_0", "member_1")
        settled = np.full((2, 3), 2.5) * np.asarray(model.members().forcing_period).reshape(2, 3)
        data = {"settled_time": (at, settled), "regime": (at, np.arange(6).reshape(2, 3)), "section": 3.0}
        voltage = (at, np.asarray(model.voltage) * np.ones((2, 1)), {"long_name": "v"})
        return xr.Dataset(data, coords={"voltage": voltage}, attrs={"model": "own"})

    monkeypatch.setattr(module, "spectrum", spectrum)
    monkeypatch.setattr(module, "kinds_of", kinds)
    found = module.spectra(QUICK, shares.append)
    assert sum(shares) == pytest.approx(1.0)
    assert found["set"].values.tolist() == ["base", "fast"]
    np.testing.assert_array_equal(found["voltage"], TRIPLES["voltage"][2])
    assert found["voltage"].attrs == {"long_name": "v"}
    cells = 10.0 * np.arange(2)[:, None] + np.arange(3)
    assert found["amplitude"].dims == ("set", "voltage", "line")
    np.testing.assert_allclose(found["early_amplitude"][..., 0], cells)
    np.testing.assert_allclose(found["amplitude"][..., 4], cells + 0.3)
    np.testing.assert_allclose(found["early_frequency_ratio"][..., 1], cells + 200.0)
    np.testing.assert_allclose(found["frequency"][..., 1], cells + 100.3)
    np.testing.assert_array_equal(found["regime"], np.arange(6).reshape(2, 3))
    assert (found.sizes["early_line"], found.sizes["line"]) == (3, 5)
    assert "section" not in found
    assert "outcome" not in found
    attributes = {"model": "own", "preset": "base, fast", "parameter": "voltage", "title": "spectra at three voltages"}
    assert attributes.items() <= found.attrs.items()
    initial = list(find_preset("base").initial)
    options = {"initial": initial, "periods": QUICK.spectrum_periods, "settled_repeats": 3}
    assert json.loads(found.attrs["options"]) == options
