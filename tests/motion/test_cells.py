"""Per-cell functions: a sweep and a single call give the same numbers, and one bad member does not stop the rest."""

import numpy as np
import pytest

import gelcone
from gelcone.codes import Outcome
from gelcone.errors import InputError
from gelcone.motion.limits import limits, limits_cells
from gelcone.motion.lyapunov import lyapunov, lyapunov_cells
from gelcone.motion.operating_limits import operating_limits, operating_limits_cells
from gelcone.motion.regime import regime, regime_cells
from gelcone.motion.section import section, section_cells
from gelcone.motion.settled import settled, settled_cells
from gelcone.motion.spectrum import spectrum, spectrum_cells
from gelcone.motion.start import start_states
from gelcone.physics.balance import PullIn
from gelcone.physics.model import ConeModel

MODEL = ConeModel(
    damping_ratio=0.1,
    spring_stiffness=0.5,
    drive_frequency=0.3,
    voltage=[0.3, 1.0, 0.8],
    stretch_limit=[50.0, 50.0, 0.03],
)
"""The last member starts outside its stretch limit."""
START = (0.5, 0.0)
ANALYSES = {
    "regime": (regime, regime_cells, {"transient": 200.0, "budget": 1500.0, "patience": 600.0}),
    "section": (section, section_cells, {"repeats": 5, "discard": 3, "phase": 0.25}),
    "lyapunov": (lyapunov, lyapunov_cells, {"window": 40.0, "transient": 200.0, "budget": 1500.0}),
    "spectrum": (spectrum, spectrum_cells, {"periods": 16, "discard": 5, "highest": 4.0}),
    "settled": (settled, settled_cells, {}),
}
each = pytest.mark.parametrize("name", ANALYSES)


@each
def test_a_call_and_its_cells_give_the_same_to_the_last_bit(name):
    public, cells, options = ANALYSES[name]
    result = public(MODEL, START, **options)
    found = cells(MODEL.members(), start_states(MODEL, START), **options)
    assert set(found.variables) <= set(result.data_vars)
    for variable, (_, values, _, _) in found.variables.items():
        own = result[variable].values
        np.testing.assert_array_equal(values[tuple(slice(n) for n in own.shape)], own, variable)
    assert result["outcome"].values.tolist() == found.outcome.tolist() == [Outcome.OK, Outcome.OK, Outcome.OUTSIDE]


@each
def test_cells_that_cannot_start_carry_their_outcome(name):
    """A call with nobody inside is refused; cells of a sweep are not."""
    public, cells, options = ANALYSES[name]
    outside = MODEL.members().take([2])
    assert cells(outside, np.array([START]), **options).outcome.tolist() == [Outcome.OUTSIDE]
    with pytest.raises(InputError, match=r"stretch_limit = 0\.03: must exceed"):
        public(MODEL.replace(stretch_limit=0.03), START, **options)


@each
def test_progress_of_a_call_adds_up_to_one(name):
    public, _, options = ANALYSES[name]
    shares = []
    public(MODEL, START, **options, progress=shares.append)
    assert sum(shares) == pytest.approx(1.0)
    assert len(shares) > 1
    assert min(shares) >= 0.0


def test_spectra_of_cells_have_one_shape_whatever_the_members():
    first, second = (
        spectrum_cells(MODEL.members().take(rows), np.tile(START, (len(rows), 1)), periods=16, discard=0, highest=3.0)
        for rows in ([0], [1, 2])
    )
    for name, (dims, values, _, _) in first.variables.items():
        assert values.shape[1:] == second.variables[name][1].shape[1:], name
        assert len(dims) == values.ndim - 1


# --- limits -----------------------------------------------------------------------------------------------------------


def test_limits_are_those_of_each_analysis_alone():
    model = ConeModel(
        spring_stiffness=0.5, hoop_prestretch=1.3, stretch_limit=[8.0, 0.01, 8.0], rest_height=[0.0, 0.0, 0.1]
    )
    result = limits(model)
    assert result["outcome"].values.tolist() == [Outcome.OK, Outcome.OUTSIDE, Outcome.OK]
    onset = gelcone.onset_voltage(model.take([0]))
    assert float(result["onset_voltage"][0]) == float(onset["onset_voltage"][0])
    assert float(result["onset_error"][0]) == float(onset["onset_error"][0]) > 0.0
    assert float(result["pitchfork_voltage"][0]) == float(
        gelcone.pitchfork_voltage(model.take([0])).pitchfork_voltage[0]
    )
    # A film that is lifted at rest has no onset from flat rest, but still pulls in.
    assert np.isnan(result["onset_voltage"].values[1:]).all()
    pull_in = gelcone.pull_in_voltage(model.take([2]))["pull_in_voltage"]
    assert float(result["pull_in_voltage"][2]) == float(pull_in[0])
    assert result["pull_in_kind"].attrs["flag_meanings"].split()[int(result["pull_in_kind"][2])] == "never"
    found = limits_cells(model.members(), np.zeros((3, 2)))
    for name, (_, values, _, _) in found.variables.items():
        np.testing.assert_array_equal(values, result[name].values, name)


def test_limits_report_their_progress():
    shares = []
    limits(ConeModel(spring_stiffness=0.5), progress=shares.append)
    assert sum(shares) == pytest.approx(1.0)
    with pytest.raises(InputError, match="stretch_limit"):
        limits(ConeModel(stretch_limit=0.01, hoop_prestretch=1.3))


# --- the settled motion -----------------------------------------------------------------------------------------------


def test_the_settled_motion_is_that_of_a_long_run():
    model = ConeModel(damping_ratio=0.1, spring_stiffness=1.0, voltage=0.8, rest_height=0.3)
    result = settled(model)
    late = gelcone.simulate(model, times=np.linspace(400.0, 400.0 + 2.0 * np.pi, 2001))["displacement"].values
    assert float(result["highest"]) == pytest.approx(late.max(), abs=1e-6)
    assert float(result["lowest"]) == pytest.approx(late.min(), abs=1e-6)
    assert float(result["stroke"]) == pytest.approx(np.ptp(late), abs=2e-6)
    assert int(result["period"]) == 1
    assert result["harmonic"].values.tolist() == [1, 2, 3, 4]
    # The force of a pure sine has twice its frequency.
    assert float(result["harmonic_amplitude"].sel(harmonic=2)) > 1e3 * float(
        result["harmonic_amplitude"].sel(harmonic=1)
    )


def test_a_tiny_drive_has_the_stroke_of_linear_theory():
    result = settled(ConeModel(voltage=[0.02, 0.01], rest_height=0.8, damping_ratio=0.1), (0.8, 0.0))
    np.testing.assert_allclose(result["stroke"], result["linear_stroke"], rtol=1e-3)
    assert float(result["linear_stroke"][0] / result["linear_stroke"][1]) == pytest.approx(4.0, rel=1e-3)


def test_rest_has_no_period():
    """Neither an undriven disc nor one below its onset moves; as in `regime` the period is 0."""
    model = ConeModel(voltage=[0.0, 0.1], damping_ratio=0.2)
    result = settled(model)
    assert result["period"].values.tolist() == regime(model)["period"].values.tolist() == [0, 0]
    assert result["resting"].values.tolist() == [1, 1]
    assert float(result["stroke"].max()) < 1e-6


@pytest.mark.parametrize("name", ["transient", "patience"])
def test_times_that_cannot_be_used_are_refused(name):
    with pytest.raises(InputError, match=f"{name} = -1: must be positive"):
        settled(ConeModel(damping_ratio=0.1), **{name: -1.0})


def test_without_damping_no_motion_settles():
    result = settled(ConeModel(damping_ratio=[0.0, 0.2], voltage=0.1))
    assert result["outcome"].values.tolist() == [Outcome.ERROR, Outcome.OK]
    assert np.isnan(result["stroke"].values[0])
    with pytest.raises(InputError, match="damping_ratio = 0"):
        settled(ConeModel(damping_ratio=0.0))


def test_a_pitchfork_from_which_the_disc_rises_gradually_is_no_pull_in():
    """Before it nothing is lost, and behind it a film without limit has a fold; with a second film, too."""
    model = ConeModel(spring_stiffness=0.5, stretch_limit=[8.0, 1e6])
    result = limits(model)
    same = gelcone.pull_in_voltage(model)
    for name in ("pull_in_voltage", "pull_in_kind"):
        np.testing.assert_array_equal(same[name], result[name])
    assert (result["pitchfork_voltage"].values < 1.3).all()
    assert result["pull_in_kind"].values[0] == PullIn.NEVER
    assert np.isposinf(result["pull_in_voltage"].values[0])
    double = limits(ConeModel(spring_stiffness=0.5, stretch_limit=8.0, second_film="taut"))
    assert (float(double["pull_in_voltage"]), int(double["pull_in_kind"])) == (np.inf, PullIn.NEVER)
    assert float(double["pitchfork_voltage"]) < 1.3


# --- operating limits -------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def operating():
    model = ConeModel(
        damping_ratio=0.3,
        voltage=[0.3, 0.0, 0.3],
        voltage_bias=[0.3, 0.0, 0.3],
        drive_frequency=0.5,
        stretch_limit=[50.0, 50.0, 0.01],
        meridional_prestretch=1.2,
        hoop_prestretch=1.5,
    )
    return model, operating_limits(model.replace(dielectric_strength=1.2))


def test_operating_limits_are_those_of_the_envelope(operating):
    model, result = operating
    plane = gelcone.envelope(model.take(0).replace(dielectric_strength=1.2), frequencies=[0.5, 0.9])
    static = dict(zip(plane["static_limit"].values, plane["static_limit_voltage"].values, strict=True))
    assert float(result["pull_in_voltage"][0]) == static["pull-in"]
    assert float(result["hoop_slack_voltage"][0]) == static["hoop slack"]
    for name, low in zip(plane["driven_limit"].values, plane["limit_low"].values[:, 0], strict=True):
        column = name.replace(" ", "_").replace("-", "_")
        assert float(result[f"driven_{column}_voltage"][0]) == pytest.approx(low, nan_ok=True)
    lowest = np.nanmin([*plane["limit_low"].values[:, 0], *static.values()])
    assert float(result["safe_peak_voltage"][0]) == pytest.approx(min(lowest, 1.2))


def test_operating_limits_of_a_wrinkling_cone_have_the_pull_in_of_the_membrane():
    model = ConeModel(film="wrinkling", voltage=0.5, voltage_bias=0.5, rest_height=0.9, damping_ratio=0.3)
    found = operating_limits(model)
    plane = gelcone.envelope(model, frequencies=[1.0, 1.1])
    assert plane.pull_in_of == "membrane"
    membrane, cone = float(found.membrane_pull_in_voltage), float(found.pull_in_voltage)
    assert membrane == float(plane.static_limit_voltage.sel(static_limit="pull-in"))
    assert float(found.driven_pull_in_voltage) == float(plane.limit_low.sel(driven_limit="pull-in")[0])
    assert membrane < 0.95 * cone
    assert cone == float(gelcone.limits(model).pull_in_voltage) == float(gelcone.static(model).pull_in_voltage)
    assert found.pull_in_of == gelcone.datasheet(model, [0.1]).pull_in_of == "membrane"
    assert found.membrane_pull_in_voltage.long_name.endswith("pull-in of the membrane")
    assert found.pull_in_voltage.long_name.endswith("pull-in of the cone")
    assert found.driven_pull_in_voltage.long_name.endswith("pull-in of the membrane")
    sheet = gelcone.datasheet(model, [0.1])
    assert (float(sheet.membrane_pull_in_voltage), float(sheet.pull_in_voltage)) == (membrane, cone)
    assert gelcone.PullIn(int(sheet.pull_in_kind)) == gelcone.PullIn.FILM
    still = gelcone.datasheet(model.replace(voltage=0.0, voltage_bias=0.0), [0.1])
    assert (float(still.membrane_pull_in_voltage), float(still.pull_in_voltage)) == (membrane, cone)
    said = gelcone.in_words(sheet)
    assert f"pull-in of the membrane under constant voltage: {membrane:.4g}\n" in said
    assert f"pull-in of the cone under constant voltage: {cone:.4g}\n" in said
    taut = operating_limits(model.replace(film="taut"))
    assert (taut.pull_in_of, taut.hoop_slack_voltage.long_name[-10:]) == ("cone", "hoop slack")


def test_operating_limits_of_members_without_voltage_or_inside(operating):
    model, result = operating
    assert result["outcome"].values.tolist() == [Outcome.OK, Outcome.ERROR, Outcome.OUTSIDE]
    assert np.isnan(result["safe_peak_voltage"].values[1:]).all()
    found = operating_limits_cells(model.replace(dielectric_strength=1.2).members(), np.zeros((3, 2)), threads=1)
    for name, (_, values, _, _) in found.variables.items():
        np.testing.assert_array_equal(values, result[name].values, name)


def test_operating_limits_say_why_every_member_is_refused():
    """The first of them has a voltage, and a radius that no membrane has."""
    model = ConeModel(film="wrinkling", voltage=[0.5, 0.0], rest_height=0.9, radius_ratio=1.5)
    with pytest.raises(InputError, match=r"radius_ratio = 1\.5: must lie between 0 and 1"):
        operating_limits(model)
    some = ConeModel(voltage=[0.0, 0.5], rest_height=0.9)
    assert operating_limits(some)["outcome"].values.tolist() == [Outcome.ERROR, Outcome.OK]


def test_operating_limits_need_a_voltage():
    with pytest.raises(InputError, match="amplitude or a bias"):
        operating_limits(ConeModel(voltage=0.0))


def test_the_mirror_image_of_a_model_has_mirrored_answers():
    """The spring free below the film's plane instead of above, and the disc started there."""
    model = ConeModel(
        damping_ratio=[0.1, 0.15], spring_stiffness=0.5, drive_frequency=0.6, voltage=0.3, voltage_bias=0.4,
        rest_height=0.5, dielectric_strength=0.8,
    )  # fmt: skip
    image = model.replace(rest_height=-0.5)
    answers = {
        regime: {"transient": 60.0, "patience": 120.0, "budget": 100.0},
        settled: {},
        limits: {},
    }
    for analysis, options in answers.items():
        own, other = (
            analysis(one, *() if analysis is limits else (start,), **options)
            for one, start in ((model, (0.4, 0.1)), (image, (-0.4, -0.1)))
        )
        for name in own.data_vars:
            if name == "initial" or own[name].dtype.kind not in "fiub":
                continue
            expected = other[{"lowest": "highest", "highest": "lowest"}.get(name, name)].values
            if own[name].attrs.get("quantity") == "state" or name in ("lowest", "highest", "mean"):
                expected = -expected
            if name == "harmonic_phase":
                off = (own[name].values - expected) % 360.0
                np.testing.assert_allclose(off[np.isfinite(off)], 180.0, atol=1e-6)
            else:
                np.testing.assert_allclose(own[name].values, expected, atol=1e-9, err_msg=str(name))
