"""A device as a notebook shows it: its drawing by its sizes, and what is set with its unit."""

import pytest

import gelcone
from gelcone.devices import shown

PUMP = gelcone.find_device("biased-pump").replace(film="taut")


@pytest.fixture
def drawn(monkeypatch):
    """What is drawn and shown of a device: the arguments of the drawing, and the rows of the table by name."""
    given = {}
    monkeypatch.setattr(shown.markup, "cone", lambda *arguments: given.update(cone=arguments) or "drawing")
    monkeypatch.setattr(shown.markup, "shown", lambda name, drawing, rows: given.update(name=name, rows=rows) or "html")

    def show(device):
        assert shown.device_html(device) == "html"
        return given["cone"], {name: value for name, value, _ in given["rows"]}

    return show


def test_a_device_is_drawn_by_its_radii_and_the_free_height_of_its_spring(drawn):
    (inner, height, labels, second), rows = drawn(PUMP)
    assert inner == pytest.approx(8.0 / 30.0)
    assert height == pytest.approx(20.0 / 30.0)
    assert labels == ["a = 8 mm", "b = 30 mm", "h0 = 20 mm"]
    assert second is None
    assert rows["material"] == "PVC-DBA 6:1"
    assert rows["film_thickness"] == "200 um"
    assert rows["film"] == "taut"
    assert not {"name", "release_velocity", "second_film", "material.name", "material.sources"} & set(rows)


def test_a_double_cone_without_a_spring_is_drawn_between_its_rims(drawn):
    pair = gelcone.find_device("double-cone").replace(film="taut", second_film="taut")
    (_, height, labels, second), _ = drawn(pair)
    assert second == pytest.approx(20.0 / 25.0)
    assert height == pytest.approx(0.5 * second)
    assert labels[2] == ""
    (_, height, labels, second), _ = drawn(pair.replace(spring_rate=5.0, initial_height="5 mm"))
    assert (height, labels[2]) == (pytest.approx(0.2), "h0 = 5 mm")


def test_of_several_devices_means_are_drawn_and_ranges_shown(drawn):
    several = PUMP.replace(film_radius=[0.03, 0.05], frequency=[8.0, 10.0])
    (inner, *_), rows = drawn(several)
    assert inner == pytest.approx(8.0 / 40.0)
    assert rows["frequency"] == "8 to 10 Hz (2)"


@pytest.mark.parametrize(
    ("offset", "row"),
    [([0.0, 500.0], "0 to 500 V (2)"), ([500.0, 0.0, 300.0], "0 to 500 V (3)"), ([0.0, 0.0], None), (0.0, None)],
)
def test_a_field_is_shown_where_one_device_at_least_has_another_than_its_default(drawn, offset, row):
    _, rows = drawn(PUMP.replace(voltage_offset=offset))
    assert rows.get("voltage_offset") == row
    assert rows["frequency"] == "10 Hz"  # a required one always


def test_the_other_rim_is_drawn_in_the_plane_of_the_first_where_no_height_is_given(drawn):
    pair = gelcone.find_device("double-cone").replace(film="taut", second_film="taut", second_flat_height=None)
    (_, height, labels, second), _ = drawn(pair.replace(spring_rate=0.0))
    assert (height, labels[2], second) == (0.0, "", 0.0)


def test_a_range_has_its_least_and_its_largest_value_wherever_they_stand(drawn):
    _, rows = drawn(PUMP.replace(frequency=[9.0, 8.0, 12.0]))
    assert rows["frequency"] == "8 to 12 Hz (3)"
    _, rows = drawn(PUMP.replace({"material.shear_modulus": 2e4, "waveform": "square"}))
    assert (rows["material.shear_modulus"], rows["waveform"]) == ("20 kPa", "square")
    assert "material.shear_modulus_range" not in rows
