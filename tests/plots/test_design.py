"""The figure of designs: probabilities with their intervals, and peaks below the limits that the margin leaves."""

import json

import numpy as np

from gelcone.plots.design import design_figure
from tests.plots.made_up import corners, data_of, result


def test_intervals_and_limits_stand_at_their_values():
    designs = result(
        {
            "apparent_power": ("design", [4.0, 3.0]),
            "peak_voltage": ("design", [1500.0, 1700.0]),
            "recommended": ("design", [1600.0, 1800.0]),
            "probability": ("design", [0.95, 0.97]),
            "probability_low": ("design", [0.94, 0.965]),
            "probability_high": ("design", [0.955, 0.99]),
        },
        {"design": ("design", [1, 2])},
        {"apparent_power": "mVA", "peak_voltage": "V"},
        {
            "title": "designs: pump", "objectives": json.dumps(["apparent_power", "peak_voltage"]),
            "margin": 0.2, "confidence": 0.9,
        },
    )  # fmt: skip
    front, share, limit = design_figure(designs).axes
    np.testing.assert_allclose(data_of(front.lines[0]), [[1500.0, 1700.0], [4.0, 3.0]])
    assert {text.get_text(): text.xy for text in front.texts} == {"1": (1500.0, 4.0), "2": (1700.0, 3.0)}
    bars = corners(share.collections[0])
    np.testing.assert_allclose(bars, [[1.0, 1.0, 0.94, 0.955], [2.0, 2.0, 0.965, 0.99]])
    assert [one.get_ydata()[0] for one in share.lines if one.get_linestyle() == "--"] == [0.9]
    heights = {c.get_label(): [bar.get_height() for bar in c] for c in limit.containers}
    np.testing.assert_allclose(heights["first limit"], [2000.0, 2250.0])
    assert heights["peak of the drive"] == [1500.0, 1700.0]
