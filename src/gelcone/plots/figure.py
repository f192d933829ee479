"""A figure that a notebook shows as the last line of a cell, without pyplot."""

from __future__ import annotations

from io import BytesIO
from typing import Any, cast

import matplotlib as mpl
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


class ShownFigure(Figure):
    """A matplotlib figure with its own PNG representation, drawn with the settings ``style``."""

    def __init__(self, style: Any, **options: Any) -> None:
        super().__init__(**options)
        self._style = style

    def _repr_png_(self) -> tuple[bytes, dict[str, int]]:
        """The picture, and the size at which it is shown: half of its pixels, for high-density screens."""
        to, canvas = BytesIO(), FigureCanvasAgg(self)
        with mpl.rc_context(self._style):
            cast(Any, canvas).print_png(to)
        width, height = canvas.get_width_height()
        return to.getvalue(), {"width": width // 2, "height": height // 2}
