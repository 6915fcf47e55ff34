"""Measures what changes of scalar theory would bring, from the orders that `table.py --work DIR` kept: `python alternatives.py DIR`.

Prints medians over sinusoids of the grid, of the share of the diffracted light that is put elsewhere [%].
"""

import sys
from pathlib import Path

import numpy as np

import grid
import scalar
import table


# Heights of the sinusoids [wavelengths].
HEIGHTS = [0.1, 0.35]


def lit(curve, sine):
    """Returns which points of a curve a plane wave reaches without crossing the curve; light of sin θ = `sine` travels toward +x."""
    if sine == 0:
        return np.ones(len(curve.x), bool)
    cot = np.sqrt(1 - sine**2) / sine
    n, x = len(curve.x), np.concatenate([curve.x + repeat * curve.period for repeat in range(3)])
    # The height above the ray through the origin, in the order in which light meets the points.
    level = np.tile(curve.z, 3) + cot * x
    if sine > 0:
        return (level >= np.maximum.accumulate(level) - 1e-12)[-n:]
    return (level[::-1] >= np.maximum.accumulate(level[::-1]) - 1e-12)[::-1][:n]


def with_shadows(curve, sine, index, orders):
    """Returns the mean shares of scalar theory over those parts of the profile that are lit and seen."""
    out = sine + orders / curve.period
    plain = scalar.shares(curve, sine, index, orders)["mean"]
    masked = np.empty(len(orders))
    for n, (order, s) in enumerate(zip(orders, out)):
        w = np.sqrt(1 - sine**2) + np.sqrt(1 - s**2)
        phase = np.exp(-1j * scalar.K * (w * curve.z + order / curve.period * curve.x)) * curve.dx
        # An order toward +x is seen as light from +x would be lit.
        mask = lit(curve, sine) & lit(curve, -s)
        whole = abs(np.mean(phase)) ** 2
        masked[n] = abs(np.mean(phase * mask)) ** 2 / max(whole, 1e-300)
    return plain * masked


def with_root_of_both(curve, sine, index, orders):
    """Returns the mean shares with R = √(R(θ_i) R(θ_r)) instead of R at the half vector."""
    out = sine + orders / curve.period
    one_plus = 1 + np.sqrt(1 - sine**2) * np.sqrt(1 - out**2) - sine * out
    half = scalar.fresnel(index, np.sqrt(one_plus / 2))
    there, back = scalar.fresnel(index, np.sqrt(1 - sine**2)), scalar.fresnel(index, np.sqrt(1 - out**2))
    shares = scalar.shares(curve, sine, index, orders)
    return sum(shares[p] * np.sqrt(there[n] * back[n]) / half[n] for n, p in enumerate(["te", "tm"])) / 2


def misplaced(found, predicted, polarisation):
    """Returns the share of the diffracted light of `polarisation` that `predicted` puts elsewhere, in percent; None without light."""
    counts = (np.sqrt(1 - found.sine**2) >= table.SMALLEST_COSINE) & (found.order != 0)
    rigorous = found.rigorous[polarisation][counts]
    return 100 * np.sum(abs(predicted[counts] - rigorous)) / rigorous.sum() if rigorous.sum() > 0 else None


def main():
    folder = Path(sys.argv[1])
    print("| material | period/λ | θ_i | TE by mean R | by R of TE | TM by mean R | by R of TM | mean | with shadows | with √(R R) |")
    print("| --- | --- | ---: |" + " ---: |" * 7)
    for material, index in grid.MATERIALS.items():
        for shortest, longest in [(0.7, 2.2), (3.3, 8.0), (12.5, 20.0)]:
            for angle in grid.ANGLES[1:]:
                columns = []
                for point in grid.points():
                    chosen = (point.kind, point.material, point.angle) == ("sinusoid", material, angle) and point.height in HEIGHTS
                    if not chosen or not shortest <= point.period <= longest:
                        continue
                    for found in table.orders_of(point, folder) or []:
                        sine = found.sine[found.order == 0][0]
                        curve = grid.curves(point)[0]
                        arguments = (curve, sine, index, found.order)
                        ways = [("mean", "te"), ("te", "te"), ("mean", "tm"), ("tm", "tm"), ("mean", "mean")]
                        errors = [misplaced(found, found.scalar[a], b) for a, b in ways]
                        errors += [misplaced(found, way(*arguments), "mean") for way in [with_shadows, with_root_of_both]]
                        columns += [errors] if None not in errors else []
                medians = np.median(columns, axis=0)
                print(f"| {material} | {shortest} to {longest} | {angle}° | " + " | ".join(f"{m:.1f}" for m in medians) + " |")


if __name__ == "__main__":
    main()
