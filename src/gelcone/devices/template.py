"""Texts of device files: of a device, of a first file to fill in, and the list of fields."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Collection, Iterator, Mapping
from typing import Any

import numpy as np

from gelcone.devices.materials import CHANGED, Material, load_materials
from gelcone.devices.record import Field, Record
from gelcone.devices.units import DIMENSIONS, FieldError, format_si, parse
from gelcone.physics.bias import Together
from gelcone.physics.component import Component
from gelcone.physics.film.film import Film

COMMENT_COLUMN = 40
HEAD = """\
# A conical gel actuator. `gelcone simulate {file}` shows how it moves, `gelcone envelope {file}` where it is safe.
#
# A value is a number in the SI unit of its line, or a text with a unit such as "0.2 mm". A line that begins with # is
# left out; take the # away to use it. The numbers are those of a {start}: put in your own.
"""


def device_text(device: Record, gel: Material) -> str:
    """The text of a device file, with this gel, that reads back as an equal device."""
    lines = [*_set_lines(device)]
    if load_materials().get(gel.name) == gel:
        return "\n".join([*lines, ""])
    lines = [line for line in lines if not line.startswith("material =")]
    return "\n".join([*lines, "", material_text(gel), ""])


def material_text(gel: Material, comments: Mapping[str, str] | None = None) -> str:
    """The table ``[material]`` of a device file; ``comments`` replace the meanings of some fields."""
    lines = ["[material]", *_set_lines(gel, comments or {})]
    if gel.sources:
        lines += ["", "[material.sources]", *(f"{name} = {_value(text, '')}" for name, text in gel.sources.items())]
    return "\n".join(lines)


def _set_lines(record: Record, comments: Mapping[str, str] | None = None) -> Iterator[str]:
    """Lines ``name = value  # meaning`` of all fields that are set, with a component's numbers in its table."""
    explained = comments or {}
    for name, value in record:
        if value is None or name == "sources" or "." in name:
            continue
        field = record.fields[name]
        if isinstance(value, Material):
            value = value.name
        elif not field.unit and (
            not isinstance(value, str) or any(n.startswith(f"{name}.") and v is not None for n, v in record)
        ):
            value = _table(record, name, record.plain(name, value))
        elif not field.required and not field.unit and value == field.default:
            continue
        elif name == "shear_modulus" and name not in explained and (modulus := _young_modulus(value)):
            name, value = "young_modulus", modulus
            field = record.fields[name]
        yield _line(name, value, explained.get(name, field.meaning), field.unit)


def _young_modulus(shear_modulus: Any) -> float | None:
    """Young's modulus if it is a short number and the shear modulus, a third of it, is not; else None."""
    if np.ndim(shear_modulus) or float(f"{shear_modulus:.12g}") == shear_modulus:
        return None
    young = float(f"{3.0 * shear_modulus:.12g}")
    return young if young / 3.0 == shear_modulus else None


def _table(record: Record, name: str, plain: Any) -> Any:
    """The table of a component in a device file: its class, its data, and its numbers with units."""
    numbers = {
        field_name.partition(".")[2]: _Text(_value(value, record.fields[field_name].unit))
        for field_name, value in record
        if field_name.startswith(f"{name}.") and value is not None
    }
    tables = [
        entry if isinstance(entry, Mapping) else {"component": entry}
        for entry in ([plain], plain)[isinstance(plain, list)]
    ]
    tables[0] = {**tables[0], **numbers}
    return tables if isinstance(plain, list) else tables[0]


class _Text(str):
    """A text that is TOML already."""


def first_file(name: str, device: Record, gel: Material) -> str:
    """The text of a first device file ``name``, with unit, meaning, usual range and default of every field.

    The values are those of ``device`` with this gel.
    """
    lines = [HEAD.format(file=name, start=getattr(device, "name", ""))]
    for field_name, field in device.fields.items():
        value = {"name": "my device", "material": gel.name}.get(field_name, getattr(device, field_name))
        lines += _explained(field_name, value, field)
    lines += [
        "# --- a gel of one's own: put a # before `material` above, take away that of [material] and of its fields",
        "",
        "# [material]",
    ]
    gel_values = {"name": "my gel", "stretch_limit": 50.0, "dielectric_strength": 2e7}
    for field_name, modulus in (("shear_modulus", gel.shear_modulus), ("young_modulus", 3.0 * gel.shear_modulus)):
        gel_values[field_name] = float(f"{modulus:.4g}")  # as one would write it: one is a third of the other
    for field_name, field in Material.fields.items():
        if field.unit or field_name in ("name", "law", "flow"):
            value = gel_values.get(field_name, getattr(gel, field_name))
            lines += _explained(field_name, value, field, out=True)
    return "\n".join(lines).rstrip() + "\n"


def _explained(name: str, value: Any, field: Field, out: bool = False) -> list[str]:
    """Lines of a field with its meaning; commented out, with an example, if it is left out or has its default."""
    usual = not field.required and isinstance(value, float | str) and value == field.default
    left_out = out or value is None or usual
    if value is None or (usual and field.unit):
        value = field.example_value()
    return [
        f"# {field.meaning}",
        f"#   {'; '.join(_terms(field))}",
        f"{'# ' if left_out else ''}{name} = {_value(value, field.unit)}",
        "",
    ]


def _terms(field: Field) -> list[str]:
    """Texts about a field: required or optional, its unit, and its usual range."""
    needed = "required" if field.required else f"optional, {default_text(field)} when left out"
    if field.unset.startswith("or give"):
        needed = f"required, {field.unset}"
    parts = [needed, f"SI unit {field.unit}" if field.unit not in ("", "1") else ""]
    parts += [f"usual {field.typical_text()}" if field.typical else ""]
    return [text for text in parts if text]


def default_text(field: Field) -> str:
    """The text of a field's default, or of its effect when it is left out."""
    if field.unset or field.default is None:
        return field.unset
    return str(field.default) if not field.unit else format_si(field.default, field.unit)


def _line(name: str, value: Any, comment: str, unit: str) -> str:
    text = f"{name} = {_value(value, unit)}"
    return f"{text:{COMMENT_COLUMN}s} # {comment}"


def _value(value: Any, unit: str) -> str:
    """The TOML of a value, with a unit if that loses no digit."""
    if isinstance(value, _Text):
        return value
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{name} = {_value(entry, '')}" for name, entry in value.items()) + "}"
    if isinstance(value, bool | int):
        return json.dumps(value)
    if isinstance(value, np.ndarray | list | tuple):
        return f"[{', '.join(_value(v, unit) for v in value)}]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if unit in ("", "1") or not np.isfinite(value) or value == 0.0:
        return repr(float(value))
    text = format_si(float(value), unit, 15)
    try:
        exact = parse("", text, unit) == value
    except FieldError:
        exact = False
    return json.dumps(text) if exact else repr(float(value))


def field_table(fields: Mapping[str, Field]) -> str:
    """The table of the fields of a device and of its material, two lines each: unit, required or optional, usual range
    and meaning."""
    lines = [
        "The fields of a device, as in a device file, after --set and --over, and in Device(...).",
        'A value is a number in the SI unit, or a text with a unit: "0.2 mm". Several are a list: in a file and',
        'in Device(...) ["500 V", "800 V"], after --set and --over "500 V,800 V" or a range "0 V:800 V:5" (from, to,',
        "how many).",
        "",
    ]
    for name, field in fields.items():
        lines += _rows(name, field)
    lines += ["", "The fields of its material, in a table [material] or with a dot: material.shear_modulus", ""]
    for name, field in Material.fields.items():
        lines += _rows(name, field)
    return "\n".join(lines)


def field_help(fields: Mapping[str, Field], name: str) -> str | None:
    """The lines of `field_table` about one field of a device or of its material; None for an unknown name."""
    all_fields = {**fields, **{f"material.{gel_field}": field for gel_field, field in Material.fields.items()}}
    full_name = name if name in all_fields else f"material.{name}"
    return "\n".join(line[2:] for line in _rows(full_name, all_fields[full_name])) if full_name in all_fields else None


def _rows(name: str, field: Field) -> list[str]:
    terms = [term for term in _terms(field) if not term.startswith("SI unit")]
    kind = {"": "text", "1": "number"}.get(field.unit, field.unit)
    return [f"  {name:28s} {kind:7s} {'; '.join(terms)}", f"      {field.meaning}"]


def fields_in_words(device: Record, swept: Collection[str] = ()) -> list[str]:
    """Texts ``name value unit`` of all fields of a device that are set, not swept and not defaults: numbers, texts,
    components and the gel. A film that ships is left out."""
    texts = []
    for name, value in device:
        field = device.fields.get(name)
        if field is None or name in swept or value is None or np.ndim(value):
            continue
        if field.unit and not (value == 0.0 and field.default == 0.0):
            texts.append(f"{name} {format_si(value, field.unit)}")
        elif isinstance(value, Material):
            skipped = {field_name for field_name, number in device if number is not None}  # a device's number wins
            texts += _gel_in_words(value, skipped | {field_name.removeprefix("material.") for field_name in swept})
        elif isinstance(value, Component):
            texts.append(f"{name} {component_in_words(value)}")
        elif isinstance(value, str) and name not in ("name", "film") and value != field.default:
            texts.append(f"{name} {value}")
    return texts


def _gel_in_words(gel: Material, skipped: Collection[str]) -> list[str]:
    """Texts of the name of a gel, and of its fields, not ``skipped``, that differ from those of the gel of that name
    that ships, or from their defaults."""
    ships = load_materials().get(gel.name.removesuffix(CHANGED))
    law = gel.strain_energy_law
    usual = dict(ships) if ships is not None else {"law": gel.fields["law"].default}
    if ships is None or ships.law != gel.law:
        usual |= {name: quantity.default for name, quantity in law.parameters.items()}
    texts = [f"material {gel.name}"]
    for name, value in gel:
        if value is None or name in (*skipped, "name", "sources") or np.ndim(value) or value == usual.get(name):
            continue
        unit = gel.fields[name].unit
        texts.append(
            f"{name} {component_in_words(law) if name == 'law' else format_si(value, unit) if unit else value}"
        )
    return texts


def component_in_words(component: Component) -> str:
    """The name of a component with its data other than defaults, of tables the number of entries."""
    if isinstance(component, Together):
        return " + ".join(map(component_in_words, component.parts))
    data_fields: tuple[dataclasses.Field[Any], ...] = (
        dataclasses.fields(component) if dataclasses.is_dataclass(component) else ()
    )
    others = ("law", "prestretch_mode") if isinstance(component, Film) else ()  # the material's and the device's
    data = {
        data_field.name: value
        for data_field in data_fields
        if data_field.name not in others and (value := getattr(component, data_field.name)) != data_field.default
    }
    entries = {
        len(value): name for name, value in data.items() if isinstance(value, tuple)
    }  # columns of one table: one
    texts = [f"{count} {name}" for count, name in entries.items()]
    texts += [_datum_in_words(name, value) for name, value in data.items() if not isinstance(value, tuple)]
    return f"{component.name} ({', '.join(texts)})" if texts else component.name


def _datum_in_words(name: str, value: Any) -> str:
    if isinstance(value, bool):
        return name if value else f"no {name}"
    if isinstance(value, Component):
        return f"{name} {component_in_words(value)}"
    return f"{name} {value:.4g}" if isinstance(value, int | float) else f"{name} {value}"


def unit_table() -> str:
    """The table of units, one line for each dimension."""
    lines = ["A value with a unit is one number and one unit, such as:"]
    for unit, dimension in DIMENSIONS.items():
        if unit != "1":
            known = ", ".join(name for name in dimension.powers if name.isascii())
            lines.append(f"  {dimension.example:12s} {dimension.name} ({known})")
    return "\n".join(lines)
