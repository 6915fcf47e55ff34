"""Cameras, lights and meshes with the conventions of diffract's scene files, as dictionaries and objects of Mitsuba: the world's up is +z."""

import math
from pathlib import Path

import mitsuba as mi
import numpy as np

TANGENT = "vertex_tangent"
# Standard deviation of the pixel filter of diffract [pixels].
FILTER = 0.5


def camera(eye, target, field_of_view, size):
    """Returns a camera with a vertical field of view in degrees. size: width and height in pixels."""
    return {
        "type": "perspective",
        "to_world": mi.ScalarTransform4f().look_at(list(eye), list(target), [0, 0, 1]),
        "fov": field_of_view,
        "fov_axis": "y",
        # The distance to the eye tells how much a pixel covers; Mitsuba counts it from the near plane.
        "near_clip": 1e-4,
        "film": {
            "type": "hdrfilm",
            "width": size[0],
            "height": size[1],
            "pixel_format": "rgb",
            "component_format": "float32",
            "rfilter": {"type": "gaussian", "stddev": FILTER},
        },
        "sampler": {"type": "multijitter"},
    }


def toward(theta, phi):
    """Returns the unit vector theta degrees from up, phi degrees from +x toward +y."""
    theta, phi = math.radians(theta), math.radians(phi)
    return [math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)]


def far_light(theta, phi, intensity=1.0):
    """Returns the light `theta,phi,intensity` of diffract: a white matt surface that faces it has the radiance `intensity`."""
    return {
        "type": "directional",
        "direction": [-x for x in toward(theta, phi)],
        "irradiance": {"type": "rgb", "value": [math.pi * intensity] * 3},
    }


def sky(width=256):
    """Returns diffract's surroundings `sky`: an overcast sky by the CIE's formula over dark ground."""
    elevation = math.pi * (0.5 - (np.arange(width // 2) + 0.5) / (width // 2))
    sine = np.sin(elevation)[:, None]
    above = np.array([0.26, 0.31, 0.38]) * ((1 + 2 * sine) / 3)
    rows = np.where(sine > 0, above, np.array([0.030, 0.026, 0.022]))
    return {
        "type": "envmap",
        "bitmap": mi.Bitmap(np.repeat(rows[:, None], width, axis=1).astype(np.float32)),
        "to_world": mi.ScalarTransform4f().rotate([1, 0, 0], 90),
    }


def plate(bsdf):
    """Returns the plate: a square of side 1 that faces up, whose rows of heights run along x."""
    return {"type": "rectangle", "to_world": mi.ScalarTransform4f().scale(0.5), "bsdf": bsdf}


def ground(radius=4.0, albedo=(0.05, 0.046, 0.042)):
    """Returns a round matt ground at z = 0."""
    return {
        "type": "disk",
        "to_world": mi.ScalarTransform4f().scale(radius),
        "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": list(albedo)}},
    }


def obj(path, bsdf):
    """Returns the mesh in an OBJ file whose y axis points up, with normals and texture coordinates, and with smooth tangents as the attribute TANGENT."""
    lists, corners, triangles, known = {"v": [], "vt": [], "vn": []}, [], [], {}
    for line in Path(path).read_text().splitlines():
        kind, *words = line.split() or [""]
        if kind in lists:
            lists[kind].append([float(word) for word in words])
        elif kind == "f":
            face = [known.setdefault(word, len(known)) for word in words]
            triangles += [[face[0], a, b] for a, b in zip(face[1:], face[2:])]
    corners = np.array([[int(i) - 1 for i in word.split("/")] for word in known])
    position, uv, normal = (np.array(lists[kind], dtype=np.float64)[corners[:, i]] for i, kind in enumerate(["v", "vt", "vn"]))
    upright = lambda v: np.stack([v[:, 0], -v[:, 2], v[:, 1]], axis=1)
    position, normal, faces = upright(position), unit(upright(normal)), np.array(triangles)
    return mesh(Path(path).stem, faces, position, normal, uv, tangents(faces, position, normal, uv), bsdf)


def unit(vectors):
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-30)


def tangents(faces, position, normal, uv):
    """Returns the direction in which u grows at each vertex: that of each triangle across the normal, weighed by its angle, as MikkTSpace does."""
    along = lambda of, k: of[faces[:, (k + 1) % 3]] - of[faces[:, k]]
    (p, q), (a, b) = (along(position, 0), -along(position, 2)), (along(uv, 0), -along(uv, 2))
    sign = np.sign(a[:, :1] * b[:, 1:] - a[:, 1:] * b[:, :1])
    of_face = sign * (b[:, 1:] * p - a[:, 1:] * q)
    flat = lambda v, n: unit(v - n * np.sum(v * n, axis=1, keepdims=True))
    result = np.zeros_like(position)
    for k in range(3):
        n = normal[faces[:, k]]
        angle = np.arccos(np.clip(np.sum(flat(along(position, k), n) * flat(-along(position, (k + 2) % 3), n), axis=1), -1, 1))
        np.add.at(result, faces[:, k], flat(of_face, n) * angle[:, None])
    return flat(result, normal)


def mesh(name, faces, position, normal, uv, tangent, bsdf):
    """Returns a mesh of Mitsuba."""
    props = mi.Properties()
    props["bsdf"] = mi.load_dict(bsdf)
    made = mi.Mesh(name, len(position), len(faces), props, has_vertex_normals=True, has_vertex_texcoords=True)
    made.add_attribute(TANGENT, 3, np.ravel(tangent).astype(np.float32))
    parameters = mi.traverse(made)
    parameters["vertex_positions"] = mi.Float(np.ravel(position))
    parameters["vertex_normals"] = mi.Float(np.ravel(normal))
    parameters["vertex_texcoords"] = mi.Float(np.ravel(uv))
    parameters["faces"] = mi.UInt32(np.ravel(faces))
    parameters.update()
    return made
