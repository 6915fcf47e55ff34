"""Makes a PNG small enough for a page: `python shrink.py FROM TO`. Needs Pillow (Debian: python3-pil).

Figures, which are drawn for print, are scaled to WIDTH. If a picture is still larger than BYTES, a transparent one is scaled to half its size, and
any other gets a palette of 256 colours.
"""

import os
import shutil
import sys

try:
    from PIL import Image
except ImportError:
    sys.exit("shrink: Pillow is missing; apt-get install python3-pil")

WIDTH = 1280
BYTES = 300_000


def scaled(picture: Image.Image, width: int) -> Image.Image:
    height = round(picture.height * width / picture.width)
    # Colours of transparent pixels must not leak into the edges.
    if "A" in picture.getbands():
        return picture.convert("RGBa").resize((width, height), Image.Resampling.LANCZOS).convert("RGBA")
    return picture.resize((width, height), Image.Resampling.LANCZOS)


def main(source: str, target: str) -> None:
    picture = Image.open(source)
    if os.path.getsize(source) <= BYTES and picture.width <= WIDTH:
        shutil.copyfile(source, target)
        return
    if picture.width > WIDTH:
        picture = scaled(picture, WIDTH)
    picture.save(target, optimize=True)
    if os.path.getsize(target) > BYTES:
        if "A" in picture.getbands():
            picture = scaled(picture, picture.width // 2)
        else:
            picture = picture.convert("RGB").quantize(256, dither=Image.Dither.FLOYDSTEINBERG)
        picture.save(target, optimize=True)


main(*sys.argv[1:])
