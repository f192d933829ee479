"""The site without Sphinx: everything public has a page, pages are reached and short, links lead somewhere."""

import re
import sys
from pathlib import Path

import pytest

import gelcone
from gelcone.cli import COMMANDS
from gelcone.glossary import GLOSSARY

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
sys.path.insert(0, str(DOCS / "site"))

import pages  # noqa: E402

WIDEST = 78
"""Characters of a line of code that a page of 1280 pixels shows."""
LONGEST = 1500
"""Words of a page that is written by hand."""


@pytest.fixture(scope="module")
def generated():
    return pages.all_pages(ROOT, results=False)


@pytest.fixture(scope="module")
def every(generated):
    """Path -> text of every page."""
    own = {str(path.relative_to(DOCS)): path.read_text(encoding="utf-8") for path in DOCS.rglob("*.md")}
    return generated | {name: text for name, text in own.items() if not name.startswith(("site", "measured"))}


def test_every_public_name_has_a_page_that_sphinx_finds(generated):
    for name in pages.public_names():
        page = generated[f"reference/api/{name}.md"]
        if callable(getattr(gelcone, name)):
            directive, target = re.search(r"\.\. auto(\w+):: (\S+)", page).groups()
            assert directive in ("function", "class")
            assert target == pages.target(name)
        assert f"[{name}](api/{name}.md)" in generated["reference/python.md"]


def test_every_command_has_a_page_with_its_help(generated):
    for name in COMMANDS:
        page = generated[f"reference/commands/{name}.md"]
        assert f"Usage: gelcone {name}" in page
        assert not re.search(r"`?gelcone\.\w+\.\w+", page), f"{name}: its help names what is internal"
        assert f"commands/{name}\n" in generated["reference/commands.md"]


def test_every_field_code_gel_device_and_term_is_listed(generated, every):
    for field in gelcone.Device.fields:
        assert f"| `{field}` |" in generated["reference/device-file.md"]
    for field in gelcone.Material.fields:
        assert f"| `material.{field}` |" in generated["reference/device-file.md"]
    for outcome in gelcone.Outcome:
        assert f"| {outcome.value} | `{outcome.label}` | {outcome.meaning} |" in generated["reference/codes.md"]
    for regime in gelcone.Regime:
        assert f"| {regime.value} | {regime.label} |" in generated["reference/codes.md"]
    for gel in gelcone.load_materials().values():
        assert f"## {gel.name}" in generated["reference/gels.md"]
    for path in (ROOT / "examples" / "devices").glob("*.toml"):
        assert f"## {path.stem}" in generated["reference/devices.md"]
    assert all(f"| {term} |" in every["glossary.md"] for term in GLOSSARY)


def test_variables_of_a_result_have_dims_a_unit_of_devices_and_a_meaning():
    table = pages.variables(pages.example_result("settled"))
    assert re.search(r"\| `stroke` \|  ?\| mm \| .*\|", table)
    assert "| `harmonic_amplitude` | harmonic | mm |" in table


def test_every_analysis_has_its_variables(generated):
    for name, (_, about) in gelcone._listing().items():
        assert (f"## {name}\n" in generated["reference/results.md"]) == bool(about)


def test_the_gallery_holds_every_example_with_a_title_and_most_draw(generated):
    scripts = {path.name for path in (ROOT / "examples").glob("*.py")}
    assert {name.removeprefix("examples/") for name in generated if name.endswith(".py")} == scripts
    drawing = [name for name in scripts if "figure = " in (ROOT / "examples" / name).read_text(encoding="utf-8")]
    assert len(drawing) >= 24
    for name in scripts:
        assert re.match(r'"""(.+)\n=+\n\n\w', generated[f"examples/{name}"])


def test_every_page_is_in_the_tree(every):
    """From the first page on, by the lists of pages."""
    reached, queue = set(), ["index"]
    while queue:
        here = queue.pop()
        if here in reached or f"{here}.md" not in every:
            continue
        reached.add(here)
        for block in re.findall(r"```\{toctree\}\n(.*?)```", every[f"{here}.md"], flags=re.DOTALL):
            names = [line for line in block.splitlines() if line and not line.startswith(":")]
            queue += [str((Path("/") / here).parent.joinpath(name).resolve().relative_to("/")) for name in names]
    assert {name.removesuffix(".md") for name in every if name.endswith(".md")} - reached == {"validation-table"}


def test_links_between_pages_lead_to_pages(every):
    for name, text in every.items():
        for link in re.findall(r"\]\(([^)#:]+\.md)(?:#[^)]*)?\)", re.sub(r"```.*?```", "", text, flags=re.DOTALL)):
            target = (Path("/") / name).parent.joinpath(link).resolve().relative_to("/")
            known = str(target) in every or (DOCS / target).exists() or (ROOT / target).exists()
            assert known or (DOCS / name).parent.joinpath(link).exists(), f"{name}: {link}"


def test_links_of_pages_by_hand_lead_to_files_or_into_the_folders_that_the_readme_names_as_generated():
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    for path in DOCS.rglob("*.md"):
        text = re.sub(r"```.*?```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        for link in re.findall(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)", text):
            target = (path.parent / link).resolve()
            if not target.exists():
                assert f"`{target.relative_to(DOCS).parts[0]}/`" in readme, f"{path.name}: {link}"


def test_pages_written_by_hand_are_short():
    for path in DOCS.rglob("*.md"):
        text = re.sub(r"```.*?```", "", path.read_text(encoding="utf-8"), flags=re.DOTALL)
        assert len(text.split()) <= LONGEST, path.name


def test_code_of_the_tutorials_is_python():
    found = 0
    for path in (DOCS / "tutorials").glob("*.md"):
        for cell in re.findall(r"```\{code-cell\}\n(.*?)```", path.read_text(encoding="utf-8"), flags=re.DOTALL):
            compile(cell, path.name, "exec")
            assert max(map(len, cell.splitlines())) <= WIDEST, f"{path.name}: a line is cut on the page"
            found += 1
    assert found >= 15
