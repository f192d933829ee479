"""A figure of the paper: its names, its command and its texts, into which what is varied is put."""

import pytest

from gelcone.paper.figures import FIGURES, figure
from gelcone.paper.figures.figure import PaperFigure, Table, paper_figure


def drawn(studies):
    return "drawn", studies


def tabled(studies):
    return Table(("a",), (("b",),))


def test_a_numbered_figure_is_named_by_its_number_and_another_by_its_name():
    own = PaperFigure(3, "Forces", ("base",), "v", "a message", ("static",), drawn)
    assert (own.name, own.heading, own.command) == ("figure-03", "Figure 3: Forces", "gelcone paper 3")
    assert own.table is None
    other = PaperFigure("end-of-chaos", "Ends", ("base",), "v", "a message", ("static",), drawn)
    assert (other.name, other.heading) == ("end-of-chaos", "Ends")
    assert other.command == "gelcone paper end-of-chaos"
    assert PaperFigure(12, "T", (), "", "", (), drawn).name == "figure-12"


def test_texts_are_those_of_the_figure_with_what_is_varied_put_in(monkeypatch):
    texts = {
        "7": {
            "title": "Seven",
            "presets": ["base", "fast"],
            "values": "at {volts}, {more:g}",
            "message": "says {this}",
        },
        "own": {"title": "Own", "presets": [], "values": "none", "message": "nothing"},
    }
    monkeypatch.setattr(figure, "_texts", lambda: texts)
    found = paper_figure(7, ("one", "two"), drawn, tabled, volts="1 and 2", more=2.50)
    assert found == PaperFigure(
        7, "Seven", ("base", "fast"), "at 1 and 2, 2.5", "says {this}", ("one", "two"), drawn, tabled
    )
    assert paper_figure("own", (), drawn).title == "Own"
    with pytest.raises(KeyError):
        paper_figure(7, (), drawn, volts="1")


def test_figures_stand_in_the_order_of_the_paper_and_each_knows_its_number():
    assert list(FIGURES) == [3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, "end-of-chaos"]
    assert all(own.number == number for number, own in FIGURES.items())
    assert [number for number, own in FIGURES.items() if own.table] == ["end-of-chaos"]
    studies = {number: own.studies for number, own in FIGURES.items()}
    assert studies[3] == ("static", "continuum")
    assert studies[12] == ("frequency", "frequency-responses")
    assert studies[14] == ("map-radial", "map-equibiaxial")
    assert [studies[number] for number in (4, 5, 7, 10, 11)] == [
        ("damping",), ("limit",), ("voltage",), ("prestretch",), ("spring",)
    ]  # fmt: skip
    assert not any("{" in own.values or "{" in own.message for own in FIGURES.values())
