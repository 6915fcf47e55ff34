"""Evaluates the rays of in_mitsuba.py by the WGSL of the export in wgpu, and filters them as diffract does: in_wgpu.py FOLDER"""

import pathlib
import sys

import numpy as np
import view

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "wgpu"))
from material import Material, device  # noqa: E402

folder = pathlib.Path(sys.argv[1])
side = 4 * view.SIZE
# A Gaussian of half a pixel, which is two rays.
frequency = np.fft.fftfreq(side)
gaussian = np.exp(-2 * np.pi**2 * 2.0**2 * (frequency[:, None] ** 2 + frequency**2))
material = Material(device(), folder / "skin")
for shape in ("sphere", "knot"):
    rays = np.load(folder / f"rays-{shape}.npz")
    pixels, seen = np.zeros((side * side, 4)), np.flatnonzero(rays["seen"])
    for part in np.array_split(seen, 32):
        pixels[part, :3] = np.pi * material.rgb(rays["light"][part], rays["viewer"][part], np.zeros((len(part), 4)))
    pixels[seen, 3] = 1
    channels = [np.fft.ifft2(np.fft.fft2(channel) * gaussian).real for channel in pixels.T.reshape(4, side, side)]
    # The middle of a pixel lies between its second and its third ray.
    middle = np.stack(channels, -1).reshape(view.SIZE, 4, view.SIZE, 4, 4)[:, 1:3, :, 1:3].mean((1, 3))
    np.save(folder / f"wgpu-{shape}.npy", middle)
