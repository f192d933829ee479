"""Errors that a user can act on."""

import numpy as np
import pytest

from gelcone import InputError
from gelcone.errors import MissingDependency, check_name, check_names, described, unknown_name


def test_an_input_error_is_a_value_error():
    assert issubclass(InputError, ValueError)


def test_an_unknown_name_suggests_the_nearest_one_or_lists_them_all():
    assert str(unknown_name("fruit", "aple", iter(["apple", "pear"]))) == "'aple' is not a fruit; did you mean 'apple'?"
    assert str(unknown_name("fruit", "zzz", ["apple", "pear"])) == "'zzz' is not a fruit; known: apple, pear"


def test_a_name_that_is_not_known_is_refused_in_short_words_that_begin_with_the_place():
    check_name("fruit", "pear", {"apple": 1, "pear": 2})
    with pytest.raises(InputError, match=r"^basket: 'x{60}' is not a fruit; known: apple, pear$"):
        check_name("fruit", 100 * "x", ["apple", "pear"], where="basket: ")
    with pytest.raises(InputError, match=r"\['pear'\].* is not a fruit"):
        check_name("fruit", ["pear"], {"apple": 1, "pear": 2})
    check_names("fruit", [], ["apple"])
    check_names("fruit", {"pear": 1, "apple": 2}, ["apple", "pear"])
    with pytest.raises(InputError, match=r"^basket: 'plum' is not a fruit; known: apple, pear$"):
        check_names("fruit", ["apple", "plum"], ["apple", "pear"], where="basket: ")


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (3, "the number 3"),
        ("pump", "the text 'pump'"),
        (None, "None"),
        (np.zeros(2), "an array"),
        ([], "a list"),
        (True, "a bool"),
    ],
)
def test_what_was_given_in_place_of_another_is_described(value, words):
    assert described(value) == words


def test_a_missing_library_is_an_import_error():
    assert issubclass(MissingDependency, ImportError)
