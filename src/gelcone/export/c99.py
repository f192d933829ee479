"""C99 from the text that the integrator writes at width 1, instruction by instruction.

Each instruction becomes one expression of the same operation on the same numbers, so that a compiler that neither
contracts nor reorders floating-point arithmetic - any that keeps to C99 - gives the bits of gelcone. Memory is made of
8-byte words that hold a double, an integer or an address.
"""

from __future__ import annotations

import re
import struct
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NoReturn

HELPERS = {
    "bits_of": "static int64_t bits_of(double value) { word own; own.d = value; return own.i; }",
    "real_of": "static double real_of(int64_t value) { word own; own.i = value; return own.d; }",
    "lowest_bit": "static int64_t lowest_bit(int64_t value) {\n  int64_t n = 0;\n  uint64_t left = (uint64_t)value;\n"
    "  while (left && !(left & 1u)) { left >>= 1; ++n; }\n  return n;\n}",
    "count_bits": "static int64_t count_bits(int64_t value) {\n  int64_t n = 0;\n  uint64_t left = (uint64_t)value;\n"
    "  for (; left; left &= left - 1) ++n;\n  return n;\n}",
    "fetch_add": "static int64_t fetch_add(word *at, int64_t more) { int64_t old = at->i; at->i = old + more; "
    "return old; }",
}
"""Functions that the translated text may call, by name."""
_TYPES = {"double": "double", "i64": "int64_t", "i1": "int", "ptr": "word *", "void": "void"}
_MEMBERS = {"double": "d", "i64": "i", "ptr": "p"}
_COMPARED = {
    "olt": "{} < {}", "ole": "{} <= {}", "ogt": "{} > {}", "oge": "{} >= {}", "oeq": "{} == {}", "une": "{} != {}",
    "ult": "!({} >= {})", "ule": "!({} > {})", "ugt": "!({} <= {})", "uge": "!({} < {})",
    "uno": "({0} != {0} || {1} != {1})",
    "eq": "{} == {}", "ne": "{} != {}", "slt": "{} < {}", "sle": "{} <= {}", "sgt": "{} > {}", "sge": "{} >= {}",
}  # fmt: skip
_REAL = {"fadd": "+", "fsub": "-", "fmul": "*", "fdiv": "/"}
_WHOLE = {"add": "+", "sub": "-", "mul": "*", "and": "&", "or": "|", "xor": "^", "shl": "<<", "lshr": ">>"}
_INTRINSICS = {
    "llvm.fma.f64": "fma",
    "llvm.sqrt.f64": "sqrt",
    "llvm.fabs.f64": "fabs",
    "llvm.cttz.i64": "lowest_bit",
    "llvm.ctpop.i64": "count_bits",
}
_CASTS = {
    ("i1", "i64"): "(int64_t){}",
    ("i64", "i1"): "(int)({} & 1)",
    ("double", "i64"): "bits_of({})",
    ("i64", "double"): "real_of({})",
    ("i1", "i1"): "{}",
}
_HEAD = re.compile(r"define (?:internal )?(\w+) @(\w+)\((.*)\) (?:noinline )?\{")
_NAME = re.compile(r"%[\w.]+")


@dataclass
class _Instruction:
    """An instruction in a ``block``: the ``name`` of its result or None, its ``word``, and the ``rest`` of its text."""

    block: str
    name: str | None
    word: str
    rest: str

    @property
    def pure(self) -> bool:
        """Whether the instruction has no effect but its value."""
        is_harmless = re.match(r"\w+ @(llvm\.\w+)", self.rest) if self.word == "call" else self.word != "atomicrmw"
        return self.name is not None and bool(is_harmless)


@dataclass
class _Function:
    """A function that is being translated."""

    head: str
    arguments: list[tuple[str, str]]
    instructions: list[_Instruction]
    addresses: dict[str, tuple[str, str]] = field(default_factory=dict)
    phis: dict[str, list[tuple[str, str, str]]] = field(default_factory=dict)
    called: set[str] = field(default_factory=set)


def translate(text: str, names: dict[str, str]) -> list[tuple[str, str]]:
    """Translate the functions of a module to declarations and bodies in C; ``names`` renames some of them."""
    parts = re.findall(r"^define .*?^\}$", text, flags=re.M | re.S)
    return [_written(_read(part, names), names) for part in parts]


def helpers(bodies: str) -> str:
    """The helpers that some bodies call."""
    return "\n".join(text for name, text in HELPERS.items() if f"{name}(" in bodies)


def _read(text: str, names: dict[str, str]) -> _Function:
    """Read the instructions of a definition, without those whose values are not used."""
    first, *lines = text.splitlines()
    match = _HEAD.fullmatch(first)
    if match is None:
        raise ValueError(f"not translated: {first}")
    kind, name, inside = match.groups()
    arguments = []
    for part in inside.split(", ") if inside else []:
        type_, argument = part.replace("noalias ", "").split(" ")
        arguments.append((_TYPES[type_], _c_name(argument)))
    listed = ", ".join(f"{type_}{'' if type_.endswith('*') else ' '}{argument}" for type_, argument in arguments)
    own_head = f"static {_TYPES[kind]} {names.get(name, name)}({listed or 'void'})"
    block, instructions = "", []
    for line in (line.strip() for line in lines[:-1]):
        if re.fullmatch(r"[\w.]+:", line):
            block = line[:-1]
            instructions.append(_Instruction(block, None, "label", block))
        elif line:
            own_name, _, rest = line.rpartition(" = ") if line.startswith("%") else ("", "", line)
            word, _, rest = rest.partition(" ")
            instructions.append(_Instruction(block, own_name or None, word, rest))
    return _Function(own_head, arguments, _living(instructions))


def _living(instructions: list[_Instruction]) -> list[_Instruction]:
    """Leave out instructions without effects whose values are not used."""
    made = {instruction.name: instruction for instruction in instructions if instruction.name and instruction.pure}
    uses = Counter(name for instruction in instructions for name in _NAME.findall(instruction.rest))
    waiting = [name for name in made if not uses[name]]
    dead = set()
    while waiting:
        name = waiting.pop()
        dead.add(name)
        for part in _NAME.findall(made[name].rest):
            uses[part] -= 1
            if part in made and not uses[part] and part not in dead:
                waiting.append(part)
    return [instruction for instruction in instructions if instruction.name not in dead]


def _written(f: _Function, names: dict[str, str]) -> tuple[str, str]:
    """Write the declaration and the body of a function in C."""
    for own in f.instructions:
        if own.word == "getelementptr":
            base, index = own.rest.removeprefix("double, ptr ").split(", i64 ")
            f.addresses[str(own.name)] = (base, index)
        elif own.word == "phi":
            for value, block in re.findall(r"\[ ([^,]+), %([\w.]+) \]", own.rest):
                f.phis.setdefault(own.block, []).append((_c_name(str(own.name)), value, block))
        elif own.word == "call" and (match := re.match(r"void (%[\w.]+)\(", own.rest)):
            f.called.add(match[1])
    taken = {name for own in f.instructions for name in _NAME.findall(own.rest)}
    lines = [f"(void){own};" for _, own in f.arguments if f"%{own}" not in taken]
    lines += [f"int64_t {own} = 0;" for own in dict.fromkeys(own for every in f.phis.values() for own, _, _ in every)]
    labels = _labels(f)
    for position, own in enumerate(f.instructions):
        following = f.instructions[position + 1] if position + 1 < len(f.instructions) else None
        lines += _statements(f, own, following, labels, names)
    return f"{f.head};", "\n".join([f"{f.head} {{", *(f"  {line}" for line in lines), "}", ""])


def _labels(f: _Function) -> set[str]:
    """The labels of jumps, except those directly after their jump."""
    labels = set()
    for index, instruction in enumerate(f.instructions):
        if instruction.word == "br":
            targets = re.findall(r"label %([\w.]+)", instruction.rest)
            behind = f.instructions[index + 1].rest if index + 1 < len(f.instructions) else ""
            labels |= {target for target in targets if target != behind}
    return labels


def _statements(
    f: _Function, own: _Instruction, following: _Instruction | None, wanted: set[str], names: dict[str, str]
) -> list[str]:
    """The lines of C of one instruction."""
    if own.word == "label":
        return [f"{_c_name(own.rest)}: ;"] if own.rest in wanted else []
    if own.word == "br":
        return _jump(f, own, "" if following is None else following.rest)
    if own.word == "ret":
        value = own.rest.partition(" ")[2]
        return [f"return {_value(f, value)};" if value else "return;"]
    if own.word in ("getelementptr", "phi"):
        return []
    if own.word == "alloca":
        match = re.fullmatch(r"double, i64 (\d+)(?:, align \d+)?", own.rest)
        if match is None:
            _refused(own)
        begun = " = {{0.0}}" if match[1] == "1" else ""  # compilers cannot see that it is set before it is read
        return [f"word {_c_name(str(own.name))}[{match[1]}]{begun};"]
    if own.word == "store":
        kind, value, address = _taken(own, r"(\w+) (\S+), ptr ([^,]+)(?:, align \d+)?")
        return [f"{_member(f, address, _MEMBERS[kind])} = {_value(f, value)};"]
    kind, text = _expression(f, own, names)
    if own.name is None:
        return [f"{text};"]
    declared = "function " if own.name in f.called else f"{kind} " if not kind.endswith("*") else kind
    return [f"{'' if kind.endswith('*') else 'const '}{declared}{_c_name(own.name)} = {text};"]


def _jump(f: _Function, own: _Instruction, behind: str) -> list[str]:
    """The lines of C of a branch; values that it passes to loop variables are set first."""

    def to(label: str) -> list[str]:
        given = [f"{name} = {_value(f, value)};" for name, value, block in f.phis.get(label, []) if block == own.block]
        return given if label == behind else [*given, f"goto {_c_name(label)};"]

    labels = re.findall(r"label %([\w.]+)", own.rest)
    if len(labels) == 1:
        return to(labels[0])
    condition = _value(f, own.rest.removeprefix("i1 ").split(", ")[0])
    first, second = (to(label) for label in labels)
    if not first:
        return [f"if (!({condition})) {{ {' '.join(second)} }}"] if second else []
    lines = [f"if ({condition}) {{ {' '.join(first)} }}"]
    return lines + ([" ".join(second)] if second else [])


def _expression(f: _Function, own: _Instruction, names: dict[str, str]) -> tuple[str, str]:
    """Type and text of an expression."""
    word, rest = own.word, own.rest
    if word in _REAL:
        a, b = _values(f, rest.removeprefix("double "))
        return "double", f"{a} {_REAL[word]} {b}"
    if word == "fneg":
        return "double", f"-{_value(f, rest.removeprefix('double '))}"
    if word in _WHOLE or word == "ashr":
        kind, _, operands = rest.partition(" ")
        a, b = _values(f, operands)
        if kind == "i1":
            return "int", f"{a} {_WHOLE[word]} {b}"
        if word == "ashr":
            return "int64_t", f"{a} >> {b}"
        return "int64_t", f"(int64_t)((uint64_t){a} {_WHOLE[word]} (uint64_t){b})"
    if word in ("fcmp", "icmp"):
        relation, a, b = _taken(own, r"(\w+) \w+ (\S+), (\S+)")
        return "int", _COMPARED[relation].format(_value(f, a), _value(f, b))
    if word == "select":
        condition, kind, a, b = _taken(own, r"i1 (\S+), (\w+) (\S+), \w+ (\S+)")
        return _TYPES[kind], f"{_value(f, condition)} ? {_value(f, a)} : {_value(f, b)}"
    if word in ("zext", "trunc", "bitcast"):
        kind, value, target = _taken(own, r"(\w+) (\S+) to (\w+)")
        return _TYPES[target], _CASTS[kind, target].format(_value(f, value))
    if word == "load":
        kind, address = _taken(own, r"(\w+), ptr ([^,]+)(?:, align \d+)?")
        return _TYPES[kind], _member(f, address, "f" if own.name in f.called else _MEMBERS[kind])
    if word == "atomicrmw":
        address, count = _taken(own, r"add ptr (\S+), i64 (\S+) monotonic")
        return "int64_t", f"fetch_add({_value(f, address)}, {_value(f, count)})"
    return _call(f, own, names) if word == "call" else _refused(own)


def _call(f: _Function, own: _Instruction, names: dict[str, str]) -> tuple[str, str]:
    kind, name, inside = _taken(own, r"(\w+) ([@%][\w.]+)\((.*)\)")
    given = [part.replace("noalias ", "").partition(" ") for part in inside.split(", ")] if inside else []
    values = [_value(f, value) for _, _, value in given]
    if name[1:] in _INTRINSICS:
        wanted = values[:1] if name.endswith(".i64") else values
        return _TYPES[kind], f"{_INTRINSICS[name[1:]]}({', '.join(wanted)})"
    if name.startswith("%"):
        types = ", ".join(_TYPES[type_] for type_, _, _ in given)
        return _TYPES[kind], f"((void (*)({types})){_c_name(name)})({', '.join(values)})"
    return _TYPES[kind], f"{names.get(name[1:], name[1:])}({', '.join(values)})"


def _taken(own: _Instruction, pattern: str) -> Sequence[str]:
    match = re.fullmatch(pattern, own.rest)
    return match.groups() if match else _refused(own)


def _refused(own: _Instruction) -> NoReturn:
    raise ValueError(f"not translated: {own.word} {own.rest}")


def _values(f: _Function, text: str) -> list[str]:
    return [_value(f, part) for part in text.split(", ")]


def _value(f: _Function, text: str) -> str:
    """The text of an operand."""
    if text in f.addresses:
        base, index = f.addresses[text]
        return f"({_value(f, base)} + {_value(f, index)})"
    if text.startswith("%"):
        return _c_name(text)
    if text.startswith("0x"):
        return real_text(struct.unpack("<d", struct.pack("<Q", int(text, 16)))[0])
    if text.startswith("-"):
        return f"({text})"
    return {"true": "1", "false": "0"}.get(text, text)


def real_text(number: float) -> str:
    """Write a double as a constant of C that reads back exactly."""
    if number != number:
        return "NAN"
    if number in (float("inf"), float("-inf")):
        return "INFINITY" if number > 0 else "(-INFINITY)"
    text = repr(number)
    return f"({text})" if text.startswith("-") else text


def _member(f: _Function, address: str, member: str) -> str:
    """The member of a word at an address."""
    if address in f.addresses:
        base, index = f.addresses[address]
        return f"{_value(f, base)}[{_value(f, index)}].{member}"
    return f"{_value(f, address)}->{member}"


def _c_name(name: str) -> str:
    return name.removeprefix("%").replace(".", "_")
