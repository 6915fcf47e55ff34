"""Draws both shapes by the extension for Blender, in Cycles and EEVEE: in_blender.py FOLDER EXTENSION.zip"""

import math
import os
import pathlib
import sys
import tempfile

resources = tempfile.TemporaryDirectory()
os.environ["BLENDER_USER_RESOURCES"] = resources.name

import bpy  # noqa: E402
import mathutils  # noqa: E402
import numpy as np  # noqa: E402

sys.path.append(os.path.join(bpy.utils.resource_path("LOCAL"), "python/lib/python3.11/site-packages"))
import OpenImageIO as oiio  # noqa: E402
import view  # noqa: E402

folder = pathlib.Path(sys.argv[1])


def added(name, data):
    thing = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def draw(shape, form, engine):
    """Returns RGBA of a shape by a material of this form."""
    for thing in list(bpy.data.objects):
        bpy.data.objects.remove(thing)
    scene = bpy.context.scene
    bpy.ops.wm.obj_import(filepath=str(folder / f"{shape}.obj"))
    thing = bpy.context.selected_objects[0]
    sun = added("sun", bpy.data.lights.new("sun", "SUN"))
    sun.rotation_euler = mathutils.Vector(view.LIGHT).to_track_quat("Z", "Y").to_euler()
    sun.data.energy = math.pi
    camera = added("camera", bpy.data.cameras.new("camera"))
    camera.location = view.EYE
    camera.rotation_euler = (-mathutils.Vector(view.EYE)).to_track_quat("-Z", "Y").to_euler()
    camera.data.angle = math.radians(view.FIELD_OF_VIEW)
    scene.camera = camera
    scene.render.engine, scene.cycles.shading_system = engine, form == "OSL"
    bpy.ops.object.select_all(action="DESELECT")
    thing.select_set(True)
    bpy.ops.diffract.import_material(filepath=str(folder / "skin/material.json"), form=form, shadows=False)
    scene.render.resolution_x = scene.render.resolution_y = view.SIZE
    scene.render.film_transparent = True
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.render.filepath = str(folder / f"{engine}-{form}-{shape}.exr")
    scene.cycles.samples, scene.cycles.max_bounces = 16, 0
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.pixel_filter_type, scene.cycles.filter_width = "GAUSSIAN", 2.0
    scene.eevee.taa_render_samples = 64
    bpy.ops.render.render(write_still=True)
    return oiio.ImageBuf(scene.render.filepath).get_pixels(oiio.FLOAT)


bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.extensions.package_install_files(filepath=sys.argv[2], repo="user_default", enable_on_install=True)
for shape in ("sphere", "knot"):
    for name, form, engine in (("nodes", "NODES", "CYCLES"), ("osl", "OSL", "CYCLES"), ("eevee", "NODES", "BLENDER_EEVEE")):
        np.save(folder / f"{name}-{shape}.npy", draw(shape, form, engine))
