"""Small and periodic motions of many devices at once, with the states of their films and circuits.

In one-harmonic balance, mean, sine and cosine of every state balance those of its rate under a sine, at the amplitude
of the voltage. Derivatives are those of the traced equation of motion, by quadrature over a period.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from gelcone.motion.regular import solved_where_regular
from gelcone.physics.members import Members
from gelcone.quantity import Array

PHASES = 16
"""Number of phases of a period at which forces, or rates, are balanced."""
NEWTON_STEPS, LONGEST_STEP, SMALLEST_STEP = 40, 0.1, 1e-12
"""Most Newton steps of a balance, the longest step of a displacement, and the size of the last step."""
BALANCED = 1e-8
"""Size of the last step above which no balance is found."""
PHASE = 2.0 * np.pi * np.arange(PHASES) / PHASES
BASIS = np.stack([np.ones(PHASES), np.sin(PHASE), np.cos(PHASE)])
WEIGHTS = np.stack([np.ones(PHASES), 2.0 * np.sin(PHASE), 2.0 * np.cos(PHASE)]) / PHASES
"""Mean, sine and cosine over a period, and the weights that find them."""
RATE = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""The derivative of mean, sine and cosine by the phase."""


def at_rest(members: Members, x: Array, voltage: Array) -> tuple[Array, Array]:
    """All states, (members, states), of discs held at x under constant commands until films and circuits have settled,
    and the derivatives of their rates, (members, states, states)."""
    still = members.replace(voltage=0.0, voltage_bias=voltage)
    z = still.start_states(np.stack([x, np.zeros_like(x)], axis=1))
    for _ in range(NEWTON_STEPS):
        rates, slopes = _rates(still, np.zeros(len(z)), z)
        step = solved_where_regular(slopes[:, 2:, 3:], rates[:, 2:])
        z[:, 2:] -= step
        if not np.nanmax(np.abs(step), initial=0.0) > SMALLEST_STEP:
            break
    return z, slopes[..., 1:]


def _rates(members: Members, tau: Array, z: Array) -> tuple[Array, Array]:
    """Rates of states (members, ..., states), and their derivatives by time and states, (..., states, 1 + states)."""
    n = members.numbers(trailing=tau.ndim - 1)
    rates, slopes = members.system.rates_and_slopes(tau, list(np.moveaxis(z, -1, 0)), n)
    rows = [[np.broadcast_to(one, tau.shape) for one in row] for row in slopes]
    return np.stack([np.broadcast_to(rate, tau.shape) for rate in rates], axis=-1), np.moveaxis(
        np.array(rows, dtype=float), (0, 1), (-2, -1)
    )


def small_motion(members: Members, x: Array) -> tuple[Array, Array]:
    """Angular frequency and decay rate of small motions about rests x without voltage, (members,); NaN for motions that
    do not oscillate."""
    motions = np.full((2, members.size), np.nan)
    slopes = at_rest(members, x, np.zeros(members.size))[1]
    for k in np.flatnonzero(np.isfinite(slopes).all(axis=(1, 2))):
        values = np.linalg.eigvals(slopes[k])
        fastest = values[np.argmax(values.imag)]
        if fastest.imag > 0.0:
            motions[:, k] = fastest.imag, -fastest.real
    return motions[0], motions[1]


def linear_motion(members: Members, x: Array) -> Array:
    """Mean, sine and cosine of all states, (members, states, 3), of the linear motion about x, as a start for
    `balanced`."""
    z, slopes = at_rest(members, x, members.values["voltage_bias"])
    omega, size = members.values["drive_frequency"], z.shape[1]
    stirred = _rates(members, np.zeros(len(z)), z)[1][..., 0] / omega[:, None]
    moved = solved_where_regular(1j * omega[:, None, None] * np.eye(size) - slopes, stirred)
    return np.stack([z, moved.real, moved.imag], axis=-1)


def balanced(members: Members, start: Array) -> Array:
    """Mean, sine and cosine of all states, (members, states, 3), of the motion under a sine; NaN where Newton's method
    fails, or a film has pulled in at one of the phases."""
    c, count = start.copy(), start.shape[1]
    size = np.full(len(c), np.nan)
    moving = np.flatnonzero(np.isfinite(c).all(axis=(1, 2)))
    for _ in range(NEWTON_STEPS):
        if not moving.size:
            break
        moving_members = members if moving.size == members.size else members.take(moving)
        omega = moving_members.values["drive_frequency"]
        rates, slopes = _rates(moving_members, PHASE / omega[:, None], np.moveaxis(c[moving] @ BASIS, 1, 2))
        turned = omega[:, None, None, None, None] * np.einsum("ij,kl->ikjl", np.eye(count), RATE)
        residual = np.einsum("rpi,kp->rik", rates, WEIGHTS) - omega[:, None, None] * (c[moving] @ RATE.T)
        matrix = np.einsum("kp,rpij,lp->rikjl", WEIGHTS, slopes[..., 1:], BASIS, optimize=True) - turned
        rows = (len(moving), 3 * count)
        step = solved_where_regular(matrix.reshape(*rows, 3 * count), residual.reshape(rows)).reshape(residual.shape)
        size[moving] = np.abs(step).max(axis=(1, 2))
        longest = np.maximum(np.abs(step[:, 0]).max(axis=1), 1e-300)
        c[moving] -= step * np.minimum(1.0, LONGEST_STEP / longest)[:, None, None]
        moving = moving[size[moving] > SMALLEST_STEP]
    is_balanced = (size < BALANCED) & ~_pulled_in(members, c)
    return np.where(is_balanced[:, None, None], c, np.nan)


def _pulled_in(members: Members, c: Array) -> npt.NDArray[np.bool_]:
    """Mask (members,): a phase of the motion lies beyond a border at which a film ends."""
    system, n, z = members.system, members.numbers(trailing=1), list(np.moveaxis(c @ BASIS, 1, 0))
    tau = PHASE / members.values["drive_frequency"][:, None]
    n = {**n, **system.switches(tau, z, n)}
    with np.errstate(all="ignore"):
        ends = [border.value(tau, z, n, np) < 0.0 for _, border in system.borders if not border.switch]
    return np.asarray(np.any(ends, axis=(0, -1)) if ends else np.zeros(members.size, dtype=bool))
