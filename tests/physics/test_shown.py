"""A model as a notebook shows it: a drawing by its ratio and heights, over the film's radius, and its numbers."""

import numpy as np
import pytest

from gelcone.physics import shown
from gelcone.physics.model import ConeModel


@pytest.mark.parametrize(
    ("changes", "inner", "height", "second"),
    [
        ({"rest_height": 0.5}, None, 0.5, None),
        ({"bias": "weight"}, None, 0.0, None),
        ({"rest_height": [0.4, 0.6], "radius_ratio": 0.4}, 0.4, 0.5, None),
        ({"rest_height": 0.3, "radius_ratio": 0.25, "second_film": "taut", "second_flat_height": 0.8}, 0.25, 0.3, 0.8),
    ],
)
def test_heights_are_drawn_over_the_radius_of_the_film(monkeypatch, changes, inner, height, second):
    """They are given over the width of the ring, b - a = (1 - a/b) b; of an ensemble the means."""
    drawn = {}
    monkeypatch.setattr(shown.markup, "cone", lambda *given: drawn.update(cone=given) or "drawing")
    monkeypatch.setattr(shown.markup, "shown", lambda name, drawing, rows: drawn.update(rows=rows) or "html")
    model = ConeModel(film="taut", **changes)
    assert model._repr_html_() == "html"
    ratio, at, labels, other = drawn["cone"]
    inner = shown.INNER if inner is None else inner
    assert ratio == pytest.approx(inner)
    assert at == pytest.approx(height * (1.0 - inner))
    assert other == (None if second is None else pytest.approx(second * (1.0 - inner)))
    assert labels[2] == f"x0 = {height:g}"
    rows = {name: value for name, value, _ in drawn["rows"]}
    assert rows["film"] == "taut"
    if "rest_height" not in changes:
        assert "rest_height" not in rows
        return
    assert rows["rest_height"] == ("0.4 to 0.6 (2)" if np.ndim(changes["rest_height"]) else f"{height:g}")
