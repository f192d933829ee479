"""What does chaos look like once every forcing period? A Poincare section: a fractal in place of a few points."""

import gelcone

model = gelcone.ConeModel(damping_ratio=0.05, spring_stiffness=0.5, drive_frequency=0.3, voltage=1.9)
points = gelcone.section(model, repeats=4000)
figure = points.gelcone.plot()

extent = float(abs(points.displacement).max())
print(f"4000 points within a displacement of {extent:.2f}")

assert 2.0 < extent < 3.0
