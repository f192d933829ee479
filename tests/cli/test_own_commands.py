"""Commands that are not one analysis: every option reaches its keyword, and what is not typed the function's default.

A table of commands, options and what is asked; the calls are recorded in place of being made.
"""

import inspect
import threading
from pathlib import Path
from types import SimpleNamespace
from urllib.parse import urlencode

import click
import numpy as np
import pytest

import gelcone
from gelcone.analyses import draws as read
from gelcone.analyses import request
from gelcone.atlas import cluster, sweep, uncertain, workers
from gelcone.cli import OWN_COMMANDS, SPECIAL, command, export, grids, group, lab, output, studio
from gelcone.cli import options as shared
from gelcone.lab import design, device, device_tests, fitted, material, page, wish
from gelcone.lab import measured as coupons
from gelcone.paper import run
from gelcone.register.analyses import ANALYSES

SUBJECT = {"device", "preset", "settings", "initial", "film"}
OUTPUT = {"out", "force", "as_json"}
MAP = ("map", "--over", "voltage=0.9:1.1:3", "--over", "damping_ratio=0.01:0.02:2")
SWEEP = ("sweep", "--over", "voltage=0.9:1.1:3")
FIT = ("fit", "--data", "tension.csv")
PUMP = ("fit", "biased-pump", "--data", "tests.toml")
TIMES = ("transient", "patience", "budget")


class Asked(gelcone.InputError):
    """Ends a command where its function would begin."""


class Calls(list):
    """Calls that were recorded: the name, what was given, and the keywords."""

    def instead_of(self, monkeypatch, home, name, answer=None):
        """Record the calls of a function; the command ends there unless there is an ``answer``."""
        real = inspect.signature(inspect.unwrap(getattr(home, name)))

        def ask(*given, **keywords):
            bound = real.bind(*given, **keywords)
            self.append((name, dict(bound.arguments), real))
            if answer is None:
                raise Asked(name)
            return answer(*given, **keywords)

        monkeypatch.setattr(home, name, ask)


@pytest.fixture
def calls(monkeypatch):
    """What is asked by any of the commands of the table."""
    found = Calls()
    for home, name in (
        (design, "design"), (page, "compare_measured"), (material, "fit_material"), (device, "fit_device"),
        (device, "plan_device"), (run, "run"), (export, "export"), (studio, "start"),
    ):  # fmt: skip
        found.instead_of(monkeypatch, home, name)
    monkeypatch.setattr(read, "read_samples", lambda path, drawn, subject: (str(path), drawn))
    monkeypatch.setattr(coupons, "read_tests", lambda *paths: list(map(str, paths)))
    monkeypatch.setattr(device_tests, "read_device_tests", str)
    monkeypatch.setattr(wish, "read_wish", lambda path: SimpleNamespace(device=gelcone.find_device("paper-table1")))
    monkeypatch.setattr(material, "known_fields_of", lambda path, content: {"subject": str(path)})
    monkeypatch.setattr(grids, "plain", lambda call: getattr(_Sweeping(found), call.__name__))
    monkeypatch.setattr(workers, "threads", lambda count: f"{count} threads")
    monkeypatch.setattr(cluster, "cluster", lambda count=None, scheduler=None: f"{count} of {scheduler}")
    return found


class _Sweeping:
    """`gelcone.sweep` of which the call is recorded, with the plan in parts."""

    def __init__(self, calls):
        self.calls = calls

    def sweep(self, plan, analysis, **keywords):
        options = plan.options
        axes = {name: np.asarray(values).tolist() for name, values in plan.over.items()}
        own = {"over": axes, "draws": plan.draws, "initial": plan.initial, "analysis": analysis, **options}
        self.calls.append(("sweep", own | keywords, inspect.signature(sweep.sweep)))
        raise Asked("sweep")


def typed(option, value):
    return () if value is None else (option, *(value if isinstance(value, tuple) else (value,)))


class Row(list):
    """A command, and (option, what is typed, keyword, what arrives) for each of its options."""

    def __init__(self, base, options, other=()):
        super().__init__(options)
        self.base, self.other = base, set(other)


OF_REGIME = [("--transient", "30", "transient", 30.0), ("--patience", "40", "patience", 40.0)]
OF_REGIME += [("--budget", "50", "budget", 50.0), ("--tolerance", "1e-6", "tolerance", 1e-6)]
HOW = [
    ("--store", "there.zarr", "store", Path("there.zarr")),
    ("--threads", "3", "workers", "3 threads"),
    ("--workers", "4", "workers", "4 of None"),
    ("--scheduler", "tcp://a", "workers", "None of tcp://a"),
]
TABLE = {
    "design": Row(
        ("design", "wish.toml"),
        [
            ("--nominal", (), "nominal", True),
            ("--seed", "5", "seed", 5),
            ("--samples", "draws.nc", "samples", ("draws.nc", ())),
        ],
        OUTPUT,
    ),
    "measured": Row(("measured", "vhb.toml"), [("--seed", "5", "seed", 5)], {"as_json"}),
    "fit": Row(
        FIT,
        [
            ("--laws", "gent, yeoh", "laws", ["gent", "yeoh"]),
            ("--branches", "1, 2", "branches", [1, 2]),
            ("--flow", "linear", "flow", "linear"),
            ("--draws", "7", "draws", 7),
            ("--seed", "5", "seed", 5),
            ("--data", "more.csv", "tests", ["tension.csv", "more.csv"]),
        ],
        {*OUTPUT, "free", "plan", "films", "loss", "profile", "predict"},
    ),
    "fit a device": Row(
        PUMP,
        [
            ("--free", "spring_rate~3%", "free", pytest.approx({"spring_rate": 0.03})),
            ("--films", "taut, wrinkling", "films", ["taut", "wrinkling"]),
            ("--loss", "damper, both", "losses", ["damper", "both"]),
            ("--profile", ("a", "--profile", "b"), "profile", ("a", "b")),
            ("--predict", ("stroke@1 kV", "--next", "pull-in"), "predict", ("stroke@1 kV", "pull-in")),
        ],
        {*OUTPUT, "data", "plan", "laws", "branches", "flow", "draws", "seed"},
    ),
    "plan a device": Row(
        (*PUMP, "--plan"),
        [
            ("--free", "spring_rate~3%", "free", pytest.approx({"spring_rate": 0.03})),
            ("--films", "taut", "film", "taut"),
            ("--loss", "both", "loss", "both"),
            ("--predict", "pull-in", "predict", ("pull-in",)),
        ],
        {*OUTPUT, "data", "plan", "laws", "branches", "flow", "draws", "seed", "profile"},
    ),
    "paper": Row(
        ("paper", "7", "voltage-threshold"),
        [
            ("--quick", (), "quick", True),
            ("--out", "there", "out", Path("there")),
            ("--force", (), "force", True),
        ],
        {"as_json"},
    ),
    "studio": Row(
        ("studio",),
        [
            ("--preset", "fast", "preset", "fast"),
            ("--port", "8123", "port", 8123),
            ("--host", "0.0.0.0", "host", "0.0.0.0"),
            ("--no-browser", (), "no_browser", True),
        ],
    ),
    "export": Row(
        ("export", "paper-table1", "a.fmu"),
        [
            ("--fmi", "3", "fmi", 3),
            ("--platforms", "host, linux", "platforms", ["host", "linux"]),
            ("--drive", "own", "drive", "own"),
            ("--tolerance", "1e-9", "tolerance", 1e-9),
            ("--force", (), "force", True),
        ],
        {"settings", "film"},
    ),
    "map": Row(
        MAP,
        [
            *OF_REGIME, *HOW,
            ("--coarsest", "9", "coarsest", 9),
            ("--uniform", (), "coarsest", None),
            ("--initial", "0.5,0.25", "initial", (0.5, 0.25)),
        ],
        {*SUBJECT, *OUTPUT, "over", "colour", "resume"},
    ),
    "sweep": Row(
        SWEEP,
        [
            *OF_REGIME, *HOW,
            ("--analysis", "settled", "analysis", "settled"),
            ("--keep", "section", "keep", ("section",)),
            ("--initial", "0.5,0.25", "initial", (0.5, 0.25)),
        ],
        {*SUBJECT, *OUTPUT, "over", "resume", "samples", "uncertain", "count", "method", "seed", "indices", "window",
         "precision", "at_once"},
    ),
}  # fmt: skip
"""Command -> its options; others are tested below, or are those of all commands."""
CASES = [(name, *own) for name, row in TABLE.items() for own in row]


def ask(command_line, calls, *given):
    calls.clear()
    code, _, err = command_line(*given)
    assert (code, len(calls)) == (2, 1), f"{given}: {err}"
    return calls[0]


def plain(value):
    return value.tolist() if isinstance(value, np.ndarray) else value


@pytest.mark.parametrize("name", TABLE)
def test_what_is_not_typed_is_the_functions_default(name, command_line, calls):
    _, keywords, real = ask(command_line, calls, *TABLE[name].base)
    usual = {n: p.default for n, p in real.parameters.items() if p.default is not inspect.Parameter.empty}
    fixed = {"progress", "watch", "workers", "names"} if name == "paper" else {"progress", "watch"}
    given = {n: plain(v) for n, v in keywords.items() if n in usual and n not in fixed}
    given.pop("material", None)
    assert given == {n: usual[n] for n in given} | ({"coarsest": grids.COARSEST} if name == "map" else {})
    assert ("progress" in keywords) == ("progress" in real.parameters and name not in ("map", "sweep"))


@pytest.mark.parametrize(("name", "option", "value", "keyword", "arrives"), CASES)
def test_an_option_reaches_its_keyword_and_no_other(name, option, value, keyword, arrives, command_line, calls):
    base = ask(command_line, calls, *TABLE[name].base)[1]
    found = ask(command_line, calls, *TABLE[name].base, *typed(option, value))[1]
    assert found[keyword] == arrives
    assert plain(base.get(keyword)) != arrives, "give another value than the default"
    others = {"progress", "watch", "wish", keyword, "device", "initial", "given"}
    assert {n: v for n, v in found.items() if n not in others} == {n: v for n, v in base.items() if n not in others}


@pytest.mark.parametrize("name", [name for name in TABLE if " " not in name])
def test_the_table_has_every_option(name):
    context = click.Context(group)
    shown = {p.name: p for p in group.get_command(context, name).params if isinstance(p, click.Option)}
    flags = {option for option, *_ in TABLE[name]}
    own = {n for n, p in shown.items() if flags & {*p.opts, *p.secondary_opts}}
    assert set(shown) - own == TABLE[name].other - own - {"device"}


def test_the_defaults_in_the_help_are_those_of_the_functions():
    context = click.Context(group)
    options = {
        name: {p.name: p.default for p in group.get_command(context, name).params}
        for name in ("sweep", "map", "datasheet", "fit", "design", "measured", "export")
    }
    drawn = inspect.signature(uncertain.draw).parameters
    for name in ("sweep", "datasheet"):
        assert {n: options[name][n] for n in ("method", "seed")} == {n: drawn[n].default for n in ("method", "seed")}
        assert options[name]["count"] == 64
    fitted = inspect.signature(gelcone.fit_material).parameters
    assert {n: options["fit"][n] for n in ("flow", "draws", "seed")} == {
        n: fitted[n].default for n in ("flow", "draws", "seed")
    }
    for name in lab.OF_MATERIALS:
        assert lab.OF_MATERIALS[name] == fitted[name].default


# --- draws ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("more", "found"),
    [
        ((), {}),
        (("--count", "8"), {"count": 8}),
        (("--method", "latin-hypercube"), {"method": "latin-hypercube"}),
        (("--seed", "5"), {"seed": 5}),
        (("--no-indices",), {"indices": False}),
        (("--analysis", "settled"), {"indices": False}),
        (("--uncertain", "prestretch=1~0.1"), {"texts": ("damping_ratio=0.1:0.2", "prestretch=1~0.1")}),
    ],
)
def test_draws_are_made_as_was_typed(more, found, command_line, monkeypatch):
    asked = []

    def made(texts, subject, **how):
        asked.append({"texts": texts, **how})
        raise Asked("draws")

    monkeypatch.setattr(grids, "read_draws", made)
    monkeypatch.setattr(command, "read_draws", made)
    usual = {"texts": ("damping_ratio=0.1:0.2",), "count": 64, "method": "sobol", "seed": 0, "indices": True}
    assert command_line(*SWEEP, "--uncertain", "damping_ratio=0.1:0.2", *more)[0] == 2
    assert asked == [usual | found]
    if more[:1] in (("--no-indices",), ("--analysis",)):
        return
    asked.clear()
    assert command_line("datasheet", "--uncertain", "damping_ratio=0.1:0.2", *more)[0] == 2
    assert asked == [usual | found | {"indices": False}]


def test_the_methods_and_seeds_of_draws_reach_the_draw(monkeypatch):
    asked = []
    subject = request.read_subject()
    monkeypatch.setattr(read, "draw", lambda spread, count, **how: asked.append((set(spread), count, how)) or {})
    both = ["prestretch=1~0.1", "damping_ratio=0.1:0.2"]
    for texts, count, wanted, indices in (
        (both, 8, True, True), (both, 8, False, False), (both[:1], 8, True, False), (both, 6, True, False),
        (both, 2, True, False), (both, 4, True, True),
    ):  # fmt: skip
        read.read_draws(texts, subject, count=count, method="latin-hypercube", seed=7, indices=wanted)
        names = {text.partition("=")[0] for text in texts}
        assert asked.pop() == (names, count, {"method": "latin-hypercube", "seed": 7, "indices": indices})


@pytest.mark.parametrize("way", [("--samples", "draws.nc"), ("--uncertain", "damping_ratio=0.1:0.2")])
def test_a_data_sheet_of_draws_is_run_as_was_typed(way, command_line, calls, monkeypatch):
    drawn = (*(("--count", "8", "--seed", "3") if way[0] == "--uncertain" else ()), "--over", "voltage=0.1,0.2")
    calls.instead_of(monkeypatch, command, "_run_draws")
    monkeypatch.setattr(command, "read_samples", lambda path, texts, subject: (path, texts))
    monkeypatch.setattr(command, "read_draws", lambda texts, subject, **how: (texts, how))
    name, found, _ = ask(command_line, calls, "datasheet", *way, *drawn)
    assert (name, found["analysis"]) == ("_run_draws", ANALYSES["datasheet"])
    how = {"count": 8, "method": "sobol", "seed": 3, "indices": False}
    assert found["draws"] == ((Path("draws.nc"), ()) if way[0] == "--samples" else ((way[1],), how))
    assert found["given"] == {"over": ("voltage=0.1,0.2",)}
    assert (found["out"], found["how"]["force"], found["how"]["as_json"]) == (None, False, False)


@pytest.mark.parametrize("how", [("--count", "64"), ("--method", "sobol"), ("--seed", "0")])
@pytest.mark.parametrize("way", [("--samples", "draws.nc"), ("--uncertain", "draws.csv")])
@pytest.mark.parametrize("form", [SWEEP, ("datasheet",)])
def test_how_draws_are_made_is_not_asked_of_a_file_that_holds_them(form, way, how, command_line):
    code, _, err = command_line(*form, *way, *how)
    assert code == 2
    assert err.strip() == f"Error: {how[0]}: says how draws are made, and {way[1]} holds them; leave it out"


def test_the_samples_of_a_sweep_are_read_with_what_else_is_uncertain(command_line, monkeypatch):
    asked = []

    def made(path, texts, subject):
        asked.append((path, texts))
        raise Asked("samples")

    monkeypatch.setattr(grids, "read_samples", made)
    assert command_line(*SWEEP, "--samples", "draws.nc")[0] == 2
    assert command_line(*SWEEP, "--samples", "draws.nc", "--uncertain", "prestretch=1~0.1")[0] == 2
    assert asked == [(Path("draws.nc"), ()), (Path("draws.nc"), ("prestretch=1~0.1",))]


# --- maps, sweeps and stores ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("base", [MAP, SWEEP])
def test_a_sweep_is_resumed_in_its_store_with_its_plan_or_that_of_the_store(base, command_line, calls, monkeypatch):
    kept, resumed = ask(command_line, calls, *base, "--resume", "there.zarr")[1], {"store": Path("there.zarr")}
    assert {n: kept[n] for n in ("store", "resume", "coarsest")} == {
        **resumed, "resume": True, "coarsest": 64 if base is MAP else None,
    }  # fmt: skip
    assert ask(command_line, calls, *base)[1]["resume"] is False
    code, _, err = command_line(*base, "--resume", "a.zarr", "--store", "b.zarr")
    assert code == 2
    assert "--store and --resume: give one of them" in err
    code, _, err = command_line(*base, "--threads", "2", "--workers", "2")
    assert code == 2
    assert "--threads, --workers and --scheduler: give one of them" in err


@pytest.mark.parametrize(
    ("colour", "also"), [("exponent", None), ("stroke", None), ("power", "power"), ("margin", "margin")]
)
def test_the_colour_of_a_map_reaches_its_figure_and_what_is_computed(colour, also, command_line, monkeypatch):
    import xarray as xr

    asked, drawn = [], []
    monkeypatch.setattr(grids, "plain", lambda call: lambda plan, analysis, **how: xr.Dataset())
    monkeypatch.setattr(grids, "with_quantity", lambda result, plan, own, **how: asked.append((own, how)) or result)
    monkeypatch.setattr(grids, "plot", lambda result, **how: drawn.append(how))

    def deliver(answers, result, subject, out, force, as_json, draw):
        assert result.attrs["title"] == "parameter map"
        draw(result)
        return 0

    monkeypatch.setattr(grids, "deliver", deliver)
    assert command_line(*MAP, "--colour", colour)[0] == 0
    ((own, how),) = asked
    assert own == also
    assert how["workers"] is None
    assert drawn == [{"colour": colour}]


@pytest.mark.parametrize("base", [MAP, SWEEP])
def test_a_sweep_is_delivered_as_was_typed(base, command_line, monkeypatch):
    import xarray as xr

    delivered, checked = [], []
    monkeypatch.setattr(grids, "plain", lambda call: lambda plan, analysis, **how: xr.Dataset())
    monkeypatch.setattr(grids, "with_quantity", lambda result, plan, own, **how: result)
    monkeypatch.setattr(grids, "check_folder", lambda *given: checked.append(given))

    def deliver(answers, result, subject, out, force, as_json, **how):
        delivered.append((answers.command, out, force, as_json))
        return 0

    monkeypatch.setattr(grids, "deliver", deliver)
    for more, found in (
        ((), (None, False, False)), (("--out", "there"), (Path("there"), False, False)),
        (("--force",), (None, True, False)), (("--json",), (None, False, True)),
    ):  # fmt: skip
        assert command_line(*base, *more)[0] == 0
        assert delivered.pop() == (base[0], *found)
        assert checked.pop() == (found[0], base[0], found[1])


def test_the_subject_of_every_command_is_read_from_what_was_typed(command_line, monkeypatch):
    asked = []

    def made(device, **how):
        asked.append({"device": device, **how})
        raise Asked("subject")

    monkeypatch.setattr(shared, "read_subject", made)
    monkeypatch.setattr(export, "read_subject", made)
    given = ("soft-film", "--preset", "fast", "--film", "taut", "--initial", "1,2", "--set", "a=1", "--set", "b=2")
    found = {"device": "soft-film", "preset": "fast", "film": "taut", "initial": "1,2", "settings": ("a=1", "b=2")}
    for base in (MAP, SWEEP, ("datasheet",)):
        assert command_line(*base, *given)[0] == 2
        assert asked.pop() == found
    typed_ = ("export", "soft-film", "there", "--film", "taut", "--set", "a=1", "--set", "b=2")
    assert command_line(*typed_)[0] == 2
    assert asked.pop() == {"device": "soft-film", "film": "taut", "settings": ("a=1", "b=2")}


# --- the other commands -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("place", ["pump", "pump.fmu", "there/pump.wasm"])
def test_a_device_is_exported_where_it_was_said(place, command_line, calls):
    found = ask(command_line, calls, "export", "paper-table1", place)[1]
    assert (found["what"].name, found["path"]) == (gelcone.find_device("paper-table1").name, Path(place))


@pytest.mark.parametrize(
    ("more", "path"),
    [
        ((), "there/run.csv"), (("run.mat",), "run.mat"), (("tables/run.parquet",), "tables/run.parquet"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("force", [False, True])
def test_a_result_is_exported_as_was_said(more, path, force, command_line, calls, monkeypatch, tmp_path):
    monkeypatch.setattr(export, "load", lambda place: f"result of {place}")
    found = ask(command_line, calls, "export", "there/run.nc", *more, *(["--force"] if force else []))[1]
    assert found == {"what": "result of there/run.nc", "path": Path(path), "force": force}
    (tmp_path / "there" / "run.nc").mkdir(parents=True)
    monkeypatch.setattr(export, "show", lambda place: f"store {place}")
    assert ask(command_line, calls, "export", "there/run.nc", *more)[1]["what"] == "store there/run.nc"


@pytest.mark.parametrize(
    ("given", "word"),
    [
        (("a.nc", "--film", "taut"), "--film taut: belongs to the export of a device"),
        (("a.nc", "--set", "a=1", "--set", "b=2"), "--set a=1 b=2: belongs to the export of a device"),
    ],
)
def test_options_of_the_other_kind_of_export_are_refused(given, word, command_line, calls):
    code, _, err = command_line("export", *given)
    assert code == 2
    assert not calls
    assert word in err


@pytest.mark.parametrize("option", ["--laws gent", "--branches 1", "--flow linear", "--draws 5", "--seed 3"])
def test_options_of_a_material_are_refused_for_a_device(option, command_line, calls):
    code, _, err = command_line(*PUMP, "--free", "spring_rate~3%", *option.split())
    assert (code, calls) == (2, [])
    assert f"{option.split()[0]}: is an option of the fit of a material" in err


@pytest.mark.parametrize("option", ["--free a", "--plan", "--films taut", "--loss both", "--predict a", "--profile a"])
def test_options_of_a_device_are_refused_for_a_material(option, command_line, calls):
    code, _, err = command_line(*FIT, *option.split())
    assert (code, calls) == (2, [])
    assert f"{option.split()[0]}: is an option of the fit of a device" in err


@pytest.mark.parametrize("option", ["--films taut,wrinkling", "--loss damper,both"])
def test_a_plan_is_that_of_one_structure(option, command_line, calls):
    code, _, err = command_line(*PUMP, "--plan", "--free", "spring_rate~3%", *option.split())
    assert (code, calls) == (2, [])
    assert f"{option.split()[0]}: a plan is that of one structure" in err


def test_subject_and_data_of_a_fit_are_those_that_were_named(command_line, calls, tmp_path):
    (tmp_path / "gel.toml").write_text("[material]\n")
    found = ask(command_line, calls, "fit", "gel.toml", "--data", "a.csv")[1]
    assert (found["tests"], found["material"]) == (["a.csv"], {"subject": "gel.toml"})
    assert ask(command_line, calls, *FIT)[1]["material"] == {}
    name, found, _ = ask(command_line, calls, *PUMP, "--free", "spring_rate~3%")
    assert (name, found["device"].name, found["tests"]) == (
        "fit_device", gelcone.find_device("biased-pump").name, "tests.toml",
    )  # fmt: skip
    assert ask(command_line, calls, *PUMP, "--free", "spring_rate~3%", "--plan")[0] == "plan_device"


def test_names_of_the_paper_and_places_of_pages_are_passed_on(command_line, calls):
    assert ask(command_line, calls, "paper", "7", "limit")[1]["names"] == ("7", "limit")
    assert ask(command_line, calls, "paper")[1]["names"] == ()
    assert ask(command_line, calls, "measured", "a.toml")[1]["path"] == Path("a.toml")
    assert ask(command_line, calls, "studio", "soft-film")[1]["device"] == "soft-film"
    assert ask(command_line, calls, "studio")[1]["device"] is None


@pytest.mark.parametrize(
    ("more", "shown", "host", "port", "opens"),
    [
        ((), {"device": "biased-pump"}, "127.0.0.1", 0, True),
        (("soft-film",), {"device": "soft-film"}, "127.0.0.1", 0, True),
        (("--preset", "fast"), {"preset": "fast"}, "127.0.0.1", 0, True),
        (
            ("--port", "8123", "--host", "localhost", "--no-browser"),
            {"device": "biased-pump"},
            "localhost",
            8123,
            False,
        ),
        (("--host", "0.0.0.0"), {"device": "biased-pump"}, "0.0.0.0", 0, True),
    ],
)
def test_the_studio_listens_where_was_said_and_opens_what_was_named(
    more, shown, host, port, opens, command_line, monkeypatch
):
    import os
    import webbrowser

    from gelcone.studio import server

    heard, opened = {}, threading.Event()

    class Studio:
        def __init__(self, shelf, host):
            heard.update(host=host)

        def listen(self, port):
            heard.update(port=port)
            return "socket"

        def address(self, query):
            return f"http://here/?{query}"

    def serve(own, listening, first, ready):
        heard.update(listening=listening, first={n: v for n, v in vars(first).items() if v})
        ready()
        assert opened.wait(5.0 if opens else 0.05) == opens

    monkeypatch.setattr(server, "Studio", Studio)
    monkeypatch.setattr(server, "run", serve)
    monkeypatch.setattr(webbrowser, "open", lambda address: opened.set())
    monkeypatch.setattr(os, "_exit", lambda code: None)
    code, out, err = command_line("studio", *more)
    assert code == 0, err
    assert heard == {"host": host, "port": port, "listening": "socket", "first": shown}
    assert f"http://here/?{urlencode(shown)}" in out
    assert ("--host 0.0.0.0: whoever can reach this machine" in err) == (host == "0.0.0.0")


@pytest.mark.parametrize(
    ("flags", "title", "then"),
    [((), "film_thickness", "simulate"), (("--wish",), "[free]", "design"), (("--tests",), "[[test]]", "fit")],
)
def test_a_first_file_is_that_of_its_kind(flags, title, then, command_line, tmp_path):
    code, out, err = command_line("init", "mine.toml", *flags)
    assert code == 0, err
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    assert title in text
    assert "gelcone " + then in out
    code, _, err = command_line("init", "mine.toml", *flags)
    assert code == 2
    assert "exists already" in err
    assert command_line("init", "other.toml", "--wish", "--tests")[0] == 2


def test_every_command_of_its_own_is_in_a_table():
    assert {*OWN_COMMANDS, *SPECIAL} - set(TABLE) == {
        "init",
        "help",
        "devices",
        "materials",
        "continue",
        "datasheet",
        "locus",
        "show",
    }


# --- files ------------------------------------------------------------------------------------------------------------


@pytest.fixture
def marked(monkeypatch):
    """Files hold what was to be written there, by its name, in place of it."""
    from gelcone import netcdf
    from gelcone.analyses import design as answers
    from gelcone.analyses import device_fit, material_fit
    from gelcone.plots import style

    for home in (netcdf, output):
        monkeypatch.setattr(home, "write_netcdf", lambda result, to: to.write_text(f"netCDF of {result}"))
    monkeypatch.setattr(style, "draw_file", lambda figure, to: to.write_text(f"picture of {figure}"))
    monkeypatch.setattr(output, "plot", lambda result: f"figure of {result}")
    monkeypatch.setattr(material, "fitted_text", lambda result: f"gel of {result}")
    monkeypatch.setattr(fitted, "fitted_draws", lambda result: f"draws of {result}")
    monkeypatch.setattr(fitted, "fitted_band", lambda result: f"band of {result}")
    monkeypatch.setattr(fitted, "fitted_device", lambda result: SimpleNamespace(to_toml=lambda: f"device of {result}"))
    for home, name in ((material_fit, "fit"), (device_fit, "device_fit"), (answers, "design")):
        monkeypatch.setattr(home, f"{name}_words", lambda *given: "said")
        monkeypatch.setattr(home, f"{name}_json", lambda result: {"of": str(result)})
    monkeypatch.setattr(device_fit, "device_plan_words", lambda *given: "said of a plan")


class Found:
    """A result that was not computed."""

    def __init__(self, name, **attrs):
        self.name, self.attrs, self.sizes = name, attrs, {"design": 2}

    def __str__(self):
        return self.name


FILES = {
    "material": (FIT, {"material.toml": "gel of it", "fit.nc": "netCDF of it", "fit.png": "picture of figure of it"}),
    "device": (
        (*PUMP, "--free", "spring_rate~3%"),
        {
            "fit.nc": "netCDF of it", "fit.png": "picture of figure of it", "device.toml": "device of it",
            "draws.nc": "netCDF of draws of it", "band.csv": "band of it",
        },
    ),
    "plan": (
        (*PUMP, "--free", "spring_rate~3%", "--plan"),
        {"plan.nc": "netCDF of it", "plan.png": "picture of figure of it"},
    ),
    "design": (
        ("design", "wish.toml"),
        {
            "design.nc": "netCDF of it", "design.png": "picture of figure of it", "design-1.toml": "device 0 of it",
            "design-2.toml": "device 1 of it",
        },
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", FILES)
def test_every_file_holds_what_its_name_says(kind, command_line, calls, marked, monkeypatch, tmp_path):
    from gelcone.analyses import design as answers

    typed_, files = FILES[kind]
    found = Found("it", refused=0)
    for home, name in (
        (material, "fit_material"), (device, "fit_device"), (device, "plan_device"), (design, "design"),
    ):  # fmt: skip
        monkeypatch.setattr(home, name, lambda *given, **how: found)
    monkeypatch.setattr(answers, "device_text", lambda result, k: f"device {k} of {result}")
    code, out, err = command_line(*typed_, "--out", "made")
    assert code == 0, err
    assert {path.name: path.read_text() for path in (tmp_path / "made").iterdir()} == files
    first, *lines = out.splitlines()
    assert first == ("said of a plan" if kind == "plan" else "said")
    assert lines == [f"wrote {Path('made') / name}" for name in files]
    assert command_line(*typed_, "--out", "made")[0] == 2
    code, out, _ = command_line(*typed_, "--out", "made", "--force", "--json")
    assert code == 0
    assert '"result": {"of": "it"}' in out
    assert "wrote" not in out
    if kind == "device":
        found.attrs["refused"] = 1
        assert command_line(*typed_)[0] == 1
    code, out, _ = command_line(*typed_)
    assert "wrote" not in out


def test_an_analysis_of_a_sweep_has_the_name_of_its_command_or_that_in_python(command_line, calls):
    for name in ("operating-limits", "operating_limits"):
        assert ask(command_line, calls, *SWEEP, "--analysis", name)[1]["analysis"] == "operating_limits"
