"""Path-traced pictures of an export: `python render.py plate|snake FOLDER -o PICTURE`. An .exr is linear and signed, a .png is displayed."""

import argparse
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")

import diffract_bsdf  # noqa: E402, F401  registers `diffract`
import scenes  # noqa: E402
import tone  # noqa: E402
from exported import Export, ExportError  # noqa: E402

SNAKE = Path(__file__).parents[2] / "assets/meshes/snake.obj"
# Cameras, lights and pigments of assets/scenes: eye, target, field of view; theta, phi, intensity.
CAMERAS = {"plate": ([1.0, 0.0, 1.5], [0.02, 0.0, 0.0], 35), "snake": ([0.353, 1.86, 1.467], [0.04, 0.04, 0.085], 35)}
LIGHTS = {"plate": (40, 180, 2), "snake": (40, -97, 2)}
EXPOSURES = {"plate": -5.0, "snake": 1.8}
PIGMENTS = {"plate": [0.7, 0.7, 0.8], "snake": [0.006, 0.0045, 0.003]}
# Samples of a pixel that are drawn at once: they take about 1 kB each.
SAMPLES_AT_ONCE = 8


def scene(name, bsdf, size, light=None, others=None):
    """Returns one of the scenes with a far light, `theta, phi, intensity`, and with other objects or lights by name."""
    shape = scenes.plate(bsdf) if name == "plate" else scenes.obj(SNAKE, bsdf | {"tangent": scenes.TANGENT})
    far = {"light": scenes.far_light(*light)} if light else {}
    return mi.load_dict({"type": "scene", "camera": scenes.camera(*CAMERAS[name], size), "shape": shape, **far, **(others or {})})


def path_traced(scene, samples, depth, most=None):
    """Returns the mean of at least `samples` samples a pixel, linear sRGB.

    depth: 2 for light that one surface reflects. most: bound of the light that several surfaces reflect, in the mean of SAMPLES_AT_ONCE samples. It takes away
    the bright dots of light that a narrow lobe throws onto a matt surface, which few paths meet, and some of that light.
    """
    passes, each = -(-samples // SAMPLES_AT_ONCE), min(samples, SAMPLES_AT_ONCE)

    def drawn(depth, seed):
        integrator = mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": max(depth, 5)})
        return np.array(mi.render(scene, integrator=integrator, spp=each, seed=seed))

    total = 0.0
    for seed in range(passes):
        whole = drawn(depth, seed)
        if most is not None:
            # The same seed draws the same paths.
            direct = drawn(2, seed)
            whole = direct + np.clip(whole - direct, -most, most)
        total = total + whole
    return total / passes


def write(path, rgb, exposure=0.0):
    """Writes a picture, whose kind its name tells."""
    if Path(path).suffix == ".exr":
        mi.Bitmap(np.float32(rgb)).write(str(path))
    else:
        mi.Bitmap(tone.codes(tone.neutral(rgb * 2**exposure))).write(str(path))


def size(text):
    width, height = text.split("x")
    return int(width), int(height)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scene", choices=CAMERAS)
    parser.add_argument("folder", help="folder of `diffract export`")
    parser.add_argument("-o", "--output", required=True)
    parser.add_argument("--size", type=size, default=(640, 360), help="WIDTHxHEIGHT")
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--depth", type=int, default=6, help="2 for light that one surface reflects")
    parser.add_argument("--most-indirect", type=float, help="bound of the light that several surfaces reflect, in the mean of 8 samples")
    parser.add_argument("--exposure", type=float, help="in stops, of a .png")
    parser.add_argument("--ground", action="store_true", help="put a matt ground below the snake")
    parser.add_argument("--no-sky", action="store_true", help="leave out the sky")
    arguments = parser.parse_args()
    mi.set_log_level(mi.LogLevel.Error)
    Export(arguments.folder)  # Mitsuba buries the error of an export in its own
    name = arguments.scene
    others = {} if arguments.no_sky else {"sky": scenes.sky()}
    if arguments.ground:
        others["ground"] = scenes.ground()
    material = {"type": "diffract", "folder": arguments.folder, "base_color": {"type": "rgb", "value": PIGMENTS[name]}}
    drawn = path_traced(scene(name, material, arguments.size, LIGHTS[name], others), arguments.samples, arguments.depth, arguments.most_indirect)
    write(arguments.output, drawn, EXPOSURES[name] if arguments.exposure is None else arguments.exposure)


if __name__ == "__main__":
    try:
        main()
    except ExportError as error:
        raise SystemExit(f"render: {error}") from None
