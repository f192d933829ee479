"""Programs as text: formulas at a point against NumPy, runs of one member, and what a translation is told."""

import ctypes
from dataclasses import dataclass

import numpy as np
import pytest

import gelcone
from gelcone.motion.engine import compile as compiler
from gelcone.motion.engine.interruptions import border_events, switches_at
from gelcone.motion.engine.plan import ARRIVED, Job
from gelcone.motion.engine.portable import formulas_text, portable
from gelcone.motion.engine.program import Program
from gelcone.physics.film.film import Border
from gelcone.physics.trace import Graph
from tests.toys import PowerFilm

TAUT = gelcone.ConeModel(rest_height=0.4, voltage=0.7, voltage_bias=0.2, damping_ratio=0.1, hoop_prestretch=1.2)
LAWS = gelcone.ConeModel(
    film="wrinkling", rest_height=0.4, voltage=0.5, voltage_bias=0.1, viscous_modulus_1=0.5, relaxation_time_1=3.0,
    circuit="amplifier", filter_time=0.3, slew_rate=0.8,
)  # fmt: skip


def outputs(model):
    """The voltage with its rate, the velocity with its rate and the displacement, and two without."""

    def wanted(time, z, n, xp):
        (voltage,) = model.system.voltages(time, z, n, xp)
        own = {"voltage": (voltage, 0.0), "square": (z[0] * z[0], None), "twice": (2.0, None)}
        return own | {"speed": (z[1], z[0])}

    return wanted


def compiled(text):
    intrinsics = "declare double @llvm.fma.f64(double, double, double)\n"
    intrinsics += "declare double @llvm.sqrt.f64(double)\ndeclare double @llvm.fabs.f64(double)\n"
    return compiler.Library(compiler.object_code(intrinsics + text, compiler.host(), compiler.COLD), compiler.host())


def at_a_point(text, law, z, time, numbers, switches):
    """What the function of a law writes, by name."""
    own = [np.array(values, dtype=float) for values in (z, numbers, switches)]
    roots = np.full(max(text.sizes["roots"], 1), np.nan)
    out = np.full(len(text.outputs) + 1, -7.0)
    library = compiled(text.points[law])  # its code is freed with it
    function = library.function(f"point_{law}", None, ctypes.c_void_p, ctypes.c_double, *[ctypes.c_void_p] * 4)
    function(own[0].ctypes.data, time, *(a.ctypes.data for a in (own[1], own[2], roots, out)))
    assert out[-1] == -7.0
    return dict(zip(text.outputs, out[:-1], strict=True))


def law_of(text, switches):
    return sum(1 << k for k, place in enumerate(text.telling) if switches[place] < 0.0)


@dataclass(frozen=True)
class Stopped(PowerFilm):
    """A power film with a mark at x = 0.1, which changes nothing, and a stop at x = -0.1, which alone divides laws."""

    borders = (
        Border(lambda x, squared, y, n, xp: n["mark"] * (0.1 - x), "mark"),
        Border(lambda x, squared, y, n, xp: n["stop"] * (0.1 + x), "stop", divides=True),
    )

    def numbers(self, parameters):
        return super().numbers(parameters) | {"mark": 1.0, "stop": 1.0}

    def switches(self, x, squared, y, n):
        return {"mark": np.where(x > 0.1, -1.0, 1.0), "stop": np.where(x < -0.1, -1.0, 1.0)}

    def odd(self, n):
        return False

    def force(self, x, squared, y, n, xp=np):
        force, slope = super().force(x, squared, y, n, xp)
        beyond = 0.5 - 0.5 * n.get("stop", 1.0)
        return force + 3.0 * beyond * (x + 0.1), slope + 3.0 * beyond


STOPPED = gelcone.ConeModel(film=Stopped(), voltage=0.4)


@pytest.mark.parametrize(("model", "laws"), [(TAUT, 1), (LAWS, 4), (STOPPED, 2)], ids=["taut", "laws", "one of two"])
def test_formulas_at_a_point_are_those_of_the_system(model, laws):
    """Rates, outputs with their rates along the motion, and borders, under the law that the switches tell."""
    system, n = model.system, model.members().numbers()
    text = portable(system, outputs(model), 1e-6)
    assert text.numbers == tuple(system.numbers)
    assert len(text.points) == text.sizes["laws"] == laws
    rng, seen = np.random.default_rng(3), set()
    for _ in range(6):
        time, z = rng.uniform(0.0, 4.0), rng.uniform(-0.8, 0.8, len(system.states))
        if len(z) > 2:
            z[2:4] = 1.0 + 0.2 * z[2:4]
        sides = switches_at(system, np.array([time]), z[None], n)
        switches = [float(sides[name][0]) for name in text.switches]
        seen.add(law := law_of(text, switches))
        numbers = [float(n[name][0]) for name in text.numbers]
        found = at_a_point(text, law, z, time, numbers, switches)
        own = {name: float(value[0]) for name, value in n.items()} | {k: float(v[0]) for k, v in sides.items()}
        rates = [float(rate) for rate in system.rates(time, list(z), own)]
        np.testing.assert_allclose([found[f"rate_{k}"] for k in range(len(z))], rates, rtol=1e-9, atol=1e-12)
        assert found["voltage"] == pytest.approx(float(system.voltages(time, list(z), own)[0]), rel=1e-12)
        assert found["voltage_rate"] == pytest.approx(float(system.voltage_rates(time, list(z), own)[0]), rel=1e-10)
        assert found["square"] == pytest.approx(z[0] ** 2, rel=1e-15)
        assert found["twice"] == 2.0
        assert found["speed_rate"] == pytest.approx(rates[1] + z[0], rel=1e-9, abs=1e-12)
        borders = [border.value(time, list(z), own, np) for _, border in system.borders]
        np.testing.assert_allclose([found[f"border_{k}"] for k in range(len(borders))], borders, rtol=1e-8, atol=1e-10)
    assert len(seen) == 1 or laws > 1
    names = [f"rate_{k}" for k in range(len(system.states))] + ["voltage", "voltage_rate", "square", "twice"]
    names += ["speed", "speed_rate"]
    assert text.outputs == (*names, *(f"border_{k}" for k in range(len(system.borders))))


def test_what_a_translation_is_told_is_the_plan_of_one_lane():
    system = LAWS.system
    text = portable(system, outputs(LAWS), 1e-6)
    plan = Program(system, "states", 1e-6, border_events(system))._plan(1)
    names = [node.value for node in plan.switches]
    assert text.switches == tuple(names)
    assert text.telling == plan.telling
    switched = [names.index(border.switch) if border.switch else -1 for _, border in system.borders]
    assert list(text.border_switches) == switched
    assert min(switched) == -1 < max(switched)
    assert len(text.modules) == 1 + len(plan.laws)
    assert {f"job_{field.name.lower()}": int(field) for field in Job}.items() <= text.sizes.items()
    assert text.sizes["job"] == len(Job)
    assert text.sizes["states"] == len(system.states)
    assert text.sizes["combinations"] == 2 ** len(names)
    assert text.sizes["roots"] == 2
    assert len(portable(TAUT.system, outputs(TAUT), 1e-6).modules) == 1


def test_numbers_that_nothing_takes_are_not_among_those_used():
    """Without voltage nothing takes the drive's; the damping and the spring are taken."""
    text = portable(TAUT.system, lambda time, z, n, xp: {}, 1e-6)
    assert text.used <= set(text.numbers)
    assert {"damping_ratio", "spring_stiffness", "voltage", "drive_frequency"} <= text.used
    more = portable(gelcone.ConeModel(circuit="amplifier", slew_rate=0.8, filter_time=0.3).system, lambda *_: {}, 1e-6)
    assert "slew_rate" in more.used
    assert not set(more.switches) & more.used


def test_numbers_that_outputs_alone_take_are_among_those_used():
    """A leak behind no resistance moves nothing; a current takes its time."""
    system = gelcone.ConeModel(rest_height=0.4, leakage_time=2.0).system
    assert "leakage_time" not in portable(system, lambda *_: {}, 1e-6).used
    text = portable(system, lambda time, z, n, xp: {"leak": (system.leaks(time, z, n, xp)[0], None)}, 1e-6)
    assert "leakage_time" in text.used


@pytest.mark.parametrize("model", [TAUT, LAWS], ids=["taut", "laws"])
def test_a_run_of_one_member_is_that_of_a_program(model):
    system, n = model.system, model.members().numbers()
    text = portable(system, outputs(model), 1e-8)
    start = model.members().start_states((0.4, 0.1))[0]
    sides = switches_at(system, np.zeros(1), start[None], n)
    numbers = {name: float(n[name][0]) for name in system.numbers} | {k: float(v[0]) for k, v in sides.items()}
    ended = text.run(numbers, start, 2.5, 2e-8, 1e6)
    raw = Program(system, "states", 1e-8, border_events(system)).run(numbers, start[None], 0.0, [[2.5]])
    assert (ended.status, ended.time) == (ARRIVED, 2.5)
    np.testing.assert_array_equal(ended.states, raw.states[0, 0])
    assert ended.switches == {name: value[0] for name, value in raw.switches.items()}
    few = text.run(numbers, start, 2.5, 2e-8, 3)
    assert few.status != ARRIVED
    assert 0.0 < few.time < 2.5
    assert np.isfinite(few.states).all()


def test_formulas_are_written_to_their_places():
    graph = Graph()
    a, b = graph.number("a"), graph.number("b")
    text = formulas_text("made", ("b", "a"), {2: a * b - graph.sin(b), 0: graph.sqrt(a) / b})
    found, given = np.full(4, -7.0), np.array([0.3, 2.0])
    library = compiled(text)
    library.function("made", None, ctypes.c_void_p, ctypes.c_void_p)(given.ctypes.data, found.ctypes.data)
    np.testing.assert_allclose(found, [np.sqrt(2.0) / 0.3, -7.0, 0.6 - np.sin(0.3), -7.0], rtol=1e-14)
