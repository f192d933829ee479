"""Branches over the strip and curves over the map are those of the command line, in the units of the page."""

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.atlas.branches import continuation
from gelcone.devices.files import shipped_devices
from gelcone.progress import Stopped, Watch, watching
from gelcone.studio import branches
from gelcone.studio.branches import _scale, follow_branches, follow_loci
from gelcone.studio.grids import Axis, Source

PUMP = Source(shipped_devices()["biased-pump"], None, {"settings": []})
FAST = Source(None, None, {"preset": "fast", "settings": []})


@pytest.mark.slow
def test_branches_of_a_preset_have_their_events():
    found = follow_branches(FAST, Axis("voltage", "", np.linspace(0.5, 0.54, 5)))
    arrays = found["arrays"]
    kinds = [found["kinds"][k] for k in arrays["event_kind"]]
    folds = [value for value, kind in zip(arrays["event_value"], kinds, strict=True) if kind == "fold"]
    assert folds == pytest.approx([0.516574] * len(folds), abs=1e-5)
    assert folds
    assert set(arrays["stable"].tolist()) == {False, True}
    np.testing.assert_array_equal(np.isnan(arrays["value"]), np.isnan(arrays["section"]))


def test_branches_of_a_device_pass_through_its_motion():
    found = follow_branches(PUMP, Axis("frequency", "Hz", np.linspace(9.0, 10.0, 3)))["arrays"]
    device = gelcone.find_device("biased-pump")
    one = gelcone.to_si(gelcone.regime(device.to_model(), device.initial_state()), device)
    at = np.nanargmax(found["value"])
    assert found["value"][at] == 10.0
    assert found["section"][at] == pytest.approx(float(one["section"][0, 0]), rel=1e-6)
    assert found["stable"][at]


@pytest.mark.parametrize(("symmetric", "resting"), [(0, 0), (1, 0), (0, 1)])
def test_a_motion_that_is_not_its_own_mirror_image_has_one(symmetric, resting, monkeypatch):
    """Lines and events of a made-up branch over a voltage in millivolts, of which the page shows volts."""
    orbit = np.zeros((2, 8, 2))
    orbit[:, ::4, 0] = [[0.1, 0.3], [0.2, 0.4]]
    shown = xr.Dataset(
        {
            "value": (("branch", "point"), [[500.0, 700.0]], {"units": "mV"}),
            "stable": (("branch", "point"), [[1, 0]]),
            "orbit": (("branch", "point", "node", "state"), orbit[None]),
            "nodes_per_repeat": ("branch", [4]),
            "period": ("branch", [2]),
            "symmetric": ("branch", [symmetric]),
            "resting": ("branch", [resting]),
            "event_kind": ("event", [0], {"flag_values": [0], "flag_meanings": "fold"}),
            "event_value": ("event", [600.0]),
            "event_branch": ("event", [0]),
            "event_orbit": (("event", "node", "state"), orbit[:1]),
        }
    )
    monkeypatch.setattr(continuation, "continue_branch", lambda *given, **options: shown)
    monkeypatch.setattr(branches, "in_si", lambda result, subject: result)
    monkeypatch.setattr(branches, "has_mirror", lambda result: True)
    arrays = follow_branches(PUMP, Axis("voltage_amplitude", "V", np.linspace(0.5, 0.7, 3)))["arrays"]
    images = 2 if not symmetric and not resting else 1
    sections = [np.array(line) * sign for line in ([0.1, 0.2], [0.3, 0.4]) for sign in (1.0, -1.0)[:images]]
    expected = np.concatenate([np.append(line, np.nan) for line in sections])
    np.testing.assert_allclose(arrays["section"], expected)
    np.testing.assert_allclose(arrays["value"], np.tile([0.5, 0.7, np.nan], 2 * images))
    np.testing.assert_allclose(arrays["event_value"], [0.6, 0.6])
    np.testing.assert_allclose(arrays["event_section"], [0.1, 0.3])


def test_values_come_in_the_unit_of_their_axis():
    values = xr.DataArray([0.2], attrs={"units": "mm"})
    assert _scale(Axis("film_thickness", "um", np.zeros(2)), values) == pytest.approx(1e3)
    assert _scale(Axis("voltage", "", np.zeros(2)), xr.DataArray([1.0], attrs={"units": "1"})) == 1.0


def test_what_has_no_bifurcation_says_so():
    x, y = Axis("frequency", "Hz", np.linspace(9.0, 10.4, 3)), Axis("voltage_amplitude", "V", np.linspace(500, 700, 3))
    with pytest.raises(gelcone.InputError, match="none lies on"):
        follow_loci(PUMP, x, y, "fold")


@pytest.mark.slow
def test_a_curve_of_folds_passes_through_the_fold():
    x, y = Axis("voltage", "", np.linspace(0.5, 0.54, 3)), Axis("damping_ratio", "", np.linspace(0.008, 0.012, 3))
    found = follow_loci(FAST, x, y, "fold")
    own = FAST.subject().model.damping_ratio
    away = np.hypot((found["x"] - 0.516574) / 0.04, (found["y"] - own) / 0.004)
    assert np.nanmin(away) < 0.05


def test_what_is_cancelled_ends_between_two_points_of_a_branch(monkeypatch):
    watch, points = Watch(), []

    def continue_branch(*arguments, progress, **options):
        while len(points) < 5:
            progress(0.1)
            points.append(1)
            watch.stop.set()

    monkeypatch.setattr(continuation, "continue_branch", continue_branch)
    with watching(watch), pytest.raises(Stopped):
        follow_branches(FAST, Axis("voltage", "", np.linspace(0.5, 0.54, 5)))
    assert len(points) == 1


@pytest.mark.parametrize(
    "source", [PUMP, Source(None, None, {"preset": "fast", "initial": "0.25,0.5", "settings": []})]
)
def test_branches_and_curves_begin_at_the_motion_of_the_page_between_the_ends_of_its_axes(source, monkeypatch):
    """Of a device its own start, which the analyses take by themselves, and ends with units."""
    from gelcone.atlas.branches import locus as curves

    asked = []

    def ask(*given, progress, **options):
        asked.append((given, options))
        raise Stopped

    monkeypatch.setattr(continuation, "continue_branch", ask)
    monkeypatch.setattr(curves, "locus", ask)
    device = source.subject().device
    x, y = (Axis("voltage_amplitude", "kV", np.linspace(0.5, 0.7, 3)), Axis("frequency", "Hz", np.linspace(9, 11, 5)))
    if device is None:
        x, y = Axis("voltage", "", x.values), Axis("drive_frequency", "", y.values)
    ends = [("0.5 kV", "0.7 kV"), ("9 Hz", "11 Hz")] if device else [(0.5, 0.7), (9.0, 11.0)]
    start = () if device else ((0.25, 0.5),)
    with pytest.raises(Stopped):
        follow_branches(source, x)
    with pytest.raises(Stopped):
        follow_loci(source, x, y, "fold")
    ((target, *given), options), ((same, event, over, *begin), _) = asked
    assert (target, same) == (source.subject().target,) * 2
    assert given == [x.name, *ends[0], *start]
    assert (event, list(over.items()), tuple(begin)) == ("fold", list(zip((x.name, y.name), ends, strict=True)), start)
    assert options == branches.OPTIONS


def test_curves_end_in_nan_each_in_the_unit_of_its_axis(monkeypatch):
    from gelcone.atlas.branches import locus as curves

    shown = xr.Dataset(
        {
            "voltage_amplitude": (("curve", "point"), [[500.0, 600.0], [700.0, np.nan]], {"units": "V"}),
            "frequency": (("curve", "point"), [[9.0, 9.5], [10.0, np.nan]], {"units": "Hz"}),
        }
    )
    monkeypatch.setattr(curves, "locus", lambda *given, **options: shown)
    monkeypatch.setattr(branches, "in_si", lambda result, subject: result)
    axes = Axis("voltage_amplitude", "kV", np.zeros(2)), Axis("frequency", "Hz", np.zeros(2))
    found = follow_loci(PUMP, *axes, "fold")
    np.testing.assert_allclose(found["x"], [0.5, 0.6, np.nan, 0.7, np.nan, np.nan])
    np.testing.assert_allclose(found["y"], [9.0, 9.5, np.nan, 10.0, np.nan, np.nan])
