"""Points of the table, and their orders by the rigorous solver and by scalar theory.

Lengths are in wavelengths. `solve` doubles the number of Fourier coefficients until the shares of the orders keep, and tells by how much they
changed; a point that does not settle is left out.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

import scalar
from cmethod import efficiencies
from elaphe import rough
from profiles import blaze, lamellar, sinusoid

# Aluminium at 550 nm (Rakić 1995); the refractive index of the default material.
MATERIALS = {"metal": 0.958 + 6.69j, "dielectric": 1.5}
PERIODS = [0.7, 1.05, 1.5, 1.8, 2.2, 2.7, 3.3, 4.1, 5.0, 6.3, 8.0, 10.0, 12.5, 20.0]
# Waves in a metal fall by e^(−2πkH) over the height H: beyond 0.8 they leave the range of 64-bit floats.
HEIGHTS = {"metal": [0.05, 0.1, 0.2, 0.35, 0.6, 0.8], "dielectric": [0.05, 0.1, 0.2, 0.35, 0.6, 1.0]}
ANGLES = [0, 30, 45, 60, 75]
# Up to this period two directions, so many degrees to both sides, are averaged over: with few orders, single directions meet narrow resonances
# (Wood's anomalies).
SPREAD, LONGEST_SPREAD = 2, 5.0
# Random profiles: the height is that of a sinusoid of the same RMS.
ROUGH_PERIODS = [0.8, 1.1, 1.5, 3.0]
ROUGH_HEIGHTS = [0.1, 0.2, 0.3, 0.4]
ROUGH_ANGLES = [0, 45, 60, 75]
MEMBERS = 10
# The number of coefficients is doubled for one profile of an ensemble in so many, and serves the others.
JUDGED = 5
# Largest height over period.
STEEPEST, ROUGH_STEEPEST = 0.6, 0.35
# Allowed change of a share over all reflected light, and of the energy, when the number of coefficients doubles.
TOLERANCE, ROUGH_TOLERANCE = 5e-4, 2e-3
# Fourier coefficients beyond those of the orders that propagate in the denser medium, at first; the most in all.
EXTRA, MOST = 20, 330


@dataclass(frozen=True)
class Point:
    """A grating, or an ensemble of profiles, in light of one direction."""

    kind: str
    material: str
    period: float
    height: float
    angle: float


@dataclass(frozen=True)
class Orders:
    """Rigorous orders of a point: numbers, sines, shares {"te", "tm", "mean"}, the change by doubling and the error of the energy, both over the
    reflected light. Of an ensemble the shares are means over it."""

    order: np.ndarray
    sine: np.ndarray
    rigorous: dict
    change: float
    energy: float


def points():
    """Returns the points of the table."""
    found = []
    for kind, (material, heights) in product(["sinusoid", "blaze", "lamellar"], HEIGHTS.items()):
        grid = product(PERIODS, heights, ANGLES)
        found += [Point(kind, material, p, h, a) for p, h, a in grid if h <= STEEPEST * p]
    for material in MATERIALS:
        grid = product(ROUGH_PERIODS, ROUGH_HEIGHTS, ROUGH_ANGLES)
        found += [Point("rough", material, p, h, a) for p, h, a in grid if h <= ROUGH_STEEPEST * p]
    return found


def length_of_rough(period):
    """Returns the length of random profiles: eight periods, fewer where they are long, because costs grow as its cube."""
    return max(min(8 * period, 16.0), 4 * period)


def solve(curve, sine, index, tolerance):
    """Returns orders of `curve` and the number of coefficients that sufficed, half that of the orders; None where doubling the number up to `MOST`
    does not settle them."""
    size = 2 * int(np.ceil(1.5 * curve.period)) + 1 + EXTRA
    found = efficiencies(curve, sine, index, size)
    while 2 * size <= MOST:
        before, found = found, efficiencies(curve, sine, index, 2 * size)
        total = min(share.sum() for share in found.reflected.values())
        change = max(abs(found.reflected[p] - before.reflected[p]).max() for p in ["te", "tm"]) / total
        if max(change, found.energy / total) <= tolerance:
            return with_mean(found, change), size
        size *= 2
    return None


def with_mean(found, change):
    """Returns rigorous orders with the mean of both polarisations."""
    total = min(share.sum() for share in found.reflected.values())
    rigorous = dict(found.reflected, mean=(found.reflected["te"] + found.reflected["tm"]) / 2)
    return Orders(found.orders, found.sine, rigorous, change, found.energy / total)


def curves(point):
    """Returns the profiles of a point."""
    if point.kind == "rough":
        length = length_of_rough(point.period)
        return [rough(point.period, point.height, length, seed) for seed in range(MEMBERS)]
    profile = {"sinusoid": sinusoid, "blaze": blaze, "lamellar": lamellar}[point.kind]
    return [profile(point.period, point.height)]


def directions(point):
    """Returns sin θ_i of the directions of light that a point averages over. A blaze is lit from both sides."""
    both = point.kind == "blaze" and point.angle > 0
    if point.kind == "rough" or point.period > LONGEST_SPREAD:
        angles = [point.angle, -point.angle] if both else [point.angle]
    else:
        angles = [point.angle - SPREAD, (point.angle + SPREAD) * (-1 if both else 1)]
    return list(np.sin(np.radians(angles)))


def orders(point):
    """Returns the rigorous orders of a point: a list over the directions of light, of the mean over an ensemble; None where a profile does not settle."""
    profiles, index = curves(point), MATERIALS[point.material]
    tolerance = ROUGH_TOLERANCE if point.kind == "rough" else TOLERANCE
    found = []
    for sine in directions(point):
        judged = [solve(curve, sine, index, tolerance) for curve in profiles[::JUDGED]]
        if None in judged:
            return None
        members = [member for member, _ in judged]
        size = max(size for _, size in judged)
        others = [curve for i, curve in enumerate(profiles) if i % JUDGED]
        members += [with_mean(efficiencies(curve, sine, index, size), 0.0) for curve in others]
        found.append(mean(members))
    return found


def mean(members):
    """Returns the mean over the orders of an ensemble."""
    first = members[0]
    rigorous = {p: np.mean([m.rigorous[p] for m in members], axis=0) for p in scalar.POLARISATIONS}
    worst = [max(getattr(m, name) for m in members) for name in ["change", "energy"]]
    return Orders(first.order, first.sine, rigorous, *worst)


def predicted(point, directions, shares):
    """Returns shares of the orders of a point by scalar theory, a dictionary for each direction of light: means over an ensemble of
    `shares`(curve, sine, index, orders)."""
    profiles, index = curves(point), MATERIALS[point.material]
    found = []
    for orders in directions:
        sine = orders.sine[orders.order == 0][0]
        members = [shares(curve, sine, index, orders.order) for curve in profiles]
        found.append({p: np.mean([member[p] for member in members], axis=0) for p in scalar.POLARISATIONS})
    return found
