"""Does the shape of the drive matter? A triangle against a sine of the same peak."""

import gelcone

model = gelcone.ConeModel(voltage=0.3, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, drive_frequency=0.7)
strokes = {}
for shape in ("sine", "triangle"):
    run = gelcone.simulate(model.replace(waveform=shape), periods=30)
    strokes[shape] = float(gelcone.settled(model.replace(waveform=shape)).stroke)
figure = run.gelcone.plot()

print(f"stroke {strokes['sine']:.4f} under a sine, {strokes['triangle']:.4f} under a triangle")

assert 0.7 < strokes["triangle"] / strokes["sine"] < 0.95  # the first harmonic of a triangle is 8/pi^2 = 0.81
