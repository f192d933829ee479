"""Sweeps of any size: an analysis in every cell of a plan, by any workers, stored while it runs.

Either every cell of the grid is computed, or the grid is refined level by level (`gelcone.atlas.refinement`) and cells
that are not computed take their values from a computed cell nearby. Workers take cells in tasks of about a second.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gelcone import dataset
from gelcone.atlas.plan import Plan
from gelcone.atlas.processes import usual_workers
from gelcone.atlas.record import Tally, coordinates, label, plan_record
from gelcone.atlas.refinement import Cells, Kinds, Refined, border_dimension, refine
from gelcone.atlas.store import STATUS_ATTRIBUTES, Field, Status, Store, fill_of, open_store
from gelcone.atlas.workers import Team, Workers
from gelcone.codes import Outcome, Regime
from gelcone.devices.analysis import analysis
from gelcone.devices.points import GELS, at
from gelcone.devices.si import shown_values
from gelcone.errors import InputError, check_names, described
from gelcone.motion.settle import check_budgets
from gelcone.motion.start import complete, start_states
from gelcone.progress import Progress, Stopped
from gelcone.register.analyses import find_analysis, sweepable
from gelcone.register.analysis import Analysis

if TYPE_CHECKING:
    import xarray as xr

TASK_CELLS = 256
"""Most cells of a task: some seconds of work that keep the integrator's lanes full."""
FEWEST_CELLS = 32
"""Fewest cells of a task, where there are as many: with fewer, lanes are empty and a cell costs a half more."""
GOLDEN = (5.0**0.5 - 1.0) / 2.0
FLUSH_SECONDS, LONGEST_FLUSH_SECONDS = 2.0, 10.0
"""Shortest and longest time between two writes to the store."""
FLUSH_SHARE = 0.05
"""Share of the time that is spent on writing, within these bounds."""
LARGEST_KIND = 64
"""Values of the variables that distinguish kinds of cells lie between -1 and this."""


@analysis(
    takes="plan",
    answers="grids",
    over="A parameter of the grid, or a field of a device: name=from:to:count or name=v1,v2,...; any number.",
    single=True,
    examples=(
        "--preset base --over voltage=0:2:21 --over prestretch=0.6:1.4:5 --over damping_ratio=0.01,0.1",
        "--preset base --over voltage=0.8:1.2:21 --uncertain prestretch=1~0.02 --count 128",
        'soft-film --over "voltage_amplitude=400 V:600 V:5" --uncertain "film_thickness=100 um~5 um"',
    ),
)
def sweep(
    plan: Plan,
    analysis: str = "regime",
    *,
    coarsest: int | None = None,
    keep: Sequence[str] = (),
    store: str | Path | None = None,
    resume: bool = False,
    workers: Workers | None = None,
    watch: Callable[[Tally], None] | None = None,
    threads: int | None = None,
    progress: Progress = None,
) -> xr.Dataset:
    """Compute an analysis in every cell of a plan.

    A cell's numbers are those of the analysis for the cell's model and initial state, under the same names, to the last
    bit, on any worker.

    Parameters
    ----------
    plan : which parameters are swept over which values, which are drawn, and the options of the analysis.
    analysis : an analysis that can be swept: regime, lyapunov, limits, settled or
        operating_limits. Default ``"regime"``.
    coarsest : computes only a lattice of at least this number of points along each axis, and the cells needed to follow
        every change of regime, or of the exponent's sign, down to the finest cell. Default: all cells are computed.
    keep : variables with many values a cell that a sweep leaves out otherwise: ``section`` of regime; ``running_time``,
        ``running_exponent``, ``finite_time`` and ``finite_exponent`` of lyapunov. Default none.
    store : folder that keeps what is computed while the sweep runs (a Zarr group). Default none.
    resume : continues with what ``store`` holds, whose plan must be the same. Default no.
    workers : who computes, for example `gelcone.cluster`. Default one process a core for 1,024 cells or more, else
        threads of this process.
    watch : called with a `Tally` of the cells after each task. Default none.
    threads : number of threads of this process. Default as ``workers``. Does not change a bit of the result.
    progress : called with the share of the work just done (the shares add up to 1).

    Returns
    -------
    Dataset over the plan's axes, in SI units for a device, with the variables of the analysis, ``status`` (of `Status`)
    and ``source``, the flattened index of the cell whose values a cell carries: its own where it was computed.
    ``attrs["totals"]`` holds the `Tally`. Cells whose values exclude one another, such as a disc larger than its film,
    have the outcome ``impossible``, and ``attrs["impossible"]`` states why the first of them has.

    Raises
    ------
    InputError : for an unknown analysis or option, an analysis that cannot be swept or refined, no cell that is
        possible and inside its stretch limit, threads as well as workers, and what
        `gelcone.atlas.store.open_store` refuses.

    Examples
    --------
    >>> import gelcone
    >>> model = gelcone.ConeModel(damping_ratio=0.1, spring_stiffness=0.5)
    >>> plan = gelcone.Plan(model, {"voltage": [0.4, 0.8], "drive_frequency": [0.4, 0.5]})
    >>> cells = gelcone.sweep(plan, "limits")
    >>> cells.onset_voltage.values.round(4).tolist()
    [[0.7151, 0.6581], [0.7151, 0.6581]]
    """
    if not isinstance(plan, Plan):
        raise InputError(
            f"sweep: was given {described(plan)}; give a plan, such as Plan(device, {{'voltage_amplitude': ...}})"
        )
    analysis_entry = find_analysis(analysis)
    options = check_sweepable(analysis_entry, plan, coarsest, keep)
    possible, models, states = plan.possible()
    start_states(models, states)
    if workers is not None and not callable(workers):
        raise InputError(f"workers: was given {described(workers)}; give gelcone.cluster(workers=N), or threads=N")
    if workers is not None and threads is not None:
        raise InputError(f"threads = {threads}: workers are given too; give one of them")
    report, errors = _reporter(watch, progress), dataset.film_errors(models)
    compute_cells = partial(_task, replace(plan, options=options), analysis_entry, tuple(keep))
    cells = _Cells(plan, analysis_entry.kinds, possible)
    with ExitStack() as stack:
        if store is not None and GELS in plan.over:
            raise InputError("store: keeps no sweep over gels; leave it out, or sweep the numbers of the material")
        if store is not None:
            record = plan_record(plan, analysis_entry, coarsest, keep, errors)
            cells.keep_in(stack.enter_context(open_store(Path(store), record, plan.dims, plan.shape, resume=resume)))
        team = stack.enter_context((workers or usual_workers(plan.size, threads))())
        begun = time.monotonic()

        def timed(tally: Tally) -> None:
            report(replace(tally, seconds=time.monotonic() - begun))

        stack.enter_context(cells.flushed_at_the_end())
        requests = refine(plan.shape, coarsest) if coarsest is not None else _all(plan.size)
        refined = _follow(requests, partial(_work, cells, team, compute_cells, timed))
        cells.infer(refined)
        totals = replace(cells.tally, seconds=time.monotonic() - begun)
        report(totals)
    return label(plan, analysis_entry, cells.fields, refined.sources, totals, f"sweep: {analysis}", errors)


def check_sweepable(analysis: Analysis, plan: Plan, coarsest: int | None, keep: Sequence[str]) -> dict[str, Any]:
    """The options of all cells, with defaults for those that the plan does not give.

    Raises `InputError` where the analysis cannot be swept, or not with these arguments.
    """
    if not analysis.swept:
        more = "" if analysis.single else f"; {analysis.command} itself takes lists, which make an ensemble"
        raise InputError(f"{analysis.name}: cannot be swept; choose one of {', '.join(sweepable())}{more}")
    check_names(f"variable that a sweep of {analysis.name} leaves out", keep, analysis.bulky)
    if coarsest is not None and (not analysis.kinds or plan.draws):
        what = "draws of uncertain parameters" if plan.draws else f"the analysis {analysis.name}"
        raise InputError(f"coarsest = {coarsest}: {what} cannot be refined; compute every cell")
    if coarsest is not None and GELS in plan.over:
        raise InputError("coarsest: gels have no order, between which a map could be refined; compute every cell")
    options = analysis.settings(plan.options)
    check_budgets(**{name: options[name] for name in ("window", "transient", "patience", "budget") if name in options})
    return options


def _reporter(watch: Callable[[Tally], None] | None, progress: Progress) -> Callable[[Tally], None]:
    """A function that passes a tally to ``watch``, and the share of the cells that it adds to ``progress``."""
    done = 0.0

    def report(tally: Tally) -> None:
        nonlocal done
        now = (tally.computed + tally.inferred) / tally.cells
        if watch is not None:
            watch(tally)
        if progress is not None and now > done:
            progress(now - done)
        done = max(now, done)

    return report


def compute(plan: Plan, analysis: Analysis, cells: Cells, keep: Sequence[str] = ()) -> dict[str, Field]:
    """Compute an analysis of some cells of the flattened grid, in the order given; the plan has all options.

    The fields of a device are in its units. They are plain arrays, so that processes do not load xarray.
    """
    model, states = plan.at(plan.values(cells))
    members = model.members()
    computed = analysis.compute(members, complete(members, states), threads=1, **plan.options)
    fields = {
        name: Field(dims, np.asarray(values), dataset.attributes(long_name, quantity))
        for name, (dims, values, long_name, quantity) in computed.variables.items()
        if name in keep or name not in analysis.bulky
    }
    if plan.device is not None:
        scales = at(plan.device, plan.values(cells)).scales
        for name, field in fields.items():
            values, attributes = shown_values(field.values, field.attributes, scales)
            fields[name] = replace(field, values=values, attributes=attributes)
    if "regime" in fields:
        fields["regime"] = replace(
            fields["regime"], attributes={**fields["regime"].attributes, **dataset.flags(Regime)}
        )
    return fields | {"outcome": Field((), np.asarray(computed.outcome, dtype=np.int8), dataset.OUTCOME_ATTRIBUTES)}


def _all(size: int) -> Generator[Cells, Kinds, Refined]:
    """Requests every cell at once."""
    yield np.arange(size)
    return Refined(np.arange(size))


def _follow(wanted: Generator[Cells, Kinds, Refined], answer: Callable[[Cells], Kinds]) -> Refined:
    """Sends the kinds of the requested cells to a refinement until it ends, and returns its result."""
    try:
        asked = next(wanted)
        while True:
            asked = wanted.send(answer(asked))
    except StopIteration as ended:
        refined: Refined = ended.value
        return refined


Part = tuple[Cells, dict[str, Field] | str | None]
"""Some cells and their fields; of cells that are impossible the reason in words, and None for a cell whose analysis
raised another error."""
Task = Callable[[Cells], list[Part]]


def _work(cells: _Cells, team: Team, task: Task, progress: Callable[[Tally], None], asked: Cells) -> Kinds:
    """Lets the workers compute the cells that are missing and possible, and returns the kinds of all."""
    cells.ask(asked)
    missing = asked[~cells.computed[asked]]
    possible = cells.possible[missing]
    for parts, steps in team.run(task, _tasks(missing[possible], team.size)):
        cells.take(parts, steps)
        if not cells.examined and any(isinstance(result, str) for _, result in parts):
            cells.examine(task)
        progress(cells.tally)
    if not cells.fields and not possible.any():
        for parts, _ in team.run(task, iter([np.flatnonzero(cells.possible)[:1]])):
            cells.begin(parts)
    if not cells.fields:
        error = "the analysis raises an error in every cell; run one of them alone to see it"
        raise InputError(next(iter(cells.reasons), error))
    cells.take([(missing[~possible], "")], 0)
    return cells.kinds(asked)


def _spread(cells: Cells) -> Cells:
    """Cells in an order of which every part samples the whole grid, in runs of neighbours.

    The cost of cells varies over the grid, so that only such parts predict how long the rest will take. The runs follow
    multiples of the golden ratio, which fill the grid evenly.
    """
    runs = np.split(cells, np.arange(FEWEST_CELLS, cells.size, FEWEST_CELLS))
    order = np.argsort(np.arange(len(runs)) * GOLDEN % 1.0, kind="stable")
    inverse = np.empty_like(order)
    inverse[order] = np.arange(len(runs))
    return np.concatenate([runs[k] for k in inverse])


def _tasks(cells: Cells, team: int) -> Iterator[Cells]:
    """Cuts cells into tasks. For several workers tasks get smaller as fewer cells are left, so that all workers end at
    about the same time."""
    cells, first = _spread(cells), 0
    while left := cells.size - first:
        parts = max(math.ceil(left / TASK_CELLS), 2 * team if team > 1 else 1)
        last = first + min(max(math.ceil(left / parts), FEWEST_CELLS), TASK_CELLS, left)
        yield cells[first:last]
        first = last


def _task(plan: Plan, analysis: Analysis, keep: tuple[str, ...], cells: Cells) -> list[Part]:
    """Computes some cells. After an error they are computed one by one; those that raise an error have no result."""
    try:
        return [(cells, compute(plan, analysis, cells, keep))]
    except (Stopped, MemoryError):
        raise
    except Exception as error:
        if cells.size == 1:
            return [(cells, str(error) if isinstance(error, InputError) else None)]
    return [part for cell in np.split(cells, cells.size) for part in _task(plan, analysis, keep, cell)]


class _Cells:
    """The computed cells of a plan, in memory and - with a store - on disk."""

    def __init__(self, plan: Plan, kinds: tuple[str, ...], possible: Cells) -> None:
        self.plan = plan
        self.possible = np.zeros(plan.size, dtype=bool)
        self.possible[possible] = True
        self._kinds = kinds
        self.examined = False
        self.fields: dict[str, Field] = {}
        self.computed = np.zeros(plan.size, dtype=bool)
        self.tally = Tally(plan.size)
        self._store: Store | None = None
        self._untaken: list[Part] = []
        self._unwritten: list[Cells] = []
        self._write_at = time.monotonic() + FLUSH_SECONDS

    def keep_in(self, store: Store) -> None:
        """Reads the cells of a store, to which further ones are written from now on."""
        self._store, self.fields = store, store.read()
        if self.fields:
            self.computed = self.fields["status"].values == Status.COMPUTED

    def ask(self, cells: Cells) -> None:
        """Counts cells as asked for."""
        computed_count = int(self.computed[cells].sum())
        tally = self.tally
        self.tally = replace(tally, asked=tally.asked + cells.size, found=tally.found + computed_count)
        self._count(cells[self.computed[cells]])

    def take(self, parts: list[Part], steps: int) -> None:
        """Stores the results of a task; cells without one get the outcome `Outcome.IMPOSSIBLE` or `Outcome.ERROR`."""
        self.tally = replace(self.tally, steps=self.tally.steps + steps)
        known = self.begin(parts)
        if self._store is not None and known and (lacks := sorted(known[0].keys() - self.fields.keys())):
            raise InputError(
                f"{self._store.path}: its cells lack {lacks[0]}: an earlier version began it; finish it with that "
                "one, or choose another store"
            )
        self._untaken += parts
        if not self.fields:
            return
        for cells, result in self._untaken:
            self.fields["outcome"].values[cells] = Outcome.IMPOSSIBLE if isinstance(result, str) else Outcome.ERROR
            for name, field in result.items() if isinstance(result, dict) else ():
                self.fields[name].values[cells] = field.values
            self.fields["status"].values[cells] = Status.COMPUTED
            self.computed[cells] = True
            self._count(cells)
            self._unwritten.append(cells)
        self._untaken = []
        if time.monotonic() > self._write_at:
            self.flush()

    def begin(self, parts: list[Part]) -> list[dict[str, Field]]:
        """Begins the fields of all cells as the first of the results, which are returned."""
        known = [result for _, result in parts if isinstance(result, dict)]
        if self.fields or not known:
            return known
        size = self.plan.size
        for name, field in known[0].items():
            of = field.values
            self.fields[name] = replace(field, values=np.full((size, *of.shape[1:]), fill_of(of.dtype), dtype=of.dtype))
        self.fields["status"] = Field((), np.zeros(size, dtype=np.uint8), STATUS_ATTRIBUTES)
        if self._store is not None:
            self._store.begin(self.fields, coordinates(self.plan))
        return known

    @property
    def reasons(self) -> list[str]:
        """The reasons why cells are impossible, of those not stored since no result is known."""
        return [result for _, result in self._untaken if isinstance(result, str)]

    def examine(self, task: Task) -> None:
        """Raises `InputError` if the first, the middle and the last cell are impossible for one and the same reason,
        which is then that of every cell."""
        self.examined = True
        possible_cells = np.flatnonzero(self.possible)
        reasons = {
            result if isinstance(result, str) else ""
            for k in (0, possible_cells.size // 2, -1)
            for _, result in task(possible_cells[[k]])
        }
        if len(reasons) == 1 and (reason := reasons.pop()):
            raise InputError(reason)

    def _count(self, cells: Cells) -> None:
        tally = self.tally
        failed = int((self.fields["outcome"].values[cells] != Outcome.OK).sum()) if self.fields else 0
        chaotic = tally.chaotic
        if "regime" in self.fields:
            chaotic = (chaotic or 0) + int((self.fields["regime"].values[cells] == Regime.CHAOTIC).sum())
        computed = tally.computed + cells.size
        self.tally = replace(tally, computed=computed, failed=tally.failed + failed, chaotic=chaotic)

    def flush(self) -> None:
        """Writes the cells to the store that are not there yet."""
        begun = time.monotonic()
        if self._store is not None and self._unwritten:
            self._store.write(self.fields, np.concatenate(self._unwritten))
        pause = (time.monotonic() - begun) / FLUSH_SHARE
        self._unwritten = []
        self._write_at = time.monotonic() + min(max(pause, FLUSH_SECONDS), LONGEST_FLUSH_SECONDS)

    @contextmanager
    def flushed_at_the_end(self) -> Iterator[None]:
        """Flushes at the end of the context, also after an interrupt."""
        try:
            yield
        finally:
            self.flush()

    def infer(self, refined: Refined) -> None:
        """Copies to the cells that were not computed the values of their sources."""
        inferred = np.flatnonzero(~self.computed)
        for field in self.fields.values():
            field.values[inferred] = field.values[refined.sources[inferred]]
        self.fields["status"].values[inferred] = Status.INFERRED
        # draws have no order, and so no border between them
        kinds = self.kinds(np.arange(self.plan.size)).reshape(self.plan.shape)
        border = None if self.plan.draws else border_dimension(kinds)
        checked, missed = refined.checked, refined.missed
        self.tally = replace(self.tally, inferred=inferred.size, checked=checked, missed=missed, border=border)
        self._unwritten.append(inferred)

    def kinds(self, cells: Cells) -> Kinds:
        """A number for the kind of each cell; 0 for an analysis without kinds."""
        kinds = np.zeros(cells.size, dtype=np.int64)
        for name in self._kinds if self.fields else ():
            kinds = (LARGEST_KIND + 2) * kinds + self.fields[name].values[cells].astype(np.int64) + 1
        return kinds
