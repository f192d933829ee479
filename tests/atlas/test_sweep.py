import json
import os
import pickle
import shutil
import signal
import subprocess
import sys
import threading
import time
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.atlas import cluster, record, store, workers
from gelcone.atlas import sweep as module
from gelcone.atlas.frequency import frequency
from gelcone.atlas.plan import Plan
from gelcone.atlas.record import Tally, plan_record, show, stored_sweep
from gelcone.atlas.refinement import Refined
from gelcone.atlas.store import Field, Status, Store
from gelcone.atlas.sweep import sweep
from gelcone.codes import Outcome, Regime
from gelcone.dataset import Findings
from gelcone.errors import InputError, LostWorker
from gelcone.motion.envelope import envelope
from gelcone.motion.regime import regime
from gelcone.physics.model import ConeModel
from gelcone.register.analyses import find_analysis, sweepable
from tests import recorded
from tests.recorded import numbers
from tests.toys import STATED, StatedCone

FAST = ConeModel(damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.3)
QUICK = {"transient": 100.0, "budget": 300.0, "patience": 100.0}
DAMPED = FAST.replace(damping_ratio=0.4)  # which settles soon: at rest, periodic or chaotic
PLAN = Plan(DAMPED, {"voltage": np.linspace(0.0, 1.2, 13), "prestretch": np.linspace(0.8, 1.6, 5)}, options=QUICK)
COARSE = 4


@pytest.fixture(scope="module")
def watched():
    """The plan, refined, and what is told while it is computed."""
    tallies: list[Tally] = []
    shares: list[float] = []
    return sweep(PLAN, coarsest=COARSE, watch=tallies.append, progress=shares.append), tallies, shares


@pytest.fixture(scope="module")
def whole(watched):
    return watched[0]


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    """A store of the plan, written after every task and once more at the end; to be copied, not changed."""
    path = tmp_path_factory.mktemp("kept") / "s"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "FLUSH_SECONDS", 0.0)  # nothing waits to be written when the rest is inferred
        patch.setattr(module, "LONGEST_FLUSH_SECONDS", 0.0)
        result = sweep(PLAN, coarsest=COARSE, store=path)
    return path, result


def same(one, other):
    """Equal to the last bit, but for the time it took."""
    xr.testing.assert_identical(one.drop_attrs(deep=False), other.drop_attrs(deep=False))


def files(path):
    """All that a store holds."""
    return {str(p.relative_to(path)): p.read_bytes() for p in sorted(path.rglob("*")) if p.is_file()}


# --- cells ------------------------------------------------------------------------------------------------------------


def test_a_cell_is_what_it_is_alone(whole):
    place = {"voltage": 10, "prestretch": 2}
    cell = whole.isel(place)
    alone = regime(DAMPED.replace(**{n: float(cell[n]) for n in place}), **QUICK)
    assert int(cell["status"]) == Status.COMPUTED
    for name in ("lowest", "highest", "return_distance"):
        assert float(cell[name]) == float(alone[name])


def test_a_refined_map_says_where_its_values_come_from(whole):
    totals = json.loads(whole.attrs["totals"])
    assert 0 < totals["inferred"] < PLAN.size
    assert 0 <= totals["missed"] <= totals["checked"] <= 0.05 * PLAN.size
    assert totals["checked"] > 0
    inferred = whole["status"].values.ravel() == Status.INFERRED
    source = whole["source"].values.ravel()
    np.testing.assert_array_equal(inferred, source != np.arange(PLAN.size))
    for name in ("regime", "highest", "settled_time"):
        values = whole[name].values.ravel()
        np.testing.assert_array_equal(values, values[source])


def test_a_refined_map_has_the_regimes_of_the_uniform_one(whole):
    uniform = sweep(PLAN)
    assert (uniform["status"] == Status.COMPUTED).all()
    assert (uniform["regime"].values != whole["regime"].values).mean() <= 0.02
    computed = whole["status"] == Status.COMPUTED
    np.testing.assert_array_equal(uniform["highest"].where(computed), whole["highest"].where(computed))
    totals = [json.loads(result.attrs["totals"])["integrator_steps"] for result in (whole, uniform)]
    assert 0 < totals[0] < totals[1]


def test_who_computes_and_in_which_tasks_changes_no_bit(whole, monkeypatch):
    monkeypatch.setattr(module, "TASK_CELLS", 5)
    monkeypatch.setattr(module, "FEWEST_CELLS", 3)
    same(sweep(PLAN, coarsest=COARSE, workers=workers.threads(1)), whole)


OF_ITS_OWN = {"regime": QUICK, "lyapunov": {"transient": 60.0, "budget": 100.0, "window": 30.0}}


LONG = {"operating_limits": pytest.mark.slow}


@pytest.mark.parametrize("name", [pytest.param(name, marks=LONG.get(name, [])) for name in sweepable()])
def test_every_sweep_marks_the_cells_that_cannot_start(name):
    plan = Plan(DAMPED, {"stretch_limit": [0.3, 60.0]}, options=OF_ITS_OWN.get(name, {}))
    result = sweep(plan, name)
    from_rest = name in ("limits", "operating_limits")
    outside = Outcome.OK if from_rest else Outcome.OUTSIDE
    assert (result["outcome"].sel(stretch_limit=0.3) == outside).all()
    assert (result["outcome"].sel(stretch_limit=60.0) == Outcome.OK).all()
    assert result.attrs["analysis"] == name


def test_a_sweep_of_envelopes_and_of_responses():
    model = FAST.replace(rest_height=0.5, spring_stiffness=1.5, voltage_bias=0.3)
    plan = Plan(model, {"drive_frequency": [0.4, 0.8], "voltage": [0.0, 0.4]})
    ends = sweep(replace(plan, model=model.replace(voltage_bias=0.0)), "operating_limits")
    assert ends["outcome"].values.tolist() == [[Outcome.ERROR, Outcome.OK]] * 2  # no drive, no envelope
    alone = envelope(model.replace(voltage_bias=0.0, voltage=0.4), frequencies=[0.4, 0.8], margin=0.0)
    for k in range(2):
        slack = float(alone["limit_low"].sel(driven_limit="hoop slack")[k])
        assert float(ends["driven_hoop_slack_voltage"][k, 1]) == slack
        assert float(ends["safe_peak_voltage"][k, 1]) == float(alone["recommended_peak"][k])
    static = alone["static_limit_voltage"].sel(static_limit="hoop slack")
    assert float(ends["hoop_slack_voltage"][0, 1]) == pytest.approx(float(static), rel=1e-12)
    assert np.isnan(ends["driven_dielectric_breakdown_voltage"]).all()
    weak = sweep(
        Plan(model.replace(voltage_bias=0.0, voltage=0.4, dielectric_strength=0.3), {"drive_frequency": [0.4, 0.8]}),
        "operating_limits",
    )
    low = envelope(
        model.replace(voltage_bias=0.0, voltage=0.4, dielectric_strength=0.3), frequencies=[0.4, 0.8], margin=0.0
    )
    for k in range(2):
        breaks = float(low["limit_low"].sel(driven_limit="dielectric breakdown")[k])
        assert float(weak["driven_dielectric_breakdown_voltage"][k]) == breaks < 0.3
        assert float(weak["safe_peak_voltage"][k]) == float(low["recommended_peak"][k])
    moved = sweep(plan, "settled")
    swept = frequency(model.replace(voltage=0.4), [0.4, 0.8], (1.0, 0.0))
    np.testing.assert_allclose(moved["stroke"][:, 1], swept["stroke"].sel(branch="up"), rtol=1e-6)
    np.testing.assert_array_equal(moved["linear_stroke"][:, 1], swept["linear_stroke"])
    assert float(moved["stroke"][0, 0]) < 4.2e-9  # twenty decay times


@pytest.mark.parametrize(("cells", "team"), [(0, 2), (5, 2), (289, 2), (289, 1), (1300, 1), (5000, 64)])
def test_tasks_hold_every_cell_once_and_those_of_several_workers_are_small_at_the_end(cells, team):
    tasks = list(module._tasks(np.arange(cells), team))
    np.testing.assert_array_equal(np.sort(np.concatenate([np.arange(0), *tasks])), np.arange(cells))
    sizes = [task.size for task in tasks]
    assert sizes == sorted(sizes, reverse=True)
    assert all(size <= module.TASK_CELLS for size in sizes)
    assert all(size >= module.FEWEST_CELLS for size in sizes[:-1])  # with fewer the lanes stay empty
    assert max(sizes[-team:], default=0) <= (module.FEWEST_CELLS if team > 1 else module.TASK_CELLS)
    assert team > 1 or max(sizes) - min(sizes) <= 1


@pytest.mark.parametrize(("cells", "team"), [(2048, 1), (2048, 2), (10_000, 4)])
def test_the_time_left_follows_from_the_first_tasks_within_a_factor_of_two(cells, team):
    """Cells get dearer along the grid, as chaos does with the voltage: a tenth of the grid costs half of the time."""
    cost = np.where(np.arange(cells) < 0.9 * cells, 1.0, 9.0)
    tasks = list(module._tasks(np.arange(cells), team))
    done, spent = np.cumsum([task.size for task in tasks]), np.cumsum([cost[task].sum() for task in tasks])
    estimate = spent * (cells - done) / done
    early = (done > 0.1 * cells) & (done < 0.8 * cells)
    ratio = estimate[early] / (cost.sum() - spent[early])
    assert 0.5 < ratio.min() <= ratio.max() < 2.0
    # neighbours stay together: they share what a cell begins with, and tiles of a store
    assert all((np.diff(task) != 1).sum() <= task.size / module.FEWEST_CELLS + 2 for task in tasks)


def test_no_task_carries_the_whole_grid():
    plan = Plan(FAST, {"voltage": np.linspace(0.0, 1.0, 500), "prestretch": np.linspace(0.5, 1.0, 500)})
    assert plan.grid["voltage"].size == 250_000
    assert len(pickle.dumps(plan)) < 20_000


@pytest.mark.parametrize("count", [1, 2])
def test_tasks_are_given_out_only_a_little_ahead(count):
    asked = []

    def tasks():
        for task in range(200):
            asked.append(task)
            yield task

    with workers.threads(count)() as team:
        answers = team.run(lambda task: task, tasks())
        first = next(answers)[0]
        assert len(asked) <= 2 * workers.AHEAD * count
        assert sorted([first, *(answer for answer, _ in answers)]) == list(range(200))


def test_three_parameters_and_a_line():
    cube = sweep(
        Plan(FAST, {"voltage": [0.2, 0.4], "prestretch": [1.0, 1.2], "damping_ratio": [0.1, 0.2]}, options=QUICK)
    )
    assert cube["regime"].dims == ("voltage", "prestretch", "damping_ratio")
    line = sweep(Plan(FAST, {"voltage": np.linspace(0.0, 1.0, 33)}, options=QUICK), coarsest=5)
    assert line["regime"][0] == Regime.REST
    assert line["regime"][-1] != Regime.REST
    assert json.loads(line.attrs["totals"])["computed"] < 20


def test_a_cell_that_raises_an_error_is_told_and_stops_nothing(monkeypatch):
    from gelcone.motion import regime as regimes

    cells = regimes.regime_cells

    def broken(members, states, **options):
        if np.isclose(members.voltage, 0.5).any():
            raise ZeroDivisionError("made up")
        return cells(members, states, **options)

    monkeypatch.setattr(regimes, "regime_cells", broken)
    result = sweep(Plan(FAST, {"voltage": [0.3, 0.4, 0.5, 0.6]}, options=QUICK))
    assert result["outcome"].values.tolist() == [0, 0, Outcome.ERROR, 0]
    assert np.isnan(result["highest"][2])
    assert np.isfinite(result["highest"][[0, 1, 3]]).all()
    assert json.loads(result.attrs["totals"])["failed"] == 1


SHARES = Plan(
    ConeModel(dielectric_share=0.3, dielectric_time=2.0), {"dielectric_share": [0.2, 0.5, 1.0], "voltage": [0.1, 0.2]}
)
"""Plan of which the last row makes no actuator: of the permittivity only a part follows late."""


def test_cells_that_make_no_actuator_say_why_and_change_no_other(tmp_path):
    found = sweep(SHARES, "limits", store=tmp_path / "s")
    assert found["outcome"].values.tolist() == [[0, 0], [0, 0], [Outcome.IMPOSSIBLE] * 2]
    assert found.attrs["impossible"].startswith("dielectric_share = 1: must be below 1")
    assert json.loads(found.attrs["totals"])["failed"] == 2
    good = sweep(replace(SHARES, over={**SHARES.over, "dielectric_share": [0.2, 0.5]}), "limits")
    assert "impossible" not in good.attrs
    for name in ("pitchfork_voltage", "pull_in_voltage", "onset_voltage"):
        np.testing.assert_array_equal(found[name].values[:2], good[name].values)
        assert np.isnan(found[name].values[2]).all()
    shown = show(tmp_path / "s")
    assert shown.attrs["impossible"] == found.attrs["impossible"]
    assert json.loads(shown.attrs["totals"])["failed"] == 2
    words = gelcone.in_words(found).splitlines()
    at = next(k for k, line in enumerate(words) if line.startswith("2 of 6 runs cannot be made: no actuator has"))
    assert words[at + 1] == f"  the first that cannot be made: {found.attrs['impossible']}"


@pytest.mark.usefixtures("no_membranes")
def test_a_disc_as_large_as_its_film_makes_no_cell_of_a_device():
    """Of which no warning is left, as of roots of negative widths."""
    device = gelcone.find_device("biased-pump").replace(film="taut")
    over = {"disc_radius": ["8 mm", "30 mm"], "film_radius": ["30 mm", "60 mm"]}
    found = sweep(Plan(device, over), "limits")
    bad = Outcome.IMPOSSIBLE
    assert found["outcome"].values.tolist() == [[0, 0], [bad, 0]]
    assert found.attrs["impossible"].startswith("disc_radius = 30 mm: must be less than film_radius = 30 mm")
    alone = gelcone.regime(device.replace(disc_radius="30 mm", film_radius="60 mm"), patience=5.0, budget=20.0)
    map_ = gelcone.map(device, over, patience=5.0, budget=20.0)
    assert float(map_["highest"][1, 1]) == float(alone["highest"])


def test_a_store_with_cells_that_make_no_actuator_is_resumed_to_the_same(tmp_path, monkeypatch):
    found = sweep(SHARES, "limits", store=tmp_path / "whole")
    own, done = module.compute, []

    def stopped(plan, analysis, cells, keep=()):
        if done:
            raise Interrupted
        done.append(cells)
        return own(plan, analysis, cells, keep)

    monkeypatch.setattr(module, "compute", stopped)
    monkeypatch.setattr(module, "TASK_CELLS", 1)
    with pytest.raises(Interrupted):
        sweep(SHARES, "limits", store=tmp_path / "s", threads=1)
    monkeypatch.undo()
    assert [cells.size for cells in done] == [1]
    for _ in range(2):  # the second time there is nothing left to compute
        same(sweep(SHARES, "limits", store=tmp_path / "s", resume=True), found)


class Interrupted(BaseException):
    """An interrupt, as by the user."""


def test_a_sweep_of_which_no_cell_makes_an_actuator_is_refused():
    with pytest.raises(InputError, match=r"dielectric_share = 1: must be below 1"):
        sweep(replace(SHARES, over={"dielectric_share": [1.0, 1.5]}), "limits")


def test_a_lattice_whose_points_make_no_actuator_is_refined_all_the_same(monkeypatch):
    """The corners of the grid alone, which are all cells that are computed at first."""
    made = Plan.at

    def without_corners(self, values):
        ends = [np.isin(own, self.over[name][[0, -1]]) for name, own in values.items()]
        if np.logical_and.reduce(ends).any():
            raise InputError("a corner")
        return made(self, values)

    monkeypatch.setattr(Plan, "at", without_corners)
    plan = Plan(DAMPED, {"voltage": np.linspace(0.0, 0.4, 3), "prestretch": np.linspace(0.8, 1.6, 3)}, options=QUICK)
    found = sweep(plan, coarsest=2)
    assert found["outcome"].values[[0, 0, 2, 2], [0, 2, 0, 2]].tolist() == [Outcome.IMPOSSIBLE] * 4
    assert found.attrs["impossible"] == "a corner"
    computed = found["status"] == Status.COMPUTED
    assert json.loads(found.attrs["totals"])["computed"] == int(computed.sum())


def test_progress_counts_every_cell(watched):
    _, tallies, _ = watched
    counts = [tally.computed for tally in tallies]
    assert counts == sorted(counts)
    assert counts[-1] + tallies[-1].inferred == PLAN.size
    assert tallies[-1].steps > 0 < tallies[-1].seconds


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"analysis": "regimes"}, "did you mean 'regime'"),
        ({"analysis": "limits", "coarsest": 4}, "limits cannot be refined"),
        ({"analysis": "bifurcation"}, "bifurcation: cannot be swept"),
        ({"analysis": "lyapunov"}, "'patience' is not an option of the analysis lyapunov"),
        ({"keep": ["lyapunov"]}, "variable that a sweep of regime leaves out; known: section"),
        ({"threads": 1, "workers": workers.threads(1)}, "give one of them"),
        ({"coarsest": 1}, "at least 2"),
    ],
)
def test_bad_sweeps_are_refused(options, message):
    with pytest.raises(InputError, match=message):
        sweep(replace(PLAN, options={}) if options.get("analysis") == "limits" else PLAN, **options)


# --- the store --------------------------------------------------------------------------------------------------------


def test_a_store_is_read_by_xarray_as_it_is(whole, kept):
    path, result = kept
    same(result, whole)
    with xr.open_zarr(path, chunks=None) as stored:
        np.testing.assert_array_equal(stored["regime"], whole["regime"])
        np.testing.assert_array_equal(stored["lyapunov"], whole["lyapunov"])
        assert stored["lyapunov"].dims == ("voltage", "prestretch", "exponent")
        np.testing.assert_array_equal(stored["voltage"], PLAN.over["voltage"])
        assert stored["regime"].attrs["flag_meanings"] == whole["regime"].attrs["flag_meanings"]
    same(show(path), whole.drop_vars("source"))
    stored = stored_sweep(path)
    assert (stored.analysis, stored.coarsest, stored.keep) == ("regime", COARSE, ())
    assert stored.plan.options == {"tolerance": 1e-15, **QUICK}
    assert stored.plan.initial == PLAN.initial
    assert stored.plan.model.parameters() == DAMPED.parameters()


class Interrupt(Exception):
    pass


def interrupted(path, after, **options):
    """A run that stops after some tasks."""
    seen = []

    def stop(tally):
        seen.append(tally)
        if len(seen) == after:
            raise Interrupt

    with pytest.raises(Interrupt):
        sweep(PLAN, coarsest=COARSE, store=path, watch=stop, **options)


def test_what_was_interrupted_goes_on_to_the_same_bytes(tmp_path, monkeypatch, whole, kept):
    monkeypatch.setattr(module, "TASK_CELLS", 7)
    interrupted(tmp_path / "s", 2)
    held = show(tmp_path / "s")
    assert 0 < int((held["status"] == Status.COMPUTED).sum()) < PLAN.size
    assert np.isnan(held["highest"].where(held["status"] == Status.MISSING)).all()
    interrupted(tmp_path / "s", 4, resume=True)
    result = sweep(PLAN, coarsest=COARSE, store=tmp_path / "s", resume=True)
    same(result, whole)
    assert json.loads(result.attrs["totals"])["computed_before"] > 0
    assert files(tmp_path / "s") == files(kept[0])


def test_another_plan_or_version_is_refused_with_the_difference(tmp_path, monkeypatch):
    interrupted(tmp_path / "s", 1)
    for changed, message in [
        ({"model": DAMPED.replace(damping_ratio=0.06)}, r"damping_ratio is 0\.4 there and 0\.06 here"),
        ({"over": PLAN.over | {"voltage": [0.0, 1.0]}}, r"voltage is 13 values from 0 to 1\.2 there and \["),
        ({"options": QUICK | {"budget": 1000.0}}, "budget is 300.0 there and 1000.0 here"),
        ({"initial": (0.5, 0.0)}, r"initial is \[1\.0, 0\.0\] there and \[0\.5, 0\.0\] here"),
    ]:
        with pytest.raises(InputError, match=message):
            sweep(replace(PLAN, **changed), coarsest=COARSE, store=tmp_path / "s", resume=True)
    with pytest.raises(InputError, match="coarsest is 4 there and missing here"):
        sweep(PLAN, store=tmp_path / "s", resume=True)
    monkeypatch.setattr(record, "__version__", "9.9")
    with pytest.raises(InputError, match=r"gelcone_version is .* there and 9\.9 here"):
        sweep(PLAN, coarsest=COARSE, store=tmp_path / "s", resume=True)


def test_a_store_whose_cells_lack_what_is_computed_today_is_refused(tmp_path, monkeypatch):
    interrupted(tmp_path / "s", 1)
    read = Store.read
    monkeypatch.setattr(Store, "read", lambda store: {n: f for n, f in read(store).items() if n != "chaotic_until"})
    words = "s: its cells lack chaotic_until: an earlier version began it; finish it with that one, or choose another"
    with pytest.raises(InputError, match=words):
        sweep(PLAN, coarsest=COARSE, store=tmp_path / "s", resume=True)


def test_a_store_belongs_to_one_run(tmp_path):
    def second(tally):
        with pytest.raises(InputError, match="another run is writing to it"):
            sweep(PLAN, coarsest=COARSE, store=tmp_path / "s", resume=True)
        raise Interrupt

    with pytest.raises(Interrupt):
        sweep(PLAN, coarsest=COARSE, store=tmp_path / "s", watch=second)
    with pytest.raises(InputError, match="is not empty; resume it with --resume"):
        sweep(PLAN, coarsest=COARSE, store=tmp_path / "s")
    sweep(PLAN, coarsest=COARSE, store=tmp_path / "s", resume=True)


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    path = tmp_path_factory.mktemp("stores") / "s"
    sweep(Plan(FAST, {"voltage": [0.3, 0.4, 0.5]}, options=QUICK), store=path)
    return path


def cut(path):
    path.write_bytes(path.read_bytes()[:-3])


def flip(path):
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(bytes(content))


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda s: cut(s / "highest" / "c" / "0"), "is damaged: a tile of highest cannot be read"),
        (lambda s: flip(s / "highest" / "c" / "0"), "is damaged: a tile of highest cannot be read"),
        (lambda s: cut(s / "status" / "c" / "0"), "is damaged: a tile of status cannot be read"),
        (lambda s: (s / "highest" / "c" / "0").unlink(), "is damaged: a tile of highest is missing"),
        (lambda s: (s / "zarr.json").unlink(), "holds no metadata"),
        (lambda s: cut(s / "zarr.json"), "is damaged: its metadata cannot be read"),
        (lambda s: (s / "highest" / "zarr.json").unlink(), "is damaged: its array highest is missing"),
    ],
    ids=["cut tile", "changed tile", "cut status", "no tile", "no metadata", "cut metadata", "no array"],
)
def test_a_damaged_store_is_refused_in_one_line(stored, tmp_path, damage, message):
    path = tmp_path / "s"
    shutil.copytree(stored, path)
    damage(path)
    for use in (show, lambda p: sweep(stored_sweep(p).plan, store=p, resume=True)):
        with pytest.raises(InputError, match=message) as told:
            use(path)
        assert "\n" not in str(told.value)


def test_a_run_killed_while_it_made_the_store_leaves_one_to_begin_again(tmp_path):
    (tmp_path / "s").mkdir()
    (tmp_path / "s" / "zarr.0123.partial").write_text("{")
    sweep(Plan(FAST, {"voltage": [0.3, 0.4]}, options=QUICK), store=tmp_path / "s")
    assert (show(tmp_path / "s")["status"] == Status.COMPUTED).all()


def test_what_is_no_store_is_refused(tmp_path):
    import zarr

    with pytest.raises(InputError, match="no such store"):
        show(tmp_path / "nothing")
    (tmp_path / "run.nc").write_bytes(b"")
    with pytest.raises(InputError, match=r"run\.nc: is a file and no store; gelcone\.load reads it"):
        show(tmp_path / "run.nc")
    with pytest.raises(InputError, match=r"holds no metadata .*; name a file in it, such as .*run\.nc"):
        show(tmp_path)
    zarr.create_group(store=tmp_path / "foreign", zarr_format=3)
    with pytest.raises(InputError, match="not one that gelcone wrote"):
        show(tmp_path / "foreign")


def test_a_full_or_read_only_disk_loses_nothing(tmp_path, monkeypatch):
    import errno

    interrupted(tmp_path / "s", 2)
    before = files(tmp_path / "s")
    for number, remedy in ((errno.ENOSPC, "free some space"), (errno.EROFS, "make it writable")):

        def refuse(*_, number=number, **__):
            raise OSError(number, os.strerror(number))

        with monkeypatch.context() as patch:
            patch.setattr(store, "_write_part", refuse)
            with pytest.raises(InputError, match=f"what it holds is safe: {remedy} and continue with --resume"):
                sweep(PLAN, coarsest=COARSE, store=tmp_path / "s", resume=True)
        assert files(tmp_path / "s") == before
    sweep(PLAN, coarsest=COARSE, store=tmp_path / "s", resume=True)
    assert (show(tmp_path / "s")["status"] != Status.MISSING).all()


# --- processes --------------------------------------------------------------------------------------------------------

COMMAND = [
    "map",
    *("--set", "damping_ratio=0.05", "--set", "spring_stiffness=0.5", "--set", "drive_frequency=0.3"),
    *("--over", "voltage=0:1.2:24", "--over", "prestretch=0.8:2:12", "--coarsest", "4", "--transient", "300"),
    *("--patience", "300", "--budget", "1500"),
]


@pytest.mark.parametrize("who", [["--threads", "2"], ["--workers", "1"]], ids=["threads", "processes"])
def test_ctrl_c_ends_soon_and_leaves_a_store_to_resume(tmp_path, monkeypatch, command_line, who):
    monkeypatch.setattr(module, "FLUSH_SECONDS", 0.0)
    path, told, left = tmp_path / "s", [], threading.Event()

    def interrupt_when_cells_come():
        while not left.wait(0.05):
            if (path / "status" / "c").exists():
                told.append(time.monotonic())
                return signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)

    watch = threading.Thread(target=interrupt_when_cells_come)
    watch.start()
    code, _, error = command_line(*COMMAND, *who, "--store", path)
    ended = time.monotonic()
    left.set()
    watch.join()
    assert ended - told[0] < 4.0  # two seconds on a machine that does nothing else
    assert (code, error.strip().splitlines()[-1]) == (130, "interrupted")
    held = show(path)
    assert 0 < int((held["status"] == Status.COMPUTED).sum()) < held["status"].size


def test_a_cluster_gives_the_same_bits_also_when_a_worker_dies(whole, monkeypatch, tmp_path):
    """One worker is a process, which dies; the other one lives in this process."""
    distributed = pytest.importorskip("distributed")
    monkeypatch.setattr(module, "TASK_CELLS", 8)
    start = [sys.executable, "-m", "distributed.cli.dask_worker", "--no-nanny", "--nthreads", "1", "--no-dashboard"]
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="tcp://", dashboard_address=":0"
    ) as local:
        address, killed = local.scheduler_address, []
        mortal = subprocess.Popen([*start, address], stderr=subprocess.DEVNULL)

        def kill(tally):
            if not killed:
                killed.append(mortal.kill())

        try:
            with distributed.Client(address) as client:
                client.wait_for_workers(2, timeout=60)
            with monkeypatch.context() as patch:
                patch.setattr(cluster, "__version__", "9.9")
                with pytest.raises(InputError, match=r"its workers have .*, here is 9\.9; install the same"):
                    sweep(PLAN, workers=cluster.cluster(scheduler=address))
            (tmp_path / "scheduler.json").write_text(json.dumps({"type": "Scheduler", "address": address}))
            own = cluster.cluster(scheduler=str(tmp_path / "scheduler.json"))
            with pytest.warns(LostWorker, match=r"worker tcp://.* is lost; 1 left take over its tasks"):
                result = sweep(PLAN, coarsest=COARSE, workers=own, watch=kill)
        finally:
            mortal.kill()
            mortal.wait()
    assert killed
    same(result, whole)


def test_a_scheduler_that_does_not_answer_is_told(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 1)
    with pytest.raises(InputError, match="scheduler tcp://localhost:9: does not answer; start one"):
        sweep(PLAN, workers=cluster.cluster(scheduler="tcp://localhost:9"))


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"address": 5}', "[" * 100_000, '{"address": "tcp:'])
def test_what_is_no_scheduler_file_is_refused(monkeypatch, tmp_path, text):
    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 0.1)  # an empty file may be one that is being written
    path = tmp_path / "scheduler.json"
    path.write_text(text)
    with pytest.raises(InputError, match="is not a scheduler file of dask; start one with"):
        cluster._address(str(path))


@pytest.mark.parametrize("begun", [False, True])
def test_a_scheduler_file_is_waited_for_and_its_lack_is_said(tmp_path, monkeypatch, begun):
    """Also one that is empty, as it is being written."""
    path = tmp_path / "scheduler.json"
    if begun:
        path.touch()
    timer = threading.Timer(0.2, path.write_text, ['{"address": "tcp://10.0.0.1:8786"}'])
    timer.start()
    assert cluster._address(str(path)) == "tcp://10.0.0.1:8786"
    timer.join()
    assert cluster._address("tcp://a.json") == "tcp://a.json"
    assert cluster._address("localhost:8786") == "localhost:8786"
    monkeypatch.setattr(cluster, "CONNECT_SECONDS", 0.1)
    with pytest.raises(InputError, match="dask scheduler --scheduler-file"):
        cluster._address(str(tmp_path / "other.json"))


def test_the_last_worker_that_is_lost_and_those_that_leave_in_order_are_told_apart():
    watched = cluster._Watched(["tcp://a", "tcp://b"], "tcp://s:8786")
    watched((0.0, {"action": "remove-worker", "worker": "tcp://a", "expected": True}))
    watched((0.0, {"action": "remove-worker", "worker": "tcp://other"}))
    watched((0.0, "no dict"))
    with pytest.warns(
        LostWorker,
        match="tcp://b is lost; none is left; the run waits for one: start it with `dask worker tcp://s:8786`",
    ):
        watched((0.0, {"action": "remove-worker", "worker": "tcp://b"}))
    watched((0.0, {"action": "add-worker", "worker": "tcp://c"}))
    with pytest.warns(LostWorker, match="none is left"):
        watched((0.0, {"action": "remove-worker", "worker": "tcp://c"}))


def test_workers_are_checked():
    with pytest.raises(InputError, match="give one of them"):
        cluster.cluster()
    with pytest.raises(InputError, match="workers = 0: must be at least 1"):
        cluster.cluster(0)
    with pytest.raises(InputError, match="workers = 'two': must be a whole number, at least 1; leave it out"):
        cluster.cluster("two")
    with pytest.raises(InputError, match="workers: was given the number 2; give gelcone"):
        sweep(Plan(ConeModel(), {"voltage": [0.1, 0.2]}), "limits", workers=2)
    with pytest.raises(InputError, match="threads = 0"):
        workers.threads(0)


class Thinner(StatedCone):
    """A film whose stated error follows from its pre-stretch."""

    name = "thinner"

    def numbers(self, parameters):
        own = super().numbers(parameters)
        return own | {"film_error": 0.01 * np.sqrt(own["B"])}


def test_a_sweep_states_the_largest_error_of_the_films_of_its_cells(tmp_path):
    """In memory, from a store and of its draws; a bifurcation diagram, too, also where the model itself has another."""
    model = FAST.replace(film=Thinner(), hoop_prestretch=2.0)
    plan = Plan(model, {"hoop_prestretch": [1.1, 1.4]})
    found = sweep(plan, "limits", store=tmp_path / "s", threads=1)
    drawn = sweep(Plan(model, {"voltage": [0.1, 0.2]}, draws={"hoop_prestretch": [1.3, 1.2]}), "limits", threads=1)
    diagram = gelcone.bifurcation(model, "hoop_prestretch", [1.1, 1.5], sweeps=[], bisections=0, **QUICK)
    for result, stated in ((found, 0.014), (show(tmp_path / "s"), 0.014), (drawn, 0.013), (diagram, 0.015)):
        assert result.attrs["film_error"] == pytest.approx(stated)
        assert result.attrs["gain_error"] == STATED["gain_error"]


def test_a_store_of_another_version_says_so(tmp_path, monkeypatch):
    whole_record = module.plan_record
    monkeypatch.setattr(
        module, "plan_record", lambda *given: {k: v for k, v in whole_record(*given).items() if k != "options"}
    )
    sweep(Plan(FAST, {"voltage": [0.1, 0.2]}, options=QUICK), store=tmp_path / "s")
    with pytest.raises(InputError, match=r"its plan lacks options; it was made by another version"):
        stored_sweep(tmp_path / "s")


# --- what is computed, inferred and kept ------------------------------------------------------------------------------


def test_a_finished_refined_store_holds_its_inferred_cells_as_inferred(tmp_path, whole, kept):
    """Resumed, it computes nothing again and takes no inferred cell for a computed one."""
    shutil.copytree(kept[0], tmp_path / "s")
    held = json.loads(show(tmp_path / "s").attrs["totals"])
    totals = json.loads(whole.attrs["totals"])
    assert (held["computed"], held["inferred"]) == (totals["computed"], totals["inferred"])
    assert held["computed"] + held["inferred"] == PLAN.size > held["computed"]
    again = sweep(PLAN, coarsest=COARSE, store=tmp_path / "s", resume=True)
    resumed = json.loads(again.attrs["totals"])
    assert resumed["computed"] == resumed["computed_before"] == totals["computed"]
    assert (resumed["inferred"], resumed["integrator_steps"]) == (totals["inferred"], 0)
    same(again, whole)


def test_a_map_is_refined_also_where_only_the_sign_of_the_exponent_changes(monkeypatch):
    """Made-up cells of one regime, whose sign changes along a line between the coarsest points."""
    from gelcone.dataset import Findings
    from gelcone.motion import regime as regimes

    def cells(members, states, **options):
        sign = np.where(members.voltage < 0.77, -1, 1).astype(np.int8)
        return Findings(
            {
                "regime": ((), np.full(members.size, Regime.CHAOTIC, dtype=np.int8), "kind", "code"),
                "sign": ((), sign, "sign", "code"),
            },
            np.zeros(members.size, dtype=np.int8),
        )

    monkeypatch.setattr(regimes, "regime_cells", cells)
    result = sweep(Plan(FAST, {"voltage": np.linspace(0.0, 1.0, 65)}), coarsest=5)
    np.testing.assert_array_equal(result["sign"], np.where(result["voltage"] < 0.77, -1, 1))
    assert json.loads(result.attrs["totals"])["computed"] < 30


def test_progress_is_called_with_shares_that_add_up_to_one(watched):
    _, tallies, shares = watched
    assert sum(shares) == pytest.approx(1.0)
    assert min(shares) > 0.0
    assert len(tallies) >= len(shares)


def test_a_store_of_a_device_is_in_its_units(tmp_path):
    """Its arrays are those of the result, to the last bit, and those of each cell alone."""
    pump = gelcone.find_device("biased-pump").replace(
        film="taut", voltage_amplitude="0.4 kV", damping_coefficient="30 mN s/m"
    )
    plan = gelcone.Plan(pump, {"film_thickness": ["0.18 mm", "0.22 mm"]})
    found = gelcone.sweep(plan, "settled", store=tmp_path / "s.zarr")
    with xr.open_zarr(tmp_path / "s.zarr") as stored:
        for name, unit in (("stroke", "mm"), ("harmonic_amplitude", "mm"), ("harmonic_phase", "degree")):
            assert stored[name].attrs["units"] == found[name].attrs["units"] == unit
            np.testing.assert_array_equal(stored[name].values, found[name].values)
    for k, thickness in enumerate(("0.18 mm", "0.22 mm")):
        alone = gelcone.settled(pump.replace(film_thickness=thickness))
        assert float(found["stroke"][k]) == pytest.approx(float(alone["stroke"]), rel=1e-12)
    again = gelcone.sweep(plan, "settled", store=tmp_path / "s.zarr", resume=True)
    xr.testing.assert_equal(again.drop_vars("status"), found.drop_vars("status"))
    xr.testing.assert_equal(gelcone.show(tmp_path / "s.zarr")["stroke"], found["stroke"])
    stiffer = replace(plan, model=pump.replace(spring_rate="23 N/m"))  # moves its dimensionless damping ratio, too
    with pytest.raises(InputError, match=r"holds another run: spring_rate is 15\.0 there and 23\.0 here"):
        gelcone.sweep(stiffer, "settled", store=tmp_path / "s.zarr", resume=True)


def test_each_thing_that_decides_the_numbers_is_in_the_record_of_a_store():
    regime, plan = find_analysis("regime"), gelcone.Plan(ConeModel(), {"voltage": [0.4, 0.8]}, options=QUICK)

    def of(coarsest=None, keep=(), **changes):
        return json.dumps(plan_record(replace(plan, **changes), regime, coarsest, keep))

    others = [
        of(8), of(None, ("section",)), of(model=ConeModel(damping_ratio=0.2)), of(initial=(0.5, 0.0)),
        of(over={"voltage": np.array([0.4, 0.9])}), of(draws={"prestretch": np.array([0.9, 1.1])}),
        of(options={**QUICK, "budget": 99.0}),
    ]  # fmt: skip
    assert len({of(), *others}) == 1 + len(others)
    shown = gelcone.sweep(gelcone.Plan(ConeModel(), {"voltage": [0.4, 0.5]}, (0.5, 0.1)), "limits")
    assert json.loads(shown.attrs["options"])["initial"] == [0.5, 0.1]


@pytest.mark.parametrize(("took", "waits"), [(0.0, 2.0), (0.2, 4.0), (60.0, 10.0)])
def test_writing_takes_a_small_share_of_the_time_and_comes_every_two_to_ten_seconds(monkeypatch, took, waits):
    clock = iter([100.0, 100.0 + took, 100.0 + took])
    monkeypatch.setattr(module.time, "monotonic", lambda: next(clock))
    cells = SimpleNamespace(_store=None, _unwritten=[np.arange(3)])
    module._Cells.flush(cells)
    assert cells._unwritten == []
    assert cells._write_at == pytest.approx(100.0 + took + waits)


# --- what is known of cells, on made-up results -----------------------------------------------------------------------


def made_up(regime, outcome, sign, **more):
    """The fields of a task."""
    values = {"regime": regime, "outcome": outcome, "sign": sign}
    fields = {name: Field((), np.asarray(own, dtype=np.int8), {}) for name, own in values.items()}
    return fields | {name: Field((), np.asarray(own), {}) for name, own in more.items()}


def cells_of(size=6, draws=()):
    plan = SimpleNamespace(size=size, shape=(2, size // 2), draws=draws)
    return module._Cells(plan, ("regime", "sign"), np.arange(size))


def test_cells_are_counted_once_by_what_became_of_them():
    own, chaotic = cells_of(), int(Regime.CHAOTIC)
    own.ask(np.arange(5))
    assert (own.tally.asked, own.tally.computed, own.tally.found) == (5, 0, 0)
    own.take([(np.array([4]), None)], 1)  # before anything is known of the fields
    own.take([(np.array([3, 1]), made_up([chaotic, 0], [0, 2], [1, -1], height=[0.5, 0.25]))], 10)
    own.take([(np.array([0]), made_up([chaotic], [0], [1], height=[0.125])), (np.array([2]), None)], 7)
    tally = own.tally
    assert (tally.computed, tally.failed, tally.chaotic, tally.steps) == (5, 3, 2, 18)
    assert own.fields["outcome"].values[:5].tolist() == [0, 2, Outcome.ERROR, 0, Outcome.ERROR]
    np.testing.assert_array_equal(own.fields["height"].values[:5], [0.125, 0.25, np.nan, 0.5, np.nan])
    assert own.fields["status"].values.tolist() == [Status.COMPUTED] * 5 + [0]
    own.ask(np.array([0, 1, 5]))
    assert (own.tally.asked, own.tally.found, own.tally.computed) == (8, 2, 7)
    assert (own.tally.failed, own.tally.chaotic) == (4, 3)


def test_cells_that_were_not_computed_take_all_fields_of_their_source():
    own = cells_of()
    own.take([(np.array([1, 4]), made_up([2, 3], [0, 1], [1, -1], height=[0.5, 0.25]))], 1)
    own.infer(Refined(np.array([1, 1, 1, 4, 4, 4]), checked=3, missed=1))
    for name, values in {"regime": [2, 3], "outcome": [0, 1], "sign": [1, -1], "height": [0.5, 0.25]}.items():
        assert own.fields[name].values.tolist() == np.repeat(values, 3).tolist(), name
    assert own.fields["status"].values.tolist() == [
        Status.COMPUTED if k in (1, 4) else Status.INFERRED for k in range(6)
    ]
    assert (own.tally.inferred, own.tally.checked, own.tally.missed) == (4, 3, 1)


def test_borders_have_a_dimension_unless_cells_are_draws():
    kinds, dimensions = (np.arange(33)[:, None] > np.arange(33)).ravel(), []
    for draws in ((), ("voltage",)):
        own = module._Cells(SimpleNamespace(size=33 * 33, shape=(33, 33), draws=draws), ("regime",), np.arange(33 * 33))
        own.take([(np.arange(33 * 33), made_up(kinds, 0 * kinds, 0 * kinds))], 1)
        own.infer(Refined(np.arange(33 * 33)))
        dimensions.append(own.tally.border)
    assert dimensions[0][0] == pytest.approx(1.0, abs=0.1)
    assert dimensions[1] is None


def test_cells_are_of_one_kind_where_all_that_distinguishes_them_is_the_same():
    regimes, signs = (part.ravel() for part in np.meshgrid(np.arange(-1, 9), np.arange(-1, 2)))
    own = cells_of(regimes.size)
    own.take([(np.arange(regimes.size), made_up(regimes, 0 * regimes, signs))], 1)
    kinds = own.kinds(np.arange(regimes.size))
    assert np.unique(kinds).size == regimes.size
    assert own.kinds(np.array([7]))[0] == kinds[7]
    assert (module._Cells(SimpleNamespace(size=4), (), np.arange(4)).kinds(np.arange(4)) == 0).all()


@pytest.mark.parametrize(("analysis", "name"), [("regime", "budget"), ("regime", "patience"), ("lyapunov", "window")])
def test_budgets_that_are_not_positive_are_refused_before_any_cell(analysis, name):
    plan = Plan(FAST, {"voltage": [0.1, 0.2]}, options={name: -1.0})
    with pytest.raises(InputError, match=f"^{name} = -1"):
        module.check_sweepable(find_analysis(analysis), plan, None, ())


def test_a_sweep_of_which_no_cell_can_start_is_refused():
    with pytest.raises(InputError, match="stretch_limit"):
        sweep(Plan(FAST.replace(stretch_limit=0.3), {"voltage": [0.1, 0.2]}), "limits")


def test_what_is_kept_of_a_cell_belongs_to_the_plan_of_a_store(stored):
    with pytest.raises(InputError, match=r"keep is \[\] there and \['section'\] here"):
        sweep(Plan(FAST, {"voltage": [0.3, 0.4, 0.5]}, options=QUICK), store=stored, resume=True, keep=("section",))


def test_an_analysis_that_fails_in_every_cell_ends_the_sweep(monkeypatch):
    monkeypatch.setattr(module, "compute", lambda *given: 1 / 0)
    with pytest.raises(InputError, match="the analysis raises an error in every cell; run one of them alone to see it"):
        sweep(Plan(FAST, {"voltage": [0.1, 0.2]}))


def test_an_analysis_refuses_some_cells_with_the_reason_or_all_at_the_start(monkeypatch, tmp_path):
    """Those that it refuses are impossible; a reason that is that of every cell ends the sweep after a few."""
    limits = find_analysis("limits")
    own, asked = limits.compute, []

    def compute(members, states, **options):
        asked.append(members.size)
        if (members.values["spring_stiffness"] > most).any():
            raise InputError("spring_stiffness: is above most; lower it")
        return own(members, states, **options)

    monkeypatch.setattr(type(limits), "compute", property(lambda self: compute))
    plan, most = Plan(DAMPED, {"spring_stiffness": np.linspace(0.1, 1.2, 12)}), 0.95
    found = sweep(plan, "limits", store=tmp_path / "s")
    assert found["outcome"].values.tolist() == [Outcome.OK] * 9 + [Outcome.IMPOSSIBLE] * 3
    assert np.isfinite(found["pitchfork_voltage"].values).tolist() == [True] * 9 + [False] * 3
    assert found.attrs["impossible"] == "spring_stiffness: is above most; lower it"
    assert show(tmp_path / "s").attrs["impossible"] == found.attrs["impossible"]
    monkeypatch.setattr(module, "TASK_CELLS", 2)
    plan, most = Plan(DAMPED, {"spring_stiffness": np.linspace(0.1, 1.2, 900)}), 0.0
    asked.clear()
    with pytest.raises(InputError, match=r"^spring_stiffness: is above most; lower it"):
        sweep(plan, "limits", threads=1)
    assert len(asked) < 60


def test_what_has_no_order_is_neither_refined_nor_stored(tmp_path):
    draws = Plan(FAST, {"voltage": [0.1, 0.2]}, draws={"prestretch": [1.0, 1.1]})
    pump = gelcone.find_device("biased-pump").replace(film="taut")
    gels = Plan(pump, {"material": ["PVC-DBA 4:1", "PVC-DBA 6:1"]})
    for plan, message in ((draws, "coarsest = 2: draws of uncertain"), (gels, "coarsest: gels have no order")):
        with pytest.raises(InputError, match=message):
            module.check_sweepable(find_analysis("regime"), plan, 2, ())
        assert module.check_sweepable(find_analysis("regime"), plan, None, ())
    with pytest.raises(InputError, match="store: keeps no sweep over gels"):
        sweep(gels, store=tmp_path / "s")
    assert not list(tmp_path.iterdir())


def test_progress_is_the_share_of_the_cells_and_never_goes_back():
    shares, tallies = [], [Tally(8, computed=2), Tally(8, computed=1), Tally(8, computed=3), Tally(8, 3, 3, inferred=5)]
    report = module._reporter(None, shares.append)
    for tally in tallies:
        report(tally)
    assert shares == [0.25, 0.125, 0.625]
    watched = []
    module._reporter(watched.append, None)(tallies[0])
    assert watched == tallies[:1]


def test_a_task_that_raises_an_error_is_tried_cell_by_cell_unless_it_is_stopped(monkeypatch):
    asked = []

    def compute(plan, analysis, cells, keep):
        asked.append((cells.tolist(), keep))
        if 3 in cells:
            raise ZeroDivisionError
        if 7 in cells:
            raise InputError("no")
        if 9 in cells:
            raise MemoryError
        return cells.sum()

    monkeypatch.setattr(module, "compute", compute)
    found = module._task(None, None, ("section",), np.array([1, 3, 5]))
    assert [(cells.tolist(), result) for cells, result in found] == [([1], 1), ([3], None), ([5], 5)]
    assert asked == [(cells, ("section",)) for cells in ([1, 3, 5], [1], [3], [5])]
    refused = module._task(None, None, (), np.array([5, 7]))
    assert [(cells.tolist(), result) for cells, result in refused] == [([5], 5), ([7], "no")]
    with pytest.raises(MemoryError):  # cell by cell it would take as much
        module._task(None, None, (), np.array([5, 9]))


# --- what is handed on ------------------------------------------------------------------------------------------------


def test_cells_are_computed_at_their_own_values_and_starts_in_one_thread_without_what_takes_much_room():
    """Of a device in its units; what is asked to be kept, is."""
    asked, pump = [], gelcone.find_device("biased-pump").replace(film="taut")

    def compute(members, states, *, threads, **options):
        asked.append((members, states, threads, options))
        size = members.size
        table = {
            "lowest": ((), numbers(size, at=1.0), "lowest", "length"), "section": (("point",), numbers(size, 3), "",
            "state"),
            "regime": ((), np.arange(size), "kind", "code"), "running": (("point",), numbers(size, 3), "", "rate"),
        }  # fmt: skip
        return Findings(table, np.arange(size, dtype=np.int8))

    analysis = SimpleNamespace(compute=compute, bulky=("section", "running"))
    plan = Plan(pump, {"frequency": [8.0, 9.0], "displacement": [1e-3, 2e-3]}, options={"tolerance": 2e-9})
    found = module.compute(plan, analysis, np.array([3, 0]), keep=("running",))
    ((members, states, threads, options),) = asked
    assert (threads, options) == (1, {"tolerance": 2e-9})
    own = [pump.replace(frequency=f"{hertz} Hz") for hertz in (9.0, 8.0)]
    np.testing.assert_allclose(
        members.number("drive_frequency"), [float(one.to_model().drive_frequency) for one in own]
    )
    np.testing.assert_allclose(states[:, 0], [2e-3 / own[0].scales.length, 1e-3 / own[1].scales.length])
    assert sorted(found) == ["lowest", "outcome", "regime", "running"]
    assert found["lowest"].attributes["units"] == "mm"
    np.testing.assert_allclose(found["lowest"].values, 1e3 * numbers(2, at=1.0) * pump.scales.length)
    assert found["regime"].attributes["flag_meanings"].split()[0] == "rest"
    assert found["outcome"].values.tolist() == [0, 1]
    assert found["running"].dims == ("point",)


@pytest.mark.parametrize("coarsest", [None, 2])
def test_a_sweep_hands_each_part_what_it_was_asked_for(monkeypatch, coarsest):
    """All cells are asked for, or those that the refinement wants; the last report holds the time of all."""
    plan, told, asked = Plan(FAST, {"voltage": [0.1, 0.2, 0.3]}), [], {}

    def task(full, analysis, keep, cells):
        asked["task"] = full.options, analysis.name, keep
        table = {"regime": numbers(cells.size), "sign": numbers(cells.size), "outcome": np.zeros(cells.size, np.int8)}
        return [(cells, {name: Field((), values, {}) for name, values in table.items()})]

    def team(function, tasks):
        for cells in tasks:
            yield function(cells), 7

    def wanted(shape, at_least):
        asked["refine"] = shape, at_least
        yield np.array([0, 2])
        return Refined(np.array([0, 0, 2]), checked=5, missed=1)

    def workers(size, threads):
        asked["workers"] = size, threads
        return lambda: nullcontext(SimpleNamespace(size=1, run=team))

    parts = recorded.record(monkeypatch, module, label="labelled")
    for name, stand_in in (("_task", task), ("usual_workers", workers), ("refine", wanted)):
        monkeypatch.setattr(module, name, stand_in)
    options = {"transient": 11.0, "budget": 13.0}
    full = Plan(plan.model, plan.over, (0.25, 0.5), options=options)
    assert sweep(full, coarsest=coarsest, keep=("section",), watch=told.append, threads=5) == "labelled"
    assert asked["workers"] == (3, 5)
    given, analysis, keep = asked["task"]
    assert {name: given[name] for name in options} == options
    assert (given["patience"], analysis, keep) == (None, "regime", ("section",))
    (label,) = parts["label"]
    assert (label["plan"], label["title"]) == (full, "sweep: regime")
    assert told[-1] is label["tally"]
    assert all(tally.seconds > 0.0 for tally in told)
    assert label["tally"].seconds >= 0.0
    tally = label["tally"]
    assert (tally.steps, tally.computed, tally.inferred) == ((7, 3, 0) if coarsest is None else (7, 2, 1))
    assert (tally.checked, tally.missed) == ((0, 0) if coarsest is None else (5, 1))
    assert label["sources"].tolist() == ([0, 1, 2] if coarsest is None else [0, 0, 2])
    assert asked.get("refine") == (None if coarsest is None else ((3,), 2))
