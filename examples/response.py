"""How does a pump answer 9 Hz? Height, film, energies and voltage over time, from rest to the settled stroke."""

import gelcone

device = gelcone.find_device("biased-pump").replace(film="taut", frequency="9 Hz")
response = gelcone.simulate(device, periods=20)
figure = response.gelcone.plot()

residual = float(abs(response.energy_residual).max())
supplied = float(abs(response.supplied_energy).max())
print(f"energy balance closed to {residual / supplied:.0e} of the energy supplied")

assert residual < 1e-9 * supplied
