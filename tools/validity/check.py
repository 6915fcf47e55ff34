"""Compares the errors that `diffract surface info` looks up for gratings outside of the grid with those of the solver. `python check.py --help`.

Both are means over the wavelengths of daylight, as a picture has them. The material is that of the table at every wavelength.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

# The matrices are small: threads wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import grid
import scalar
import table

# Kind, material, period and height in wavelengths: drawn at random, evenly in the logarithms, more than 6 % from the periods of the grid.
GRATINGS = [
    ("sinusoid", "metal", 1.6, 0.2),
    ("sinusoid", "metal", 4.4, 0.41),
    ("sinusoid", "dielectric", 1.6, 0.11),
    ("sinusoid", "dielectric", 5.5, 0.22),
    ("blaze", "metal", 8.7, 0.22),
    ("blaze", "dielectric", 1.6, 0.38),
    ("blaze", "dielectric", 3.7, 0.38),
    ("lamellar", "metal", 6.8, 0.28),
    ("lamellar", "dielectric", 2.0, 0.12),
    ("lamellar", "dielectric", 14.3, 0.48),
]
# Wavelength in which periods and heights are given [µm].
WAVELENGTH = 0.55
# Number of wavelengths that the solver gets: middles of equal shares of the light, by S (x̄ + ȳ + z̄) of daylight.
WAVELENGTHS = 16
SPECTRA = Path(__file__).parents[2] / "assets/spectra"
# Errors below this count as this, as in the look-up.
SMALLEST = 0.01
OPTIONS = {"metal": ["--material", "aluminium"], "dielectric": []}


def looked_up(diffract, theory, kind, material, period, height):
    """Returns {angle: error} of `theory` that the program tells of a height field of the grating."""
    curve = grid.curves(grid.Point(kind, material, period, height, 0))[0]
    repeats, columns, rows = 8, 1024, 16
    spacing = repeats * period / columns
    x = (np.arange(columns) + 0.5) * spacing
    profile = np.interp(x, curve.x, curve.z, period=period) * WAVELENGTH * 1e-6
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "grating.npy"
        np.save(path, np.tile(profile, (rows, 1)))
        pixel = f"{spacing * WAVELENGTH * 1e3}nm"
        command = [diffract, "surface", "info", path, "--pixel-size", pixel, "--json", "--theory", theory, *OPTIONS[material]]
        found = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)["scalar_theory"]
    if not found["grooves"] or found["grooves"]["profile"] != kind:
        print(f"{kind}: {found['line']}", file=sys.stderr)
    return {error["angle_deg"]: error["mean"] for error in found["errors"]}


def wavelengths():
    """Returns the wavelengths that the solver gets [µm]."""
    observer, power = (np.loadtxt(SPECTRA / name, delimiter=",", skiprows=1) for name in ["cie-1931-2deg.csv", "d65.csv"])
    nanometres = np.arange(380.0, 781.0)
    weight = sum(np.interp(nanometres, observer[:, 0], observer[:, i]) for i in [1, 2, 3])
    light = np.cumsum(weight * np.interp(nanometres, power[:, 0], power[:, 1]))
    return np.interp((np.arange(WAVELENGTHS) + 0.5) / WAVELENGTHS, light / light[-1], nanometres + 0.5) / 1e3


def solved(folder, theory, kind, material, period, height, angle):
    """Returns the error of `theory` that the solver gives in daylight; None where it does not settle."""
    found = []
    for wavelength in wavelengths():
        scale = WAVELENGTH / wavelength
        point = grid.Point(kind, material, period * scale, height * scale, angle)
        directions = table.orders_of(point, folder)
        if directions is None:
            return None
        found.append(table.misplaced(directions, table.by_theory(point, directions, theory), "mean"))
    return float(np.mean(found))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("diffract", help="the program")
    parser.add_argument("--theory", choices=scalar.THEORIES, default="small-slope")
    parser.add_argument("--work", type=Path, help="folder that keeps the solver's orders")
    arguments = parser.parse_args()
    if arguments.work:
        arguments.work.mkdir(parents=True, exist_ok=True)
    angles = grid.ANGLES
    print("| grating | material | period/λ | height/λ | " + " | ".join(f"{a}°" for a in angles) + " |")
    print("| --- | --- | ---: | ---: |" + " ---: |" * len(angles))
    within = total = gratings = 0
    for kind, material, period, height in GRATINGS:
        told = looked_up(arguments.diffract, arguments.theory, kind, material, period, height)
        cells, hits = [], []
        for angle in angles:
            error = solved(arguments.work, arguments.theory, kind, material, period, height, angle)
            if error is None or angle not in told:
                cells.append("not known")
                continue
            ratio = told[angle] / max(error, SMALLEST)
            hits.append(0.5 <= ratio <= 2)
            cells.append(f"{100 * told[angle]:.1f} / {100 * error:.1f}" + ("" if hits[-1] else " *"))
        within, total, gratings = within + sum(hits), total + len(hits), gratings + all(hits)
        print(f"| {kind} | {material} | {period} | {height} | " + " | ".join(cells) + " |")
    print(f"\nLook-up / solver, %. Within a factor of two: {within} of {total} points, all angles of {gratings} of {len(GRATINGS)} gratings.")


if __name__ == "__main__":
    main()
