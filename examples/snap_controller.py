"""Can a controller hold a disc that snaps? A PI controller with damping around the cone between two wells."""

import numpy as np
from matplotlib.figure import Figure

import gelcone

device = gelcone.find_device("snap-cone").replace(film="taut")
run = gelcone.simulate(device, periods=30)
print(f"under its own drive the disc moves between {float(run.displacement[100:].min()):.1f} and "
      f"{float(run.displacement[100:].max()):.1f} mm")  # fmt: skip

# the same device, moved on by half a millisecond at a time; an action of -1 to 1 is the squared voltage
cone = gelcone.environment(device, highest_voltage="1.8 kV", heights=("6 mm", "10 mm"), period="0.5 ms", episode="2 s")
cone.reset(seed=0)
plant, integral, heights = cone.episodes, 0.0, []
before = plant.displacement[0]
for k in range(4000):
    wanted = 6.5e-3 if k < 2000 else 7.5e-3
    height = plant.displacement[0]
    error, speed, before = wanted - height, (height - before) / 0.5e-3, height
    integral = np.clip(integral + 0.5e-3 * 5e3 * error, 0.0, 1.0)
    share = np.clip(integral + 20.0 * error - 2.0 * speed, 0.0, 1.0)
    _, _, terminated, _, info = cone.step(np.array([2.0 * share - 1.0]))
    assert not terminated, info
    heights.append(1e3 * plant.displacement[0])
figure = Figure(figsize=(7.0, 3.0))
figure.subplots().plot(heights)

print(f"held at {heights[1999]:.4f} mm of 6.5 and {heights[-1]:.4f} mm of 7.5, with {plant.voltage[0]:.0f} V")
assert abs(heights[1999] - 6.5) < 2e-3
assert abs(heights[-1] - 7.5) < 2e-3
