"""Redraws the paper's figures and judges its claims; results are written to a folder and reused from there.

A folder holds ``data/<study>.nc``, ``figure-03.png`` and ``.svg``, ``claims.json`` and ``report.html``. A study is not
computed again if its file was computed with the same effort by the same program (see `stamp`), so that an interrupted
run can be resumed.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass, replace
from datetime import date
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone._version import __version__
from gelcone.codes import Outcome
from gelcone.dataset import load, save
from gelcone.errors import InputError, unknown_name
from gelcone.files import check_writable, write_together, writer_of
from gelcone.paper.effort import FULL, QUICK, Effort
from gelcone.paper.films import PAPERS
from gelcone.paper.numbers import Number
from gelcone.paper.report import DrawnFigure, JudgedClaim, WithFilm, report_html
from gelcone.paper.stamp import stamp
from gelcone.paper.truths import Share, share
from gelcone.paper.verdicts import judge, verdict_text
from gelcone.paper.work import Job, Progress, do
from gelcone.plots.style import draw_file

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from gelcone.paper.claims import Claim
    from gelcone.paper.figures.figure import PaperFigure
    from gelcone.paper.studies.study import Study

FOLDERS = {FULL.name: Path("paper-results"), QUICK.name: Path("paper-results-quick")}
DRAWING = 2.0
"""Work of drawing a figure, in the unit of `Study.work`."""

_FIGURE = re.compile(r"(?:fig(?:ure)?[-_ ]?)?0*(\d+)", re.IGNORECASE)


@dataclass(frozen=True)
class Paper:
    """Studies, figures and claims by name."""

    studies: Mapping[str, Study]
    figures: Mapping[int | str, PaperFigure]
    claims: Mapping[str, Claim]


@dataclass(frozen=True)
class Selection:
    """The requested figures and claims."""

    figures: tuple[int | str, ...]
    claims: tuple[str, ...]


@dataclass(frozen=True)
class PaperRun:
    """The requested results, and the path of the report, which covers everything in the folder."""

    figures: tuple[DrawnFigure, ...]
    claims: tuple[JudgedClaim, ...]
    report: Path
    effort: str


def source_paper() -> Paper:
    """The studies, figures and claims of the source paper."""
    from gelcone.paper.claims import CLAIMS
    from gelcone.paper.figures import FIGURES
    from gelcone.paper.studies import STUDIES

    return Paper(STUDIES, FIGURES, CLAIMS)


def run(
    names: Iterable[str | int] = (),
    *,
    quick: bool = False,
    out: str | Path | None = None,
    force: bool = False,
    workers: int = 1,
    progress: Progress = lambda label, share: None,
    paper: Paper | None = None,
) -> PaperRun:
    """Draws figures, judges claims and writes the report.

    A claim includes its figure; without names all figures and claims are processed. The report and ``claims.json``
    cover everything in the folder, including results of earlier runs of the same effort and version, and every claim
    whose studies are there.

    Parameters
    ----------
    names : figures (``3``, ``"3"``, ``"figure-03"``, ``"end-of-chaos"``) and claims (``"voltage-threshold"``).
    quick : compute on coarser grids and over fewer periods.
    out : folder; by default ``paper-results``, for quick runs ``paper-results-quick``.
    force : recompute studies that are there.
    workers : parallel processes; the data are the same to the last bit. Default 1, all in this process.
    progress : called with the current job and the share of the work done since the last call.
    paper : other studies, figures and claims than those of the source paper.

    Raises
    ------
    InputError : before any work, for an unknown name (with the nearest one) or a folder that cannot be written.
    """
    paper = paper or source_paper()
    effort = QUICK if quick else FULL
    others = [effort.with_film(film) for film in effort.films]
    asked = select(names, paper)
    folder = Path(out) if out is not None else FOLDERS[effort.name]
    shown = {*asked.figures, *(paper.claims[name].figure for name in asked.claims)}
    figures = [figure for number, figure in paper.figures.items() if number in shown]
    asked_studies = _wanted(figures, [paper.claims[name] for name in asked.claims], effort, others, paper)
    needed = {_key(name, variant) for name, variant in asked_studies}
    _check_folder(folder, figures, needed)
    ready = {key: study for variant in (effort, *others) for key, study in _ready(folder, variant, paper).items()}
    studies = {key: study for key, study in ready.items() if not (force and key in needed)}
    jobs_of = {
        _key(name, variant): _computing(paper.studies[name], variant, folder, paper) for name, variant in asked_studies
    }
    missing = {key: job for key, job in jobs_of.items() if key not in studies}
    jobs = [*missing.values(), *(_drawing(figure, studies, folder) for figure in figures)]
    with closing(do(jobs, workers, progress)) as done:
        studies |= {name: result for name, result in done if name in missing}
    drawn = {figure.number: _drawn(figure, folder) for figure in figures}
    return _finish(asked, drawn, studies, folder, effort, paper)


def _wanted(
    figures: Sequence[PaperFigure], claims: Sequence[Claim], effort: Effort, others: Sequence[Effort], paper: Paper
) -> list[tuple[str, Effort]]:
    """The studies behind figures and claims with the effort (and film) of each, in the order of the paper."""
    study_names = {
        name for studies in (*(f.studies for f in figures), *(c.studies for c in claims)) for name in studies
    }
    names_of = [(effort, study_names)]
    for other in others:
        judged = [claim for claim in claims if _judged_with(claim, other.film, paper)]
        names_of.append((other, {name for claim in judged for name in claim.studies}))
    return [(name, each) for each, names in names_of for name in paper.studies if name in names]


def _key(study: str, effort: Effort) -> str:
    """Name of a study's data; data with other films than the paper's have folders of their own."""
    return study if effort.film == PAPERS else f"{effort.film}/{study}"


def _judged_with(claim: Claim, film: str, paper: Paper) -> bool:
    """Whether a claim is judged with another film."""
    return film not in claim.without and all(film in paper.studies[name].films for name in claim.studies)


def _computing(study: Study, effort: Effort, folder: Path, paper: Paper) -> Job:
    key = _key(study.name, effort)
    purpose = _purpose(study.name, paper) + (f", film {effort.film}" if key != study.name else "")
    return Job(key, purpose, study.work, frozenset(), partial(_compute, study, effort, _data_path(folder, key)))


def _drawing(figure: PaperFigure, ready: Mapping[str, xr.Dataset], folder: Path) -> Job:
    there = {name: ready[name] for name in figure.studies if name in ready}
    draw = partial(_draw, figure, folder, there)
    return Job(figure.name, f"figure {figure.number}", DRAWING, frozenset(figure.studies) - frozenset(there), draw)


def select(names: Iterable[str | int], paper: Paper) -> Selection:
    """The figures and claims of these names, each once; all without names."""
    figures: list[int | str] = []
    claims = []
    for name in names:
        number = _FIGURE.fullmatch(str(name))
        if number or name in paper.figures:
            figures.append(int(number[1]) if number else name)
        elif name in paper.claims:
            claims.append(str(name))
        else:
            named = [number for number in paper.figures if isinstance(number, str)]
            raise unknown_name("figure or claim of the paper", str(name), [*named, *paper.claims])
    for wanted in figures:
        if wanted not in paper.figures:
            known = ", ".join(map(str, paper.figures))
            raise InputError(f"figure {wanted}: is not one of those that are redrawn: {known}")
    if not figures and not claims:
        return Selection(tuple(paper.figures), tuple(paper.claims))
    return Selection(tuple(dict.fromkeys(figures)), tuple(dict.fromkeys(claims)))


def claim_record(judged: JudgedClaim) -> dict[str, Any]:
    """A judged claim as plain data, for ``claims.json`` and the command line."""
    finding = judged.finding
    return {
        "id": judged.claim.name,
        "statement": judged.claim.statement,
        "verdict": judged.verdict.value,
        "parts": {name: judge(part).value for name, part in finding.parts.items()},
        "text": verdict_text(finding),
        "why": finding.why,
        "numbers": [_number_record(number) for number in finding.numbers],
        "figure": judged.claim.figure,
        "share": _share_record(finding.share),
        "slack": [_number_record(number) for number in finding.slack],
        "consequence": finding.consequence,
        "neighbourhood": finding.neighbourhood,
        "unseen": finding.unseen,
        "details": finding.details,
        "with_films": [_film_record(other) for other in judged.others],
    }


def _film_record(other: WithFilm) -> dict[str, Any]:
    """The judgement of a claim with another film, as plain data."""
    return {
        "film": other.film,
        "verdict": other.verdict.value,
        "pulled_in": _share_record(other.pulled_in),
        "numbers": [_number_record(number) for number in other.finding.numbers],
        "text": str(other),
    }


def _share_record(share: Share | None) -> dict[str, Any] | None:
    if share is None:
        return None
    low, high = share.interval
    counts = {"holding": share.holding, "failing": share.failing, "open": share.open}
    return {"value": _finite(share.value), "low": low, "high": high, **counts}


def _number_record(number: Number) -> dict[str, Any]:
    values = {name: _finite(getattr(number, name)) for name in ("value", "error", "low", "high")}
    return {"meaning": number.meaning, **values, "unit": number.unit, "text": str(number)}


def _finite(value: float | None) -> float | None:
    return float(value) if value is not None and math.isfinite(value) else None


def _check_folder(folder: Path, figures: Iterable[PaperFigure], studies: Iterable[str]) -> None:
    pictures = (path for figure in figures for path in (_drawn(figure, folder).png, _drawn(figure, folder).svg))
    data = (_data_path(folder, name) for name in studies)
    check_writable((folder / "report.html", folder / "claims.json", *pictures, *data), force=True)


def _data_path(folder: Path, study: str) -> Path:
    return folder / "data" / f"{study}.nc"


def _ready(folder: Path, effort: Effort, paper: Paper) -> dict[str, xr.Dataset]:
    """The studies in the folder that were computed with this effort by this program."""
    ready = {}
    for key in (_key(name, effort) for name in paper.studies):
        try:
            study = load(_data_path(folder, key))
        except InputError:
            continue
        if all(study.attrs.get(name) == value for name, value in stamp(effort).items()):
            ready[key] = study
    return ready


def _compute(
    study: Study, effort: Effort, path: Path, _: Mapping[str, Any], progress: Callable[[float], None]
) -> xr.Dataset:
    """Computes and saves a study, without the time it took, so that equal runs give equal files."""
    result = study.compute(effort, progress).assign_attrs(stamp(effort))
    result.attrs.pop("totals", None)
    save(result, path, force=True)
    return result


def _purpose(study: str, paper: Paper) -> str:
    """A study's name, and the figures or else the claims that need it."""
    figures = [str(figure.number) for figure in paper.figures.values() if study in figure.studies]
    claims = [name for name, claim in paper.claims.items() if study in claim.studies]
    if figures:
        return f"{study}, for figure{'s' if len(figures) > 1 else ''} {', '.join(figures)}"
    return f"{study}, for {', '.join(claims)}"


def _draw(
    figure: PaperFigure,
    folder: Path,
    there: Mapping[str, xr.Dataset],
    computed: Mapping[str, xr.Dataset],
    progress: Callable[[float], None],
) -> None:
    """Draws a figure and writes it as PNG and SVG."""
    drawn = _drawn(figure, folder)
    picture = figure.draw({**there, **computed})
    progress(0.2)
    writers = {drawn.png: partial(draw_file, picture), drawn.svg: partial(_draw_again, picture)}
    write_together(writers, force=True)
    progress(0.8)


def _draw_again(picture: Figure, path: Path) -> None:
    """Draws with the layout of the first drawing: finding it takes half of the time."""
    picture.set_layout_engine("none")
    draw_file(picture, path)


def _drawn(figure: PaperFigure, folder: Path) -> DrawnFigure:
    png, svg = (folder / f"{figure.name}.{suffix}" for suffix in ("png", "svg"))
    return DrawnFigure(figure, png, svg, tuple(_data_path(folder, name) for name in figure.studies))


def _is_current(drawn: DrawnFigure, studies: Mapping[str, xr.Dataset]) -> bool:
    """Whether an earlier run drew the figure from the data in the folder."""
    if not (drawn.png.exists() and drawn.svg.exists() and all(name in studies for name in drawn.figure.studies)):
        return False
    oldest = min(drawn.png.stat().st_mtime_ns, drawn.svg.stat().st_mtime_ns)
    return all(path.stat().st_mtime_ns <= oldest for path in drawn.data)


def _finish(
    asked: Selection,
    drawn: dict[int | str, DrawnFigure],
    studies: Mapping[str, xr.Dataset],
    folder: Path,
    effort: Effort,
    paper: Paper,
) -> PaperRun:
    """Judges all claims whose studies are there, and writes ``claims.json`` and the report."""
    earlier = (_drawn(figure, folder) for number, figure in paper.figures.items() if number not in drawn)
    every = drawn | {other.figure.number: other for other in earlier if _is_current(other, studies)}
    shown = [every[number] for number in paper.figures if number in every]
    figures = [replace(plot, table=plot.figure.table(studies)) if plot.figure.table else plot for plot in shown]
    judgeable = [claim for claim in paper.claims.values() if all(name in studies for name in claim.studies)]
    claims = [_judged(claim, studies, effort, paper) for claim in judgeable]
    record = {
        "effort": effort.name,
        "version": __version__,
        "claims": [claim_record(judged) for judged in claims],
        "tables": {figure.figure.name: asdict(figure.table) for figure in figures if figure.table},
    }
    page = report_html(figures, claims, effort=effort.name, version=__version__, day=date.today())
    texts = {
        folder / "claims.json": json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False),
        folder / "report.html": page,
    }
    write_together({path: writer_of(text + "\n") for path, text in texts.items()}, force=True)
    answered = (j for j in claims if j.claim.name in asked.claims or j.claim.figure in asked.figures)
    new_figures = tuple(figure for figure in figures if figure.figure.number in drawn)
    return PaperRun(new_figures, tuple(answered), folder / "report.html", effort.name)


def _judged(claim: Claim, studies: Mapping[str, xr.Dataset], effort: Effort, paper: Paper) -> JudgedClaim:
    finding = claim.check({name: studies[name] for name in claim.studies})
    others = []
    for film in (film for film in effort.films if _judged_with(claim, film, paper)):
        keys = {name: _key(name, effort.with_film(film)) for name in claim.studies}
        if all(key in studies for key in keys.values()):
            others.append(_with_film(claim, film, {name: studies[key] for name, key in keys.items()}))
    return JudgedClaim(claim, finding, judge(finding), tuple(others))


def _with_film(claim: Claim, film: str, theirs: Mapping[str, xr.Dataset]) -> WithFilm:
    """The claim judged with another film, on its studies with that film."""
    finding = claim.check(theirs)
    ended = [(study["outcome"] == Outcome.PULLED_IN).values.ravel() for study in theirs.values() if "outcome" in study]
    pulled_in = share(np.concatenate(ended) if ended else [], sample=False)
    return WithFilm(film, finding, judge(finding), pulled_in)
