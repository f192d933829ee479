"""Sine, cosine, exponential and logarithm from arithmetic alone, to about one unit in the last place.

Without calls of a mathematical library they give the same bits on every machine and in every lane.
"""

from __future__ import annotations

import math

from gelcone.motion.engine.code import Function, Value

ROUND = 1.5 * 2.0**52
"""Adding and subtracting this rounds a number to an integer; the lowest bits of the sum hold it."""
HALF_PI = (1.5707963267948966, 6.123233995736766e-17, -1.4973849048591698e-33)
LOG_2_HIGH, LOG_2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
"""log 2 in two parts, the first with 21 trailing zero bits, so that its product with an exponent is exact."""
SQRT_HALF_BITS = 0x3FE6A09E667F3BCD
MANTISSA_BITS = 0xFFFFFFFFFFFFF


def sine_cosine(f: Function, angle: Value) -> tuple[Value, Value]:
    """Sine and cosine of an angle.

    Reduction to |r| <= pi/4 by three parts of pi/2 (Cody and Waite, Software Manual for the Elementary Functions,
    1980), exact in fused arithmetic up to 1e9; then Taylor series. Infinity gives NaN.
    """
    shifted = f.fused(angle, f.real(2.0 / math.pi), f.real(ROUND))
    minus = f.negative(f.subtract(shifted, f.real(ROUND)))
    quarter = f.bits(shifted)
    first = f.fused(minus, f.real(HALF_PI[0]), angle)
    product = f.multiply(minus, f.real(HALF_PI[1]))
    r, lost = two_sum(f, first, product)
    product_lost = f.fused(minus, f.real(HALF_PI[1]), f.negative(product))
    rest = f.fused(minus, f.real(HALF_PI[2]), f.add(lost, product_lost))
    z = f.multiply(r, r)
    series = f.polynomial(z, [f.real((-1.0) ** k / math.factorial(2 * k + 1)) for k in range(1, 10)])
    sine = f.add(r, f.fused(f.multiply(z, r), series, f.fused(f.multiply(f.real(-0.5), z), rest, rest)))
    series = f.polynomial(z, [f.real((-1.0) ** k / math.factorial(2 * k)) for k in range(2, 10)])
    half = f.multiply(f.real(0.5), z)
    top = f.subtract(f.real(1.0), half)
    lost = f.subtract(f.subtract(f.real(1.0), top), half)
    lost = f.subtract(lost, f.multiply(r, rest))
    cosine = f.add(top, f.fused(f.multiply(z, z), series, lost))
    odd = f.compare_whole("ne", f.whole("and", quarter, f.integer(1)), f.integer(0))

    def signed(value: Value, turns: Value) -> Value:
        sign = f.whole("shl", f.whole("and", turns, f.integer(2)), f.integer(62))
        return f.from_bits(f.whole("xor", f.bits(value), sign))

    return (
        signed(f.choose(odd, cosine, sine), quarter),
        signed(f.choose(odd, sine, cosine), f.whole("add", quarter, f.integer(1))),
    )


def exponential(f: Function, value: Value, rest: Value | None = None) -> Value:
    """exp(value + rest), for a ``rest`` far below the value's last place; 0 and infinity beyond the range.

    exp(k log 2 + r) = 2^k exp(r), |r| <= log(2)/2, with a Taylor series for exp(r).
    """
    value = f.choose(f.compare("ogt", value, f.real(800.0)), f.real(800.0), value)
    value = f.choose(f.compare("olt", value, f.real(-800.0)), f.real(-800.0), value)
    shifted = f.fused(value, f.real(1.0 / math.log(2.0)), f.real(ROUND))
    minus = f.negative(f.subtract(shifted, f.real(ROUND)))
    first = f.fused(minus, f.real(LOG_2_HIGH), value)
    low = f.multiply(minus, f.real(LOG_2_LOW))
    if rest is not None:
        low = f.add(low, rest)
    r = f.add(first, low)
    lost = f.add(f.subtract(first, r), low)
    series = f.polynomial(r, [f.real(1.0 / math.factorial(k)) for k in range(2, 15)])
    result = f.add(f.real(1.0), f.add(r, f.fused(f.multiply(r, r), series, lost)))
    # 2^k in two factors, so that numbers near both ends of the range come out right
    power = f.whole("sub", f.bits(shifted), f.integer(0x4338000000000000))
    half = f.whole("ashr", power, f.integer(1))
    for part in (half, f.whole("sub", power, half)):
        scale = f.whole("shl", f.whole("add", part, f.integer(1023)), f.integer(52))
        result = f.multiply(result, f.from_bits(scale))
    return result


def logarithm(f: Function, value: Value) -> tuple[Value, Value]:
    """log(value) and its rounding error; NaN outside the normal positive numbers.

    log(2^e (1 + m)) = e log 2 + log(1 + m) with 1 + m in [sqrt(1/2), sqrt(2)), and log(1 + m) =
    m - m^2/2 + s (m^2/2 + R), s = m/(2 + m), R = 2 (s^2/3 + s^4/5 + ...), as in fdlibm.
    """
    mantissa, exponent = split(f, value)
    m = f.subtract(mantissa, f.real(1.0))
    s = f.divide(m, f.add(m, f.real(2.0)))
    z = f.multiply(s, s)
    series = f.multiply(z, f.polynomial(z, [f.real(2.0 / (2 * k + 3)) for k in range(11)]))
    half = f.multiply(f.real(0.5), m)
    square = f.multiply(half, m)
    square_low = f.fused(half, m, f.negative(square))
    correction = f.fused(s, f.add(square, series), f.fused(exponent, f.real(LOG_2_LOW), f.negative(square_low)))
    # e log 2 + m - m^2/2 + correction, from the largest term on, with all rounding errors
    result, lost = two_sum(f, f.multiply(exponent, f.real(LOG_2_HIGH)), m)
    result, more = two_sum(f, result, f.negative(square))
    low = f.add(f.add(lost, more), correction)
    total, low = two_sum(f, result, low)
    normal = f.both(f.compare("oge", value, f.real(2.0**-1022)), f.compare("olt", value, f.real(math.inf)))
    return f.choose(normal, total, f.real(math.nan)), low


def logarithm_of_one_plus(f: Function, value: Value) -> Value:
    """log(1 + value) = log(u) + c/u, with u = 1 + value rounded and c the rounding error."""
    u, lost = two_sum(f, f.real(1.0), value)
    return f.add(logarithm(f, u)[0], f.divide(lost, u))


def power(f: Function, base: Value, exponent: Value) -> Value:
    """base^exponent = exp(exponent log(base)), with the rounding error of the product; base > 0."""
    log, low = logarithm(f, base)
    product = f.multiply(exponent, log)
    rest = f.fused(exponent, low, f.fused(exponent, log, f.negative(product)))
    return exponential(f, product, rest)


def two_sum(f: Function, a: Value, b: Value) -> tuple[Value, Value]:
    """a + b rounded, and the rounding error (Knuth, The Art of Computer Programming 2, 4.2.2)."""
    total = f.add(a, b)
    back = f.subtract(total, a)
    return total, f.add(f.subtract(a, f.subtract(total, back)), f.subtract(b, back))


def split(f: Function, value: Value) -> tuple[Value, Value]:
    """Mantissa in [sqrt(1/2), sqrt(2)) and binary exponent of positive normal numbers, both as reals."""
    steps = f.whole("sub", f.bits(value), f.integer(SQRT_HALF_BITS))
    mantissa = f.whole("add", f.whole("and", steps, f.integer(MANTISSA_BITS)), f.integer(SQRT_HALF_BITS))
    exponent = f.whole("add", f.whole("ashr", steps, f.integer(52)), f.integer(0x4338000000000000))
    return f.from_bits(mantissa), f.subtract(f.from_bits(exponent), f.real(ROUND))


def rough_log2(f: Function, value: Value) -> Value:
    """log2 to about 1e-4, for step sizes; for 0 a finite number below -1000."""
    mantissa, exponent = split(f, value)
    m = f.subtract(mantissa, f.real(1.0))
    terms = (1.4426950408889634, -0.72134752, 0.48089835, -0.36067376, 0.2885390, -0.2404492)
    return f.fused(m, f.polynomial(m, [f.real(term) for term in terms]), exponent)


def rough_exp2(f: Function, value: Value) -> Value:
    """2^value to about 1e-4, for |value| < 1000."""
    shifted = f.add(value, f.real(ROUND))
    r = f.subtract(value, f.subtract(shifted, f.real(ROUND)))
    series = f.polynomial(r, [f.real(math.log(2.0) ** k / math.factorial(k)) for k in range(6)])
    return f.from_bits(f.whole("add", f.bits(series), f.whole("shl", f.bits(shifted), f.integer(52))))
