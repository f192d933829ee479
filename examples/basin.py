"""Which of two motions does a start end on? The basins of a beam that snaps between two wells."""

import numpy as np

import gelcone

model = gelcone.ConeModel(bias="beam", beam_stiffness=-1.6, damping_ratio=0.1, voltage=0.3, voltage_bias=0.3)
grid = {"displacement": np.linspace(-1.2, 1.2, 25), "velocity": np.linspace(-1.0, 1.0, 21)}
found = gelcone.basin(model, grid)
figure = found.gelcone.plot()

shares = found.attractor_share.values
print(f"{len(shares)} attractors, with shares of {', '.join(f'{share:.2f}' for share in shares)}")

assert len(shares) >= 2
assert abs(shares.sum() - 1.0) < 1e-12
