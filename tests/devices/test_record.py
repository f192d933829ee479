"""Fields of a record: their usual ranges and examples, the names that people mean, and plain data."""

import inspect

import numpy as np
import pytest

from gelcone.devices.record import (
    LARGEST,
    MOST_UNKNOWN,
    Field,
    FieldErrors,
    Record,
    meant_fields,
    plain,
    unknown_field,
)
from gelcone.devices.units import FieldError

LENGTH = Field("thickness", "m", typical=(1e-4, 1e-2), above=0.0, near=("depth", "height"))
FIELDS = {
    "film_thickness": LENGTH,
    "disc_radius": Field("radius", "m", near=("radius",)),
    "name": Field("name", default="x"),
    "waveform.radius_share": Field("share", "1"),
}


@pytest.mark.parametrize(
    ("value", "odd"),
    [
        (1e-3, None), (1.1e-5, None), (0.9e-5, 0.9e-5), (0.099, None), (0.11, 0.11), (-0.11, -0.11), (0.0, None),
        (np.inf, None), ([1e-3, 0.5, 0.6], 0.5), (None, None), (-1e-3, None), (-0.9e-5, -0.9e-5), ([-1e-3, -0.5], -0.5),
    ],
)  # fmt: skip
def test_what_lies_outside_the_usual_range_widened_is_implausible(value, odd):
    assert LENGTH.implausible(value, 10.0) == odd
    assert Field("x", "m").implausible(value, 10.0) is None


def test_an_example_is_given_or_the_middle_of_the_usual_range():
    assert LENGTH.example_value() == 1e-3
    assert LENGTH.example_text() == "1 mm"
    assert LENGTH.typical_text() == "0.1 to 10 mm"
    assert Field("x", "ohm m", typical=(1e7, 1e14)).typical_text() == "1e+07 to 1e+14 ohm m"
    own = Field("x", "m", typical=(1e-4, 1e-2), example=3e-3)
    assert (own.example_value(), own.example_text()) == (3e-3, "3 mm")
    bare = Field("x", "m")
    assert (bare.example_value(), bare.example_text(), bare.typical_text()) == (1.0, "", "")


def test_values_are_read_within_their_bounds():
    assert LENGTH.read("film_thickness", "0.2 mm") == 2e-4
    assert LENGTH.read("film_thickness", [1e-3, "2 mm"]).tolist() == [1e-3, 2e-3]
    for value in (0.0, "-1 mm", "1 V", np.inf, 2.0 * LARGEST):
        with pytest.raises(FieldError, match="film_thickness"):
            LENGTH.read("film_thickness", value)
    assert LENGTH.read("film_thickness", LARGEST) == LARGEST
    assert FIELDS["name"].read("name", "a") == "a"
    for text in ("", "  ", 3):
        with pytest.raises(FieldError, match="non-empty text"):
            FIELDS["name"].read("name", text)
    assert LENGTH.required
    assert not FIELDS["name"].required


@pytest.mark.parametrize(
    ("name", "meant"),
    [
        ("Film-Thickness", ["film_thickness"]), ("depth", ["film_thickness"]), ("radius", ["disc_radius"]),
        ("film thicknes", ["film_thickness"]), ("heigth", ["film_thickness"]), ("qqq", []),
        ("radius_share", ["waveform.radius_share"]),
    ],
)  # fmt: skip
def test_names_that_people_use_mean_the_field_that_lists_them_or_the_nearest(name, meant):
    assert meant_fields(name, FIELDS) == meant
    error = unknown_field("device", name, FIELDS)
    expected = (
        f"did you mean {meant[0]!r}?" if meant else "known: film_thickness, disc_radius, name, waveform.radius_share"
    )
    assert str(error) == f"{name!r} is not a device field; {expected}"


def test_of_many_fields_those_are_named_that_contain_what_was_typed():
    many = (
        FIELDS | {f"bias.magnet_{name}": LENGTH for name in ("height", "width")} | {f"x{k}": LENGTH for k in range(12)}
    )
    typed = {"mag": "with 'mag' in their names: bias.magnet_height, bias.magnet_width", "qqqqq": "gelcone help device"}
    for name, words in typed.items():
        error = str(unknown_field("device", name, many))
        assert error.startswith(f"{name!r} is not a device field; {words}")
        assert len(error) < 120


def test_several_errors_are_a_line_each_of_the_first_field():
    both = FieldErrors([FieldError("a", "a: wrong"), FieldError("b", "b: worse")])
    assert (str(both), both.field) == ("a: wrong\nb: worse", "a")
    assert [error.field for error in both.errors] == ["a", "b"]


def test_plain_data_are_lists_and_numbers():
    assert plain(np.array([1.0, 2.0])) == [1.0, 2.0]
    assert plain("x") == "x"
    assert plain(3.0) == 3.0


class Plate(Record):
    """A record of this test."""

    kind = "plate"
    width = Field("width", "m", above=0.0, near=("breadth",))
    mass = Field("mass", "kg", least=0.0)
    colour = Field("colour", default="red")
    share = Field("share", "1", default=0.5)


def test_a_record_says_of_all_fields_what_is_wrong_and_not_that_one_is_missing_whose_name_is_misspelt():
    with pytest.raises(FieldErrors) as refused:
        Plate(breadth=1.0, colour=" ")
    lines = str(refused.value).splitlines()
    assert lines == [
        "'breadth' is not a plate field; did you mean 'width'?",
        "mass: is missing; give the mass in kg",
        "colour = ' ': must be a non-empty text in quotes",
    ]
    with pytest.raises(FieldError, match=r"^mass: is missing; give the mass in kg$") as alone:
        Plate(width=1.0, mass=None)
    assert not isinstance(alone.value, FieldErrors)
    with pytest.raises(FieldErrors) as many:
        Plate(**{f"zz{k}": 1.0 for k in range(MOST_UNKNOWN + 9)})
    assert len(many.value.errors) == MOST_UNKNOWN + 2


def test_errors_within_a_table_have_dotted_names():
    within = FieldErrors([FieldError("a", "a: wrong"), FieldError("b", "b: worse")]).within("material")
    assert isinstance(within, FieldErrors)
    assert [error.field for error in within.errors] == ["material.a", "material.b"]
    assert str(within).splitlines()[1].startswith("material.b")


def test_a_record_is_its_fields_and_does_not_change():
    own = Plate(width="3 mm", mass=[1.0, 2.0])
    assert own.parameters() == {"width": 3e-3, "mass": [1.0, 2.0], "colour": "red", "share": 0.5}
    assert own == Plate(**own.parameters())
    assert own != Plate(width="3 mm", mass=[1.0, 2.5])
    assert repr(own) == "Plate(width=0.003, mass=[1.0, 2.0], colour='red', share=0.5)"
    with pytest.raises(AttributeError, match=r"width: a plate does not change; replace\(width=...\)"):
        own.width = 2.0
    with pytest.raises(AttributeError, match="Plate has no field 'depth'"):
        _ = own.depth
    kinds = {name: entry.default for name, entry in Plate.__signature__.parameters.items()}
    assert kinds == {"width": inspect.Parameter.empty, "mass": inspect.Parameter.empty, "colour": "red", "share": 0.5}


class Pair(Record):
    """A record whose fields do not fit, once each of them does."""

    low = Field("low", "m")
    high = Field("high", "m")

    def misfits(self):
        if self.low > self.high:
            yield FieldError("low", "low: is above high")
            yield FieldError("high", "high: is below low")


def test_what_does_not_fit_together_is_told_once_each_field_is_right():
    with pytest.raises(FieldErrors) as both:
        Pair(low=2.0, high=1.0)
    assert [error.field for error in both.value.errors] == ["low", "high"]
    with pytest.raises(FieldError, match=r"^high: is missing") as alone:
        Pair(low=2.0)
    assert not isinstance(alone.value, FieldErrors)
    assert Pair(low=1.0, high=2.0).parameters() == {"low": 1.0, "high": 2.0}
