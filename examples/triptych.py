"""Three voltages side by side: over time, in the phase plane and as a section, each with its kind of motion."""

import gelcone

model = gelcone.ConeModel(damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.3, voltage=[0.4, 0.9, 1.9])
found = gelcone.triptych(model, budget=1000.0)
figure = found.gelcone.plot()

kinds = [gelcone.Regime(code).label for code in found.regime.values]
print(", ".join(kinds))

assert kinds == ["rest", "periodic", "chaotic"]
