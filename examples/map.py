"""A map of the motion over voltage and pre-stretch, stopped half-way and resumed from its store."""

import json
import os

import gelcone

STORE = "map.zarr"
plan = gelcone.Plan(
    gelcone.ConeModel(damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=1.0),
    {"voltage": [0.2 + 0.1 * k for k in range(12)], "prestretch": [0.7 + 0.1 * k for k in range(10)]},
    options={"transient": 100.0, "patience": 100.0, "budget": 300.0},
)


def stop(share):
    """Raises KeyboardInterrupt, as Ctrl-C does, after the first cells."""
    raise KeyboardInterrupt


try:
    gelcone.sweep(plan, coarsest=4, store=STORE, resume=os.path.exists(STORE), progress=stop)
except KeyboardInterrupt:
    print("stopped; what is done is in", STORE)
result = gelcone.sweep(plan, coarsest=4, store=STORE, resume=True)
figure = result.gelcone.plot()

totals = json.loads(result.attrs["totals"])
still = float((result.regime == gelcone.Regime.REST).mean())
print(
    f"{totals['computed']} of {totals['cells']} cells computed, {totals['computed_before']} before; at rest {still:.0%}"
)

assert totals["computed_before"] > 0
assert abs(still - 0.6) < 0.01
