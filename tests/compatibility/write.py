"""Writes an archive of files that one version of gelcone made, for later versions to read or refuse.

Run once by each version that is released, for 0.1 with the sources of 0.1.0 on the path:

    PYTHONPATH=CHECKOUT/src python tests/compatibility/write.py tests/compatibility/0.1.tar.xz
"""

import sys
import tarfile
import tempfile
from pathlib import Path

import numpy as np

import gelcone

BASE = {"damping_ratio": 0.05, "spring_stiffness": 0.5, "drive_frequency": 0.3}
SMALL = {"transient": 20.0, "budget": 60.0}


class Enough(Exception):
    """Ends a survey after its first cells."""


def results(film: Path) -> dict:
    """A small result of each kind, by the name of its file."""
    model, fast = (
        gelcone.ConeModel(voltage=1.04, **BASE),
        gelcone.ConeModel(voltage=0.9, **BASE | {"drive_frequency": 1.0}),
    )
    yeoh = gelcone.ConeModel(law="yeoh", law_parameters={"yeoh_c2": 0.02, "yeoh_c3": 0.001}, **BASE)
    pump = gelcone.find_device("biased-pump")
    times = np.linspace(0.0, 4.0, 5)
    moved = gelcone.simulate(pump.to_model(), pump.initial_state(), times=times)
    diagram = {"transient": 30.0, "budget": 60.0}
    return {
        "simulate": gelcone.simulate(model, (1.0, 0.0), times=times),
        "simulate-ensemble": gelcone.simulate(model.replace(voltage=[0.5, 1.5]), times=times),
        "simulate-device": gelcone.to_si(moved, pump),
        "simulate-yeoh": gelcone.simulate(yeoh, times=times),
        "simulate-film": gelcone.simulate(model.replace(voltage=0.5, film=gelcone.read_film(film)), times=times),
        "section": gelcone.section(fast, repeats=5, discard=3),
        "lyapunov": gelcone.lyapunov(fast, **SMALL),
        "regime": gelcone.regime(fast.replace(voltage=[0.2, 0.9]), **SMALL),
        "map": gelcone.parameter_map(fast, {"voltage": [0.3, 0.9], "prestretch": [0.8, 1.0, 1.2]}, **SMALL),
        "bifurcation": gelcone.bifurcation(fast, "voltage", [0.3, 0.9], bisections=0, **diagram),
        "static": gelcone.static(gelcone.ConeModel(rest_height=0.3), [0.0, 0.5]),
    }


def stores(folder: Path) -> None:
    """A finished map and an interrupted one."""
    plan = gelcone.Plan(
        gelcone.ConeModel(**BASE | {"drive_frequency": 1.0}),
        {"voltage": [0.2, 0.4, 0.6, 0.8], "prestretch": [0.8, 0.9, 1.0, 1.1, 1.2]},
        rounds=1,
        **SMALL,
    )
    gelcone.survey(plan, coarsest=2, store=folder / "map.zarr")

    def stop(tally):
        if tally.computed:
            raise Enough

    try:
        gelcone.survey(plan, coarsest=2, store=folder / "interrupted.zarr", progress=stop, workers=gelcone.threads(1))
    except Enough:
        return
    raise SystemExit("the second survey was not interrupted")


def main(archive: Path) -> None:
    """Writes the archive."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        gelcone.write_film(gelcone.fit_film(gelcone.ConeModel(**BASE), 0.2), folder / "film.json")
        for name, result in results(folder / "film.json").items():
            gelcone.save(result, folder / f"{name}.nc")
        stores(folder)
        with tarfile.open(archive, "w:xz") as packed:
            for path in sorted(folder.iterdir()):
                packed.add(path, path.name, filter=nameless)


def nameless(entry: tarfile.TarInfo) -> tarfile.TarInfo:
    """An entry without its owner."""
    entry.uname = entry.gname = ""
    entry.uid = entry.gid = 0
    return entry


if __name__ == "__main__":
    main(Path(sys.argv[1]))
