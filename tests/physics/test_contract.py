"""What is refused of a component of one's own when its class is read: in one line, with class, formula and remedy."""

import sys
from dataclasses import dataclass

import numpy as np
import pytest

from gelcone.devices.device import find_device
from gelcone.errors import InputError
from gelcone.physics.bias import BIASES, Bias, LinearSpring, Together
from gelcone.physics.circuit import Circuit
from gelcone.physics.component import State
from gelcone.physics.contract import DEFAULTS, numbers_of, points_of
from gelcone.physics.drive import VOLTAGE, Pieced, Waveform
from gelcone.physics.film.film import Film
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.film.taut import TautCone
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.laws import LAWS, StrainEnergyLaw
from gelcone.physics.model import ConeModel
from gelcone.physics.records import CIRCUITS, FILMS, find_bias
from gelcone.physics.waveforms import WAVEFORMS
from gelcone.quantity import Quantity
from tests.toys import TOYS, TurningBias

PULL = {"pull": Quantity("k", "stiffness", 0.2)}
FILTER = {"filter_time": Quantity("t", "time constant", 0.3, positive=True)}
LAG = (State("lag", "displacement that it follows"),)


class Pulls(Bias):
    name = "pulls"
    parameters = PULL

    def force(self, x, y, n, xp=np):
        return n["pull"] * x, n["pull"]


class Hangs(Film):
    name = "hangs"

    def force(self, x, squared, y, n, xp=np):
        return (2.0 - squared) * x, 2.0 - squared + 0.0 * x


class Hums(Waveform):
    name = "hums"

    def shape(self, phase, n, xp=np):
        return xp.sin(phase) + 0.3 * xp.sin(2.0 * phase)

    def shape_rate(self, phase, n, xp=np):
        return xp.cos(phase) + 0.6 * xp.cos(2.0 * phase)


class Soft(StrainEnergyLaw):
    name = "soft"

    def energy(self, strain, n, xp=np):
        return 0.5 * strain

    def response(self, strain, n, xp=np):
        return 1.0 + 0.0 * strain

    def response_slope(self, strain, n, xp=np):
        return 0.0 * strain


class Filters(Circuit):
    name = "filters"
    parameters = FILTER
    states = (State("film_voltage", "voltage on the film", "voltage"),)

    def voltage(self, port, y, n, xp=np):
        return y[0]

    def rates(self, port, y, n, xp=np):
        return [(port.command - y[0]) / n["filter_time"]]

    def time_constant(self, n):
        return n["filter_time"]


KINDS = {Pulls: "bias", Hangs: "film", Hums: "waveform", Soft: "law", Filters: "circuit"}
every_kind = pytest.mark.parametrize("own", KINDS)


def other(base, **changes):
    """A class derived from ``base`` that is named Wrong, with other attributes and methods."""
    return type("Wrong", (base,), changes)


def model_of(component):
    kind = next(kind for base, kind in KINDS.items() if isinstance(component, base))
    return ConeModel(film=TautCone(law=component)) if kind == "law" else ConeModel(**{kind: component})


def refused(own):
    with pytest.raises(InputError) as error:
        model_of(own())
    text = str(error.value)
    assert "\n" not in text
    return text


@every_kind
def test_the_classes_that_follow_are_taken_as_they_are(own):
    model_of(own())


def test_an_own_component_is_proved_once_at_its_defaults_and_at_two_points():
    proved = []
    own = other(Pulls, prove=lambda self, given=DEFAULTS: proved.append(dict(given)))
    for _ in range(2):
        ConeModel(bias=own())
    assert proved == [{}, {"pull": 0.2 * 1.27}, {"pull": 0.2 / 1.27}]


def test_the_points_near_the_defaults_lie_inside_the_bounds_and_are_those_that_a_component_takes():
    """Neighbours move apart, so that their products and quotients change."""
    named = {
        "one": Quantity("a", "a", 2.0, positive=True), "two": Quantity("b", "b", -1.0, lower=-1.0),
        "none": Quantity("c", "c", 0.0, lower=0.5), "endless": Quantity("d", "d", np.inf, infinite=True),
    }  # fmt: skip
    first, second = points_of(other(Pulls, parameters=named)())
    assert first == pytest.approx({"one": 2.54, "two": -1.0 / 1.27, "none": 0.5, "endless": 0.1 / 1.27})
    assert second == pytest.approx({"one": 2.0 / 1.27, "two": -1.0, "none": 0.5, "endless": 0.127})
    assert points_of(Soft()) == []

    def complete(self, given):
        if given.get("pull", 0.2) > 0.2:
            raise InputError("too large")
        return {"pull": 0.2, **given}

    assert points_of(other(Pulls, complete=complete)()) == [{"pull": 0.2 / 1.27}]


def test_a_contradiction_away_from_the_defaults_is_refused_with_the_point():
    def force(self, x, y, n, xp=np):
        return n["pull"] ** 2 * x, n["pull"] + 0.0 * x

    bad = other(Pulls, force=force, parameters={"pull": Quantity("k", "stiffness", 1.0)})
    with pytest.raises(InputError, match=r"Wrong.force, its slope .*\(it is right at the defaults, and wrong at pull"):
        ConeModel(bias=bad())


@pytest.mark.parametrize("which", [0, 1])
def test_a_bias_that_returns_nan_is_refused_by_its_formula(which):
    def force(self, x, y, n, xp=np):
        found = [0.2 * x, 0.2 + 0.0 * x]
        found[which] = found[which] + 0.0 * xp.sqrt(0.3 - x)
        return tuple(found)

    with pytest.raises(
        InputError,
        match=r"Wrong.force: is NaN at x = 0.375; return a finite number for every x from -1.5 to 1.5 \(continue",
    ):
        ConeModel(bias=other(Pulls, force=force)())


def test_a_film_of_which_no_highest_voltage_is_known_is_refused():
    with pytest.raises(InputError, match=r"Wrong.highest_squared: is NaN at x = 0; return infinity if no voltage"):
        ConeModel(film=other(Hangs, highest_squared=lambda self, x, n: np.where(np.abs(x) > 0.0, np.inf, np.nan))())


@pytest.mark.parametrize("held", [Together, TautCone])
def test_a_part_of_a_component_is_proved_too(held):
    bad = other(Pulls, odd=False)() if held is Together else other(Soft, strain_limit=3.0)()
    with pytest.raises(InputError, match=r"Wrong\.(odd: is False|strain_limit: is 3.0), and must be a method"):
        ConeModel(bias=Together((LinearSpring(), bad))) if held is Together else ConeModel(film=TautCone(law=bad))


SHIPPED = [*LAWS.values(), *BIASES.values(), *FILMS.values(), *WAVEFORMS.values(), *CIRCUITS.values()]


@pytest.mark.parametrize(
    "component",
    [
        *SHIPPED,
        TautCone(branches=2),
        WrinklingCone(branches=1),
        MembraneFilm(branches=1),
        Together((LinearSpring(), TurningBias())),
        *(part for toy in TOYS.values() for part in toy.values()),
    ],
    ids=lambda component: f"{component.name}{getattr(component, 'branches', '') or ''}",
)
def test_what_ships_keeps_its_contract(component):
    component.prove()
    for given in points_of(component):
        component.prove(given)


# --- a value for a method, a method for a value, other arguments ------------------------------------------------------


@pytest.mark.parametrize("base", [Pulls, Hangs])
def test_odd_is_one_method_for_films_and_biases(base):
    """A value is refused when the class is read, not when an analysis calls it."""
    text = refused(other(base, odd=False))
    assert text == "Wrong.odd: is False, and must be a method; write def odd(self, n): return False"
    assert not other(base, odd=lambda self, n: False)().odd({})
    model_of(other(base, odd=lambda self, n: False)())


def test_a_device_refuses_it_before_anything_is_computed(monkeypatch):
    monkeypatch.setitem(sys.modules, "own_parts", type("Module", (), {"Wrong": other(Pulls, odd=False)}))
    with pytest.raises(InputError, match=r"bias: Wrong\.odd: is False, and must be a method"):
        find_device("biased-pump").replace(bias="own_parts:Wrong")


@pytest.mark.parametrize(
    ("own", "changes", "message"),
    [
        (Filters, {"time_constant": 0.3}, "Wrong.time_constant: is 0.3, and must be a method; write def time_cons"),
        (Hums, {"antiperiodic": lambda self: False}, "Wrong.antiperiodic: is a method, and must be a value; write a"),
        (Hums, {"repeat": 1}, "Wrong.repeat: is 1, and must be True or False"),
        (Hangs, {"states": list(LAG)}, "Wrong.states: is [State(name='l...irrored=False)], and must be a tuple"),
        (Hangs, {"states": ("lag",)}, "Wrong.states: is ('lag',); give a tuple of gelcone.State"),
        (Pulls, {"parameters": lambda self: PULL}, "Wrong.parameters: is a method, and must be a value"),
        (Pulls, {"parameters": {"pull": 0.2}}, "Wrong.parameters: is {'pull': 0.2}; give names and their gelcone.Qua"),
        (Pulls, {"name": None}, "Wrong.name: is missing, and must be a text; write name"),
        (Hums, {"parameters": PULL}, "Wrong.parameters: lacks voltage; write parameters = Waveform.parameters | {...}"),
        (Pulls, {"force": lambda self, x, n: (x, 1.0)}, "Wrong.force: takes (x, n), and must take (x, y, n, xp); wri"),
    ],
)  # fmt: skip
def test_what_is_not_of_the_contracts_kind_is_refused(own, changes, message):
    assert refused(other(own, **changes)).startswith(message)


def test_a_class_without_a_formula_says_which():
    module = type("Module", (), {"Blank": type("Blank", (Bias,), {"name": "blank"})})
    sys.modules["own_parts"] = module
    try:
        with pytest.raises(InputError) as error:
            find_bias("own_parts:Blank")
    finally:
        del sys.modules["own_parts"]
    assert str(error.value) == "bias 'own_parts:Blank': its class lacks force; write def force(self, x, y, n, xp)"


# --- what formulas return ---------------------------------------------------------------------------------------------


def stuck(self, *_):
    raise ZeroDivisionError("by design")


@pytest.mark.parametrize(
    ("own", "changes", "message"),
    [
        (Pulls, {"force": lambda self, x, y, n, xp=np: n["pull"] * x}, "Wrong.force: returns array"),
        (Pulls, {"force": lambda self, x, y, n, xp=np: (n["pul"], 0.0)}, "Wrong.force: reads 'pul', which is not one"),
        (Pulls, {"force": lambda self, x, y, n, xp=np: (x if x > 0 else 0, 1.0)}, "Wrong.force: fails (ValueError: "),
        (Pulls, {"free_height": stuck}, "Wrong.free_height: fails (ZeroDivisionError: by d"),
        (Pulls, {"odd": lambda self, n: "no"}, "Wrong.odd: returns 'no'; return one number for each member"),
        (Pulls, {"states": LAG}, "Wrong.rates: returns []; return a list of 1, one for each of its states"),
        (Pulls, {"starts": lambda self, x, n: [0.0]}, "Wrong.starts: returns [0.0]; return a list of 0, one for each"),
        (Hangs, {"reach": lambda self, n: 3.0}, "Wrong.reach: returns 3.0; return a list of 2, one for each of its en"),
        (Hangs, {"state": lambda self, x, voltage, y, n: None}, "Wrong.state: returns None; return a list of 8, one"),
        (Hangs, {"describe": lambda self: 3}, "Wrong.describe: returns 3; return a text"),
        (Hangs, {"relaxed": lambda self, x, squared, n: [0.0]}, "Wrong.relaxed: returns [0.0]; return None, or a list"),
        (Hangs, {"states": LAG, "rates": lambda self, x, velocity, squared, y, n, xp=np: x - y[0]}, "Wrong.rates: ret"),
        (Hums, {"detail": lambda self, n: [1.0, 2.0, 3.0]}, "Wrong.detail: returns [1.0, 2.0, 3.0]; return one number"),
        (Soft, {"strain_limit": lambda self, n: None}, "Wrong.strain_limit: returns None; return one number for each"),
        (Filters, {"rates": lambda self, port, y, n, xp=np: port.command - y[0]}, "Wrong.rates: returns array"),
        (Filters, {"powers": lambda self, port, current, y, n, xp=np: 0.0}, "Wrong.powers: returns 0.0; return a mapp"),
        (Filters, {"voltage": lambda self, port, y, n, xp=np: port.comand}, "Wrong.voltage: fails (AttributeError: "),
        (Filters, {"numbers": stuck}, "Wrong.numbers: fails (ZeroDivisionError: by design)"),
    ],
)  # fmt: skip
def test_a_formula_that_fails_or_returns_something_else_is_refused(own, changes, message):
    assert refused(other(own, **changes)).startswith(message)


class Steps(Pieced):
    name = "steps"

    def table(self, n):
        return [0.0, 1.0]


def test_a_table_of_pieces_that_is_none_is_refused():
    with pytest.raises(InputError, match=r"Steps.table: returns \[0.0, 1.0\]; return Pieces\(begins, terms\)"):
        ConeModel(waveform=Steps())


# --- formulas that contradict one another -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("own", "changes", "message"),
    [
        (Pulls, {"force": lambda self, x, y, n, xp=np: (x * x, 2.0 * x)},
         "Wrong.force, odd in x, at a displacement: it is 2.25 at -1.5, and must be -2.25; correct it, or write def"),
        (Hangs, {"force": lambda self, x, squared, y, n, xp=np: (x - 0.1, 1.0 + 0.0 * x)},
         "Wrong.force, odd in x, at a displacement: it is -1.6 at -1.5, and must be -1.4; correct it, or write def"),
        (Hangs, {"force": lambda self, x, squared, y, n, xp=np: (x, 2.0 + 0.0 * x)},
         "Wrong.force, its slope at a displacement: it is 2 at -1.5, and must be 1"),
        (Hums, {"antiperiodic": True}, "Wrong.antiperiodic = True, a change of sign of the shape after half a period"),
        (Hums, {"shape_rate": lambda self, phase, n, xp=np: xp.cos(phase)}, "Wrong.shape_rate, the derivative of"),
        (Pulls, {"states": LAG, "rates": lambda self, x, velocity, y, n, xp=np: [np.sin(x)]},
         "Wrong.rates: a formula cannot be differentiated and compiled"),
        (Filters, {"rates": lambda self, port, y, n, xp=np: [np.tanh(port.command - y[0])]},
         "Wrong.rates: a formula cannot be differentiated and compiled"),
    ],
)  # fmt: skip
def test_formulas_that_contradict_the_contract_are_refused(own, changes, message):
    assert refused(other(own, **changes)).startswith(message)


def test_the_slope_is_that_at_held_states_too():
    @dataclass(frozen=True)
    class Follows(Hangs):
        states = LAG

        def force(self, x, squared, y, n, xp=np):
            lag = x - y[0] if y else 0.0 * x
            return x + 0.5 * lag, 1.0 + 0.0 * x

        def rates(self, x, velocity, squared, y, n, xp=np):
            return [x - y[0]]

    with pytest.raises(InputError, match=r"Follows.force, its slope at a displacement: it is 1 at -1.5, and must be"):
        ConeModel(film=Follows())


def test_numbers_are_those_of_one_member_and_of_two():
    one, two = numbers_of(WAVEFORMS["square"], {"rise": 0.1})
    assert (one["duty"], one["rise"]) == (0.5, 0.1)
    np.testing.assert_array_equal(two["duty"], [[0.5], [0.5]])
    assert set(VOLTAGE) < set(one) == set(two)
