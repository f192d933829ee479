"""One question, where the model holds, has one answer: limits lie where the flags of `static` change."""

import numpy as np
import pytest

import gelcone
from gelcone.motion.envelope import plane_of
from gelcone.motion.static_limits import STATIC_LIMITS, static_limits_of

pytestmark = pytest.mark.slow

FLAGS = {
    "dielectric breakdown": ("breakdown",),
    "hoop slack": ("hoop_slack",),
    "meridional slack": ("meridional_slack",),
    "stretch limit": ("near_limit",),
    "pull-in": ("beyond_membrane", "pulled_in"),
}
LAWS = {"gent": ("stretch_limit",), "neo-hookean": (), "yeoh": ("yeoh_c2", "yeoh_c3")}
LARGEST = {"stretch_limit": 60.0, "yeoh_c2": 0.05, "yeoh_c3": 0.004}
DEVICES = 2


def models(film, law):
    """Random cones, lifted and driven; those of a law have one membrane."""
    own = np.random.default_rng(sorted(LAWS).index(law))
    film_numbers = {"hoop_prestretch": own.uniform(1.2, 1.6), "meridional_prestretch": own.uniform(1.05, 1.3)}
    film_numbers |= {name: LARGEST[name] * own.uniform(0.3, 1.0) for name in LAWS[law]}
    for _ in range(DEVICES):
        rest = {"rest_height": own.uniform(0.2, 1.0), "spring_stiffness": own.uniform(0.3, 2.0)}
        rest |= {"dielectric_strength": own.uniform(0.4, 2.0), "voltage": 0.1, "damping_ratio": 0.1}
        yield gelcone.ConeModel(film=film, law=law, radius_ratio=0.25, **film_numbers, **rest)


def fails(model, voltages):
    """Flags by limit, where a slow ramp is at voltages; all of pull-in where it has ended."""
    found = gelcone.static(model, voltages)
    reached = (found["rest_displacement"] + found["stroke"]).values
    flags = {name: [] for name in FLAGS}
    for k, x in enumerate(reached):
        places = found["equilibrium_displacement"].values[k]
        at = int(np.nanargmin(np.abs(places - x))) if np.isfinite(x) else None
        for name, of in FLAGS.items():
            ended = at is None and name == "pull-in"
            flags[name].append(
                ended or any(at is not None and found[f"validity_{one}"].values[k, at] > 0 for one in of)
            )
    return flags


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("film", ["taut", "wrinkling", "membrane"])
def test_a_limit_at_constant_voltage_lies_where_static_changes_its_flag(film, law):
    for model in models(film, law):
        limits = dict(zip(STATIC_LIMITS, static_limits_of(plane_of(model, 1)), strict=True))
        assert np.isfinite(min(limits[name] for name in FLAGS)), model
        for name in FLAGS:
            if np.isfinite(limits[name]):
                near = fails(model, [0.999 * limits[name], 1.001 * limits[name]])
                assert near[name] == [False, True], (name, limits[name], model)
        lowest = min(limits[name] for name in FLAGS)
        below = fails(model, lowest * np.linspace(0.0, 0.999, 20))
        assert not any(any(own) for own in below.values()), model


CONES = {
    "a taut pump": ("biased-pump", {"film": "taut"}),
    "a strong taut pump": (
        "biased-pump", {"film": "taut", "hoop_prestretch": 1.6, "meridional_prestretch": 1.3, "voltage_offset": "0 V"},
    ),
    "a wrinkling pump": ("biased-pump", {"film": "wrinkling"}),
    "two taut films": ("double-cone", {"film": "taut", "second_film": "taut"}),
}  # fmt: skip


@pytest.mark.parametrize("name", CONES)
def test_below_the_safe_peak_every_assumption_holds_in_a_run_and_at_rest(name):
    """Also where the membrane pulls in for which the cone stands."""
    shipped, changes = CONES[name]
    device = gelcone.find_device(shipped).replace(changes)
    limits = gelcone.operating_limits(device)
    assert limits.attrs["pull_in_of"] == "membrane"
    safe = float(limits["safe_peak_voltage"])
    assert 100.0 < safe < 1e5
    share = 0.999 * safe / (device.voltage_amplitude + abs(device.voltage_offset))
    driven = device.replace(
        voltage_amplitude=share * device.voltage_amplitude, voltage_offset=share * device.voltage_offset
    )
    run = gelcone.simulate(driven, periods=60.0)
    flags = [str(one) for one in run.data_vars if str(one).startswith("validity_") and str(one) != "validity_error"]
    assert len(flags) == 6
    assert all(not float(run[one]) > 0.0 for one in flags), {one: float(run[one]) for one in flags}
    if device.second_drive != "opposite":  # whose offset rises with the drive
        near = gelcone.static(device, [0.999 * safe])
        x = float((near["rest_displacement"] + near["stroke"]).item())
        at = int(np.nanargmin(np.abs(near["equilibrium_displacement"].values[0] - x)))
        assert all(not float(near[one][0, at]) > 0.0 for one in flags)
