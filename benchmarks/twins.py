"""Random twins: one question asked of two models that are the same actuator, or in two ways, must have one answer.

    python benchmarks/twins.py [CASES] [SEED] [KIND ...]      (default 8 of each kind, 2026, all kinds)

A twin has the other sign of all voltages, is seen from the other side, has another size and another gel, one film in
place of two, a waveform of samples in place of a formula, is a member of an ensemble, or is read from a file; `KINDS`
lists them. `benchmarks/random_models.py` draws films, laws, loads, circuits, drives and second films. All numbers of
all answers are compared, and with them flags, outcomes, missing values and refusals.

Printed are one line for each kind with the number of comparisons and the largest difference, over the largest value of
its quantity in the answer and the bound, and each difference beyond its bound.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from random_models import (
    UNITS,
    Draw,
    actuator,
    circuit,
    cone,
    creep,
    devices_of_two_sizes,
    one_wave_twice,
    second,
    size,
    terms,
    waves_of_both_signs,
)

import gelcone
from gelcone import ConeModel
from gelcone.codes import Outcome
from gelcone.physics.waveforms import Harmonics

Difference = tuple[str, float]
"""Variable of an answer with its values, and how far apart these are over the bound."""
EXACT, ROOTS = 1e-12, 1e-8
"""Bounds of the same computation, and of numbers that are found by searches."""
LOOSE = {"apparent_power": 1e4, "linear_stroke": 1e3, "validity_": 1e2, "driven_": 1e6, "safe_peak": 1e6}
LOOSE |= {"pull_in_voltage": 1e4, "examined_": 1e4, "rms_": 1e4}
"""Bounds over the others: of what is taken from samples or has a stated error; of driven limits, which are ends of
intervals of searches whose runs start above their rest; and of pull-in, which of a film without a stretch limit is the
voltage at the last displacement searched."""
OF_ROUNDING = ("settled_time", "validity_error", "averaged_time", "standard_error", "return_distance", "cycle_distance")
OF_ROUNDING += ("lyapunov", "zero_one", "section", "drift", "overshoot", "pull_in_from", "pull_in_kind", "branch_")
"""Variables of rounding, of the points of a motion that happen to be computed, and of the far end of searches."""
REST = 400.0
"""Time after which the disc is at rest under a constant voltage."""


@dataclass
class Twin:
    """Two models, their starts, the answers asked of both, and the changes that make those of the other equal.

    ``units`` are those of the other over those of the one; ``turned`` turns an answer of the other back; ``but`` are
    parts of the names of variables that differ.
    """

    one: Any
    other: Any
    ask: tuple[str, ...]
    starts: tuple[Any, Any] = ((0.6, 0.1), (0.6, 0.1))
    units: Mapping[str, float] = field(default_factory=dict)
    turned: Callable[[Any], Any] = lambda found: found
    but: tuple[str, ...] = ()
    bound: float = ROOTS


ANSWERS: dict[str, Callable[[Any, Any, Mapping[str, float]], Any]] = {
    "settled": lambda own, start, u: gelcone.settled(own, **start),
    "regime": lambda own, start, u: gelcone.regime(own, **start),
    "run": lambda own, start, u: gelcone.simulate(own, times=np.linspace(0.0, 20.0 * u["t"], 401), **start),
    "static": lambda own, start, u: gelcone.static(own, [0.3 * u["v"], 0.7 * u["v"]]),
    "limits": lambda own, start, u: gelcone.limits(own),
    "step": lambda own, start, u: gelcone.step(own, [0.5 * u["v"]], duration=30.0 * u["t"]),
    "small signal": lambda own, start, u: gelcone.small_signal_response(own, [0.4 / u["t"], 1.5 / u["t"]]),
    "operating limits": lambda own, start, u: gelcone.operating_limits(own),
    "data sheet": lambda own, start, u: gelcone.datasheet(own, [0.4 * u["v"]]),
}
ALL = tuple(ANSWERS)[:-1]
MOTION = ALL[:3]


def asked(name: str, own: Any, start: Any, units: Mapping[str, float]) -> Any:
    """An answer, or the text of the error that refuses it."""
    try:
        return ANSWERS[name](own, {} if start is None else {"initial": start}, units)
    except gelcone.InputError as error:
        return str(error)


def compared(twin: Twin) -> Iterator[Difference]:
    """Compare all answers of two twins; motions only where they have a period or rest."""
    alike = dict.fromkeys("ltevcf", 1.0)
    for name in twin.ask:
        one = asked(name, twin.one, twin.starts[0], alike)
        other = asked(name, twin.other, twin.starts[1], alike | dict(twin.units))
        if isinstance(one, str) or isinstance(other, str):
            both = isinstance(one, str) and isinstance(other, str)
            yield f"{name}: {one if isinstance(one, str) else other}", 0.0 if both else np.inf
        elif name not in ("settled", "regime") or int(one["period"]) > 0 or int(one.get("resting", 0)):
            but = twin.but if twin.bound == EXACT else (*twin.but, *OF_ROUNDING)
            for variable, away in apart(one, twin.turned(other), alike | dict(twin.units), but):
                loose = max((LOOSE[part] for part in LOOSE if variable.startswith(part)), default=1.0)
                yield f"{name}: {variable}", away / twin.bound / (1.0 if twin.bound == EXACT else loose)


def apart(one: Any, other: Any, units: Mapping[str, float], but: tuple[str, ...]) -> Iterator[Difference]:
    """Differences of the variables of two answers, infinite where flags, shapes or missing values differ."""
    one, other, largest = phasors(one), phasors(other), dict[str, float]()
    for value in one.data_vars.values():
        if value.dtype.kind == "f":
            finite = float(np.abs(np.where(np.isfinite(value), value, 0.0)).max(initial=1e-9))
            largest[value.attrs["quantity"]] = max(largest.get(value.attrs["quantity"], 0.0), finite)
    for name in sorted(set(map(str, one.data_vars)) | set(map(str, other.data_vars))):
        if any(part in name for part in but):
            continue
        if name not in one or name not in other:
            yield f"{name}, of one alone", np.inf
            continue
        quantity = one[name].attrs["quantity"]
        a, b = one[name].values, other[name].values
        shown = f"{name}, {a.ravel()[:4]} {b.ravel()[:4]}"
        if a.shape != b.shape or a.dtype.kind != "f":
            yield shown, 0.0 if np.array_equal(a, b) else np.inf
            continue
        b = b / size(UNITS.get(quantity, "1"), units)
        finite = np.isfinite(a) & np.isfinite(b)
        away = np.abs(a - b)[finite].max(initial=0.0) / largest[quantity]
        yield shown, float(away) if np.array_equal(a[~finite], b[~finite], equal_nan=True) else np.inf


def phasors(found: Any) -> Any:
    """An answer with sine and cosine parts in place of phases, which mean nothing where an amplitude vanishes."""
    for phase in [str(name) for name in found.data_vars if str(name).endswith("phase")]:
        amplitude = found["harmonic_amplitude" if phase == "harmonic_phase" else "gain"]
        for part in (np.sin, np.cos):
            parts = amplitude * part(np.radians(found[phase].fillna(0.0)))
            found = found.assign({f"{phase}_{part.__name__}": parts.assign_attrs(amplitude.attrs)})
        found = found.drop_vars(phase)
    return found


# --- the same actuator -----------------------------------------------------------------------------------------------


def other_sign(draw: Draw) -> Twin:
    """All voltages with the other sign."""
    (wave, negative), own = waves_of_both_signs(draw), actuator(draw)
    turned = {"voltage_bias": -own["voltage_bias"], "waveform": negative}
    but = ("phase", "drive_voltage", "film_voltage", "amplifier_voltage", "current", "initial", "charge")
    return Twin(ConeModel(**own, waveform=wave), ConeModel(**own | turned), ALL, but=but)


def seen_from(height: float) -> Callable[[Any], Any]:
    """An answer with heights from the plane at a ``height``, downwards, and the phases of its displacements."""
    places = ("displacement", "mean", "begin", "end", "equilibrium", "rest_displacement", "final_displacement")

    def turned(found: Any) -> Any:
        new = {name: height - found[name] for name in places if name in found}
        signed = ["velocity", *(["stroke"] if found.attrs["title"] == "statics" else [])]
        new |= {name: -found[name] for name in signed if name in found}
        if "lowest" in found:
            new |= {"lowest": height - found["highest"], "highest": height - found["lowest"]}
        new |= {name: found[name] + 180.0 for name in ("phase", "harmonic_phase") if name in found}
        return found.assign({name: value.assign_attrs(found[name].attrs) for name, value in new.items()})

    return turned


ALONG = ("force", "stiffness", "fold", "pitchfork_displacement", "initial", "slope", "equilibri", "pull_in_to")
"""Variables of `static` along the displacement, and states."""


def mirrored(draw: Draw) -> Twin:
    """A single cone on the other side of the plane of its film."""
    own = actuator(draw, double=0.0)
    if draw.chance(0.5):
        own |= {"bias": "spring+weight+beam", "weight": draw.uniform(-0.2, 0.2), "beam_height": draw.uniform(-1.0, 1.0)}
    turned = {name: -own[name] for name in ("rest_height", "weight", "beam_height") if name in own}
    starts = ((0.6, 0.1), (-0.6, -0.1))
    return Twin(ConeModel(**own), ConeModel(**own | turned), ALL, starts, turned=seen_from(0.0), but=ALONG)


def exchanged(draw: Draw) -> Twin:
    """A double cone whose first and second film are exchanged, as are their voltages."""
    films = [str(draw.choice(["taut", "wrinkling"], p=[0.8, 0.2])) for _ in range(2)]
    own = cone(draw, film=films[0], law="gent")
    own = {name: value for name, value in own.items() if not name.startswith("yeoh")} | second(draw, films[1])
    own |= (creep(draw) if films[0] == films[1] else {}) | circuit(draw, max(films))
    height = own["second_flat_height"]
    swap = {"film": films[1], "second_film": films[0], "rest_height": height - own["rest_height"]}
    for name in ("hoop_prestretch", "meridional_prestretch"):
        swap |= {name: own[f"second_{name}"], f"second_{name}": own[name]}
    wave, starts, same = Harmonics(((1, 1.0, 0.0),)), ((0.5, 0.1), (height - 0.5, -0.1)), own["second_drive"] == "same"
    swap |= {"waveform": wave if same else Harmonics(((1, -1.0, 0.0),))}
    of_films = ("second", "stretch", "viscous", "stress", "field", "film_state", "slack", "current")
    of_films += ("pull_in_film", "pull_in_displacement", "pull_in_time")
    of_drives = () if same else ("voltage", "charge", "slew", "apparent", "limited")
    return Twin(
        ConeModel(**own, waveform=wave), ConeModel(**own | swap), ALL if same else MOTION, starts,
        turned=seen_from(height), but=(*ALONG, *of_films, *of_drives),
    )  # fmt: skip


def one_of_two(draw: Draw) -> Twin:
    """Two equal films that are flat together, and one film of their volume, on twice the energy and half the square of
    the time."""
    own = cone(draw) | creep(draw)
    own |= circuit(draw, own["film"])
    own.pop("circuit", None)  # a charge that is commanded is that of all films
    pair = ConeModel(**own, second_film=own["film"], second_drive="same")
    factors = {"spring_stiffness": 0.5, "series_resistance": 8.0**0.5, "current_limit": 8.0**-0.5}
    factors |= dict.fromkeys(("damping_ratio", "drive_frequency", "slew_rate"), 0.5**0.5)
    factors |= dict.fromkeys(("leakage_time", "filter_time", "dielectric_time", "relaxation_time_1"), 2.0**0.5)
    single = ConeModel(**own | {name: own[name] * factor for name, factor in factors.items() if name in own})
    starts, units = ((0.6, 0.1), (0.6, 0.1 * 0.5**0.5)), {"e": 0.5, "t": 2.0**0.5, "c": 0.5}
    but = ("second", "initial", "current")
    return Twin(pair, single, tuple(name for name in ALL if name != "limits"), starts, units, but=but)


def without_bias(draw: Draw) -> Twin:
    """Films in opposite phase without a bias, and in phase: their squared voltages are equal."""
    own = cone(draw, voltage_bias=0.0) | creep(draw)
    own |= second(draw, own["film"])
    same, opposite = (ConeModel(**own | {"second_drive": drive}) for drive in ("same", "opposite"))
    but = ("second", "initial", "peak_", "rms", "apparent", "current")
    return Twin(same, opposite, (*MOTION, "operating limits"), turned=of_a_ramp, but=but)


def of_a_ramp(found: Any) -> Any:
    """An answer whose limits of a drive that grows in proportion have the names of those on a slow ramp: without a bias
    they are the same."""
    begin = "proportional_"
    return found.rename({name: name.removeprefix(begin) for name in found.data_vars if name.startswith(begin)})


def at_one_voltage(draw: Draw) -> Twin:
    """Films in phase without an amplitude, and in opposite phase, or the second with the bias as a constant voltage."""
    own = cone(draw, voltage=0.0) | creep(draw)
    own |= second(draw, own["film"])
    held = {"second_drive": "constant", "second_voltage": abs(own["voltage_bias"])}
    changed = held if draw.chance(0.5) else {"second_drive": "opposite"}
    but = ("second", "initial", "charge", "current", "apparent", "power", "energy", "dissip", "linear")
    return Twin(ConeModel(**own | {"second_drive": "same"}), ConeModel(**own | changed), MOTION, but=but)


def pushed(draw: Draw) -> Twin:
    """A spring, and one with a constant force or a straight beam that does the same."""
    own = actuator(draw)
    stiffness, push, share = own["spring_stiffness"], draw.uniform(-0.3, 0.3), draw.uniform(0.2, 0.8)
    force = {"bias": "spring+force", "push": push, "rest_height": own["rest_height"] - push / stiffness}
    beam = {"bias": "spring+beam", "spring_stiffness": share * stiffness, "beam_height": own["rest_height"]}
    beam |= {"beam_stiffness": (1.0 - share) * stiffness, "beam_cubic": 0.0}
    other = ConeModel(**own | (force if draw.chance(0.5) else beam))
    return Twin(ConeModel(**own), other, ALL, but=("spring_energy", "blocked", "force", "stiffness"))


def in_tension(draw: Draw) -> Twin:
    """A film in tension throughout, taut and wrinkling."""
    own = cone(draw, voltage=draw.uniform(0.02, 0.1), film="taut", hoop_prestretch=1.6, meridional_prestretch=1.4)
    own |= {"voltage_bias": draw.uniform(-0.2, 0.2), "rest_height": draw.uniform(0.3, 0.8)} | creep(draw)
    but = ("film_state", "beyond", "pull_in")
    return Twin(ConeModel(**own), ConeModel(**own | {"film": "wrinkling"}), (*MOTION, "step", "small signal"), but=but)


def one_shape(draw: Draw) -> Twin:
    """A waveform by its name, and the same one by samples, harmonics or another name."""
    own, (one, other) = actuator(draw), one_wave_twice(draw)
    return Twin(ConeModel(**own, **one), ConeModel(**own, **other), ALL)


def twice_the_frequency(draw: Draw) -> Twin:
    """A sine, and a second harmonic of half the frequency."""
    own = actuator(draw)
    half = {"waveform": Harmonics(((2, 1.0, 0.0),)), "drive_frequency": 0.5 * own["drive_frequency"]}
    return Twin(ConeModel(**own), ConeModel(**own | half), (*MOTION, "operating limits"), but=("harmonic", "period"))


def later_phase(draw: Draw) -> Twin | Iterator[Difference]:
    """A drive that begins later, from the state that the motion then has."""
    own, later, drawn = actuator(draw), draw.uniform(0.5, 5.0), terms(draw)
    one = ConeModel(**own, waveform=Harmonics(drawn))
    other = ConeModel(**own, waveform=Harmonics(tuple((k, a, phi + k * later) for k, a, phi in drawn)))
    begun = gelcone.integrate(one, (0.6, 0.0), [later / own["drive_frequency"]])
    if int(begun.outcome[0]) != Outcome.OK:
        return iter(())
    return Twin(one, other, MOTION[:2], ((0.6, 0.0), begun.states[0, -1]), but=("phase",))


def negligible(draw: Draw) -> Twin:
    """A circuit, and the same one with a part that does nothing."""
    own = cone(draw, film="taut") | creep(draw) | {"series_resistance": draw.uniform(0.05, 0.5)}
    own |= second(draw, "taut") if draw.chance(0.5) else {}
    part = [{"current_limit": 1e3}, {"leakage_time": 1e12}, {"leakage_time": np.inf}][int(draw.integers(3))]
    return Twin(
        ConeModel(**own), ConeModel(**own | part), ALL, but=("leak", "limited", "heat", "film_power", "film_voltage")
    )


def in_an_ensemble(draw: Draw) -> Twin:
    """A model alone, and the second of three that differ in three numbers."""
    own = actuator(draw)
    names = draw.choice([name for name, value in own.items() if isinstance(value, float)], 3, replace=False)
    three = ConeModel(**own | {str(name): own[str(name)] * np.array([0.9, 1.0, 1.05]) for name in names})
    ask = (*MOTION, "limits", "operating limits")
    return Twin(ConeModel(**own), three, ask, turned=lambda found: found.isel(member=1), bound=EXACT)


def read_back(draw: Draw) -> Twin:
    """A model, and that of the file of one of its results."""
    model = ConeModel(**actuator(draw), waveform=waves_of_both_signs(draw)[0])
    with TemporaryDirectory() as folder:
        gelcone.save(gelcone.static(model, [0.1]), f"{folder}/result.nc")
        return Twin(model, gelcone.model_of(gelcone.load(f"{folder}/result.nc")), ALL, bound=EXACT)


def another_size(draw: Draw) -> Twin:
    """A device of other sizes, masses, gels, times and voltages with the same dimensionless numbers."""
    one, other, units = devices_of_two_sizes(draw)
    return Twin(one, other, ("settled", "regime", *ALL[3:6], *tuple(ANSWERS)[-2:]), (None, None), units)


# --- two ways to one answer ------------------------------------------------------------------------------------------


def held_and_static(draw: Draw) -> Iterator[Difference]:
    """The end of a run under a constant voltage, the settled motion, and the nearest stable equilibrium."""
    own = actuator(draw) | {"voltage": 0.0, "voltage_bias": draw.uniform(-0.6, 0.6)}
    model = ConeModel(**own)
    run = gelcone.simulate(model, (0.6, 0.0), times=[0.0, REST])
    if int(run["outcome"]) != Outcome.OK:
        return
    static, settled = gelcone.static(model, [abs(own["voltage_bias"])]), gelcone.settled(model, (0.6, 0.0))
    end, places = float(run["displacement"][-1]), static["equilibrium_displacement"].values[0]
    away = np.abs(np.where(static["stable"].values[0] > 0, places, np.inf) - end)
    k = int(np.nanargmin(away))
    yield f"equilibria {places}, end {end}", away[k] / 1e-6
    yield f"mean of the settled motion {float(settled['mean'])}, end {end}", abs(float(settled["mean"]) - end) / 1e-6
    yield "resting", 0.0 if int(settled["resting"]) else np.inf
    if "film_voltage" in static:
        on_film = float(static["film_voltage"][0, k])
        held = run["film_voltage" if "film_voltage" in run else "drive_voltage"]
        yield f"voltage on the film {on_film}", abs(abs(float(held[-1])) - on_film) / 1e-6
    for flag in {"hoop_slack", "meridional_slack", "breakdown", "near_limit"} & set(run):
        same = bool(run[flag][-1]) == (float(static[f"validity_{flag}"][0, k]) > 0.0)
        yield f"{flag} at rest", 0.0 if same else np.inf


def safe_and_run(draw: Draw) -> Iterator[Difference]:
    """The safe peak, below which a run from rest meets no limit, and the first driven limit, above which it does."""
    own = actuator(draw, film="taut")
    model = ConeModel(**own | {"rest_height": abs(own["rest_height"])})
    found, rest = gelcone.operating_limits(model), float(gelcone.static(model, [0.0])["rest_displacement"])
    flags = {name: f"validity_{name}" for name in ("hoop_slack", "meridional_slack", "breakdown", "near_limit")}

    def met(peak: float) -> list[str]:
        share = peak / float(model.peak_voltage)
        driven = model.replace(voltage=share * model.voltage, voltage_bias=share * model.voltage_bias)
        run = gelcone.simulate(driven, (rest + 1e-3, 0.0), periods=80.0)
        ended = [] if int(run["outcome"]) == Outcome.OK else ["end"]
        return ended + [name for name, flag in flags.items() if float(run[flag]) > 0.0]

    safe, names = (
        float(found["safe_peak_voltage"]),
        (*tuple(flags)[:2], "dielectric_breakdown", "stretch_limit", "pull_in"),
    )
    if 0.0 < safe < np.inf:
        yield f"limits met below {safe}: {below}" if (below := met(0.999 * safe)) else "", np.inf if below else 0.0
    first = min(float(found[f"driven_{name}_voltage"]) for name in names)
    if first < np.inf and not float(found["driven_chaos_voltage"]) < first:
        above = met(first + 1.1 * float(found["driven_error_voltage"]))
        yield f"limits met above {first}: {above}", 0.0 if above else np.inf


KINDS: dict[str, Callable[[Draw], Any]] = {
    made.__name__.replace("_", " "): made
    for made in (
        other_sign, mirrored, exchanged, one_of_two, without_bias, at_one_voltage, pushed, in_tension, one_shape,
        twice_the_frequency, later_phase, negligible, in_an_ensemble, read_back, another_size, held_and_static,
        safe_and_run,
    )
}  # fmt: skip


def main(cases: int, seed: int, kinds: list[str]) -> int:
    """Compare twins, print differences beyond their bounds, and return the number of these."""
    wrong = 0
    for kind in kinds or KINDS:
        worst, count = ("", 0.0), 0
        for number in range(seed, seed + cases):
            made = KINDS[kind](Draw(number))
            for what, away in compared(made) if isinstance(made, Twin) else made:
                count, worst = count + 1, max(worst, (what, away), key=lambda one: one[1])
                if not away <= 1.0:
                    wrong += 1
                    print(f"{kind} {number}: {what}: {away:.1e} times the bound", flush=True)
        print(f"{kind:20} {count:6} compared, at most {worst[1]:.1e} of the bound ({worst[0][:60]})", flush=True)
    return wrong


if __name__ == "__main__":
    warnings.simplefilter("ignore")
    numbers = [int(text) for text in sys.argv[1:] if text.isdigit()]
    sys.exit(main(*(numbers + [8, 2026][len(numbers) :]), [text for text in sys.argv[1:] if not text.isdigit()]) > 0)
