"""Does chaos last? Nearby starts at a voltage where it ends by itself, and the mean lifetime that they show."""

import gelcone

model = gelcone.ConeModel(damping_ratio=0.05, spring_stiffness=1.5, drive_frequency=1.0, voltage=3.0)
found = gelcone.regime(model, patience=20000.0, budget=2000.0)
figure = found.gelcone.plot()

low, high = float(found.lifetime_low), float(found.lifetime_high)
print(f"{gelcone.Regime(int(found.regime)).label}; mean lifetime between {low:.2g} and {high:.2g} time units")

assert low > 1000.0
