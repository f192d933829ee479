"""Progress adds up, and a run is stopped by its watch."""

import importlib
import threading
from types import SimpleNamespace

import pytest
import tqdm.auto

import gelcone
from gelcone import ConeModel, simulate
from gelcone.progress import Counted, Stopped, Watch, advance, bar, barred, split_progress, watching, weighted


def test_a_share_is_reported_to_a_progress_if_there_is_one():
    told = []
    advance(told.append, 0.25)
    advance(None, 0.5)
    assert told == [0.25]


def test_a_weighted_progress_is_a_share_of_the_whole():
    told = []
    half = weighted(told.append, 0.5)
    half(0.25)
    half(0.75)
    assert told == [0.125, 0.375]
    assert weighted(None, 0.5) is None


@pytest.mark.parametrize("share", [1.0, 0.4])
def test_two_parts_add_up_in_the_ratio_of_their_work(share):
    told = []
    first, second = split_progress(told.append, 3.0, 1.0, share)
    first(1.0)
    second(1.0)
    assert told == pytest.approx([0.75 * share, 0.25 * share])
    assert split_progress(None, 3.0, 1.0) == (None, None)


MODEL = ConeModel(rest_height=0.8, hoop_prestretch=1.3, damping_ratio=0.3, voltage=0.2)
RELAXING = MODEL.replace(viscous_modulus_1=0.5, relaxation_time_1=2.0)


@pytest.mark.parametrize(
    ("module", "part", "most", "run"),
    [
        ("response", "delivered", 0.7, lambda progress: simulate(MODEL, periods=2, progress=progress)),
        ("settled", "linear_response", 0.7, lambda progress: gelcone.settled(MODEL, progress=progress)),
        ("step", "stroke_and_blocked_force", 0.7, lambda progress: gelcone.step(MODEL, [0.3], progress=progress)),
        # the starts of the curve before it take two thirds of the time of a membrane behind a resistance
        ("creep", "validity_of_run", 0.85, lambda progress: gelcone.creep(RELAXING, [0.3], progress=progress)),
    ],
)
def test_a_bar_is_not_full_before_the_last_long_part_begins(monkeypatch, module, part, most, run):
    module, shares, before = importlib.import_module(f"gelcone.motion.{module}"), [], []
    work = getattr(module, part)

    def watched(*arguments, **options):
        before.append(sum(shares))
        return work(*arguments, **options)

    monkeypatch.setattr(module, part, watched)
    run(shares.append)
    assert 0.3 < before[-1] <= most + 1e-12
    assert sum(shares) == pytest.approx(1.0)


def test_a_watch_counts_steps_and_stops_what_it_watches():
    watch = Watch()
    with watching(watch):
        simulate(ConeModel(), periods=2)
    assert watch.steps > 10
    watch.stop.set()
    with pytest.raises(Stopped), watching(watch):
        simulate(ConeModel(), periods=2)
    counted = watch.steps
    simulate(ConeModel(), periods=2)  # outside nothing is watched
    assert watch.steps == counted


def test_a_watch_inside_another_gives_back_the_place():
    outer, inner = Watch(), Watch()
    with watching(outer):
        with watching(inner):
            simulate(ConeModel(), periods=1)
        before = outer.steps
        simulate(ConeModel(), periods=1)
    assert (before, outer.steps) == (0, inner.steps)


def test_a_watch_belongs_to_its_thread():
    watch = Watch()
    watch.stop.set()
    ended = []
    with watching(watch):
        other = threading.Thread(target=lambda: ended.append(simulate(ConeModel(), periods=1)))
        other.start()
        other.join()
    assert len(ended) == 1


@pytest.mark.parametrize(("shares", "rest"), [([], [1.0]), ([0.25, 0.5], [0.25]), ([0.25, 0.75], []), ([1.25], [])])
def test_work_that_ends_early_reports_the_rest(shares, rest):
    told = []
    counted = Counted(told.append)
    for share in shares:
        counted(share)
    counted.finish()
    counted.finish()
    assert told == shares + rest
    Counted(None).finish()


@pytest.fixture
def bars(monkeypatch):
    """The bars shown so far."""
    shown, own = [], tqdm.auto.tqdm
    monkeypatch.setattr("tqdm.auto.tqdm", lambda **options: shown.append(own(**options)) or shown[-1])
    return shown


def test_a_bar_adds_shares_and_takes_counts_of_cells_as_they_stand(bars, capsys):
    with bar("map") as report:
        report(0.25)
        report(SimpleNamespace(computed=2, asked=4))
        assert bars[0].n == pytest.approx(0.5)
        report(SimpleNamespace(computed=3, asked=4))
    assert (bars[0].n, bars[0].total) == (pytest.approx(0.75), 1.0)
    assert "map: " in capsys.readouterr().err
    for computed, asked in ((0, 0), (1, 1)):
        with bar("little to do") as report:
            report(SimpleNamespace(computed=computed, asked=asked))
        assert bars[-1].n == computed


def test_a_function_shows_a_bar_of_its_name_where_it_is_asked_for(bars):
    @barred
    def search(start, *, progress=None, steps=2):
        advance(progress, 0.25 * steps)
        return start + steps

    told = []
    assert (search(1), search(1, progress=None), search(1, progress=told.append, steps=3)) == (3, 3, 4)
    assert (bars, told) == ([], [0.75])
    assert search(2, progress=True, steps=3) == 5
    assert [(one.desc, one.n) for one in bars] == [("search", 0.75)]
