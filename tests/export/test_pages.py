"""The pages about other programs: what can be run here is run as it stands."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

import gelcone
from gelcone.export.compiler import find_compiler
from tests.export.instance import device

DOCS = Path(__file__).parents[2] / "docs"
PAGES = ("fmpy", "simulink", "openmodelica", "c", "python-control", "learning")


def blocks(page, language):
    """The blocks of a page in a language."""
    return re.findall(rf"```{language}\n(.*?)```", (DOCS / f"{page}.md").read_text(encoding="utf-8"), flags=re.DOTALL)


@pytest.fixture
def ran(monkeypatch, tmp_path):
    """Runs the Python of a page, one block after the other, and gives its names."""
    monkeypatch.chdir(tmp_path)

    def of(page, **given):
        names = dict(given)
        for text in blocks(page, "python"):
            exec(compile(text, f"{page}.md", "exec"), names)
        return names

    return of


@pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler here")
def test_the_page_of_fmpy_gives_the_height_of_gelcone(ran):
    found = ran("fmpy")
    own = gelcone.rates(found["device"])
    times = found["found"]["time"]
    right = gelcone.simulate(found["device"].replace(voltage_amplitude=0.0, voltage_offset=900.0), times=times[1:])
    assert own.start[0] < found["height"]
    assert found["height"] == pytest.approx(1e-3 * float(right.displacement[-1]), rel=1e-6)
    assert (found["found"]["valid"] == 1.0).all()


def test_the_page_of_python_control_runs(ran):
    found = ran("python-control")
    assert found["electric"].outputs == ("current",)
    assert found["closed"].dcgain() == pytest.approx(1.0)
    assert found["response"].outputs.shape == (2, 301)
    assert float(found["rise"].largest_error) < 0.01
    assert found["run"].success
    assert found["acceleration"] > 0.0


def test_the_page_of_learning_runs(ran):
    found = ran("learning", gelcone=gelcone, device=device(film="taut"))
    assert found["seen"].shape == (1024, 4)
    assert found["pumps"].observation_space.contains(found["seen"])
    assert np.isfinite(found["reward"]).all()


@pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler here")
def test_the_page_of_c_compiles_and_runs(tmp_path):
    gelcone.export(device(film="taut"), tmp_path / "pump")
    (body,) = blocks("c", "c")
    text = f'#include <stdio.h>\n#include "pump.h"\nint main(void) {{\nint outcome;\ndouble height;\n{body}'
    (tmp_path / "pump" / "page.c").write_text(text + 'printf("%.6f\\n", height);\nreturn 0;\n}\n')
    command = [
        *find_compiler(),
        "-std=c99",
        "-Wall",
        "-Werror",
        "-ffp-contract=off",
        "page.c",
        "pump.c",
        "-lm",
        "-o",
        "p",
    ]
    subprocess.run(command, cwd=tmp_path / "pump", check=True)
    words, height = subprocess.run(
        ["./p"], cwd=tmp_path / "pump", check=True, capture_output=True, text=True
    ).stdout.split()
    assert words == "ok"
    assert 0.012 < float(height) < 0.014


@pytest.mark.parametrize("page", PAGES)
def test_a_page_is_short_and_is_found_from_the_overview(page):
    text = (DOCS / f"{page}.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) < 75
    assert "\n\nHow " in text or "\n\nCan " in text, "it opens with the question it answers"
    assert f"({page}.md)" in (DOCS / "export.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("page", ["simulink", "openmodelica"])
def test_what_was_not_run_says_so(page):
    assert "**This was not run:**" in (DOCS / f"{page}.md").read_text(encoding="utf-8")
