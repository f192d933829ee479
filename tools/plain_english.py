"""Check the prose of the sources against the rules of CONTRIBUTING: words, and how docstrings begin.

    python tools/plain_english.py              (ends with 1 if something is found)

Docstrings, texts and comments are searched for `WORDS`, and names for the word told. Public functions, classes and
modules need a docstring, but methods inherit that of a base class; none, private ones too, begins with `BEGINNINGS`.
"""

from __future__ import annotations

import ast
import re
import sys
import tokenize
from collections.abc import Iterator
from functools import cache
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src" / "gelcone"
WORDS = {
    r"told|tells?": "reported, states, reports",
    r"beside": "next to, with, in addition",
    r"go(?:es)? on|went on": "continues",
    r"so (?:many|much|few)": "the number itself",
    r"kept": "stored, unchanged",
    r"looks? (?:at|for)|looked (?:at|for)": "compute, search, read",
    r"seen to": "observed to",
    r"(?<!there )(?:is|are) no\b(?! (?:longer|more than))": "is not a",
}
"""What is not written (a regular expression between word boundaries), and what is written instead."""
BEGINNINGS = re.compile(
    r"(?:What|Of|How|That|Where|Whose|Which|Whether it|Than|So|As|With|For|In|By|To|And|Or|But|If|When|Its|The same)\b"
)
"""A docstring stands alone, a private one too: it begins with a verb or names the thing."""


def findings(path: Path) -> Iterator[tuple[int, str]]:
    """The lines of a file that break a rule, and the rule."""
    with path.open("rb") as content:
        for token in tokenize.tokenize(content.readline):
            if token.type == tokenize.NAME and "told" in token.string.split("_"):
                yield token.start[0], f"the name {token.string!r}; write what it holds"
            if token.type in (tokenize.STRING, tokenize.COMMENT, getattr(tokenize, "FSTRING_MIDDLE", -1)):
                yield from _words(token.string, token.start[0])
    yield from _docstrings(ast.parse(path.read_bytes()))


def _statements(module: ast.Module) -> Iterator[ast.AST]:
    """A module and all that it defines, at any depth; most of the nodes of `ast.walk` are expressions."""
    found: list[ast.AST] = [module]
    for node in found:  # which grows
        yield node
        for name in ("body", "orelse", "finalbody", "handlers", "cases"):
            found += getattr(node, name, ())


def _words(text: str, line: int) -> Iterator[tuple[int, str]]:
    for pattern, instead in WORDS.items():
        for found in re.finditer(rf"\b(?:{pattern})\b", text, flags=re.IGNORECASE):
            yield line + text[: found.start()].count("\n"), f"{found[0]!r}; write {instead}"


def _docstrings(module: ast.Module) -> Iterator[tuple[int, str]]:
    for node, owner in [(module, None), *_public(module)]:
        docstring = ast.get_docstring(node)
        if docstring is None and owner is not None and _inherits(owner, node.name):
            continue
        line = getattr(node, "lineno", 1)
        if docstring is None:
            yield line, f"{getattr(node, 'name', 'the module')} has no docstring"
    for node in _statements(module):
        documented = isinstance(node, ast.Module | ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef)
        if documented and BEGINNINGS.match(docstring := ast.get_docstring(node) or ""):
            line = getattr(node, "lineno", 1)
            yield line, f"a docstring begins with {docstring.split(maxsplit=1)[0]!r}; let it stand alone"


def _inherits(owner: ast.AST, name: str) -> bool:
    """Whether a base of a class, or one of its bases, documents a method of this name."""
    bases = [base.id for base in getattr(owner, "bases", ()) if isinstance(base, ast.Name)]
    known = [one for base in bases for one in _classes().get(base, ())]
    return any(
        _inherits(base, name)
        or any(getattr(method, "name", "") == name and ast.get_docstring(method) for method in base.body)
        for base in known
    )


@cache
def _classes() -> dict[str, list[ast.ClassDef]]:
    """Name -> the classes of that name in the sources."""
    found: dict[str, list[ast.ClassDef]] = {}
    for path in SOURCE.rglob("*.py"):
        for node in _statements(ast.parse(path.read_bytes())):
            if isinstance(node, ast.ClassDef):
                found.setdefault(node.name, []).append(node)
    return found


def _public(parent: ast.AST) -> Iterator[tuple[ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef, ast.AST]]:
    """Find public functions, classes and their public methods, each with what it belongs to."""
    for node in ast.iter_child_nodes(parent):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            yield node, parent
            if isinstance(node, ast.ClassDef):
                yield from _public(node)


def main() -> int:
    """Print the findings in all modules; 1 if there are any."""
    files = sorted(SOURCE.rglob("*.py"))
    found = [f"{path.relative_to(SOURCE)}:{line}: {what}" for path in files for line, what in findings(path)]
    print("\n".join(found) or f"{len(files)} files: nothing found")
    return int(bool(found))


if __name__ == "__main__":
    sys.exit(main())
