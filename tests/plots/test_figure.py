"""A figure as a notebook shows it: its own picture, in the style in which it was drawn, at half its size in pixels."""

from io import BytesIO

import matplotlib as mpl
import numpy as np
from PIL import Image

from gelcone.plots.style import draw_file, styled


def picture(figure):
    data, size = figure._repr_png_()
    with Image.open(BytesIO(data)) as image:
        return np.asarray(image.convert("RGB")), size


def test_the_picture_is_shown_at_half_its_pixels():
    pixels, size = picture(styled(3.0, 2.0, lambda page: page.add_subplot()))
    assert pixels.shape == (400, 600, 3)
    assert size == {"width": 300, "height": 200}


def test_the_picture_is_that_of_the_file_whatever_the_notebook_has_set(tmp_path):
    """What is drawn late, such as ticks that follow from the room, has the style too."""

    def draw(page):
        page.add_subplot().plot([1.0, 2.0], [3.0, 4.0])

    draw_file(styled(3.0, 2.0, draw), tmp_path / "figure.png")
    with Image.open(tmp_path / "figure.png") as image:
        saved = np.asarray(image.convert("RGB"))
    with mpl.rc_context({"font.size": 20.0, "axes.labelsize": 20.0, "lines.linewidth": 9.0}):
        shown, _ = picture(styled(3.0, 2.0, draw))
    np.testing.assert_array_equal(shown, saved)
