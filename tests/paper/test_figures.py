"""Figures 3 to 12 of the paper, drawn from studies computed with little effort."""

import pprint
import re
from pathlib import Path
from types import SimpleNamespace

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from gelcone.paper.figures import FIGURES
from gelcone.paper.figures.marks import listed
from gelcone.plots.style import save_figure
from gelcone.presets import load_presets
from tests.paper.figures_table import TABLE
from tests.paper.test_motions import STUDIES, tiny_studies
from tests.plots.described import described

OWN = {study.name for study in STUDIES}
DRAWN = [number for number, figure in FIGURES.items() if set(figure.studies) <= OWN]


def test_the_figures_of_the_paper_are_there_in_order():
    assert list(FIGURES) == [*range(3, 15), "end-of-chaos"]
    assert list(range(3, 13)) == DRAWN


@pytest.mark.parametrize("number", FIGURES)
def test_a_figure_says_what_it_shows_and_where_its_values_are_from(number):
    figure = FIGURES[number]
    assert figure.number == number
    assert set(figure.presets) <= set(load_presets())
    assert len(figure.message.split()) > 40
    assert re.search("text|reconstructed", figure.values)
    # What is computed belongs into the claims: a message holds no number that a run could change.
    assert not re.search(r"\d", figure.message)


def shown(number, drawn):
    """Labels, legends and what is drawn of a figure, with the study of each variable where it has several."""
    studies = FIGURES[number].studies
    named = {f"{study}." if len(studies) > 1 else "": tiny_studies()[study] for study in studies}
    variables = {f"{prefix}{name}": own for prefix, study in named.items() for name, own in study.variables.items()}
    return described(drawn, SimpleNamespace(variables=variables))


@pytest.mark.parametrize("number", DRAWN)
def test_a_figure_draws_with_nothing_clipped(number):
    figure = FIGURES[number]
    drawn = figure.draw({name: tiny_studies()[name] for name in figure.studies})
    if number in TABLE:
        assert shown(number, drawn) == TABLE[number]
    FigureCanvasAgg(drawn).draw()
    width, height = drawn.get_size_inches()
    assert width <= 7.2
    assert height <= 9.0
    box = drawn.get_tightbbox()
    assert (box.x0 > -0.02, box.y0 > -0.02, box.x1 < width + 0.02, box.y1 < height + 0.02) == (True,) * 4
    for axes in drawn.axes:
        if axes.get_label() != "<colorbar>":
            assert axes.get_xlabel() or not any(label.get_visible() for label in axes.get_xticklabels())


def test_a_figure_saves_the_same_bytes_each_time(tmp_path):
    figure = FIGURES[3]
    for name in ("one.svg", "two.svg"):
        save_figure(figure.draw({name: tiny_studies()[name] for name in figure.studies}), tmp_path / name)
    assert (tmp_path / "one.svg").read_bytes() == (tmp_path / "two.svg").read_bytes()


def test_numbers_are_listed_as_words():
    assert listed((0.5, 1.04, 1.7)) == "0.5, 1.04 and 1.7"


def rewrite_table():
    """Writes the table anew."""
    path = Path(__file__).with_name("figures_table.py")
    drawn = {n: FIGURES[n].draw({name: tiny_studies()[name] for name in FIGURES[n].studies}) for n in TABLE}
    found = pprint.pformat({n: shown(n, own) for n, own in drawn.items()}, width=105, sort_dicts=False)
    head = path.read_text(encoding="utf-8").partition("TABLE = ")[0]
    path.write_text(f"{head}TABLE = {found}\n", encoding="utf-8")


if __name__ == "__main__":
    rewrite_table()
