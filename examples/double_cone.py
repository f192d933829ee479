"""Does an antagonist remove the second harmonic? A double cone in opposite phase, against one film driven alone."""

import gelcone

# two homogeneous cones that wrinkle: in a second; two membranes, its default, take ten
device = gelcone.find_device("double-cone").replace(film="wrinkling", second_film="wrinkling")
device = device.replace(frequency="6 Hz", voltage_amplitude="450 V")
alone = device.replace(second_drive="constant", second_voltage="1.13 kV")

shares, strokes = {}, {}
for name, own in (("opposite", device), ("alone", alone)):
    motion = gelcone.to_si(gelcone.settled(own.to_model(), own.initial_state()), own)
    first, second = motion.harmonic_amplitude[:2].values
    shares[name], strokes[name] = second / first, float(motion.stroke)
    print(f"{name:9s} stroke {motion.stroke:.2f} {motion.stroke.units}, second harmonic {100 * shares[name]:.2g} %")
figure = gelcone.simulate(device, periods=20).gelcone.plot()

assert shares["opposite"] < 1e-9
assert shares["alone"] > 0.2
assert abs(strokes["opposite"] - 3.06) < 0.02
