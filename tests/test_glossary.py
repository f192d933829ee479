"""The words of tables and figures are explained, in one place."""

import sys
from pathlib import Path

import pytest

import gelcone
from gelcone import glossary
from gelcone.codes import FilmPullIn
from gelcone.motion.driven import DRIVEN_LIMITS
from gelcone.motion.envelope import STATIC_LIMITS
from gelcone.words import FAILINGS

sys.path.insert(0, str(Path(__file__).parents[1] / "docs" / "site"))

import pages

SHOWN = {
    *(name.replace("dielectric ", "") for name in (*DRIVEN_LIMITS, *STATIC_LIMITS) if name != "chaos"),
    *(words for name, words in FAILINGS.items() if name not in ("breakdown", "pulled_in")),
    *(kind.label for kind in FilmPullIn if kind),
    *(kind.label for kind in gelcone.Regime),
    *("stroke", "blocked force", "apparent power", "kick", "window", "pull-in at a constant voltage", "crumpled"),
}
"""What envelopes, statics, runs and maps print."""


@pytest.mark.parametrize("term", sorted(SHOWN))
def test_what_is_shown_is_explained(term, command_line):
    code, out, err = command_line("help", term)
    assert (code, err) == (0, "")
    head, *meaning = out.partition("\n\n")[0].splitlines()
    assert head == glossary.find_term(term)
    assert " ".join(line.strip() for line in meaning) == glossary.GLOSSARY[head]


def test_the_page_is_the_glossary(command_line):
    page = Path(__file__).parents[1] / "docs" / "glossary.md"
    assert page.read_text(encoding="utf-8") == pages.glossary()
    listed = command_line("help", "glossary")[1]
    assert all(f"\n{term}\n" in f"\n{listed}" for term in glossary.GLOSSARY)


def test_help_and_figures_point_to_it(command_line):
    assert "gelcone help glossary" in " ".join(command_line("--help")[1].split())
    figure = gelcone.plot(gelcone.simulate(gelcone.ConeModel(), times=[0.0, 1.0]))
    assert figure.texts[-1].get_text().endswith("terms: gelcone help glossary")


def test_a_term_is_found_however_it_is_written(command_line):
    assert command_line("help", "Pull-In")[1] == command_line("help", "pull_in")[1] != ""
    code, _, err = command_line("help", "pul-in")
    assert code == 2
    assert "did you mean 'pull-in'" in err
