"""At which voltage does rest give way to motion? A bifurcation diagram swept up, against Floquet theory."""

import numpy as np

import gelcone

model = gelcone.ConeModel(damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.5)
diagram = gelcone.bifurcation(
    model, "voltage", np.linspace(0.4, 0.7, 7), initial=[(0.01, 0.0)], sweeps=["up"], bisections=6
)
figure = diagram.gelcone.plot()

change = next(c for c in gelcone.thresholds_of(diagram) if c["branch"] == "up")
onset = float(gelcone.onset_voltage(model).onset_voltage)
print(f"{change['from']} to {change['to']} between {change['low']:.4f} and {change['high']:.4f}; Floquet {onset:.5f}")

assert (change["from"], change["to"]) == ("rest", "periodic")
assert abs(change["low"] - onset) < 1e-3
