"""Look shared by all figures: what is written."""

from PIL import Image

from gelcone.plots.style import numbered, save_figure, styled


def test_names_in_an_svg_do_not_depend_on_the_last_bits_of_the_layout():
    svg = '<g clip-path="url(#{0})" style="fill: #1f77b4"/><path id="{1}"/><use href="#{1}"/><clipPath id="{0}"/>'
    one, two = (numbered(svg.format(*names)) for names in (("p04da9c31dc", "m1"), ("pccf9ffa184", "m1")))
    assert one == two == svg.format("n0", "m1")


def test_a_picture_has_two_hundred_points_an_inch(tmp_path):
    save_figure(styled(2.0, 1.5, lambda page: [page.add_subplot()]), tmp_path / "picture.png")
    with Image.open(tmp_path / "picture.png") as picture:
        assert picture.size == (400, 300)
