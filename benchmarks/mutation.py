"""Mutation test: faults are put into the program one at a time, and the tests of their folder run.

    python benchmarks/mutation.py                                  (40 random faults in each folder)
    python benchmarks/mutation.py --folder plots --count 100 --seed 7
    python benchmarks/mutation.py --listed                         (those of mutations.toml)
    python benchmarks/mutation.py --folder paper --show            (only prints the faults)

Faults are put into a temporary copy of the tree; the checkout is never touched. A fault in ``src/gelcone/FOLDER/x.py``
runs ``tests/FOLDER/test_x.py`` and, if that does not see it, the rest of ``tests/FOLDER``; one in a module at the top
runs its test file alone. A run that fails, or takes `SLOWER` times as long as without a fault, has seen it. Faults that
are not seen are printed as a line of code before and after.

Random faults change one expression: a comparison, an arithmetic or logical operator, a sign, a constant, an index, a
condition, a dropped term, an exchanged minimum and maximum. Left out are words, annotations, what only runs for type
checkers, what says how a figure looks rather than what it shows (`LOOKS`), and by how much a search is patient
(`PATIENCE`): these change no result. Of what remains some faults change nothing either; they count as not seen.

mutmut 3 and cosmic-ray were considered. Both run a fixed command over every mutant of a module; neither draws a seeded
sample over a folder, knows mirrored test folders, or leaves out the looks of figures, which together are most of the
lines below.
"""

from __future__ import annotations

import argparse
import ast
import copy
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
SOURCE = Path("src/gelcone")
LISTED = Path(__file__).with_name("mutations.toml")
NEEDED = ("src", "tests", "benchmarks", "examples", "docs", "pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md")
TOP = "(top)"
"""Name for the modules outside of folders."""
SLOWER = 4.0
LEAST_PATIENCE = 60.0

LOOKS = frozenset(
    (
        "alpha",
        "arrowprops",
        "bbox_to_anchor",
        "bottom",
        "capsize",
        "clip_on",
        "columnspacing",
        "depth_shade",
        "elinewidth",
        "elev",
        "azim",
        "figsize",
        "fontsize",
        "gridspec_kw",
        "ha",
        "handlelength",
        "hatch",
        "height_ratios",
        "hspace",
        "in_layout",
        "labelpad",
        "labelspacing",
        "length",
        "linewidth",
        "linewidths",
        "loc",
        "lw",
        "markersize",
        "mew",
        "ms",
        "ncols",
        "pad",
        "rasterized",
        "rotation",
        "s",
        "shrinkA",
        "shrinkB",
        "size",
        "sizes",
        "textcoords",
        "va",
        "visible",
        "width_ratios",
        "wspace",
        "zorder",
        "layout",
    )
)
"""Keywords of matplotlib that determine appearance alone."""
LOOKING = frozenset({"tick_params", "suptitle", "align_ylabels", "Stroke", "margins", "set_in_layout", "view_init"})
"""Functions whose arguments determine appearance alone."""
PATIENCE = (
    "MOST_",
    "SMALLEST",
    "TOLERANCE",
    "PATIENCE",
    "_STEPS",
    "ITERATIONS",
    "_EVERY",
    "WORTH",
    "WORK",
    "work",
    "heights",
)
"""Parts of names of constants and keywords that set the length of a search, or its cost."""

SWAPPED: dict[type, type] = {
    ast.Lt: ast.GtE,
    ast.GtE: ast.Lt,
    ast.Gt: ast.LtE,
    ast.LtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.Pow: ast.Mult,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
    ast.And: ast.Or,
    ast.Or: ast.And,
}
OPPOSITE = {"min": "max", "any": "all", "argmin": "argmax", "fmin": "fmax", "minimum": "maximum", "nanmin": "nanmax"}
OPPOSITE |= {"floor": "ceil", "nanargmin": "nanargmax", "sin": "cos"}
OPPOSITE |= {there: here for here, there in OPPOSITE.items()}


@dataclass(frozen=True)
class Fault:
    """A fault: the text ``old`` at a byte offset of a file, and the ``new`` text in its place."""

    file: Path
    at: int
    old: str
    new: str
    kind: str

    @property
    def folder(self) -> str:
        inside = self.file.relative_to(SOURCE).parts
        return inside[0] if len(inside) > 1 else TOP

    def applied(self, text: bytes) -> bytes:
        end = self.at + len(self.old.encode())
        assert text[self.at : end] == self.old.encode(), f"{self.file}: the text has changed"
        return text[: self.at] + self.new.encode() + text[end:]

    def lines(self, text: bytes) -> tuple[int, str, str]:
        """Number of the line, and the line before and after the fault."""
        begin = text.rfind(b"\n", 0, self.at) + 1
        end = text.find(b"\n", self.at + len(self.old.encode()))
        after = self.applied(text)[begin : end + len(self.new.encode()) - len(self.old.encode())]
        before = text[begin:end]
        return text[:begin].count(b"\n") + 1, *(" ".join(part.decode().split()) for part in (before, after))


# --- random faults ----------------------------------------------------------------------------------------------------


def random_faults(root: Path, folder: str, count: int, seed: int) -> list[Fault]:
    """Up to ``count`` faults in a folder of the program, each in another place, the same for the same seed."""
    draw = random.Random(f"{seed} {folder}")
    places = [place for file in modules(root, folder) for place in faults_of(root, file)]
    chosen: dict[tuple[Path, int], Fault] = {}
    draw.shuffle(places)
    for fault in places:
        if len(chosen) < count:
            chosen.setdefault((fault.file, fault.at), fault)
    return list(chosen.values())


def folders(root: Path) -> list[str]:
    inside = sorted(p.name for p in (root / SOURCE).iterdir() if p.is_dir() and any(p.rglob("*.py")))
    return [TOP, *(name for name in inside if not name.startswith("_"))]


def modules(root: Path, folder: str) -> list[Path]:
    where = root / SOURCE
    found = where.glob("*.py") if folder == TOP else (where / folder).rglob("*.py")
    return sorted(path.relative_to(root) for path in found)


def faults_of(root: Path, file: Path) -> list[Fault]:
    """Every fault that can be put into a module."""
    text = (root / file).read_bytes()
    starts = [0]
    for line in text.splitlines(keepends=True):
        starts.append(starts[-1] + len(line))
    faults = []
    for node, changed, kind in _changes(ast.parse(text)):
        at = starts[node.lineno - 1] + node.col_offset
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        old = text[at : starts[node.end_lineno - 1] + node.end_col_offset].decode()
        new = ast.unparse(changed)
        if new != ast.unparse(node):
            faults.append(Fault(file, at, old, new if isinstance(node, ast.keyword) else f"({new})", kind))
    return faults


def _changes(tree: ast.AST) -> Iterator[tuple[ast.expr, ast.expr, str]]:
    """Expressions with their replacements."""
    for node in _considered(tree):
        yield from ((node, new, kind) for new, kind in _faulty(node))


def _considered(node: ast.AST) -> Iterator[ast.expr]:
    """Expressions below a node that are worth a fault."""
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "returns", "decorator_list", "bases") or isinstance(node, (ast.Raise, ast.JoinedStr)):
            continue
        children = value if isinstance(value, list) else [value]
        if isinstance(node, ast.Call) and _name(node.func) == "styled" and name == "args":
            children = children[2:]  # width and height
        for child in children:
            if not isinstance(child, ast.AST) or _left_out(child):
                continue
            if isinstance(child, ast.expr):
                yield child
            yield from _considered(child)


def _left_out(node: ast.AST) -> bool:
    if isinstance(node, ast.keyword):
        return node.arg in LOOKS or any(part in str(node.arg) for part in PATIENCE)
    if isinstance(node, (ast.Assign, ast.AnnAssign)):
        first = node.targets[0] if isinstance(node, ast.Assign) else node.target
        if isinstance(first, ast.Name) and (first.id == "__all__" or any(part in first.id for part in PATIENCE)):
            return True
    if isinstance(node, ast.If):
        return isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"
    return isinstance(node, ast.Call) and _name(node.func) in LOOKING


def _name(function: ast.expr) -> str:
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")


def _faulty(node: ast.expr) -> Iterator[tuple[ast.expr, str]]:
    """Possible replacements of an expression."""
    if isinstance(node, ast.Compare) and len(node.ops) == 1:
        new = copy.deepcopy(node)
        new.ops = [SWAPPED[type(node.ops[0])]()]
        yield new, "comparison"
    elif isinstance(node, ast.BinOp) and not _of_words(node):
        if type(node.op) in SWAPPED:
            new_sum = copy.deepcopy(node)
            new_sum.op = SWAPPED[type(node.op)]()
            yield new_sum, "operator"
        if isinstance(node.op, (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.BitAnd, ast.BitOr)):
            yield node.left, "dropped term"
    elif isinstance(node, ast.BoolOp):
        other = copy.deepcopy(node)
        other.op = SWAPPED[type(node.op)]()
        yield other, "logic"
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.Not, ast.Invert)):
        yield node.operand, "sign"
    elif isinstance(node, ast.IfExp):
        yield ast.IfExp(node.test, node.orelse, node.body), "condition"
    elif isinstance(node, ast.Constant):
        yield from _other_constant(node.value)
    elif isinstance(node, ast.Call):
        yield from _other_call(node)


def _other_constant(value: object) -> Iterator[tuple[ast.expr, str]]:
    if isinstance(value, bool):
        yield ast.Constant(not value), "constant"
    elif isinstance(value, int):
        yield ast.Constant(value + 1 if abs(value) < 10 else 2 * value), "constant"
    elif isinstance(value, float):
        yield ast.Constant(1.5 * value if value else 1.0), "constant"


def _other_call(node: ast.Call) -> Iterator[tuple[ast.expr, str]]:
    name = _name(node.func)
    if name in OPPOSITE:
        new = copy.deepcopy(node)
        if isinstance(new.func, ast.Attribute):
            new.func.attr = OPPOSITE[name]
        elif isinstance(new.func, ast.Name):
            new.func.id = OPPOSITE[name]
        yield new, "opposite"
    if name in ("abs", "sqrt", "square", "sorted", "bool", "log"):
        yield node.args[0], "dropped function"
    if name in ("where", "plot", "axvspan", "axhspan", "fill_between", "pcolormesh") and len(node.args) >= 2:
        exchanged = copy.deepcopy(node)
        exchanged.args[-2:] = exchanged.args[:-3:-1]
        yield exchanged, "exchanged arguments"


def _of_words(node: ast.BinOp) -> bool:
    return any(
        isinstance(n, ast.JoinedStr) or (isinstance(n, ast.Constant) and isinstance(n.value, str))
        for n in ast.walk(node)
    )


# --- listed faults ----------------------------------------------------------------------------------------------------


def listed_faults(root: Path, listed: Path = LISTED) -> list[Fault]:
    """The faults of the list; each old text must occur exactly once in its file."""
    faults = []
    for entry in tomllib.loads(listed.read_text(encoding="utf-8"))["fault"]:
        file = SOURCE / entry["file"]
        text = (root / file).read_bytes()
        old = entry["old"]
        if text.count(old.encode()) != 1:
            raise SystemExit(f"{listed.name}: {file} holds {text.count(old.encode())} times, not once: {old}")
        faults.append(Fault(file, text.index(old.encode()), old, entry["new"], "listed"))
    return faults


# --- running the tests ------------------------------------------------------------------------------------------------


class Copy:
    """A temporary copy of the tree in which the tests run."""

    def __init__(self, root: Path, where: Path):
        self.where = where
        for name in NEEDED:
            path = root / name
            if path.is_dir():
                shutil.copytree(path, where / name, ignore=shutil.ignore_patterns("__pycache__", "*.nc"))
            elif path.exists():
                shutil.copy2(path, where / name)
        self.needed: dict[tuple[str, ...], float] = {}

    def sees(self, fault: Fault) -> bool:
        """Whether the tests of the fault's folder fail with it."""
        path = self.where / fault.file
        text, runs = path.read_bytes(), self._runs(fault)
        if not runs:
            return False
        patience = self._patience(fault, runs)
        try:
            path.write_bytes(fault.applied(text))
            return any(not self._passes(run, patience) for run in runs)
        finally:
            path.write_bytes(text)
            # The same size within the same second would pass for the same source.
            for stale in path.parent.glob(f"__pycache__/{path.stem}.*"):
                stale.unlink(missing_ok=True)

    def _runs(self, fault: Fault) -> list[tuple[str, ...]]:
        """Arguments of pytest: the fault's own test file, then the other tests of its folder."""
        inside = fault.file.relative_to(SOURCE)
        folder = Path("tests") / inside.parts[0] if fault.folder != TOP else Path("tests")
        own = sorted((self.where / "tests" / inside.parent).glob(f"test_{inside.stem}*.py"))
        own = [path.relative_to(self.where) for path in own]
        rest = [] if fault.folder == TOP else [str(folder), *(f"--ignore={path}" for path in own)]
        if fault.folder != TOP and not any((self.where / folder).rglob("test_*.py")):
            rest = []
        return [run for run in (tuple(map(str, own)), tuple(rest)) if run]

    def _patience(self, fault: Fault, runs: list[tuple[str, ...]]) -> float:
        """Seconds for a run of tests, from the time that they need without a fault; ends if they fail then."""
        tests = runs[0] if fault.folder == TOP else (str(Path("tests") / fault.folder),)
        if tests not in self.needed:
            before = time.perf_counter()
            if not self._passes(tests, None):
                raise SystemExit(f"{' '.join(tests)}: fails without any fault")
            self.needed[tests] = time.perf_counter() - before
        return max(LEAST_PATIENCE, SLOWER * self.needed[tests])

    def _passes(self, run: tuple[str, ...], patience: float | None) -> bool:
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "-n", "0", *run]
        environment = os.environ | {"PYTHONPATH": str(self.where / "src")}
        try:
            done = subprocess.run(command, cwd=self.where, env=environment, capture_output=True, timeout=patience)
        except subprocess.TimeoutExpired:
            return False
        return done.returncode in (0, 5)  # 5: nothing to run


def measured(faults: list[Fault], root: Path) -> dict[Fault, bool]:
    """Each fault with whether it was seen; unseen ones are printed as they come."""
    seen: dict[Fault, bool] = {}
    with tempfile.TemporaryDirectory(prefix="gelcone-mutation-") as where:
        tree = Copy(root, Path(where))
        for number, fault in enumerate(faults, start=1):
            seen[fault] = tree.sees(fault)
            print(f"{number} of {len(faults)}, {sum(seen.values())} seen", end="\r", file=sys.stderr, flush=True)
            if not seen[fault]:
                print(f"not seen: {described(fault, root)}", flush=True)
    return seen


def described(fault: Fault, root: Path) -> str:
    number, before, after = fault.lines((root / fault.file).read_bytes())
    return f"{fault.file.relative_to(SOURCE)}:{number} ({fault.kind})\n    - {before}\n    + {after}"


def table(seen: dict[Fault, bool]) -> str:
    """The share of seen faults by folder."""
    whole = Counter(fault.folder for fault in seen)
    found = Counter(fault.folder for fault, was in seen.items() if was)
    rows = [
        f"{folder:12s} {found[folder]:4d} of {count:4d}  {found[folder] / count:5.0%}"
        for folder, count in sorted(whole.items())
    ]
    total = f"{'all':12s} {found.total():4d} of {whole.total():4d}  {found.total() / max(whole.total(), 1):5.0%}"
    return "\n".join([*rows, total])


def main(arguments: list[str] | None = None, root: Path = ROOT) -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--folder", action="append", help="folder of src/gelcone, more than once if wanted; default all"
    )
    parser.add_argument("--count", type=int, default=40, help="random faults a folder (default 40)")
    parser.add_argument("--seed", type=int, default=0, help="default 0")
    parser.add_argument("--listed", action="store_true", help="the faults of mutations.toml instead of random ones")
    parser.add_argument("--show", action="store_true", help="print the faults and run nothing")
    parser.add_argument("--least", type=float, default=0.85, help="share below which the exit code is 1 (default 0.85)")
    asked = parser.parse_args(arguments)
    wanted = asked.folder or folders(root)
    unknown = set(wanted) - set(folders(root))
    if unknown:
        parser.error(f"no folder {', '.join(sorted(unknown))}; there are {', '.join(folders(root))}")
    if asked.listed:
        faults = [fault for fault in listed_faults(root) if fault.folder in wanted]
    else:
        faults = [fault for folder in wanted for fault in random_faults(root, folder, asked.count, asked.seed)]
    if asked.show:
        print("\n".join(described(fault, root) for fault in faults))
        return 0
    seen = measured(faults, root)
    print(table(seen))
    return 0 if sum(seen.values()) >= asked.least * len(seen) else 1


if __name__ == "__main__":
    sys.exit(main())
