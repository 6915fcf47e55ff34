"""Runs diffract and reads its pictures."""

import os
import subprocess
from pathlib import Path

import mitsuba as mi
import numpy as np

DIFFRACT = os.environ.get("DIFFRACT", str(Path(__file__).parents[2] / "target/release/diffract"))


def diffract(*words, folder="."):
    """Runs a command of diffract in a folder and returns what it prints."""
    run = subprocess.run([DIFFRACT, *map(str, words)], cwd=folder, capture_output=True, text=True)
    if run.returncode != 0:
        raise RuntimeError(f"diffract {' '.join(map(str, words))}: {run.stderr.strip()}")
    return run.stdout


def picture(path):
    """Returns linear sRGB, [row][column][3], and the coverage of an EXR."""
    rgba = np.array(mi.Bitmap(str(path)).convert(mi.Bitmap.PixelFormat.RGBA, mi.Struct.Type.Float32, False))
    return rgba[..., :3], rgba[..., 3]


def relative_l2(found, expected):
    """Returns the error over all colours, as in docs/ACCURACY.md."""
    return np.linalg.norm(found - expected) / np.linalg.norm(expected)
