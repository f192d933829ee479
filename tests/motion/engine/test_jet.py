"""Orders of Taylor series, and the coefficients of roots, against mpmath and Cauchy's integral."""

import math

import numpy as np
import pytest

from tests.motion.engine.jets import NUMBERS, ORDER, STATES, TIME, WIDTH, assert_rows, compiled


def test_a_border_of_low_order_has_no_more_coefficients_than_it_asks_for():

    def product(x, u, t, n, xp):
        return x * u

    def other(x, u, t, n, xp):
        return xp.exp(x - 0.5 * t * u)

    found, _, _, rows = compiled([product, other], highest=[3, ORDER])
    assert [len(row) for row in rows] == [ORDER + 1, ORDER + 1, 4, ORDER + 1]
    assert_rows(found[0], product, 3)
    assert_rows(found[1], other)


def test_a_part_has_the_order_of_the_longest_of_what_is_made_of_it():
    def product(x, u, t, n, xp):
        return x * u - t

    def made(*at):
        return at[4].exp(product(*at))

    for formulas, highest in (([made, product], [ORDER, 3]), ([product, made], [3, ORDER])):
        found, _, _, rows = compiled(formulas, highest=highest)
        assert [len(row) for row in rows[2:]] == [order + 1 for order in highest]
        for row, formula, order in zip(found, formulas, highest, strict=True):
            assert_rows(row, formula, order)


def test_coefficients_known_to_be_zero_cost_nothing():
    time = (
        lambda x, u, t, n, xp: t * t * t - t,
        lambda x, u, t, n, xp: n["a"] - 3.0 * t,
        lambda x, u, t, n, xp: n["a"],
    )
    _, _, _, rows = compiled(time)
    for row, terms in zip(rows[2:], (4, 2, 1), strict=True):
        assert [k for k, value in enumerate(row) if value is not None] == list(range(terms))


# --- roots ------------------------------------------------------------------------------------------------------------


CIRCLE = 0.25 * np.exp(2j * np.pi * np.arange(64) / 64)


def on_circle(formula):
    """The Taylor coefficients (order + 1, lanes) of a formula from its values around the start, in complex numbers."""
    h, (x, u) = CIRCLE[:, None], STATES
    n = {name: value + 0.0 * h for name, value in NUMBERS.items()}
    at = x * np.cos(h) + u * np.sin(h), u * np.cos(h) - x * np.sin(h)
    terms = np.fft.fft(formula(*at, TIME + h, n, np), axis=0).real / CIRCLE.size
    return terms[: ORDER + 1] / 0.25 ** np.arange(ORDER + 1)[:, None]


def solved(residuals, guesses):
    """The roots of equations by Newton's method with differences, in complex numbers."""
    roots = np.stack(guesses)
    for _ in range(30):
        value, columns = np.stack(residuals(*roots)), []
        for k in range(len(roots)):
            moved = roots.copy()
            moved[k] += 1e-7
            columns.append((np.stack(residuals(*moved)) - value) / 1e-7)
        matrix = np.moveaxis(np.array(columns), (0, 1), (-1, -2))
        roots = roots - np.moveaxis(np.linalg.solve(matrix, np.moveaxis(value, 0, -1)[..., None])[..., 0], -1, 0)
    return roots


def cubic(y, x, u, n, xp):
    """Sums that contain the root, products of it, and functions of it."""
    return y + y * y * y / 3.0 + xp.sin(y) * x * 0.1 - u * n["b"] - 0.2 * xp.exp(0.1 * y)


def of_cubic(x, u, t, n, xp):
    return xp.root("y", lambda y, x, u, xp: cubic(y, x, u, n, xp), [x, u], lambda x, u, xp: 0.0 * x + 0.3)


@pytest.mark.parametrize(
    "found", [math.nan, 0.25, np.array([[math.nan, 0.4, math.nan, -3.0]])], ids=["new", "near", "mixed"]
)
def test_coefficients_of_a_root_and_of_what_is_made_of_it(found):
    """From its first guess, from a value near it, and with lanes of both kinds."""

    def root(x, u, t, n, xp):
        return solved(lambda y: [cubic(y, x, u, n, xp)], [0.3 + 0.0 * x])[0]

    made = (
        (of_cubic, root),
        (lambda *at: of_cubic(*at) * at[0] - at[2], lambda *at: root(*at) * at[0] - at[2]),
        (lambda *at: at[4].cos(of_cubic(*at)), lambda *at: np.cos(root(*at))),
    )
    rows, _, last, _ = compiled([traced for traced, _ in made], found=found)
    for row, (_, formula) in zip(rows, made, strict=False):
        np.testing.assert_allclose(row, on_circle(formula), rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(row[:4], on_circle(formula)[:4], rtol=1e-12, atol=1e-13)
    np.testing.assert_array_equal(rows[len(made)], rows[0])
    np.testing.assert_array_equal(last[0], rows[0, 0])


def of_two_values(x, u, t, n, xp):
    """sqrt(2 + x) or the opposite."""
    return xp.root("y", lambda y, x, xp: y * y - 2.0 - x, [x], lambda x, xp: 1.0 + 0.0 * x)


def test_a_root_that_has_a_value_follows_it_and_one_without_begins_at_the_guess():
    found = np.array([[-1.5, math.nan, 1.2, -1.2]])
    rows, _, _, _ = compiled([of_two_values], found=found)
    signs = np.array([-1.0, 1.0, 1.0, -1.0])
    np.testing.assert_allclose(rows[0, 0], signs * np.sqrt(2.0 + STATES[0]), rtol=1e-14)
    np.testing.assert_allclose(rows[0, 1], STATES[1] / (2.0 * rows[0, 0]), rtol=1e-13)


def test_a_root_has_the_same_bits_however_long_its_neighbours_take():
    """Of (y - 1)^3 multiplied out, whose rounding moves a root by more than its last digits with each correction."""

    def noisy(x, u, t, n, xp):
        return xp.root(
            "y", lambda y, x, xp: ((y - 3.0) * y + 3.0) * y - 1.0 - 0.001 * (2.0 + x), [x], lambda x, xp: 1.2 + 0.0 * x
        )

    far, near = 1e6, 1.0 + np.cbrt(0.001 * (2.0 + STATES[0])) + 1e-7
    _, _, together, _ = compiled([noisy], found=np.array([near]))
    np.testing.assert_allclose(together[0], near, atol=1e-6)
    for lane in range(WIDTH):
        others = np.array([np.where(np.arange(WIDTH) == lane, near, far)])
        _, _, last, _ = compiled([noisy], found=others)
        assert last[0, lane] == together[0, lane]


def test_rates_may_contain_roots():
    """x' = s with s^2 = 1 + x: 1 + x = (sqrt(1 + x_0) + h/2)^2."""

    def flow(x, u, t, n, xp):
        return [xp.root("s", lambda s, x, xp: s * s - 1.0 - x, [x], lambda x, xp: 1.0 + 0.0 * x), 0.0 * u]

    _, states, _, _ = compiled([], rates=flow)
    start = np.sqrt(1.0 + STATES[0])
    np.testing.assert_allclose(states[0, :3], [STATES[0], start, 0.25 * np.ones(WIDTH)], rtol=1e-13)
    np.testing.assert_allclose(states[0, 3:], 0.0, atol=1e-13)


def test_coefficients_of_two_roots_that_depend_on_each_other():
    """y + z y^2/2 = u + 1 and z + sin(z)/3 - y = x^2."""

    def both(x, u, t, n, xp):
        def second(y):
            return xp.root(
                "z", lambda z, y, x, xp: z + xp.sin(z) / 3.0 - y - x * x, [y, x], lambda y, x, xp: 1.0 + x * x
            )

        y = xp.root("y", lambda y, u, xp: y + 0.5 * second(y) * y * y - u - 1.0, [u], lambda u, xp: 0.7 + 0.0 * u)
        return y, second(y)

    def pair(x, u, t, n, xp):
        return solved(
            lambda y, z: [y + z * y * y / 2.0 - u - 1.0, z + np.sin(z) / 3.0 - y - x * x], [0.7 + 0.0 * x, 1.0 + x * x]
        )

    made = (lambda y, z, x: y, lambda y, z, x: z, lambda y, z, x: y * z + x)
    rows, _, _, _ = compiled([lambda *at, of=of: of(*both(*at), at[0]) for of in made])
    for row, of in zip(rows, made, strict=False):
        right = on_circle(lambda *at, of=of: of(*pair(*at), at[0]))
        np.testing.assert_allclose(row, right, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(row[:4], right[:4], rtol=1e-12, atol=1e-12)


def searched(residual, start, longest):
    """The root of a residual of y alone in each lane, from a start."""
    rows, _, _, _ = compiled(
        [lambda x, u, t, n, xp: xp.root(
            "y", lambda y, x, xp: residual(y, x, xp), [x], lambda x, xp: 0.0 * x + start, longest
        )]
    )  # fmt: skip
    return rows[0, 0]


def test_a_search_in_short_steps_meets_the_first_of_several_roots():
    """Of y (x + 2 - 1.5 sin(3 y)) = 4: without a bound Newton's method leaps over some."""

    def residual(y, x, xp):
        return y * (x + 2.0 - 1.5 * xp.sin(3.0 * y)) - 4.0

    grid = np.linspace(0.05, 6.0, 200_001)
    values = residual(grid, STATES[0][:, None], np)
    first = np.array([grid[np.argmax(row > 0.0)] for row in values])
    found = searched(residual, 0.05, 0.05)
    np.testing.assert_allclose(found, first, atol=1e-4)
    assert not np.allclose(searched(residual, 0.05, math.inf), first, atol=1e-4)


def test_a_bounded_search_is_lost_where_the_residual_over_the_root_does_not_rise():
    def residual(y, x, xp):
        return y * (4.0 - y) - 1.0 - x

    assert np.isnan(searched(residual, 9.0, 0.1)).all()
    lower = 2.0 - np.sqrt(3.0 - STATES[0])
    np.testing.assert_allclose(searched(residual, 0.1, math.inf), lower, rtol=1e-12)
