"""Installs the extension in a fresh Blender, uses it as a script would, and compares its pictures with those of diffract."""

import contextlib
import io
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

HOME = tempfile.TemporaryDirectory()
# A Blender without anything of the user's.
os.environ["BLENDER_USER_RESOURCES"] = HOME.name

import bpy  # noqa: E402
import mathutils  # noqa: E402
import numpy as np  # noqa: E402

ROOT = pathlib.Path(__file__).parents[2]
DIFFRACT = os.environ.get("DIFFRACT", str(ROOT / "target/release/diffract"))
ZIP = os.environ.get("DIFFRACT_ZIP", str(ROOT / "target/blender/diffract.zip"))
OPTICS = ["--coherence", "gaussian:8um", "--tolerance", "2e-2"]
SIZE = 384
# The module keeps Blender's own packages where its program does not look.
sys.path.append(os.path.join(bpy.utils.resource_path("LOCAL"), "python/lib/python3.11/site-packages"))


def direction(theta, phi):
    theta, phi = math.radians(theta), math.radians(phi)
    return mathutils.Vector((math.sin(theta) * math.cos(phi), math.sin(theta) * math.sin(phi), math.cos(theta)))


def blocks(picture, side=8):
    """Returns means over squares of pixels: pictures with other samples and pixel filters have them in common."""
    height, width = picture.shape[:2]
    return picture.reshape(height // side, side, width // side, side, -1).mean((1, 3))


def difference(picture, reference):
    a, b = (blocks(p)[..., :3] for p in (picture, reference))
    return float(np.linalg.norm(a - b) / np.linalg.norm(b))


class Blender(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.place = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.place.name)
        words = [DIFFRACT, "export", "elaphe", "-o", "skin", *OPTICS, "--footprint", "0"]
        subprocess.run(words, cwd=cls.folder, check=True, capture_output=True)
        bpy.ops.wm.read_factory_settings(use_empty=True)
        bpy.ops.extensions.package_install_files(filepath=ZIP, repo="user_default", enable_on_install=True)
        (cls.addon,) = (key for key in bpy.context.preferences.addons.keys() if key.endswith(".diffract"))

    @classmethod
    def tearDownClass(cls):
        cls.place.cleanup()
        HOME.cleanup()

    def setUp(self):
        bpy.context.preferences.addons[self.addon].preferences.program = DIFFRACT
        for thing in list(bpy.data.objects):
            bpy.data.objects.remove(thing)
        self.scene = bpy.context.scene
        self.scene.world = None
        render = self.scene.render
        render.resolution_x = render.resolution_y = SIZE
        render.film_transparent = True
        self.camera = self.added("camera", bpy.data.cameras.new("camera"))
        self.camera.data.angle = math.radians(35.0)
        self.scene.camera = self.camera
        self.look(mathutils.Vector((0.0, -3.3, 1.8)))

    def added(self, name, data):
        thing = bpy.data.objects.new(name, data)
        self.scene.collection.objects.link(thing)
        return thing

    def look(self, eye, roll=0.0):
        self.camera.location = eye
        self.camera.rotation_euler = (-eye).to_track_quat("-Z", "Y").to_euler()
        self.camera.rotation_euler.rotate_axis("Z", roll)

    def sun(self, theta, phi, strength):
        sun = self.added("sun", bpy.data.lights.new("sun", "SUN"))
        sun.rotation_euler = direction(theta, phi).to_track_quat("Z", "Y").to_euler()
        sun.data.energy, sun.data.angle = strength, 0.0
        return sun

    def shape(self, make=bpy.ops.mesh.primitive_uv_sphere_add, **given):
        make(**given)
        thing = bpy.context.object
        bpy.ops.object.shade_smooth()
        return thing

    def sphere(self):
        return self.shape(segments=128, ring_count=64, radius=1.0)

    def by_diffract(self, thing, samples=16, options=f"--method table --table {{}} {' '.join(OPTICS)}"):
        """Returns RGBA and distances as the render engine draws them."""
        skin = bpy.data.materials.new("skin")
        skin.diffract.surface = "elaphe"
        thing.data.materials.clear()
        thing.data.materials.append(skin)
        self.scene.diffract.samples, self.scene.diffract.options = samples, options.format(self.folder / "skin")
        return self.drawn("DIFFRACT")

    def by_cycles(self, thing, form, samples=16):
        bpy.ops.object.select_all(action="DESELECT")
        thing.select_set(True)
        told = bpy.ops.diffract.import_material(filepath=str(self.folder / "skin/material.json"), form=form)
        self.assertEqual(told, {"FINISHED"})
        return self.cycles(samples)[0]

    def cycles(self, samples):
        cycles = self.scene.cycles
        cycles.samples, cycles.max_bounces = samples, 0
        cycles.use_denoising = cycles.use_adaptive_sampling = False
        cycles.pixel_filter_type, cycles.filter_width = ("BOX", 1.0) if samples > 1 else ("BOX", 0.01)
        return self.drawn("CYCLES")

    def drawn(self, engine):
        import OpenImageIO as oiio

        settings = self.scene.render
        settings.engine = engine
        self.scene.view_layers[0].use_pass_z = True
        if hasattr(settings.image_settings, "media_type"):
            settings.image_settings.media_type = "MULTI_LAYER_IMAGE"
        settings.image_settings.file_format = "OPEN_EXR_MULTILAYER"
        settings.image_settings.color_depth = "32"
        settings.filepath = str(self.folder / f"{engine}.exr")
        with contextlib.redirect_stdout(io.StringIO()):
            bpy.ops.render.render(write_still=True)
        channels = {}
        for part in range(oiio.ImageBuf(settings.filepath).nsubimages):
            image = oiio.ImageBuf(settings.filepath, part, 0)
            pixels = image.get_pixels(oiio.FLOAT)
            channels |= {name.split(".", 1)[-1]: pixels[..., i] for i, name in enumerate(image.spec().channelnames)}
        (distance,) = (pixels for name, pixels in channels.items() if name.startswith("Depth."))
        return np.dstack([channels[f"Combined.{c}"] for c in "RGBA"]), distance

    def test_nodes_and_scripts_are_the_picture_of_diffract(self):
        knot = lambda: self.shape(bpy.ops.mesh.primitive_torus_add, major_segments=200, minor_segments=100, rotation=(0.9, 0.3, 0.0))  # noqa: E731
        for name, make in (("sphere", self.sphere), ("torus", knot)):
            for lights in ([(35, -50, 2 * math.pi)], [(35, -50, 2 * math.pi), (60, -120, 3.0)]):
                self.setUp()
                thing = make()
                for light in lights:
                    self.sun(*light)
                self.scene.diffract.options = ""
                reference = self.by_diffract(thing, options="--shadows off --method table --table {} " + " ".join(OPTICS))[0]
                for form in ("NODES", "OSL"):
                    bpy.context.scene.cycles.shading_system = form == "OSL"
                    picture = self.by_cycles(thing, form)
                    error = difference(picture, reference)
                    sums = picture[..., :3].sum((0, 1)) / reference[..., :3].sum((0, 1)) - 1.0
                    print(f"{name}, {len(lights)} lights, {form}: {error:.4f}, sums {np.abs(sums).max():.4f}", file=sys.stderr)
                    if name == "sphere":
                        self.assertLess(error, 0.015)
                    else:
                        # The script traces shadows, and both have another silhouette.
                        self.assertLess(error, 0.05 if form == "NODES" else 0.2)
                    self.assertGreater(difference(picture[:, ::-1], reference), 0.5, "a mirrored picture is another one")

    def test_shadows_are_traced_by_the_script(self):
        sphere = self.sphere()
        self.sun(35, -50, 2 * math.pi)
        self.scene.cycles.shading_system = True
        free = self.by_cycles(sphere, "OSL", 4)
        blocker = self.shape(bpy.ops.mesh.primitive_plane_add, size=4.0, location=direction(35, -50) * 3.0)
        blocker.visible_camera = False
        dark = self.by_cycles(sphere, "OSL", 4)
        self.assertGreater(free[..., :3].sum(), 100.0)
        self.assertLess(abs(dark[..., :3]).sum(), 1e-3 * free[..., :3].sum())

    def test_a_point_light_is_a_small_lamp(self):
        sphere = self.sphere()
        lamp = self.added("lamp", bpy.data.lights.new("lamp", "POINT"))
        lamp.location, lamp.data.energy, lamp.data.shadow_soft_size = (1.5, -2.5, 2.5), 300.0, 0.001
        reference = self.by_diffract(sphere)[0]
        picture = self.by_cycles(sphere, "NODES")
        self.assertLess(difference(picture, reference), 0.015)

    def test_cameras_see_what_those_of_blender_see(self):
        thing = self.shape(bpy.ops.mesh.primitive_torus_add, rotation=(0.4, 0.3, 0.0), location=(0.2, 0.0, 0.1))
        self.sun(35, -50, 2 * math.pi)
        camera = self.camera.data

        def set_camera(eye, roll=0.0, **settings):
            self.look(mathutils.Vector(eye), roll)
            camera.type, camera.shift_x, camera.shift_y, camera.sensor_fit = "PERSP", 0.0, 0.0, "AUTO"
            for name, value in settings.items():
                setattr(camera, name, value)

        views = [
            ("plain", (0.0, -3.3, 1.8), {}),
            ("rolled", (1.0, -3.3, 1.8), {"roll": 0.7}),
            ("shifted", (-2.0, -3.3, 1.8), {"shift_x": 0.12, "shift_y": -0.2, "roll": -2.2}),
            ("orthographic", (1.0, 3.3, -1.8), {"type": "ORTHO", "ortho_scale": 3.5, "shift_x": -0.1, "roll": 0.3}),
            ("from above", (0.0, 0.0, 4.0), {"type": "ORTHO", "ortho_scale": 3.5}),
            ("from above in perspective", (0.0, 0.0, 4.0), {"roll": 1.0}),
        ]
        for shape in ((SIZE, SIZE), (SIZE, SIZE // 2), (SIZE // 2, SIZE)):
            self.scene.render.resolution_x, self.scene.render.resolution_y = shape
            for name, eye, settings in views:
                set_camera(eye, **settings)
                color, distance = self.by_diffract(thing, 1, "--method spectral --windows 1x1 --tolerance 1e-1 --coherence gaussian:4um")
                other, other_distance = self.cycles(1)
                seen, also = color[..., 3] > 0.5, other[..., 3] > 0.5
                self.assertGreater(also.sum(), 3000, name)
                # A few pixels at the outline: the other one looks beside their middle.
                self.assertLess((seen != also).sum(), 0.01 * also.sum(), name)
                both = seen & also
                apart = np.abs(distance - other_distance)[both] / other_distance[both]
                self.assertLess(np.quantile(apart, 0.95), 2e-3, name)

    def test_a_world_lights_the_scene(self):
        sphere = self.sphere()
        quick = "--windows 1x1 --tolerance 1e-1 --coherence gaussian:4um"
        dark = self.by_diffract(sphere, 1, quick)[0]
        self.assertEqual(np.abs(dark[..., :3]).max(), 0.0)
        self.scene.world = bpy.data.worlds.new("world")
        if bpy.app.version < (5, 0, 0):
            self.scene.world.use_nodes = True
        background = next(node for node in self.scene.world.node_tree.nodes if node.type == "BACKGROUND")
        background.inputs["Color"].default_value, background.inputs["Strength"].default_value = (0.5, 0.5, 0.5, 1.0), 2.0
        lit = self.by_diffract(sphere, 1, quick)[0]
        inside = lit[..., 3] == 1.0
        # A dielectric of index 1.5 under an even sky reflects 4 % at normal incidence, and 9 % in the mean.
        self.assertTrue(0.03 < lit[inside][:, 1].mean() < 0.2, lit[inside][:, 1].mean())

    def test_what_cannot_be_done_is_told(self):
        sphere = self.sphere()
        self.scene.render.engine = "DIFFRACT"
        with self.assertRaisesRegex(RuntimeError, "no object has a material with a surface"):
            bpy.ops.render.render()
        with self.assertRaisesRegex(RuntimeError, "--nonsense"):
            self.by_diffract(sphere, options="--nonsense")
        bpy.context.preferences.addons[self.addon].preferences.program = "/nowhere/diffract"
        with self.assertRaisesRegex(RuntimeError, "nowhere"):
            self.by_diffract(sphere)
        with self.assertRaisesRegex(RuntimeError, "no sun or point light"):
            bpy.ops.diffract.import_material(filepath=str(self.folder / "skin/material.json"))
        self.sun(1, 2, 3)
        with self.assertRaisesRegex(RuntimeError, "material.json"):
            bpy.ops.diffract.import_material(filepath=str(self.folder / "nothing"))


if __name__ == "__main__":
    unittest.main()
