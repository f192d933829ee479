"""The words and the quantity of every variable that a folder of the program labels, read from its sources."""

import ast
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src" / "gelcone"
QUANTITIES = frozenset(
    {
        "code", "count", "energy", "field", "flag", "force", "frequency", "length", "parameter", "rate", "share",
        "stiffness", "time", "voltage",
    }
)  # fmt: skip


def described_in(folder):
    """A line ``module: name: words: quantity`` for each ``"name": (values, "words", "quantity")``."""
    return sorted(
        f"{path.stem}: {_text(key)}: {_text(value.elts[-2])}: {value.elts[-1].value}"
        for path in (SOURCE / folder).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Dict)
        for key, value in zip(node.keys, node.values, strict=True)
        if key is not None and _describes(value)
    )


def _describes(value):
    """Whether a value of a dict is a variable: some values, then its words and its quantity."""
    if not isinstance(value, ast.Tuple) or len(value.elts) not in (3, 4):
        return False
    *values, _, quantity = value.elts
    named = isinstance(quantity, ast.Constant) and quantity.value in QUANTITIES
    return named and not all(isinstance(own, ast.Constant) for own in values)


def _text(node):
    """A text, with the expressions in it as they are written."""
    if isinstance(node, ast.Constant):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(_text(part) for part in node.values)
    return f"{{{ast.unparse(getattr(node, 'value', node))}}}"
