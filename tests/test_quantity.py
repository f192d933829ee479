"""Quantity: which values pass, unchanged, and which are refused in one line that names the value and the bound."""

from decimal import Decimal
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gelcone.errors import InputError
from gelcone.quantity import ALL_CORES, LARGEST, MOST, Quantity, check_count, spread, taken

ANY = Quantity("a", "anything finite", 0.25)
POSITIVE = Quantity("p", "positive", 1.0, positive=True)
FROM_ZERO = Quantity("z", "zero or more", 0.5, lower=0.0)
LIMIT = Quantity("J", "positive or infinite", 50.0, positive=True, infinite=True)
finite = st.floats(-LARGEST, LARGEST)


@settings(deadline=None)
@given(finite)
def test_every_finite_number_passes_exactly_where_the_bounds_allow_it(value):
    for quantity, allowed in ((ANY, True), (POSITIVE, value > 0.0), (FROM_ZERO, value >= 0.0), (LIMIT, value > 0.0)):
        if allowed:
            checked = quantity.check("x", value)
            assert type(checked) is float
            assert checked == value
        else:
            with pytest.raises(InputError, match=r"^x = .*: must be "):
                quantity.check("x", value)


@settings(deadline=None)
@given(st.lists(finite, min_size=1, max_size=5))
def test_an_array_passes_exactly_when_its_smallest_entry_does(values):
    if min(values) >= 0.0:
        np.testing.assert_array_equal(FROM_ZERO.check("x", values), values)
    else:
        with pytest.raises(InputError) as error:
            FROM_ZERO.check("x", values)
        assert str(error.value).startswith(f"x = {min(values):g}: must be at least 0")


@pytest.mark.parametrize("value", [2, 2.0, np.float32(2.0), np.int8(2), np.uint64(2), np.array(2.0), np.array(2)])
def test_a_scalar_of_any_number_type_becomes_a_float(value):
    checked = ANY.check("x", value)
    assert type(checked) is float
    assert checked == 2.0


@pytest.mark.parametrize("value", [[1, 2], (1, 2), np.array([1, 2]), np.array([1.0, 2.0], dtype=np.float32)])
def test_a_sequence_of_any_number_type_becomes_a_float_array(value):
    checked = ANY.check("x", value)
    assert checked.dtype == np.float64
    np.testing.assert_array_equal(checked, [1.0, 2.0])


@pytest.mark.parametrize("source", [np.arange(4.0), np.arange(8.0)[::2]])
def test_the_checked_array_is_a_copy(source):
    checked = ANY.check("x", source)
    assert not np.shares_memory(checked, source)
    source[1] = 99.0
    assert checked[1] != 99.0


def test_the_shape_is_kept():
    assert ANY.check("x", np.zeros((2, 1, 3))).shape == (2, 1, 3)
    assert ANY.check("x", [4.0]).shape == (1,)


def test_the_bounds_themselves():
    assert FROM_ZERO.check("x", 0.0) == 0.0
    assert Quantity("y", "at least one", 2.0, lower=1.0).check("x", 1.0) == 1.0
    assert POSITIVE.check("x", 5e-324) == 5e-324
    assert LIMIT.check("x", np.inf) == np.inf
    np.testing.assert_array_equal(LIMIT.check("x", [3.0, np.inf]), [3.0, np.inf])


@pytest.mark.parametrize(
    ("quantity", "value", "message"),
    [
        (POSITIVE, 0, "x = 0: must be greater than 0"),
        (POSITIVE, -0.0, "must be greater than 0"),
        (POSITIVE, [3.0, -1.5, 2.0], "x = -1.5: must be greater than 0"),
        (FROM_ZERO, -1e-300, "x = -1e-300: must be at least 0"),
        (Quantity("y", "at least one", 2.0, lower=1.0), 0.5, "x = 0.5: must be at least 1"),
        (ANY, np.inf, "x = inf: must be finite"),
        (ANY, [0.0, -np.inf], "x = -inf: must be finite"),
        (LIMIT, -np.inf, "x = -inf: must be greater than 0"),
        (ANY, np.nan, "x = nan: must be a number; leave it out to take its default 0.25"),
        (LIMIT, [1.0, np.nan], "x = nan: must be a number; leave it out to take its default 50"),
        (ANY, [], "x = []: is empty; give at least one value"),
        (ANY, np.zeros((2, 0)), "is empty; give at least one value"),
        (ANY, "2", "x = '2': must be a number or an array of numbers"),
        (ANY, b"2", "must be a number or an array of numbers"),
        (ANY, ["1", "2"], "must be a number or an array of numbers"),
        (ANY, None, "x = None: must be a number or an array of numbers"),
        (ANY, True, "x = True: must be a number or an array of numbers"),
        (ANY, np.True_, "must be a number or an array of numbers"),
        (ANY, [True, False], "must be a number or an array of numbers"),
        (ANY, 1j, "x = 1j: must be a number or an array of numbers"),
        (ANY, np.array([1.0 + 1.0j]), "must be a number or an array of numbers"),
        (ANY, {"a": 1}, "must be a number or an array of numbers"),
        (ANY, [[1.0], [1.0, 2.0]], "must be a number or an array of numbers"),
        (ANY, Decimal(2), "must be a number or an array of numbers"),
        (ANY, SimpleNamespace(), "must be a number or an array of numbers"),
        (ANY, np.array(["2026-01-01"], dtype="datetime64[D]"), "must be a number or an array of numbers"),
    ],
)
def test_refused_values(quantity, value, message):
    with pytest.raises(InputError) as error:
        quantity.check("x", value)
    assert message in str(error.value)
    assert str(error.value).startswith("x = ")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("quantity", "value", "named"),
    [
        (ANY, 1e31, "1e+31"), (ANY, -1e200, "-1e+200"), (ANY, np.nextafter(LARGEST, np.inf), "1e+30"),
        (ANY, [1.0, 1e155], "1e+155"), (ANY, [-1e40, 1.0], "-1e+40"), (ANY, [1e40, -1e50, 2.0], "-1e+50"),
        (LIMIT, [np.inf, 1e31], "1e+31"),
    ],
)  # fmt: skip
def test_a_size_that_overflows_is_refused_and_named(quantity, value, named):
    with pytest.raises(InputError, match="is beyond what the equations can be computed with; give a smaller") as error:
        quantity.check("x", value)
    assert str(error.value).startswith(f"x = {named}: ")


def test_the_largest_sizes_pass():
    assert ANY.check("x", -LARGEST) == -LARGEST
    np.testing.assert_array_equal(LIMIT.check("x", [LARGEST, np.inf]), [LARGEST, np.inf])


@pytest.mark.parametrize("value", [2, MOST, np.int8(3), np.uint64(2)])
def test_whole_numbers_from_the_least_on_pass(value):
    check_count("steps", value, 2)


@pytest.mark.parametrize(
    ("value", "message"),
    [
        (1, "steps = 1: must be at least 2; leave it out to use all cores"),
        (-3, "steps = -3: must be at least 2; leave it out to use all cores"),
        (True, "steps = True: must be at least 2; leave it out to use all cores"),
        (2.0, "steps = 2.0: must be a whole number, at least 2; leave it out to use all cores"),
        ("4", "steps = '4': must be a whole number, at least 2; leave it out to use all cores"),
        (None, "steps = None: must be a whole number, at least 2; leave it out to use all cores"),
        (MOST + 1, "steps = 1000000000001: must be at most 1000000000000"),
    ],
)
def test_other_numbers_are_refused_with_the_remedy(value, message):
    with pytest.raises(InputError) as error:
        check_count("steps", value, 2, ALL_CORES)
    assert str(error.value) == message
    with pytest.raises(InputError) as error:
        check_count("steps", value, 2)
    assert str(error.value) == message.partition(";")[0]


def test_true_is_not_a_number_of_anything():
    with pytest.raises(InputError, match=r"^steps = True: must be at least 1$"):
        check_count("steps", True, 1)


def test_a_value_is_spread_over_a_shape():
    np.testing.assert_array_equal(spread(2, (2, 2)), [[2.0, 2.0], [2.0, 2.0]])
    np.testing.assert_array_equal(spread([1.0, 2.0], (2, 2)), [[1.0, 2.0], [1.0, 2.0]])
    own = np.array([1.0, 2.0])
    assert spread(own, (2,)) is own
    with pytest.raises(ValueError, match="broadcast"):
        spread(own, (3,))


def test_a_number_is_the_same_at_all_places_and_an_array_is_spread_before_places_are_taken():
    places = np.array([[True, False, True], [False, False, True]])
    assert taken(3.0, places) == 3.0
    np.testing.assert_array_equal(taken(np.array([1.0, 2.0, 4.0]), places), [1.0, 4.0, 4.0])
