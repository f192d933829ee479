"""Progress on a terminal: bars of all the work with what is being made, and lines that come at their time."""

from contextlib import contextmanager
from types import SimpleNamespace

import pytest

from gelcone import disk_cache
from gelcone.atlas.record import Tally
from gelcone.cli import output, paper, waiting
from gelcone.errors import InputError
from tests.analyses.said import SUBJECT
from tests.edited import made


class Bar:
    """A bar that records."""

    made: list = []

    def __init__(self, **given):
        self.given, self.said, self.n, self.total, self.initial = given, [], 0.0, given.get("total"), 0.0
        Bar.made.append(self)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.said.append("closed")

    def update(self, share):
        self.n += share

    def refresh(self):
        pass

    def set_description_str(self, text, refresh=True):
        self.said.append((text, refresh))

    def set_postfix_str(self, text, refresh):
        self.said.append((text, refresh))


@pytest.fixture
def bars(monkeypatch):
    import tqdm

    Bar.made = []
    monkeypatch.setattr(tqdm, "tqdm", Bar)
    for home in (output, paper, waiting):
        monkeypatch.setattr(home, "sys", SimpleNamespace(stderr=SimpleNamespace(isatty=lambda: True)))
    return Bar.made


def test_a_bar_takes_shares_of_the_work_and_names_what_is_made(bars):
    with output.progress_bar("static") as report, disk_cache.making(disk_cache.MEMBRANES):
        report(0.25)
        report(0.5)
    (bar,) = bars
    assert bar.n == 0.75
    assert bar.bar_format == "{l_bar}{bar}| {elapsed}<{remaining}"
    assert bar.given["bar_format"] == "{l_bar}{bar}| {elapsed}"
    assert {name: bar.given[name] for name in ("total", "desc", "leave")} == {
        "total": 1.0,
        "desc": "static",
        "leave": False,
    }
    assert bar.said == [("static, making membrane 1", True), ("static", True), "closed"]


@pytest.fixture
def lines(monkeypatch, capsys):
    """Writes the lines of a log when asked for, with the seconds since the begin of the work: seconds -> the line."""
    said, clock = [], [100.0]

    @contextmanager
    def logging(say):
        said.append(say)
        yield

    monkeypatch.setattr(output, "logging", logging)
    monkeypatch.setattr(output, "time", SimpleNamespace(monotonic=lambda: clock[0]))

    def after(seconds):
        clock[0] = 100.0 + seconds
        said[-1]()
        return capsys.readouterr().err

    return after


def test_a_line_of_a_log_says_what_is_done_what_is_left_and_what_is_made(lines):
    with output.progress_lines("static") as report:
        assert lines(3.0) == "static: 0 % after 3 s\n"
        report(0.25)
        assert lines(10.0) == "static: 25 % after 10 s, 30 s left\n"
        with disk_cache.making(disk_cache.MEMBRANES):
            assert lines(20.0) == f"static, making membrane 1: {waiting.STORED}; 25 % after 20 s\n"
        report(0.5)
        assert lines(30.0) == "static: 75 % after 30 s, 10 s left\n"
        report(0.25)
        assert lines(40.0) == "static: 100 % after 40 s\n"


def test_the_time_left_to_a_sweep_is_that_of_its_own_rate(lines):
    """Cells that a store held before took none of it."""
    tally = Tally(cells=1000, asked=300, computed=200, found=100, chaotic=50, seconds=20.0)
    text = "200 of 300 cells, 5 a second, 20 s left, 25 % chaotic"
    assert output.tally_text(tally) == text
    with output.tally_shown("map") as show:
        assert lines(7.0) == "map: no cell yet after 7 s\n"
        show(tally)
        assert lines(20.0) == f"map: {text}\n"
    assert output.tally_text(Tally(cells=9, asked=9, computed=4, found=4)) == "4 of 9 cells, 0 a second"


@pytest.mark.parametrize(("outcomes", "code"), [([0, 0], 0), ([6, 0], 0), ([6, 1], 1), (None, 0)])
def test_a_command_ends_with_1_where_every_run_failed(outcomes, code):
    result = made({"stroke": ("member", [1.0, 2.0])} if outcomes is None else {"outcome": ("member", outcomes)})
    answers = SimpleNamespace(command="settled", words=lambda shown, subject: "words")
    assert output.deliver(answers, result, SUBJECT, None, False, False) == code


def test_a_bar_of_cells_counts_what_was_asked_and_found(bars):
    with output.tally_shown("map") as show:
        show(Tally(cells=1000, asked=300, computed=200, found=100, chaotic=50, seconds=20.0))
    (bar,) = bars
    assert (bar.total, bar.n, bar.initial) == (300, 200, 100)
    assert bar.said == [("25 % chaotic", False), "closed"]
    assert (bar.given["unit"], bar.given["desc"], bar.given["leave"]) == ("cells", "map", False)
    numbers = {"n_fmt": 200, "total_fmt": 300, "elapsed": "00:20", "remaining": "00:10", "rate_fmt": "5 cells/s"}
    shown = bar.given["bar_format"].format(l_bar="map: 67%|", bar="#", postfix=", 25 % chaotic", **numbers)
    assert shown == "map: 67%|#| 200/300 cells [00:20<00:10, 5 cells/s, 25 % chaotic]"


@pytest.mark.parametrize(
    ("hidden", "terminal", "shown"), [(False, True, None), (True, True, True), (False, False, True)]
)
def test_the_bar_of_the_paper_is_one_of_terminals(hidden, terminal, shown, bars, monkeypatch):
    monkeypatch.setattr(paper.sys.stderr, "isatty", lambda: terminal)
    with paper.progress_bar(hidden) as progress:
        progress("claim limit", 0.0)
        progress("claim limit", 0.125)
    (bar,) = bars
    assert (bar.given["disable"], bar.given["total"], bar.n) == (shown, 1.0, 0.125)
    assert bar.said == [("claim limit", True), ("claim limit", False), "closed"]


@pytest.mark.parametrize("processors", [1, 3, 4, 64])
def test_the_paper_takes_a_process_a_core_up_to_four(processors, monkeypatch, command_line):
    from gelcone.motion import flow
    from gelcone.paper import run

    asked = []

    def made(names, **how):
        asked.append(how["workers"])
        raise KeyboardInterrupt

    monkeypatch.setattr(flow, "available_threads", lambda: processors)
    monkeypatch.setattr(run, "run", made)
    assert command_line("paper")[0] == 130
    assert asked == [min(processors, 4)]


def test_a_line_of_a_terminal_names_what_is_made_before_a_command_reports(bars):
    with waiting.said_before("fit"):
        for kind in (disk_cache.MEMBRANES, "code", disk_cache.MEMBRANES, disk_cache.CHARGES):
            with disk_cache.making(kind):
                pass
    assert [bar.given["desc"] for bar in bars] == [
        "fit, making membrane 1", "fit, compiling", "fit, making membrane 2", "fit, making membrane 2",
    ]  # fmt: skip
    assert all(bar.given["leave"] is False for bar in bars)


def test_the_first_line_of_a_log_comes_soon_and_the_others_now_and_then(monkeypatch):
    asked = []
    monkeypatch.undo()  # the tests of this folder silence lines
    monkeypatch.setattr(waiting, "ticking", lambda *given: asked.append(given))
    waiting.logging(print)
    ((say, every, first),) = asked
    assert say is print
    assert 1.0 < first < every < 60.0
    assert waiting.BAR_SECONDS <= 1.0


def test_ticks_come_at_their_times(monkeypatch):
    """The first after its own time, all others after theirs, and none once the work is done."""
    waits = []

    class Event:
        def wait(self, seconds):
            waits.append(seconds)
            return len(waits) > 3

        def set(self):
            waits.append("done")

    class Thread:
        def __init__(self, target, daemon):
            self.start = target
            assert daemon

        def join(self):
            waits.append("joined")

    ticks = []
    monkeypatch.setattr(waiting, "threading", SimpleNamespace(Event=Event, Thread=Thread))
    for first, begun in ((5.0, [5.0, 20.0, 20.0, 20.0]), (None, [20.0] * 4)):
        waits.clear()
        ticks.clear()
        with waiting.ticking(lambda: ticks.append(0), 20.0, first):
            pass
        assert waits == [*begun, "done", "joined"]
        assert len(ticks) == 3


@pytest.mark.parametrize(("amplitude", "code"), [("0", 0), ("0.01", 0), ("50", 1)])
def test_an_answer_without_runs_has_not_failed(amplitude, code, command_line):
    """A transfer function by linear theory alone; signals that settle, and such as end in failure."""
    about = ("rest_height=0.8", "hoop_prestretch=1.4", "damping_ratio=0.1", "stretch_limit=20")
    settings = [word for setting in about for word in ("--set", setting)]
    over = ("--over", "drive_frequency=1", "--over", f"amplitude={amplitude}")
    found = command_line("transfer", *settings, "--bias", "0.6", *over)
    assert found[0] == code, found


def test_a_result_whose_figure_fails_is_written_all_the_same_over_a_file_only_where_that_was_asked_for(tmp_path):
    def draw(shown):
        raise ArithmeticError("no figure")

    result = made({"stroke": ("member", [1.0, 2.0])})
    with pytest.raises(ArithmeticError):
        output._write(tmp_path, "settled", result, draw, False)
    assert [path.name for path in tmp_path.iterdir()] == ["settled.nc"]
    with pytest.raises(InputError, match="exists"):
        output._write(tmp_path, "settled", result, draw, False)
    with pytest.raises(ArithmeticError):
        output._write(tmp_path, "settled", result, draw, True)
