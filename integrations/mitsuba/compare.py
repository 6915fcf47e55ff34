"""Draws one plate by diffract, by Mitsuba and by a browser, and tells their differences: `python compare.py [PICTURE]`. Needs Chromium."""

import re
import subprocess
import sys
import tempfile
from math import asin, atan, atan2, cos, degrees, hypot, sin
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")

import diffract_bsdf  # noqa: E402, F401
import first_hit  # noqa: E402
import scenes  # noqa: E402
import tone  # noqa: E402
from program import diffract, picture, relative_l2  # noqa: E402

SIDE = 240
OPTICS = ["--coherence", "gaussian:8um", "--tolerance", "2e-2"]
# Camera of the page: its distance, a factor of it, and its focal length, for a plate of half a side 0.86.
PITCH, NEARER, FIELD_OF_VIEW = -0.5, 0.6, degrees(2 * atan(1 / 3.2))
DISTANCE = NEARER * 4.75 * 0.5 / 0.86
EYE = [0.0, DISTANCE * sin(PITCH), DISTANCE * cos(PITCH)]
# x and y of the direction of the light: the first order falls onto the plate.
LIGHT = (0.5, 0.45)
# Factor of the differences in the picture.
MAGNIFIED = 1000
CHROMIUM = "--headless --no-sandbox --disable-gpu-sandbox --use-angle=swiftshader --enable-unsafe-swiftshader --no-first-run --disable-background-networking "
CHROMIUM += "--disable-dev-shm-usage --timeout=60000 --virtual-time-budget=10000 --dump-dom"


def by_diffract(folder, theta, phi):
    """Returns linear sRGB and the coverage by the program itself, from the table of the export."""
    scene = f'mesh = "plate"\nsurface = "elaphe"\nlights = ["{theta},{phi}"]\n[camera]\neye = {EYE}\ntarget = [0.0, 0.0, 0.0]\n'
    (folder / "plate.toml").write_text(scene + f'field_of_view = "{FIELD_OF_VIEW}deg"\n')
    diffract("render", "plate.toml", "--table", "skin", *OPTICS, "--samples", 1, "--size", f"{SIDE}x{SIDE}", "-o", "plate.exr", folder=folder)
    return picture(folder / "plate.exr")


def by_mitsuba(folder, theta, phi):
    """Returns linear sRGB and where there is a surface."""
    camera = scenes.camera(EYE, [0, 0, 0], FIELD_OF_VIEW, (SIDE, SIDE))
    plate = scenes.plate({"type": "diffract", "folder": str(folder / "skin")})
    return first_hit.picture(mi.load_dict({"type": "scene", "camera": camera, "plate": plate}), theta, phi)


def by_browser(folder):
    """Returns linear sRGB and the coverage by the page of the material."""
    page = folder / "page.html"
    # The page allows its script alone, and prepares itself once it is on a screen.
    document = re.sub('<meta http-equiv="Content-Security-Policy"[^>]*>', "", page.read_text())
    hands = "<script>const opened = openDevice; openDevice = () => { opened(); parallel = null; }; prepare(async () => {}).then(() => {"
    hands += f"element('around').checked = false; Object.assign(state, {{ shape: PLATE, yaw: 0, pitch: {PITCH}, distance: {NEARER}, light: {list(LIGHT)} }});"
    hands += f"document.documentElement.dataset.radiance = radiance({SIDE}, {SIDE}).join(); }});</script></body>"
    page.write_text(document.replace("</body>", hands))
    command = ["chromium", *CHROMIUM.split(), f"--user-data-dir={folder / 'profile'}", f"file://{page}"]
    document = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    numbers = re.search('data-radiance="([^"]*)"', document)[1]
    # The page's rows go up.
    rgba = np.array(numbers.split(","), dtype=np.float64).reshape(SIDE, SIDE, 4)[::-1]
    return rgba[..., :3], rgba[..., 3]


def plates():
    """Returns the plate by each program, linear sRGB, 0 where one of them does not show it alone, and the pixels that all show."""
    theta, phi = degrees(asin(hypot(*LIGHT))), degrees(atan2(LIGHT[1], LIGHT[0]))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        common = ["export", "elaphe", *OPTICS, "--footprint", "0"]
        diffract(*common, "-o", "skin", folder=folder)
        diffract(*common, "--html", "page.html", folder=folder)
        drawn = {"diffract": by_diffract(folder, theta, phi), "Mitsuba": by_mitsuba(folder, theta, phi), "browser": by_browser(folder)}
    inside = np.logical_and.reduce([cover == 1 for _, cover in drawn.values()])
    if inside.sum() < SIDE**2 / 4:
        raise RuntimeError("the three pictures do not show the same plate")
    return {name: np.where(inside[..., None], rgb, 0) for name, (rgb, _) in drawn.items()}, inside


def differences(shown):
    """Returns the relative L2 of each program's picture from another's, by their names."""
    pairs = [("Mitsuba", "diffract"), ("browser", "diffract"), ("browser", "Mitsuba")]
    return {pair: relative_l2(shown[pair[0]], shown[pair[1]]) for pair in pairs}


def main(target):
    shown, inside = plates()
    print(f"relative L2 over {inside.sum()} pixels of {SIDE} x {SIDE}")
    for (one, other), off in differences(shown).items():
        print(f"{one} from {other}: {off:.1e}")
    if target:
        bright = 0.9 / np.percentile(shown["diffract"][inside], 99.5)
        off = [np.abs(rgb - shown["diffract"]) * MAGNIFIED for rgb in shown.values()]
        rows = [np.concatenate([tone.neutral(bright * rgb) for rgb in row], axis=1) for row in (shown.values(), off)]
        mi.Bitmap(tone.codes(np.concatenate(rows, axis=0))).write(target)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else None)
