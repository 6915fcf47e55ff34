"""Kernel of the small-slope approximation, on NumPy and on Dr.Jit: shaders/small_slope.glsl of diffract, which has its source."""

import drjit as dr
import mitsuba as mi
import numpy as np

# Product of sines below which a direction is the normal: the azimuth is rounding there, and the sum over polarisations does not depend on it.
NORMAL = 1e-6


def sum_over_polarisations(contrast, q_i, q_r, c_i, c_r, cosine, sines, polarisation, power):
    """Returns |B|^2, with contrast = n^2 - 1, q = sqrt(n^2 - sin^2 theta), c = cos theta, the cosine of the azimuth between the wave vectors in the plane, and
    the product of the sines of both directions. `power` is that of a complex number."""
    squared, sine2 = contrast + 1, 1 - cosine * cosine
    s_i, s_r = power(q_i + c_i), power(q_r + c_r)
    p_i, p_r = power(squared * c_i + q_i), power(squared * c_r + q_r)
    te = (cosine * cosine / s_r + sine2 * power(q_r) / p_r) / s_i
    tm = (power(q_r * q_i * cosine - squared * sines) / p_r + sine2 * power(q_i) / s_r) / p_i
    return power(contrast) * {"none": 0.5 * (te + tm), "te": te, "tm": tm}[polarisation]


def on_host(index, light, viewer, polarisation):
    """Returns |B|^2 for a refractive index n + ik, where `light` and `viewer` are lists of three arrays of NumPy."""
    contrast = complex(index) ** 2 - 1
    q = lambda c: np.sqrt(contrast + c * c)
    sines = np.hypot(light[0], light[1]) * np.hypot(viewer[0], viewer[1])
    cosine = -(light[0] * viewer[0] + light[1] * viewer[1]) / np.maximum(sines, NORMAL)
    cosine = np.where(sines > NORMAL, np.clip(cosine, -1, 1), 1)
    power = lambda z: np.abs(z) ** 2
    return sum_over_polarisations(contrast, q(light[2]), q(viewer[2]), light[2], viewer[2], cosine, sines, polarisation, power)


def on_device(index, light, viewer, polarisation):
    """Returns |B|^2 for a refractive index n + ik, where `light` and `viewer` are vectors of Dr.Jit."""
    contrast = mi.Complex2f(complex(index) ** 2 - 1)
    q = lambda c: dr.sqrt(contrast + c * c)
    sines = dr.sqrt((light.x * light.x + light.y * light.y) * (viewer.x * viewer.x + viewer.y * viewer.y))
    cosine = -(light.x * viewer.x + light.y * viewer.y) / dr.maximum(sines, NORMAL)
    cosine = dr.select(sines > NORMAL, dr.clip(cosine, -1, 1), 1)
    power = lambda z: z.real * z.real + z.imag * z.imag
    return sum_over_polarisations(contrast, q(light.z), q(viewer.z), light.z, viewer.z, cosine, sines, polarisation, power)
