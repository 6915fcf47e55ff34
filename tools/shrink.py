"""Makes a PNG small enough for a page: `python shrink.py FROM TO`. Needs Pillow (Debian: python3-pil).

Figures, which are drawn for print, are scaled to WIDTH, and get a palette of 256 colours where they are still larger than FIGURE_BYTES. Other pictures of more
than BYTES keep their colours: a picture of a scene is scaled to half its size, one of the window, whose background is opaque, to three quarters.
"""

import os
import shutil
import sys

try:
    from PIL import Image
except ImportError:
    sys.exit("shrink: Pillow is missing; apt-get install python3-pil")

WIDTH = 960
FIGURE_BYTES = 450_000
BYTES = 300_000
# Pictures of scenes and of the window are no wider than this, figures are.
WIDEST_SCENE = 1280


def scaled(picture: Image.Image, width: int) -> Image.Image:
    height = round(picture.height * width / picture.width)
    # Colours of transparent pixels must not leak into the edges.
    if "A" in picture.getbands():
        return picture.convert("RGBa").resize((width, height), Image.Resampling.LANCZOS).convert("RGBA")
    return picture.resize((width, height), Image.Resampling.LANCZOS)


def main(source: str, target: str) -> None:
    picture = Image.open(source)
    if os.path.getsize(source) <= BYTES and picture.width <= WIDEST_SCENE:
        shutil.copyfile(source, target)
        return
    if picture.width > WIDEST_SCENE:
        picture = scaled(picture.convert("RGB"), WIDTH)
        picture.save(target, optimize=True)
        if os.path.getsize(target) > FIGURE_BYTES:
            picture.quantize(256, kmeans=8, dither=Image.Dither.FLOYDSTEINBERG).save(target, optimize=True)
        return
    width = picture.width // 2 if "A" in picture.getbands() else picture.width * 3 // 4
    scaled(picture, width).save(target, optimize=True)


main(*sys.argv[1:])
