"""`gelcone paper`: what is selected, computed, kept and continued; with small studies in place of the real ones."""

import dataclasses
import json
import os
import time
from dataclasses import dataclass, field, replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from click.testing import CliRunner

from gelcone import cli, dataset
from gelcone.codes import Outcome
from gelcone.dataset import load, save
from gelcone.errors import InputError
from gelcone.paper import run as run_module
from gelcone.paper import run as running
from gelcone.paper.claims import Claim
from gelcone.paper.effort import QUICK
from gelcone.paper.figures.figure import PaperFigure, Table
from gelcone.paper.films import OTHER_FILMS
from gelcone.paper.numbers import Number
from gelcone.paper.report import DrawnFigure
from gelcone.paper.run import Paper, Selection, run, select
from gelcone.paper.stamp import sources
from gelcone.paper.studies.study import Study
from gelcone.paper.truths import share
from gelcone.paper.verdicts import Finding, Verdict
from gelcone.plots.style import styled


@dataclass
class Laboratory:
    """A paper of three studies, three figures and three claims, that counts what is computed and drawn."""

    computed: list = field(default_factory=list)
    drawn: list = field(default_factory=list)
    stop_at: str = ""
    films: tuple = ()

    def study(self, name):
        def compute(effort, progress):
            if name == self.stop_at:
                raise KeyboardInterrupt
            self.computed.append(name if effort.film == "taut" else f"{name} {effort.film}")
            progress(0.25)
            progress(0.75)
            values = np.random.default_rng(len(name)).normal(size=effort.diagram_values)
            attrs = {"title": name, "totals": str(time.perf_counter())}
            pulled_in = np.where(values > 0.5, Outcome.PULLED_IN, Outcome.OK) if effort.film != "taut" else 0 * values
            variables = {
                "x": ("time", values, {"units": "1", "long_name": name}),
                "outcome": ("time", pulled_in.astype(np.int8), {"units": "1"}),
            }
            return xr.Dataset(variables, attrs=attrs)

        return Study(name, compute, work=0.1, films=self.films)

    def figure(self, number, *studies):
        def draw(data):
            self.drawn.append(number)
            return styled(2.0, 1.5, lambda page: [page.add_subplot().plot(data[name]["x"].values) for name in studies])

        message = f"What figure {number} shows."
        return PaperFigure(number, f"Title {number}", ("base",), "voltage 0.5 (text)", message, studies, draw)

    def claim(self, name, figure, *studies):
        def check(data):
            mean = float(np.mean([data[study]["x"].mean() for study in studies]))
            return Finding(holds=True, numbers=(Number("mean", mean, error=0.1), Number("none", np.nan)), why="because")

        return Claim(name, f"Statement of {name}.", figure, studies, check)

    @property
    def paper(self):
        studies = [self.study(name) for name in ("swing", "rest", "limit")]
        figures = [self.figure(3, "swing"), self.figure(4, "swing", "rest"), self.figure(13, "rest")]
        claims = [self.claim("first", 3, "swing"), self.claim("second", 4, "rest"), self.claim("third", 13, "limit")]
        return Paper(
            {study.name: study for study in studies},
            {figure.number: figure for figure in figures},
            {claim.name: claim for claim in claims},
        )


@pytest.fixture
def laboratory():
    return Laboratory()


def contents(folder):
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())


# --- what is selected -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", [3, "3", "03", "figure-03", "figure-3", "Figure 3", "fig3", "figure_03"])
def test_a_figure_has_many_names(laboratory, name):
    assert select([name], laboratory.paper) == Selection((3,), ())


def test_names_are_taken_once_and_none_means_all(laboratory):
    assert select(["second", "4", 4, "second"], laboratory.paper) == Selection((4,), ("second",))
    assert select([], laboratory.paper) == Selection((3, 4, 13), ("first", "second", "third"))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("secnd", "'secnd' is not a figure or claim of the paper; did you mean 'second'?"),
        ("7x", "'7x' is not a figure or claim of the paper; known: first, second, third"),
        ("2", "figure 2: is not one of those that are redrawn: 3, 4, 13"),
    ],
)
def test_what_is_unknown_is_refused_before_any_work(laboratory, tmp_path, name, message):
    with pytest.raises(InputError) as error:
        run(["first", name], out=tmp_path / "out", paper=laboratory.paper)
    assert str(error.value) == message
    assert laboratory.computed == []
    assert not (tmp_path / "out").exists()


# --- a figure that the paper does not have ----------------------------------------------------------------------------


def with_extra(paper):
    """The small paper with a figure of a name and a table of two rows."""

    def table(studies):
        return Table(("added", "count"), (("nothing", "3"), ("x <= 1", f"{studies['swing'].sizes['time']}")))

    return replace(paper, figures={**paper.figures, "extra": replace(paper.figures[3], number="extra", table=table)})


def test_a_figure_of_our_own_is_asked_for_by_its_name_and_comes_last(laboratory):
    paper = with_extra(laboratory.paper)
    assert select(["extra", "4"], paper) == Selection(("extra", 4), ())
    assert select([], paper).figures == (3, 4, 13, "extra")
    with pytest.raises(InputError, match="'extr' is not a figure or claim of the paper; did you mean 'extra'"):
        select(["extr"], paper)


def test_its_table_stands_in_the_report_in_claims_json_and_on_the_terminal(laboratory, tmp_path, monkeypatch):
    monkeypatch.setattr(running, "source_paper", lambda: with_extra(laboratory.paper))
    answer = CliRunner().invoke(cli.group, ["paper", "extra", "--quick", "--out", str(tmp_path)])
    lines = answer.output.splitlines()
    assert [line.split() for line in lines[:3]] == [["added", "count"], ["nothing", "3"], ["x", "<=", "1", "41"]]
    assert lines[3] == f"figure extra in {tmp_path}"
    assert {"extra.png", "extra.svg", "data/swing.nc"} <= set(contents(tmp_path))
    tables = json.loads((tmp_path / "claims.json").read_text())["tables"]
    assert tables == {"extra": {"head": ["added", "count"], "rows": [["nothing", "3"], ["x <= 1", "41"]]}}
    page = (tmp_path / "report.html").read_text()
    for part in (
        '<section id="extra">', "<h2>Title 3</h2>", "<th>count</th>", "<tr><td>x &lt;= 1</td><td>41</td></tr>",
        "<code>gelcone paper extra</code>",
    ):  # fmt: skip
        assert part in page
    asked = CliRunner().invoke(cli.group, ["paper", "extra", "--quick", "--out", str(tmp_path), "--json"])
    (figure,) = json.loads(asked.output)["result"]["figures"]
    assert (figure["number"], figure["table"]) == ("extra", tables["extra"])


# --- what a run writes ------------------------------------------------------------------------------------------------


def test_a_run_writes_data_figures_claims_and_report(laboratory, tmp_path):
    result = run(quick=True, out=tmp_path, paper=laboratory.paper)
    pictures = [f"figure-{n:02d}.{suffix}" for n in (3, 4, 13) for suffix in ("png", "svg")]
    data = [f"data/{name}.nc" for name in ("swing", "rest", "limit")]
    assert contents(tmp_path) == sorted([*pictures, *data, "claims.json", "report.html"])
    assert [judged.verdict for judged in result.claims] == [Verdict.REPRODUCED] * 3
    assert [(drawn.figure.number, drawn.png.name) for drawn in result.figures] == [
        (3, "figure-03.png"),
        (4, "figure-04.png"),
        (13, "figure-13.png"),
    ]
    attrs = load(tmp_path / "data" / "swing.nc").attrs
    assert (attrs["effort"], attrs["gelcone_version"], attrs["title"]) == ("quick", running.__version__, "swing")
    record = json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))
    assert (record["effort"], [claim["id"] for claim in record["claims"]]) == ("quick", ["first", "second", "third"])
    assert record["claims"][0]["numbers"][1] == {
        "meaning": "none",
        "value": None,
        "error": None,
        "low": None,
        "high": None,
        "unit": "",
        "text": "none",
    }


def test_progress_names_the_work_and_adds_up_to_one(laboratory, tmp_path):
    steps = []
    run(quick=True, out=tmp_path, paper=laboratory.paper, progress=lambda *step: steps.append(step))
    assert sum(share for _, share in steps) == pytest.approx(1.0)
    labels = list(dict.fromkeys(label for label, _ in steps))
    assert sorted(labels, key=lambda label: label.startswith("figure")) == [
        "swing, for figures 3, 4",
        "rest, for figures 4, 13",
        "limit, for third",
        "figure 3",
        "figure 4",
        "figure 13",
    ]


def test_the_same_run_gives_the_same_bytes(laboratory, tmp_path):
    for folder in ("one", "two"):
        run(quick=True, out=tmp_path / folder, paper=laboratory.paper)
    for path in ("claims.json", "figure-04.png", "figure-04.svg"):
        assert (tmp_path / "one" / path).read_bytes() == (tmp_path / "two" / path).read_bytes()
    one, two = (load(tmp_path / folder / "data" / "rest.nc") for folder in ("one", "two"))
    xr.testing.assert_identical(one, two)


def test_what_computes_is_part_of_the_program_and_what_shows_is_not():
    names = {name for name, _ in sources()}
    assert {
        "physics/model.py",
        "motion/flow.py",
        "paper/studies/maps.py",
        "presets.toml",
        "devices/materials.toml",
    } <= names
    assert "devices/paper-table1.toml" in names
    assert not {name for name in names if name.startswith(("cli", "plots", "paper/figures"))}
    assert "paper/claims/claim.py" not in names


# --- what is continued ------------------------------------------------------------------------------------------------


def test_what_is_there_is_not_computed_again(laboratory, tmp_path):
    run(quick=True, out=tmp_path, paper=laboratory.paper)
    before = {path: (tmp_path / path).read_bytes() for path in contents(tmp_path)}
    run(quick=True, out=tmp_path, paper=laboratory.paper)
    assert laboratory.computed == ["swing", "rest", "limit"]
    assert {path: (tmp_path / path).read_bytes() for path in contents(tmp_path)} == before


def test_an_interrupted_run_leaves_whole_files_and_continues(laboratory, tmp_path):
    laboratory.stop_at = "rest"
    with pytest.raises(KeyboardInterrupt):
        run(quick=True, out=tmp_path, paper=laboratory.paper)
    left = contents(tmp_path)
    assert left in (["data/swing.nc"], ["data/swing.nc", "figure-03.png", "figure-03.svg"])
    laboratory.stop_at = ""
    run(quick=True, out=tmp_path, paper=laboratory.paper)
    assert laboratory.computed == ["swing", "rest", "limit"]


def test_a_figure_that_cannot_be_drawn_stops_the_run_and_keeps_the_data(laboratory, tmp_path):
    def draw(data):
        raise RuntimeError("no ink")

    paper = laboratory.paper
    figures = paper.figures | {3: dataclasses.replace(paper.figures[3], draw=draw)}
    with pytest.raises(RuntimeError, match="no ink"):
        run(quick=True, out=tmp_path, paper=dataclasses.replace(paper, figures=figures))
    assert {"data/swing.nc", "data/rest.nc", "data/limit.nc"} <= set(contents(tmp_path))
    assert not {"figure-03.png", "figure-03.svg", "claims.json", "report.html"} & set(contents(tmp_path))


def test_an_interrupted_write_leaves_no_file(laboratory, tmp_path, monkeypatch):
    def interrupted(result, path):
        raise KeyboardInterrupt

    monkeypatch.setattr(dataset, "write_netcdf", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run(["3"], quick=True, out=tmp_path, paper=laboratory.paper)
    assert contents(tmp_path) == []


def spoil_effort(path):
    save(load(path).assign_attrs(effort="full"), path, force=True)


def spoil_sizes(path):
    save(load(path).assign_attrs(effort_sizes="{}"), path, force=True)


def spoil_version(path):
    save(load(path).assign_attrs(gelcone_version="0.0.1"), path, force=True)


def spoil_program(path):
    save(load(path).assign_attrs(program="another"), path, force=True)


def spoil_whole(path):
    path.write_bytes(b"not netCDF")


def test_data_of_another_effort_or_version_or_broken_are_computed_again(laboratory, tmp_path):
    run(["second"], quick=True, out=tmp_path, paper=laboratory.paper)
    assert laboratory.computed == ["swing", "rest"]
    for spoil in (spoil_effort, spoil_sizes, spoil_version, spoil_program, spoil_whole):
        laboratory.computed.clear()
        spoil(tmp_path / "data" / "rest.nc")
        run(["second"], quick=True, out=tmp_path, paper=laboratory.paper)
        assert laboratory.computed == ["rest"], spoil.__name__


def test_force_computes_again_only_what_is_asked_for(laboratory, tmp_path):
    run(quick=True, out=tmp_path, paper=laboratory.paper)
    run(["13"], quick=True, out=tmp_path, force=True, paper=laboratory.paper)
    assert laboratory.computed == ["swing", "rest", "limit", "rest"]


def test_a_claim_brings_its_figure_and_a_figure_the_claims_its_data_suffice_for(laboratory, tmp_path):
    result = run(["second"], quick=True, out=tmp_path / "claim", paper=laboratory.paper)
    assert laboratory.computed == ["swing", "rest"]
    assert [drawn.figure.number for drawn in result.figures] == [4]
    assert [judged.claim.name for judged in result.claims] == ["second"]
    result = run([13], quick=True, out=tmp_path / "figure", paper=laboratory.paper)
    assert laboratory.computed == ["swing", "rest", "rest"]
    assert result.claims == ()


def test_the_report_covers_what_earlier_runs_left(laboratory, tmp_path):
    run([3], quick=True, out=tmp_path, paper=laboratory.paper)
    result = run([13], quick=True, out=tmp_path, paper=laboratory.paper)
    assert [drawn.figure.number for drawn in result.figures] == [13]
    page = result.report.read_text(encoding="utf-8")
    assert ['id="figure-03"' in page, 'id="figure-04"' in page, 'id="figure-13"' in page] == [True, False, True]
    claims = json.loads((tmp_path / "claims.json").read_text(encoding="utf-8"))["claims"]
    assert [claim["id"] for claim in claims] == ["first", "second"]
    assert "Claims whose figure is not drawn here" in page


def test_a_picture_older_than_its_data_is_left_out_of_the_report(laboratory, tmp_path):
    run([3], quick=True, out=tmp_path, paper=laboratory.paper)
    path = tmp_path / "data" / "swing.nc"
    save(load(path), path, force=True)
    page = run([13], quick=True, out=tmp_path, paper=laboratory.paper).report.read_text(encoding="utf-8")
    assert 'id="figure-03"' not in page


@pytest.mark.parametrize("place", ["", "data"])
def test_a_folder_that_cannot_be_written_is_refused_before_any_work(laboratory, tmp_path, place):
    blocked = tmp_path / "out" / place
    blocked.parent.mkdir(exist_ok=True)
    blocked.write_text("a file where a folder should be")
    with pytest.raises(InputError, match=r"cannot be written \(.*\); choose another folder"):
        run([3], quick=True, out=tmp_path / "out", paper=laboratory.paper)
    assert laboratory.computed == []


# --- the command ------------------------------------------------------------------------------------------------------


@pytest.fixture
def command(laboratory, tmp_path, monkeypatch):
    """Runs `gelcone paper` on the small paper in an empty folder."""
    monkeypatch.setattr(running, "source_paper", lambda: laboratory.paper)
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: CliRunner().invoke(cli.group, ["paper", *arguments])


def test_claims_are_judged_again_with_other_films(laboratory, tmp_path):
    """Its studies lie in a folder of their own; the verdict states the share of runs that end by pull-in."""
    laboratory.films = ("wrinkling", "membrane")
    found = run(["second"], quick=True, out=tmp_path, paper=laboratory.paper)
    assert sorted(laboratory.computed) == ["rest", "rest membrane", "rest wrinkling", "swing"]
    (judged,) = found.claims
    records = {claim["id"]: claim for claim in json.loads((tmp_path / "claims.json").read_text())["claims"]}
    for film, other, record in zip(laboratory.films, judged.others, records["second"]["with_films"], strict=True):
        seen = load(tmp_path / "data" / film / "rest.nc")["outcome"].values == Outcome.PULLED_IN
        assert other.film == record["film"] == film
        assert other.pulled_in == share(seen, sample=False)
        assert 0.0 < other.pulled_in.value < 1.0
        assert record["text"] == judged.with_film(film)
        assert record["text"] == f"reproduced; {seen.mean():.0%} of the runs end by pull-in"
        assert record["text"] in (tmp_path / "report.html").read_text()
    all_ended = replace(other, pulled_in=share([True, True], sample=False))
    assert str(all_ended) == "every run ends by pull-in"
    assert str(replace(other, pulled_in=share([False], sample=False))) == "reproduced"


def test_a_film_that_one_study_of_a_claim_does_not_take_is_not_judged(laboratory, tmp_path):
    laboratory.films = ("wrinkling",)
    (judged,) = run(["second"], quick=True, out=tmp_path, paper=laboratory.paper).claims
    assert [other.film for other in judged.others] == ["wrinkling"]
    assert judged.with_film("membrane") == ""
    page = (tmp_path / "report.html").read_text()
    assert "<th>If the film wrinkles</th>" in page
    assert "<th>With the membrane</th>" not in page


def test_the_film_that_creeps_is_left_to_full_runs_and_to_claims_that_can_be_read_with_it(laboratory, tmp_path):
    laboratory.films = OTHER_FILMS
    paper = laboratory.paper
    without = replace(paper.claims["second"], without=("creeping",))
    paper = replace(paper, claims=paper.claims | {"second": without})
    quick = run(["first", "second"], quick=True, out=tmp_path / "quick", paper=paper)
    assert [[other.film for other in judged.others] for judged in quick.claims] == [["wrinkling", "membrane"]] * 2
    assert not any("creeping" in computed for computed in laboratory.computed)
    full = run(["first", "second"], out=tmp_path / "full", paper=paper)
    first, second = full.claims
    assert [other.film for other in first.others] == list(OTHER_FILMS)
    assert [other.film for other in second.others] == ["wrinkling", "membrane"]
    assert [name for name in laboratory.computed if "creeping" in name] == ["swing creeping"]
    sizes = {film: load(tmp_path / "full" / "data" / film / "swing.nc").sizes["time"] for film in OTHER_FILMS}
    assert sizes == {"wrinkling": 201, "membrane": 201, "creeping": 41}  # it takes much longer
    page = (tmp_path / "full" / "report.html").read_text()
    assert "<th>If it also creeps, behind 1 MOhm</th>" in page
    assert page.count("<td>not judged</td>") == 1


def test_the_command_ends_with_the_table_of_claims(command, tmp_path):
    result = command("--quick")
    lines = result.output.splitlines()
    assert result.exit_code == 0
    assert " ".join(lines[0].split()) == "claim verdict key number which is"
    assert [line.split()[:2] for line in lines[1:4]] == [[n, "reproduced"] for n in ("first", "second", "third")]
    assert "±" in lines[1]
    assert lines[4:] == ["figures 3, 4, 13 in paper-results-quick", "wrote paper-results-quick/report.html"]
    assert (tmp_path / "paper-results-quick" / "report.html").exists()


def test_the_command_prints_one_json_object(command):
    result = command("first", "--quick", "--out", "there", "--json")
    answer = json.loads(result.output)
    content = answer["result"]
    assert (content["effort"], answer["version"], content["report"]) == (
        "quick",
        running.__version__,
        "there/report.html",
    )
    assert content["figures"] == [
        {"number": 3, "png": "there/figure-03.png", "svg": "there/figure-03.svg", "data": ["there/data/swing.nc"]}
    ]
    (claim,) = content["claims"]
    assert {"id": "first", "verdict": "reproduced", "why": "because", "figure": 3}.items() <= claim.items()
    assert claim["numbers"][0]["error"] == 0.1


def test_without_quick_the_effort_is_full(command):
    assert json.loads(command("3", "--json").output)["result"]["effort"] == "full"
    assert load("paper-results/data/swing.nc").sizes["time"] == 201


def test_an_interrupt_says_how_to_go_on(command, laboratory):
    laboratory.stop_at = "rest"
    result = command("--quick")
    assert result.exit_code == 130
    assert result.output == "interrupted; what is complete is saved, and the same command continues from there\n"


# --- the real studies, figures and claims -----------------------------------------------------------------------------


def test_the_source_paper_holds_together():
    """Every study, figure and preset that something refers to exists, and every study serves something."""
    from gelcone.presets import load_presets

    paper = running.source_paper()
    assert list(paper.figures) == [*range(3, 15), "end-of-chaos"]
    assert not {figure.name for figure in paper.figures.values()} & set(paper.studies)  # names of jobs
    assert len(paper.claims) == 21
    used = {name for part in (*paper.figures.values(), *paper.claims.values()) for name in part.studies}
    assert used == set(paper.studies)
    assert {claim.figure for claim in paper.claims.values()} <= set(paper.figures)
    assert {name for figure in paper.figures.values() for name in figure.presets} <= set(load_presets())
    for name, study in paper.studies.items():
        assert study.name == name
    for number, figure in paper.figures.items():
        assert (figure.number, bool(figure.title), bool(figure.message), bool(figure.values)) == (
            number,
            True,
            True,
            True,
        )
    for name, claim in paper.claims.items():
        assert (claim.name, bool(claim.statement)) == (name, True)


def test_a_figure_is_current_when_both_its_pictures_are_younger_than_its_data(tmp_path):
    drawn = DrawnFigure(
        SimpleNamespace(studies=("swing",)), *(tmp_path / n for n in ("a.png", "a.svg")), (tmp_path / "swing.nc",)
    )
    for path in (drawn.png, drawn.svg, *drawn.data):
        path.touch()
    for png, svg, data, current in ((1, 3, 2, False), (3, 1, 2, False), (1, 1, 2, False), (2, 2, 1, True)):
        for path, at in ((drawn.png, png), (drawn.svg, svg), (drawn.data[0], data)):
            os.utime(path, (at, at))
        assert run_module._is_current(drawn, {"swing": None}) is current
    assert not run_module._is_current(drawn, {})
    younger = tmp_path / "static.nc"
    younger.touch()  # long after the pictures
    assert not run_module._is_current(dataclasses.replace(drawn, data=(*drawn.data, younger)), {"swing": None})


def test_a_claim_is_judged_with_another_film_once_all_its_studies_are_there():
    checked = []

    def check(studies):
        checked.append(sorted(studies))
        return Finding(holds=True, numbers=(), why="")

    claim = Claim("own", "Something holds.", 1, ("one", "other"), check)
    paper = SimpleNamespace(studies={name: SimpleNamespace(films=("wrinkling",)) for name in claim.studies})
    own = {name: xr.Dataset() for name in claim.studies}
    one, other = ({f"wrinkling/{name}": xr.Dataset()} for name in claim.studies)
    for there, films in ((own, []), (own | one, []), (own | one | other, ["wrinkling"])):
        assert [judged.film for judged in running._judged(claim, there, QUICK, paper).others] == films
    assert checked == [["one", "other"]] * 4
