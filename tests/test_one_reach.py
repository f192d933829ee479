"""The displacement at which a film reaches its stretch limit is one, whoever asks."""

import numpy as np
import pytest

import gelcone
from gelcone.lab import candidates
from gelcone.paper.studies.study import reach_of


@pytest.mark.parametrize("stretches", [(1.0, 1.0), (1.3, 1.1), (0.9, 1.6)])
def test_forces_comparison_and_studies_end_at_one_displacement(stretches):
    meridional, hoop = stretches
    model = gelcone.ConeModel(meridional_prestretch=meridional, hoop_prestretch=hoop, stretch_limit=20.0)
    compared = gelcone.validate(model, [0.5], elements=2)["cone_limit_displacement"].values.ravel()
    for share, place in zip((0.1, 0.5, 0.9), compared, strict=True):
        lower = model.replace(stretch_limit=20.0 * share)
        low, high = place * (1.0 - 1e-13), place * (1.0 + 1e-13)
        assert np.isfinite(lower.force(low))
        assert np.isnan(lower.force(high))
        assert reach_of(lower) == place


def test_a_design_is_examined_up_to_where_the_forces_of_its_device_end(monkeypatch):
    device = gelcone.find_device("biased-pump").replace({"film": "taut", "material.stretch_limit": 8.0})
    ramps = []
    monkeypatch.setattr(
        candidates, "_rest", lambda *given, own=candidates._rest: ramps.append(own(*given)) or ramps[-1]
    )
    thick = np.array([[device.film_thickness]])
    candidates.examine(device, {"film_thickness": thick}, 1.2)
    model = device.to_model()
    lower = model.replace(stretch_limit=float(model.stretch_limit) * (1.0 - 1e-6))
    assert candidates.GREATEST_HEIGHT > ramps[0][1].item() == pytest.approx(reach_of(lower).item(), rel=1e-14)
