"""Fields of a record: their usual ranges and examples, the names that people mean, and plain data."""

import numpy as np
import pytest

from gelcone.devices.record import LARGEST, Field, FieldErrors, meant_fields, plain, unknown_field
from gelcone.devices.units import FieldError

LENGTH = Field("thickness", "m", typical=(1e-4, 1e-2), above=0.0, near=("depth", "height"))
FIELDS = {
    "film_thickness": LENGTH,
    "disc_radius": Field("radius", "m", near=("radius",)),
    "name": Field("name", default="x"),
}


@pytest.mark.parametrize(
    ("value", "odd"),
    [
        (1e-3, None), (1.1e-5, None), (0.9e-5, 0.9e-5), (0.099, None), (0.11, 0.11), (-0.11, -0.11), (0.0, None),
        (np.inf, None), ([1e-3, 0.5, 0.6], 0.5), (None, None),
    ],
)  # fmt: skip
def test_what_lies_outside_the_usual_range_widened_is_implausible(value, odd):
    assert LENGTH.implausible(value, 10.0) == odd
    assert Field("x", "m").implausible(value, 10.0) is None


def test_an_example_is_given_or_the_middle_of_the_usual_range():
    assert LENGTH.example_value() == 1e-3
    assert LENGTH.example_text() == "1 mm"
    assert LENGTH.typical_text() == "100 um to 10 mm"
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
    ],
)  # fmt: skip
def test_names_that_people_use_mean_the_field_that_lists_them_or_the_nearest(name, meant):
    assert meant_fields(name, FIELDS) == meant
    error = unknown_field("device", name, FIELDS)
    expected = f"did you mean {meant[0]!r}?" if meant else "known: film_thickness, disc_radius, name"
    assert str(error) == f"{name!r} is not a device field; {expected}"


def test_several_errors_are_a_line_each_of_the_first_field():
    both = FieldErrors([FieldError("a", "a: wrong"), FieldError("b", "b: worse")])
    assert (str(both), both.field) == ("a: wrong\nb: worse", "a")
    assert [error.field for error in both.errors] == ["a", "b"]


def test_plain_data_are_lists_and_numbers():
    assert plain(np.array([1.0, 2.0])) == [1.0, 2.0]
    assert plain("x") == "x"
    assert plain(3.0) == 3.0
