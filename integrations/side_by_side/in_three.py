"""Draws both shapes by three.js and by diffract: in_three.py FOLDER"""

import pathlib
import shutil
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "three"))
import test_three  # noqa: E402

folder = pathlib.Path(sys.argv[1])
pictures = test_three.Pictures
pictures.setUpClass()
light = pictures.LIGHTS[:1]
for shape in ("sphere", "knot"):
    found, mesh = pictures().drawn(shape=shape, lights=light, tangents=True)
    np.save(folder / f"three-{shape}.npy", found)
    np.save(folder / f"diffract-{shape}.npy", pictures().expected(mesh, light))
    (folder / f"{shape}.obj").write_text(mesh)
shutil.copytree(pictures.folder / "skin", folder / "skin", dirs_exist_ok=True)
pictures.tearDownClass()
