"""The coordinate transformation (C) method for a grating in one direction, light in the plane across the grooves.

J. Chandezon, M. T. Dupuis, G. Cornet, D. Maystre, "Multicoated gratings: a differential formalism applicable in the entire optical region",
J. Opt. Soc. Am. 72, 839 (1982); L. Li, J. Chandezon, G. Granet, J.-P. Plumey, "Rigorous and efficient grating-analysis method made easy for
optical engineers", Appl. Opt. 38, 304 (1999); parametric curves after J.-P. Plumey, B. Guizal, J. Chandezon, "Coordinate transformation method as
applied to asymmetric gratings with vertical facets", J. Opt. Soc. Am. A 14, 610 (1997).

Coordinates (t, u): x = x(t), z = z(t) + u; the profile is u = 0. F is the field along the grooves, E (TE) or H (TM); fields go as e^{−iωt}. With F
= Σ F_m e^{iα_m t} e^{iρu} Helmholtz's equation in a medium of index n is a quadratic eigenproblem in ρ,

    (k²n² D − α A α) F + ρ (α B + B α) F − ρ² C F = 0,

A, B, C, D: Toeplitz matrices of the Fourier coefficients of 1/x', z'/x', x' + z'²/x' and x'. On the profile F and (x' ∂_z − z' ∂_x) F / n^{0 (TE), 2 (TM)}
are continuous. Plane waves that propagate are known exactly and replace their eigenvectors. Lengths are in wavelengths, k = 2π.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig, toeplitz

K = 2 * np.pi


@dataclass(frozen=True)
class Efficiencies:
    """Shares of the incident light by order, and what checks them.

    orders: numbers m of the reflected orders that propagate; sine: sin θ_r = sin θ_i + m λ/d of each. reflected: {"te", "tm"} to shares.
    energy: |1 − reflected − transmitted − absorbed|, the larger of TE and TM.
    """

    orders: np.ndarray
    sine: np.ndarray
    reflected: dict
    energy: float


def matrix(values, size):
    """Returns the Toeplitz matrix of the Fourier coefficients of equidistant samples of a periodic function."""
    c = np.fft.fft(values) / len(values)
    n = np.arange(size)
    return toeplitz(c[n], c[-n])


class Curved:
    """Operators of a curve for `size` Fourier coefficients, light of sin θ_i = `sine`."""

    def __init__(self, curve, sine, size):
        self.curve, self.size = curve, size
        self.order = np.arange(size) - size // 2
        self.alpha = K * (sine + self.order / curve.period)
        self.t = np.arange(len(curve.x)) * curve.period / len(curve.x)
        self.carrier = np.exp(-1j * K * sine * self.t)
        a, b = 1 / curve.dx, curve.dz / curve.dx
        self.a, self.b = matrix(a, size), matrix(b, size)
        self.c, self.d = matrix(curve.dx + curve.dz * b, size), matrix(curve.dx, size)

    def coefficients(self, field):
        """Returns the Fourier coefficients of a field that is given along the curve."""
        c = np.fft.fft(field * self.carrier) / len(field)
        return c[self.order]

    def plane_wave(self, alpha, beta):
        """Returns e^{i(αx + βz)} and its derivative along the normal, on the curve."""
        wave = np.exp(1j * (alpha * self.curve.x + beta * self.curve.z))
        slope = 1j * (beta * self.curve.dx - alpha * self.curve.dz) * wave
        return self.coefficients(wave), self.coefficients(slope)

    def outgoing(self, index, up):
        """Returns the fields that leave into a medium above (`up`) or below the profile: the orders that propagate, F and its normal
        derivative, a column a field, the propagating orders first."""
        beta = np.sqrt(K**2 * index**2 - self.alpha**2 + 0j)
        propagates = (beta.real > 0) & (abs(beta.imag) < 1e-12)
        sign = 1 if up else -1
        rho, vectors = self.eigenvectors(index)
        # Each plane wave, up or down, has an eigenvalue near ±β; the exact wave replaces it.
        free = np.ones(len(rho), bool)
        for value in np.concatenate([beta[propagates], -beta[propagates]]):
            free[np.argmin(np.where(free, abs(rho - value), np.inf))] = False
        chosen = np.flatnonzero(free)
        count = self.size - np.count_nonzero(propagates)
        chosen = chosen[np.argsort(-sign * rho[chosen].imag)][:count]
        fields, rho = vectors[:, chosen], rho[chosen]
        slopes = 1j * (self.c @ (fields * rho) - self.b @ (self.alpha[:, None] * fields))
        waves = [self.plane_wave(a, sign * b) for a, b in zip(self.alpha[propagates], beta[propagates])]
        exact = np.array(waves).reshape(-1, 2, self.size)
        join = lambda i, numeric: np.concatenate([exact[:, i].T, numeric], axis=1)
        return np.flatnonzero(propagates), beta, join(0, fields), join(1, slopes)

    def eigenvectors(self, index):
        """Returns ρ and F of the quadratic eigenproblem."""
        n = self.size
        alpha = self.alpha[:, None]
        m0 = (K * index) ** 2 * self.d - alpha * self.a * self.alpha
        m1 = alpha * self.b + self.b * self.alpha
        linear = np.zeros((2 * n, 2 * n), complex)
        linear[:n, n:] = np.eye(n)
        linear[n:] = np.linalg.solve(self.c, np.concatenate([m0, m1], axis=1))
        rho, vectors = eig(linear, overwrite_a=True, check_finite=False)
        fields = vectors[:n]
        return rho, fields / np.linalg.norm(fields, axis=0)


def flux(field, slope):
    """Returns the power through the profile of a field and its normal derivative, up to the factor of `efficiencies`."""
    return np.sum(field.conj() * slope).imag


def efficiencies(curve, sine, index, size):
    """Returns the efficiencies of `curve` in light of sin θ_i = `sine` that travels toward +x and −z.

    index: refractive index below the profile, complex with a positive imaginary part for metals, None for a perfect conductor; size: number of
    Fourier coefficients.
    """
    space = Curved(curve, sine, size)
    orders, beta, up, up_slope = space.outgoing(1.0, True)
    incident = K * np.sqrt(1 - sine**2)
    down, down_slope = space.plane_wave(K * sine, -incident)
    if index is not None:
        below, _, inside, inside_slope = space.outgoing(index, False)
    reflected, energy = {}, 0.0
    for polarisation, n in [("te", 1.0), ("tm", index)]:
        if index is None:
            boundary = (up, -down) if polarisation == "te" else (up_slope, -down_slope)
            amplitude, lost = np.linalg.solve(*boundary), 0.0
        else:
            system = np.block([[up, -inside], [up_slope, -inside_slope / n**2]])
            amplitude = np.linalg.solve(system, -np.concatenate([down, down_slope]))
            field, slope = inside @ amplitude[size:], inside_slope @ amplitude[size:] / n**2
            lost = -flux(field, slope) / incident
        share = abs(amplitude[: len(orders)]) ** 2 * beta[orders].real / incident
        reflected[polarisation] = share
        energy = max(energy, abs(1 - share.sum() - lost))
    return Efficiencies(space.order[orders], space.alpha[orders] / K, reflected, energy)
