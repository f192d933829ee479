"""Made-up worlds: what each motion is, as a function of the parameters, and all studies of a claim in such a world.

Samples are drawn and stopped by the program's own studies, with the run's own sizes; the classification of motions, a
diagram and a map are taken from the world.
"""

from contextlib import contextmanager

import numpy as np
import pytest
import xarray as xr

from gelcone.codes import Outcome, Regime
from gelcone.motion.attractor.classification import Evidence
from gelcone.paper import sampling
from gelcone.paper.claims import CLAIMS
from gelcone.paper.studies import STUDIES, limits, samples
from gelcone.paper.studies.diagrams import PANELS, values_of
from gelcone.paper.studies.triples import TRIPLES
from gelcone.paper.verdicts import judge
from gelcone.presets import find_preset
from tests.paper.made_up import CHAOTIC, PERIODIC, cells, checked, diagram

LEFT = int(Regime.LEFT_THE_DOMAIN)


class World:
    """``kind`` of motion by numbers (a dict of arrays, with ``mode`` for the pre-stretch); ``finite``: whether the
    exponent over the window is positive, by default where the motion is chaotic; ``extent`` of the motion."""

    def __init__(self, kind, finite=None, extent=None):
        self._kind, self._finite, self._extent = kind, finite, extent

    def kind(self, n):
        found = np.asarray(self._kind(n))
        found = np.where(found, int(CHAOTIC), int(PERIODIC)) if found.dtype == bool else found
        return np.broadcast_to(found, n["voltage"].shape).astype(np.int8)

    def finite(self, n):
        positive = self.kind(n) == CHAOTIC if self._finite is None else self._finite(n)
        values = np.where(np.broadcast_to(positive, n["voltage"].shape), 0.1, -0.1)
        return np.where(self.kind(n) == LEFT, np.nan, values)

    def extent(self, n):
        return np.broadcast_to(6.0 if self._extent is None else self._extent(n), n["voltage"].shape)


def numbers(members):
    found = {name: np.broadcast_to(value, (members.size,)) for name, value in members.values.items()}
    return found | {"mode": getattr(members.system.film, "prestretch_mode", "radial")}


def classified(world):
    def classify(members, states, **_):
        n, found = numbers(members), Evidence.blank(members.size)
        kind = world.kind(n)
        there = kind != LEFT
        found.regime[:] = kind
        found.exponents[:, 0] = np.where(there, np.where(kind == CHAOTIC, 0.1, -0.1), np.nan)
        found.exponents[:, 1] = found.exponents[:, 0] - 1.0
        found.standard_error[:] = 0.01
        found.highest[:] = np.where(there, world.extent(n), np.nan)
        found.lowest[:] = -found.highest
        found.outcome[:] = np.where(there, Outcome.OK, Outcome.PULLED_IN)
        found.final[:] = found.highest[:, None]
        return found

    return classify


class _Swing:
    def __init__(self, states):
        self.highest, self.lowest = states[:, 0], -states[:, 0]


@contextmanager
def made_up(world):
    with pytest.MonkeyPatch.context() as patch:
        for module in (sampling, samples, limits):
            patch.setattr(module, "classify", classified(world))
        patch.setattr(limits, "swing", lambda members, final: _Swing(final))

        def finite_exponents(members, states, window, options):
            return np.stack([world.finite(numbers(members))] * 2, axis=1), None

        patch.setattr(sampling, "finite_exponents", finite_exponents)
        yield


def _cells(world, preset, over, shape=None, **changes):
    model = find_preset(preset).model.replace(**changes)
    mode = changes.get("prestretch_mode", "radial")
    grid = np.meshgrid(*over.values(), indexing="ij")
    n = {name: np.full(grid[0].shape, float(np.asarray(value))) for name, value in model.values.items()}
    n |= dict(zip(over, grid, strict=True)) | {"mode": mode}
    kind, extent = world.kind(n), world.extent(n)
    more = {"highest": extent, "lowest": -extent, "window_highest": extent, "window_lowest": -extent}
    more["late_validity_slack"] = np.zeros(extent.shape)
    exponent = np.where(kind == LEFT, np.nan, np.where(kind == CHAOTIC, 0.1, -0.1))
    sign = np.where(kind == CHAOTIC, 1, np.where(kind == LEFT, 0, -1))
    return cells(over, kind == CHAOTIC, kinds=kind, exponent=exponent, finite=world.finite(n), sign=sign, **more)


def _diagram(world, preset, parameter, effort):
    values = values_of(preset, parameter, effort)
    changes = {} if parameter == "voltage" else {"voltage": PANELS[preset, parameter]}
    own = _cells(world, preset, {parameter: values}, **changes)
    chaos = own["regime"].values == CHAOTIC
    thresholds = []
    for k in np.flatnonzero(chaos[1:] != chaos[:-1]):
        low, high = float(values[k]), float(values[k + 1])
        for _ in range(effort.bisections):
            middle = 0.5 * (low + high)
            at = _cells(world, preset, {parameter: np.array([middle])}, **changes)["regime"].values[0] == CHAOTIC
            low, high = (middle, high) if at == chaos[k] else (low, middle)
        thresholds.append(("from 1,0", low, high))
    more = {name: own[name].values for name in ("highest", "lowest")}
    exponent, finite = (own[name].values[:, 0] for name in ("lyapunov", "finite"))
    kinds = own["regime"].values
    return diagram(
        parameter, values, chaos, thresholds=thresholds, kinds=kinds, exponent=exponent, finite=finite, **more
    )


def _study(name, world, effort):
    if name in samples.SAMPLES or name in ("neighbours", "large-limits"):
        return STUDIES[name].compute(effort, lambda share: None)
    if name.startswith("diagram-"):
        _, preset, parameter = name.split("-", 2)
        return _diagram(world, preset, parameter.replace("-", "_"), effort)
    if name.startswith("map-"):
        count, stretches = effort.map_shape
        over = {"voltage": np.linspace(0.0, 2.0, count), "prestretch": np.linspace(0.4, 2.0, stretches)}
        return _cells(world, "base", over, prestretch_mode=name.removeprefix("map-"))
    if name == "limit-map":
        voltages, count = effort.limit_map
        over = {"voltage": np.linspace(0.7, 1.6, voltages), "stretch_limit": np.geomspace(0.52, 50.0, count)}
        return _cells(world, "fast", over)
    preset, parameter, values, changes = TRIPLES[name]
    return _cells(world, preset, {parameter: np.array(values)}, **changes).assign_attrs(window=effort.window)


def studies_in(world, claim, effort) -> dict[str, xr.Dataset]:
    with made_up(world):
        return {name: _study(name, world, effort) for name in CLAIMS[claim].studies}


def verdict_in(world, claim, effort):
    return judge(checked(claim, studies_in(world, claim, effort)))
