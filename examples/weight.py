"""How far does a payload sag, and what stroke is left? A cone under its own weight and up to 20 g more."""

import gelcone

device = gelcone.find_device("biased-pump").replace(film="taut", gravity="9.81 m/s^2")
loaded = device.replace(payload=[f"{5 * k} g" for k in range(5)])
motion = gelcone.settled(loaded.replace(voltage_amplitude="0.2 kV"))
rests = gelcone.static(loaded, ["0 V"]).rest_displacement
figure = gelcone.simulate(device.replace(payload="20 g", voltage_amplitude="0.2 kV"), periods=20).gelcone.plot()

print("rest", ", ".join(f"{value:.2f}" for value in rests.values), rests.units)
print("stroke", ", ".join(f"{value:.2f}" for value in motion.stroke.values), motion.stroke.units)

assert (rests.values[:-1] > rests.values[1:]).all()
