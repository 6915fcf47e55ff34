"""Answers the directions of an export by its WGSL function in wgpu: evaluate.py FOLDER [-o ANSWERS.csv]"""

import argparse
from pathlib import Path

import numpy as np

from material import STANDARD_FRAME, Material, device


def directions(folder):
    """Returns light, viewer, footprint and the colours of the table of conformance.csv."""
    rows = np.genfromtxt(Path(folder) / "conformance.csv", delimiter=",", skip_header=1)
    return rows[:, 0:3], rows[:, 3:6], rows[:, 6:10], rows[:, 13:16]


def answers(gpu, folder, frame=STANDARD_FRAME):
    """Returns the colours by wgpu, and their relative L2 from those of the table."""
    light, viewer, footprint, table = directions(folder)
    found = Material(gpu, folder, frame).rgb(light, viewer, footprint)
    return found, np.linalg.norm(found - table) / np.linalg.norm(table)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", help="folder that `diffract export` wrote")
    parser.add_argument("-o", "--output", help="file for the answers, which `diffract export --check FOLDER --answers FILE` judges")
    arguments = parser.parse_args()
    gpu = device()
    found, off = answers(gpu, arguments.folder)
    if arguments.output:
        np.savetxt(arguments.output, found, "%.9g", ",", header="r,g,b", comments="")
    about = gpu.adapter.info
    print(f"{len(found)} directions on {about['device']} ({about['backend_type']}): relative L2 from the table {off:.2e}")


if __name__ == "__main__":
    main()
