"""Computes `assets/validity/table.csv`: errors of scalar theory against the C method. `python table.py --help`.

The error of a point is the share of the diffracted light that scalar theory puts elsewhere, Σ |s − r| / Σ r over the orders but 0 with scalar and
rigorous shares s and r: the mean of the orders' relative errors, weighted by their light. The mean of TE and TM, which unpolarised light has, TE and
TM; `specular` is the relative error of order 0. Both theories of the program have their columns.
"""

import argparse
import csv
import pickle
import random
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

import grid
import scalar

TABLE = Path(__file__).parents[2] / "assets/validity/table.csv"
POINT = ["kind", "material", "period", "height", "angle"]
ERRORS = ["mean", "te", "tm", "specular"]
CHECKS = ["change", "energy"]


def column(theory, name):
    """Returns the name of the column of an error."""
    return f"{theory.replace('-', '_')}_{name}"


COLUMNS = [*POINT, *(column(theory, name) for theory in scalar.THEORIES for name in ERRORS), *CHECKS]


def by_theory(point, directions, theory):
    """Returns the shares of the orders of a point by a theory: a dictionary for each direction."""
    return grid.predicted(point, directions, lambda *arguments: scalar.shares(theory, *arguments))


def misplaced(directions, shares, polarisation):
    """Returns the share of the diffracted light of `grid.orders` that `shares` puts elsewhere, the mean over the directions of light; None where no
    order is diffracted."""
    found = []
    for orders, predicted in zip(directions, shares):
        diffracted = orders.order != 0
        rigorous = orders.rigorous[polarisation][diffracted]
        if rigorous.size > 0:
            found.append(np.sum(abs(predicted[polarisation][diffracted] - rigorous)) / max(rigorous.sum(), 1e-300))
    return np.mean(found) if found else None


def specular(directions, shares):
    """Returns the relative error of order 0 in unpolarised light, the largest of the directions."""
    zero = [orders.order == 0 for orders in directions]
    return max(abs(s["mean"][z] / o.rigorous["mean"][z] - 1)[0] for o, s, z in zip(directions, shares, zero))


def fields_of(point):
    """Returns the first fields of the row of a point, which tell points apart."""
    return [point.kind, point.material, *(f"{v:g}" for v in [point.period, point.height, point.angle])]


def row(point, directions):
    """Returns the row of a point, errors in percent; None where no order is diffracted."""
    errors = []
    for theory in scalar.THEORIES:
        shares = by_theory(point, directions, theory)
        found = [misplaced(directions, shares, p) for p in ["mean", "te", "tm"]]
        if None in found:
            return None
        errors += [*found, specular(directions, shares)]
    checks = [f"{max(getattr(orders, name) for orders in directions):.0e}" for name in CHECKS]
    return [*fields_of(point), *(f"{100 * error:.3g}" for error in errors), *checks]


def path_of(point, folder):
    """Returns the file in `folder` that keeps the orders of a point."""
    return folder / f"{point.kind}-{point.material}-{point.period}-{point.height}-{point.angle}.pickle"


def orders_of(point, folder):
    """Returns `grid.orders(point)`, kept in `folder` if there is one."""
    path = folder and path_of(point, folder)
    if path and path.exists():
        return pickle.loads(path.read_bytes())
    found = grid.orders(point)
    if path:
        path.write_bytes(pickle.dumps(found))
    return found


def verify(count, jobs):
    """Computes `count` random points again and compares their rows with those of the table."""
    rows = {tuple(row[: len(POINT)]): row for row in csv.reader(TABLE.open())}
    compared = [i for i, name in enumerate(COLUMNS) if name.endswith(("_mean", "_te", "_tm"))]
    points = random.Random(1).sample(grid.points(), count)
    largest, missing = 0.0, 0
    with ProcessPoolExecutor(jobs) as pool:
        for point, directions in zip(points, pool.map(grid.orders, points)):
            fields = directions and row(point, directions)
            kept = rows.get(tuple(fields_of(point)))
            if bool(fields) != bool(kept):
                missing += 1
                print(f"{point}: {fields} instead of {kept}")
            elif fields:
                # Of the diffracted light, in percent; three digits are kept.
                pairs = [(float(fields[i]), float(kept[i])) for i in compared]
                largest = max(largest, max(abs(a - b) / max(1.0, abs(b)) for a, b in pairs))
    print(f"{count} points: errors differ by at most {largest:.1e} of their value or of 1 %; {missing} are in one of both alone")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=TABLE)
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--work", type=Path, help="folder that keeps the orders of each point, so that a stopped run goes on")
    parser.add_argument("--kept", action="store_true", help="write the rows of the points that --work has, and compute none")
    parser.add_argument("--verify", type=int, metavar="N", help="compute N random points again and compare them with the table instead")
    arguments = parser.parse_args()
    if arguments.verify:
        return verify(arguments.verify, arguments.jobs)
    if arguments.work:
        arguments.work.mkdir(parents=True, exist_ok=True)
    points, lines, left_out = grid.points(), [",".join(COLUMNS)], 0
    if arguments.kept:
        points = [point for point in points if path_of(point, arguments.work).exists()]
    with ProcessPoolExecutor(arguments.jobs) as pool:
        results = pool.map(orders_of, points, [arguments.work] * len(points))
        for i, (point, directions) in enumerate(zip(points, results)):
            fields = directions and row(point, directions)
            left_out += directions is None
            lines += [",".join(fields)] if fields else []
            if i % 50 == 49:
                print(f"{i + 1} of {len(points)} points", flush=True)
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    arguments.output.write_text("\n".join(lines) + "\n")
    print(f"{arguments.output}: {len(lines) - 1} points; {left_out} did not settle and are left out")


if __name__ == "__main__":
    main()
