"""What a figure shows, read back from its artists: labels and scales, and the variables that are drawn."""

import re

import numpy as np
from matplotlib import colormaps
from matplotlib.collections import PathCollection, PolyCollection, QuadMesh
from matplotlib.container import BarContainer
from matplotlib.ticker import FuncFormatter

STYLES = {"-": "solid", "--": "dashed", ":": "dotted", "-.": "dash-dotted", "None": "points"}


def tagged(result):
    """The result with a unit of its own for every variable: a label shows whose unit it has."""
    result = result.copy()
    for name, variable in result.variables.items():
        if variable.attrs.get("units") == "1" and "flag_values" not in variable.attrs:
            variable.attrs["units"] = f"of {name}"
    return result


class Sources:
    """The variables of a result by their numbers."""

    def __init__(self, result):
        numbers = {str(n): v.values for n, v in result.variables.items() if v.dtype.kind in "fiu"}
        by_size = sorted(numbers, key=lambda n: (numbers[n].size, n))
        self.known = [(n, np.unique(numbers[n][np.isfinite(numbers[n])].astype(float))) for n in by_size]

    def of(self, values):
        """The smallest variable that holds all of some numbers, or a share of it in percent; - for others."""
        values = np.unique(np.asarray(values, dtype=float))
        values = values[np.isfinite(values)]
        if not values.size:
            return "nothing"
        if (np.abs(values) < 1e-9).all():
            return "0"
        for factor, end in ((1.0, ""), (100.0, " in %")):
            for name, held in self.known:
                if self._holds(factor * held, values):
                    return name + end
        return "-"

    @staticmethod
    def _holds(held, values):
        if not held.size:
            return False
        at = np.clip(np.searchsorted(held, values), 1, held.size - 1) if held.size > 1 else np.zeros(values.size, int)
        nearest = np.minimum(np.abs(held[at] - values), np.abs(held[at - 1] - values))
        return bool((nearest <= 1e-9 * np.abs(values) + 1e-13).all())


def line_words(line, sources, axes):
    """One line: its style, and what lies along x and y."""
    x, y = (np.asarray(v, dtype=float) for v in line.get_data(orig=False))
    style = STYLES.get(line.get_linestyle(), "dashed")
    style = "dashed" if style == "solid" and line.is_dashed() else style
    style += f" {line.get_marker()}" if line.get_marker() not in ("None", None, "") else ""
    if not x.size:
        return f"{style} in the legend"
    over = line.get_transform()
    if over == axes.get_yaxis_transform(which="grid"):
        return f"{style} level at {sources.of(y)}"
    if over == axes.get_xaxis_transform(which="grid"):
        return f"{style} upright at {sources.of(x)}"
    return f"{style} {sources.of(y)} over {sources.of(x)}"


def collection_words(own, sources):
    """Cells of a map, points, and what is filled."""
    if isinstance(own, QuadMesh):
        values = np.ma.filled(np.ma.asarray(own.get_array(), dtype=float), np.nan)
        return f"cells of {sources.of(values)}" + (f" in {own.cmap.name}" if own.cmap.name in colormaps else "")
    if isinstance(own, PathCollection):
        x, y = np.asarray(own.get_offsets()).T
        return f"points {sources.of(y)} over {sources.of(x)}"
    if isinstance(own, PolyCollection) and own.get_paths():
        x, y = np.concatenate([path.vertices for path in own.get_paths()]).T
        return f"filled {sources.of(y[y != 0.0])} over {sources.of(x)}"
    return None


def bar_words(bars, sources):
    """The lengths of bars."""
    across = bars.orientation == "horizontal"
    return f"bars of {sources.of([bar.get_width() if across else bar.get_height() for bar in bars])}"


def plain(text):
    """A text on one line, a # for each number."""
    return re.sub(r"[-\u2212+]?\b\d[\d.]*(e[-+]?\d+)?\b", "#", " ".join(text.split()))


def with_label(words, artist):
    """What is drawn, and what a legend calls it."""
    label = str(artist.get_label())
    return words if not words or not label or label.startswith("_") else f"{words}: {plain(label)}"


def named_ticks(axes):
    """The ticks of an axis that are words, or numbers in a form of their own."""
    for axis in (axes.xaxis, axes.yaxis):
        form = axis.get_major_formatter()
        if isinstance(form, FuncFormatter):
            texts = dict.fromkeys(plain(form(at, k)) for k, at in enumerate(axis.get_ticklocs()))
            yield f"ticks: {', '.join(texts)}" if set(texts) - {"#"} else f"ticks as {form(1.5, 0)}"
        elif type(form).__name__ == "StrCategoryFormatter":
            yield f"ticks: {', '.join(tick.get_text() for tick in axis.get_ticklabels())}"


def written(artists):
    """Texts, each once."""
    return list(dict.fromkeys(text for own in artists if (text := plain(own.get_text()))))


def described(figure, result):
    """Of each axes: labels, title and scales, and what is drawn, each once, in the order of drawing; then the title
    and the legends of the figure."""
    sources, found = Sources(result), []
    for axes in figure.axes:
        log = " and ".join(n for n in "xy" if getattr(axes, f"get_{n}scale")() == "log")
        head = [f"{end}: {plain(text)}" for end, text in (("x", axes.get_xlabel()), ("y", axes.get_ylabel())) if text]
        head += [f"title: {plain(text)}" for side in ("left", "center", "right") if (text := axes.get_title(side))]
        head += [f"log {log}"] * bool(log)
        drawn = [with_label(line_words(line, sources, axes), line) for line in axes.lines]
        drawn += [with_label(collection_words(own, sources), own) for own in axes.collections]
        drawn += [bar_words(own, sources) for own in axes.containers if isinstance(own, BarContainer)]
        drawn += [f"text: {text}" for text in written(axes.texts)]
        drawn = list(dict.fromkeys(words for words in [*drawn, *named_ticks(axes)] if words))
        if drawn or head:
            found.append(("; ".join(head), drawn))
    legends = [own for own in (*(axes.get_legend() for axes in figure.axes), *figure.legends) if own]
    entries = [f"{plain(own.get_title().get_text())}: {', '.join(written(own.get_texts()))}" for own in legends]
    title = written([figure._suptitle] if figure._suptitle else [])
    return [*found, ("figure", [*title, *dict.fromkeys(own.lstrip(": ") for own in entries)])]
