"""Regimes: every kind with its evidence, flags, and a small labelled set."""

import importlib
import importlib.util
import json
import sys
from pathlib import Path

import numpy as np
import pytest

from gelcone.codes import Outcome, Regime
from gelcone.dataset import load, save
from gelcone.errors import InputError
from gelcone.motion.attractor.classification import RETURNS, Evidence, classify
from gelcone.motion.attractor.cycle import FIRST_TOLERANCE as ROUGH
from gelcone.motion.flow import integrate
from gelcone.motion.regime import regime
from gelcone.physics.model import ConeModel
from gelcone.presets import find_preset
from gelcone.statistics import wilson
from tests.recorded import numbers, record

module = importlib.import_module("gelcone.motion.regime")

SET = {"spring_stiffness": 0.5, "damping_ratio": 0.05, "drive_frequency": 0.3}


def one(initial=(1.0, 0.0), **parameters):
    """The Dataset of a single model and its regime in words."""
    result = regime(ConeModel(**parameters), initial)
    return result, Regime(int(result["regime"])).label


# --- rest and cycles --------------------------------------------------------------------------------------------------


def test_rest_without_drive_and_below_the_onset():
    for voltage in (0.0, 0.3):
        result, name = one(**SET, voltage=voltage)
        assert (name, int(result["period"]), int(result["doubtful"])) == ("rest", 0, 0)
        assert float(result["lyapunov"][0]) == pytest.approx(-0.05, abs=1e-8)
        assert float(result["highest"]) < 1e-5


def test_rest_away_from_the_middle():
    """A constant voltage beyond the pitchfork: the disc rests on the side it started on."""
    for side in (1.0, -1.0):
        result, name = one((side, 0.0), **SET, voltage=0.0, voltage_bias=1.2)
        assert name == "rest"
        assert side * float(result["lowest"]) > 0.1
        assert not int(result["symmetric"])


@pytest.mark.parametrize(
    ("parameters", "initial", "period", "symmetric"),
    [
        (SET | {"voltage": 1.0}, (1.0, 0.0), 1, False),
        ({"damping_ratio": 0.1, "voltage": 0.2, "voltage_bias": 0.3, "rest_height": 0.5}, (0.5, 0.0), 1, False),
        (SET | {"voltage": 0.8}, (1.0, 0.0), 2, True),
        (SET | {"voltage": 1.1}, (1.0, 0.0), 2, False),
        (
            {
                "spring_stiffness": 0.196,
                "damping_ratio": 0.269,
                "drive_frequency": 1.885,
                "voltage": 1.769,
                "voltage_bias": -0.375,
                "stretch_limit": 93.9,
            },
            (1.0, 0.0),
            4,
            False,
        ),
    ],
)
def test_cycles(parameters, initial, period, symmetric):
    result, name = one(initial, **parameters)
    assert (name, int(result["period"]), bool(result["symmetric"])) == ("periodic", period, symmetric)
    assert int(result["doubtful"]) == 0
    assert int(result["sign"]) == -1
    assert np.isnan(float(result["zero_one"]))
    exponents = result["lyapunov"].values
    assert exponents.sum() == pytest.approx(-2.0 * parameters["damping_ratio"], abs=1e-7)
    assert float(result["cycle_distance"]) < 1e-4
    # By simulation: the section goes over itself after the period, and after no divisor of it.
    points = result["section"].values
    size = np.abs(points).max()
    gaps = [np.abs(points[n:] - points[:-n]).max() / size for n in range(1, period + 1)]
    assert gaps[-1] < 1e-4
    assert all(gap > 1e-2 for gap in gaps[:-1])


def test_the_exponents_of_a_cycle_are_the_decay_of_a_deviation_from_it():
    """A real multiplier near 1: a start beside the cycle comes back at the rate that the exponent says."""
    model = ConeModel(**SET, voltage=1.5)
    result = regime(model)
    rate = float(result["lyapunov"][0])
    assert -0.02 < rate < -0.01
    repeat, point = float(model.forcing_period), result["section"].values[-1]
    cycle_after = 2 * repeat * np.arange(1, 21)
    runs = integrate(model.take([0, 0]), [point, point + np.array([1e-6, 0.0])], cycle_after).states
    apart = np.linalg.norm(runs[1] - runs[0], axis=1)
    slope = np.log(apart[15] / apart[8]) / (cycle_after[15] - cycle_after[8])
    assert slope == pytest.approx(rate, rel=1e-3)


def test_a_slow_drive_that_squeezes_every_motion_together_once_a_repeat():
    """Where the voltage vanishes all motions meet at rest; in between they go to one side and the other in turn."""
    result, name = one(spring_stiffness=0.6, damping_ratio=0.4, drive_frequency=0.01, voltage=1.35)
    assert np.abs(result["section"].values).max() < 1e-9
    assert float(result["highest"]) > 3.0
    assert float(result["lowest"]) < -3.0
    assert (name, int(result["period"]), bool(result["symmetric"])) == ("periodic", 2, True)


# --- the other kinds --------------------------------------------------------------------------------------------------


def test_chaos_in_both_opinions():
    result, name = one(spring_stiffness=0.9, damping_ratio=0.1, drive_frequency=1.5, voltage=2.5)
    assert (name, int(result["doubtful"]), int(result["sign"])) == ("chaotic", 0, 1)
    assert float(result["lyapunov"][0]) > 10.0 * float(result["standard_error"][0])
    assert float(result["zero_one"]) > 0.9
    assert int(result["period"]) == 0
    assert np.isnan(float(result["cycle_distance"]))
    # one forcing period leads from each point to the next, and the motion stays in its extent, of which it fills much
    model = ConeModel(spring_stiffness=0.9, damping_ratio=0.1, drive_frequency=1.5, voltage=2.5)
    points, turn = result["section"].values, np.pi / 1.5
    np.testing.assert_allclose(integrate(model, points[3], [turn]).states[0, -1], points[4], atol=1e-6)
    x = integrate(model, points[3], np.linspace(0.0, 5.0 * turn, 200)[1:]).states[0, :, 0]
    low, high = float(result["lowest"]), float(result["highest"])
    room = 0.02 * (high - low)
    assert low - room < x.min() < x.max() < high + room
    assert np.ptp(x) > 0.6 * (high - low)


@pytest.mark.parametrize("voltage", [0.0, 0.1])
def test_quasi_periodic_without_damping(voltage):
    result, name = one(spring_stiffness=1.5, damping_ratio=0.0, voltage=voltage, drive_frequency=0.77)
    assert (name, int(result["doubtful"]), int(result["sign"])) == ("quasi-periodic", 0, 0)
    assert float(result["zero_one"]) < 0.2


def test_chaos_without_damping():
    result, name = one(spring_stiffness=0.5, damping_ratio=0.0, voltage=1.5, drive_frequency=0.3)
    assert (name, int(result["sign"])) == ("chaotic", 1)


def test_chaos_that_ends_says_so_and_what_it_ends_in():
    """Of 700 starts nearly all end within 30,000, after 8,800 +- 330 in the mean, on a cycle of 6."""
    model = ConeModel(damping_ratio=0.05, spring_stiffness=1.5, drive_frequency=1.0, voltage=3.0)
    for start in (1.0, 1.0 + 1e-12):
        result = regime(model, (start, 0.0))
        assert (Regime(int(result["regime"])).label, int(result["period"])) == ("transient chaos", 6)
        assert float(result["lifetime_low"]) < 9_500.0
        assert float(result["lifetime_high"]) > 8_100.0
        assert 0.0 < float(result["share_chaotic"]) < 1.0
        assert int(result["sign"]) == -1
        assert float(result["lyapunov"].sum()) == pytest.approx(-0.1, abs=1e-7)
        # chaos for some, and two mirror images of the cycle for the others
        assert set(result["fate_regime"].values.tolist()) == {Regime.CHAOTIC, Regime.PERIODIC}
        assert float(result["fate_share"].sum()) == pytest.approx(1.0)
        assert (result["fate_share_low"] <= result["fate_share"]).all()
        assert (result["fate_share"] <= result["fate_share_high"]).all()
        # the ends are the shares p at which the observed one is 1.96 standard deviations of 16 draws away
        for end in ("low", "high"):
            p, share = result[f"fate_share_{end}"].values, result["fate_share"].values
            within = (share > 0.0) & (share < 1.0)
            away = np.abs(share - p)[within] / np.sqrt(p * (1.0 - p) / float(result["starts"]))[within]
            np.testing.assert_allclose(away, 1.96, atol=1e-3)


def test_the_name_of_chaos_that_ends_does_not_hang_on_the_start():
    """Points of the paper's grids where 0.1 said now one thing and now another."""
    for preset, voltage in (("base", 1.45), ("fast", 1.55)):
        model = find_preset(preset).model.replace(voltage=np.full(3, voltage))
        result = regime(model, np.array([[1.0, 0.0], [1.0 + 1e-12, 0.0], [1.0 - 1e-10, 1e-11]]))
        assert (result["regime"] == Regime.TRANSIENT_CHAOS).all()
        assert len(set(result["period"].values.tolist())) == 1
        low, high = result["lifetime_low"].values, result["lifetime_high"].values
        assert low.max() < high.min()


def test_chaos_that_lasts_says_how_long_it_was_seen():
    result, name = one(spring_stiffness=0.9, damping_ratio=0.1, drive_frequency=1.5, voltage=2.5)
    assert name == "chaotic"
    assert float(result["chaotic_until"]) >= 1e5
    assert (float(result["share_chaotic"]), float(result["lifetime"])) == (1.0, np.inf)
    assert 4e4 < float(result["lifetime_low"]) < 6e4
    slow = regime(ConeModel(spring_stiffness=0.9, damping_ratio=0.01, drive_frequency=0.005, voltage=1.7), patience=2e4)
    if int(slow["regime"]) == Regime.CHAOTIC:
        assert float(slow["chaotic_until"]) >= 2e4


def test_chaos_of_a_moment_is_no_transient_chaos():
    """A motion that settles at once is named by what it settles to, however its start decides between attractors."""
    _, name = one(**SET | {"damping_ratio": 0.01}, voltage=1.0)
    assert name in ("periodic", "rest")


def test_left_the_domain():
    model = ConeModel(
        spring_stiffness=0.5,
        damping_ratio=0.05,
        drive_frequency=0.3,
        voltage=[0.5, 0.0, 0.5],
        voltage_bias=[0.0, 2.0, 0.0],
        stretch_limit=[0.4, np.inf, 50.0],
    )
    result = regime(model)
    assert [Regime(code).label for code in result["regime"].values[:2]] == ["left the domain"] * 2
    assert result["outcome"].values.tolist() == [Outcome.OUTSIDE, Outcome.NOT_FINITE, Outcome.OK]
    assert np.isnan(result["lyapunov"].values[:2]).all()
    alone = regime(model.take([2]))
    np.testing.assert_array_equal(alone["lyapunov"].values[0], result["lyapunov"].values[2])


# --- flags ------------------------------------------------------------------------------------------------------------


def test_rest_on_a_hilltop_is_flagged():
    """Started exactly at rest where that is unstable, the disc stays; the exponent says that it would not."""
    result, name = one((0.0, 0.0), **SET, voltage=2.0)
    assert (name, int(result["doubtful"]), int(result["sign"])) == ("rest", 1, 1)


def test_what_has_not_settled_is_transient_and_flagged():
    """On the verge of the pitchfork of rest nothing settles within the time given."""
    onset = float(np.sqrt(ConeModel(**SET, voltage=0.0).stiffness(0.0)))
    result = regime(ConeModel(**SET, voltage=0.0, voltage_bias=onset), (0.3, 0.0), transient=20.0)
    assert Regime(int(result["regime"])) in (Regime.TRANSIENT, Regime.PERIODIC, Regime.REST)
    assert int(result["doubtful"]) == 1


def test_growth_away_from_unstable_rest_is_no_chaos():
    """Just above the onset a deviation grows for longer than there is patience: a positive exponent, and no chaos."""
    model = ConeModel(spring_stiffness=1.5, damping_ratio=0.05, drive_frequency=1.1, voltage=[0.6959, 0.697, 0.71])
    impatient, patient = (classify(model.members(), np.tile([3e-5, 0.0], (3, 1)), patience=p) for p in (800.0, None))
    assert [Regime(code).label for code in impatient.regime] == ["transient", "transient", "periodic"]
    assert impatient.doubtful.tolist() == [True, True, False]
    assert (impatient.sign[:2] >= 0).all()
    assert [Regime(code).label for code in patient.regime] == ["periodic"] * 3


# --- the contract -----------------------------------------------------------------------------------------------------


def test_the_dataset_is_labelled_and_comes_back_from_a_file(tmp_path):
    result = regime(ConeModel(**SET | {"voltage": [[0.3], [1.0]], "damping_ratio": [0.05, 0.1]}))
    assert result["regime"].shape == (2, 2)
    assert result["section"].shape == (2, 2, RETURNS, 2)
    assert result["regime"].attrs["flag_meanings"].split()[:2] == ["rest", "periodic"]
    for variable in result.data_vars.values():
        assert {"long_name", "units"} <= set(variable.attrs)
    save(result, tmp_path / "regime.nc")
    assert load(tmp_path / "regime.nc").equals(result)


@pytest.mark.parametrize("name", ["transient", "patience", "budget"])
@pytest.mark.parametrize("value", [0.0, -3.0, np.nan, np.inf])
def test_times_that_cannot_be_used_are_refused(name, value):
    with pytest.raises(InputError, match=f"{name} = .*: (must be positive|is longer than)"):
        regime(ConeModel(), **{name: value})


def test_a_start_outside_is_refused_when_nobody_can_start():
    with pytest.raises(InputError, match=r"stretch_limit = 0\.4: must exceed I1 - 3"):
        regime(ConeModel(stretch_limit=0.4))


# --- the labelled set -------------------------------------------------------------------------------------------------


@pytest.fixture
def classification(monkeypatch):
    path = Path(__file__).parents[2] / "benchmarks" / "classification.py"
    spec = importlib.util.spec_from_file_location("classification", path)
    benchmark = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, "classification", benchmark)
    spec.loader.exec_module(benchmark)
    return benchmark


def test_certain_cases_are_named_right_or_flagged(classification, monkeypatch, capsys):
    """The small version of ``benchmarks/classification.py``, with less patience for its labels."""
    monkeypatch.setattr(classification, "PATIENCE", (4, 8))
    monkeypatch.setattr(classification, "AVERAGE", 5_000.0)
    monkeypatch.setattr(classification, "FEWEST_BLOCKS", 60)
    monkeypatch.setattr(classification, "OPINION", 400)
    code = classification.main(12)
    printed = capsys.readouterr().out
    assert code == 0, printed
    assert "wrong without a flag: 0" in printed


@pytest.mark.parametrize("parameters", [{"voltage": 0.3}, {"voltage": 1.6, "spring_stiffness": 0.9}])
def test_progress_comes_as_it_goes_and_adds_up_to_one(parameters):
    shares = []
    regime(ConeModel(**SET | parameters), transient=200.0, patience=800.0, budget=1500.0, progress=shares.append)
    assert sum(shares) == pytest.approx(1.0)
    assert len(shares) > 1
    assert min(shares) > 0.0


# --- from the evidence to the result ----------------------------------------------------------------------------------

UNITS = {
    Regime: ("regime", "fate_regime"),
    "code": ("symmetric", "doubtful", "sign", "coexisting"),
    "count": ("period", "starts", "fate_period"),
    "length": ("lowest", "highest"),
    "rate": ("lyapunov", "standard_error"),
    "share": ("return_distance", "cycle_distance", "share_chaotic", "fate_share", "fate_share_low", "fate_share_high"),
    "state": ("section",),
    "time": ("averaged_time", "settled_time", "chaotic_until"),
}


def evidence():
    """Evidence of three members in which no two numbers are equal."""
    blank = Evidence.blank(3)
    own = {name: numbers(*values.shape, at=k + 1.0) for k, (name, values) in enumerate(vars(blank).items())}
    own |= {name: np.arange(3) == k for k, name in enumerate(("symmetric", "doubtful", "coexisting"))}
    own |= {"fate_share": 0.5 * (own["fate_share"] % 1.0), "followed": np.array([16, 12, 9])}
    return Evidence(**(own | {"outcome": np.array([0, 3, 1], dtype=np.int8), "regime": np.array([2, 5, 1])}))


def test_each_variable_holds_its_part_of_the_evidence():
    """Shares of fates are between the ends of their own interval, of as many starts as were followed."""
    own = evidence()
    found = module._findings(own, ConeModel().system)
    renamed = {"lyapunov": "exponents", "starts": "followed"}
    ends = {f"fate_share_{end}": values for end, values in
            zip(("low", "high"), wilson(own.fate_share, own.followed[:, None]), strict=True)}  # fmt: skip
    for name, (_, values, _, of) in found.variables.items():
        if not name.startswith(("validity", "film")):
            expected = ends[name] if name in ends else getattr(own, renamed.get(name, name))
            np.testing.assert_array_equal(values, expected, name)
            assert isinstance(of, dict) or name in UNITS[of]
    assert {name for names in UNITS.values() for name in names} < set(found.variables)
    assert found.outcome.tolist() == [0, 3, 1]


def test_the_search_has_the_start_and_the_budgets_of_the_call(monkeypatch):
    asked = record(monkeypatch, module, classify=evidence())
    model, shares = ConeModel(voltage=[0.5, 0.6, 0.7]), []
    options = {"transient": 11.0, "patience": 12.0, "budget": 13.0, "tolerance": 2e-9}
    found = regime(model, (0.25, 0.5), **options, threads=3, progress=shares.append)
    ((call,),) = asked.values()
    np.testing.assert_array_equal(call["states"], [[0.25, 0.5]] * 3)
    np.testing.assert_array_equal(call["members"].number("voltage"), [0.5, 0.6, 0.7])
    assert {name: call[name] for name in options} == options
    assert (call["threads"], call["progress"]) == (3, shares.append)
    assert json.loads(found.attrs["options"]) == options
    assert (found.attrs["title"], found["outcome"].values.tolist()) == ("regime of motion", [0, 3, 1])


def test_every_integration_has_the_tolerance_and_the_threads_of_the_call(integrations):
    regime(ConeModel(**SET, voltage=0.9), tolerance=2e-15, threads=2)
    assert integrations == {(2e-15, 2), (ROUGH, 2)}  # Newton's first steps are rough


def test_no_start_next_to_a_doubling_is_called_chaotic():
    """6e-8 above a doubling motions settle in 1e6 time units: 62 % of the starts were called chaotic, of none of which
    the motion is."""
    found = regime(find_preset("fast").model.replace(voltage=1.0413657), (1.000000000001, 0.0))
    assert (int(found["regime"]), int(found["period"]), float(found["share_chaotic"])) == (Regime.PERIODIC, 32, 0.0)
    assert np.isnan(found["lifetime"])
    assert Regime.CHAOTIC not in found["fate_regime"].values


def test_rest_has_no_period_with_or_without_damping():
    for damping in (0.0, 0.1):
        found = regime(ConeModel(spring_stiffness=0.5, damping_ratio=damping, voltage=0.3), (0.0, 0.0))
        assert (Regime(int(found["regime"])).label, int(found["period"])) == ("rest", 0)
