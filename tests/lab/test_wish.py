"""Wishes: requirements, bounds, tolerances and objectives, in SI and within limits."""

import re

import numpy as np
import pytest

from gelcone.devices.fields import DEVICE_FIELDS
from gelcone.errors import InputError
from gelcone.lab.wish import (
    FIRST_WISH,
    MEASURES,
    MOST_FREE,
    MOST_OBJECTIVES,
    MOST_TOLERANCES,
    Objective,
    Requirement,
    Tolerance,
    _bounds,
    _middle,
    _objectives,
    _requirement,
    _share,
    _table,
    read_wish,
    with_samples,
)  # fmt: skip

WISH = """
stroke = ">= 2 mm"
peak_voltage = "<= 2 kV"
smallest = ["apparent_power"]
frequency = "10 Hz"
footprint = "60 mm"
film = "taut"
disc_radius = "8 mm"
film_thickness = "0.2 mm"
hoop_prestretch = 1.4
moving_mass = "5 g"
damping_coefficient = "10 mN s/m"
material = "PVC-DBA 6:1"
voltage_offset = "0.8 kV"
voltage_amplitude = "0.7 kV"
[free]
spring_rate = "1 N/m:100 N/m"
initial_height = "5 mm:40 mm"
[tolerances]
film_thickness = "5 %"
hoop_prestretch = 0.02
"""


FIRST = FIRST_WISH.replace("{file}", "wish.toml")


@pytest.fixture
def wish(tmp_path):
    def read(old="", new="", text=WISH):
        path = tmp_path / "wish.toml"
        path.write_text(text.replace(old, new) if old else text)
        return read_wish(path)

    return read


def test_a_wish_holds_what_is_written_in_si(wish):
    found = wish()
    assert found.requirements == (Requirement("stroke", True, 2e-3), Requirement("peak_voltage", False, 2e3))
    assert found.free == {"spring_rate": (1.0, 100.0), "initial_height": (5e-3, 0.04)}
    assert found.tolerances == (Tolerance("film_thickness", 0.05, True), Tolerance("hoop_prestretch", 0.02, False))
    assert found.objectives == (Objective("apparent_power", False),)
    assert (found.margin, found.confidence, found.uncertain) == (0.2, 0.95, 2)
    assert found.device.film_radius == pytest.approx(0.03)
    assert found.device.spring_rate == pytest.approx(10.0)
    assert found.device.initial_height == pytest.approx((5e-3 * 0.04) ** 0.5)


@pytest.mark.parametrize(("key", "low", "high"), [("confidence", 0.5, 0.99), ("margin", 0.0, 0.9)])
def test_shares_of_a_wish_reach_from_their_lower_to_their_upper_bound(wish, key, low, high):
    """A search of some hundred draws cannot tell a confidence above 99 % from certainty."""
    for given, share in ((low, low), (high, high), (f'"{100.0 * high:g} %"', high)):
        assert getattr(wish('frequency = "10 Hz"', f'frequency = "10 Hz"\n{key} = {given}'), key) == pytest.approx(
            share
        )
    for given in (low - 0.01, high + 0.009):
        with pytest.raises(InputError, match=f"{key} = {given}: must be a share from {low:g} to {high:g}"):
            wish('frequency = "10 Hz"', f'frequency = "10 Hz"\n{key} = {given}')


def test_bounds_about_zero_have_their_mean_in_the_middle():
    assert _middle((0.0, 2.0)) == 1.0
    assert _middle((-1.0, 3.0)) == 1.0
    assert _middle((1.0, 4.0)) == 2.0
    assert _bounds({"voltage_offset": "0 V:2 kV", "hoop_prestretch": "1:2"}) == {
        "voltage_offset": (0.0, 2e3),
        "hoop_prestretch": (1.0, 2.0),
    }


@pytest.mark.parametrize(("text", "bound"), [(">= 5 mVA", 5e-3), ("<=0.1 W", 0.1), (">=  3mW", 3e-3)])
def test_powers_may_be_apparent(text, bound):
    assert _requirement("apparent_power", text) == Requirement("apparent_power", text.startswith(">"), bound)


def test_objectives_are_in_their_order_and_the_probability_where_there_are_none():
    assert _objectives({}) == (Objective("probability", True),)
    both = {"smallest": ["current", "peak_voltage"], "largest": "stroke"}
    names = [("current", False), ("peak_voltage", False), ("stroke", True)]
    assert _objectives(both) == tuple(Objective(*one) for one in names)
    assert len(names) == MOST_OBJECTIVES
    with pytest.raises(InputError, match="4 objectives: give at most 3"):
        _objectives(both | {"largest": ["stroke", "blocked_force"]})
    with pytest.raises(InputError, match="is an objective twice"):
        _objectives({"smallest": ["current", "current"]})


@pytest.mark.parametrize(
    ("value", "share"), [("20 %", 0.2), (0.5, 0.5), ("0.3", 0.3), (None, 0.25), (0.1, 0.1), (0.9, 0.9)]
)
def test_shares_may_be_percent(value, share):
    assert _share({} if value is None else {"margin": value}, "margin", 0.25, 0.1, 0.9) == pytest.approx(share)


@pytest.mark.parametrize("value", [0.09, 0.91, "95 %", "much", True, "nan"])
def test_shares_out_of_bounds_are_refused(value):
    with pytest.raises(InputError, match=r"margin = .*: must be a share from 0.1 to 0.9"):
        _share({"margin": value}, "margin", 0.25, 0.1, 0.9)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('">= 2 mm"', '"2 mm"', "must be a bound"), ('">= 2 mm"', '">= 0 mm"', "stroke"),
        ('"1 N/m:100 N/m"', '"100 N/m:1 N/m"', "first bound must be the smaller"),
        ('"1 N/m:100 N/m"', '"5 N/m:5 N/m"', "first bound must be the smaller"),
        ('"1 N/m:100 N/m"', '"100 N/m"', "must be two bounds"),
        ("hoop_prestretch = 0.02", "beam_rate = 0.02", "not set"),
        ("hoop_prestretch = 0.02", 'damping_ratio = "10 %"', "not set"),
        ('film = "taut"', 'film = "tau"', "did you mean 'taut'"), ("moving_mass", "moving_mas", "did you mean"),
    ],
)  # fmt: skip
def test_wishes_that_cannot_be_are_refused(wish, old, new, message):
    with pytest.raises(InputError, match=message):
        wish(old, new)


@pytest.mark.parametrize("name", ["film_thickness", "hoop_prestretch"])
def test_a_field_is_uncertain_by_a_tolerance_or_by_draws(wish, name):
    """Not by both, whichever of several tolerances it is."""
    with pytest.raises(InputError, match=rf"^samples: \[tolerances\] holds {name}, too"):
        with_samples(wish(), {"spring_rate": np.array([2.0, 3.0]), name: np.array([1.4, 1.5])})
    own = with_samples(wish(), {"moving_mass": np.array([4e-3, 5e-3, 9e-3])})
    assert (own.uncertain, own.device.moving_mass) == (3, pytest.approx(5e-3))


def test_draws_that_are_uncertain_together_are_reproduced_by_their_root(wish):
    """Its square is the covariance of the logarithms; a free field stays in the middle of its bounds."""
    rng = np.random.default_rng(2)
    stiff = rng.normal(size=200)
    draws = {
        "moving_mass": 5e-3 * np.exp(0.1 * stiff + 0.05 * rng.normal(size=200)),
        "spring_rate": 8.0 * np.exp(0.3 * stiff),
    }
    own = with_samples(wish(), draws)
    logs = np.log(list(draws.values()))
    np.testing.assert_allclose(own.samples.root @ own.samples.root.T, np.cov(logs), rtol=1e-10, atol=1e-15)
    assert own.samples.names == tuple(draws)
    np.testing.assert_allclose(own.samples.medians, np.median(list(draws.values()), axis=1), rtol=1e-3)
    assert own.device.moving_mass == pytest.approx(own.samples.medians[0])
    assert own.device.spring_rate == wish().device.spring_rate


@pytest.mark.parametrize(("text", "least"), [("<= 70 mm", False), (">=50 mm", True)])
def test_a_footprint_is_a_size_or_a_bound(wish, text, least):
    """As a bound it is required of a ring whose radius is given or free."""
    found = wish('footprint = "60 mm"', f'footprint = "{text}"\nfilm_radius = "31 mm"')
    assert found.requirements[-1] == Requirement("footprint", least, 0.05 if least else 0.07)
    assert found.device.film_radius == 0.031
    with pytest.raises(InputError, match="footprint and film_radius are both given; give one"):
        wish('footprint = "60 mm"', 'footprint = "60 mm"\nfilm_radius = "31 mm"')


def test_a_first_wish_reads_back(wish):
    found = wish(text=FIRST)
    assert [one.name for one in found.requirements] == ["stroke", "peak_voltage"]
    assert (found.margin, found.confidence, found.device.film_radius) == (0.2, 0.95, 0.03)
    assert found.free["disc_radius"] == (0.004, 0.015)
    assert ("material.shear_modulus", 0.1, True) in found.tolerances


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('stroke = ">= 5 mm"', 'stroke = "5 mm"', r'stroke = \'5 mm\': must be a bound, such as stroke = ">= 5 mm"'),
        ('stroke = ">= 5 mm"', 'stroke = ">= 5 kV"', "kV is a unit of voltage, not of length"),
        (
            'stroke = ">= 5 mm"',
            'strok = ">= 5 mm"',
            "'strok' is not a field, requirement or setting; did you mean 'stroke'",
        ),
        ("margin = 0.2", "margin = 2", "margin = 2: must be a share from 0 to 0.9"),
        ("margin = 0.2", "margin = true", "margin = True: must be a share"),
        ('"4 mm:15 mm"', '"15 mm:4 mm"', "the first bound must be the smaller one"),
        ('"4 mm:15 mm"', '"4 mm"', 'must be two bounds, such as "4 mm:15 mm"'),
        ('disc_radius = "4', 'disk_radius = "4', "did you mean 'disc_radius'"),
        ('"apparent_power"', '"aparent_power"', "did you mean 'apparent_power'"),
        ('frequency = "10 Hz"', 'frequency = "10 Hz"\nspring_rate = "5 N/m"', "spring_rate: is given and free"),
        (
            'frequency = "10 Hz"',
            'frequency = "10 Hz"\nfilm_radius = "30 mm"',
            "footprint and film_radius are both given",
        ),
        ('spring_rate = "3 %"', 'spring_rat = "3 %"', "did you mean 'spring_rate'"),
        ('spring_rate = "3 %"', 'spring_rate = "-3 %"', "must be greater than 0"),
        ('material = "PVC-DBA 6:1"', 'material = "VHB 4910"', "takes a gel that does not creep"),
        ('material = "PVC-DBA 6:1"', 'material = "os:system"', "'os:system' is not a material"),
        ('frequency = "10 Hz"', 'frequency = "10 Hz"\nwaveform = "square"', "takes a sine; leave waveform out"),
        ('frequency = "10 Hz"', 'frequency = "10 Hz"\nbeam_rate = "-1 N/m"', "leave beam_rate out"),
        ('frequency = "10 Hz"', 'frequency = "10 Hz"\nfilm = "os:path"', "'os:path' is not a film of a design"),
        ("[free]", "[free", "broken TOML"),
    ],
)
def test_a_wish_that_cannot_be_used_is_refused_in_one_line(wish, old, new, message):
    assert old in FIRST
    with pytest.raises(InputError, match=message) as caught:
        wish(text=FIRST.replace(old, new, 1))
    assert "\n" not in str(caught.value)


def test_fields_of_a_material_stand_under_dotted_names_as_deep_as_they_may(wish):
    found = wish("hoop_prestretch = 0.02", '[tolerances.material]\nshear_modulus = "10 %"')
    assert Tolerance("material.shear_modulus", 0.1, True) in found.tolerances
    assert _table({"free": {"a": 1, "b": {"c": 2, "d": 3}}}, "free") == {"a": 1, "b.c": 2, "b.d": 3}
    assert _table({}, "free") == {}
    for key, most in (("free", MOST_FREE), ("tolerances", MOST_TOLERANCES)):
        many = {f"f{k}": 1 for k in range(most)}
        assert _table({key: many}, key) == many
        with pytest.raises(InputError, match=rf"\[{key}\]: has {most + 1} fields; give at most {most}"):
            _table({key: {"one": {"more": 1}} | many}, key)
    with pytest.raises(InputError, match=r"free = '3': must be a table, \[free\]"):
        _table({"free": "3"}, "free")


@pytest.mark.parametrize("name", [name for name, field in DEVICE_FIELDS.items() if field.unit])
def test_a_bound_below_what_the_field_may_have_is_refused(name):
    """The least value itself may be one; a value that it must be above may not."""
    field = DEVICE_FIELDS[name]
    lowest = field.above if field.least is None else field.least
    inside, outside = (-2.0, None) if lowest is None else (lowest, lowest - 0.25)
    if field.above is not None and field.least is None:
        inside, outside = lowest + 0.25, lowest
    assert _bounds({name: f"{inside}:{inside + 1.0}"}) == {name: (inside, inside + 1.0)}
    if outside is not None:
        with pytest.raises(InputError, match=rf"\[free\] {name} = .*: must be "):
            _bounds({name: f"{outside}:{inside + 1.0}"})


@pytest.mark.parametrize("name", MEASURES)
def test_the_example_of_a_requirement_is_one(name):
    with pytest.raises(InputError, match="must be a bound, such as") as error:
        _requirement(name, "5")
    (example,) = re.findall(rf'such as {name} = "(.*?)"', str(error.value))
    assert _requirement(name, example).bound > 0.0
