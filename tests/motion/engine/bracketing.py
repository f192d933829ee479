"""A reference for oscillators whose stiffness changes at borders: closed-form pieces, switches found by bracketing.

    x'' + 2 z x' + k x = c + f sin(w t)    between switches,

with k = 1 + K_1 [x > d_1] + K_2 [x > d_2] and c = K_1 d_1 [x > d_1] + K_2 d_2 [x > d_2]: the force is continuous.
"""

import numpy as np


class Pieces:
    """Members (M,) in their present piece, each with its own time and state at the piece's start."""

    def __init__(self, z, f, w, stiffness, borders):
        self.z, self.f, self.w = z, f, w
        self.stiffness, self.borders = stiffness, borders  # (2, M) each
        members = f.size
        self.start = np.zeros(members)
        self.beyond = np.zeros((2, members), dtype=bool)
        self.switches = np.zeros(members, dtype=int)
        self.amplitudes = np.zeros((6, members))
        self.enter(np.ones(members, dtype=bool), np.zeros(members), np.zeros(members), np.zeros(members))

    def enter(self, chosen, time, x, u):
        """Starts a new piece at these states."""
        k = 1.0 + (self.stiffness * self.beyond).sum(axis=0)
        c = (self.stiffness * self.borders * self.beyond).sum(axis=0)
        difference, drag = k - self.w**2, 2.0 * self.z * self.w
        scale = self.f / (difference**2 + drag**2)
        sine, cosine = difference * scale, -drag * scale
        rest = c / k
        phase = self.w * time
        a = x - rest - sine * np.sin(phase) - cosine * np.cos(phase)
        b = u - self.w * (sine * np.cos(phase) - cosine * np.sin(phase))
        omega = np.sqrt(k - self.z**2)
        made = np.array([a, (b + self.z * a) / omega, omega, rest, sine, cosine])
        self.amplitudes = np.where(chosen, made, self.amplitudes)
        self.start = np.where(chosen, time, self.start)

    def at(self, time, index=slice(None)):
        """Displacement and velocity of the members ``index``."""
        a, b, omega, rest, sine, cosine = self.amplitudes[:, index]
        tau = time - self.start[index]
        decay = np.exp(-self.z * tau)
        co, si = np.cos(omega * tau), np.sin(omega * tau)
        free, slope = decay * (a * co + b * si), decay * omega * (b * co - a * si)
        w = self.w[index]
        sw, cw = np.sin(w * time), np.cos(w * time)
        x = rest + free + sine * sw + cosine * cw
        u = slope - self.z * free + w * (sine * cw - cosine * sw)
        return x, u

    def gap(self, time, border, index=slice(None)):
        """How far a member is on its side of a border, and how fast that changes."""
        x, u = self.at(time, index)
        sign = np.where(self.beyond[border, index], 1.0, -1.0)
        return sign * (x - self.borders[border, index]), sign * u

    def _switch(self, now, end, border):
        """Time at which each member passes the border in (now, end], infinite if it does not."""
        times = np.full(now.shape, np.inf)
        _, slope = self.gap(now, border)
        gap_end, slope_end = self.gap(end, border)
        # one that leaves the border which it stands on does not cross it; a dip may hide between positive ends
        index = np.flatnonzero(
            ((gap_end < 0.0) & ((slope <= 0.0) | (slope_end <= 0.0))) | ((slope < 0.0) & (slope_end > 0.0))
        )
        if not index.size:
            return times
        low, high, slope, slope_end = now[index], end[index], slope[index], slope_end[index]
        turns = np.flatnonzero(slope * slope_end < 0.0)
        if turns.size:
            inner, sign = index[turns], np.sign(slope[turns])
            turn = bisect(lambda t: sign * self.gap(t, border, inner)[1], low[turns], high[turns])
            low[turns] = np.where(sign > 0.0, turn, low[turns])  # from its highest point
            high[turns] = np.where(sign < 0.0, turn, high[turns])  # or to its lowest
        crosses = self.gap(high, border, index)[0] < 0.0
        inner = index[crosses]
        if inner.size:
            times[inner] = falling_zero(lambda t: self.gap(t, border, inner), low[crosses], high[crosses])
        return times

    def first_switch(self, now, end):
        """Time of the first switch in (now, end], infinite if none, and its border."""
        both = np.array([self._switch(now, end, border) for border in range(2)])
        return both.min(axis=0), both.argmin(axis=0)

    def advance(self, now, end):
        """To the end, or to the first switch before it, of each member; the time reached."""
        time, border = self.first_switch(now, end)
        due = np.isfinite(time)
        moment = np.where(due, time, end)
        if due.any():
            x, u = self.at(moment)
            self.beyond ^= (np.arange(2)[:, None] == border) & due
            self.switches += due
            self.enter(due, moment, x, u)
        return moment, due


def bisect(function, low, high):
    """Where a function that is positive at ``low`` and not at ``high`` changes its sign, to 1e-11 of the span."""
    for _ in range(36):
        middle = 0.5 * (low + high)
        positive = function(middle) > 0.0
        low, high = np.where(positive, middle, low), np.where(positive, high, middle)
    return high


def falling_zero(function, low, high):
    """The same to the last digits, by Newton's method with the slope, kept inside of the bracket."""
    at = low.copy()  # first: a second border at the same place is passed at once
    for _ in range(16):
        value, slope = function(at)
        low, high = np.where(value > 0.0, at, low), np.where(value > 0.0, high, at)
        with np.errstate(all="ignore"):
            newton = at - value / slope
        at = np.where((newton >= low) & (newton <= high), newton, 0.5 * (low + high))
    return at


def reference(z, f, w, stiffness, borders, times, span=0.1):
    """States (M, samples, 2) at common ``times`` from rest, and the number of switches (M,).

    ``span``: so short that a velocity changes its sign at most once in it.
    """
    pieces = Pieces(z, f, w, stiffness, borders)
    result, now, sample = np.empty((f.size, times.size, 2)), np.zeros(f.size), np.zeros(f.size, dtype=int)
    while (sample < times.size).any():
        target = times[np.minimum(sample, times.size - 1)]
        now, switched = pieces.advance(now, np.minimum(now + span, np.maximum(target, now)))
        arrived = np.flatnonzero((now >= target) & ~switched & (sample < times.size))
        if arrived.size:
            result[arrived, sample[arrived]] = np.stack(pieces.at(now[arrived], arrived), axis=-1)
            sample[arrived] += 1
    return result, pieces.switches
