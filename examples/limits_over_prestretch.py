"""Does pre-stretch help? Voltages at which rest becomes unstable and at which the film pulls in, over pre-stretch."""

import numpy as np

import gelcone

model = gelcone.ConeModel(film="wrinkling", spring_stiffness=0.9, drive_frequency=0.5)
plan = gelcone.Plan(model, {"hoop_prestretch": np.linspace(1.0, 2.0, 21)})
found = gelcone.sweep(plan, "limits")
figure = found.gelcone.plot()

low, high = found.pull_in_voltage.values[[0, -1]]
print(f"pull-in at {low:.4f} without pre-stretch, at {high:.4f} with a hoop stretched by 2")

assert abs(low - 0.691) < 1e-3
assert high > low
