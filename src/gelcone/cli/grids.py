"""`gelcone map`, `gelcone sweep` and `gelcone show`: many cells, and the stores that keep them."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import click
from click.core import ParameterSource

from gelcone.analyses.answer import check_folder
from gelcone.analyses.ask import answer_to, answers_of, read_options
from gelcone.analyses.draws import read_draws, read_samples, table_among
from gelcone.analyses.lab import lab_answer
from gelcone.analyses.request import Subject
from gelcone.analyses.swept import example
from gelcone.atlas.maps import ALSO, TITLE, with_quantity
from gelcone.atlas.plan import Plan
from gelcone.atlas.record import show, stored_sweep
from gelcone.atlas.sweep import check_sweepable, sweep
from gelcone.cli.lists import print_device
from gelcone.cli.options import (
    OUTPUT,
    PLACE,
    help_of,
    option_parameters,
    output_parameters,
    over_parameter,
    samples_parameter,
    subject_of,
    subject_parameters,
    take_how_drawn,
    uncertain_parameters,
)
from gelcone.cli.output import deliver, say, tally_shown
from gelcone.dataset import load
from gelcone.devices.analysis import check_one, device_words, plain, state_of
from gelcone.errors import InputError
from gelcone.plots import plot
from gelcone.plots.map import COLOURS
from gelcone.register.analyses import find_analysis, sweepable
from gelcone.register.analysis import Analysis, Option

if TYPE_CHECKING:
    from gelcone.atlas.workers import Workers

MAP, SWEEP, SHOW = (find_analysis(name) for name in ("map", "sweep", "show"))
COARSEST = 64
_RUN = ("store", "resume", "threads", "workers", "scheduler")
"""Arguments that say how a sweep is run, not which."""


class Sweep(NamedTuple):
    """A sweep to run, and what it is about."""

    subject: Subject
    plan: Plan
    analysis: str
    coarsest: int | None
    keep: tuple[str, ...]


def store_parameters(alone: str = "") -> list[click.Parameter]:
    """--store and --resume; ``alone`` says what the latter does without other arguments."""
    return [
        click.Option(
            ["--store"],
            type=PLACE,
            metavar="STORE",
            help="Keep results in a new store while they come (Zarr); an interrupted run can be resumed.",
        ),
        click.Option(
            ["--resume"], type=PLACE, metavar="STORE", help=f"Continue with what a store of the same run holds{alone}."
        ),
    ]


def run_parameters() -> list[click.Parameter]:
    """--store, --resume, --threads, --workers and --scheduler."""
    return [
        *store_parameters("; without other arguments its own plan is taken"),
        click.Option(["--threads"], type=int, metavar="N", help="Use N threads of this process."),
        click.Option(
            ["--workers"],
            type=int,
            metavar="N",
            help="Use N processes. [default: one a core for 1,024 cells or more, else threads]",
        ),
        click.Option(
            ["--scheduler"],
            metavar="ADDRESS|FILE",
            help="Use the dask cluster of a scheduler, or of its scheduler file.",
        ),
    ]


def sweep_options() -> list[Option]:
    """The options of all analyses that can be swept, each with the analyses that take it."""
    takers: dict[str, tuple[Option, list[str]]] = {}
    for analysis in sweepable().values():
        for name, option in analysis.options.items():
            takers.setdefault(name, (option, []))[1].append(analysis.name)
    takers.pop("threads")
    return [replace(option, help=f"{option.help} Of {', '.join(names)}.") for option, names in takers.values()]


def map_command() -> click.Command:
    """`gelcone map`."""
    params = [
        *subject_parameters(),
        *over_parameter(MAP),
        click.Option(
            ["--coarsest"],
            type=int,
            default=COARSEST,
            show_default=True,
            help="Points along each axis that are computed at least; the map is refined where it changes between them.",
        ),
        click.Option(["--uniform"], is_flag=True, help="Compute every cell."),
        click.Option(
            ["--colour"],
            type=click.Choice(COLOURS),
            default="exponent",
            show_default=True,
            help="What the picture next to the regimes shows: the largest exponent, the stroke, the power of the "
            "source, or the margin to pull-in at a constant voltage.",
        ),
        *option_parameters(option for name, option in find_analysis("regime").options.items() if name != "threads"),
        *run_parameters(),
        *output_parameters(),
    ]
    return click.Command("map", params=params, callback=run_map, help=help_of(MAP))


def run_map(
    *, over: tuple[str, ...], coarsest: int, uniform: bool, colour: str, resume: Path | None, **typed: Any
) -> int:
    """Reads the map, or takes that of a store, and runs it."""
    output, how = _take(typed, OUTPUT), _take(typed, _RUN)
    kept, workers = one_store(how["store"], resume), read_workers(how)
    if resume is not None and from_store(resume, bool(over)):
        wanted = stored(resume)
        if wanted.analysis != "regime" or len(wanted.plan.dims) != 2 or wanted.plan.draws:
            raise InputError(f"{resume}: holds a sweep that is not a map; use `gelcone sweep --resume {resume}`")
    else:
        subject = subject_of(typed)
        check_one(subject.model, "map")
        swept = subject.over(over)
        if len(swept) != 2:
            remedies = {
                0: f"for example {_two_axes(subject)}",
                1: "for one, use `gelcone bifurcation`",
            }
            remedy = remedies.get(len(swept), "fix the others with --set, or use `gelcone sweep`")
            raise InputError(f"--over: a map takes two parameters, not {len(swept)}; {remedy}")
        plan = _plan(find_analysis("regime"), subject, swept, {}, _given(typed))
        plan.check_order("a map")
        wanted = Sweep(subject, plan, "regime", None if uniform else coarsest, ())
    drawn = output | {"draw": partial(plot, colour=colour)}
    return run(MAP, wanted, kept, resume is not None, workers, drawn, also=colour if colour in ALSO else None)


def sweep_command() -> click.Command:
    """`gelcone sweep`."""
    params = [
        *subject_parameters(),
        *over_parameter(SWEEP),
        *uncertain_parameters(),
        samples_parameter(),
        click.Option(
            ["--indices/--no-indices"],
            default=True,
            help="Two or more parameters: with Sobol indices, half of the draws again for each. [default: indices]",
        ),
        click.Option(
            ["--analysis"],
            default="regime",
            show_default=True,
            help=f"What is computed in every cell: {', '.join(sweepable())}.",
        ),
        click.Option(
            ["--keep"],
            multiple=True,
            metavar="VARIABLE",
            help="Keep a variable with many values a cell, such as the section of regime; may be repeated.",
        ),
        *option_parameters(sweep_options()),
        *run_parameters(),
        *output_parameters(),
    ]
    return click.Command("sweep", params=params, callback=run_sweep, help=help_of(SWEEP))


def run_sweep(
    *,
    over: tuple[str, ...],
    uncertain: tuple[str, ...],
    samples: Path | None,
    indices: bool,
    analysis: str,
    keep: tuple[str, ...],
    resume: Path | None,
    **typed: Any,
) -> int:
    """Reads the sweep, or takes that of a store, and runs it."""
    output, how = _take(typed, OUTPUT), _take(typed, _RUN)
    kept, workers = one_store(how["store"], resume), read_workers(how)
    if resume is not None and from_store(resume, bool(over or uncertain or samples)):
        sweep = stored(resume)
    else:
        subject = subject_of(typed)
        check_one(subject.model, "sweep")
        analysis_entry = find_analysis(analysis.replace("-", "_"))
        drawn = take_how_drawn(typed, samples or table_among(uncertain))
        if samples is not None:
            draws = read_samples(samples, uncertain, subject)
        else:
            draws = read_draws(uncertain, subject, indices=indices and analysis_entry.name == "regime", **drawn)
        if not (over or draws):
            axis_example = example(subject.device, "voltage" if subject.device is None else "frequency")
            raise InputError(f"--over: is not given; give what is swept, such as {axis_example}, or --uncertain")
        plan = _plan(analysis_entry, subject, subject.over(over), draws, _given(typed))
        sweep = Sweep(subject, plan, analysis_entry.name, None, keep)
    return run(SWEEP, sweep, kept, resume is not None, workers, output)


def run(
    command: Analysis,
    wanted: Sweep,
    store: Path | None,
    resume: bool,
    workers: Workers | None,
    output: dict[str, Any],
    also: str | None = None,
) -> int:
    """Runs a sweep and delivers its result."""
    subject, plan, analysis, coarsest, keep = wanted
    with device_words(subject.device):
        check_sweepable(find_analysis(analysis), plan, coarsest, keep)
    check_folder(output["out"], command.command, output["force"])
    with tally_shown(command.command) as watch, device_words(subject.device):
        result = plain(sweep)(
            plan,
            analysis,
            coarsest=coarsest,
            keep=keep,
            store=store,
            resume=resume,
            workers=workers,
            watch=watch,
        )
        if command is MAP:
            result = with_quantity(result, plan, also, workers=workers, watch=watch).assign_attrs(title=TITLE)
    return deliver(answers_of(command), result, subject, **output)


def show_command() -> click.Command:
    """`gelcone show`."""
    place = click.Argument(["place"], type=PLACE, metavar="STORE|FILE.nc|FILE.toml")
    text = (
        "What a file or a store holds: a result that --out wrote, in the words of its command; a device; the cells of "
        "a map or sweep, also while it runs.\n\n\b\ngelcone show results/simulate.nc\n"
        "gelcone show map.zarr --out results"
    )
    return click.Command("show", params=[place, *output_parameters()], callback=run_show, help=text)


def run_show(*, place: Path, out: Path | None, force: bool, as_json: bool) -> int:
    """Reads a file or a store and delivers what it holds."""
    if place.suffix == ".toml":
        if out is not None:
            raise InputError(f"--out {out}: a device has no figure; leave it out")
        print_device("show", str(place), as_json)
        return 0
    if place.is_dir():
        check_folder(out, SHOW.command, force)
        return deliver(answers_of(SHOW), show(place), stored(place).subject, out, force, as_json)
    result = load(place)
    if (shown := lab_answer(result)) is not None:
        if out is not None:
            raise InputError(f"--out {out}: the command that wrote {place.name} writes its figure, too; leave it out")
        words, content = shown
        say("show", as_json, content(), words())
        return 0
    answers, subject = answer_to(result)
    check_folder(out, answers.command, force)
    return deliver(answers, result, subject, out, force, as_json)


def _plan(
    analysis: Analysis, subject: Subject, over: dict[str, Any], draws: dict[str, Any], typed: dict[str, Any]
) -> Plan:
    """The plan of a sweep; options that the analysis does not have are refused with the plan."""
    options = {**typed, **read_options(analysis, subject, typed, in_si=True)}
    return Plan(subject.target, over, subject.beginning, draws, options)


def _two_axes(subject: Subject) -> str:
    if subject.device is None:
        return "--over voltage=0:2:101 --over prestretch=0.4:2:81"
    return '--over "voltage_amplitude=100 V:800 V:29" --over "frequency=5 Hz:20 Hz:31"'


# --- stores and workers -----------------------------------------------------------------------------------------------


def stored(store: Path) -> Sweep:
    """The sweep that a store was made for."""
    kept_sweep = stored_sweep(store)
    plan = kept_sweep.plan
    initial = plan.initial if plan.device is None else state_of(plan.device, plan.initial)
    subject = Subject(plan.cone, plan.device, initial, plan.initial)
    return Sweep(subject, plan, kept_sweep.analysis, kept_sweep.coarsest, kept_sweep.keep)


def from_store(resume: Path, given: bool) -> bool:
    """Whether the sweep is the store's own, as the command line describes none; `InputError` for a part of one."""
    context = click.get_current_context()
    typed = {name for name in context.params if context.get_parameter_source(name) != ParameterSource.DEFAULT}
    if typed <= {*_RUN, *OUTPUT}:
        return True
    if not given:
        raise InputError(
            f"--resume {resume}: give it alone, and the store's sweep is taken, or with all of the sweep "
            "(device, --set, --over), and it is compared"
        )
    return False


def one_store(store: Path | None, resume: Path | None) -> Path | None:
    """The folder that keeps the results, if any."""
    if store is not None and resume is not None:
        raise InputError("--store and --resume: give one of them; --store begins, --resume continues")
    return store or resume


def read_workers(how: dict[str, Any]) -> Workers | None:
    """Who computes, if that is said."""
    from gelcone.atlas.cluster import cluster
    from gelcone.atlas.workers import threads

    chosen = {name: how[name] for name in ("threads", "workers", "scheduler") if how[name] is not None}
    if len(chosen) > 1:
        raise InputError("--threads, --workers and --scheduler: give one of them")
    if not chosen:
        return None
    if "threads" in chosen:
        return threads(how["threads"])
    return cluster(how["workers"], how["scheduler"])


def _take(typed: dict[str, Any], names: tuple[str, ...]) -> dict[str, Any]:
    return {name: typed.pop(name) for name in names if name in typed}


def _given(typed: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in typed.items() if value is not None}
