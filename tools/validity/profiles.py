"""Profiles of gratings as smooth parametric curves x(t), z(t), one period long.

Lengths are in wavelengths. A curve has x(t + period) = x(t) + period and x'(t) > 0. Corners are rounded: the curve of straight lines, taken by
arc length, is convolved with a Gaussian whose standard deviation is `ROUNDING` of the curve's length.
"""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

# Standard deviation of the Gaussian that rounds corners, over the length of the curve.
ROUNDING = 0.01
# Width of the flanks of blazes and lamellar gratings over the period.
FLANK = 0.06
# Points per period of a curve; its Fourier coefficients are those of a fast Fourier transform.
SAMPLES = 4096


@dataclass(frozen=True)
class Curve:
    """A profile at `SAMPLES` equidistant parameters t from 0 to `period`."""

    period: float
    x: np.ndarray
    z: np.ndarray
    dx: np.ndarray
    dz: np.ndarray

    @property
    def height(self):
        """Returns the height range."""
        return np.ptp(self.z)

    def rms_slope(self):
        """Returns the RMS of dz/dx over x."""
        return np.sqrt(np.mean(self.dz**2 / self.dx))

    def rms(self):
        """Returns the RMS height about the mean over x."""
        mean = np.mean(self.z * self.dx)
        return np.sqrt(np.mean((self.z - mean) ** 2 * self.dx))


def derivative(values, period):
    """Returns the derivative of equidistant samples of a periodic function."""
    n = len(values)
    frequency = 2 * np.pi / period * np.fft.fftfreq(n, 1 / n)
    frequency[n // 2] = 0
    return np.fft.ifft(1j * frequency * np.fft.fft(values)).real


def from_graph(period, height, slope):
    """Returns the curve of `height`(x), whose derivative is `slope`(x), by arc length."""
    fine = np.linspace(0, period, 4 * SAMPLES + 1)
    speed = np.sqrt(1 + slope(fine) ** 2)
    arc = np.concatenate([[0], np.cumsum((speed[1:] + speed[:-1]) / 2)])
    t = np.arange(SAMPLES) * period / SAMPLES
    x = CubicSpline(arc * period / arc[-1], fine)(t)
    dx = np.mean(speed[:-1]) / np.sqrt(1 + slope(x) ** 2)
    return Curve(period, x, height(x), dx, slope(x) * dx)


def from_corners(period, corners, rounding=ROUNDING):
    """Returns the rounded curve of straight lines through `corners` (x, z), whose first is at x = 0 and whose last is at x = period."""
    corners = np.asarray(corners, float)
    lengths = np.hypot(*np.diff(corners, axis=0).T)
    arc = np.concatenate([[0], np.cumsum(lengths)])
    t = np.arange(SAMPLES) * period / SAMPLES
    s = t * arc[-1] / period
    low_pass = np.exp(-0.5 * (2 * np.pi * rounding * np.fft.fftfreq(SAMPLES, 1 / SAMPLES)) ** 2)
    smooth = lambda values: np.fft.ifft(low_pass * np.fft.fft(values)).real
    # x(t) − t is periodic.
    shift = smooth(np.interp(s, arc, corners[:, 0]) - t)
    z = smooth(np.interp(s, arc, corners[:, 1]))
    return Curve(period, t + shift, z, 1 + derivative(shift, period), derivative(z, period))


def sinusoid(period, height):
    """Returns a sinusoid of full height `height`."""
    k, a = 2 * np.pi / period, height / 2
    return from_graph(period, lambda x: a * np.cos(k * x), lambda x: -a * k * np.sin(k * x))


def blaze(period, height, flank=FLANK, rounding=ROUNDING):
    """Returns a sawtooth that rises over all of the period but `flank` of it."""
    scale = np.array([period, height])
    return from_corners(period, scale * [[0, 0], [1 - flank, 1], [1, 0]], rounding)


def lamellar(period, height, flank=FLANK, rounding=ROUNDING):
    """Returns ridges half a period wide with flanks `flank` of the period wide."""
    f = flank / 2
    corners = [[0, 0], [0.25 - f, 0], [0.25 + f, 1], [0.75 - f, 1], [0.75 + f, 0], [1, 0]]
    return from_corners(period, np.array([period, height]) * corners, rounding)
