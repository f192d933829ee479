"""The formulas of a membrane's force: sums of powers and their derivatives."""

import numpy as np
import pytest

from gelcone.membrane import force


@pytest.mark.parametrize("piece", force.PIECES)
@pytest.mark.parametrize("what", ["main", "rim", "disc"])
@pytest.mark.parametrize("shape", [(), (3, 1)])
def test_sums_and_their_derivatives_are_those_of_the_powers(piece, what, shape):
    """For one film and arrays of places, and for several films; by j at once and one after the other."""
    rng = np.random.default_rng(3)
    named = force.names(piece, what)
    n = {name: rng.uniform(-1.0, 1.0, shape)[()] for name in named.ravel()}
    u, q = rng.uniform(-1.0, 1.0, (2, 3, 5))
    rows, expected = np.array([[n[name] for name in row] for row in named]), np.zeros((3, 3, 5))
    for i, j in np.ndindex(named.shape):
        if what == "main" and j > 0 and i > force.MAIN[piece][0]:
            continue  # what depends on u alone
        expected[0] += rows[i, j] * u**i * q**j
        expected[1] += i * rows[i, j] * u ** max(i - 1, 0) * q**j
        expected[2] += j * rows[i, j] * u**i * q ** max(j - 1, 0)
    found = force.tensor(force.columns(piece, what, n, force.powers(u, len(named)), q), q)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-12)
    if what == "disc":
        field = n | {name.replace("disc", "field"): value for name, value in n.items()}
        np.testing.assert_allclose(force.ends(piece, u, q, field), [expected[0]] * 2, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize(("before", "beyond"), [(-2.5, 1.5), (-1.3, 0.3), (-0.5, 0.0)])
def test_pull_in_falls_to_its_lowest_up_to_the_star_and_stays_there(before, beyond):
    """By a sum that is 0.4 wherever, times how far the place, -1/s, is below the star's, -1."""
    n = dict.fromkeys(force.END_NAMES, 0.0) | {force.END_NAMES[0]: 0.4, "lowest_pull_in": 0.7, "star_place": -1.0}
    n |= {"end_scale": 0.3, "end_begin": -9.0, "end_offset": 0.1, "far_shift": 0.0, "far_exponent": -1.0}
    assert force.place("far", -1.0 / before, n)[0] == pytest.approx(before)
    assert force.pull_in(-1.0 / before, n) == pytest.approx(0.7 + 0.4 * beyond, abs=force.ROUNDED)


def drawn(piece, seed=4):
    """Random numbers of a piece, with p and u of order 1 at s about 0.5."""
    rng = np.random.default_rng(seed)
    n = {}
    for what, shape in force.shapes(piece).items():
        for name in np.atleast_1d(force.names(piece, what)).ravel():
            n[name] = rng.uniform(-0.5, 0.5) if shape else rng.uniform(0.4, 1.2)
    n[f"{piece}_exponent"] = -0.7 if piece == "far" else 0.6
    return n | {f"{piece}_start": 0.9}


def straight(piece, s, V, n):
    """The force from its formula, term by term; ``rim`` and ``whole``, u and q."""
    p = -((s + n[f"{piece}_shift"]) ** n[f"{piece}_exponent"])
    u = n[f"{piece}_scale"] * p + n[f"{piece}_offset"]
    line = lambda what: sum(n[name] * u**i for i, name in enumerate(force.names(piece, what)))  # noqa: E731
    W = n[f"{piece}_start"] + (u + 1.0) * line("rise")
    q = V / (W + 1e-12) if piece == "near" else V * W
    total = 0.0
    for what, distance in (("main", 1.0), ("rim", q - line("rim_at")), ("whole", q - line("whole_at"))):
        named = force.names(piece, what)
        places = [(i, j) for i, j in np.ndindex(named.shape) if what != "main" or not j or i <= force.MAIN[piece][0]]
        total += np.maximum(distance, 0.0) ** 2 * sum(n[named[i, j]] * u**i * q**j for i, j in places)
    return (W - V if piece == "near" else 1.0) * total, q - line("rim_at"), q - line("whole_at"), u, q


@pytest.mark.parametrize("piece", force.PIECES)
def test_a_force_is_that_of_its_formula_and_its_slopes_are_those_of_it(piece):
    """Where no, one and both kinks count; and where a program says which of them do."""
    n = drawn(piece)
    s, V = (places.ravel() for places in np.meshgrid(np.linspace(0.2, 0.9, 9), np.linspace(0.05, 0.7, 9)))
    found = force.pull(piece, s, V, n)
    k, rim, whole, u, q = straight(piece, s, V, n)
    np.testing.assert_allclose(found.k, k, rtol=1e-11, atol=1e-13)
    counted = {(a > 0.0, b > 0.0) for a, b in zip(rim.tolist(), whole.tolist(), strict=True)}
    assert len(counted) >= 2
    h = 1e-6
    inner = np.minimum(abs(rim), abs(whole)) > 1e-4
    by_s, by_v = ((straight(piece, s + a, V + b, n)[0] - straight(piece, s - a, V - b, n)[0]) / (2.0 * h)
                  for a, b in ((h, 0.0), (0.0, h)))  # fmt: skip
    np.testing.assert_allclose(found.by_s[inner], by_s[inner], rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(found.by_v[inner], by_v[inner], rtol=1e-6, atol=1e-7)
    spot = force.spot(piece, s, V, n)
    for name, value in (("rim", rim), ("whole", whole), ("u", u), ("q", q)):
        np.testing.assert_allclose(getattr(found, name), value, rtol=1e-11, atol=1e-13)
        np.testing.assert_allclose(getattr(spot, name), value, rtol=1e-11, atol=1e-13)
    np.testing.assert_array_equal(spot.base, found.base)
    for kink, value in (("rim", rim), ("whole", whole)):
        np.testing.assert_allclose(force.distance(piece, kink, s, V, n), value, rtol=1e-11, atol=1e-13)
    if piece == "near":
        np.testing.assert_allclose(force.tension(s, V, n), found.base, rtol=1e-12)
    for behind in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)):
        told = force.pull(piece, s, V, n, behind)
        same = ((rim > 0.0) == behind[0]) & ((whole > 0.0) == behind[1])
        for name in ("k", "by_s", "by_v"):
            np.testing.assert_allclose(getattr(told, name)[same], getattr(found, name)[same], rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("piece", force.PIECES)
def test_a_film_held_at_one_height_pulls_at_each_voltage_as_one_that_is_held_there_anew(piece):
    """Bit for bit, with sums over the height that are computed once."""
    n, s = drawn(piece), np.linspace(0.2, 0.9, 9)
    held = force.Held.at(piece, s, n)
    sums = []
    for V in (0.05, np.linspace(0.1, 0.7, 9), 0.4):
        np.testing.assert_equal(held.pull(V), force.pull(piece, s, V, n))
        sums.append(dict(held._sums))
    assert all(sums[0][what] is sums[-1][what] for what in ("main", "rim", "whole", "rim_at", "whole_at"))


def test_the_pull_in_voltage_turns_within_a_thousandth_of_the_star():
    n = dict.fromkeys(force.END_NAMES, 0.0) | {force.END_NAMES[0]: 0.4, "lowest_pull_in": 0.7, "star_place": -1.0}
    n |= {"end_scale": 0.3, "end_begin": -9.0, "end_offset": 0.1, "far_shift": 0.0, "far_exponent": -1.0}
    assert force.pull_in(1.0, n) == pytest.approx(0.7 + 0.4 * 0.5e-3, abs=1e-12)
    for below in (-3e-3, 3e-3):
        expected = 0.7 + 0.2 * (np.hypot(below, 1e-3) + below)
        assert force.pull_in(1.0 / (1.0 + below), n) == pytest.approx(expected, abs=1e-12)
    for i, name in enumerate(force.END_NAMES):
        own = n | {force.END_NAMES[0]: 0.0, name: 1.0}
        t = 0.3 * np.sqrt(-2.0 + 9.0) + 0.1
        assert force.pull_in(0.5, own) == pytest.approx(0.7 + 0.5 * (np.hypot(1.0, 1e-3) + 1.0) * t**i, rel=1e-12)
