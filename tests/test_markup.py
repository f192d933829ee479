"""The drawing of a cone by its sizes, and the table of its fields, as a notebook shows them."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from gelcone import markup
from gelcone.markup import FLAT, MOST_HEIGHT, RADIUS, TALL, WIDTH

LABELS = ["a = 8 mm", "b = 30 mm", "h0 = 20 mm"]


def tree_of(html):
    """HTML as a tree; XML knows no attribute without a value."""
    return ET.fromstring(html.replace("<details open>", "<details>"))


def drawn(*given, labels=LABELS, **more):
    """Circles as [y, radius], films as corners, texts as [y, words], and the two ends of the dashes, in pixels."""
    parts = list(ET.fromstring(markup.cone(*given, labels, **more)))
    kinds = {
        name: [part for part in parts if part.tag.endswith(name)] for name in ("ellipse", "polygon", "text", "path")
    }
    circles = [[float(one.get(name)) for name in ("cy", "rx")] for one in kinds["ellipse"]]
    assert all(float(one.get("ry")) == pytest.approx(FLAT * float(one.get("rx")), abs=0.06) for one in kinds["ellipse"])
    assert {one.get("cx") for one in kinds["ellipse"]} == {f"{WIDTH / 2:.1f}"}
    films = [np.array([[float(v) for v in place.split(",")] for place in one.get("points").split()])
             for one in kinds["polygon"]]  # fmt: skip
    texts = [(float(one.get("y")), one.text or "") for one in kinds["text"]]
    dashes = [[float(v) for v in one.get("d").partition(" ")[2].split("V")] for one in kinds["path"]]
    return circles, films, texts, dashes


@pytest.mark.parametrize("height", [0.3, -0.3, 0.0])
def test_the_disc_hangs_at_its_height_over_the_rim(height):
    (rim, disc), (film,), _, ((low, high),) = drawn(0.25, height)
    assert (rim[1], disc[1]) == pytest.approx((RADIUS, 0.25 * RADIUS), abs=0.06)
    assert rim[0] - disc[0] == pytest.approx(height * RADIUS, abs=0.11)
    assert (low, high) == (rim[0], disc[0])
    assert film[:, 0] - WIDTH / 2 == pytest.approx([-RADIUS, -0.25 * RADIUS, 0.25 * RADIUS, RADIUS], abs=0.06)
    assert film[:, 1].tolist() == [rim[0], disc[0], disc[0], rim[0]]


@pytest.mark.parametrize(("height", "second"), [(2.0, None), (-2.0, None), (0.5, 1.0), (0.2, -0.9), (0.4, 0.6)])
def test_all_heights_have_one_scale_and_room_on_the_page(height, second):
    circles, films, texts, _ = drawn(0.25, height, second=second)
    rims, disc = circles[:-1], circles[-1]
    scale = min(RADIUS, MOST_HEIGHT / max(abs(height), abs(second or 0.0)))
    assert len(rims) == len(films) == (1 if second is None else 2)
    assert rims[0][0] - disc[0] == pytest.approx(scale * height, abs=0.11)
    if second is not None:
        assert rims[0][0] - rims[1][0] == pytest.approx(scale * second, abs=0.11)
        assert films[1][:, 1].tolist() == [rims[1][0], disc[0], disc[0], rims[1][0]]
    places = [y for y, _ in circles]
    assert 0.5 * (min(places) + max(places)) == pytest.approx(TALL / 2, abs=0.11)
    assert {radius for _, radius in circles[:-1]} == {RADIUS}
    assert disc[1] == pytest.approx(0.25 * RADIUS, abs=0.06)  # heights alone are drawn smaller
    assert all(0.0 < y < TALL for y in (*places, *(y for y, _ in texts)))


def test_labels_stand_above_the_disc_below_all_and_next_to_the_height():
    for height in (0.4, -0.4):
        circles, _, texts, _ = drawn(0.25, height)
        (disc, name), (rim, below), (middle, aside) = texts
        assert [name, below, aside] == LABELS
        assert disc < circles[1][0] - FLAT * circles[1][1]
        assert rim > max(y for y, _ in circles) + FLAT * RADIUS
        assert min(y for y, _ in circles) < middle < max(y for y, _ in circles)


def test_a_height_without_a_name_is_not_measured():
    *_, texts, dashes = drawn(0.25, 0.4, labels=["a", "b", ""])
    assert ([words for _, words in texts], dashes) == (["a", "b", ""], [])


def test_texts_cannot_become_markup():
    given = "<b>&\"'"
    html = markup.shown(given, "DRAWING", [[given, given]])
    tree = tree_of(html)
    assert tree.find("strong").text == given
    assert [cell.text for cell in tree.iter("td")] == [given, given]
    assert "DRAWING" in html
    *_, texts, _ = drawn(0.25, 0.4, labels=[given] * 3)
    assert [words for _, words in texts] == [given] * 3


def test_a_table_has_a_row_for_each_field_in_their_order():
    rows = [["film", "taut", "the film"], ["frequency", "9 Hz", "of the drive"]]
    tree = tree_of(markup.shown("pump", "<svg/>", rows))
    assert [[cell.text for cell in row] for row in tree.iter("tr")] == rows
