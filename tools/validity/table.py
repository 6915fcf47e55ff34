"""Computes `assets/validity/table.csv`: errors of scalar theory against the C method. `python table.py --help`.

The error of a point is the share of the diffracted light that scalar theory puts elsewhere, Σ |s − r| / Σ r over the orders but 0 with scalar and
rigorous shares s and r: the mean of the orders' relative errors, weighted by their light. TE, TM, and the mean of both, which unpolarised light has.
"""

import argparse
import csv
import pickle
import random
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

import grid

TABLE = Path(__file__).parents[2] / "assets/validity/table.csv"
# Orders nearer to the surface than this cosine are left out, as in docs/EFFICIENCY.md.
SMALLEST_COSINE = 0.25
COLUMNS = "kind,material,period,height,angle,mean,te,tm,specular,change,energy"


def errors(directions, polarisation):
    """Returns the relative errors of the diffracted orders of `grid.orders` and the share of the diffracted light in each."""
    relative, light = [], []
    for found in directions:
        counts = (np.sqrt(1 - found.sine**2) >= SMALLEST_COSINE) & (found.order != 0)
        rigorous = found.rigorous[polarisation][counts]
        relative.append(abs(found.scalar[polarisation][counts] / rigorous - 1))
        light.append(rigorous / max(rigorous.sum(), 1e-300))
    light = [share / sum(len(l) > 0 for l in light) for share in light]
    return np.concatenate(relative), np.concatenate(light)


def row(point, directions):
    """Returns the row of a point, errors in percent; None where no order is diffracted."""
    if errors(directions, "mean")[1].size == 0:
        return None
    means = [np.sum(np.multiply(*errors(directions, p))) for p in ["mean", "te", "tm"]]
    zero = [found.order == 0 for found in directions]
    specular = max(abs(f.scalar["mean"][z] / f.rigorous["mean"][z] - 1)[0] for f, z in zip(directions, zero))
    percent = [f"{100 * value:.3g}" for value in [*means, specular]]
    checks = [f"{max(getattr(f, name) for f in directions):.0e}" for name in ["change", "energy"]]
    return [point.kind, point.material, *(f"{v:g}" for v in [point.period, point.height, point.angle]), *percent, *checks]


def orders_of(point, folder):
    """Returns `grid.orders(point)`, kept in `folder` if there is one."""
    path = folder and folder / f"{point.kind}-{point.material}-{point.period}-{point.height}-{point.angle}.pickle"
    if path and path.exists():
        return pickle.loads(path.read_bytes())
    found = grid.orders(point)
    if path:
        path.write_bytes(pickle.dumps(found))
    return found


def verify(count, jobs):
    """Computes `count` random points again and compares their rows with those of the table."""
    rows = {tuple(row[:5]): row[5:] for row in csv.reader(TABLE.open())}
    points = random.Random(1).sample(grid.points(), count)
    largest, missing = 0.0, 0
    with ProcessPoolExecutor(jobs) as pool:
        for point, directions in zip(points, pool.map(grid.orders, points)):
            fields = directions and row(point, directions)
            kept = rows.get((point.kind, point.material, *(f"{v:g}" for v in [point.period, point.height, point.angle])))
            if bool(fields) != bool(kept):
                missing += 1
                print(f"{point}: {fields} instead of {kept}")
            elif fields:
                # Of the diffracted light, in percent; three digits are kept.
                pairs = [(float(a), float(b)) for a, b in zip(fields[5:8], kept[:3])]
                largest = max(largest, max(abs(a - b) / max(1.0, abs(b)) for a, b in pairs))
    print(f"{count} points: errors differ by at most {largest:.1e} of their value or of 1 %; {missing} are in one of both alone")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("-o", "--output", type=Path, default=TABLE)
    parser.add_argument("--jobs", type=int, default=1, help="processes")
    parser.add_argument("--work", type=Path, help="folder that keeps the orders of each point, so that a stopped run goes on")
    parser.add_argument("--verify", type=int, metavar="N", help="compute N random points again and compare them with the table instead")
    arguments = parser.parse_args()
    if arguments.verify:
        return verify(arguments.verify, arguments.jobs)
    if arguments.work:
        arguments.work.mkdir(parents=True, exist_ok=True)
    points, lines, left_out = grid.points(), [COLUMNS], 0
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
