"""Tests on devices, and fits of them, by another program: ``tests/reference/lab.json``."""

import json
from pathlib import Path

import numpy as np

import gelcone
from gelcone.lab.bench import KINDS, DeviceTest
from gelcone.lab.device_fit import Problem

CERTIFIED = json.loads((Path(__file__).parents[1] / "reference" / "lab.json").read_text(encoding="utf-8"))
UNITS = {
    "height": "m", "voltage": "V", "voltage_offset": "V", "voltage_amplitude": "V", "frequency": "Hz", "force": "N",
    "stroke": "m", "in_phase": "m", "quadrature": "m", "decay": "per_s",
}  # fmt: skip
FIELDS = {
    "mu": "material.shear_modulus", "J": "material.stretch_limit", "lm": "meridional_prestretch",
    "lh": "hoop_prestretch", "H": "film_thickness", "eps": "material.relative_permittivity", "k": "spring_rate",
    "h0": "initial_height", "m": "moving_mass", "c": "damping_coefficient",
}  # fmt: skip
GAINS = {"load": "load cell", "laser": "laser", "hv": "amplifier"}
TAUT, WRINKLING = "A1 (taut data)", "B1 (wrinkling data)"


def device(fields, film):
    return gelcone.find_device("biased-pump").replace(dict(fields), film=film)


def made(test, noise=None):
    kind = KINDS[test["test"]]

    def row(source, name):
        return np.atleast_1d(np.asarray(source[f"{name}_{UNITS[name]}"], dtype=float))

    return DeviceTest(
        test["test"],
        test["test"],
        {name: row(test, name) for name in kind.set},
        {name: row(test, name) for name in kind.read},
        {name: row(noise or test, name) for name in kind.read},
    )


def problem(case, film, gains=True):
    own = CERTIFIED["device_fits"][case]
    tests = tuple(made(test, noise) for test, noise in zip(own["data"], own["noise_sd"], strict=True))
    free = {FIELDS[name]: spread for name, spread in own["priors_relative_sd"].items()}
    spreads = {GAINS[name]: spread if gains else 1e-9 for name, spread in own["gain_sd"].items()}
    return Problem(device(own["nominal"], film), free, tests, spreads)
