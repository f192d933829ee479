"""Components: equal ones are one, and files name them so that another process finds them again."""

import pickle
from dataclasses import dataclass, field

import numpy as np
import pytest

from gelcone import permission
from gelcone.errors import InputError
from gelcone.physics.bias import BIASES, Bias, LinearSpring, Together
from gelcone.physics.component import Component, State, from_record, names_of, to_record
from gelcone.physics.contract import same_formula
from gelcone.physics.film.taut import TautCone
from gelcone.physics.laws import LAWS, Gent, StrainEnergyLaw, Yeoh
from gelcone.physics.model import ConeModel
from gelcone.physics.waveforms import Harmonics, Sine, Square
from gelcone.quantity import Quantity

HERE = __name__


@dataclass(frozen=True)
class Cubic(Bias):
    """F = k1 x + k3 x^3 with numbers that are no parameters."""

    cubic: float = 0.5
    offsets: tuple[float, ...] = ()
    other: Component = field(default_factory=LinearSpring)

    name = "own cubic"
    parameters = {"own_stiffness": Quantity("k1", "stiffness at the flat film", 1.0)}

    def force(self, x, y, n, xp=np):
        return n["own_stiffness"] * x + self.cubic * x * x * x, n["own_stiffness"] + 3.0 * self.cubic * x * x


class Holder:
    @dataclass(frozen=True)
    class Inner(Bias):
        factor: float = 2.0
        name = "inner"

        def force(self, x, y, n, xp=np):
            return self.factor * x, self.factor


def read(record, kind="bias", shipped=BIASES, base=Bias):
    return from_record(kind, record, shipped, base)


# --- equality ---------------------------------------------------------------------------------------------------------


def test_components_of_a_class_are_equal_where_they_hold_the_same():
    assert Gent() == Gent()
    assert hash(Gent()) == hash(Gent())
    assert Gent() != Yeoh()
    assert Cubic(0.5) == Cubic(0.5)
    assert hash(Cubic(0.5)) == hash(Cubic(0.5))
    assert Cubic(0.5) != Cubic(0.6)
    assert Cubic(other=Cubic(0.1)) != Cubic(other=Cubic(0.2))
    assert TautCone(Gent()) == TautCone(Gent())
    assert TautCone(Gent()) != TautCone(Yeoh())
    assert {Gent(): 1}[Gent()] == 1


def test_what_a_component_has_computed_does_not_count():
    """Square waves know the number of their pieces once they were asked. Were they keys that differ before and are
    equal after, the cache of systems would give another's as soon as it lets go of one of the two."""
    first, second = Square(), Square()
    assert ConeModel(waveform=first).system is ConeModel(waveform=second).system
    assert second.piece_count == 4
    assert first == second
    ConeModel(waveform=second)
    assert first.piece_count == 4
    for k in range(100):
        other = ConeModel(waveform=Harmonics(((1, 1.0, float(k)),)))
        assert other.system.waveform.terms[0][2] == k
        assert type(ConeModel(waveform=second, duty=0.3).system.waveform) is Square


class Held(Sine):
    """A waveform whose class is no dataclass."""

    name = "held"

    def __init__(self, values):
        self.values = values


@dataclass(frozen=True)
class Frozen(Sine):
    values: object = ()

    name = "frozen"


@dataclass
class Thawed(Sine):
    values: object = ()

    name = "thawed"


@pytest.mark.parametrize(
    ("component", "message"),
    [
        (Held(np.ones(2)), r"held: values is an array; hold a tuple of numbers, tuple\(values.tolist\(\)\)"),
        (Frozen(np.ones(2)), "frozen: values is an array; hold a tuple"),
        (Frozen([1.0, 2.0]), "frozen: cannot be compared .*'list'.*; make its class a frozen dataclass"),
        (Thawed((1.0,)), "thawed: cannot be compared .*'Thawed'.*; make its class a frozen dataclass"),
    ],
)
def test_a_component_that_cannot_be_compared_is_refused(component, message):
    with pytest.raises(InputError, match=message):
        ConeModel(waveform=component)


@pytest.mark.parametrize("kind", [Held, Frozen])
def test_tuples_can_be_compared(kind):
    assert ConeModel(waveform=kind((1.0, 2.0))).system is ConeModel(waveform=kind((1.0, 2.0))).system


def test_a_class_derived_from_another_is_not_equal_to_it():
    class Changed(Gent):
        pass

    assert Changed() != Gent()
    assert Gent() != Changed()


@pytest.mark.parametrize("component", [Gent(), Cubic(0.7, (1.0, 2.0), Cubic(0.1)), TautCone(Yeoh(), "equibiaxial")])
def test_a_component_from_another_process_is_equal(component):
    again = pickle.loads(pickle.dumps(component))
    assert again == component
    assert hash(again) == hash(component)


@pytest.mark.parametrize("component", [*LAWS.values(), *BIASES.values(), Cubic(0.7, (1.0,), Cubic(0.1))])
def test_the_disk_cache_finds_what_another_process_made_of_a_component(component):
    again = pickle.loads(pickle.dumps(component))
    assert repr(again) == repr(component)
    assert " at 0x" not in repr(component)


def test_components_that_hold_other_numbers_are_written_otherwise():
    class Held(Gent):
        def __init__(self, factor):
            self.factor = factor

    assert repr(Held(0.5)) == repr(Held(0.5)) != repr(Held(0.6))
    assert repr(Held(0.5)) != repr(Gent())


# --- records ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS)
def test_what_ships_is_written_by_its_name(law):
    assert to_record(law, LAWS) == law.name
    assert read(law.name, "strain-energy law", LAWS, StrainEnergyLaw) == law


@pytest.mark.parametrize(
    "bias",
    [
        Cubic(),
        Cubic(0.1 + 0.2),
        Cubic(offsets=(0.1, 1.0 / 3.0)),
        Cubic(other=Cubic(0.3, (2.0,), Cubic(-1.5))),
        Holder.Inner(3.0),
    ],
    ids=["defaults", "number", "tuple", "nested twice", "inner class"],
)
def test_a_users_class_is_written_by_module_and_class_with_its_numbers(bias):
    import json

    record = to_record(bias, BIASES)
    assert record["component"] == f"{HERE}:{type(bias).__qualname__}"
    again = read(json.loads(json.dumps(record)))
    assert again == bias
    assert type(again) is type(bias)


def test_a_users_class_that_takes_the_name_of_a_shipped_one_is_not_taken_for_it():
    class Impostor(LinearSpring):
        name = "spring"

    assert to_record(Impostor(), BIASES) == f"{HERE}:{Impostor.__qualname__}"
    assert to_record(LinearSpring(), BIASES) == "spring"


def test_a_record_may_leave_out_fields():
    assert read({"component": f"{HERE}:Cubic", "cubic": 2.0}) == Cubic(2.0)
    assert read(f"{HERE}:Cubic") == Cubic()


# --- what cannot be read ----------------------------------------------------------------------------------------------


def message(record, **options):
    with pytest.raises(InputError) as error:
        read(record, **options)
    text = str(error.value)
    assert "\n" not in text
    return text


def test_an_unknown_name_suggests_the_near_one():
    assert message("sprng") == "'sprng' is not a bias; did you mean 'spring'?"


@pytest.mark.parametrize("record", [3, None, {}, {"cubic": 1.0}, ["spring"], {"component": 3}])
def test_what_is_no_record_is_refused(record):
    assert "must be the name of a bias: spring" in message(record)


@pytest.mark.parametrize(
    ("module", "path"), [("no_such_module_here", "Cubic"), (HERE, "Vanished"), (HERE, "Holder.Gone")]
)
def test_a_class_that_cannot_be_imported_says_where_to_put_it(module, path):
    text = message(f"{module}:{path}")
    assert text.startswith(f"bias '{module}:{path}': cannot be imported (")
    assert f"it was defined in the module {module!r}" in text
    assert "put its class into a module that Python finds" in text


def test_a_class_of_a_script_says_so():
    assert "it was defined in a script or notebook: put its class into a module" in message("__main__:MyBias")


def test_a_class_inside_a_function_cannot_be_found_again():
    @dataclass(frozen=True)
    class Local(Bias):
        factor: float = 1.0
        name = "local"

        def force(self, x, y, n, xp=np):
            return self.factor * x, self.factor

    record = to_record(Local(), BIASES)
    assert "<locals>" in record["component"]
    assert "put its class into a module that Python finds" in message(record)


def test_a_class_of_another_kind_is_refused():
    text = message("gelcone.physics.laws:Gent")
    assert text == "bias 'gelcone.physics.laws:Gent': is not a bias; derive its class from gelcone.Bias"
    assert "is not a class; give the component itself" in message("gelcone.physics.bias:BIASES")


def test_numbers_that_do_not_fit_the_class_are_refused():
    @dataclass(frozen=True)
    class Checked(Bias):
        factor: float
        name = "checked"

        def force(self, x, y, n, xp=np):
            return x, 1.0

    Holder.Checked = Checked
    try:
        text = message({"component": f"{HERE}:Holder.Checked"})
    finally:
        del Holder.Checked
    assert "its numbers do not fit its class" in text
    assert "use the version that wrote it" in text


# --- parameters -------------------------------------------------------------------------------------------------------


def test_parameters_take_their_defaults_and_are_checked():
    spring = LinearSpring()
    assert spring.complete({}) == {"spring_stiffness": 1.5, "rest_height": 0.0}
    assert spring.complete({"rest_height": 0.2, "else": 1.0}) == {"spring_stiffness": 1.5, "rest_height": 0.2}
    with pytest.raises(InputError, match="spring_stiffness = -1: must be at least 0"):
        spring.complete({"spring_stiffness": -1.0})
    assert spring.numbers({"spring_stiffness": 2.0, "rest_height": 0.1, "voltage": 9.0}) == {
        "spring_stiffness": 2.0,
        "rest_height": 0.1,
    }


def test_what_a_component_adds_are_parameters_of_the_model():
    model = ConeModel(bias=Cubic(0.25), own_stiffness=[0.5, 2.0])
    assert "spring_stiffness" not in model.parameters()
    np.testing.assert_array_equal(model.own_stiffness, [0.5, 2.0])
    taut = ConeModel(spring_stiffness=0.0)
    expected = taut.force(0.4) + np.array([0.5, 2.0]) * 0.4 + 0.25 * 0.4**3
    np.testing.assert_allclose(model.force(np.full(2, 0.4)), expected, rtol=1e-14)
    assert model.replace(own_stiffness=3.0).take([0]).own_stiffness == 3.0
    with pytest.raises(InputError, match="'own_stifness' is not a model parameter; did you mean 'own_stiffness'"):
        model.replace(own_stifness=1.0)


def test_parameters_give_a_model_of_own_components_back():
    model = ConeModel(bias=Cubic(0.25, (1.0,), Cubic(0.5)), own_stiffness=0.5, law="yeoh", yeoh_c2=0.1)
    again = ConeModel.from_parameters(model.parameters())
    assert again.system == model.system
    assert again.parameters() == model.parameters()


@pytest.mark.parametrize("several", [tuple, list])
def test_the_permissions_of_a_component_are_its_own_and_those_of_all_its_parts(several):
    parts = several([Cubic(0.7, (1.0,), Holder.Inner(3.0)), BIASES["weight"]])
    needed = names_of(Together(parts))
    assert needed >= {f"{HERE}:Cubic", f"{HERE}:Holder.Inner", "gelcone.physics.bias:Together"}
    assert needed >= set().union(*map(names_of, parts))
    assert names_of(parts[0]) > names_of(parts[0].other)


@dataclass(frozen=True)
class Scaled(StrainEnergyLaw):
    """A neo-Hookean law whose response has a factor: only with 1 is it the slope of its energy."""

    factor: float = 1.0

    name = "scaled"

    def energy(self, strain, n, xp=np):
        return 0.5 * strain

    def response(self, strain, n, xp=np):
        return self.factor + 0.0 * strain

    def response_slope(self, strain, n, xp=np):
        return 0.0 * strain

    def strain_limit(self, n):
        return np.asarray(np.inf)


def test_each_component_of_a_class_is_proved_by_what_it_holds():
    assert ConeModel(law=Scaled()).law == Scaled()
    with pytest.raises(InputError, match=r"Scaled.response, twice .* correct its formula"):
        ConeModel(law=Scaled(1.1))


def test_components_that_are_no_dataclasses_are_equal_where_they_hold_the_same():
    class Held(Gent):
        def __init__(self, factor):
            self.factor = factor

    assert Held(0.5) == Held(0.5)
    assert Held(0.5) != Held(0.6)
    assert hash(Held(0.5)) == hash(Held(0.5))


def test_a_formula_is_compared_where_the_other_one_has_a_value_and_named_where_it_first_differs():
    at, stated = np.array([0.5, 1.0, 2.0, 4.0]), np.array([1.0, 2.0, 3.0, 4.0])
    same_formula(Gent(), "x", at, stated, lambda: np.array([np.nan, 2.0, np.inf, 4.0]))
    with pytest.raises(InputError, match=r"^Gent.x: it is 3 at 2, and must be 3\.5; correct its formula$"):
        same_formula(Gent(), "x", at, stated, lambda: np.array([1.0, 2.0, 3.5, 4.5]))


def test_the_data_of_a_class_that_does_not_ship_are_read_as_they_are_and_put_to_the_question(monkeypatch):
    """Only a table of ``nested`` alone is a component of its own; permission is asked for all fields."""
    asked = []
    monkeypatch.setattr(permission, "check_data", lambda *given: asked.append(given))
    record = {"component": f"{HERE}:Cubic", "cubic": 0.25, "offsets": {"nested": "spring", "more": 1}}
    assert read(record).offsets == {"nested": "spring", "more": 1}
    data = {"cubic": 0.25, "offsets": {"nested": "spring", "more": 1}}
    assert asked == [("bias", f"{HERE}:Cubic", data)]


def test_numbers_stand_in_the_order_of_the_parameters_and_a_state_begins_at_nothing():
    assert LinearSpring().number_names == ("spring_stiffness", "rest_height")
    assert State("lag", "its state").start == 0.0
    assert not State("lag", "its state").mirrored


def test_components_in_a_tuple_are_written_each_with_its_own_data():
    import json

    both = Together((Cubic(0.3, (1.0,)), LinearSpring()))
    record = json.loads(json.dumps(to_record(both, {})))
    assert [part["nested"] for part in record["parts"]] == [to_record(part, {}) for part in both.parts]
    assert read(record) == both
