"""Makes a PNG small enough for a page: `python shrink.py FROM TO`. Needs Pillow (Debian: python3-pil).

Figures, which are drawn for print, are scaled to WIDTH; what is still larger than BYTES gets a palette of 256 colours.
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


def main(source: str, target: str) -> None:
    picture = Image.open(source)
    if os.path.getsize(source) <= BYTES and picture.width <= WIDTH:
        shutil.copyfile(source, target)
        return
    if picture.width > WIDTH:
        height = round(picture.height * WIDTH / picture.width)
        picture = picture.resize((WIDTH, height), Image.Resampling.LANCZOS)
    picture.save(target, optimize=True)
    if os.path.getsize(target) > BYTES:
        # Only this method keeps transparent pixels.
        method = Image.Quantize.FASTOCTREE if "A" in picture.getbands() else Image.Quantize.MEDIANCUT
        picture.quantize(256, method=method, dither=Image.Dither.FLOYDSTEINBERG).save(target, optimize=True)


main(*sys.argv[1:])
