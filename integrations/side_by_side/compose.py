"""Prints how far the pictures are from those of diffract, and puts them side by side: compose.py FOLDER"""

import pathlib
import sys

import numpy as np
import view
from PIL import Image, ImageDraw, ImageFont

NAMES = {"diffract": "diffract", "three": "three.js", "wgpu": "WGSL in wgpu", "nodes": "Cycles, nodes", "osl": "Cycles, OSL", "mitsuba": "Mitsuba"}
# Of a displayed picture: linear radiance that is white, background, gap and height of the letters [pixels].
WHITE, BACKGROUND, GAP, LETTERS = 1.7, 0.1, 10, 15

folder = pathlib.Path(sys.argv[1])


def blocks(picture):
    return picture.reshape(view.SIZE // 4, 4, view.SIZE // 4, 4, -1).mean((1, 3))


def off(found, ours):
    """Returns relative L2 over means of 4 x 4 pixels that both cover, of the picture and of its mirror image."""
    inside = ((ours[..., 3] > 0.999) & (found[..., 3] > 0.5))[..., None]
    a, b = (blocks(np.where(inside, picture[..., :3], 0)) for picture in (found, ours))
    return [np.linalg.norm(x - b) / np.linalg.norm(b) for x in (a, a[:, ::-1])]


def displayed(picture):
    linear = np.clip(picture[..., :3] / WHITE, 0, 1)
    srgb = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    return Image.fromarray((np.clip(srgb + (1 - np.clip(picture[..., 3:], 0, 1)) * BACKGROUND, 0, 1) * 255 + 0.5).astype(np.uint8))


step = view.SIZE + GAP
sheet = Image.new("RGB", (GAP + len(NAMES) * step, 2 * step + 2 * GAP + LETTERS), "white")
font = ImageFont.load_default(LETTERS)
for row, shape in enumerate(("sphere", "knot")):
    ours = np.load(folder / f"diffract-{shape}.npy")
    for column, (key, name) in enumerate(NAMES.items()):
        found = np.load(folder / f"{key}-{shape}.npy").astype(float)
        print(f"{shape}, {name}: {{:.4f}}, mirrored {{:.2f}}".format(*off(found, ours)))
        at = (GAP + column * step, 2 * GAP + LETTERS + row * step)
        sheet.paste(displayed(found), at)
        ImageDraw.Draw(sheet).text((at[0], GAP // 2), name, fill=(20, 20, 20), font=font)
    positive = np.dstack([np.maximum(ours[..., :3], 0), ours[..., 3]])
    print(f"{shape}, EEVEE, from the picture without negative components: {off(np.load(folder / f'eevee-{shape}.npy').astype(float), positive)[0]:.4f}")
sheet.save(folder / "elsewhere.png")
