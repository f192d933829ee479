"""Sweeps of any size: an analysis in every cell of a plan, by any workers, kept in a store while it runs.

The grid's cells are computed all of them, or level by level with `gelcone.atlas.refinement`; what is not computed takes
its values from a computed cell nearby. Cells go to the workers in tasks of about a second.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gelcone.atlas.analyses import compute, find_analysis
from gelcone.atlas.plan import Plan
from gelcone.atlas.record import Tally, coordinates, device_record, label, plan_record
from gelcone.atlas.refinement import Cells, Kinds, Refined, border_dimension, refine
from gelcone.atlas.store import STATUS_ATTRIBUTES, Field, Status, Store, fill_of, open_store
from gelcone.atlas.workers import Team, Workers, threads
from gelcone.codes import Outcome, Regime
from gelcone.errors import InputError
from gelcone.motion.heyoka import LANES
from gelcone.motion.settle import start_states
from gelcone.progress import Stopped

if TYPE_CHECKING:
    import xarray as xr

    from gelcone.devices.device import Device

TASK_CELLS = 64
"""Cells of a task at most: some seconds of work, many lanes of the integrator."""
FEWEST_CELLS = 16
"""Cells of a task, where there are as many: with fewer the lanes stay empty, and a cell costs a quarter more."""
FLUSH_SECONDS, LONGEST_FLUSH_SECONDS = 2.0, 10.0
"""What is done goes to the store so often: as a large map's writing takes longer, less often."""
FLUSH_SHARE = 0.05
"""Share of the time that writing takes, within these bounds."""
REFINABLE = ("regime", "section")
"""Analyses whose cells have a kind, so that a map of them can be refined where it changes."""
_EVIDENCE = ("regime", "sign")


Progress = Callable[[Tally], None]


def survey(
    plan: Plan,
    analysis: str = "regime",
    *,
    coarsest: int | None = None,
    store: str | Path | None = None,
    resume: bool = False,
    device: Device | None = None,
    workers: Workers | None = None,
    progress: Progress = lambda tally: None,
) -> xr.Dataset:
    """An analysis in every cell of a plan.

    Parameters
    ----------
    plan : which parameters are swept over which values, and which are drawn.
    analysis : one of `gelcone.atlas.analyses.ANALYSES`. Default ``"regime"``.
    coarsest : computes only a lattice of at least so many points along each axis, and what is needed to follow every
        change of regime, or of the exponent's sign, down to the finest cell. Default: all cells are computed.
    store : folder that takes the results while they come, as a Zarr group.
    resume : goes on with what the store holds, whose plan must be the same.
    device : what the plan's model comes from; the store keeps it, so that what it holds can be shown in SI units.
    workers : who computes: `gelcone.atlas.workers.threads` (default, one a core) or ``cluster``.
    progress : called with a `Tally` after each task.

    Returns
    -------
    Dataset over the plan's axes with the variables of the analysis, ``status`` (of `Status`) and ``source``, the
    flattened index of the cell whose values a cell carries: its own where it was computed. ``attrs["totals"]`` holds
    the `Tally`.

    Raises
    ------
    InputError : for an unknown analysis, one that cannot be refined, no cell inside its stretch limit, and what
        `gelcone.atlas.store.open_store` refuses.
    """
    find_analysis(analysis)
    if coarsest is not None and (analysis not in REFINABLE or plan.draws):
        what = "draws of uncertain parameters" if plan.draws else f"the analysis {analysis}"
        raise InputError(f"coarsest = {coarsest}: {what} cannot be refined; compute every cell")
    start_states(*plan.at(plan.grid))
    cells = _Cells(plan)
    with ExitStack() as stack:
        if store is not None:
            record, about = plan_record(plan, analysis, coarsest), device_record(device)
            cells.keep_in(
                stack.enter_context(open_store(Path(store), record, plan.dims, plan.shape, about=about, resume=resume))
            )
        team = stack.enter_context((workers or threads())())
        begun = time.monotonic()

        def timed(tally: Tally) -> None:
            progress(replace(tally, seconds=time.monotonic() - begun))

        stack.enter_context(cells.flushed_at_the_end())
        wanted = refine(plan.shape, coarsest) if coarsest is not None else _all(plan.size)
        refined = _follow(wanted, partial(_work, cells, team, analysis, timed))
        cells.infer(refined)
        totals = replace(cells.tally, seconds=time.monotonic() - begun)
        progress(totals)
    return label(plan, cells.fields, refined.sources, totals, f"sweep: {analysis}")


def _all(size: int) -> Generator[Cells, Kinds, Refined]:
    """Asks for every cell."""
    yield np.arange(size)
    return Refined(np.arange(size))


def _follow(wanted: Generator[Cells, Kinds, Refined], answer: Callable[[Cells], Kinds]) -> Refined:
    """Answers what is asked for until nothing more is; what the asking comes to."""
    try:
        asked = next(wanted)
        while True:
            asked = wanted.send(answer(asked))
    except StopIteration as ended:
        refined: Refined = ended.value
        return refined


def _work(cells: _Cells, team: Team, analysis: str, progress: Progress, asked: Cells) -> Kinds:
    """Has those of the cells computed that are not there yet; the kinds of all."""
    cells.ask(asked)
    tasks = _tasks(asked[~cells.computed[asked]], team.size)
    for parts, steps in team.run(partial(_task, cells.plan, analysis), tasks):
        cells.take(parts, steps)
        progress(cells.tally)
    if not cells.fields:
        raise InputError("the analysis raises an error in every cell; run one of them alone to see it")
    return cells.kinds(asked)


def _tasks(cells: Cells, team: int) -> Iterator[Cells]:
    """Cuts cells into tasks, the smaller the fewer cells are left, so that no worker is busy long after the others."""
    first = 0
    while first < cells.size:
        share = (cells.size - first) // (2 * team) // LANES * LANES
        last = first + min(max(share, FEWEST_CELLS), TASK_CELLS)
        yield cells[first:last]
        first = last


def _task(plan: Plan, analysis: str, cells: Cells) -> list[tuple[Cells, xr.Dataset | None]]:
    """Computes some cells. Where that raises an error they are tried one by one; those that raise it have no result."""
    try:
        return [(cells, compute(plan, analysis, cells))]
    except (Stopped, InputError, MemoryError):
        raise
    except Exception:
        if cells.size == 1:
            return [(cells, None)]
    return [part for cell in np.split(cells, cells.size) for part in _task(plan, analysis, cell)]


class _Cells:
    """What is known of the cells of a plan, in memory and - with a store - on disk."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.fields: dict[str, Field] = {}
        self.computed = np.zeros(plan.size, dtype=bool)
        self.tally = Tally(plan.size)
        self._store: Store | None = None
        self._untaken: list[tuple[Cells, xr.Dataset | None]] = []
        self._unwritten: list[Cells] = []
        self._write_at = time.monotonic() + FLUSH_SECONDS

    def keep_in(self, store: Store) -> None:
        """Takes over what a store holds, and keeps there what comes."""
        self._store, self.fields = store, store.read()
        if self.fields:
            self.computed = self.fields["status"].values == Status.COMPUTED

    def ask(self, cells: Cells) -> None:
        """Counts cells as asked for."""
        found = int(self.computed[cells].sum())
        tally = self.tally
        self.tally = replace(tally, asked=tally.asked + cells.size, found=tally.found + found)
        self._count(cells[self.computed[cells]])

    def take(self, parts: list[tuple[Cells, xr.Dataset | None]], steps: int) -> None:
        """Puts the results of a task in their places; cells without one carry that in their outcome."""
        self.tally = replace(self.tally, steps=self.tally.steps + steps)
        known = [result for _, result in parts if result is not None]
        if not self.fields and known:
            self._begin(known[0])
        self._untaken += parts
        if not self.fields:
            return
        for cells, result in self._untaken:
            self.fields["outcome"].values[cells] = Outcome.ERROR
            for name, variable in result.data_vars.items() if result is not None else ():
                self.fields[str(name)].values[cells] = variable.values
            self.fields["status"].values[cells] = Status.COMPUTED
            self.computed[cells] = True
            self._count(cells)
            self._unwritten.append(cells)
        self._untaken = []
        if time.monotonic() > self._write_at:
            self.flush()

    def _count(self, cells: Cells) -> None:
        tally = self.tally
        failed = int((self.fields["outcome"].values[cells] != Outcome.OK).sum()) if self.fields else 0
        chaotic = int((self.fields["regime"].values[cells] == Regime.CHAOTIC).sum()) if "regime" in self.fields else 0
        self.tally = replace(
            tally,
            computed=tally.computed + cells.size,
            failed=tally.failed + failed,
            chaotic=tally.chaotic + chaotic,
        )

    def _begin(self, result: xr.Dataset) -> None:
        size = self.plan.size
        for name, variable in result.data_vars.items():
            values = np.full((size, *variable.shape[1:]), fill_of(variable.dtype), dtype=variable.dtype)
            self.fields[str(name)] = Field(tuple(map(str, variable.dims[1:])), values, dict(variable.attrs))
        self.fields["status"] = Field((), np.zeros(size, dtype=np.uint8), STATUS_ATTRIBUTES)
        if self._store is not None:
            self._store.begin(self.fields, coordinates(self.plan))

    def flush(self) -> None:
        """Brings the store up to date."""
        begun = time.monotonic()
        if self._store is not None and self._unwritten:
            self._store.write(self.fields, np.concatenate(self._unwritten))
        pause = (time.monotonic() - begun) / FLUSH_SHARE
        self._unwritten = []
        self._write_at = time.monotonic() + min(max(pause, FLUSH_SECONDS), LONGEST_FLUSH_SECONDS)

    @contextmanager
    def flushed_at_the_end(self) -> Iterator[None]:
        """Writes what is done also when the work is interrupted."""
        try:
            yield
        finally:
            self.flush()

    def infer(self, refined: Refined) -> None:
        """Gives the cells that were not computed the values of those they were inferred from."""
        inferred = np.flatnonzero(~self.computed)
        for field in self.fields.values():
            field.values[inferred] = field.values[refined.sources[inferred]]
        self.fields["status"].values[inferred] = Status.INFERRED
        border = border_dimension(self.kinds(np.arange(self.plan.size)).reshape(self.plan.shape))
        checked, missed = refined.checked, refined.missed
        self.tally = replace(self.tally, inferred=inferred.size, checked=checked, missed=missed, border=border)
        self._unwritten.append(inferred)

    def kinds(self, cells: Cells) -> Kinds:
        """A number for each kind that cells are told apart by; 0 for an analysis without kinds."""
        if not all(name in self.fields for name in _EVIDENCE):
            return np.zeros(cells.size, dtype=np.int64)
        regime, sign = (self.fields[name].values[cells].astype(np.int64) for name in _EVIDENCE)
        return 3 * regime + sign + 1
