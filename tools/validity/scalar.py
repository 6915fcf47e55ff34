"""Scalar theory of diffract: shares of the orders by equation B.12 of the thesis, for a grating in one direction.

share_m = R(half angle) · G / w² · |c_m|², G = (1 + ω_i·ω_r)² / (cos θ_i cos θ_r), w = −(cos θ_i + cos θ_r), c_m = 1/d ∫ e^{ikwh(x)} e^{−2πimx/d} dx.
"""

import numpy as np

K = 2 * np.pi


def fresnel(index, cos):
    """Returns the reflectances (TE, TM) of a plane at the cosine `cos` of the angle of incidence."""
    inside = np.sqrt(index**2 - 1 + cos**2 + 0j)
    te = (cos - inside) / (cos + inside)
    tm = (index**2 * cos - inside) / (index**2 * cos + inside)
    return abs(te) ** 2, abs(tm) ** 2


def shares(curve, sine, index, orders):
    """Returns the reflected shares of `orders`: {"te", "tm", "mean"}; light of sin θ_i = `sine` travels toward +x."""
    out = sine + orders / curve.period
    cos_i, cos_r = np.sqrt(1 - sine**2), np.sqrt(1 - out**2)
    w = cos_i + cos_r
    one_plus = 1 + cos_i * cos_r - sine * out
    phase = np.exp(-1j * K * (np.outer(w, curve.z) + np.outer(orders / curve.period, curve.x)))
    c = np.mean(phase * curve.dx, axis=1)
    scalar = one_plus**2 / (cos_i * cos_r) / w**2 * abs(c) ** 2
    te, tm = fresnel(index, np.sqrt(one_plus / 2))
    return {"te": te * scalar, "tm": tm * scalar, "mean": (te + tm) / 2 * scalar}
