"""One self-contained HTML page of the paper's figures and claims, without scripts or external resources."""

from __future__ import annotations

import base64
import inspect
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from html import escape
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

from gelcone.paper.films import CREEPING, MEMBRANE, SERIES_RESISTANCE, WRINKLING, creeping_in_words
from gelcone.paper.numbers import Number
from gelcone.paper.truths import Share
from gelcone.paper.verdicts import Finding, Verdict, judge, verdict_text
from gelcone.physics.model import parameter_quantity
from gelcone.presets import Preset, load_presets

if TYPE_CHECKING:
    from gelcone.paper.claims import Claim
    from gelcone.paper.figures.figure import PaperFigure, Table

DOI = "10.1177/10775463261460015"
LARGEST_SVG = 400_000
"""Largest SVG in bytes that the page embeds; larger ones are replaced by the PNG, as scatter plots of many points draw
slowly."""

FILM_HEADINGS = {
    WRINKLING: "If the film wrinkles",
    MEMBRANE: "With the membrane",
    CREEPING: f"If it also creeps, behind {SERIES_RESISTANCE}",
}
"""Headings of the columns for other films."""

BADGES = {verdict: verdict.name.lower() for verdict in Verdict} | {Verdict.NOT_REPRODUCED: "refuted"}
"""CSS class of each verdict's badge; the badge states the verdict in words, too."""

SYMBOLS = {"zeta": "ζ", "kappa": "κ", "omega": "ω", "x0": "x₀", "v0": "v₀", "lp": "λₚ"}


@dataclass(frozen=True)
class DrawnFigure:
    """A drawn figure: its pictures, the data files of its studies, and its table, if any."""

    figure: PaperFigure
    png: Path
    svg: Path
    data: tuple[Path, ...]
    table: Table | None = None


@dataclass(frozen=True)
class WithFilm:
    """A claim judged with another film; ``pulled_in`` is the share of runs that ended by pull-in."""

    film: str
    finding: Finding
    verdict: Verdict
    pulled_in: Share

    def __str__(self) -> str:
        """The verdict in words, or that every run ended by pull-in."""
        share, text = self.pulled_in.value, verdict_text(self.finding)
        if share == 1.0:
            return "every run ends by pull-in"
        return f"{text}; {share:.0%} of the runs end by pull-in" if share > 0.0 else text


@dataclass(frozen=True)
class JudgedClaim:
    """A claim with its finding and verdict; ``others`` are the judgements with other films."""

    claim: Claim
    finding: Finding
    verdict: Verdict
    others: tuple[WithFilm, ...] = ()

    def with_film(self, film: str) -> str:
        """The verdict with another film in words; empty if the claim was not judged with it."""
        return next((str(other) for other in self.others if other.film == film), "")


def films_of(claims: Iterable[JudgedClaim]) -> dict[str, str]:
    """The films with which any of the claims was judged -> the headings of their columns."""
    judged = {other.film for claim in claims for other in claim.others}
    return {film: heading for film, heading in FILM_HEADINGS.items() if film in judged}


def report_html(
    figures: Sequence[DrawnFigure], claims: Sequence[JudgedClaim], *, effort: str, version: str, day: date
) -> str:
    """The whole page, from drawn figures and judged claims."""
    style = files("gelcone.paper").joinpath("report.css").read_text(encoding="utf-8")
    title = "The source paper, figure by figure and claim by claim"
    body = (
        _header(title, claims, effort, version, day),
        _contents(figures, claims),
        _overview(figures, claims),
        *(_figure_section(drawn, claims) for drawn in figures),
        _pictureless(figures, claims),
        _rules(),
        _films(),
        _presets(),
    )
    # the browser refuses external resources, should the page ever refer to one
    policy = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
    return "\n".join(
        (
            "<!DOCTYPE html>",
            '<html lang="en">',
            "<head>",
            '<meta charset="utf-8">',
            f'<meta http-equiv="Content-Security-Policy" content="{policy}">',
            '<meta name="viewport" content="width=device-width, initial-scale=1">',
            f"<title>gelcone: {escape(title)}</title>",
            f"<style>\n{style}</style>",
            "</head>",
            "<body>",
            *(part for part in body if part),
            "</body>",
            "</html>",
        )
    )


# --- the page from top to bottom ----------------------------------------------------------------------------------


def _header(title: str, claims: Sequence[JudgedClaim], effort: str, version: str, day: date) -> str:
    counted = Counter(judged.verdict for judged in claims)
    counts = ", ".join(f"{counted[verdict]} {verdict.value}" for verdict in Verdict if counted[verdict])
    sum_up = f"<p class='lead'>Of {len(claims)} claims: {escape(counts)}.</p>" if claims else ""
    return f"""<header>
<h1>{escape(title)}</h1>
<p class="origin">gelcone {escape(version)}, effort {escape(effort)},
<time datetime="{day.isoformat()}">{day.isoformat()}</time></p>
<p>The source paper is J. Vib. Control, doi {DOI}. Its equation of motion was derived again from the energies that it
names; figures are redrawn and claims checked with an integrator that respects the stretch limit of the gel.</p>
{sum_up}
<p class="remark"><strong>The identification of the parameters is not unique.</strong> Numbers marked <em>text</em>
are from the paper's text. Those marked <em>reconstructed</em> were found by a search over a few thousand sets for those
under which most of the paper's claims hold; other sets fit equally well, and a verdict can depend on the choice.
Where a claim was also checked at other parameters, the share of them for which it holds is given with its interval:
samples grow until it leaves the claim's cut or a budget ends, and all looks together hold at 95 %.</p>
<p>All quantities are dimensionless unless a unit is given. Lyapunov exponents are those of the flow, per unit
of dimensionless time.</p>
</header>"""


def _contents(figures: Sequence[DrawnFigure], claims: Sequence[JudgedClaim]) -> str:
    entries = [("claims", "The claims at a glance")] if claims else []
    entries += [(drawn.figure.name, drawn.figure.heading) for drawn in figures]
    if _without_picture(figures, claims):
        entries.append(("other-claims", "Claims whose figure is not drawn here"))
    entries += [("verdicts", "How the verdicts are reached"), ("films", "The other films")]
    entries.append(("presets", "The parameter sets"))
    items = "\n".join(f'<li><a href="#{anchor}">{escape(name)}</a></li>' for anchor, name in entries)
    return f'<nav aria-label="Contents">\n<h2>Contents</h2>\n<ol>\n{items}\n</ol>\n</nav>'


def _overview(figures: Sequence[DrawnFigure], claims: Sequence[JudgedClaim]) -> str:
    if not claims:
        return ""
    drawn = {other.figure.number: other.figure for other in figures}
    films = films_of(claims)
    rows = "\n".join(
        f'<tr><td><a href="#{escape(judged.claim.name)}">{escape(judged.claim.name)}</a>'
        f"<br>{escape(judged.claim.statement)}</td>"
        f"<td>{_badge(judged)}</td>{_others(judged, films)}<td>{_key(judged.finding)}</td>"
        f"<td>{_figure_link(judged.claim.figure, drawn)}</td></tr>"
        for judged in claims
    )
    columns = "".join(f"<th>{heading}</th>" for heading in films.values())
    head = f"<tr><th>Claim</th><th>Verdict</th>{columns}<th>Key number</th><th>Figure</th></tr>"
    return f"""<section id="claims">
<h2>The claims at a glance</h2>
<table class="overview">
<thead>{head}</thead>
<tbody>
{rows}
</tbody>
</table>
</section>"""


def _figure_section(drawn: DrawnFigure, claims: Sequence[JudgedClaim]) -> str:
    figure = drawn.figure
    presets = load_presets()
    data = ", ".join(f"<code>data/{escape(path.name)}</code>" for path in drawn.data)
    shown = "\n".join(_claim(judged) for judged in claims if judged.claim.figure == figure.number)
    return f"""<section id="{figure.name}">
<h2>{escape(figure.heading)}</h2>
<figure>
<img src="{_picture(drawn)}" alt="{escape(figure.heading)}">
<figcaption>{escape(figure.message)}</figcaption>
</figure>
{_table(drawn.table)}
<h3>Parameters</h3>
<p>{escape(figure.values)}</p>
{_parameter_table([presets[name] for name in figure.presets])}
<p class="source">Redraw it with <code>{escape(figure.command)}</code>. Its data: {data}.</p>
{shown}
</section>"""


def _claim(judged: JudgedClaim) -> str:
    claim, finding = judged.claim, judged.finding
    rows = "\n".join(
        f"<tr><td>{escape(number.meaning)}</td><td>{escape(str(number))}</td></tr>" for number in _numbers(finding)
    )
    details = "".join(f"<dt>{escape(name)}</dt><dd>{escape(text)}</dd>" for name, text in finding.details.items())
    remarks = {
        "A consequence of the model": finding.consequence,
        "Film slack": _slack(finding),
        "What the paper could not see": finding.unseen,
        "With a film that wrinkles instead of pushing": _sentence(judged.with_film(WRINKLING)),
        "With the film as a membrane": _sentence(judged.with_film(MEMBRANE)),
        f"With a film that also creeps, behind {SERIES_RESISTANCE}": _sentence(judged.with_film(CREEPING)),
    }
    paragraphs = "\n".join(
        f'<p><span class="label">{label}:</span> {escape(text)}</p>' for label, text in remarks.items() if text
    )
    return f"""<article class="claim" id="{escape(claim.name)}">
<h3>{escape(claim.name)} {_badge(judged)}</h3>
<p><span class="label">The paper says:</span> {escape(claim.statement)}</p>
<p><span class="label">Why this verdict:</span> {escape(finding.why)}</p>
<table class="numbers"><tbody>
{rows}
</tbody></table>
{f"<dl>{details}</dl>" if details else ""}
{paragraphs}
</article>"""


def _slack(finding: Finding) -> str:
    shares = [number.value for number in finding.slack]
    if not shares:
        return ""
    span = f"{min(shares):.0%}" if min(shares) == max(shares) else f"{min(shares):.0%} to {max(shares):.0%}"
    return f"in chaos the film is slack for {span} of the time; a real film then wrinkles and does not push."


def _pictureless(figures: Sequence[DrawnFigure], claims: Sequence[JudgedClaim]) -> str:
    left = _without_picture(figures, claims)
    if not left:
        return ""
    shown = "\n".join(_claim(judged) for judged in left)
    numbers = sorted({judged.claim.figure for judged in left})
    command = f"gelcone paper {' '.join(map(str, numbers))}"
    return f"""<section id="other-claims">
<h2>Claims whose figure is not drawn here</h2>
<p><code>{escape(command)}</code> draws the figures that show them.</p>
{shown}
</section>"""


def _rules() -> str:
    """The rules, quoted from the docstring of `judge` so that the two cannot diverge."""
    rules = re.findall(r"^\d+\. (.+)$", inspect.getdoc(judge) or "", re.MULTILINE)
    items = "\n".join(f"<li>{escape(rule)}</li>" for rule in rules)
    return f"""<section id="verdicts">
<h2>How the verdicts are reached</h2>
<p>The check of a claim computes whether it holds in the long run at the paper's parameters, whether it holds over a
finite window from the start like the paper's, at what share of other parameters it holds, and whether it
holds for a fixed-step Runge-Kutta integrator in runs that go beyond the stretch limit. The first rule that applies
gives the verdict:</p>
<ol>
{items}
</ol>
</section>"""


def _films() -> str:
    return f"""<section id="films">
<h2>The other films</h2>
<dl class="purposes">
<dt>{FILM_HEADINGS[WRINKLING]}</dt><dd>A cone that goes slack where the paper's pushes, and pulls in.</dd>
<dt>{FILM_HEADINGS[MEMBRANE]}</dt><dd>The axisymmetric membrane in place of a cone: claims about force and pull-in.</dd>
<dt>{FILM_HEADINGS[CREEPING]}</dt><dd>{escape(creeping_in_words())}</dd>
</dl>
</section>"""


def _presets() -> str:
    presets = list(load_presets().values())
    purposes = "\n".join(
        f"<dt><code>{escape(preset.name)}</code></dt><dd>{escape(preset.purpose)}</dd>" for preset in presets
    )
    return f"""<section id="presets">
<h2>The parameter sets</h2>
<dl class="purposes">
{purposes}
</dl>
{_parameter_table(presets)}
<p class="source">Try one with <code>gelcone simulate --preset base --set voltage=1.04</code>.</p>
</section>"""


# --- its pieces ---------------------------------------------------------------------------------------------------


def _table(table: Table | None) -> str:
    """The table of a figure; empty without one."""
    if table is None:
        return ""
    head, *rows = (
        "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells)
        for tag, cells in (("th", table.head), *(("td", row) for row in table.rows))
    )
    body = "\n".join(f"<tr>{row}</tr>" for row in rows)
    return f"<table class='overview'>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{body}\n</tbody>\n</table>"


def _parameter_table(presets: Sequence[Preset]) -> str:
    """Parameters by preset, each number marked as text or reconstructed."""
    if not presets:
        return ""
    names = dict.fromkeys(name for preset in presets for name in (*preset.text, *preset.reconstructed))
    head = "".join(f"<th>{escape(preset.name)}</th>" for preset in presets)
    rows = [
        f"<tr><td>{escape(_meaning(name))}</td>{''.join(_parameter_cell(preset, name) for preset in presets)}</tr>"
        for name in names
    ]
    starts = "".join(_cell(", ".join(f"{value:g}" for value in preset.initial), "reconstructed") for preset in presets)
    rows.append(f"<tr><td>initial displacement and velocity</td>{starts}</tr>")
    body = "\n".join(rows)
    return f"""<table class="parameters">
<thead><tr><th>Parameter</th>{head}</tr></thead>
<tbody>
{body}
</tbody>
</table>"""


def _parameter_cell(preset: Preset, name: str) -> str:
    for origin, values in (("text", preset.text), ("reconstructed", preset.reconstructed)):
        if name in values:
            return _cell(f"{values[name]:g}", origin)
    return "<td></td>"


def _cell(value: str, origin: str) -> str:
    return f'<td>{escape(value)} <span class="{origin}">{origin}</span></td>'


def _meaning(name: str) -> str:
    quantity = parameter_quantity(name)
    return f"{name.replace('_', ' ')} {SYMBOLS.get(quantity.symbol, quantity.symbol)}"


def _numbers(finding: Finding) -> Iterable[Number]:
    """All numbers behind a finding, with the share of neighbouring parameters last."""
    yield from finding.numbers
    yield from finding.slack
    if finding.share is not None:
        yield finding.share.number(f"share of other parameters ({finding.neighbourhood}) for which it holds")


def _key(finding: Finding) -> str:
    if not finding.numbers:
        return ""
    number = finding.numbers[0]
    return f"<strong>{escape(str(number))}</strong><br>{escape(number.meaning)}"


def _others(judged: JudgedClaim, films: Iterable[str]) -> str:
    return "".join(f"<td>{escape(judged.with_film(film)) or 'not judged'}</td>" for film in films)


def _sentence(text: str) -> str:
    return f"{text}." if text else ""


def _badge(judged: JudgedClaim) -> str:
    return f'<span class="badge {BADGES[judged.verdict]}">{escape(verdict_text(judged.finding))}</span>'


def _figure_link(number: int, drawn: Mapping[int | str, PaperFigure]) -> str:
    return f'<a href="#{drawn[number].name}">{number}</a>' if number in drawn else str(number)


def _without_picture(figures: Sequence[DrawnFigure], claims: Sequence[JudgedClaim]) -> list[JudgedClaim]:
    drawn = {other.figure.number for other in figures}
    return [judged for judged in claims if judged.claim.figure not in drawn]


def _picture(drawn: DrawnFigure) -> str:
    """The picture as a data URI: SVG, or PNG if the SVG is too large."""
    small = drawn.svg.stat().st_size <= LARGEST_SVG
    path, kind = (drawn.svg, "svg+xml") if small else (drawn.png, "png")
    return f"data:image/{kind};base64,{base64.b64encode(path.read_bytes()).decode('ascii')}"
