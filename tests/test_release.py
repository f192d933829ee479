"""The parts of a release agree: public names, versions, dependencies, workflows, fields left to fill."""

import re
import tomllib
from pathlib import Path

import pytest

import gelcone

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))


def test_the_public_names_are_those_of_the_list():
    """A new name takes a line there; one that goes is deprecated for two minor versions first."""
    listed = (ROOT / "tests" / "public_names.txt").read_text(encoding="utf-8").split()
    assert [name for name in dir(gelcone) if not name.startswith("__")] == listed


def test_files_have_names_that_every_system_takes():
    """Windows takes none with a bar, an angle or a quotation mark."""
    folders = [path for path in ROOT.iterdir() if path.is_dir() and not path.name.startswith(".")]
    names = [path.name for path in ROOT.iterdir()] + [path.name for folder in folders for path in folder.rglob("*")]
    assert [name for name in names if not re.fullmatch(r"[\w. +@-]+", name)] == []


def test_a_star_import_takes_the_public_names_and_no_others():
    scope = {}
    exec("from gelcone import *", scope)
    assert {name for name in scope if not name.startswith("__")} == set(gelcone.__all__)
    assert set(gelcone.__all__) == {name for name in dir(gelcone) if not name.startswith("__")}


def test_the_citation_has_the_version():
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {gelcone.__version__}\n" in citation
    assert f'version: "{gelcone.__version__}"' in (ROOT / "packaging" / "recipe.yaml").read_text(encoding="utf-8")


def test_the_recipe_has_the_dependencies_of_the_project():
    recipe = (ROOT / "packaging" / "recipe.yaml").read_text(encoding="utf-8")
    run = recipe.partition("  run:\n")[2].partition("tests:")[0]
    found = {line.strip().removeprefix("- ").replace("-base", "").replace(" ", "").lower() for line in run.splitlines()}
    wanted = {dependency.lower() for dependency in PROJECT["dependencies"]}
    assert found - {""} == wanted | {"python>=${{python_min}}"}


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.name)
def test_workflows_pin_their_actions_and_ask_for_little(path):
    text = path.read_text(encoding="utf-8")
    used = re.findall(r"uses: (\S+)", text)
    assert used
    assert all(re.fullmatch(r"[\w./-]+@[0-9a-f]{40}", action) for action in used)
    assert "\npermissions:\n  contents: read\n" in text
    granted = re.findall(r"^ +([\w-]+): write$", text, flags=re.MULTILINE)
    assert granted == (["id-token"] if path.name == "release.yml" else [])


def test_scripts_that_workflows_run_are_there():
    for path in WORKFLOWS:
        for script in re.findall(r"python ((?:tools|docs|benchmarks)/\w+\.py)", path.read_text(encoding="utf-8")):
            assert (ROOT / script).is_file(), f"{path.name}: {script}"


def test_what_is_left_to_fill_is_named_in_one_place():
    """Nothing names a host or a person that does not exist."""
    releasing = (ROOT / "RELEASING.md").read_text(encoding="utf-8")
    for name in ("pyproject.toml", "CITATION.cff", "paper.md", "packaging/recipe.yaml"):
        assert f"`{name}`" in releasing
    for path in (
        "SECURITY.md",
        "CODE_OF_CONDUCT.md",
        "RELEASING.md",
        "paper.md",
        "packaging/recipe.yaml",
        "Dockerfile",
    ):
        assert "example.com" not in (ROOT / path).read_text(encoding="utf-8")


def test_the_paper_has_the_length_and_the_parts_that_journals_ask_for():
    paper = (ROOT / "paper.md").read_text(encoding="utf-8")
    body = paper.split("---", 2)[2]
    assert 750 <= len(body.split()) <= 1000
    wanted = "Summary, Statement of need, State of the field, Software design, Research impact statement"
    headings = [line.removeprefix("# ") for line in body.splitlines() if line.startswith("# ")]
    assert headings == [*wanted.split(", "), "AI usage disclosure", "Availability", "Acknowledgements", "References"]
    cited = set(re.findall(r"@(\w+)", body))
    assert cited == set(
        re.findall(r"^@\w+\{(\w+),", (ROOT / "paper.bib").read_text(encoding="utf-8"), flags=re.MULTILINE)
    )
