"""Scalar theory of diffract: shares of the orders of a grating in one direction, light in the plane across the grooves.

share_m = F |c_m|² / w², w = −(cos θ_i + cos θ_r), c_m = 1/d ∫ e^{ikwh(x)} e^{−2πimx/d} dx. The factor F is that of the theory:

    stam          R(half angle) (1 + ω_i·ω_r)² / (cos θ_i cos θ_r), equation B.12 of the thesis with Fresnel's reflectance
    small-slope   4 cos θ_i cos θ_r |B|², the small-slope approximation of first order (Voronovich 1994, Waves in Random Media 4, 337)

and small-slope divides f by max(1, E(ω_i)/R(ω_i), E(ω_r)/R(ω_r)): E is the share of the light from a direction that all orders get, R Fresnel's
reflectance of a flat surface, both for unpolarised light.
"""

from dataclasses import dataclass

import numpy as np

K = 2 * np.pi
THEORIES = ["small-slope", "stam"]
POLARISATIONS = ["te", "tm", "mean"]
# Orders at the horizon, of a smaller cosine, have no light.
HORIZON = 1e-6


def inside(index, sine):
    """Returns √(n² − sin²θ), the cosine of the refracted wave times n."""
    return np.sqrt(index**2 - sine**2 + 0j)


def fresnel(index, cos):
    """Returns the reflectances (TE, TM) of a plane at the cosine `cos` of the angle of incidence. index: None for a perfect conductor."""
    if index is None:
        return np.ones_like(cos), np.ones_like(cos)
    q = np.sqrt(index**2 - 1 + cos**2 + 0j)
    te = (cos - q) / (cos + q)
    tm = (index**2 * cos - q) / (index**2 * cos + q)
    return abs(te) ** 2, abs(tm) ** 2


def stam(index, sine, out):
    """Returns the factor (TE, TM) of Stam from light of sin θ_i = `sine` toward +x to sin θ_r = `out`, the mirror direction being `out` = `sine`."""
    product = np.sqrt(1 - sine**2) * np.sqrt(1 - out**2)
    one_plus = 1 + product - sine * out
    te, tm = fresnel(index, np.sqrt(one_plus / 2))
    return te * one_plus**2 / product, tm * one_plus**2 / product


def small_slope(index, sine, out):
    """Returns the factor (TE, TM) of the small-slope approximation; directions as in `stam`.

    Signed sines hold the azimuth: cos φ = ±1 is the sign of `sine` · `out`, and leaves |ss| and turns the sign of all of pp."""
    cos_i, cos_r = np.sqrt(1 - sine**2), np.sqrt(1 - out**2)
    q_i, q_r = inside(index, sine), inside(index, out)
    e, n2 = index**2 - 1, index**2
    ss = e / ((cos_i + q_i) * (cos_r + q_r))
    pp = e * (q_r * q_i - n2 * out * sine) / ((n2 * cos_r + q_r) * (n2 * cos_i + q_i))
    return 4 * cos_i * cos_r * abs(ss) ** 2, 4 * cos_i * cos_r * abs(pp) ** 2


FACTORS = {"small-slope": small_slope, "stam": stam}


@dataclass(frozen=True)
class Prediction:
    """Shares of the orders without a limit, and the energy of the theory in unpolarised light.

    shares: {"te", "tm", "mean"}. incident, outgoing: E/R of the light, and by order of light from the direction into which it goes.
    """

    shares: dict
    incident: float
    outgoing: np.ndarray


def between(curve, sines):
    """Returns |c|² w⁻² from each of the directions `sines` to each; they differ by multiples of 1/period."""
    cos = np.sqrt(1 - sines**2)
    # w = cos θ_i + cos θ_r: the phase is a sum of a part of each direction.
    arriving, leaving = (np.exp(-1j * K * (np.outer(cos, curve.z) + sign * np.outer(sines, curve.x))) for sign in [-1, 1])
    c = (arriving * curve.dx) @ leaving.T / len(curve.x)
    return abs(c) ** 2 / (cos[:, None] + cos) ** 2


def predict(theory, curve, sine, index, orders):
    """Returns the prediction for `orders`, all of those that propagate; light of sin θ_i = `sine` travels toward +x."""
    sines = sine + orders / curve.period
    lit = abs(sines) < np.sqrt(1 - HORIZON**2)
    sines, place = sines[lit], list(orders[lit]).index(0)
    te, tm = (between(curve, sines) * factor for factor in FACTORS[theory](index, sines[:, None], sines[None]))
    mean = (te + tm) / 2
    flat = np.mean(fresnel(index, np.sqrt(1 - sines**2)), axis=0)
    shares = {name: np.zeros(len(orders)) for name in POLARISATIONS}
    for name, values in zip(POLARISATIONS, [te, tm, mean]):
        shares[name][lit] = values[place]
    # Light that comes back from an order goes into each direction by the share that light from there sends into the order: a column adds it up.
    outgoing = np.ones(len(orders))
    outgoing[lit] = mean.sum(axis=0) / flat
    return Prediction(shares, mean[place].sum() / flat[place], outgoing)


def limited(prediction, divisor):
    """Returns the shares divided by `divisor`, which is at least 1."""
    return {name: share / divisor for name, share in prediction.shares.items()}


def shares(theory, curve, sine, index, orders):
    """Returns the reflected shares of `orders` by the theory as the program has it: {"te", "tm", "mean"}."""
    found = predict(theory, curve, sine, index, orders)
    if theory == "stam":
        return found.shares
    return limited(found, np.maximum(np.maximum(1, found.incident), found.outgoing))
