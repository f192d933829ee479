"""Look shared by all figures: what is written, units on axes, second axes."""

import pytest
from PIL import Image

from gelcone.plots.style import CYCLE, axis_label, coordinate_axis, log_ticks, numbered, save_figure, styled
from tests.plots.made_up import blank, result


def test_names_in_an_svg_do_not_depend_on_the_last_bits_of_the_layout():
    svg = '<g clip-path="url(#{0})" style="fill: #1f77b4"/><path id="{1}"/><use href="#{1}"/><clipPath id="{0}"/>'
    one, two = (numbered(svg.format(*names)) for names in (("p04da9c31dc", "m1"), ("pccf9ffa184", "m1")))
    assert one == two == svg.format("n0", "m1")


def test_a_picture_has_two_hundred_points_an_inch(tmp_path):
    save_figure(styled(2.0, 1.5, lambda page: [page.add_subplot()]), tmp_path / "picture.png")
    with Image.open(tmp_path / "picture.png") as picture:
        assert picture.size == (400, 300)


def test_the_kind_of_file_follows_from_its_name(tmp_path):
    for suffix, begin in (("png", b"\x89PNG"), ("svg", b"<?xml"), ("pdf", b"%PDF")):
        path = tmp_path / f"picture.{suffix}"
        save_figure(styled(2.0, 1.5, lambda page: [page.add_subplot()]), path)
        assert path.read_bytes().startswith(begin)
    assert b"CreationDate" not in (tmp_path / "picture.pdf").read_bytes()
    assert b"<dc:date>" not in (tmp_path / "picture.svg").read_bytes()


def test_the_palette_has_no_colour_twice():
    assert len(set(CYCLE)) == len(CYCLE) == 6


def test_a_label_bears_the_unit_of_a_variable_that_has_one():
    data = result({"x": ("t", [1.0]), "y": ("t", [1.0])}, units={"x": "mm"})
    assert axis_label(data["x"], "displacement") == "displacement (mm)"
    assert axis_label(data["y"], "displacement") == "displacement"
    assert axis_label(data["y"].drop_attrs(), "displacement") == "displacement"


def test_a_log_scale_has_plain_numbers():
    axes = blank()
    axes.set_xlim(1.0, 60.0)
    log_ticks(axes)
    axes.figure.draw_without_rendering()
    shown = [text.get_text() for text in axes.get_xticklabels()]
    assert {"1", "2", "5", "10", "20", "50"} <= set(shown)
    assert axes.get_xscale() == "log"
    assert not any(text.get_text() for text in axes.get_xticklabels(minor=True))


def over():
    return result({}, {"drive_frequency": ("drive_frequency", [1.0, 2.0, 4.0])})


@pytest.mark.parametrize("name", ["xaxis", "yaxis"])
def test_an_axis_bears_the_name_of_its_coordinate(name):
    axis = getattr(blank(), name)
    coordinate_axis(axis, over(), "drive_frequency")
    assert axis.get_label_text() == "drive frequency"
    coordinate_axis(axis, over(), "voltage")
    assert axis.get_label_text() == "drive frequency"
