"""The house: every folder of the package imports only what stands above it, and no module imports itself in a circle.

All imports count, those inside functions and those for types too.
"""

import ast
import re
from functools import cache
from pathlib import Path

import pytest

from tests import conftest

PACKAGE = Path(__file__).parents[1] / "src" / "gelcone"
FLOORS = [
    [
        "_version",
        "errors",
        "codes",
        "quantity",
        "bracket",
        "statistics",
        "progress",
        "files",
        "disk_cache",
        "netcdf",
        "earlier",
        "interchange",
        "markup",
        "permission",
    ],
    ["accessor", "register"],
    ["membrane"],
    ["physics"],
    ["presets", "dataset"],
    ["devices"],
    ["continuum"],
    ["motion"],
    ["atlas"],
    ["lab"],
    ["amounts"],
    ["words", "glossary"],
    ["plots"],
    ["analyses"],
    ["export", "learn"],
    ["paper", "studio"],
    ["cli"],
    ["__main__"],
]
"""Folders and modules, each line importing only from the lines before it and from its own folder.

`accessor` and `register` stand on the ground: they hold names of the package, which load what is above only in use.
"""
FLOOR = {name: number for number, names in enumerate(FLOORS) for name in names}
REMAINING: set[tuple[str, str]] = set()
"""Arrows that still run the wrong way, (from, to); this list may only shrink."""


def modules():
    """Dotted name below ``gelcone`` -> path of every module; the package's own ``__init__`` is left out."""
    paths = {path.relative_to(PACKAGE).with_suffix(""): path for path in PACKAGE.rglob("*.py")}
    named = {".".join(name.parts).removesuffix(".__init__"): path for name, path in paths.items()}
    return {name: path for name, path in named.items() if name != "__init__"}


MODULES = modules()


def imported(source, known=MODULES):
    """The modules of gelcone that a source imports, with the line of each."""
    found = {}
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.level:
            raise AssertionError("a relative import; write the module's whole name")
        names = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        for name in names:
            parts = name.split(".")
            if parts[0] != "gelcone":
                continue
            candidates = (".".join(parts[1:end]) for end in range(len(parts), 1, -1))
            module = next((candidate for candidate in candidates if candidate in known), None)
            if module is not None:
                found.setdefault(module, node.lineno)
    return found


def test_the_table_of_the_architecture_is_the_order_that_is_checked():
    text = (PACKAGE.parents[1] / "ARCHITECTURE.md").read_text(encoding="utf-8")
    rows = [line.split("|")[1] for line in text.splitlines() if line.startswith("| `")]
    rows = rows[: next(n for n, row in enumerate(rows) if "`cli/`" in row) + 1]
    written = [name for row in rows for name in re.findall(r"`(\w+)(?:\.py|/)`", row)]
    assert sorted(written) == sorted(set(FLOOR) - {"_version", "accessor", "__main__"})
    assert [FLOOR[name] for name in written] == sorted(FLOOR[name] for name in written)


@cache
def imports():
    """The modules that every module imports."""
    return {name: imported(path.read_text(encoding="utf-8")) for name, path in MODULES.items()}


def place(module):
    return module.partition(".")[0]


def wrong_way():
    return {
        (module, other)
        for module, others in imports().items()
        for other in others
        if FLOOR[place(other)] > FLOOR[place(module)]
        or (FLOOR[place(other)] == FLOOR[place(module)] and place(other) != place(module) and FLOOR[place(module)] > 0)
    }


def circles():
    """Modules from which imports lead back to themselves, each with the shortest way."""
    found = {}
    for start in imports():
        ways = {other: [start, other] for other in imports()[start]}
        queue = list(ways)
        while queue and start not in ways:
            here = queue.pop(0)
            for other in imports()[here]:
                if other not in ways:
                    ways[other] = [*ways[here], other]
                    queue.append(other)
        if start in ways:
            found[start] = " -> ".join(ways[start])
    return found


def test_every_folder_and_module_has_its_floor():
    assert {place(module) for module in MODULES} <= set(FLOOR)


def test_every_folder_imports_only_what_stands_above_it():
    assert wrong_way() == REMAINING


def test_no_module_imports_itself_in_a_circle():
    assert circles() == {}


def test_the_integrator_is_known_to_one_place():
    """LLVM is imported by one module of the engine, and the engine by the module that gives a back end alone."""
    text = {module: path.read_text(encoding="utf-8") for module, path in MODULES.items()}
    assert [module for module in text if "import llvmlite" in text[module]] == ["motion.engine.compile"]
    users = [module for module in text if "motion.engine" in text[module] and not module.startswith("motion.engine")]
    assert users == ["motion.flow"]
    assert not [module for module in text if "import heyoka" in text[module]]


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("from gelcone.motion.flow import integrate", {"motion.flow"}),
        ("from gelcone import dataset", {"dataset"}),
        ("def f():\n    import gelcone.physics.laws as laws", {"physics.laws"}),
        ("import gelcone\nfrom gelcone import simulate", set()),
        ("import numpy", set()),
    ],
)
def test_imports_are_found_wherever_they_stand(source, found):
    assert set(imported(source, {"motion.flow": 0, "dataset": 0, "physics.laws": 0})) == found


LONGEST = 80
"""Lines of a function without its docstring."""


@pytest.mark.parametrize("name", MODULES)
def test_functions_are_short(name):
    for node in ast.walk(ast.parse(MODULES[name].read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            first = node.body[1] if ast.get_docstring(node) is not None and node.body[1:] else node.body[0]
            assert node.end_lineno - first.lineno < LONGEST, f"{name}: {node.name}"


def test_no_plugin_imports_numpy_before_the_threads_of_blas_are_held_back():
    assert not conftest.NUMPY_CAME_FIRST
