"""What does the film do from disc to rim? Shape, thickness, field and wrinkles of the membrane at three voltages."""

import gelcone

device = gelcone.find_device("biased-pump")
rings = gelcone.film(device, ["13 mm"], ["0 V", "0.7 kV", "1.1 kV"])
figure = rings.gelcone.plot()

force = rings.force.values.ravel()
print("force of the film:", ", ".join(f"{value:.4f} {rings.force.units}" for value in force))

assert force[0] > force[1] > force[2] > 0.0
