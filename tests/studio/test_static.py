"""The page's own modules, under the test runner of node: what computes, and what is drawn on a canvas that records."""

import json
import re
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest

from gelcone.codes import Regime
from gelcone.studio import asked, grids, look, setting
from gelcone.studio.server import KINDS

TESTS = Path(__file__).parent / "static"
STATIC = Path(setting.__file__).parent / "static"
NODE = shutil.which("node")
TSC = shutil.which("tsc")
OLDEST = 20


@cache
def version():
    printed = subprocess.run([NODE, "--version"], capture_output=True, text=True, check=True).stdout
    return int(printed.removeprefix("v").partition(".")[0])


@pytest.mark.skipif(NODE is None, reason="no node on this machine (Debian: nodejs), which runs the page's modules")
@pytest.mark.parametrize("path", sorted(TESTS.glob("*.test.js")), ids=lambda path: path.name.partition(".")[0])
def test_modules(path):
    if version() < OLDEST:
        pytest.skip(f"node is older than {OLDEST} and has no test runner")
    done = subprocess.run([NODE, path], capture_output=True, text=True, cwd=TESTS.parents[2], timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    assert int(re.search(r"^. pass (\d+)", done.stdout, re.MULTILINE)[1]) > 0


@pytest.mark.skipif(TSC is None, reason="no tsc on this machine (npm install --global typescript), which checks types")
@pytest.mark.parametrize("fault", ["", "export const wrong = /** @type {string} */ (extent([1])[2].name);"])
def test_types_in_comments_hold(tmp_path, fault):
    static, config = tmp_path / "static", json.loads((TESTS / "tsconfig.json").read_text(encoding="utf-8"))
    shutil.copytree(STATIC, static)
    with (static / "plot.js").open("a", encoding="utf-8") as file:
        file.write(fault)
    (tmp_path / "tsconfig.json").write_text(json.dumps(config | {"include": ["static/*.js"]}))
    done = subprocess.run([TSC, "--project", tmp_path], capture_output=True, text=True, timeout=120)
    assert (done.returncode == 0) == (fault == ""), done.stdout + done.stderr


def test_every_module_has_tests_of_its_name_and_is_loaded_with_the_page():
    modules = {module.stem for module in STATIC.glob("*.js")}
    assert {path.name.partition(".")[0] for path in TESTS.glob("*.test.js")} == modules | {"whole"}
    page = (STATIC / "index.html").read_text(encoding="utf-8")
    assert set(re.findall(r'"modulepreload" href="/static/(\w+)\.js"', page)) == modules - {"main"}


# --- what the page and the server must agree on ----------------------------------------------------------------------


def source(name):
    return (STATIC / f"{name}.js").read_text(encoding="utf-8")


def constant(text, name):
    return json.loads(re.search(rf"\b{name} = ([^;,]+(?:, \d+\])?)[,;]", text)[1])


def test_the_map_has_as_many_cells_on_both_sides():
    assert constant(source("map"), "CELLS") == list(asked.MAP_CELLS)
    assert constant(source("work"), "IMPOSSIBLE") == grids.IMPOSSIBLE
    assert int(re.search(r"over\[1\]\)\) / (\d+)", source("sweep"))[1]) == asked.STRIP_VALUES - 1


def test_states_of_the_film_have_the_same_numbers_on_both_sides():
    cone = source("cone")
    assert [constant(cone, name) for name in ("AROUND", "MERIDIAN", "BOTH")] == [
        look.HOOP_SLACK,
        look.MERIDIONAL_SLACK,
        look.CRUMPLED,
    ]
    assert constant(source("badge"), "BREAKDOWN") == look.BREAKDOWN < min(look.NEAR_LIMIT, look.BEYOND_MEMBRANE)
    order = re.search(r"palette\.film = \[(.*?)\]", source("colours"))[1].replace("palette.", "").split(", ")
    names = {"taut": look.TAUT, "around": look.HOOP_SLACK, "meridian": look.MERIDIONAL_SLACK, "both": look.CRUMPLED}
    names |= {"breakdown": look.BREAKDOWN, "limit": look.NEAR_LIMIT, "beyond": look.BEYOND_MEMBRANE}
    assert [names[name] for name in order] == list(range(len(look.FILM_STATES)))


def test_kinds_of_motion_have_the_same_numbers_on_both_sides():
    settled = re.search(r"wanders = !\[([\d, ]+)\]", source("looks"))[1]
    assert [int(number) for number in settled.split(",")] == [Regime.REST, Regime.PERIODIC]
    assert f"code === {int(Regime.CHAOTIC)} ? 0.75" in source("sweep")


def test_the_page_sends_no_file_that_the_server_refuses():
    assert int(re.search(r"LARGEST_FILE = (\d+)", source("main"))[1]) == setting.LONGEST_FILE
    assert "file.size > LARGEST_FILE" in source("main")


def test_every_run_that_the_page_offers_may_be_asked_for():
    text = (STATIC / "index.html").read_text(encoding="utf-8")
    offered = [int(value) for value in re.findall(r'<option value="(\d+)"', text)]
    assert [look.check_periods(value) for value in offered] == offered
    assert look.PERIODS in offered
    assert int(re.search(r'periods: \["(\d+)"', source("address"))[1]) == look.PERIODS


def test_files_have_kinds():
    assert {path.suffix for path in STATIC.iterdir()} <= set(KINDS)
