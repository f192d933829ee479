"""Every command in README, guides and help is taken as it stands: read up to where the computation would begin."""

import re
import shlex
import shutil
from pathlib import Path

import click
import pytest
import xarray as xr

import gelcone
from gelcone.cli import COMMANDS, group
from gelcone.lab.wish import FIRST_WISH
from gelcone.motion.driven import DRIVEN_LIMITS
from gelcone.motion.static_limits import STATIC_LIMITS
from gelcone.register.analyses import ANALYSES

ROOT = Path(__file__).parents[1]
PAGES = sorted([ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "ARCHITECTURE.md", *(ROOT / "docs").rglob("*.md")])
PLACEHOLDER = re.compile(r"\b[A-Z]{3,}\b|\.\.\.|\[|<|\|")


def in_blocks(text):
    """The commands of a page's blocks of shell lines, those that run over several lines joined."""
    for block in re.findall(r"```sh\n(.*?)```", text, flags=re.DOTALL):
        for line in block.replace("\\\n", " ").splitlines():
            if line.strip().startswith("gelcone "):
                yield re.sub(r"\s+#.*$", "", line.strip())


def in_lines(text):
    """The commands among the words of a page or of a help text, without those that stand for many."""
    for code in re.findall(r"`(gelcone [^`]+)`", " ".join(text.split())):
        named = re.fullmatch(r"gelcone [\w-]+( --[\w-]+)?", code)  # a command or option by its name
        if not named and not PLACEHOLDER.search(re.sub(r'"[^"]*"', "", code)):
            yield code


def of_help(name):
    """The examples of a command's help, a line each."""
    command = group.get_command(click.Context(group), name)
    for line in (command.help or "").splitlines():
        if line.strip().startswith("gelcone "):
            yield line.strip()
    yield from in_lines((command.help or "").replace("\b", ""))


def written():
    """(where, command) of all."""
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        for command in dict.fromkeys([*in_blocks(text), *in_lines(re.sub(r"```.*?```", "", text, flags=re.DOTALL))]):
            yield page.name, command
    for name in COMMANDS:
        for command in dict.fromkeys(of_help(name)):
            yield f"help {name}", command


WRITTEN = list(dict.fromkeys(written()))


class Begun(Exception):
    """The computation would begin here."""


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """A folder with what commands of the guides refer to: results, stores and devices by the names they have there."""
    folder = tmp_path_factory.mktemp("docs")
    pump = gelcone.find_device("biased-pump")
    for name in ("mine.toml", "my-device.toml"):
        gelcone.save(pump, folder / name)
    for path in (ROOT / "docs" / "measured").glob("*/*.*"):
        shutil.copy(path, folder / path.name)
    shutil.copy(folder / "pump-tests.toml", folder / "mine-tests.toml")
    (folder / "tension.csv").write_text("stretch,stress (kPa)\n1,0\n1.1,5\n1.2,9\n1.3,12\n")
    (folder / "relaxation.csv").write_text("time (s),stretch,stress (kPa)\n1,2,9\n2,2,8\n3,2,7\n4,2,7\n")
    (folder / "recorded.csv").write_text("time (s), voltage (V)\n0, 0\n0.2, 700\n0.5, 0\n")
    (folder / "wish.toml").write_text(FIRST_WISH.format(file="wish.toml"))
    (folder / "designs").mkdir()
    gelcone.save(pump, folder / "designs" / "design-1.toml")
    (folder / "fitted").mkdir()
    gelcone.save(pump, folder / "fitted" / "device.toml")
    draws = xr.Dataset({"spring_rate": ("draw", [14.0, 15.0, 16.0], {"units": "N/m"})})
    gelcone.save(draws, folder / "fitted" / "draws.nc")
    shutil.copytree(ROOT / "docs" / "measured", folder / "docs" / "measured")
    (folder / "results").mkdir()
    gelcone.save(gelcone.simulate(pump, times=[0.0, 1e-3]), folder / "results" / "simulate.nc")
    grid = gelcone.Plan(gelcone.ConeModel(), {"voltage": [0.5, 1.0], "drive_frequency": [0.1, 0.2]})
    found = gelcone.sweep(grid, "limits")
    for name in ("map.nc", "tongues.nc", "results/map.nc"):
        gelcone.save(found, folder / name)
    for name in ("map.zarr", "fast.zarr"):
        gelcone.sweep(grid, "regime", store=folder / name)
    return folder


@pytest.fixture
def dry(monkeypatch, prepared):
    """Nothing is computed, written or served."""

    def begin(*_, **__):
        raise Begun

    for place in (
        "gelcone.cli.command.plain",
        "gelcone.cli.grids.deliver",
        "gelcone.cli.export.export",
        "gelcone.paper.run.run",
        "gelcone.cli.studio.start",
        "gelcone.lab.material.fit_material",
        "gelcone.lab.device.fit_device",
        "gelcone.lab.device.plan_device",
        "gelcone.lab.design.design",
        "gelcone.lab.page.compare_measured",
    ):
        monkeypatch.setattr(place, begin)
    for place in ("cli.command", "cli.grids"):  # results of a name may be there
        monkeypatch.setattr(f"gelcone.{place}.check_folder", lambda *_: None)
    monkeypatch.setattr("gelcone.cli.output.check_writable", lambda *_, **__: None)
    monkeypatch.setattr("gelcone.cli.grids.plain", lambda call: begin)
    monkeypatch.setattr("gelcone.files.write_whole", begin)
    monkeypatch.chdir(prepared)


def refused(arguments):
    """Why a command is refused; empty where its computation would begin, or where it has only to print something."""
    try:
        group.main(arguments, prog_name="gelcone", standalone_mode=False)
    except Begun:
        return ""
    except (gelcone.InputError, click.ClickException) as error:
        return str(getattr(error, "message", error))
    return ""


@pytest.mark.parametrize(("where", "command"), WRITTEN, ids=lambda text: text[:70])
@pytest.mark.usefixtures("dry")
def test_a_command_is_taken_as_it_stands(where, command, monkeypatch, tmp_path):
    _, *arguments = shlex.split(command.rstrip("&").strip())
    if arguments[0] == "init":
        monkeypatch.chdir(tmp_path)
    assert refused(arguments) == "", f"{where}: {command}"


@pytest.mark.usefixtures("dry")
def test_what_is_refused_is_seen():
    assert "not a device field" in refused(["settled", "biased-pump", "--set", "drive_frequency=6 Hz"])
    assert refused(["sweep", "biased-pump", "--over", "no_such=1:2:3"])
    assert refused(["no-such-command"])


def test_every_page_and_every_analysis_has_commands():
    assert {"README.md", "maps.md", "branches.md", "continuum.md"} <= {where for where, _ in WRITTEN}
    told = {where for where, _ in WRITTEN}
    assert {f"help {analysis.command}" for analysis in ANALYSES.values()} <= told
    assert len(WRITTEN) > 80


# --- what commands print ----------------------------------------------------------------------------------------------

PRINTED = [
    (page, commands, output)
    for page in PAGES
    for commands, output in re.findall(
        r"```sh\n([^`]*)```\n\n```\n([^`]*)```", page.read_text(encoding="utf-8"), flags=re.DOTALL
    )
]
TIMED = re.compile(r" in [\d.]+ s\b")


@pytest.mark.slow
def test_what_a_page_says_is_printed_is_printed(command_line, undrawn):
    """In the order of the page, for a store of one command is that of the next."""
    for page, commands, output in PRINTED:
        for command in in_blocks(f"```sh\n{commands}```"):
            code, printed, err = command_line(*shlex.split(command)[1:], *(["--force"] if "--out" in command else []))
            assert code == int("failed: " in printed), err  # of a run that ends in pull-in it is 1
        for line in output.splitlines():
            assert TIMED.sub("", line) in TIMED.sub("", printed).splitlines(), f"{page.name}: {line}"


def test_there_are_pages_that_say_what_is_printed():
    assert [page.name for page, _, _ in PRINTED].count("maps.md") == 3


def test_the_limits_that_safe_drive_explains_are_those_that_envelopes_name():
    text = (ROOT / "docs" / "howto" / "safe-drive.md").read_text(encoding="utf-8")
    table = text.partition("| limit | what happens beyond |")[2].partition("\n\n")[0]
    rows = [line.split("|")[1] for line in table.splitlines() if line.startswith("| ")]
    named = {name.strip() for row in rows for name in row.split(",")}
    assert named == {*DRIVEN_LIMITS, *STATIC_LIMITS}
