"""Pictures without chance, as diffract draws one sample a pixel: the light of the surface at the centre of each pixel, averaged over the pixel's footprint."""

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes import toward

# Distance that a ray to the light keeps from the surface.
STEP = 1e-4


def by_texture_coordinates(si):
    """Makes the changes of the normal those over texture coordinates: of meshes Mitsuba tells them over the barycentric ones."""
    mesh = mi.MeshPtr(si.shape)
    used = si.is_valid() & si.shape.is_mesh() & mesh.has_vertex_texcoords()
    corners = mesh.face_indices(si.prim_index, used)
    at, second, third = (mesh.vertex_texcoord(corner, used) for corner in corners)
    a, b = second - at, third - at
    scale = dr.select(used, 1 / (a.x * b.y - b.x * a.y), 0)
    scale = dr.select(dr.isfinite(scale), scale, 0)
    du, dv = (b.y * si.dn_du - a.y * si.dn_dv) * scale, (a.x * si.dn_dv - b.x * si.dn_du) * scale
    si.dn_du, si.dn_dv = dr.select(used, du, si.dn_du), dr.select(used, dv, si.dn_dv)


def picture(scene, theta, phi, intensity=1.0, shadows=True):
    """Returns linear sRGB, [row][column][3], and where the picture shows a surface, under one far light. Other lights of the scene are not looked at."""
    sensor = scene.sensors()[0]
    width, height = (int(n) for n in sensor.film().size())
    index = dr.arange(mi.UInt32, width * height)
    place = mi.Point2f((mi.Float(index % width) + 0.5) / width, (mi.Float(index // width) + 0.5) / height)
    ray, _ = sensor.sample_ray_differential(0, 0.5, place, mi.Point2f(0.5))
    si = scene.ray_intersect(ray, mi.RayFlags.All | mi.RayFlags.dNSdUV, True)
    si.compute_uv_partials(ray)
    by_texture_coordinates(si)
    light = mi.Vector3f(toward(theta, phi))
    seen = si.is_valid()
    value = si.bsdf().eval(mi.BSDFContext(), si, si.to_local(light), seen)
    if shadows:
        value = dr.select(scene.ray_test(si.spawn_ray(light), seen), 0, value)
    rgb = np.array(value * (dr.pi * intensity)).T.reshape(height, width, 3)
    return np.where(np.array(seen).reshape(height, width, 1), rgb, 0), np.array(seen).reshape(height, width)
