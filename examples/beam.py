"""What does a buckled beam gain? The stroke of a cone on a beam, against that of the same cone without."""

import gelcone

device = gelcone.find_device("beam-cone").replace(film="taut")
plain = device.replace(beam_rate="-0.001 N/m", beam_cubic_rate="0 N/m^3")
found = gelcone.static(device, [f"{100 * k} V" for k in range(11)])
without = gelcone.static(plain, ["1 kV"])
figure = found.gelcone.plot()

gain = float(found.stroke[-1]) / float(without.stroke[0])
print(f"stroke at 1 kV {float(found.stroke[-1]):.2f} {found.stroke.units}, {gain:.1f} times that without the beam")

assert gain > 2.0
