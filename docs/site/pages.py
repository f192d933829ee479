"""The pages that are generated from the package: reference and gallery, each as path -> text.

Nothing here needs Sphinx, so that `tests/docs/test_site.py` can see that everything public has a page.
"""

from __future__ import annotations

import doctest
import inspect
import json
import re
from collections.abc import Iterable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

import gelcone

Pages = dict[str, str]
FOLDERS = {
    "devices": "Devices and gels",
    "motion": "Functions behind the analyses",
    "atlas": "Plans, workers and uncertain parameters",
    "lab": "Measured data",
    "export": "Other programs",
    "physics": "Models and their components",
    "": "Results, codes and errors",
}
"""Folder of the package -> heading of the names that come from it and are not analyses."""


def write(pages: Mapping[str, str], folder: Path) -> Iterable[Path]:
    """Write pages that differ from what is there; yields all paths."""
    for name, text in pages.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
        yield path


def all_pages(root: Path, results: bool = True) -> Pages:
    """Every generated page; ``results`` also runs the examples of the analyses, which takes some seconds."""
    pages = (
        api()
        | commands()
        | device_file()
        | gels()
        | codes()
        | answers(root)
        | gallery(root)
        | devices()
        | project(root)
    )
    return pages | results_page(results) | validation(root)


def public_names() -> list[str]:
    """The public names of the package."""
    return [name for name in dir(gelcone) if not name.startswith("__")]


def table(heads: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    """A Markdown table."""
    heads = list(heads)
    lines = [heads, ["---"] * len(heads), *([cell(value) for value in row] for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n"


def cell(value: Any) -> str:
    """A text as it may stand in a cell."""
    return " ".join(str(value).split()).replace("|", "\\|")


def code(value: Any) -> str:
    """A text in the type of code; empty for none."""
    return f"`{value}`" if str(value) else ""


# --- Python -----------------------------------------------------------------------------------------------------------


def api() -> Pages:
    """A page for each public name, and a list by subject."""
    analyses = {name: about for name, (_, about) in gelcone._listing().items() if about}
    groups: dict[str, list[str]] = {"Analyses": list(analyses)} | {heading: [] for heading in FOLDERS.values()}
    for name in public_names():
        if name not in analyses:
            folder = gelcone._listing()[name][0].split(".")[1:2]
            groups[FOLDERS.get("".join(folder), FOLDERS[""])].append(name)
    text = ["# Python", "", "```{eval-rst}", ".. py:module:: gelcone", "```", "", inspect.cleandoc(INTRODUCTION), ""]
    for heading, names in groups.items():
        text += [f"## {heading}", "", table(["name", "what"], ((f"[{n}](api/{n}.md)", summary(n)) for n in names))]
    every = "\n".join(f"api/{name}" for name in public_names())
    text += ["```{toctree}", ":hidden:", "", every, "```", ""]
    return {"reference/python.md": "\n".join(text)} | {
        f"reference/api/{name}.md": api_page(name) for name in public_names()
    }


INTRODUCTION = """
    Everything public is a name of `gelcone` itself, loaded when it is first used. Analyses take a `Device` in SI units,
    with options as numbers or as texts with units, or a dimensionless `ConeModel`; they give an `xarray.Dataset`.
    What is public, and for how long, is on the page [Policy](../project/policy.md).
    """


def summary(name: str) -> str:
    """The first line of a docstring."""
    about = gelcone._listing()[name][1]
    return (about or (inspect.getdoc(named(name)) or "").partition("\n")[0]).replace("`", "")


def named(name: str) -> Any:
    """A public object; a folder that can be called, as the studio, stands for the function of its name."""
    thing = getattr(gelcone, name)
    return getattr(import_module(target(name).rpartition(".")[0]), name) if callable(thing) else thing


def target(name: str) -> str:
    """The dotted name by which Sphinx finds a public object."""
    folder = inspect.ismodule(getattr(gelcone, name)) and callable(getattr(gelcone, name))
    return f"{gelcone._listing()[name][0]}.{name}" if folder else f"gelcone.{name}"


def api_page(name: str) -> str:
    """The page of a public name."""
    thing = named(name)
    head = f"# {name}\n\n"
    if name == "LAWS":
        return (
            head
            + "The strain-energy laws that ship, by name:\n\n"
            + table(
                ["name", "class", "energy"],
                ((code(k), code(type(v).__name__), summary(type(v).__name__)) for k, v in thing.items()),
            )
        )
    if inspect.ismodule(thing):
        return head + "One function for each kind of figure; `gelcone.plot` picks the one that a result is drawn by.\n"
    role = "autoclass" if inspect.isclass(thing) else "autofunction"
    members = "\n   :members:" if inspect.isclass(thing) and not issubclass(thing, Exception) else ""
    command = gelcone._listing()[name][1] and command_of(name)
    also = f"\nOn the command line: [gelcone {command}](../commands/{command}.md).\n" if command else ""
    return f"{head}```{{eval-rst}}\n.. {role}:: {target(name)}{members}\n```\n{also}"


# --- commands ---------------------------------------------------------------------------------------------------------


def command_of(name: str) -> str:
    """The command of an analysis."""
    from gelcone.register.analysis import command_name

    return command_name(name)


def commands() -> Pages:
    """A page for each command: its help, as printed."""
    from click.testing import CliRunner

    from gelcone.cli import COMMANDS, group

    runner = CliRunner()
    pages = {}
    for name in COMMANDS:
        said = runner.invoke(group, [name, "--help"], prog_name="gelcone", terminal_width=100).output
        pages[f"reference/commands/{name}.md"] = f"# gelcone {name}\n\n```text\n{said.rstrip()}\n```\n"
    said = runner.invoke(group, ["--help"], prog_name="gelcone", terminal_width=100).output
    every = "\n".join(f"commands/{name}" for name in COMMANDS)
    listed = f"```{{toctree}}\n:maxdepth: 1\n\n{every}\n```\n"
    pages["reference/commands.md"] = f"# Commands\n\n```text\n{said.rstrip()}\n```\n\n{listed}"
    return pages


# --- devices and gels -------------------------------------------------------------------------------------------------


def device_file() -> Pages:
    """The fields of a device."""
    fields = [(name, field) for name, field in gelcone.Device.fields.items()]
    rows = [(code(name), field.unit or "", field.meaning, said(field)) for name, field in fields]
    gel = [
        (code(f"material.{name}"), field.unit or "", field.meaning, said(field))
        for name, field in gelcone.Material.fields.items()
    ]
    heads = ["field", "unit", "meaning", "when left out"]
    text = f"{inspect.cleandoc(DEVICE_FILE)}\n\n## Fields of the device\n\n{table(heads, rows)}\n"
    return {"reference/device-file.md": text + f"## Fields of the material\n\n{table(heads, gel)}"}


DEVICE_FILE = """
    # The device file

    A TOML file. `gelcone init mine.toml` writes one with every field explained, `gelcone devices biased-pump` prints
    one that ships, and `gelcone help device` lists the fields. A number has its SI unit; a text has its own, as in
    `"0.2 mm"`. The same fields are the keywords of `gelcone.Device`, the names after `--set` and `--over`, and the
    axes of sweeps. A gel is the name of one that [ships](gels.md), or a table `[material]` with the fields below.
    A user-defined law, film, waveform, bias or circuit is a table, too: see [how to add one](../howto/own-parts.md).
    """


def said(field: Any) -> str:
    """What a field is when it is left out."""
    if field.unset:
        return str(field.unset)
    return "required" if field.required else str(field.default)


def gels() -> Pages:
    """The gels that ship, with the source of every number."""
    text = ["# Gels", "", "What `gelcone materials` lists, with the source of every number.", ""]
    for name, gel in gelcone.load_materials().items():
        rows = []
        for field, about in gelcone.Material.fields.items():
            value = getattr(gel, field, None)
            if field not in ("name", "sources") and value is not None:
                rows.append((code(field), shown(value), about.unit, gel.sources.get(field, "")))
        text += [f"## {name}", "", table(["field", "value", "unit", "source"], rows)]
    return {"reference/gels.md": "\n".join(text)}


def shown(value: Any) -> str:
    """A value of a gel as text."""
    if isinstance(value, float | int):
        return f"{value:.6g}"
    return (
        ", ".join(f"{v:.6g}" for v in value) if isinstance(value, tuple | list) else getattr(value, "name", str(value))
    )


def devices() -> Pages:
    """The devices that ship, as the files they are."""
    from gelcone.devices.files import shipped_devices

    text = [
        "# Devices that ship",
        "",
        "Each is a file that `gelcone devices NAME` prints; every number states where it is from.",
        "",
    ]
    for name in shipped_devices():
        source = Path(gelcone.__file__).parents[2] / "examples" / "devices" / f"{name}.toml"
        text += [f"## {name}", "", f"```toml\n{source.read_text(encoding='utf-8').rstrip()}\n```", ""]
    return {"reference/devices.md": "\n".join(text)}


# --- codes, JSON, results ---------------------------------------------------------------------------------------------


def codes() -> Pages:
    """Outcomes, regimes and the other codes of results."""
    from gelcone.codes import FilmPullIn

    text = [inspect.cleandoc(CODES), "", "## Outcomes", ""]
    text += [
        table(
            ["code", "name", "what happened, and what to do"],
            ((o.value, code(o.label), o.meaning) for o in gelcone.Outcome),
        )
    ]
    text += [
        "## Regimes",
        "",
        table(["code", "name", "meaning"], ((r.value, r.label, r.meaning) for r in gelcone.Regime)),
    ]
    for kind in (gelcone.PullIn, FilmPullIn, gelcone.Onset):
        text += [f"## {kind.__name__}", "", (inspect.getdoc(kind) or "").partition("\n")[0], ""]
        text += [table(["code", "name"], ((one.value, one.name.lower().replace("_", " ")) for one in kind))]
    return {"reference/codes.md": "\n".join(text)}


def glossary() -> str:
    """The text of ``docs/glossary.md``, which stands in the repository."""
    from gelcone.glossary import GLOSSARY

    rows = [f"| {term} | {meaning} |" for term, meaning in GLOSSARY.items()]
    head = "# Glossary\n\nThe words of figures, tables and messages; `gelcone help glossary` prints them.\n"
    return "\n".join([head, "| term | meaning |", "|---|---|", *rows]).replace("|offset|", "\\|offset\\|") + "\n"


CODES = """
    # Outcomes, regimes, messages

    Every member of an ensemble and every cell of a map ends with an outcome, and where it has a long run with a regime.
    Results hold the codes; JSON, tables and texts the names.

    ## Messages

    What cannot be used is refused in one line that names the value, the bound and the remedy: on the command line
    `Error: ...` with exit code 2, in Python `gelcone.InputError`. What can be used and is probably not meant is a line
    that begins with `Warning:`, in Python a `gelcone.errors.DoubtfulInput`. A library that is missing is named with the
    command that installs it (`gelcone.MissingDependency`). `gelcone regime` and others end with 1 where they have an
    answer that you should doubt, and print why.
    """


def answers(root: Path) -> Pages:
    """The JSON of every command."""
    schema = json.loads((root / "docs" / "answer.schema.json").read_text(encoding="utf-8"))
    rows = (
        (code(name), one.get("description", schema["$defs"]["names"].get("description", "")))
        for name, one in schema["properties"].items()
    )
    text = f"# JSON\n\n{schema['title']}, checked against a [schema](../answer.schema.json) (JSON Schema 2020-12).\n\n"
    return {"reference/json.md": text + table(["key", "meaning"], rows)}


def results_page(run: bool) -> Pages:
    """The variables of every analysis: dims, unit of a device, meaning, from the examples of the docstrings."""
    text = ["# Results", "", inspect.cleandoc(RESULTS), ""]
    for name in (name for name, (_, about) in gelcone._listing().items() if about):
        text += [f"## {name}", "", summary(name), ""]
        text += [variables(example_result(name))] if run else ["(left out of a fast build)", ""]
    return {"reference/results.md": "\n".join(text)}


RESULTS = """
    An answer is an `xarray.Dataset`. Below are the variables of each analysis as the example of its
    docstring gives them; further states, a second film and a circuit add their own. *Unit* is that of a device; a
    model's numbers are dimensionless. `result.attrs` holds model, options and version, from which it can be run again.
    """


def example_result(name: str) -> Any:
    """The last Dataset that the example of an analysis makes."""
    scope: dict[str, Any] = {}
    for example in doctest.DocTestParser().get_examples(inspect.getdoc(named(name)) or ""):
        exec(compile(example.source, name, "exec"), scope)
    return [value for value in scope.values() if hasattr(value, "data_vars")][-1]


def variables(result: Any) -> str:
    """A table of the variables of a result."""
    from gelcone.devices.scales import MEASURES

    rows = []
    for name, one in {**result.coords, **result.data_vars}.items():
        measure = MEASURES.get(one.attrs.get("quantity", ""))
        unit = measure.shown if measure else one.attrs.get("units", "").replace("1", "")
        rows.append((code(name), ", ".join(map(str, one.dims)), unit, one.attrs.get("long_name", "")))
    return table(["variable", "dims", "unit", "meaning"], rows)


# --- gallery ----------------------------------------------------------------------------------------------------------


def gallery(root: Path) -> Pages:
    """The examples with the headings that sphinx-gallery wants: a title, then the question that each answers."""
    pages = {"examples/GALLERY_HEADER.rst": GALLERY}
    for script in sorted((root / "examples").glob("*.py")):
        title = script.stem.replace("_", " ").capitalize()
        source = script.read_text(encoding="utf-8")
        pages[f"examples/{script.name}"] = re.sub(r'^"""', f'"""{title}\n{"=" * len(title)}\n\n', source, count=1)
    return pages


GALLERY = """Gallery
=======

Short scripts, each with a figure and a number that it asserts. The tests run them as they are; download one and run it.

"""


# --- the project ------------------------------------------------------------------------------------------------------


PROJECT = ("CHANGELOG", "CONTRIBUTING", "ARCHITECTURE", "RELEASING", "SECURITY", "CODE_OF_CONDUCT")
"""Pages that stand at the top of the repository."""


def project(root: Path) -> Pages:
    """Pages that stand at the top of the repository, with links that work here."""
    pages = {}
    for name in PROJECT:
        text = (root / f"{name}.md").read_text(encoding="utf-8")
        for other in PROJECT:
            text = text.replace(f"({other}.md", f"({other.lower()}.md")
        pages[f"project/{name.lower()}.md"] = re.sub(r"\]\(docs/", "](../", text)
    return pages


def validation(root: Path) -> Pages:
    """The table of certified numbers, from the file that `benchmarks/validation.py` writes."""
    import csv

    with (root / "docs" / "validation.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    heads = ["number", "reference", "gelcone", "error", "from"]
    groups: dict[str, list[list[str]]] = {}
    for row in rows:
        groups.setdefault(row["subject"], []).append(
            [row["number"], row["reference"], row["found"], code(row["error"]), row["source"]]
        )
    text = "\n".join(f"## {subject}\n\n{table(heads, lines)}" for subject, lines in groups.items())
    made = f"Computed on {rows[0]['date']} by gelcone {rows[0]['version']}; the error is the largest over a case.\n\n"
    return {"validation-table.md": "---\norphan: true\n---\n# Certified numbers\n\n" + made + text}
