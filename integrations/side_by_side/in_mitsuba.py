"""Draws both shapes by Mitsuba, and keeps the directions of 4 x 4 rays a pixel for wgpu: in_mitsuba.py FOLDER"""

import pathlib
import sys

import drjit as dr
import mitsuba as mi
import numpy as np
import view

mi.set_variant("llvm_ad_rgb")
sys.path.insert(0, str(pathlib.Path(__file__).parents[1] / "mitsuba"))
import diffract_bsdf  # noqa: E402, F401  registers `diffract`
import first_hit  # noqa: E402
import scenes  # noqa: E402

folder = pathlib.Path(sys.argv[1])
light = np.array(view.LIGHT) / np.linalg.norm(view.LIGHT)


def scene(shape, size):
    material = {"type": "diffract", "folder": str(folder / "skin"), "tangent": scenes.TANGENT}
    camera = scenes.camera(view.EYE, (0, 0, 0), view.FIELD_OF_VIEW, (size, size))
    return mi.load_dict({"type": "scene", "camera": camera, "shape": scenes.obj(folder / f"{shape}.obj", material)})


def rays(scene, size):
    """Returns the directions to light and viewer in the tangent frame for a grid of rays, and which of them meet the shape."""
    index = dr.arange(mi.UInt32, size * size)
    place = mi.Point2f((mi.Float(index % size) + 0.5) / size, (mi.Float(index // size) + 0.5) / size)
    ray, _ = scene.sensors()[0].sample_ray_differential(0, 0.5, place, mi.Point2f(0.5))
    si = scene.ray_intersect(ray, mi.RayFlags.All, True)
    normal = np.array(si.sh_frame.n).T
    tangent = np.array(si.shape.eval_attribute_3(scenes.TANGENT, si, si.is_valid())).T
    tangent = scenes.unit(tangent - normal * np.sum(tangent * normal, axis=1, keepdims=True))
    frame = (tangent, np.cross(normal, tangent), normal)
    local = lambda v: np.stack([np.sum(v * axis, axis=1) for axis in frame], axis=1)
    viewer = -np.array(ray.d).T
    return {"light": local(np.broadcast_to(light, viewer.shape)), "viewer": local(viewer), "seen": np.array(si.is_valid())}


theta, phi = np.degrees([np.arccos(light[2]), np.arctan2(light[1], light[0])])
for shape in ("sphere", "knot"):
    rgb, seen = first_hit.picture(scene(shape, view.SIZE), theta, phi, shadows=False)
    np.save(folder / f"mitsuba-{shape}.npy", np.dstack([rgb, seen]))
    np.savez(folder / f"rays-{shape}.npz", **rays(scene(shape, 4 * view.SIZE), 4 * view.SIZE))
