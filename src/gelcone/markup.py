"""The representation of devices and models in notebooks: a drawing (SVG) and a table (HTML), all texts escaped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

WIDTH, TALL = 300, 180
RADIUS, FLAT = 105.0, 0.22
"""Radius of the rim in the drawing, and the aspect ratio of circles seen from the side."""
MOST_HEIGHT = 70.0


def shown(title: str, drawing: str, rows: Iterable[Sequence[str]]) -> str:
    """A title, a drawing and a table; the first text of each row is a name."""
    cells = ("".join(f'<td style="text-align:left">{escape(text)}</td>' for text in row) for row in rows)
    table = "".join(f"<tr>{cell}</tr>" for cell in cells)
    return (
        f'<div><strong>{escape(title)}</strong><div style="display:flex;flex-wrap:wrap;align-items:flex-start">'
        f"{drawing}<details open><summary>fields</summary><table>{table}</table></details></div></div>"
    )


def cone(inner: float, height: float, labels: Sequence[str], second: float | None = None) -> str:
    """The drawing of a cone: a disc of radius ``inner`` at ``height`` above the rim's plane, both over the rim's
    radius; ``second`` is the height of the rim of a second film. ``labels`` are of disc, rim and height."""
    levels = [height, 0.0, *([] if second is None else [second])]
    scale = RADIUS
    if (reach := max(map(abs, levels))) * scale > MOST_HEIGHT:
        scale = MOST_HEIGHT / reach
    middle, base = 0.5 * WIDTH, 0.5 * TALL + 0.5 * scale * (max(levels) + min(levels))
    up = {level: base - scale * level for level in levels}
    small = RADIUS * inner

    def circle(radius: float, y: float, fill: str) -> str:
        return (
            f'<ellipse cx="{middle:.1f}" cy="{y:.1f}" rx="{radius:.1f}" ry="{FLAT * radius:.1f}" fill="{fill}" '
            'stroke="currentColor"/>'
        )

    def film(y: float) -> str:
        side = [(middle - RADIUS, y), (middle - small, up[height]), (middle + small, up[height]), (middle + RADIUS, y)]
        points = " ".join(f"{x:.1f},{y:.1f}" for x, y in side)
        return f'<polygon points="{points}" fill="#56B4E9" fill-opacity="0.35" stroke="currentColor"/>'

    def text(x: float, y: float, words: str, anchor: str = "middle") -> str:
        return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(words)}</text>'

    rims = [0.0] if second is None else [0.0, second]
    parts = [part for level in rims for part in (circle(RADIUS, up[level], "none"), film(up[level]))]
    right = middle + RADIUS + 8.0
    dashes = f'<path d="M{right:.1f} {up[0.0]:.1f}V{up[height]:.1f}" stroke="currentColor" stroke-dasharray="3 2"/>'
    parts += [
        circle(small, up[height], "#888888"),
        dashes if labels[2] else "",
        text(middle, up[height] - FLAT * small - 4.0, labels[0]),
        text(middle, max(up.values()) + FLAT * RADIUS + 13.0, labels[1]),
        text(right + 4.0, 0.5 * (up[0.0] + up[height]) + 4.0, labels[2], "start"),
    ]
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH + 60}" height="{TALL}" font-size="11" '
        f'fill="currentColor" role="img" aria-label="drawing of the cone">{"".join(parts)}</svg>'
    )
