"""Writes an archive of files of version 0.2, for later versions to read.

Run once, with the sources of 0.2.0 on the path:

    PYTHONPATH=CHECKOUT/src python tests/compatibility/write_0_2.py tests/compatibility/0.2.tar.xz
"""

import sys
import tarfile
import tempfile
from pathlib import Path

import numpy as np
from write import nameless

import gelcone

BASE = {"damping_ratio": 0.05, "spring_stiffness": 0.5, "drive_frequency": 1.0}
SMALL = {"transient": 20.0, "budget": 60.0}
X = np.linspace(0.0, 1.0, 9)


def results() -> dict:
    """A small result of each analysis, by the name of its file."""
    fast = gelcone.ConeModel(voltage=0.9, **BASE)
    calm = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, damping_ratio=0.1)
    pair = gelcone.ConeModel(
        second_film="taut",
        second_drive="opposite",
        second_flat_height=1.5,
        voltage=0.2,
        voltage_bias=0.6,
        hoop_prestretch=1.4,
        damping_ratio=0.1,
    )
    pump = gelcone.find_device("biased-pump").replace(film="taut")
    return {
        "basin": gelcone.basin(fast, {"displacement": [0.1, 0.2], "velocity": [0.0, 0.1]}, **SMALL),
        "bifurcation": gelcone.bifurcation(fast, "voltage", [0.3, 0.9], bisections=0, transient=30.0, budget=60.0),
        "envelope": gelcone.envelope(pump, frequencies=[9.0, 12.0], peaks=[500.0, 900.0, 1300.0]),
        "extrema": gelcone.extrema(fast),
        "frequency": gelcone.frequency(calm, [1.0, 1.2, 1.4]),
        "limits": gelcone.limits(calm),
        "lyapunov": gelcone.lyapunov(fast, **SMALL),
        "map": gelcone.map(fast, {"voltage": [0.3, 0.9], "prestretch": [0.8, 1.0]}, **SMALL),
        "operating-limits": gelcone.operating_limits(pair),
        "regime": gelcone.regime(fast),
        "section": gelcone.section(fast, repeats=5),
        "settled": gelcone.settled(pump),
        "simulate": gelcone.simulate(pump, times=np.linspace(0.0, 0.1, 9)),
        "spectrum": gelcone.spectrum(fast),
        "static": gelcone.static(calm, [0.0, 0.5], X),
        "static-pair": gelcone.static(pair, [0.5], X),
        "sweep": gelcone.sweep(gelcone.Plan(calm, {"voltage": [0.2, 0.3]}), "settled"),
        "tongues": gelcone.tongues(fast, [0.5, 1.0, 1.5], [0.2, 0.6, 1.0]),
    }


def main(archive: Path) -> None:
    """Writes the archive."""
    with tempfile.TemporaryDirectory() as place:
        for name, result in results().items():
            gelcone.save(result, Path(place) / f"{name}.nc")
        with tarfile.open(archive, "w:xz") as packed:
            for path in sorted(Path(place).iterdir()):
                packed.add(path, path.name, filter=nameless)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
