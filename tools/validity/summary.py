"""Prints the tables of docs/VALIDITY.md from `assets/validity/table.csv`: `python summary.py [THEORY]`."""

import csv
import sys

import grid
import table

# Height of the gratings that are shown [wavelengths].
HEIGHT = 0.2
# Periods that are shown [wavelengths].
PERIODS = [0.7, 1.05, 1.5, 2.2, 3.3, 5.0, 8.0, 12.5, 20.0]


def main():
    theory = sys.argv[1] if len(sys.argv) > 1 else "small-slope"
    mean, rows = table.column(theory, "mean"), {}
    for r in csv.DictReader(table.TABLE.open()):
        rows[r["kind"], r["material"], *(float(r[name]) for name in ["period", "height", "angle"])] = float(r[mean])

    def cell(*point):
        errors = [rows.get((*point, float(angle))) for angle in grid.ROUGH_ANGLES]
        return " / ".join("–" if e is None else f"{e:.2g}" if e < 99.5 else f"{e:.0f}" for e in errors)

    print("| | " + " | ".join(f"{p}" for p in PERIODS) + " |\n| --- |" + " --- |" * len(PERIODS))
    for kind in ["sinusoid", "blaze", "lamellar"]:
        for material in grid.MATERIALS:
            print(f"| {kind}, {material} | " + " | ".join(cell(kind, material, p, HEIGHT) for p in PERIODS) + " |")
    print("\n| | " + " | ".join(f"{h}" for h in grid.ROUGH_HEIGHTS) + " |\n| --- |" + " --- |" * len(grid.ROUGH_HEIGHTS))
    for material in grid.MATERIALS:
        for p in grid.ROUGH_PERIODS:
            print(f"| {p} λ, {material} | " + " | ".join(cell("rough", material, p, h) for h in grid.ROUGH_HEIGHTS) + " |")


if __name__ == "__main__":
    main()
