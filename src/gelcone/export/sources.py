"""The C sources of a device: tables of its numbers, the translated loop, and the functions of an instance."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from importlib.resources import files
from typing import Any, NamedTuple

import numpy as np

from gelcone._version import __version__
from gelcone.codes import CALL_SPAN, STEPS_PER_CALL, Outcome
from gelcone.devices.analysis import check_one
from gelcone.devices.device import Device
from gelcone.devices.fields import DRIVE_NUMBERS
from gelcone.devices.record import LARGEST
from gelcone.devices.scales import MEASURES
from gelcone.errors import InputError
from gelcone.export import c99
from gelcone.export.parameters import STRENGTH, Parameters, parameters_of
from gelcone.motion.flow import formulas_text, portable, smallest_step
from gelcone.motion.job import Portable
from gelcone.motion.validity import slack_places
from gelcone.physics.differentiate import evaluated
from gelcone.physics.drive import VOLTAGE, Pieces
from gelcone.physics.driven import DRIVE_PIECE, INPUTS, PHASE, DrivenSystem, driven
from gelcone.physics.model import ConeModel
from gelcone.physics.system import ConeSystem
from gelcone.physics.trace import Node, ordered

RATE = "_rate"
FLAT_HEIGHT = "second_flat_height"


class Variable(NamedTuple):
    """A variable of an exported device: its name, its kind, its SI unit ("" for a code) and its meaning."""

    name: str
    kind: str
    unit: str
    meaning: str


INPUT_VARIABLES = (
    Variable("voltage", "input", "V", "commanded voltage"),
    Variable("voltage_rate", "input", "V/s", "rate at which the commanded voltage changes until it is set again"),
    Variable("external_force", "input", "N", "force on the disc, positive away from the film's plane"),
    Variable("external_force_rate", "input", "N/s", "rate at which that force changes until it is set again"),
)
_OUTPUTS = {
    "film_voltage": ("voltage", "voltage on the {film}"),
    "charge": ("charge", "charge on the {film}"),
    "charge_rate": ("current", "current into the {film}, its leak included; without the jumps of a voltage that jumps"),
    "capacitance": ("capacitance", "charge of the {film} over its voltage"),
    "meridional_stress": ("stress", "true meridional stress of the {film}"),
    "hoop_stress": ("stress", "true hoop stress of the {film}"),
    "true_field": ("field", "largest true electric field in the {film}"),
    "limit_share": ("1", "share of its stretch limit that the {film} has reached"),
}
"""Outputs of each film -> quantity and meaning."""
CODES = (
    (
        "outcome",
        f"how the motion ended: {', '.join(f'{int(o)} {o.words}' for o in Outcome if o.value in (0, 2, 3, 4, 6))}",
    ),
    ("film_is_slack", "1 where a film is slack in a direction, else 0"),
    ("breakdown", "1 where the true field exceeds the dielectric strength, else 0"),
    ("near_limit", "1 where a film is within 1 % of its stretch limit, else 0"),
    ("valid", "1 where the model holds, else 0"),
)
TITLES = {"charge_rate": "current"}
"""Outputs whose name differs from that of their formula."""


@dataclass(frozen=True)
class Exported:
    """A device to be exported: its program as text, its parameters and its variables; ``inside``: with its drive."""

    device: Device
    name: str
    inside: bool
    tolerance: float

    @cached_property
    def model(self) -> ConeModel:
        """The dimensionless model of one device."""
        check_one(self.device, "export")
        return self.device.to_model()

    @cached_property
    def pieces(self) -> Pieces | None:
        """The pieces of the included drive, None without any; `InputError` if they change with its parameters."""
        drive, model = self.system.waveform.pieces, self.model  # type: ignore[attr-defined]
        if drive is None:
            return None
        tables = [
            drive.table({**model.values, **{name: model.values[name] + share * k for k, name in enumerate(VOLTAGE, 1)}})
            for share in (0, 1)
        ]
        if any((getattr(tables[0], part) != getattr(tables[1], part)).any() for part in ("begins", "terms")):
            raise InputError(
                f"drive: the pieces of the waveform {drive.name} change with voltage or frequency, which stay free; "
                "leave it out and give the voltage as an input"
            )
        return tables[0]

    @cached_property
    def system(self) -> DrivenSystem:
        """The system under inputs."""
        return driven(self.model.system, self.inside)

    @cached_property
    def program(self) -> Portable:
        """The text of the program."""
        return portable(self.system, partial(outputs_of, self.system), self.tolerance)

    @cached_property
    def parameters(self) -> Parameters:
        """The parameters that can be changed."""
        states = [state.quantity for state in self.system.states]
        return parameters_of(self.device, self.model, self.program.used, states)

    @cached_property
    def outputs(self) -> dict[str, tuple[int, str, str]]:
        """Name of each output -> index among the values of a point, quantity and meaning."""
        outputs, states = {}, {state.name for state in self.system.states}
        for film in self.system.films:
            for name, (quantity, meaning) in _OUTPUTS.items():
                if film.prefix + name in self.program.outputs and film.prefix + name not in states:
                    index = self.program.outputs.index(film.prefix + name)
                    outputs[film.prefix + TITLES.get(name, name)] = (
                        index,
                        quantity,
                        meaning.format(film=film.words[4:]),
                    )
        return outputs

    @cached_property
    def kinds(self) -> list[tuple[str, ...]]:
        """The states of tension of each film; "taut" alone for a film without any."""
        return [film.kinds or ("taut",) for film in self.system.films]

    @cached_property
    def variables(self) -> list[Variable]:
        """All variables, in the order of their numbers in C."""
        states = [
            Variable(
                s.name,
                "state",
                _unit(s.quantity),
                s.meaning.partition(",")[0] if k else "height of the disc above the film's plane",
            )
            for k, s in enumerate(self.system.states)
        ]
        rates = [Variable(f"{s.name}{RATE}", "rate", _rate_unit(s.unit), f"rate of change of {s.name}") for s in states]
        outputs = [Variable(n, "output", _unit(q), meaning) for n, (_, q, meaning) in self.outputs.items()]
        films = [
            Variable(f"{film.prefix}film_state", "code", "", ", ".join(f"{k} {kind}" for k, kind in enumerate(kinds)))
            for film, kinds in zip(self.system.films, self.kinds, strict=True)
        ]
        codes = [*films, *(Variable(name, "code", "", meaning) for name, meaning in CODES)]
        parameters = [
            Variable(name, "parameter", field.unit, field.meaning) for name, field in self.parameters.fields.items()
        ]
        time = [Variable("time", "time", "s", "time since the start")]
        return [*INPUT_VARIABLES, *states, *rates, *outputs, *codes, *time, *parameters]

    def start(self) -> tuple[np.ndarray[Any, Any], dict[str, float]]:
        """The initial states, dimensionless, and the switches there at zero input voltage."""
        z = np.asarray(self.model.members().start_states(np.array([self.device.initial_state()])), dtype=float)[0]
        n = self.numbers()
        switches = self.system.switches(0.0, [np.float64(value) for value in z], n)
        return z, {name: float(np.ravel(switches[name])[0]) for name in self.program.switches}

    def numbers(self) -> dict[str, float]:
        """The numbers of the formulas for the device's parameters and zero inputs, rounded as in C."""
        arrays = self.system.numbers_of({name: np.asarray(value, float) for name, value in self.model.values.items()})
        numbers = {name: float(np.ravel(value)[0]) for name, value in arrays.items()}
        return numbers | self._evaluated(self.parameters.nodes)

    @cached_property
    def scale_values(self) -> dict[str, float]:
        """The SI values of dimensionless units, by quantity."""
        return self._evaluated(self.parameters.scales)

    def _evaluated(self, nodes: Mapping[str, Node]) -> dict[str, float]:
        parameters = self.parameters
        leaves = [node for node in ordered(nodes.values()) if node.operation == "number"]
        known = {leaf.index: np.float64(parameters.values[leaf.value]) for leaf in leaves}
        return dict(zip(nodes, map(float, evaluated(list(nodes.values()), known)), strict=True))


def outputs_of(system: ConeSystem, time: Any, z: Any, n: Any, xp: Any) -> dict[str, tuple[Any, Any]]:
    """The formulas of the outputs, each with what is added to its rate if that is an output, too: voltage, charge with
    the current, which is its rate and the leak, capacitance, stresses and field of each film."""
    outputs: dict[str, tuple[Any, Any]] = {}
    volts, leaks = system.voltages(time, z, n, xp), system.leaks(time, z, n, xp)
    for k, (film, voltage, leak) in enumerate(zip(system.films, volts, leaks, strict=True)):
        y, squared, prefix = system.states_of(z, "film", k), voltage * voltage, film.prefix
        outputs[f"{prefix}film_voltage"] = voltage, None
        if film.film.traced_charge:
            capacitance = film.capacitance(z[0], squared, y, n, xp)
            charge = system.stored(time, z, n, xp) if system.circuit.delays else voltage * capacitance
            outputs |= {f"{prefix}charge": (charge, leak), f"{prefix}capacitance": (capacitance, None)}
        state = film.traced_state(z[0], squared, y, n, xp)
        if state is not None and system.circuit.delays:
            pulling = film.traced_state(z[0], system.squares(time, z, n, xp)[k], y, n, xp)
            state = pulling._replace(field_squared=state.field_squared) if pulling else state
        if state is not None:
            outputs |= {
                f"{prefix}{name}": (getattr(state, name), None) for name in ("meridional_stress", "hoop_stress")
            }
            outputs |= {f"{prefix}true_field": (xp.sqrt(state.field_squared), None)}
            outputs |= {f"{prefix}limit_share": (state.limit_share, None)}
    return outputs


def _unit(quantity: str) -> str:
    return MEASURES[quantity].unit if quantity in MEASURES else "1"


def _rate_unit(unit: str) -> str:
    return {"1": "1/s", "m": "m/s", "m/s": "m/s^2", "C": "A"}.get(unit, f"{unit}/s")


# --- the text ---------------------------------------------------------------------------------------------------------


def sources(exported: Exported) -> dict[str, str]:
    """Write the header and the source: file name -> text."""
    name, program, title = exported.name, exported.program, in_comment(exported.device.name)
    lines = [
        _template("prelude.c"),
        *_tables(exported),
        *_translated(exported),
        _template("core.c"),
        _template("device.c"),
    ]
    source = f'/* {title}, exported by gelcone {__version__}: see {name}.h. */\n#include "{name}.h"\n\n'
    n = program.sizes
    values = {
        "DEVICE_TITLE": title,
        "GELCONE_VERSION": __version__,
        "VARIABLES\n": _enum(exported),
        "SIZE_PARAMETERS": max(len(exported.parameters.values), 1),
        "SIZE_STATES": n["states"],
        "SIZE_SWITCHES": max(len(program.switches), 1),
        "SIZE_NUMBERS": len(program.numbers) + len(exported.parameters.scales),
        "SIZE_OUT": len(program.outputs),
        "SIZE_ROOTS": max(n["roots"], 1),
        "SIZE_TABLE": max(n["held"], 1),
        "SIZE_LANES": n["laws"] * n["rows"],
        "SIZE_SCRATCH": n["scratch"],
        "SIZE_STORE": n["rows"],
        "SIZE_WORDS": n["words"],
    }
    return {f"{name}.h": filled("device.h", name, values), f"{name}.c": _named(source + "\n".join(lines), name)}


def example(exported: Exported) -> str:
    """Write a program that drives the device by its voltage."""
    amplitude, offset, frequency = (float(exported.device.get(field)) for field in DRIVE_NUMBERS)
    shown, turn, drive = "film voltage", "", ""
    if not exported.inside:
        before, after = (
            f"{offset!r} + {amplitude!r} * sin(turn * {frequency!r} * ({at}))" for at in ("k * step", "(k + 1) * step")
        )
        shown, turn = "voltage", ", turn = 6.283185307179586"
        drive = (
            f"    double before = {before}, after = {after};\n"
            "    DEVICE_set(&device, DEVICE_UP_VOLTAGE, before);\n"
            "    DEVICE_set(&device, DEVICE_UP_VOLTAGE_RATE, (after - before) / step);\n"
        )
    last, unit = ("current", "A") if "current" in exported.outputs else ("velocity", "m/s")
    values = {"FIRST_SHOWN": shown, "FIRST_NAME": constant(shown), ", TURN_SET": turn, "DRIVE_SET\n": drive}
    return filled("example.c", exported.name, values | {"LAST_SHOWN": f"{last} ({unit})", "LAST_NAME": constant(last)})


def filled(template: str, name: str, values: Mapping[str, object]) -> str:
    """Fill the name of the device and some ``values`` into a template."""
    text = _template(template)
    for word, value in values.items():
        text = text.replace(word, str(value))
    return _named(text, name)


def _template(name: str) -> str:
    return (files("gelcone.export") / "templates" / name).read_text(encoding="utf-8")


def _named(text: str, name: str) -> str:
    """Replace DEVICE by the name of the device in a text."""
    return text.replace("DEVICE_H\n", f"{name.upper()}_H\n").replace("DEVICE_UP", name.upper()).replace("DEVICE", name)


def in_comment(text: str) -> str:
    """A text without line breaks, and without characters that could end a comment or join its line with the next."""
    printable = "".join(c if c.isprintable() and c not in "\\?" else " " for c in text)
    return re.sub(r"\*(?=/)|/(?=\*)", " ", printable)


def _enum(exported: Exported) -> str:
    rows = []
    for k, variable in enumerate(exported.variables):
        fixed = {"input": "input", "state": "state", "parameter": "parameter"}.get(variable.kind, "read")
        unit = f", {variable.unit}" if variable.unit not in ("", "1") else ""
        rows.append(f"  DEVICE_UP_{constant(variable.name)} = {k}, /* {fixed}{unit}: {in_comment(variable.meaning)} */")
    rows.append(f"  DEVICE_UP_VARIABLES = {len(exported.variables)} /* how many there are */")
    return "\n".join(rows) + "\n"


def constant(name: str) -> str:
    """The name of a variable as part of its constant in C."""
    return re.sub(r"\W", "_", name).upper()


def _array(kind: str, name: str, values: Sequence[Any]) -> str:
    """Write a table; a single zero if it is empty."""
    texts = [c99.real_text(float(value)) if kind == "double" else str(int(value)) for value in values] or ["0"]
    rows = [", ".join(texts[k : k + 8]) for k in range(0, len(texts), 8)]
    return f"static const {kind} {name}[] = {{\n  " + ",\n  ".join(rows) + "\n};"


def _tables(exported: Exported) -> list[str]:
    """Write the numbers of the device as definitions and tables."""
    program, parameters, system = exported.program, exported.parameters, exported.system
    z, switches = exported.start()
    numbers, scales = exported.numbers(), list(parameters.scales)
    members, n = exported.model.members(), program.sizes
    names = list(program.numbers)
    places = dict(zip((*INPUTS, PHASE), ("VOLTAGE", "VOLTAGE_RATE", "FORCE", "FORCE_RATE", "PHASE"), strict=True))
    pieces = exported.pieces
    out = program.outputs
    combined = 2 ** len(program.switches)
    most = max(map(len, exported.kinds))
    defines: dict[str, Any] = {
        "N_STATES": n["states"], "N_NUMBERS": len(names), "N_SCALES": len(scales), "N_OUT": len(out),
        "N_PARAMETERS": len(parameters.values), "N_SWITCHES": len(program.switches), "N_ROOTS": n["roots"],
        "N_LAWS": n["laws"], "N_TELLING": len(program.telling), "N_BORDERS": len(program.border_switches),
        "N_FILMS": len(system.films), "N_OUTPUTS": len(exported.outputs), "N_JOB": n["job"],
        "N_COMBINATIONS": n["combinations"], "N_COMBINED": combined, "N_KINDS": most,
        "OUT_BORDER": out.index("border_0") if "border_0" in out else 0, "CODE": n["code"], "SERVE": n["serve"],
        **{name.upper(): place for name, place in n.items() if name.startswith("job_")},
        **{f"SCALE_{name.upper()}": scales.index(name) for name in ("time", "voltage", "force", "field")},
        **{f"NUMBER_{where}": names.index(name) for name, where in places.items()},
        "P_DIELECTRIC_STRENGTH": list(parameters.values).index(STRENGTH),
        **({"P_FREQUENCY": list(parameters.values).index("frequency")} if exported.inside else {}),
        **({} if pieces is None else _piece_defines(pieces, exported, names)),
        "SMALLEST_STEP": repr(float(smallest_step(members)[0])), "FASTEST": repr(float(np.ravel(members.fastest)[0])),
        "STEPS_PER_CALL": f"{STEPS_PER_CALL}.0", "CALL_SPAN": repr(CALL_SPAN), "LARGEST": repr(LARGEST),
        **{f"TEXT_{own.name}": f'"{own.meaning}"' for own in Outcome},
    }  # fmt: skip
    quantities = [state.quantity for state in system.states]
    watched = ("meridional_stress", "hoop_stress", "true_field", "limit_share")
    film_out = [film.prefix + name for film in system.films for name in watched]
    return [
        *(f"#define {name} {value}" for name, value in defines.items()),
        *([] if pieces is None else _piece_tables(pieces)),
        _array("double", "NUMBERS", [numbers[name] for name in names]),
        _array("double", "PARAMETERS", list(parameters.values.values())),
        _array("double", "LEAST", [_least(field) for field in parameters.fields.values()]),
        # a dielectric strength of 0 stands for an unknown one
        _array("int", "EXCLUSIVE", [f.above is not None and name != STRENGTH for name, f in parameters.fields.items()]),
        _array("double", "START", list(z)),
        _array("double", "START_SWITCHES", [switches[name] for name in program.switches]),
        _array("int", "STATE_SCALE", [scales.index(q) if q in scales else scales.index("1") for q in quantities]),
        _array("int", "OUTPUT_PLACE", [place for place, _, _ in exported.outputs.values()]),
        _array("int", "OUTPUT_SCALE", [scales.index(quantity) for _, quantity, _ in exported.outputs.values()]),
        _array("int", "TELLING", program.telling),
        _array("int", "BORDER_SWITCH", program.border_switches),
        _array("int", "FILM_OUT", [out.index(name) if name in out else -1 for name in film_out]),
        _array("int", "HAS_KINDS", [bool(film.kinds) for film in system.films]),
        _array("int", "KIND", [kind for film in system.films for kind in _kinds(film, program.switches)]),
        _array("int", "SLACK", [kind in own for own in map(_slack, system.films) for kind in range(most)]),
        _array("double", "REACH", [end for film in system.films for end in film.film.reach(film.own(numbers))]),
        _array("int", "FLAT_HEIGHT", [names.index(FLAT_HEIGHT) if film.drive else -1 for film in system.films]),
    ]  # fmt: skip


def _piece_defines(pieces: Pieces, exported: Exported, names: Sequence[str]) -> dict[str, Any]:
    """The definitions of a drive with pieces: sizes, and indices of its numbers."""
    indices = {f"NUMBER_{name.upper()}": names.index(name) for name in DRIVE_PIECE if name in names}
    repeats = int(exported.model.system.waveform.repeat)
    return indices | {"N_PIECES": len(pieces.begins), "REPEATS": repeats, "FIRST": repr(float(pieces.begins[0]))}


def _piece_tables(pieces: Pieces) -> list[str]:
    return [
        _array("double", "PIECE_OFFSETS", (pieces.begins - pieces.begins[0]).tolist()),
        _array("double", "PIECE_TERMS", np.ravel(pieces.terms).tolist()),
    ]


def _least(field: Any) -> float:
    """The least value of a field; that of all numbers if it has no bound."""
    bound = field.above if field.above is not None else field.least
    return -LARGEST if bound is None else float(bound)


def _kinds(film: Any, switches: Sequence[str]) -> list[int]:
    """The film's state of tension for each combination of signs of the switches."""
    combined = 2 ** len(switches)
    if not film.kinds:
        return [0] * combined
    return np.argmax(film.times_of_kinds(list(switches), np.eye(combined)), axis=1).tolist()


def _slack(film: Any) -> set[int]:
    return {place for places in slack_places(film).values() for place in places}


def _translated(exported: Exported) -> list[str]:
    """Translate the loop, the formulas of outputs and those of parameters to C."""
    program, parameters = exported.program, exported.parameters
    first, *steps = program.modules
    names = list(program.numbers)
    closed = {names.index(name): node for name, node in parameters.nodes.items()}
    closed |= {len(names) + k: node for k, node in enumerate(parameters.scales.values())}
    numbers = formulas_text("set_closed_numbers", list(parameters.values), closed)
    pairs = c99.translate(first, {"start": "start_run", "step": "step_0"})
    for k, step in enumerate(steps):
        pairs += c99.translate(step, {"step": f"step_{k}"})
    for text in (*program.points, numbers):
        pairs += c99.translate(text, {})
    bodies = "\n".join(body for _, body in pairs)
    laws = range(program.sizes["laws"])
    return [
        c99.helpers(bodies),
        "\n".join(head for head, _ in pairs),
        "",
        bodies,
        "typedef void (*step_function)(word *, word *, word *, word *, word *);",
        "typedef void (*point_function)(word *, double, word *, word *, word *, word *);",
        f"static const step_function STEPS[] = {{{', '.join(f'step_{k}' for k in laws)}}};",
        f"static const point_function POINTS[] = {{{', '.join(f'point_{k}' for k in laws)}}};",
        "",
    ]
