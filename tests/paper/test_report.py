"""The report: what stands on the page, that it escapes everything, and what a real browser makes of it."""

import fcntl
import json
import math
import os
import re
import select
import shutil
import subprocess
import sys
from datetime import date
from html import unescape
from html.parser import HTMLParser
from pathlib import Path

import pytest

from gelcone.paper import report as reporting
from gelcone.paper.claims import Claim
from gelcone.paper.figures.figure import PaperFigure, Table
from gelcone.paper.films import CREEPING, MEMBRANE, SERIES_RESISTANCE, WRINKLING, creeping_in_words
from gelcone.paper.numbers import Number
from gelcone.paper.report import DrawnFigure, JudgedClaim, WithFilm, report_html
from gelcone.paper.run import run
from gelcone.paper.truths import Share
from gelcone.paper.verdicts import Finding, Verdict, judge
from gelcone.plots.style import save_figure, styled

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--remote-debugging-pipe",
)
PATIENCE = 60.0
NASTY = "<script>alert('x')</script> & \"v\" < 1"
FINDINGS = {
    Verdict.REPRODUCED: {"holds": True, "share": Share(18, 2), "neighbourhood": f"voltages {NASTY}"},
    Verdict.TRANSIENT: {"holds": False, "holds_finite": True},
    Verdict.CHOSEN: {"holds": True, "share": Share(2, 18), "neighbourhood": "voltages"},
    Verdict.NOT_REPRODUCED: {"holds": False},
    Verdict.ARTEFACT: {"holds": False, "holds_fixed_step": True},
    Verdict.UNDECIDED: {"holds": None},
    Verdict.UNDECIDABLE: {"holds": True, "decidable": False},
}


def words_of(page, between=""):
    """The text of a page, with something in place of its tags."""
    return " ".join(unescape(re.sub(r"<style>.*?</style>|<[^>]+>", between, page, flags=re.DOTALL)).split())


def finding(**found):
    numbers = (Number(f"threshold {NASTY}", 1.0432, error=0.0031), Number("stroke", 0.2, low=0.1, high=0.3, unit="mm"))
    return Finding(
        numbers=numbers, why=f"why {NASTY}", unseen=f"unseen {NASTY}", details={f"at {NASTY}": NASTY}, **found
    )


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """A report of two figures and eight claims: every verdict, and one claim whose figure is not drawn."""
    folder, figures = tmp_path_factory.mktemp("page"), []
    for number, presets in ((3, ("table1",)), (8, ("base", "fast"))):
        figure = PaperFigure(number, f"Title {NASTY}", presets, f"values {NASTY}", f"message {NASTY}", ("swing",), None)
        picture = styled(4.0, 2.0, lambda sheet: sheet.add_subplot().plot([0.0, 1.0, 0.5]))
        png, svg = (folder / f"{figure.name}.{suffix}" for suffix in ("png", "svg"))
        save_figure(picture, png)
        save_figure(picture, svg)
        figures.append(DrawnFigure(figure, png, svg, (folder / "data" / "swing.nc",)))
    claims = []
    for place, (verdict, found) in enumerate([*FINDINGS.items(), (Verdict.REPRODUCED, {"holds": True})]):
        shown = (3, 8, 8, 3, 3, 8, 8, 12)[place]
        claim = Claim(f"claim-{place}", f"statement {NASTY}", shown, ("swing",), None)
        claims.append(JudgedClaim(claim, finding(**found), judge(finding(**found))))
        assert claims[-1].verdict is verdict
    return report_html(figures, claims, effort="quick", version="1.2.3", day=date(2026, 2, 3))


@pytest.mark.parametrize(
    ("ended", "others", "words"),
    [
        (0, 10, "reproduced"), (3, 7, "reproduced; 30% of the runs end by pull-in"),
        (9, 1, "reproduced; 90% of the runs end by pull-in"), (10, 0, "every run ends by pull-in"),
        (0, 0, "reproduced"),
    ],
)  # fmt: skip
def test_a_verdict_with_another_film_says_how_many_runs_end_by_pull_in(ended, others, words):
    own = finding(holds=True)
    wrinkling = WithFilm("wrinkling", own, judge(own), Share(ended, others))
    lost = WithFilm("membrane", finding(holds=False), Verdict.NOT_REPRODUCED, Share(0, 1))
    claim = JudgedClaim(Claim("claim", "statement", 3, ("swing",), None), own, judge(own), (lost, wrinkling))
    assert (claim.with_film("wrinkling"), claim.with_film("membrane")) == (words, "not reproduced")
    assert claim.with_film("creeping") == ""
    assert list(reporting.films_of([claim])) == ["wrinkling", "membrane"]


def test_each_remark_about_a_claim_stands_behind_its_label():
    slack = tuple(Number("share of the time", share) for share in (0.35, 0.2))
    own, lost = finding(holds=True, consequence="it follows", slack=slack), finding(holds=False)
    films = tuple(WithFilm(film, lost, judge(lost), Share(0, 1)) for film in (WRINKLING, MEMBRANE, CREEPING))
    claim = JudgedClaim(Claim("claim", "statement", 3, ("swing",), None), own, judge(own), films)
    shown = [words_of(text) for text in re.findall("<p>.*</p>", reporting._claim(claim))]
    assert shown[2:] == [
        "A consequence of the model: it follows",
        "Film slack: in chaos the film is slack for 20% to 35% of the time; "
        "a real film then wrinkles and does not push.",
        f"What the paper could not see: unseen {NASTY}",
        "With a film that wrinkles instead of pushing: not reproduced.",
        "With the film as a membrane: not reproduced.",
        f"With a film that also creeps, behind {SERIES_RESISTANCE}: not reproduced.",
    ]


def test_the_key_number_of_a_claim_is_its_first():
    assert words_of(reporting._key(finding(holds=True)), " ") == f"1.0432 ± 0.0031 threshold {NASTY}"
    assert reporting._key(Finding(holds=True, numbers=(), why="why")) == ""


class Outline(HTMLParser):
    """Ids, links, sources and the text of a page; fails for tags that do not match."""

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.links, self.sources, self.tags, self.words = [], [], [], [], [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.tags.append(tag)
        self.ids += [attributes["id"]] if "id" in attributes else []
        self.links += [attributes["href"]] if "href" in attributes else []
        self.sources += [attributes["src"]] if "src" in attributes else []
        if tag not in ("meta", "img", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def test_the_page_is_whole_and_its_links_lead_somewhere(page):
    outline = Outline(page)
    assert len(outline.ids) == len(set(outline.ids))
    assert {link.removeprefix("#") for link in outline.links} <= set(outline.ids)
    assert {"claims", "figure-03", "figure-08", "claim-0", "claim-6", "verdicts", "presets"} <= set(outline.ids)
    assert outline.tags.count("img") == 2
    assert all(source.startswith("data:image/") for source in outline.sources)


def test_the_contents_name_each_section_by_its_heading(page):
    entries = re.findall(r'<li><a href="#(.*?)">(.*?)</a></li>', page)
    headings = dict(re.findall(r'<section id="(.*?)">\n<h2>(.*?)</h2>', page))
    assert len(entries) == 7
    assert dict(entries) == headings


def test_a_table_of_a_figure_has_its_head_above_its_rows():
    shown = reporting._table(Table(("case <", "count"), (("a", "1"), ("b", "2"))))
    cells = re.findall(r"<(th|td)>(.*?)</(?:th|td)>", shown)
    assert cells == [("th", "case &lt;"), ("th", "count"), *(("td", own) for own in ("a", "1", "b", "2"))]
    assert shown.index("<thead>") < shown.index("count") < shown.index("<tbody>") < shown.index("<td>a")
    assert reporting._table(None) == ""


FIXED = """
gelcone: The source paper, figure by figure and claim by claim
The source paper, figure by figure and claim by claim
gelcone 1.2.3, effort full, 2026-02-03
The source paper is J. Vib. Control, doi 10.1177/10775463261460015. Its equation of motion was derived again from the
energies that it names; figures are redrawn and claims checked with an integrator that respects the stretch limit of
the gel.
The identification of the parameters is not unique. Numbers marked text are from the paper's text. Those marked
reconstructed were found by a search over a few thousand sets for those under which most of the paper's claims hold;
other sets fit equally well, and a verdict can depend on the choice. Where a claim was also checked at other parameters,
the share of them for which it holds is given with its interval: samples grow until it leaves the claim's cut or a
budget ends, and all looks together hold at 95 %.
All quantities are dimensionless unless a unit is given. Lyapunov exponents are those of the flow, per unit of
dimensionless time.
Contents
How the verdicts are reached
The other films
The parameter sets
How the verdicts are reached
The check of a claim computes whether it holds in the long run at the paper's parameters, whether it holds over a finite
window from the start like the paper's, at what share of other parameters it holds, and whether it holds for a
fixed-step Runge-Kutta integrator in runs that go beyond the stretch limit. The first rule that applies gives the
verdict:
{rules}
The other films
If the film wrinkles A cone that goes slack where the paper's pushes, and pulls in.
With the membrane The axisymmetric membrane in place of a cone: claims about force and pull-in.
If it also creeps, behind 1 MOhm {creeping}
The parameter sets
table1 static curves
base voltage, pre-stretch and damping studies, maps
fast stretch-limit study, spectra, second opinion on every threshold
spring spring-stiffness study (figures 11 and 12)
"""
RULES = {
    Verdict.UNDECIDABLE: "The surviving text does not say enough, or nothing could be computed",
    Verdict.REPRODUCED: "It holds, and for more than half of the other parameters (where these were checked)",
    Verdict.CHOSEN: "It holds, but for at most half of them",
    Verdict.TRANSIENT: "It does not hold in the long run, but over a finite window",
    Verdict.ARTEFACT: "It holds for neither, but for the fixed-step integrator beyond the stretch limit",
    "elsewhere": "It holds at some of the other parameters",
    Verdict.NOT_REPRODUCED: "Otherwise",
    Verdict.UNDECIDED: "Where the numbers leave one of these questions open and the verdict depends on it",
}


def test_a_page_without_claims_explains_itself():
    """All that stands on every page, but for the table of parameters at its end."""
    rules = "\n".join(f"{said}: {getattr(own, 'value', Verdict.CHOSEN.value)}." for own, said in RULES.items())
    expected = FIXED.format(rules=rules, creeping=creeping_in_words())
    page = report_html([], [], effort="full", version="1.2.3", day=date(2026, 2, 3))
    assert words_of(page.partition('<table class="parameters">')[0], " ") == " ".join(expected.split())


def test_everything_is_escaped(page):
    outline = Outline(page)
    assert "script" not in outline.tags
    text = " ".join(outline.words)
    for part in ("threshold", "why", "unseen", "at", "Title", "values", "message", "statement", "voltages"):
        assert f"{part} {NASTY}" in text


def test_the_page_says_what_is_needed_to_judge_it(page):
    text = words_of(page, " ")
    for said in (
        "gelcone 1.2.3, effort quick, 2026-02-03",
        "The identification of the parameters is not unique.",
        "Of 8 claims: 2 reproduced, 1 only as a transient, 1 only for chosen parameters, 1 not reproduced, 1 artefact",
        "spring stiffness κ 1.5 text",
        "spring stiffness κ 0.9 reconstructed 0.5 reconstructed",
        "initial displacement and velocity 1, 0 reconstructed",
        "Redraw it with gelcone paper 8 . Its data: data/swing.nc",
        "1.0432 ± 0.0031",
        "0.20 [0.10, 0.30] mm",
        "share of other parameters (voltages) for which it holds 0.10 [0.02, 0.39]",
        "Claims whose figure is not drawn here gelcone paper 12 draws the figures that show them.",
    ):
        assert said in text


def test_the_rules_on_the_page_are_those_of_judge(page):
    rules = [line.split(". ", 1)[1] for line in judge.__doc__.splitlines() if re.match(r" +\d\. ", line)]
    assert len(rules) == 8
    assert all(f"<li>{rule}</li>" in page for rule in rules)


def test_a_large_svg_gives_way_to_the_png(tmp_path, monkeypatch):
    for suffix in ("png", "svg"):
        (tmp_path / f"figure-03.{suffix}").write_bytes(b"picture")
    drawn = DrawnFigure(None, tmp_path / "figure-03.png", tmp_path / "figure-03.svg", ())
    assert reporting._picture(drawn).startswith("data:image/svg+xml;base64,")
    monkeypatch.setattr(reporting, "LARGEST_SVG", 3)
    assert reporting._picture(drawn).startswith("data:image/png;base64,")


def test_a_report_without_claims_or_figures_is_a_whole_page():
    Outline(report_html([], [], effort="full", version="1", day=date(2026, 1, 1)))


# --- badges for all readers -------------------------------------------------------------------------------------------


def luminance(colour):
    parts = (int(colour[i : i + 2], 16) / 255.0 for i in (1, 3, 5))
    linear = [part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def test_every_badge_has_its_own_colour_and_readable_words(page):
    colours = {}
    for verdict, name in reporting.BADGES.items():
        background = re.search(rf"\.{name}\.badge \{{ background: (#\w+)", page)[1]
        colours[verdict] = {"#fff": "#ffffff"}.get(background, background)
        paper = luminance(colours[verdict])
        words = 1.0 if f".{name}.badge {{ background: {background}; color: #fff" in page else 0.0
        assert (max(paper, words) + 0.05) / (min(paper, words) + 0.05) >= 4.5
        assert f'<span class="badge {name}">{verdict.value}</span>' in page
    assert len(set(colours.values())) == len(Verdict)


# --- in a browser -----------------------------------------------------------------------------------------------------


class Browser:
    """Headless Chromium, driven over the DevTools protocol on two pipes: NUL-ended JSON messages."""

    def __init__(self, receive, send):
        self.receive, self.send, self.count, self.rest, self.events, self.session = receive, send, 0, b"", [], {}

    def turn_to_a_new_page(self):
        self.session, self.events = {}, []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = {"sessionId": self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]}
        for domain in ("Page", "Network", "Runtime", "Log"):
            self.call(f"{domain}.enable")

    def call(self, method, **params):
        self.count += 1
        message = {"id": self.count, "method": method, "params": params, **self.session}
        os.write(self.send, json.dumps(message).encode() + b"\0")
        while (answer := self.message()).get("id") != self.count:
            self.events.append(answer)
        assert "error" not in answer, answer
        return answer["result"]

    def message(self):
        while b"\0" not in self.rest:
            ready, _, _ = select.select([self.receive], [], [], PATIENCE)
            part = os.read(self.receive, 1 << 20) if ready else b""
            if not part:
                raise RuntimeError("Chromium went away" if ready else f"Chromium said nothing for {PATIENCE} s")
            self.rest += part
        text, self.rest = self.rest.split(b"\0", 1)
        return json.loads(text)

    def open(self, address):
        self.call("Page.navigate", url=address)
        while "Page.loadEventFired" not in (event["method"] for event in self.events):
            self.events.append(self.message())

    def evaluate(self, expression):
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"]["value"]

    def seen(self, method):
        return [event["params"] for event in self.events if event["method"] == method]


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    """A started browser; skips the test where there is none."""
    if CHROMIUM is None:
        pytest.skip("no Chromium on this machine: install it (Debian: apt-get install chromium) to run this test")
    pipes = [*os.pipe(), *os.pipe()]
    high = [fcntl.fcntl(end, fcntl.F_DUPFD_CLOEXEC, 10) for end in pipes]
    for end in pipes:
        os.close(end)
    commands, send, receive, answers = high
    # Chromium reads commands from descriptor 3 and answers on 4.
    start = f"import os, sys; os.dup2({commands}, 3); os.dup2({answers}, 4); os.execvp(sys.argv[1], sys.argv[1:])"
    process = subprocess.Popen(
        [sys.executable, "-c", start, CHROMIUM, *FLAGS, f"--user-data-dir={tmp_path_factory.mktemp('profile')}"],
        pass_fds=(commands, answers),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(commands)
    os.close(answers)
    try:
        yield Browser(receive, send)
    finally:
        os.close(send)
        os.close(receive)
        process.terminate()
        try:
            process.wait(20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def look(path, browser):
    """What a browser sees: widths of the pictures, requests beyond the page itself, complaints, and more."""
    address = path.resolve().as_uri()
    browser.turn_to_a_new_page()
    browser.open(address)
    ready = "Promise.allSettled([...document.images].map(i => i.decode()))"
    widths = browser.evaluate(f"{ready}.then(() => [...document.images].map(i => i.naturalWidth))")
    requests = [event["request"]["url"] for event in browser.seen("Network.requestWillBeSent")]
    kinds = ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded", "Network.loadingFailed")
    return {
        "widths": widths,
        "requests": [url for url in requests if url != address and not url.startswith("data:")],
        "complaints": [event for kind in kinds for event in browser.seen(kind)],
        "too wide": browser.evaluate("document.documentElement.scrollWidth > window.innerWidth"),
        "dead links": browser.evaluate("[...document.links].filter(a => !document.querySelector(a.hash)).length"),
    }


CLEAN = {"requests": [], "complaints": [], "too wide": False, "dead links": 0}


def test_a_browser_opens_the_report_without_complaint(page, tmp_path, browser):
    path = tmp_path / "report.html"
    path.write_text(page, encoding="utf-8")
    seen = look(path, browser)
    widths = seen.pop("widths")
    assert len(widths) == 2
    assert min(widths) > 0
    assert seen == CLEAN


@pytest.mark.parametrize(
    ("fault", "found"),
    [
        ("<img src='http://127.0.0.1:9/picture.png'>", "requests"),
        ("<img src='data:image/png;base64,AAAA'>", "widths"),
        ("<script>console.log('hello')</script>", "complaints"),
        ("<script>nothing()</script>", "complaints"),
        ("<p style='width: 500rem'>wide</p>", "too wide"),
        ("<a href='#nowhere'>there</a>", "dead links"),
    ],
)
def test_the_browser_finds_faults(tmp_path, browser, fault, found):
    path = tmp_path / "report.html"
    path.write_text(f"<!DOCTYPE html><html><body>{fault}</body></html>", encoding="utf-8")
    seen = look(path, browser)
    assert seen[found] != CLEAN.get(found, [])
    assert 0 in seen["widths"] or "img" not in fault


def test_the_page_forbids_requests(page, tmp_path, browser):
    path = tmp_path / "report.html"
    path.write_text(page.replace("</body>", "<img src='http://127.0.0.1:9/picture.png'></body>"), encoding="utf-8")
    seen = look(path, browser)
    assert "Content Security Policy" in str(seen["complaints"])


# --- the real thing ---------------------------------------------------------------------------------------------------


def test_a_small_report_from_end_to_end(tmp_path):
    """Real studies, figures and claims, those that take the least time."""
    quick = run(("energy-steepening", "linear-limit"), quick=True, out=tmp_path / "paper")
    assert [judged.claim.name for judged in quick.claims] == ["linear-limit", "energy-steepening"]
    check_figures(quick, [6])
    for judged in quick.claims:
        check_evidence(judged)
    assert quick.claims[0].verdict is Verdict.CHOSEN
    assert [other.film for other in quick.claims[0].others] == ["wrinkling", "membrane"]


@pytest.mark.slow
def test_the_quick_report_from_end_to_end(tmp_path, request):
    """Every study, figure and claim: one test, because the run takes about a minute on two cores."""
    quick = run(quick=True, out=tmp_path / "paper")
    assert len(quick.claims) == 21
    check_figures(quick, [*range(3, 15), "end-of-chaos"])
    for judged in quick.claims:
        check_evidence(judged)
    # Verdicts are not pinned, but for the two that are mathematically certain.
    verdicts = {judged.claim.name: judged.verdict for judged in quick.claims}
    assert verdicts["static-bistable"] is verdicts["practical-voltage"] is Verdict.REPRODUCED
    if CHROMIUM is not None:
        seen = look(quick.report, request.getfixturevalue("browser"))
        widths = seen.pop("widths")
        assert len(widths) == 13
        assert min(widths) > 0
        assert seen == CLEAN


def check_figures(quick, numbers):
    assert [drawn.figure.number for drawn in quick.figures] == numbers
    page = quick.report.read_text(encoding="utf-8")
    for drawn in quick.figures:
        assert f'id="{drawn.figure.name}"' in page
        assert all(path.stat().st_size > 0 for path in (drawn.png, drawn.svg, *drawn.data))


def check_evidence(judged):
    found = judged.finding
    assert judged.verdict is judge(found)
    assert found.why
    assert found.unseen
    assert math.isfinite(found.numbers[0].value)
    # an error is computed, or absent where all digits shown are those of the integrator
    assert all(number.error is None or number.error > 0.0 for number in found.numbers)


@pytest.mark.parametrize(("shown", "apart"), [((3,), False), ((12,), True), ((3, 12), True), ((), False)])
def test_the_contents_list_all_sections_that_the_page_has(shown, apart):
    """Claims whose figure is not drawn have a section of their own; without claims there is no glance at them."""
    figure = PaperFigure(3, "Title", ("base",), "values", "message", ("swing",), None)
    drawn = [DrawnFigure(figure, Path("a.png"), Path("a.svg"), ())]
    claims = [
        JudgedClaim(
            Claim(f"claim-{number}", "statement", number, ("swing",), None), finding(holds=True), Verdict.REPRODUCED
        )
        for number in shown
    ]
    links = Outline(reporting._contents(drawn, claims)).links
    expected = ["#claims"] * bool(shown) + [f"#{figure.name}"] + ["#other-claims"] * apart
    assert links == [*expected, "#verdicts", "#films", "#presets"]
    assert [judged.claim.figure for judged in reporting._without_picture(drawn, claims)] == [12] * apart
