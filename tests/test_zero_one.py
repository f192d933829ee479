"""The 0-1 test on series whose answer is known."""

from __future__ import annotations

import numpy as np

from gelcone.motion.zero_one import zero_one


def logistic(parameter: float, count: int = 600) -> np.ndarray:
    x, out = 0.4, []
    for _ in range(count + 200):
        x = parameter * x * (1.0 - x)
        out.append(x)
    return np.array(out[200:])


def test_chaos_is_near_one_and_order_near_zero():
    rotation = np.cos(2.0 * np.pi * (np.sqrt(5.0) - 1.0) / 2.0 * np.arange(600))
    k = zero_one(np.stack([logistic(3.97), logistic(3.5), rotation]))
    assert k[0] > 0.9
    assert (np.abs(k[1:]) < 0.2).all()


def test_a_series_with_nan_has_no_answer():
    series = logistic(3.97)
    series[10] = np.nan
    assert np.isnan(zero_one(series[None])[0])
