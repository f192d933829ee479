"""What each function of FMI 2.0 and 3.0 answers, called as an importer calls it: values, statuses and messages."""

from __future__ import annotations

import ctypes
import re
import struct
import subprocess

import numpy as np
import pytest

import gelcone
from gelcone.codes import Outcome
from gelcone.devices.record import LARGEST
from gelcone.export import fmu
from gelcone.export.compiler import find_compiler
from gelcone.export.sources import Exported
from tests.export.instance import device

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="there is no C compiler here")
OK, WARNING, DISCARD, ERROR = range(4)
LOGGERS = {
    2: ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p,
                        ctypes.c_char_p),
    3: ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p, ctypes.c_char_p),
}  # fmt: skip
DRIVE = {
    "component": "samples", "shares": [0.0, 0.2, 0.45, 0.8, 1.0], "values": [0.0, 0.6, 1.0, -0.5, 0.0],
    "interpolation": "pchip", "repeat": True,
}  # fmt: skip
PUMP = {
    "film": "wrinkling", "meridional_prestretch": 1.0, "hoop_prestretch": 1.05, "waveform": DRIVE,
    "voltage_offset": 900.0, "voltage_amplitude": 200.0,
}  # fmt: skip
"""Its film has borders, and its drive, which is inside, cubic pieces with corners between them."""
BOTH = pytest.mark.parametrize("fmi", [2, 3])


class Callbacks(ctypes.Structure):
    """The callbacks of FMI 2.0."""

    _fields_ = [("logger", LOGGERS[2]), *((name, ctypes.c_void_p) for name in ("new", "free", "done", "environment"))]


class EventInfo(ctypes.Structure):
    """What FMI 2.0 says of events."""

    _fields_ = [*((name, ctypes.c_int) for name in ("again", "terminate", "nominals", "values", "next")),
                ("when", ctypes.c_double)]  # fmt: skip


def doubles(values):
    return (ctypes.c_double * max(len(values), 1))(*values)


def references(values):
    return (ctypes.c_uint * max(len(values), 1))(*values)


class Component:
    """A component behind the interface of one version: functions without their prefix give their status."""

    def __init__(self, library, exported, fmi, token, early=False):
        self.exported, self.fmi, self.logged = exported, fmi, []
        self.library = ctypes.CDLL(str(library))
        self.names = [variable.name for variable in exported.variables]

        def log2(_, name, status, category, form, text):
            self.logged.append((name, status, category, text))

        def log3(_, status, category, text):
            self.logged.append((b"one", status, category, text))

        self._log = LOGGERS[fmi](log2 if fmi == 2 else log3)
        if fmi == 2:
            self._calls = Callbacks(logger=self._log)
            given = b"one", 1, token.encode(), b"", ctypes.byref(self._calls), 0, 0
        else:
            given = (
                b"one",
                token.encode(),
                b"",
                False,
                False,
                False,
                early,
                None,
                ctypes.c_size_t(0),
                None,
                self._log,
                None,
            )
        make = self._function("Instantiate" if fmi == 2 else "InstantiateCoSimulation", ctypes.c_void_p)
        self.at = ctypes.c_void_p(make(*given))

    def _function(self, name, result):
        own = getattr(self.library, f"fmi{self.fmi}{name}")
        own.restype = result
        return own

    def __call__(self, name, *given):
        count = [ctypes.c_size_t(one) if isinstance(one, int) and not isinstance(one, bool) else one for one in given]
        sized = [ctypes.c_double(one) if isinstance(one, float) else one for one in count]
        return self._function(name, ctypes.c_int)(self.at, *sized)

    def begin(self, start=0.0):
        if self.fmi == 2:
            assert self("SetupExperiment", ctypes.c_int(0), 0.0, start, ctypes.c_int(0), 0.0) == OK
            assert self("EnterInitializationMode") == OK
        else:
            assert self("EnterInitializationMode", False, 0.0, start, False, 0.0) == OK
        return self("ExitInitializationMode")

    def get(self, places, kind="Real"):
        """Status and values of variables, by the function of one type."""
        names = {"Real": ("Real", "Float64"), "Integer": ("Integer", "Int32"), "Boolean": ("Boolean", "Boolean")}
        made = {"Real": ctypes.c_double, "Integer": ctypes.c_int}.get(
            kind, ctypes.c_int if self.fmi == 2 else ctypes.c_bool
        )
        values = (made * len(places))()
        more = [] if self.fmi == 2 else [len(places)]
        status = self(f"Get{names[kind][self.fmi == 3]}", references(places), len(places), values, *more)
        return status, list(values)

    def set(self, places, values):
        more = [] if self.fmi == 2 else [len(values)]
        return self(
            "SetReal" if self.fmi == 2 else "SetFloat64", references(places), len(places), doubles(values), *more
        )

    def __getitem__(self, name):
        kind = next(own.kind for own in self.exported.variables if own.name == name)
        flag = kind == "code" and name != "outcome" and not name.endswith("film_state")
        status, (value,) = self.get(
            [self.names.index(name)], "Boolean" if flag else "Integer" if kind == "code" else "Real"
        )
        assert status == OK
        return value

    def __setitem__(self, name, value):
        assert self.set([self.names.index(name)], [value]) == OK

    def step(self, now, size, early=None):
        """Status; of FMI 3.0 whether the step ended the simulation, whether it was early, and its last time."""
        if self.fmi == 2:
            return self("DoStep", now, size, ctypes.c_int(1))
        event, terminate, early = (ctypes.c_bool(True) for _ in range(3))
        last = ctypes.c_double()
        given = [ctypes.byref(one) for one in (event, terminate, early, last)]
        self.ended = lambda: (event.value, terminate.value, early.value, last.value)
        return self("DoStep", now, size, True, *given)

    def update(self):
        """Whether to repeat, to terminate, nominals or values change and another event follows, and when."""
        if self.fmi == 2:
            info = EventInfo(1, 0, 1, 1, 0, 0.0)
            assert self("NewDiscreteStates", ctypes.byref(info)) == OK
            flags = info.again, info.terminate, info.nominals, info.values, info.next
            return (*map(bool, flags), info.when if info.next else None)
        flags, when = [ctypes.c_bool(True) for _ in range(5)], ctypes.c_double()
        assert self("UpdateDiscreteStates", *(ctypes.byref(one) for one in (*flags, when))) == OK
        again, terminate, nominals, values, following = (one.value for one in flags)
        return again, terminate, nominals, values, following, when.value if following else None

    def completed(self):
        """Whether an integrator's step enters an event, and whether it ends the simulation."""
        enter, end = ((ctypes.c_int if self.fmi == 2 else ctypes.c_bool)(1) for _ in range(2))
        assert self("CompletedIntegratorStep", ctypes.c_int(1), ctypes.byref(enter), ctypes.byref(end)) == OK
        return bool(enter.value), bool(end.value)


@pytest.fixture(scope="module")
def libraries(tmp_path_factory):
    """The library of a version, compiled without optimisation: driven from inside or by its input."""
    found = {}

    def of(fmi, inside=True):
        if (fmi, inside) not in found:
            folder = tmp_path_factory.mktemp(f"fmi{fmi}-{inside}")
            exported = Exported(device(**(PUMP if inside else {"film": "taut"})), "pump", inside, 1e-7)
            for name, text in fmu._contents(exported, fmi).items():
                if name.startswith("sources/"):
                    (folder / name.rpartition("/")[2]).write_text(text, encoding="utf-8")
            flags = ["-std=c99", "-O0", "-ffp-contract=off", "-fPIC", "-shared", "-o", "pump.so", f"fmi{fmi}.c", "-lm"]
            subprocess.run([*find_compiler(), *flags], cwd=folder, check=True)
            token = re.search(r'"(\{\w{32}\})"', (folder / "fmu.c").read_text(encoding="utf-8"))[1]
            found[fmi, inside] = folder / "pump.so", exported, fmi, token
        return found[fmi, inside]

    return of


@pytest.fixture
def made(libraries):
    """A component, which is freed at the end; without ``start`` it is not begun."""
    found = []

    def of(fmi, inside=True, start=0.0, early=False):
        found.append(Component(*libraries(fmi, inside), early=early))
        assert found[-1].at.value
        if start is not None:
            assert found[-1].begin(start) == OK
        return found[-1]

    yield of
    for one in found:
        one._function("FreeInstance", None)(one.at)


def drive(one, time):
    """The voltage of the device's own drive."""
    model, scales = one.exported.model, one.exported.device.scales
    waveform = model.system.waveform
    values = {name: np.asarray(value, dtype=float) for name, value in model.values.items()}
    return float(waveform.voltage(time / scales.time, waveform.numbers(values))) * scales.voltage


@BOTH
def test_an_instance_is_that_of_its_token_and_says_its_version(fmi, libraries, made):
    one = made(fmi)
    assert one._function("GetVersion", ctypes.c_char_p)() == {2: b"2.0", 3: b"3.0"}[fmi]
    library, exported, _, token = libraries(fmi)
    assert Component(library, exported, fmi, token.replace("{", "[")).at.value is None
    names = (ctypes.c_char_p * 1)(b"logStatusError")
    assert one("SetDebugLogging", ctypes.c_int(1), 1, names) == OK
    if fmi == 2:
        assert one._function("GetTypesPlatform", ctypes.c_char_p)() == b"default"
        return
    made_ = one._function("InstantiateModelExchange", ctypes.c_void_p)
    other = ctypes.c_void_p(made_(b"two", token.encode(), b"", False, False, None, one._log))
    assert other.value
    one._function("FreeInstance", None)(other)
    assert one._function("InstantiateScheduledExecution", ctypes.c_void_p)(
        b"three", token.encode(), b"", False, False, None, one._log, None, None, None
    ) is None  # fmt: skip
    for name in ("Terminate", "EnterConfigurationMode", "ExitConfigurationMode", "EvaluateDiscreteStates"):
        assert one(name) == OK


@BOTH
def test_states_rates_and_nominals_are_those_of_the_device(fmi, made):
    one = made(fmi)
    right, scales = gelcone.rates(one.exported.device), one.exported.device.scales
    count, buffer = len(right.states), doubles([0.0, 0.0])
    derivatives = "GetDerivatives" if fmi == 2 else "GetContinuousStateDerivatives"
    assert one("GetContinuousStates", buffer, count) == OK
    assert list(buffer) == pytest.approx(list(right.start), rel=1e-12)
    y, time = [0.011, 0.2], 0.013
    assert one("SetTime", time) == OK
    assert one["time"] == time
    assert one("SetContinuousStates", doubles(y), count) == OK
    assert one["displacement"] == pytest.approx(0.011, rel=1e-15)
    assert one(derivatives, buffer, count) == OK
    assert list(buffer) == pytest.approx(list(right(time, y)), rel=1e-9)
    assert one("GetNominalsOfContinuousStates", buffer, count) == OK
    assert list(buffer) == pytest.approx([scales.length, scales.velocity], rel=1e-12)
    for name in ("GetContinuousStates", "SetContinuousStates", derivatives, "GetNominalsOfContinuousStates"):
        for other in (count - 1, count + 1):
            assert one(name, doubles([0.0] * 4), other) == ERROR, name
    assert one["displacement"] == pytest.approx(0.011, rel=1e-15)
    if fmi == 3:
        size = ctypes.c_size_t()
        assert one("GetNumberOfContinuousStates", ctypes.byref(size)) == OK
        assert size.value == count
    one("SetContinuousStates", doubles([1e200, 0.0]), count)
    assert one(derivatives, buffer, count) == DISCARD


@BOTH
def test_a_border_that_is_crossed_is_an_event_after_which_its_law_holds(fmi, made):
    one = made(fmi)
    borders = len(one.exported.program.border_switches)
    values = doubles([0.0] * borders)

    def indicators():
        assert one("GetEventIndicators", values, borders) == OK
        if fmi == 3:
            status, same = one.get([len(one.names) + k for k in range(borders)])
            assert (status, same) == (OK, list(values))
        return list(values)

    assert min(indicators()) > 0.0
    assert one["film_state"] == 0
    one["voltage"] = 1000.0  # added to the drive
    assert min(indicators()) < 0.0
    assert one["film_state"] == 0
    assert one.completed() == (False, False)
    assert one.update()[:4] == (False, False, False, False)
    assert min(indicators()) > 0.0
    assert (one["film_state"], one["film_is_slack"], one["valid"]) == (1, True, True)
    assert one("GetEventIndicators", values, borders + 1) == ERROR
    if fmi == 3:
        assert one.get([len(one.names) + borders])[0] == ERROR
        size = ctypes.c_size_t()
        assert one("GetNumberOfEventIndicators", ctypes.byref(size)) == OK
        assert size.value == borders


@BOTH
def test_the_next_event_is_the_next_corner_of_the_drive_inside(fmi, made):
    one, period = made(fmi), 1.0 / device(**PUMP).frequency
    begins = one.exported.pieces.begins / (2.0 * np.pi)
    corners = period * np.sort(np.concatenate([(begins % 1.0) + k for k in range(4)]))
    for time in (0.0, 0.013, 0.019, 0.034, 0.047, 0.0651, 0.077, 0.091, 0.151, 0.2449):
        one("SetTime", time)
        assert one.update()[4:] == (True, pytest.approx(corners[corners > time + 1e-9][0], abs=1e-9))
        assert one["film_voltage"] == pytest.approx(drive(one, time), abs=1e-6)
    assert made(fmi, inside=False).update() == (False, False, False, False, False, None)


@BOTH
def test_a_start_and_steps_are_at_the_time_that_was_said(fmi, made):
    one = made(fmi, start=0.013)
    assert one["time"] == 0.013
    assert one["film_voltage"] == pytest.approx(drive(one, 0.013), abs=1e-6)
    assert one.step(0.031, 0.02) == OK
    assert one["time"] == pytest.approx(0.051, rel=1e-15)
    assert one["film_voltage"] == pytest.approx(drive(one, 0.051), abs=1e-6)
    if fmi == 3:
        assert one.ended() == (False, False, False, pytest.approx(0.051, rel=1e-15))
    one["moving_mass"] = 0.02
    assert one("Reset") == OK
    assert (one["time"], one["moving_mass"], one["velocity"]) == (0.0, one.exported.device.moving_mass, 0.0)
    for now, size in ((0.0, -1e-3), (0.0, np.nan), (0.0, np.inf), (np.inf, 1e-3), (np.nan, 1e-3)):
        assert one.step(float(now), float(size)) == ERROR
        assert b"refused" in one.logged.pop()[3]
    assert one["time"] == 0.0


@BOTH
@pytest.mark.parametrize("early", [False, True])
def test_an_end_is_reported_with_its_words_and_time(fmi, early, made):
    one = made(fmi, early=early)
    film = one.exported.system.films[0]
    reach = float(film.film.reach(film.own(one.exported.numbers()))[1]) * one.exported.device.scales.length
    words = (b"one", ERROR, b"logStatusError", Outcome.STRETCH_LIMIT.meaning.encode())
    one("SetContinuousStates", doubles([0.9999 * reach, 0.0]), 2)
    assert one.completed() == (False, False)
    one("SetContinuousStates", doubles([1.0001 * reach, 0.0]), 2)
    assert one.completed() == (False, True)
    assert one["outcome"] == Outcome.STRETCH_LIMIT
    assert one.update()[:4] == (False, True, False, False)
    assert one.logged == []
    one("Reset")
    one("SetContinuousStates", doubles([1.0001 * reach, 0.0]), 2)
    assert one("ExitInitializationMode") == ERROR
    assert one.logged.pop() == words
    assert one.step(0.25, 1.0) == (DISCARD if fmi == 2 else WARNING)
    assert one.logged.pop() == (words[0], DISCARD if fmi == 2 else WARNING, *words[2:])
    one("Reset")
    one["voltage_rate"] = 2e4
    assert one.step(0.25, 1.0) == (DISCARD if fmi == 2 else WARNING)
    assert 0.25 < one["time"] < 0.4
    assert one["outcome"] == Outcome.PULLED_IN
    assert one.logged.pop()[3] == Outcome.PULLED_IN.meaning.encode()
    if fmi == 3:
        assert one.ended() == (False, True, early, one["time"])


@BOTH
def test_every_variable_is_read_by_the_function_of_its_type_and_set_where_it_may_be(fmi, made):
    one = made(fmi)
    settable = {"input", "state", "parameter"}
    for place, own in enumerate(one.exported.variables):
        flag = own.kind == "code" and own.name in ("film_is_slack", "breakdown", "near_limit", "valid")
        kind = "Boolean" if flag else "Integer" if own.kind == "code" else "Real"
        for other in ("Real", "Integer", "Boolean"):
            status, (value,) = one.get([place], other)
            assert status == (OK if other == kind else ERROR), own.name
            if other == kind == "Real":
                assert one.set([place], [value]) == (OK if own.kind in settable else ERROR), own.name
    assert one.set([0, 1], [5.0, 7.0]) == OK
    assert one.get([1, 0]) == (OK, [7.0, 5.0])
    end = len(one.names) + (len(one.exported.program.border_switches) if fmi == 3 else 0)
    for place in (end, 2**31, 2**32 - 1):
        assert [one.get([place], kind)[0] for kind in ("Real", "Integer", "Boolean")] == [ERROR] * 3
        assert one.set([place], [0.0]) == ERROR
    assert b"refused" in one.logged[-1][3]


@BOTH
def test_what_there_is_not_is_an_error_unless_nothing_was_asked(fmi, made):
    one, room = made(fmi), (ctypes.c_uint64 * 4)()
    none = ["GetString", "SetInteger", "SetBoolean", "SetString"]
    if fmi == 3:
        types = [f"{sign}Int{size}" for sign in ("", "U") for size in (8, 16, 32, 64) if (sign, size) != ("", 32)]
        none = [f"{way}{kind}" for way in ("Get", "Set") for kind in ("Float32", *types, "String")]
        none += ["SetInt32", "SetBoolean"]
    for name in none:
        more = [] if fmi == 2 else [1]
        assert one(name, references([4]), 1, room, *more) == ERROR, name
        assert one(name, references([4]), 0, room, *more) == OK, name
    if fmi == 2:
        given = references([0]), 1, references([4]), 1, doubles([1.0]), doubles([1.0])
        assert one("GetDirectionalDerivative", *given) == ERROR
        assert one("GetRealOutputDerivatives", references([4]), 1, (ctypes.c_int * 1)(1), doubles([0.0])) == ERROR
        assert one("CancelStep") == ERROR
        return
    for name in ("GetClock", "SetClock"):
        assert [one(name, references([4]), count, room) for count in (1, 0)] == [ERROR, OK]
    for name in ("GetBinary", "SetBinary"):
        assert [one(name, references([4]), count, room, room, 1) for count in (1, 0)] == [ERROR, OK]
    for name in ("GetDirectionalDerivative", "GetAdjointDerivative"):
        assert one(name, references([0]), 1, references([4]), 1, doubles([1.0]), 1, doubles([1.0]), 1) == ERROR
    assert one("GetOutputDerivatives", references([4]), 1, (ctypes.c_int * 1)(1), doubles([0.0]), 1) == ERROR
    for name in ("GetIntervalDecimal", "GetShiftDecimal", "SetIntervalDecimal", "SetShiftDecimal",
                 "GetIntervalFraction", "GetShiftFraction", "SetIntervalFraction", "SetShiftFraction"):  # fmt: skip
        assert one(name, references([4]), 1, room, room, room) == ERROR
    assert one("GetNumberOfVariableDependencies", ctypes.c_uint(4), room) == ERROR
    assert one("GetVariableDependencies", ctypes.c_uint(4), room, room, room, room, 1) == ERROR
    assert one("ActivateModelPartition", ctypes.c_uint(0), 0.0) == ERROR


def test_slopes_of_inputs_and_statuses_of_fmi_2(made):
    one = made(2, inside=False)
    place = one.names.index

    def slope(name, order, value):
        return one("SetRealInputDerivatives", references([place(name)]), 1, (ctypes.c_int * 1)(order), doubles([value]))

    assert [slope("voltage", 1, 3e3), slope("external_force", 1, 0.5)] == [OK, OK]
    assert (one["voltage_rate"], one["external_force_rate"]) == (3e3, 0.5)
    assert [slope(*given) for given in (("voltage", 2, 1.0), ("voltage_rate", 1, 1.0), ("displacement", 1, 1.0))] == [
        ERROR
    ] * 3
    assert slope("voltage", 1, np.nan) == ERROR
    assert b"refused" in one.logged.pop()[3]
    assert one.step(0.0, 0.01) == OK
    assert (one["voltage"], one["external_force"]) == pytest.approx((30.0, 5e-3), rel=1e-12)
    real, whole, truth, text = ctypes.c_double(), ctypes.c_int(), ctypes.c_int(1), ctypes.c_char_p()
    assert [one("GetRealStatus", ctypes.c_int(k), ctypes.byref(real)) for k in range(4)] == [
        DISCARD,
        DISCARD,
        OK,
        DISCARD,
    ]
    assert real.value == one["time"]
    statuses = [one("GetBooleanStatus", ctypes.c_int(k), ctypes.byref(truth)) for k in range(4)]
    assert (statuses, truth.value) == ([DISCARD, DISCARD, DISCARD, OK], 0)
    for name, value in (("GetStatus", whole), ("GetIntegerStatus", whole), ("GetStringStatus", text)):
        assert [one(name, ctypes.c_int(k), ctypes.byref(value)) for k in range(4)] == [DISCARD] * 4
    one["voltage"] = 1e6
    one.step(0.01, 0.1)
    assert one("GetBooleanStatus", ctypes.c_int(3), ctypes.byref(truth)) == OK
    assert truth.value == 1


@BOTH
def test_a_stored_state_is_whole_and_each_part_of_it_within_its_bounds(fmi, made):
    """As bytes: time, inputs, parameters, states, switches and outcome."""
    one = made(fmi)
    exported, names = one.exported, ("FMUstate", "FMUState")
    kept, size = ctypes.c_void_p(), ctypes.c_size_t()
    state = names[fmi == 3]
    write, read = f"Serialize{state}", f"{'DeSerialize' if fmi == 2 else 'Deserialize'}{state}"
    one["voltage"] = 12.0
    one.step(0.0, 0.02)
    assert one(f"Get{state}", ctypes.byref(kept)) == OK
    assert one(f"Serialized{state}Size", kept, ctypes.byref(size)) == OK
    parameters, states, switches = (
        len(exported.parameters.values),
        len(exported.system.states),
        len(exported.program.switches),
    )
    form = f"<{1 + 4 + parameters + states + switches}dq"
    assert size.value == struct.calcsize(form)
    room = (ctypes.c_char * size.value)()
    assert one(write, kept, room, size.value - 1) == ERROR
    assert one(write, None, room, size.value) == ERROR
    assert one(write, kept, room, size.value) == OK
    numbers = list(struct.unpack(form, room.raw))
    assert numbers[:2] == [0.02, 12.0]
    assert numbers[5 : 5 + parameters] == list(exported.parameters.values.values())
    first = 5 + parameters
    assert numbers[first] * exported.device.scales.length == pytest.approx(one["displacement"], rel=1e-12)
    one["voltage"] = 100.0
    one.step(0.02, 0.02)
    assert one(f"Set{state}", None) == ERROR
    assert one(f"Set{state}", kept) == OK
    assert (one["time"], one["voltage"]) == (0.02, 12.0)

    def taken(place, value, more=b""):
        own = list(numbers)
        own[place] = value
        data = struct.pack(form, *own) + more
        found = ctypes.c_void_p()
        status = one(read, data, len(data), ctypes.byref(found))
        assert bool(found.value) == (status == OK)
        if status == OK:
            assert one(f"Free{state}", ctypes.byref(found)) == OK
            assert found.value is None
        return status

    mass, last = 5 + list(exported.parameters.values).index("moving_mass"), len(numbers) - 1
    damping = 5 + list(exported.parameters.values).index("damping_coefficient")
    good = [
        (0, -1.0),
        (1, -LARGEST),
        (mass, 1e-9),
        (damping, 0.0),
        (first, 3.0),
        (last - 1, -1.0),
        (last, 6),
        (last, 0),
    ]
    assert [taken(*own) for own in good] == [OK] * len(good)
    bad = [(0, np.inf), (0, np.nan), (1, np.inf), (4, np.nan), (mass, 0.0), (mass, np.inf), (damping, -1e-9),
           (first, np.nan), (first + 1, np.inf), (last - 1, 0.5), (last - 1, 0.0), (last, 7), (last, -1)]  # fmt: skip
    for own in bad:
        assert taken(*own) == ERROR, own
        assert one.logged.pop()[3] == b"these bytes are not a state of this model"
    assert taken(0, 0.0, b"\0" * 8) == ERROR
    assert one.logged.pop()[3] == b"a state of another size, of another model"
    assert one(f"Free{state}", ctypes.byref(kept)) == OK
    assert kept.value is None
