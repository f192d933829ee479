"""What `gelcone paper` prints of figures and claims: a table cut to the terminal, where the files are, and JSON."""

import json
import os
import shutil
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from gelcone.cli import paper
from gelcone.paper import report, run, verdicts
from gelcone.paper.figures.figure import Table

OUT = Path("results")


class Number(SimpleNamespace):
    """A number of a claim, as it is written."""

    def __str__(self):
        return self.text


def judged(name, verdict, number, meaning, films):
    numbers = [Number(text=number, meaning=meaning), Number(text="9.9", meaning="another")] if number else []
    return SimpleNamespace(
        claim=SimpleNamespace(name=name), finding=SimpleNamespace(numbers=numbers, verdict=verdict),
        with_film=lambda film: films.get(film, ""),
    )  # fmt: skip


@pytest.fixture
def found(monkeypatch):
    monkeypatch.setattr(report, "films_of", lambda claims: {"wrinkling": "Wrinkling", "creeping": "Creeping film"})
    monkeypatch.setattr(verdicts, "verdict_text", lambda finding: finding.verdict)
    monkeypatch.setattr(run, "claim_record", lambda claim: {"id": claim.claim.name})
    drawn = [
        SimpleNamespace(figure=SimpleNamespace(number=7), png=OUT / "7.png", svg=OUT / "7.svg", data=[OUT / "7.nc"],
        table=None),
        SimpleNamespace(
            figure=SimpleNamespace(number=9), png=OUT / "9.png", svg=OUT / "9.svg", data=[],
            table=Table(("voltage", "kind"), (("0.5", "rest"), ("1.04", "chaos"))),
        ),
    ]  # fmt: skip
    claims = [
        judged("limit", "reproduced", "1.22", "the voltage", {"wrinkling": "holds", "creeping": "fails"}),
        judged("spring", "not reproduced", "", "", {}),
    ]
    return SimpleNamespace(figures=drawn, claims=claims, report=OUT / "report.html", effort="quick")


def test_the_table_of_claims_has_their_films_and_key_numbers(found):
    rows = [[cell.strip() for cell in line.split("  ") if cell.strip()] for line in paper.claim_table(found.claims)]
    assert rows == [
        ["claim", "verdict", "wrinkling", "creeping film", "key number", "which is"],
        ["limit", "reproduced", "holds", "fails", "1.22", "the voltage"], ["spring", "not reproduced"],
    ]  # fmt: skip
    head, first, _ = paper.claim_table(found.claims)
    assert [head.index(word) for word in ("verdict", "key number")] == [
        first.index(word) for word in ("reprod", "1.22")
    ]


def test_the_summary_says_where_everything_is(found):
    lines = paper.summary(found).splitlines()
    assert lines[3:] == [
        "voltage  kind",
        "0.5      rest",
        "1.04     chaos",
        "figures 7, 9 in results",
        f"wrote {OUT / 'report.html'}",
    ]
    found.figures, found.claims = found.figures[:1], []
    assert paper.summary(found).splitlines() == ["figure 7 in results", f"wrote {OUT / 'report.html'}"]


def test_the_answer_as_json(found):
    assert paper.report(found) == {
        "claims": [{"id": "limit"}, {"id": "spring"}],
        "figures": [
            {"number": 7, "png": str(OUT / "7.png"), "svg": str(OUT / "7.svg"), "data": [str(OUT / "7.nc")]},
            {"number": 9, "png": str(OUT / "9.png"), "svg": str(OUT / "9.svg"), "data": [],
             "table": {"head": ("voltage", "kind"), "rows": (("0.5", "rest"), ("1.04", "chaos"))}},
        ],
        "report": str(OUT / "report.html"), "effort": "quick",
    }  # fmt: skip


def test_what_is_typed_decides_what_is_printed(found, command_line, monkeypatch):
    monkeypatch.setattr(run, "run", lambda names, **how: found)
    code, out, _ = command_line("paper", "7")
    assert (code, out.splitlines()[-1]) == (0, f"wrote {OUT / 'report.html'}")
    code, out, _ = command_line("paper", "7", "--json")
    assert (code, json.loads(out)["command"], json.loads(out)["result"]["effort"]) == (0, "paper", "quick")

    def interrupted(names, **how):
        raise KeyboardInterrupt

    monkeypatch.setattr(run, "run", interrupted)
    code, _, err = command_line("paper")
    assert code == 130
    assert "the same command continues from there" in err


@pytest.mark.parametrize(("terminal", "line"), [(True, "abcdefg…"), (False, "abcdefghij")])
def test_lines_are_cut_to_the_width_of_a_terminal_alone(terminal, line, monkeypatch):
    monkeypatch.setattr(shutil, "get_terminal_size", lambda *args, **kwargs: os.terminal_size((8, 24)))
    monkeypatch.setattr(sys.stdout, "isatty", lambda: terminal, raising=False)
    assert paper._cut("abcdefghij") == line
    assert paper._cut("abcdefgh") == "abcdefgh"


@pytest.mark.parametrize(
    ("typed", "names", "options"),
    [
        ((), (), {}),
        (("7", "limit"), ("7", "limit"), {}),
        (("7", "--force"), ("7",), {"force": True}),
        (("--quick",), (), {"quick": True}),
        (("7", "--out", "there"), ("7",), {"out": Path("there")}),
    ],
)
@pytest.mark.parametrize("cores", [2, 16])
def test_what_is_typed_reaches_the_studies(typed, names, options, cores, found, command_line, monkeypatch):
    """At most four processes, and no more than there are cores."""
    asked = []
    monkeypatch.setattr("gelcone.motion.flow.available_threads", lambda: cores)
    monkeypatch.setattr(run, "run", lambda names, *, progress, **how: asked.append((names, how)) or found)
    assert command_line("paper", *typed)[0] == 0
    usual = {"quick": False, "out": None, "force": False, "workers": min(cores, 4)}
    assert asked == [(names, usual | options)]
