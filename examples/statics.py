"""Where may the disc rest, and at which voltage does the film pull in? Equilibria over the voltage."""

import gelcone

device = gelcone.find_device("biased-pump").replace(film="wrinkling")
rests = gelcone.static(device, [f"{100 * k} V" for k in range(21)])
figure = rests.gelcone.plot()

voltage = float(rests.pull_in_voltage)
print(
    f"the film pulls in at {voltage:.1f} V; without a voltage the disc rests at {float(rests.rest_displacement):.2f} mm"
)

assert abs(float(rests.rest_displacement) - 12.6) < 0.1
