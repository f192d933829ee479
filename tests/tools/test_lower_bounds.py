"""The script of the lower bounds reads them as they are written, and misses none."""

import runpy
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SCRIPT = runpy.run_path(str(ROOT / "tools" / "lower_bounds.py"))
TEXT = """
[project]
dependencies = ["click>=8.1", "heyoka>=7.3; platform_system == 'Linux'"]
[project.optional-dependencies]
cluster = ["Distributed[complete] >= 2024.8"]
fem = ["scikit-fem>=10", "click>=8.1"]
test = ["pytest>=8,<99"]
"""


def test_the_lowest_version_of_every_requirement_is_pinned():
    assert SCRIPT["pins"](TEXT) == {
        "click": "8.1",
        "heyoka": "7.3",
        "distributed": "2024.8",
        "scikit-fem": "10",
        "pytest": "8",
    }


@pytest.mark.parametrize(
    ("requirement", "message"),
    [("click", "click: has no lower bound"), ("click>=8.2", "click: has two lower bounds, 8.1 and 8.2")],
)
def test_a_missing_or_second_bound_is_refused(requirement, message):
    with pytest.raises(ValueError, match=message):
        SCRIPT["pins"](TEXT.replace("scikit-fem>=10", requirement))


def test_every_requirement_of_the_project_has_a_bound():
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    names = {r.split(">")[0].split("[")[0].lower() for r in tomllib.loads(text)["project"]["dependencies"]}
    assert names <= set(SCRIPT["pins"](text))
