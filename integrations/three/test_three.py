"""Draws shapes by the module in Chromium, and compares them with the pictures of diffract."""

import base64
import http.server
import json
import os
import pathlib
import subprocess
import tempfile
import threading
import unittest
import urllib.parse

import numpy as np
import OpenEXR

HERE = pathlib.Path(__file__).parent
ROOT = HERE.parents[1]
DIFFRACT = os.environ.get("DIFFRACT", str(ROOT / "target/release/diffract"))
NODE_MODULES = pathlib.Path(os.environ.get("THREE_MODULES", ROOT / "target/three/node_modules"))
CHROMIUM = [
    "chromium", "--headless", "--no-sandbox", "--disable-gpu-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--no-first-run", "--disable-background-networking", "--disable-dev-shm-usage",
]  # fmt: skip
OPTICS = ["--coherence", "gaussian:8um", "--tolerance", "2e-2"]
SIZE = 256
EYE = (0.9, 1.4, 3.0)
# Half the angle of the field of view of both cameras is 17.5 degrees.
FIELD_OF_VIEW = "35deg"


def diffract(*words, folder):
    run = subprocess.run([DIFFRACT, *map(str, words)], cwd=folder, capture_output=True, text=True, check=False)
    if run.returncode != 0:
        raise RuntimeError(f"diffract {' '.join(map(str, words))}: {run.stderr.strip()}")
    return run.stdout


class Handler(http.server.SimpleHTTPRequestHandler):
    """Serves the module, three.js and the exports, and takes answers."""

    def translate_path(self, path):
        path = urllib.parse.unquote(urllib.parse.urlsplit(path).path).lstrip("/")
        for place in (self.server.folder, HERE, NODE_MODULES.parent):
            if (place / path).is_file():
                return str(place / path)
        return str(HERE / "nothing")

    def do_POST(self):
        text = self.rfile.read(int(self.headers["Content-Length"]))
        self.send_response(204)
        self.end_headers()
        self.server.answer = json.loads(text)
        self.server.answered.set()

    def log_message(self, *_):
        pass


class Pictures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.place = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.place.name)
        diffract("export", "elaphe", "-o", "skin", *OPTICS, "--footprint", "0", folder=cls.folder)
        cls.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        cls.server.folder = cls.folder
        cls.server.answered = threading.Event()
        threading.Thread(target=cls.server.serve_forever, daemon=True).start()

    @classmethod
    def tearDownClass(cls):
        cls.server.shutdown()
        cls.place.cleanup()

    def drawn(self, **asked):
        """Returns the pixels that the module draws, [row][column][RGBA], and the shape as OBJ."""
        asked = {"folder": "skin", "size": SIZE, "eye": EYE, "settings": {}, **asked}
        query = urllib.parse.urlencode({"asked": json.dumps(asked)})
        address = f"http://127.0.0.1:{self.server.server_address[1]}/test.html?{query}"
        self.server.answered.clear()
        with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
            command = [*CHROMIUM, f"--user-data-dir={profile}", "--remote-debugging-port=0", address]
            browser = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            try:
                self.assertTrue(self.server.answered.wait(180), "the browser has sent nothing")
            finally:
                browser.kill()
                browser.wait()
        answer = self.server.answer
        self.assertEqual(answer["failures"], [])
        self.assertEqual(answer["wrong"], 0)
        pixels = np.frombuffer(base64.b64decode(answer["pixels"]), np.float32)
        return pixels.reshape(SIZE, SIZE, 4)[::-1], answer["mesh"]

    def expected(self, mesh, lights, *more):
        """Returns the picture of diffract of the same shape, [row][column][RGBA]. Its world has z up."""
        (self.folder / "shape.obj").write_text(mesh)
        x, y, z = EYE
        words = ["render", "shape.obj", "--up", "y", "--surface", "elaphe", "--table", "skin", *OPTICS]
        words += ["--eye", f"{x},{-z},{y}", "--target", "0,0,0", "--field-of-view", FIELD_OF_VIEW]
        for x, y, z in lights:
            theta, phi = np.degrees([np.arctan2(np.hypot(x, z), y), np.arctan2(-z, x)])
            words += ["--light", f"{theta},{phi}"]
        words += ["--shadows", "off", "--environment", "none", "--base-color", "0,0,0"]
        words += ["--size", f"{SIZE}x{SIZE}", "--samples", "16", "-o", "ours.exr", *more]
        diffract(*words, folder=self.folder)
        with OpenEXR.File(str(self.folder / "ours.exr")) as file:
            return np.asarray(file.channels()["RGBA"].pixels, np.float64)

    def compare(self, name, most, found, ours):
        """Asserts that the colours of pixels that both cover differ by at most `most` of their RMS, over blocks of 4 × 4 pixels: one of both draws one sample a pixel."""
        inside = (ours[..., 3] > 0.999) & (found[..., 3] > 0.5)
        self.assertGreater(inside.sum(), SIZE**2 / 8)
        means = [self.blocks(np.where(inside[..., None], picture[..., :3], 0)) for picture in (found, ours)]
        apart = np.linalg.norm(means[0] - means[1]) / np.linalg.norm(means[1])
        total = means[0].sum() / means[1].sum() - 1
        print(f"{name}: {apart:.4f} relative L2 over blocks of 4 x 4 pixels, sum {total:+.4f}")
        self.assertLess(apart, most)

    @staticmethod
    def blocks(picture):
        return picture.reshape(SIZE // 4, 4, SIZE // 4, 4, 3).mean((1, 3))

    LIGHTS = ((1.0, 2.0, 1.5), (-2.0, 0.5, 1.0))
    # Tolerances are about twice what was measured: three.js draws one sample a pixel, and without tangents each triangle has a frame of its own.

    def test_shapes_with_tangents_look_as_diffract_draws_them(self):
        for shape in ("sphere", "knot"):
            for lights in (self.LIGHTS[:1], self.LIGHTS):
                found, mesh = self.drawn(shape=shape, lights=lights, tangents=True)
                self.compare(f"{shape}, {len(lights)} lights", 0.02, found, self.expected(mesh, lights))

    def test_without_tangents_the_texture_coordinates_tell_them(self):
        found, mesh = self.drawn(shape="knot", lights=self.LIGHTS[:1])
        ours = self.expected(mesh, self.LIGHTS[:1])
        self.compare("knot without tangents", 0.05, found, ours)
        turned, _ = self.drawn(shape="knot", lights=self.LIGHTS[:1], settings={"turn": np.pi / 2})
        with self.assertRaises(AssertionError):
            self.compare("grooves turned by 90 degrees", 0.1, turned, ours)

    def test_without_texture_coordinates_an_axis_tells_them(self):
        # Meridians of the sphere run along its axis y, a right angle beside its tangents.
        found, _ = self.drawn(shape="sphere", lights=self.LIGHTS[:1], plain=True, settings={"along": [0, 1, 0]})
        turned, _ = self.drawn(shape="sphere", lights=self.LIGHTS[:1], tangents=True, settings={"turn": np.pi / 2})
        self.compare("sphere along its axis", 0.02, found, turned)
        straight, _ = self.drawn(shape="sphere", lights=self.LIGHTS[:1], tangents=True)
        with self.assertRaises(AssertionError):
            self.compare("sphere across its axis", 0.02, found, straight)


if __name__ == "__main__":
    unittest.main()
