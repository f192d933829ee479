"""The study of spectra: two windows of each motion, at three voltages of two sets."""

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
    for row, name in zip(np.broadcast_to(model.drive_frequency, (2, 3)), module.SETS, strict=True):
        assert (row == find_preset(name).model.drive_frequency).all()
    assert initial == find_preset(module.SETS[0]).initial
