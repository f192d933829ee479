"""Components of a user's own run through every registered analysis, stores, files and the command line.

No line of gelcone knows the components of `tests.toys`: what they add - parameters, a state - must be set, swept,
drawn, saved and shown all the same.
"""

import inspect
import json
import re

import numpy as np
import pytest

import gelcone
from gelcone import ConeModel, InputError
from gelcone.devices.scales import MEASURES
from gelcone.motion.static_limits import STATIC_LIMITS
from gelcone.register.analyses import ANALYSES
from tests.answers import result
from tests.toys import TOYS, CubicBias, FilteredVoltage, PowerFilm, ThreeHarmonics

DRIVE = ["--set", "damping_ratio=0.2", "--set", "voltage=0.6", "--set", "drive_frequency=1.3"]
TYPED = {
    "film": ["--set", "film=tests.toys:PowerFilm", "--set", "film_modulus=0.9"],
    "waveform": ["--set", "waveform=tests.toys:ThreeHarmonics", "--set", "second_harmonic=0.15"],
    "bias": ["--set", "bias=tests.toys:CubicBias", "--set", "bias_cubic=0.4"],
    "circuit": ["--set", "circuit=tests.toys:FilteredVoltage", "--set", "filter_time=0.4"],
}
TYPED["together"] = [text for typed in TYPED.values() for text in typed]
TYPED["second"] = [
    *("--set", "second_film=tests.toys:PowerFilm", "--set", "second_flat_height=0", "--set", "second_drive=opposite"),
    *("--set", "second_film_modulus=0.7"),
]
OWN = {"film": "film_modulus", "waveform": "second_harmonic", "bias": "bias_cubic", "circuit": "filter_time"}
OWN["second"] = "second_film_modulus"
MODELS = TOYS | {"second": {"second_film": PowerFilm(), "second_drive": "opposite"}}
SMALL = {
    "simulate": ["--periods", "3"],
    "section": ["--repeats", "5", "--discard", "20"],
    "extrema": ["--repeats", "5", "--discard", "20"],
    "lyapunov": ["--budget", "3000", "--window", "50"],
    "frequency": ["--over", "drive_frequency=0.9:1.5:3"],
    "tongues": ["--over", "drive_frequency=1:2:3", "--over", "voltage=0.1:0.9:3"],
    "bifurcation": ["--over", "voltage=0.2:0.6:3", "--sweeps", "up"],
    "continue_branch": ["voltage", "0.3", "0.6", "--checks", "2"],
    "map": ["--over", "voltage=0.2:0.6:2", "--over", "damping_ratio=0.2:0.3:2", "--uniform"],
    "sweep": ["--over", "damping_ratio=0.2:0.3:2"],
    "basin": ["--over", "displacement=-0.5:0.5:2", "--over", "velocity=-0.5:0.5:2"],
    "transfer": ["--bias", "0.3", "--over", "drive_frequency=0.9,1.5"],
    "envelope": ["--over", "drive_frequency=0.9:1.5:2", "--over", "peak_voltage=0.2:0.6:2"],
}
"""What keeps the work small; an analysis that is not listed runs as it is."""
ASKED = [name for name in ANALYSES if name not in ("show", "locus", "drive", "film", "validate", "creep")]
"""A store is shown by the test of stores; what has no branches does not creep, what has no bifurcation has no locus,
and what rests flat no best drive; only the membrane varies from disc to rim; films of a law alone are compared with
finite elements."""


def not_swept(analysis, typed):
    """The drive, without what the analysis sweeps in its place."""
    if analysis.name in ("tongues", "envelope"):  # which need their own drive too
        return DRIVE
    swept = {text.partition("=")[0] for text in typed}
    pairs = zip(DRIVE[::2], DRIVE[1::2], strict=True)
    return [text for option, value in pairs if value.partition("=")[0] not in swept for text in (option, value)]


def documentation(name, known=()):
    """The docstring of a public function, with those of the functions that it refers to."""
    own = inspect.getdoc(getattr(gelcone, name))
    named = set(re.findall(r"`(?:gelcone\.)?(\w+)`", own)) - {name, *known}
    others = {one for one in named if inspect.isfunction(getattr(gelcone, one, None))}
    return " ".join([own, *(documentation(other, (*known, name)) for other in sorted(others))])


def undocumented(name, found):
    """The variables of a result that its docstring does not name; of a family it names the beginning, and of the errors
    of averages the end."""
    words = set(re.findall(r"\w+", documentation(name))) | {
        state.name for state in gelcone.model_of(found).system.states
    }
    families = ("validity_", "film_state_", "second_", "motion_validity_", "motion_film_state_", "static_", "driven_")
    families += ("proportional_",)
    left = [str(own) for own in found.data_vars if own not in words and not str(own).startswith(families)]
    if "_standard_error" in words:
        left = [own for own in left if own.removesuffix("_standard_error") not in {*words} - {own}]
    return [own for own in left if own not in LIMITS]


QUANTITIES = {
    *MEASURES,
    *(
        "angle",
        "code",
        "count",
        "flag",
        "level",
        "margin",
        "multiplier",
        "parameter",
        "ratio",
        "share",
        "state",
        "stretch",
    ),
}
LIMITS = {f"{limit.replace(' ', '_').replace('-', '_')}_voltage" for limit in STATIC_LIMITS}


@pytest.mark.parametrize("toy", ["together", *(pytest.param(toy, marks=pytest.mark.slow) for toy in MODELS)])
@pytest.mark.parametrize("name", ASKED)
def test_every_analysis_takes_components_of_ones_own(name, toy, command_line, undrawn, tmp_path):
    """All four together, a system of three states; and, slower, each alone."""
    analysis = ANALYSES[name]
    arguments = [
        analysis.command,
        *TYPED[toy],
        *not_swept(analysis, SMALL.get(name, [])),
        *SMALL.get(name, []),
        "--json",
        "--out",
        "results",
    ]
    code, out, err = command_line(*arguments)
    assert code == 0, err
    answer = result(out)
    typed = dict(setting.split("=", 1) for setting in TYPED[toy][1::2])
    (written,) = (tmp_path / "results").glob("*.nc")
    assert int((tmp_path / "results" / f"{written.stem}.png").read_text().split()[0]) > 0
    found = gelcone.load(written)
    assert name == "sweep" or undocumented(name, found) == []  # a sweep has the variables of its analysis
    assert {own.attrs["quantity"] for own in found.variables.values() if "quantity" in own.attrs} <= QUANTITIES
    model = gelcone.model_of(found)
    for kind in TOYS if toy == "together" else [toy]:
        own, expected = OWN[kind], float(typed[OWN[kind]])
        assert answer["parameters"][own] == expected
        part = model.system.films[1].film if kind == "second" else getattr(model.system, kind)
        assert part == (PowerFilm() if kind == "second" else TOYS[kind][kind])
        assert np.all(np.asarray(model.values[own]) == expected)


@pytest.mark.parametrize("toy", MODELS)
def test_what_a_component_adds_is_swept_stored_resumed_and_shown(toy, tmp_path):
    model = ConeModel(damping_ratio=0.3, voltage=0.4, drive_frequency=1.3, **MODELS[toy])
    own = OWN[toy]
    values = model.values[own] * np.array([1.0, 1.2])
    plan = gelcone.Plan(model, {own: values, "voltage": [0.2, 0.4]})
    alone = gelcone.sweep(plan)
    stored = gelcone.sweep(plan, store=tmp_path / "toy.zarr")
    resumed = gelcone.sweep(plan, store=tmp_path / "toy.zarr", resume=True)
    for name in ("regime", "lyapunov", "highest"):
        np.testing.assert_array_equal(alone[name], stored[name])
        np.testing.assert_array_equal(alone[name], resumed[name])
    assert json.loads(resumed.attrs["totals"])["computed_before"] == plan.size
    shown = gelcone.show(tmp_path / "toy.zarr")
    np.testing.assert_array_equal(shown[own], values)
    assert gelcone.model_of(shown).system == model.system
    single = gelcone.regime(model.replace(**{own: values[1], "voltage": 0.2}))
    np.testing.assert_array_equal(single["lyapunov"], alone["lyapunov"].sel({own: values[1], "voltage": 0.2}))


# --- their physics ----------------------------------------------------------------------------------------------------


def test_a_filter_weakens_and_delays_the_voltage_as_its_gain_says():
    model = ConeModel(circuit=FilteredVoltage(), filter_time=0.7, voltage=0.5, drive_frequency=2.0)
    response = gelcone.simulate(model, (0.0, 0.0), periods=30)
    omega, gain = 2.0, 1.0 / (1.0 + 2.0j * 0.7)
    late = response.isel(time=slice(-101, None))
    expected = 0.5 * np.imag(gain * np.exp(1j * omega * late["time"].values))
    np.testing.assert_allclose(late["film_voltage"], expected, atol=1e-9)
    np.testing.assert_allclose(late["drive_voltage"], 0.5 * np.sin(omega * late["time"]), atol=1e-12)


def test_the_exponents_of_a_filtered_system_are_three_and_add_up():
    model = ConeModel(circuit=FilteredVoltage(), filter_time=0.5, damping_ratio=0.2, voltage=0.4, drive_frequency=1.3)
    found = gelcone.lyapunov(model, budget=3000.0)
    assert found["lyapunov"].shape == (3,)
    assert float(found["lyapunov"].sum()) == pytest.approx(-0.4 - 1.0 / 0.5, abs=1e-8)
    # the filter's own state decays with its time constant, whatever the disc does
    assert float(abs(found["lyapunov"] + 2.0).min()) < 1e-6


def test_a_fast_filter_is_the_ideal_source():
    ideal = ConeModel(damping_ratio=0.3, voltage=0.5, drive_frequency=1.3, voltage_bias=0.4, rest_height=0.3)
    fast = ideal.replace(circuit=FilteredVoltage(), filter_time=1e-4)
    one, other = (gelcone.settled(model) for model in (ideal, fast))
    assert float(other["stroke"]) == pytest.approx(float(one["stroke"]), rel=1e-3)
    rest, filtered = (gelcone.floquet_multipliers(m.replace(rest_height=0.0)) for m in (ideal, fast))
    assert float(filtered["growth_rate"]) == pytest.approx(float(rest["growth_rate"]), abs=1e-4)


def test_a_cubic_bias_without_cube_is_the_spring():
    spring = ConeModel(spring_stiffness=1.2, damping_ratio=0.1, voltage=0.9, drive_frequency=0.7)
    cubic = ConeModel(
        bias=CubicBias(), bias_stiffness=1.2, bias_cubic=0.0, damping_ratio=0.1, voltage=0.9, drive_frequency=0.7
    )
    one, other = (gelcone.integrate(model, (1.0, 0.0), [20.0]) for model in (spring, cubic))
    np.testing.assert_allclose(other.states, one.states, rtol=1e-12)
    voltages = [float(gelcone.pitchfork_voltage(model).pitchfork_voltage) for model in (spring, cubic)]
    assert voltages[1] == pytest.approx(voltages[0], rel=1e-12)


def test_harmonics_that_are_nothing_leave_the_sine_and_its_forcing_period_doubles_with_the_second():
    sine = ConeModel(voltage=0.8, drive_frequency=0.6)
    plain = sine.replace(waveform=ThreeHarmonics(), second_harmonic=0.0, third_harmonic=0.0)
    one, other = (gelcone.integrate(model, (1.0, 0.0), [30.0]) for model in (sine, plain))
    np.testing.assert_allclose(other.states, one.states, rtol=1e-11)
    assert float(plain.forcing_period) == 2.0 * float(sine.forcing_period)


def test_the_energy_of_a_film_that_knows_only_its_force_is_conserved():
    model = ConeModel(film=PowerFilm(), damping_ratio=0.0, voltage=0.0, spring_stiffness=0.5)
    response = gelcone.simulate(model, (1.2, 0.0), periods=20)
    assert float(abs(response["energy_residual"]).max()) < 1e-12
    # what the film does not say of itself is unknown, not fine
    assert np.isnan(float(response["validity_hoop_slack"]))


def test_a_component_that_cannot_be_imported_again_says_what_to_do(tmp_path):
    class Passing(PowerFilm):
        name = "passing"

    response = gelcone.simulate(ConeModel(film=Passing()), periods=1)
    gelcone.save(response, tmp_path / "passing.nc")
    with pytest.raises(InputError, match="put its class into a module that Python finds"):
        gelcone.model_of(gelcone.load(tmp_path / "passing.nc"))


def test_the_command_line_finds_a_class_in_the_folder_it_runs_in(command_line, tmp_path):
    (tmp_path / "my_springs.py").write_text(
        "from tests.toys import CubicBias\n\n\nclass Mine(CubicBias):\n    name = 'mine'\n"
    )
    code, out, err = command_line("limits", "--set", "bias=my_springs:Mine", "--set", "bias_stiffness=1.44", "--json")
    assert code == 0, err
    assert result(out)["pitchfork_voltage"] == pytest.approx(1.2, rel=1e-12)
