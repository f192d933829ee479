"""Rest under a constant command: nothing flows in films, bias and circuits, and a step to it does not move."""

import numpy as np
import pytest

import gelcone
from gelcone.motion.linear import slopes_under
from gelcone.motion.rest import _circuit_slopes, circuits_under, rest_under
from gelcone.physics.commanded import voltage_under
from gelcone.physics.film.at_once import films_at_once
from gelcone.physics.film.film import Film
from gelcone.physics.film.membrane import MembraneFilm
from gelcone.physics.film.taut import TautCone
from gelcone.physics.film.wrinkling import WrinklingCone
from gelcone.physics.model import ConeModel
from tests.toys import TurningBias

OWN = {"rest_height": 0.8, "hoop_prestretch": 1.4, "damping_ratio": 0.25, "spring_stiffness": 1.5}
BRANCH = {"viscous_modulus_1": 0.4, "relaxation_time_1": 3.0}
LEAK = {"series_resistance": 3.0, "leakage_time": 12.0, "leakage_field": 0.4}


class LaggingFilm(Film):
    """A film of one's own whose pull follows displacement and voltage with a delay; at rest it pulls as the one
    without."""

    name = "lagging"
    states = (gelcone.State("lag", "pull, late", "share"),)
    parameters = {"lag_time": gelcone.Quantity("tl", "time constant of the pull", 2.0, positive=True, scale="time")}

    def force(self, x, squared, y, n, xp=np):
        pull = y[0] if y else 2.0 + x * x - squared
        return pull * x, pull + (0.0 if y else 2.0 * x * x)

    def rates(self, x, velocity, squared, y, n, xp=np):
        return [(2.0 + x * x - squared - y[0]) / n["lag_time"]]

    def time_constant(self, n):
        return n["lag_time"]


FILMS = {
    f"{film.name}, {words}": {**OWN, **BRANCH, "film": film(branches=1, **more), "rest_height": height}
    for film in (TautCone, WrinklingCone, MembraneFilm)
    for words, height, more in (
        ("log", 0.8, {}),
        ("linear", 0.8, {"flow": "linear"}),
        ("exponent", 0.8, {"flow_exponent": 3}),
        ("flat", 0.0, {"flow_exponent": 5}),
    )
}
MODELS = FILMS | {
    "wrinkled": {**FILMS["wrinkling, log"], "hoop_prestretch": 1.0, **LEAK},
    "current limit": {**FILMS["taut, exponent"], **LEAK, "current_limit": 0.01},
    "two films": {**FILMS["taut, log"], "second_film": TautCone(branches=1), "second_flat_height": 1.4, **LEAK},
    "late permittivity": {**FILMS["taut, log"], **LEAK, "dielectric_share": 0.3, "dielectric_time": 2.0},
    "film of one's own": {"film": LaggingFilm(), "rest_height": 0.8, "spring_stiffness": 1.5, "damping_ratio": 0.25},
    "bias of one's own": {"film": TautCone(branches=1), "bias": TurningBias(), "damping_ratio": 0.25, **BRANCH},
    "filter": {**OWN, "filter_time": 0.4, "slew_rate": 2.0},
}
LEVELS = (0.0, 0.5)


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("name", MODELS)
def test_at_rest_no_state_changes(name, level):
    model = ConeModel(voltage=0.2, **MODELS[name])
    place = float(gelcone.stroke_and_blocked_force(model, [level])["displacement"][0])
    z = rest_under(model, place, level)
    assert z[0] == place
    system, n = model.system, model.numbers()
    rates = system.under(level, [np.float64(value) for value in z], n).rates()
    np.testing.assert_allclose(np.array(rates, dtype=float), 0.0, atol=1e-10)
    volts = [voltage_under(system, line, place, system.command_of(line, level, n), n) for line in system.film_lines]
    assert np.isfinite(slopes_under(model.members(), np.array([[place]]), [np.array([[v]]) for v in volts])).all()


@pytest.mark.parametrize("level", LEVELS)
@pytest.mark.parametrize("name", FILMS)
def test_a_film_that_creeps_begins_a_step_relaxed(name, level):
    found = gelcone.step(ConeModel(voltage=0.2, **FILMS[name]), [level], before=level, duration=10.0, tolerance=1e-10)
    assert np.abs(found["displacement"] - found["initial_displacement"]).max() < 1e-9


def test_a_film_relaxes_to_its_lengths_under_voltage():
    """A wrinkled one is wider and longer than without."""
    film = WrinklingCone(branches=1)
    n = ConeModel(film=film, rest_height=0.8, hoop_prestretch=1.0).numbers()
    for squared in (0.0, 0.3):
        m, width = film.lengths(0.5, squared, n)
        assert film.relaxed(0.5, squared, n) == [1.0 / m, 1.0 / width]
    assert width > 1.0


def test_the_rates_of_circuits_are_traced_once_for_all_voltages():
    model = ConeModel(**MODELS["late permittivity"])
    before = _circuit_slopes.cache_info()
    for level in (0.3, 0.4, 0.5):
        rest_under(model, 0.6, level)
    after = _circuit_slopes.cache_info()
    assert after.misses - before.misses <= 1
    assert after.hits - before.hits >= 2


def test_a_membrane_at_once_rests_at_the_voltage_of_its_run():
    """Behind a resistance the leak has the capacitance that programs have."""
    model, command = ConeModel(**MODELS["membrane, log"], **LEAK), np.float64(0.4)
    start = model.members().start_states((0.7, 0.0))
    held = films_at_once(model, start)
    voltage = voltage_under(held.system, held.system.lines[0], 0.7, command, held.numbers_at(0))
    own = circuits_under(model.system, command, list(start[0]), model.numbers())
    assert own[-1] == pytest.approx(float(voltage), rel=1e-13)
    assert 0.05 < voltage < 0.99 * command
