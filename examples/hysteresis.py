"""Between which drive frequencies a biased cone has two motions, and why: the folds of its response.

Sweeps bracket the two jumps; the branch between them, which no sweep sees, has a fold in each bracket.
"""

import numpy as np

import gelcone

cone = gelcone.ConeModel(
    damping_ratio=0.01, voltage=0.06, voltage_bias=0.6, rest_height=0.8, hoop_prestretch=1.4, law="neo-hookean"
)
response = gelcone.frequency(cone, np.linspace(1.4, 1.43, 7), (0.8, 0.0), branches=True)
figure = response.gelcone.plot()

folds = response["jump_event"].values
for jump in range(response.sizes["jump"]):
    own = response.isel(jump=jump)
    low, high, sweep = float(own["jump_low"]), float(own["jump_high"]), str(own["jump_branch"].values)
    print(f"swept {sweep:4s} it jumps between {low:.6f} and {high:.6f}: fold at {folds[jump]:.9f}")
width = folds[1] - folds[0]
print(f"two motions coexist over {width:.9f}")

assert all(
    jump_low <= fold <= jump_high
    for jump_low, fold, jump_high in zip(response["jump_low"].values, folds, response["jump_high"].values, strict=True)
)
assert abs(width - 0.008554462) < 1e-8
