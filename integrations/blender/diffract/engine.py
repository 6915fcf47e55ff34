"""The render engine: the scene goes to `diffract render`, and its picture comes back with alpha and depth."""

import pathlib
import shutil
import subprocess
import tempfile
import time

import bpy
import numpy as np

from . import scene_files

# Blender's distance of what is not there.
NOWHERE = 1e10


def program():
    """Returns the path of the program: that of the preferences, or the one in the path."""
    addon = bpy.context.preferences.addons.get(__package__)
    path = addon.preferences.program if addon else ""
    found = path or shutil.which("diffract")
    if not found:
        raise FileNotFoundError("there is no diffract; install it, or name it in the preferences of the add-on")
    return found


def read(path):
    """Returns the pixels of a picture with depth, [row from the lower one on][column][RGBA], and distances."""
    import OpenImageIO as oiio

    image = oiio.ImageBuf(str(path))
    names = image.spec().channelnames
    pixels = image.get_pixels(oiio.FLOAT)[::-1]
    color = pixels[..., [names.index(name) for name in "RGBA"]]
    distance = pixels[..., names.index("Z")]
    return np.ascontiguousarray(color), np.where(np.isfinite(distance), distance, NOWHERE)


class DiffractEngine(bpy.types.RenderEngine):
    """Renders by diffract."""

    bl_idname = "DIFFRACT"
    bl_label = "diffract"
    bl_use_preview = False
    bl_use_eevee_viewport = True

    def update_render_passes(self, scene=None, renderlayer=None):
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        self.register_pass(scene, renderlayer, "Depth", 1, "Z", "VALUE")

    def render(self, depsgraph):
        scene = depsgraph.scene
        share = scene.render.resolution_percentage / 100.0
        size = [max(1, int(n * share)) for n in (scene.render.resolution_x, scene.render.resolution_y)]
        try:
            with tempfile.TemporaryDirectory(prefix="diffract-") as folder:
                picture = self.drawn(pathlib.Path(folder), depsgraph, scene, size)
                if picture is None:
                    return
                color, distance = read(picture)
        except (OSError, ValueError, RuntimeError) as error:
            self.report({"ERROR"}, str(error))
            return
        result = self.begin_result(0, 0, *size)
        passes = result.layers[0].passes
        passes["Combined"].rect.foreach_set(color.ravel())
        if "Depth" in passes:
            passes["Depth"].rect.foreach_set(distance.ravel())
        self.end_result(result)

    def drawn(self, folder, depsgraph, scene, size):
        """Returns the path of the picture, or None if the user stopped it."""
        self.update_stats("diffract", "writing the scene")
        path, left_out = scene_files.write(folder, depsgraph, size)
        for what in left_out:
            self.report({"WARNING"}, f"diffract leaves out {what}")
        settings = scene.diffract
        output = folder / "picture.exr"
        words = [program(), "render", path.name, "-o", output.name, "--depth", "--size", f"{size[0]}x{size[1]}", "--samples", str(settings.samples)]
        words += settings.options.split()
        if not scene.render.film_transparent and "[environment]" in path.read_text():
            words += ["--background", "surroundings"]
        with (folder / "said").open("w+") as said:
            work = subprocess.Popen(words, cwd=folder, stderr=said, stdout=subprocess.DEVNULL, stdin=subprocess.DEVNULL)
            while work.poll() is None:
                if self.test_break():
                    work.terminate()
                    work.wait()
                    return None
                self.update_stats("diffract", "drawing")
                time.sleep(0.1)
            said.seek(0)
            lines = [line for line in said.read().replace("\r", "\n").splitlines() if line.strip()]
        if work.returncode != 0:
            raise RuntimeError(lines[-1] if lines else f"diffract ended with {work.returncode}")
        for line in lines:
            self.report({"INFO"}, line)
        return output


def panels():
    """Returns the panels of other engines that serve this one, too."""
    others = ("BLENDER_RENDER", "BLENDER_EEVEE_NEXT", "BLENDER_EEVEE")
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if engines and any(name in engines for name in others) and panel.__name__.startswith(("DATA_PT", "OUTPUT_PT", "WORLD_PT_context", "VIEWLAYER_PT_layer")):
            yield panel


def register():
    bpy.utils.register_class(DiffractEngine)
    for panel in panels():
        panel.COMPAT_ENGINES.add(DiffractEngine.bl_idname)


def unregister():
    for panel in panels():
        panel.COMPAT_ENGINES.discard(DiffractEngine.bl_idname)
    bpy.utils.unregister_class(DiffractEngine)
