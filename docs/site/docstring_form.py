"""The docstrings of this house in the form that numpydoc reads, made when the site is built.

``name : meaning`` becomes name and meaning, "Returns" gets the type of the annotation, and a name in single backticks
leads to its page where it is public and is plain code elsewhere.
"""

from __future__ import annotations

import re
from typing import Any

import gelcone

ENTRY = re.compile(r"^(?P<names>\*{0,2}\w+(?:, \*{0,2}\w+)*) : (?P<text>.*)$")
UNDERLINE = re.compile(r"^-{3,}$")
CODE = re.compile(r"(?<![`:\w])`([^`\n]+)`(?![`_])")
TYPES = {"xr.Dataset": "xarray.Dataset"}


def capital(text: str) -> str:
    """A text with a capital, unless it begins with a name."""
    return text[:1].upper() + text[1:] if not re.match(r"^\w+[_(.=]", text) else text


def linked(match: re.Match[str]) -> str:
    """A link to a public name, or code."""
    name = match[1].removeprefix("gelcone.")
    public = name.partition(".")[0] in dir(gelcone) and "." not in name
    return f":doc:`{name} </reference/api/{name}>`" if public else f"``{match[1]}``"


def process(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    """Rewrite the lines of a docstring in place."""
    returns = str(getattr(thing, "__annotations__", {}).get("return", "object"))
    out: list[str] = []
    section = ""
    for k, line in enumerate(lines):
        if k + 1 < len(lines) and UNDERLINE.match(lines[k + 1]):
            section, first = line.strip(), True
            out.append(line)
        elif section in ("Parameters", "Attributes", "Raises") and (found := ENTRY.match(line)):
            out += [found["names"], "    " + capital(found["text"])]
        elif section == "Returns" and line and not UNDERLINE.match(line):
            out += [TYPES.get(returns, returns)] if first else []
            out.append("    " + (capital(line) if first else line))
            first = False
        else:
            out.append(line)
    lines[:] = [line if line.lstrip().startswith((">>>", "...")) else plain(line) for line in out]


def plain(line: str) -> str:
    """A line whose names are linked, and whose sizes such as |x| are no substitutions."""
    return CODE.sub(linked, re.sub(r"(?<!`)\|([^|`\n]+)\|(?!`)", r"\|\1\|", line))


def setup(app: Any) -> dict[str, Any]:
    """Run before numpydoc, which reads what this writes."""
    app.connect("autodoc-process-docstring", process, priority=400)
    return {"parallel_read_safe": True, "version": gelcone.__version__}
