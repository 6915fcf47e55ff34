"""Draws shapes by the shader of an export in Godot, and compares them with the pictures of diffract: a virtual display, numpy and OpenEXR are needed.

GODOT names the program with its first options, else "godot"; DIFFRACT that of diffract, else target/release/diffract."""

import json
import os
import pathlib
import shlex
import shutil
import subprocess
import tempfile
import unittest

import numpy as np
import OpenEXR

HERE = pathlib.Path(__file__).parent
DIFFRACT = os.environ.get("DIFFRACT", str(HERE.parents[1] / "target/release/diffract"))
GODOT = shlex.split(os.environ.get("GODOT", "xvfb-run -a godot"))
OPTICS = ["--coherence", "gaussian:8um", "--tolerance", "2e-2"]
SIZE = 256
# Rendering methods, as Godot names them when it starts.
RENDERERS = {"forward_plus": "Forward+", "mobile": "Forward Mobile", "gl_compatibility": "Compatibility"}
LIGHTS = ((1.0, 2.0, 1.5), (-2.0, 0.5, 1.0))


def run(*words, folder):
    made = subprocess.run([*map(str, words)], cwd=folder, capture_output=True, text=True, check=False)
    if made.returncode != 0:
        raise RuntimeError(f"{' '.join(map(str, words))}: {made.stdout} {made.stderr}")
    return made.stdout + made.stderr


class Pictures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        held = tempfile.TemporaryDirectory(dir=os.environ.get("GODOT_PLACE"))
        cls.addClassCleanup(held.cleanup)
        cls.folder = pathlib.Path(held.name)
        run(DIFFRACT, "export", "elaphe", "-o", "skin", *OPTICS, "--footprint", "0", folder=cls.folder)
        (cls.folder / "project.godot").write_text("config_version=5\n")
        shutil.copy(HERE / "draw.gd", cls.folder)

    def drawn(self, method, **asked):
        """Returns the linear colours by Godot, [row][column][RGB], for one of its rendering methods."""
        asked = {"size": SIZE, "eye": (0.9, 1.4, 3.0), "rotation": (0, 0, 0), "turn": 0, **asked}
        (self.folder / "asked.json").write_text(json.dumps(asked))
        told = run(*GODOT, "--rendering-method", method, "--audio-driver", "Dummy", "--path", self.folder, "-s", "draw.gd", folder=self.folder)
        self.assertNotIn("SHADER ERROR", told)
        self.assertIn(f" - {RENDERERS[method]} - ", told)
        pixels = np.frombuffer((self.folder / "pixels.bin").read_bytes(), np.float32).reshape(SIZE, SIZE, 4)[..., :3]
        if method == "gl_compatibility":
            # The picture of this renderer is that of a screen.
            pixels = np.where(pixels <= 0.04045, pixels / 12.92, ((pixels + 0.055) / 1.055) ** 2.4)
        return pixels

    def expected(self, lights):
        """Returns the picture of diffract of the same shape, [row][column][RGBA]. Its world has z up."""
        words = ["render", "shape.obj", "--up", "y", "--surface", "elaphe", "--table", "skin", *OPTICS, "--eye", "0.9,-3.0,1.4", "--target", "0,0,0"]
        for x, y, z in lights:
            theta, phi = np.degrees([np.arctan2(np.hypot(x, z), y), np.arctan2(-z, x)])
            words += ["--light", f"{theta},{phi}"]
        words += ["--field-of-view", "35deg", "--shadows", "off", "--environment", "none", "--base-color", "0,0,0"]
        run(DIFFRACT, *words, "--size", f"{SIZE}x{SIZE}", "--samples", "16", "-o", "ours.exr", folder=self.folder)
        with OpenEXR.File(str(self.folder / "ours.exr")) as file:
            return np.asarray(file.channels()["RGBA"].pixels, np.float64)

    def apart(self, name, found, ours):
        """Returns the relative L2 over blocks of 4 x 4 pixels that the shape covers to the edge: Godot draws one sample a pixel."""
        inside = ours[..., 3] > 0.999
        for axis in (0, 1):
            inside &= np.roll(inside, 1, axis) & np.roll(inside, -1, axis)
        self.assertGreater(inside.sum(), SIZE**2 / 8)
        means = [np.where(inside[..., None], picture[..., :3], 0).reshape(SIZE // 4, 4, SIZE // 4, 4, 3).mean((1, 3)) for picture in (found, np.maximum(ours, 0))]
        apart = np.linalg.norm(means[0] - means[1]) / np.linalg.norm(means[1])
        print(f"{name}: {apart:.4f} relative L2, sum {means[0].sum() / means[1].sum() - 1:+.4f}")
        return apart

    # Tolerances are about twice what was measured.

    def test_shapes_look_as_diffract_draws_them_by_all_renderers(self):
        for method in RENDERERS:
            for shape, lights in (("sphere", LIGHTS[:1]), ("torus", LIGHTS)):
                found = self.drawn(method, shape=shape, lights=lights)
                self.assertLess(self.apart(f"{method}, {shape}, {len(lights)} lights", found, self.expected(lights)), 0.02)

    def test_both_sides_of_a_plane_have_the_colours_of_diffract_and_a_turned_one_does_not(self):
        for rotation in ((0, 0, 0), (10, 180, 0)):
            found = self.drawn("forward_plus", shape="plane", lights=LIGHTS[:1], rotation=rotation)
            ours = self.expected(LIGHTS[:1])
            self.assertLess(self.apart(f"plane, turned by {rotation[1]} degrees", found, ours), 0.002)
            turned = self.drawn("forward_plus", shape="plane", lights=LIGHTS[:1], rotation=rotation, turn=90)
            self.assertGreater(self.apart("grooves turned by 90 degrees", turned, ours), 0.1)


if __name__ == "__main__":
    unittest.main()
