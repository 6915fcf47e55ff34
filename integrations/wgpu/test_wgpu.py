"""The WGSL function of an export through wgpu, judged by `diffract export --check`. Run: python -m unittest test_wgpu"""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

from evaluate import answers
from material import device

HERE = Path(__file__).parent
DIFFRACT = os.environ.get("DIFFRACT", str(HERE.parents[1] / "target/release/diffract"))


def run(*words, folder):
    return subprocess.run([*map(str, words)], cwd=folder, capture_output=True, text=True)


class Function(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        held = tempfile.TemporaryDirectory()
        cls.addClassCleanup(held.cleanup)
        cls.folder = Path(held.name)
        for words in [
            ["surface", "synth", "bumps", "--patch", "2um", "-o", "small.gsf"],
            ["export", "small.gsf", "-o", "material", "--coherence", "gaussian:8um", "--footprint", "0.05", "--tolerance", "5e-2"],
        ]:
            made = run(DIFFRACT, *words, folder=cls.folder)
            assert made.returncode == 0, made.stderr

    def test_answers_are_those_of_the_table(self):
        told = run(sys.executable, HERE / "evaluate.py", "material", "-o", "mine.csv", folder=self.folder)
        self.assertEqual(told.returncode, 0, told.stderr)
        self.assertIn("1000 directions", told.stdout)
        judged = run(DIFFRACT, "export", "--check", "material", "--answers", "mine.csv", folder=self.folder)
        self.assertTrue(judged.stdout.startswith("right: "), judged.stdout + judged.stderr)
        print(told.stdout + judged.stdout)

    def test_a_turned_frame_gives_other_answers(self):
        _, off = answers(device(), self.folder / "material", ((0, 1, 0), (-1, 0, 0), (0, 0, 1)))
        self.assertGreater(off, 0.05)


if __name__ == "__main__":
    unittest.main()
