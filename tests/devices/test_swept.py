"""Sweeps over the fields of a device, and dimensional twins: what units and scales must not change.

A swept field gives each device's own answer. Two devices of one dimensionless model are twins: their answers are
those of the model times their own scales, in every analysis.
"""

import numpy as np
import pytest
import xarray as xr

import gelcone
from gelcone.atlas.record import coordinates
from gelcone.codes import Outcome
from gelcone.devices.fields import SWEPT_FIELDS
from gelcone.devices.numbers import numbers_of
from gelcone.devices.points import device_at
from gelcone.devices.scales import MEASURES
from gelcone.devices.si import device_attributes

PUMP = gelcone.find_device("biased-pump").replace(
    film="taut", disc_radius="14 mm", gravity=9.81, payload="1 g", constant_force="1 mN", release_velocity="0.02 m/s"
)
"""A disc of 0.47 of the film's radius, with a bias, a weight and a push."""
BEAM = gelcone.find_device("beam-cone").replace(film="taut")
DOUBLE = gelcone.find_device("double-cone").replace(film="taut", second_film="taut")
OTHERS = {
    "prestretch": gelcone.find_device("soft-film").replace(film="taut"),
    "quality_factor": BEAM,
    "damping_ratio": PUMP.replace(damping_ratio=0.1),
    "release_height": PUMP.replace(release_height="10 mm"),
    "material.yeoh_c2": PUMP.replace({"material.law": "yeoh", "material.yeoh_c2": 0.01, "material.yeoh_c3": 1e-4}),
    "second_flat_height": DOUBLE,
    "second_prestretch": DOUBLE.replace(second_prestretch=1.2),
    "second_meridional_prestretch": DOUBLE.replace(second_meridional_prestretch=1.1, second_hoop_prestretch=1.3),
    "second_voltage": DOUBLE.replace(second_drive="constant", second_voltage="0.5 kV"),
}
AMPLIFIER = {"filter_frequency": 1e3, "slew_rate": 1e6, "series_resistance": 1e6, "current_limit": 5e-4}
LEAK = {"material.resistivity": 1e9, "material.resistivity_field": 1.7e7}
DELAY = {"material.dielectric_share": 0.3, "material.dielectric_time": 0.2}
OTHERS |= dict.fromkeys([*AMPLIFIER, *LEAK], PUMP.replace(AMPLIFIER | LEAK))
OTHERS |= dict.fromkeys(DELAY, PUMP.replace(DELAY))
BRANCHES = {f"material.{name}_{k}": value * k for k in (1, 2, 3) for name, value in
            {"viscous_modulus": 9e3, "relaxation_time": 0.3, "viscous_stretch_limit": 60.0}.items()}  # fmt: skip
OTHERS |= dict.fromkeys(BRANCHES, PUMP.replace(BRANCHES))
OTHERS["material.yeoh_c3"] = OTHERS["material.yeoh_c2"]
OTHERS["second_hoop_prestretch"] = OTHERS["second_meridional_prestretch"]
OTHERS |= dict.fromkeys(("beam_rate", "beam_cubic_rate", "beam_height"), BEAM)
OWN = {"material.young_modulus": 24.7e3, "material.dielectric_strength": 2e7, "material.heat_capacity": 1.5e6}
"""Values of fields that no device has set."""


def device_of(name):
    """A device that has the field, and a value of it."""
    device = OTHERS.get(name, PUMP)
    value = OWN.get(name) or device.get(name) or {"release_velocity": 0.1, "material.stretch_limit": 50.0}[name]
    return device, float(value)


def same_model(one, other, k):
    """The k-th of an ensemble is a model."""
    assert one.system == other.system
    for name, value in one.values.items():
        found = np.broadcast_to(other.values[name], other.shape).ravel()[k]
        assert float(found) == pytest.approx(float(value), rel=1e-13), name


@pytest.mark.parametrize("name", SWEPT_FIELDS)
def test_a_swept_field_gives_the_model_the_start_and_the_scales_of_each_device(name):
    device, value = device_of(name)
    values = np.sort([value, 1.02 * value])
    model, states = device_at(device, {name: values})
    plan = gelcone.Plan(device, {name: values})
    axes = {key: (f.dims, f.values, dict(f.attributes)) for key, f in coordinates(plan).items()}
    ones = {f"a {q}": (name, np.ones(2), {"units": "1", "quantity": q}) for q in MEASURES}
    shown = gelcone.to_si(xr.Dataset(ones, axes, device_attributes(device)))
    recovered = gelcone.model_of(shown)
    for k in range(2):
        one = device.replace({name: values[k]})
        same_model(one.to_model(), model, k)
        same_model(one.to_model(), recovered, k)
        np.testing.assert_allclose(states[k], one.initial_state(), rtol=1e-12)
        for quantity, measure in MEASURES.items():
            assert shown[f"a {quantity}"].attrs["units"] == measure.shown
            assert float(shown[f"a {quantity}"].isel({name: k})) == pytest.approx(
                float(one.scales.shown(quantity)), rel=1e-13
            )


@pytest.mark.parametrize("initial", [None, (0.009, 0.03)])
def test_a_swept_start_is_in_metres_whatever_else_is_swept(initial):
    """Displacement, velocity and a field that changes both scales, alone and together, with a start of their own."""
    width = {"film_radius": np.array([0.03, 0.033, 0.03])}
    start = {"displacement": np.array([0.008, 0.012, 0.01]), "velocity": np.array([-0.05, 0.05, 0.1])}
    for given in ([*start], ["displacement"], ["velocity"]):
        states = device_at(PUMP, width | {name: start[name] for name in given}, initial)[1]
        for k in range(3):
            one = PUMP.replace(film_radius=width["film_radius"][k])
            own = one.initial_state() if initial is None else None
            x = one.scales.length * own[0] if own else initial[0]
            u = one.scales.velocity * own[1] if own else initial[1]
            x, u = (
                start[name][k] if name in given else value for name, value in (("displacement", x), ("velocity", u))
            )
            np.testing.assert_allclose(states[k], [x / one.scales.length, u / one.scales.velocity], rtol=1e-12)


def test_the_ratio_of_the_radii_is_the_devices():
    for film in ("taut", "wrinkling", "membrane"):
        assert PUMP.replace(film=film).to_model().radius_ratio == pytest.approx(14 / 30, rel=1e-15)


# --- twins ------------------------------------------------------------------------------------------------------------


def twin_of(device):
    """Another device of the same model: twice as wide, thicker, heavier, of another gel."""
    gel = device.material.replace(shear_modulus=3.0 * device.material.shear_modulus, relative_permittivity=4.0)
    other = device.replace(
        disc_radius=2.0 * device.disc_radius,
        film_radius=2.0 * device.film_radius,
        film_thickness=1.7 * device.film_thickness,
        moving_mass=0.6 * device.moving_mass,
        payload=None if device.payload is None else 0.6 * device.payload,
        material=gel,
    )
    ratio = {q: other.scales.size(q) / device.scales.size(q) for q in MEASURES}
    changes = {}
    for field, quantity in numbers_of(device).values():
        if quantity != "1" and device.get(field) is not None:
            changes[field] = device.get(field) * ratio[quantity]
    more = {"release_height": "length", "release_velocity": "velocity", "dielectric_strength": "field"}
    more["filter_frequency"] = "frequency"
    changes |= {name: device.get(name) * ratio[q] for name, q in more.items() if device.get(name) is not None}
    if device.gravity is not None:
        changes["gravity"] = device.gravity * ratio["force"] / 0.6
    if device.damping_coefficient is not None:
        changes["damping_coefficient"] = device.damping_coefficient * ratio["force"] / ratio["velocity"]
    return other.replace_quietly(changes)


CALLS = {
    "simulate": lambda d: gelcone.simulate(d, periods=3),
    "settled": gelcone.settled,
    "regime": gelcone.regime,
    "static": lambda d: gelcone.static(d, [0.5 * d.scales.voltage]),
    "stroke_and_blocked_force": lambda d: gelcone.stroke_and_blocked_force(d, [0.4 * d.scales.voltage]),
    "section": lambda d: gelcone.section(d, repeats=3, discard=5),
    "extrema": lambda d: gelcone.extrema(d, repeats=3, discard=5),
    "spectrum": lambda d: gelcone.spectrum(d, discard=20),
    "lyapunov": lambda d: gelcone.lyapunov(d, budget=500.0 * d.scales.time, window=50.0 * d.scales.time),
    "frequency": lambda d: gelcone.frequency(d, np.array([1.2, 1.6]) * d.scales.frequency),
    "operating_limits": lambda d: gelcone.operating_limits(d.replace_quietly({"frequency": d.scales.frequency})),
}
OTHER_MODELS = {"operating_limits": {"drive_frequency": 1.0}}
"""Where no window of chaos is met: at the device's own frequency they are so narrow that rounding decides in which of
them chaos is met first."""
OPTIONS = {
    "simulate": {"periods": 3},
    "section": {"repeats": 3, "discard": 5},
    "extrema": {"repeats": 3, "discard": 5},
    "static": {"voltages": [0.5]},
    "stroke_and_blocked_force": {"voltages": [0.4]},
    "lyapunov": {"budget": 500.0, "window": 50.0},
    "frequency": {"frequencies": np.array([1.2, 1.6])},
    "spectrum": {"discard": 20},  # while the free motion is more than rounding
}
STATELESS = ("operating_limits", "static", "stroke_and_blocked_force", "frequency")
ROUNDING = ("energy_residual", "line_prominence", "return_distance", "aliasing_bound")
"""Variables that are differences of nearly equal numbers, or ratios to them."""


def scale_of(variable, attributes, scales):
    """What a dimensionless unit of a variable is in its unit."""
    quantity = attributes.get("quantity")
    if quantity == "parameter":
        quantity = numbers_of(PUMP)[variable].quantity
    if quantity == "state":
        return np.array([scales.shown("length"), scales.shown("velocity")])
    return scales.shown(quantity) if quantity in MEASURES else 1.0


def assert_scaled(shown, plain, scales):
    """A result in SI is a dimensionless one times the scales, in the units of `MEASURES`."""
    counted = 0
    for variable, mine in plain.variables.items():
        if mine.dtype.kind not in "iuf" or variable in ROUNDING:
            continue
        quantity, scale = mine.attrs.get("quantity"), scale_of(variable, mine.attrs, scales)
        expected = mine.values * scale
        finite = np.abs(expected[np.isfinite(expected)])
        np.testing.assert_allclose(
            shown[variable].values,
            expected,
            rtol=1e-6,
            atol=1e-7 * finite.max(initial=0.0) + 1e-12 * np.max(scale),
            err_msg=variable,
        )
        if quantity in MEASURES:
            counted += 1
            assert shown[variable].attrs["units"] == MEASURES[quantity].shown
    assert counted


@pytest.fixture(scope="module")
def plain():
    """The answers of the model, by analysis."""
    model, found = PUMP.to_model(), {}

    def answer(name):
        if name not in found:
            start = {} if name in STATELESS else {"initial": PUMP.initial_state()}
            own = model.replace(**OTHER_MODELS.get(name, {}))
            found[name] = getattr(gelcone, name)(own, **start, **OPTIONS.get(name, {}))
        return found[name]

    return answer


@pytest.mark.parametrize("name", CALLS)
@pytest.mark.parametrize("device", [PUMP, twin_of(PUMP)], ids=["device", "twin"])
def test_a_device_and_its_twin_answer_as_their_model_times_their_scales(name, device, plain):
    assert_scaled(CALLS[name](device), plain(name), device.scales)


def test_twins_have_one_model():
    for device in (PUMP, BEAM, DOUBLE, *OTHERS.values()):
        same_model(device.to_model(), twin_of(device).to_model(), 0)
    assert twin_of(PUMP).scales.time != PUMP.scales.time


def test_a_branch_of_a_device_is_that_of_its_model_times_its_scales():
    """The curvature of branches that are born and all errors too."""
    field, scales = "voltage_amplitude", PUMP.scales
    shown = gelcone.continue_branch(PUMP, field, 700.0, 800.0)
    plain = gelcone.continue_branch(
        PUMP.to_model(), "voltage", 700.0 / scales.voltage, 800.0 / scales.voltage, initial=PUMP.initial_state()
    )
    names = {"displacement", "highest", "lowest", "exponent"} & set(plain.variables) & set(shown.variables)
    assert names
    for name in names:
        scale = scale_of(name, plain[name].attrs, scales)
        np.testing.assert_allclose(shown[name].values[:, 0], plain[name].values[:, 0] * scale, rtol=1e-6)


def test_one_device_without_a_membrane_leaves_the_others_their_answers():
    """Alone it is refused, with the reason; in a sweep its outcome says so."""
    pump = gelcone.find_device("biased-pump")
    swept = gelcone.Plan(pump, {"hoop_prestretch": [pump.hoop_prestretch, 2.6]})
    for name in ("limits", "settled"):
        assert gelcone.sweep(swept, name)["outcome"].values.tolist() == [Outcome.OK, Outcome.OUTSIDE]
    assert "membrane cannot be computed" in Outcome.OUTSIDE.meaning
    for changes in ({"hoop_prestretch": 2.6}, {"hoop_prestretch": 2.6, "release_height": "5 mm"}):
        with pytest.raises(gelcone.InputError, match="is too close to the pre-stretch for the membrane"):
            gelcone.settled(pump.replace(changes))


GELS = ["PVC-DBA 6:1", "PVC-DBA 4:1"]
"""Not in the order of the alphabet, nor of their stiffness."""


def test_a_sweep_over_gels_gives_each_devices_own_answer(tmp_path):
    found = gelcone.sweep(gelcone.Plan(PUMP, {"material": GELS, "frequency": [8.0, 9.0]}), "settled")
    assert found["material"].values.tolist() == GELS
    for gel in GELS:
        own = gelcone.settled(PUMP.replace(material=gel, frequency=9.0))
        for name in ("stroke", "power", "field", "linear_stroke"):
            assert float(found[name].sel(material=gel, frequency=9.0)) == pytest.approx(float(own[name]), rel=1e-9)
    model = gelcone.model_of(found)
    assert model.shape == (2, 2)
    gelcone.save(found, tmp_path / "gels.nc")
    assert gelcone.load(tmp_path / "gels.nc").identical(found)
    figure = found.gelcone.plot()
    assert [line.get_label() for line in figure.axes[0].get_lines()] == GELS
    np.testing.assert_array_equal(figure.axes[0].get_lines()[1].get_ydata(), found["stroke"].sel(material=GELS[1]))
    points = gelcone.sweep(gelcone.Plan(PUMP, {"material": GELS}), "settled").gelcone.plot()
    assert [tick.get_text() for tick in points.axes[-1].get_xticklabels()] == GELS


@pytest.mark.parametrize(
    ("run", "message"),
    [
        (lambda: gelcone.Plan(PUMP, {"material": ["PVC-DBA 6:1"]}), "at least 2 gels, each once"),
        (lambda: gelcone.Plan(PUMP, {"material": GELS + GELS[:1]}), "at least 2 gels, each once"),
        (lambda: gelcone.Plan(PUMP, {"material": ["PVC-DBA 6:1", "PVC"]}), "'PVC' is not a material"),
        (lambda: gelcone.map(PUMP, {"material": GELS, "frequency": [8.0, 9.0]}), "gels have no order; a map takes"),
        (lambda: gelcone.bifurcation(PUMP, "material", GELS), "gels have no order; a bifurcation diagram takes"),
        (lambda: gelcone.sweep(gelcone.Plan(PUMP, {"material": GELS}), coarsest=2), "gels have no order, between"),
        (lambda: gelcone.sweep(gelcone.Plan(PUMP, {"material": GELS}), store="gels.zarr"), "keeps no sweep over gels"),
    ],
)
def test_sweeps_over_gels_say_what_they_cannot(run, message, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(gelcone.InputError, match=message):
        run()
    assert not any(tmp_path.iterdir())
