"""Devices with a film that can be inverted."""

from __future__ import annotations

import gelcone

FILMS = {
    "taut": {"film": "taut"},
    "wrinkling": {"film": "wrinkling", "meridional_prestretch": 1.0, "hoop_prestretch": 1.05, "voltage_offset": 800.0},
}


def device(kind="taut"):
    return gelcone.find_device("biased-pump").replace(FILMS[kind])
