"""Draws `docs/images/validity.png`: the table as maps, with the built-in surfaces of diffract and with scans on it. `python figure.py DIFFRACT [NAME=SCAN]...`

A scan is a file with the options that `diffract surface info` needs to read it, and `--illuminant` where its light is not daylight.
"""

import csv
import json
import subprocess
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.colors import LogNorm

import table

PICTURE = Path(__file__).parents[2] / "docs/images/validity.png"
BUILT_IN = ["sinusoid", "blaze", "elaphe", "xenopeltis", "tulip", "brushed", "cd", "dvd"]
# Behind names, which lie over numbers.
PLATE = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1}
KINDS, MATERIALS, ANGLES = ["sinusoid", "blaze", "lamellar", "rough"], ["metal", "dielectric"], [30, 60]


def shape(diffract, words):
    """Returns the kind that the program measures, and period and height in units of the light's mean wavelength, or None."""
    report = subprocess.run([diffract, "surface", "info", *words, "--json"], check=True, capture_output=True).stdout
    theory = json.loads(report)["scalar_theory"]
    grooves, wavelength = theory["grooves"], theory["wavelength_m"]
    return grooves and (grooves["profile"], grooves["period_m"] / wavelength, grooves["height_m"] / wavelength)


def main():
    rows = list(csv.DictReader(table.TABLE.open()))
    surfaces = {name: shape(sys.argv[1], [name]) for name in BUILT_IN}
    scans = [argument.split("=", 1) for argument in sys.argv[2:]]
    surfaces |= {name: shape(sys.argv[1], words.split()) for name, words in scans}
    print("\n".join(f"{name}: {found}" for name, found in surfaces.items()))
    figure, axes = plt.subplots(len(KINDS), 4, figsize=(16, 12), layout="constrained", sharex=True, sharey=True)
    for row, kind in zip(axes, KINDS):
        for panel, (material, angle) in zip(row, [(m, a) for m in MATERIALS for a in ANGLES]):
            at = 45 if kind == "rough" and angle == 30 else angle
            chosen = [r for r in rows if (r["kind"], r["material"], float(r["angle"])) == (kind, material, at)]
            x, y, error = (np.array([float(r[name]) for r in chosen]) for name in ["period", "height", table.column("small-slope", "mean")])
            norm = LogNorm(1, 100)
            dots = panel.scatter(x, y, c=np.clip(error, 1, 100), norm=norm, cmap="viridis", marker="s", s=110)
            for px, py, e in zip(x, y, error):
                light = e > 25
                panel.text(px, py, f"{e:.0f}" if e < 999 else ">", ha="center", va="center", fontsize=6, color="black" if light else "white")
            for name, found in surfaces.items():
                if found and found[0] == kind:
                    panel.plot(*found[1:], "r+", markersize=10)
                    panel.annotate(name, found[1:], color="red", fontsize=7, xytext=(4, 8), textcoords="offset points", bbox=PLATE)
            panel.set(xscale="log", yscale="log", title=f"{kind}, {material}, {at}°")
    figure.supxlabel("period / λ")
    figure.supylabel("height / λ")
    figure.colorbar(dots, ax=axes, label="diffracted light that scalar theory puts elsewhere [%]", shrink=0.5)
    figure.savefig(PICTURE, dpi=90)


if __name__ == "__main__":
    main()
