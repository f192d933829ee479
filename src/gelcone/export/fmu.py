"""A device as an FMU: C sources, a description of its variables, and the library for this machine, in one zip file."""

from __future__ import annotations

import hashlib
import platform
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple
from xml.sax.saxutils import quoteattr

from gelcone._version import __version__
from gelcone.errors import InputError, check_name
from gelcone.export.compiler import compile_library, cross_compiler, find_compiler
from gelcone.export.sources import RATE, Exported, Variable, filled, sources
from gelcone.files import write_whole

VERSIONS = (2, 3)
BASES = ("kg", "m", "s", "A")
UNITS: Mapping[str, tuple[int, int, int, int]] = {
    "1": (0, 0, 0, 0), "m": (0, 1, 0, 0), "kg": (1, 0, 0, 0), "s": (0, 0, 1, 0), "Hz": (0, 0, -1, 0),
    "V": (1, 2, -3, -1), "Pa": (1, -1, -2, 0), "N": (1, 1, -2, 0), "m/s": (0, 1, -1, 0), "m/s^2": (0, 1, -2, 0),
    "N/m^3": (1, -2, -2, 0), "N/m": (1, 0, -2, 0), "N s/m": (1, 0, -1, 0), "V/m": (1, 1, -3, -1), "A": (0, 0, 0, 1),
    "F": (-1, -2, 4, 2), "C": (0, 0, 1, 1), "ohm": (1, 2, -3, -2), "J": (1, 2, -2, 0), "W": (1, 2, -3, 0),
    "V/s": (1, 2, -4, -1), "N/s": (1, 1, -3, 0), "1/s": (0, 0, -1, 0), "A/s": (0, 0, -1, 1),
}  # fmt: skip
"""Exponents of kg, m, s and A in each unit."""
HOST = "host"


class Platform(NamedTuple):
    """A machine: its folders in FMI 2.0 ("" for none) and 3.0, the suffix of libraries, and the compiler's target."""

    second: str
    third: str
    ending: str
    target: str


PLATFORMS: Mapping[str, Platform] = {
    "linux": Platform("linux64", "x86_64-linux", ".so", "x86_64-linux-gnu.2.17"),
    "linux-arm": Platform("", "aarch64-linux", ".so", "aarch64-linux-gnu.2.17"),
    "windows": Platform("win64", "x86_64-windows", ".dll", "x86_64-windows-gnu"),
    "macos": Platform("darwin64", "x86_64-darwin", ".dylib", "x86_64-macos"),
    "macos-arm": Platform("", "aarch64-darwin", ".dylib", "aarch64-macos"),
}
_SYSTEMS = {"Linux": "linux", "Darwin": "macos", "Windows": "windows"}
_MACHINES = {"x86_64": "", "amd64": "", "aarch64": "-arm", "arm64": "-arm"}
Numbered = Sequence[tuple[int, Variable]]
_DATE = (1980, 1, 1, 0, 0, 0)


def write_fmu(exported: Exported, path: Path, fmi: int, platforms: Sequence[str], force: bool) -> bool:
    """Write the file, whole or not at all; return whether it contains libraries for all ``platforms``."""
    compilers = _compilers(exported.name, fmi, platforms)

    def write(temporary: Path) -> None:
        texts = _contents(exported, fmi)
        source_texts = {Path(name).name: text for name, text in texts.items() if name.startswith("sources/")}
        contents = {name: text.encode() for name, text in texts.items()}
        contents |= {
            file_name: compile_library(compiler, source_texts, f"fmi{fmi}.c")
            for file_name, compiler in compilers.items()
        }
        with zipfile.ZipFile(temporary, "w", zipfile.ZIP_DEFLATED) as archive:
            for name, data in sorted(contents.items()):
                entry = zipfile.ZipInfo(name, _DATE)
                entry.compress_type, entry.external_attr = zipfile.ZIP_DEFLATED, 0o644 << 16
                archive.writestr(entry, data)

    write_whole(path, write, force=force)
    return len(compilers) == len(set(platforms))


def _compilers(name: str, fmi: int, platforms: Sequence[str]) -> dict[str, list[str]]:
    """Name of each library in the file -> its compiler; this machine's library is left out without a compiler."""
    compilers: dict[str, list[str]] = {}
    host = _SYSTEMS.get(platform.system(), "") + _MACHINES.get(platform.machine().lower(), "?")
    for platform_name in platforms:
        check_name("platform", platform_name, [HOST, *PLATFORMS])
        known = PLATFORMS.get(host if platform_name == HOST else platform_name)
        folder = "" if known is None else known.second if fmi == 2 else known.third
        if known is not None and not folder and platform_name != HOST:
            raise InputError(f"platforms {platform_name!r}: has no place in FMI 2.0; give fmi = 3")
        compiler = find_compiler() if platform_name == HOST else cross_compiler(PLATFORMS[platform_name].target)
        if known is not None and folder and compiler is not None:
            compilers[f"binaries/{folder}/{name}{known.ending}"] = compiler
    return compilers


def _contents(exported: Exported, fmi: int) -> dict[str, str]:
    """The texts of the file, by name."""
    source_texts = sources(exported)
    token = "{" + hashlib.sha256("".join(source_texts.values()).encode()).hexdigest()[:32] + "}"
    shared = filled("fmu.c", exported.name, {"TOKEN": f'"{token}"'})
    contents = {f"sources/{name}": text for name, text in source_texts.items()}
    contents |= {"sources/fmu.c": shared, f"sources/fmi{fmi}.c": filled(f"fmi{fmi}.c", exported.name, {})}
    contents["resources/device.toml"] = exported.device.to_toml()
    contents["modelDescription.xml"] = description(exported, fmi, token)
    if fmi == 3:
        contents["sources/buildDescription.xml"] = (
            '<?xml version="1.0" encoding="UTF-8"?>\n<fmiBuildDescription fmiVersion="3.0">\n'
            f'  <BuildConfiguration modelIdentifier="{exported.name}">\n    <SourceFileSet language="C99">'
            '<SourceFile name="fmi3.c"/></SourceFileSet>\n  </BuildConfiguration>\n</fmiBuildDescription>\n'
        )
    return contents


# --- the description --------------------------------------------------------------------------------------------------


def description(exported: Exported, fmi: int, token: str) -> str:
    """Write the text of modelDescription.xml."""
    listed = [(k, variable) for k, variable in enumerate(exported.variables) if variable.kind != "time"]
    head = _element(
        "fmiModelDescription",
        {
            "fmiVersion": f"{fmi}.0",
            "modelName": exported.name,
            ("guid" if fmi == 2 else "instantiationToken"): token,
            "description": "".join(c for c in exported.device.name if c.isprintable()),
            "generationTool": f"gelcone {__version__}",
            "variableNamingConvention": "structured",
        }
        | ({"numberOfEventIndicators": len(exported.program.border_switches)} if fmi == 2 else {}),
        closed=False,
    )
    kinds = _kinds_of_fmu(exported, fmi)
    used = {variable.unit for _, variable in listed} | {"s"}
    units = _lines(_unit(unit) for unit in UNITS if unit in used)
    numbered = listed if fmi == 3 else list(enumerate((variable for _, variable in listed), start=1))
    rows = _rows(exported, listed, numbered, fmi)
    if fmi == 3:
        rows = _rows3(exported, rows)
    structure = _structure2(numbered) if fmi == 2 else _structure3(exported, numbered)
    experiment = {"startTime": "0", "stopTime": "1", "tolerance": f"{exported.tolerance:g}", "stepSize": "0.001"}
    return (
        f'<?xml version="1.0" encoding="UTF-8"?>\n{head}\n{kinds}  <UnitDefinitions>\n{units}  </UnitDefinitions>\n'
        '  <LogCategories><Category name="logStatusError"/></LogCategories>\n'
        f"  {_element('DefaultExperiment', experiment)}\n"
        f"  <ModelVariables>\n{_lines(rows)}  </ModelVariables>\n  <ModelStructure>\n{_lines(structure)}"
        "  </ModelStructure>\n</fmiModelDescription>\n"
    )


def _element(name: str, attributes: Mapping[str, object], inside: str = "", *, closed: bool = True) -> str:
    pairs = "".join(f" {key}={quoteattr(str(value))}" for key, value in attributes.items() if value is not None)
    if not closed:
        return f"<{name}{pairs}>"
    return f"<{name}{pairs}>{inside}</{name}>" if inside else f"<{name}{pairs}/>"


def _unit(unit: str) -> str:
    powers = {base: power for base, power in zip(BASES, UNITS[unit], strict=True) if power}
    return _element("Unit", {"name": unit}, _element("BaseUnit", powers))


def _lines(rows: Iterable[str]) -> str:
    return "".join(f"    {row}\n" for row in rows)


def _kinds_of_fmu(exported: Exported, fmi: int) -> str:
    state = "FMUstate" if fmi == 2 else "FMUState"
    both = {"modelIdentifier": exported.name, f"canGetAndSet{state}": "true", f"canSerialize{state}": "true"}
    if fmi == 2:
        both |= {"canNotUseMemoryManagementFunctions": "true"}
    inside = '<SourceFiles><File name="fmi2.c"/></SourceFiles>' if fmi == 2 else ""
    steps = {"canHandleVariableCommunicationStepSize": "true"}
    if fmi == 2:
        steps |= {"canInterpolateInputs": "true"}
    exchange, stepped = _element("ModelExchange", both, inside), _element("CoSimulation", both | steps, inside)
    return f"  {exchange}\n  {stepped}\n"


def _name(own: Variable) -> str:
    """The name of a variable in an FMU; rates are der(...)."""
    return f"der({own.name.removesuffix(RATE)})" if own.kind == "rate" else own.name


def _starts(exported: Exported) -> dict[str, float]:
    z = exported.start()[0]
    scales = exported.scale_values
    states = zip(exported.system.states, z, strict=True)
    return {s.name: float(value * scales.get(s.quantity, 1.0)) for s, value in states} | dict(
        exported.parameters.values
    )


def _attributes(own: Variable, place: int) -> dict[str, object]:
    """The attributes of a variable that both versions share."""
    causality = {"input": "input", "rate": "local", "parameter": "parameter"}.get(own.kind, "output")
    variability = {"parameter": "tunable", "code": "discrete"}.get(own.kind, "continuous")
    initial = {"input": None, "state": "exact", "parameter": "exact"}.get(own.kind, "calculated")
    return {
        "name": _name(own), "valueReference": place, "description": own.meaning, "causality": causality,
        "variability": variability, "initial": initial,
    }  # fmt: skip


def _is_flag(own: Variable) -> bool:
    return own.kind == "code" and not own.name.endswith("film_state") and own.name != "outcome"


def _groups(numbered: Numbered) -> tuple[list[int], list[int], list[int]]:
    """The numbers of outputs, of rates, and of initial unknowns."""
    outputs = [number for number, variable in numbered if variable.kind in ("state", "output", "code")]
    rates = [number for number, variable in numbered if variable.kind == "rate"]
    return (
        outputs,
        rates,
        sorted([*rates, *(number for number, variable in numbered if variable.kind in ("output", "code"))]),
    )


def _rows(exported: Exported, listed: Numbered, numbered: Numbered, fmi: int) -> list[str]:
    """The variables that both versions list, ``numbered`` as the version refers to them."""
    starts, numbers = _starts(exported), {variable.name: number for number, variable in numbered}
    real, whole = ("Real", "Integer") if fmi == 2 else ("Float64", "Int32")
    rows = []
    for reference, variable in listed:
        kind = "Boolean" if _is_flag(variable) else whole if variable.kind == "code" else real
        start = 0.0 if variable.kind == "input" else starts.get(variable.name)
        shared = _attributes(variable, reference)
        typed = {
            "unit": variable.unit or None,
            "start": None if start is None else repr(start),
            "derivative": numbers[variable.name.removesuffix(RATE)] if variable.kind == "rate" else None,
        }
        if fmi == 2:
            rows.append(_element("ScalarVariable", shared, _element(kind, typed)))
        else:
            rows.append(_element(kind, shared | typed))
    return rows


def _rows3(exported: Exported, rows: list[str]) -> list[str]:
    """The variables of FMI 3.0: the time, ``rows``, and the event indicators."""
    count = len(exported.variables)
    time = {"name": "time", "valueReference": count - len(exported.parameters.values) - 1, "causality": "independent"}
    elements = [_element("Float64", time | {"variability": "continuous", "unit": "s"}), *rows]
    for k in range(len(exported.program.border_switches)):
        border = Variable(f"border_{k}", "local", "", "positive on the side of the border on which the motion is")
        attributes = _attributes(border, count + k) | {"causality": "local", "variability": "continuous"}
        elements.append(_element("Float64", attributes))
    return elements


def _structure2(numbered: Numbered) -> list[str]:
    outputs, rates, unknown = _groups(numbered)

    def each(name: str, numbers: Iterable[int]) -> str:
        return _element(name, {}, "".join(_element("Unknown", {"index": number}) for number in numbers))

    return [each("Outputs", outputs), each("Derivatives", rates), each("InitialUnknowns", unknown)]


def _structure3(exported: Exported, numbered: Numbered) -> list[str]:
    outputs, rates, unknown = _groups(numbered)
    count = len(exported.variables)
    borders = range(count, count + len(exported.program.border_switches))
    groups = {
        "Output": outputs, "ContinuousStateDerivative": rates, "InitialUnknown": unknown, "EventIndicator": borders,
    }  # fmt: skip
    return [_element(name, {"valueReference": place}) for name, places in groups.items() for place in places]
