"""Prints the tables of decision 24, from the orders that `table.py --work DIR` kept: `python theories.py DIR`.

Both theories, and small slope without and with limits of its energy, against the C method on sinusoids and blazes.
"""

import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

import grid
import scalar
import table

# Ways from Prediction of small slope and of Stam's factor on a perfect conductor to the divisor of f: 1 where nothing is limited.
LIMITS = {
    "none": lambda own, mirror: 1.0,
    "E/R, the larger of both ends": lambda own, mirror: np.maximum(np.maximum(1, own.incident), own.outgoing),
    "E/R of the incident end (not reciprocal)": lambda own, mirror: max(1, own.incident),
    "√ of the product of both ends": lambda own, mirror: np.sqrt(max(1, own.incident) * np.maximum(1, own.outgoing)),
    "product of both ends": lambda own, mirror: max(1, own.incident) * np.maximum(1, own.outgoing),
    "Stam's albedo at R = 1, the larger of both ends": lambda own, mirror: np.maximum(np.maximum(1, mirror.incident), mirror.outgoing),
}
CHOSEN = "E/R, the larger of both ends"
WAYS = ["stam", "none", CHOSEN]
# Bands of periods and heights, and rows of the tables.
ALL_PERIODS = {"0.7 to 1.05 λ": (0.7, 1.05), "1.5 to 2.2 λ": (1.5, 2.2), "2.7 to 5 λ": (2.7, 5.0), "6.3 to 20 λ": (6.3, 20.0)}
ALL_HEIGHTS = {"≤ 0.1 λ": (0.0, 0.1), "0.2 λ": (0.2, 0.2), "0.35 λ": (0.35, 0.35), "≥ 0.6 λ": (0.6, 1.0)}
SHORT, MIDDLE, LONG = ("≤ 1.5 λ", (0.0, 1.5)), ("3.3 to 5 λ", (3.3, 5.0)), ("≥ 10 λ", (10.0, 20.0))
SINGLE = ("1.5 λ", (1.5, 1.5))
LOW, HIGH = ("≤ 0.1 λ", (0.0, 0.1)), ("> 0.1 λ", (0.11, 1.0))
DIFFRACTED = [
    ("dielectric", MIDDLE, 30, "mean"),
    ("dielectric", MIDDLE, 60, "mean"),
    ("dielectric", SINGLE, 60, "mean"),
    ("dielectric", LONG, 60, "mean"),
    ("dielectric", MIDDLE, 75, "mean"),
    ("metal", MIDDLE, 60, "mean"),
    ("metal", SINGLE, 60, "te"),
    ("dielectric", LONG, 60, "tm"),
    ("dielectric", MIDDLE, 60, "tm"),
]
ENERGY = [("metal", SHORT, LOW), ("metal", SHORT, HIGH), ("metal", MIDDLE, HIGH), ("metal", LONG, HIGH)]
ENERGY += [("dielectric", SHORT, LOW), ("dielectric", SHORT, HIGH), ("dielectric", MIDDLE, HIGH), ("dielectric", LONG, HIGH)]
POLARISATIONS = {"mean": "unpolarised light", "te": "TE", "tm": "TM"}


@dataclass(frozen=True)
class Judged:
    """Errors of a point by way: {polarisation: share of the diffracted light put elsewhere}, the share of all reflected light, the sum of orders."""

    point: grid.Point
    diffracted: dict
    whole: dict
    total: dict


def ways_of(curve, sine, index, orders):
    """Returns the shares by every way: {way: {"te", "tm", "mean"}}."""
    predict = partial(scalar.predict, curve=curve, sine=sine, orders=orders)
    own, mirror = predict("small-slope", index=index), predict("stam", index=None)
    found = {name: scalar.limited(own, limit(own, mirror)) for name, limit in LIMITS.items()}
    return found | {"stam": predict("stam", index=index).shares}


def judge(point, directions):
    """Returns the errors of a point."""
    curve, index = grid.curves(point)[0], grid.MATERIALS[point.material]
    found = [ways_of(curve, o.sine[o.order == 0][0], index, o.order) for o in directions]
    diffracted, whole, total = {}, {}, {}
    for way in found[0]:
        shares = [ways[way] for ways in found]
        diffracted[way] = {p: table.misplaced(directions, shares, p) for p in scalar.POLARISATIONS}
        pairs = [(s["mean"], o.rigorous["mean"]) for s, o in zip(shares, directions)]
        whole[way] = np.mean([np.sum(abs(s - r)) / r.sum() for s, r in pairs])
        total[way] = max(s.sum() for s, _ in pairs)
    return Judged(point, diffracted, whole, total)


def chosen(judged, material, periods, heights, angle):
    """Returns the points in a cell."""
    inside = lambda value, band: band[0] <= value <= band[1]
    fits = lambda p: p.material == material and p.angle == angle and inside(p.period, periods) and inside(p.height, heights)
    return [j for j in judged if fits(j.point)]


def percent(value):
    """Returns a share in percent, two digits."""
    value = 100 * value
    return f"{value:.2g}" if value < 99.5 else f"{value:.0f}"


def median(cell, way, polarisation):
    """Returns the median of the share of the diffracted light that is put elsewhere; None without points."""
    errors = [j.diffracted[way][polarisation] for j in cell if j.diffracted[way][polarisation] is not None]
    return np.median(errors) if errors else None


def arrow(values):
    """Returns values in percent with arrows between them; a dash where there are none."""
    return "–" if None in values else " → ".join(percent(v) for v in values)


def print_table(head, numbers, rows):
    """Prints a table of Markdown with `numbers` columns of numbers."""
    print("\n| " + " | ".join(head) + " |\n| " + " | ".join(["---"] * (len(head) - numbers) + ["---:"] * numbers) + " |")
    for row in rows:
        print("| " + " | ".join(row) + " |")


def diffracted_light(judged):
    """Prints medians of the diffracted light that is put elsewhere: Stam → small slope → limited."""
    rows = []
    for material, (name, periods), angle, polarisation in DIFFRACTED:
        cells = []
        for height in grid.HEIGHTS[material][:5]:
            cell = chosen(judged, material, periods, (height, height), angle)
            cells.append(arrow([median(cell, way, polarisation) for way in WAYS]))
        rows.append([f"{material}, {name}, {angle}°, {POLARISATIONS[polarisation]}", *cells])
    print_table(["", *(f"H = {h} λ" for h in grid.HEIGHTS["metal"][:5])], 5, rows)


def cells(judged, polarisation):
    """Prints medians of both theories as the program has them for all cells, bold where small slope loses by a tenth or more, and counts those."""
    rows, lost, count = [], 0, 0
    for material in grid.MATERIALS:
        for (period, periods), (height, heights) in [(p, h) for p in ALL_PERIODS.items() for h in ALL_HEIGHTS.items()]:
            values = [chosen(judged, material, periods, heights, angle) for angle in grid.ANGLES]
            pairs = [[median(cell, way, polarisation) for way in ["stam", CHOSEN]] for cell in values]
            known = [None not in pair for pair in pairs]
            loses = [is_known and pair[1] > max(1.1 * pair[0], pair[0] + 0.001) for is_known, pair in zip(known, pairs)]
            lost, count = lost + sum(loses), count + sum(known)
            if any(known):
                rows.append([material, period, height, *(f"**{arrow(p)}**" if l else arrow(p) for p, l in zip(pairs, loses))])
    print(f"\n{POLARISATIONS[polarisation]}: small slope is worse in {lost} of {count} cells")
    print_table(["material", "period", "height", *(f"{a}°" for a in grid.ANGLES)], len(grid.ANGLES), rows)


def all_orders(judged):
    """Prints means of the reflected light that is put elsewhere, order 0 included: Stam → small slope → limited."""
    rows = []
    for material, (period, periods), (height, heights) in ENERGY:
        means = []
        for angle in grid.ANGLES:
            cell = chosen(judged, material, periods, heights, angle)
            means.append(arrow([np.mean([j.whole[way] for j in cell]) if cell else None for way in WAYS]))
        rows.append([f"{material}, {period}, H {height}", *means])
    print_table(["", *(f"{a}°" for a in grid.ANGLES)], len(grid.ANGLES), rows)


def limits(judged):
    """Prints the mean of the reflected light that each limit puts elsewhere, and the largest sum of orders over all points."""
    rows, angles = [], [0, 30, 60, 75]
    columns = [("metal", SHORT), ("metal", MIDDLE), ("dielectric", SHORT), ("dielectric", MIDDLE)]
    for way in ["stam", *LIMITS]:
        means = []
        for material, (_, periods) in columns:
            parts = [[j.whole[way] for j in chosen(judged, material, periods, HIGH[1], angle)] for angle in angles]
            means.append(" / ".join(percent(np.mean(part)) if part else "–" for part in parts))
        rows.append(["Stam" if way == "stam" else way, *means, f"{max(j.total[way] for j in judged):.2f}"])
    heads = [f"{material}, {period}" for material, (period, _) in columns]
    print("\nH > 0.1 λ, at " + " / ".join(f"{a}°" for a in angles))
    print_table(["limit", *heads, "largest sum"], len(heads) + 1, rows)


def main():
    folder = Path(sys.argv[1])
    points = [p for p in grid.points() if p.kind in ["sinusoid", "blaze"] and table.path_of(p, folder).exists()]
    solved = [(point, table.orders_of(point, folder)) for point in points]
    judged = [judge(point, directions) for point, directions in solved if directions]
    print(f"{len(judged)} points, {sum(len(o.order) for _, d in solved for o in d or [])} orders")
    diffracted_light(judged)
    for polarisation in POLARISATIONS:
        cells(judged, polarisation)
    all_orders(judged)
    limits(judged)


if __name__ == "__main__":
    main()
