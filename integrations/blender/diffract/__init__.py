"""Light that scanned surfaces diffract, in Blender: materials of exports, and a render engine."""

import pathlib

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty, PointerProperty, StringProperty

from . import engine, lights, material


class DiffractPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    program: StringProperty(name="diffract", description="The program; empty: the one in the path", subtype="FILE_PATH")

    def draw(self, context):
        self.layout.prop(self, "program")


class DiffractSceneSettings(bpy.types.PropertyGroup):
    samples: IntProperty(name="Samples", description="Samples a pixel", default=16, min=1, max=4096)
    options: StringProperty(name="Options", description="Further options of diffract render, as in --tolerance 1e-2")


class DiffractMaterialSettings(bpy.types.PropertyGroup):
    surface: StringProperty(name="Surface", description="A height field: a file, or the name of a generated one such as elaphe or blaze", subtype="FILE_PATH")
    pixel_size: StringProperty(name="Pixel size", description="Of a file without one, as in 90nm")
    height: StringProperty(name="Height", description="From the lowest to the highest sample, as in 430nm")
    material: StringProperty(name="Material", description="As after --material; empty: a dielectric of index 1.5")
    film: StringProperty(name="Film", description="As after --film, as in 120nm:1.7")
    grooves: StringProperty(name="Grooves", description="How the patch lies on the mesh: an angle as in 90deg, or radial")
    base_color: FloatVectorProperty(name="Pigment", description="Albedo below the surface", subtype="COLOR", size=3, min=0.0, max=1.0)


class DiffractImport(bpy.types.Operator):
    """Add the material of an export of diffract, under the lights that are there"""

    bl_idname = "diffract.import_material"
    bl_label = "Import a material of diffract"
    bl_options = {"REGISTER", "UNDO"}

    filepath: StringProperty(subtype="FILE_PATH")
    filter_glob: StringProperty(default="material.json", options={"HIDDEN"})
    form: EnumProperty(
        name="Form",
        items=[("NODES", "Nodes", "Plain nodes: Cycles on any device, and EEVEE; without shadows"), ("OSL", "Script", "Open Shading Language: Cycles on CPUs, with traced shadows")],
    )
    turn: FloatProperty(name="Turn", description="Rotation of the grooves about the normal", subtype="ANGLE")
    shadows: BoolProperty(name="Shadows", description="Traced shadows of the script", default=True)

    def invoke(self, context, event):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        folder = pathlib.Path(bpy.path.abspath(self.filepath))
        folder = folder if folder.is_dir() else folder.parent
        suns = lights.usable(context.scene.objects)
        if not suns:
            self.report({"ERROR"}, "the scene has no sun or point light for the material")
            return {"CANCELLED"}
        chosen = [thing for thing in context.selected_objects if thing.type == "MESH"]
        uv_map = next((thing.data.uv_layers.active.name for thing in chosen if thing.data.uv_layers.active), None)
        try:
            if self.form == "OSL":
                context.scene.cycles.shading_system = True
                made = material.of_script(folder, suns, uv_map, self.turn, self.shadows)
            else:
                made = material.of_nodes(folder, suns, uv_map, self.turn)
        except (OSError, ValueError, KeyError, RuntimeError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        for thing in chosen:
            thing.data.materials.clear()
            thing.data.materials.append(made)
        self.report({"INFO"}, f"{made.name}: {len(suns)} lights; a light that is added later needs another import")
        return {"FINISHED"}


class DiffractMaterialPanel(bpy.types.Panel):
    bl_label = "diffract"
    bl_idname = "MATERIAL_PT_diffract"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "material"

    @classmethod
    def poll(cls, context):
        return context.material is not None

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.operator(DiffractImport.bl_idname)
        for name in ("surface", "pixel_size", "height", "material", "film", "grooves", "base_color"):
            self.layout.prop(context.material.diffract, name)


class DiffractRenderPanel(bpy.types.Panel):
    bl_label = "diffract"
    bl_idname = "RENDER_PT_diffract"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "render"

    @classmethod
    def poll(cls, context):
        return context.engine == engine.DiffractEngine.bl_idname

    def draw(self, context):
        self.layout.use_property_split = True
        for name in ("samples", "options"):
            self.layout.prop(context.scene.diffract, name)


def menu(self, context):
    self.layout.operator(DiffractImport.bl_idname, text="Material of diffract (material.json)")


CLASSES = (DiffractPreferences, DiffractSceneSettings, DiffractMaterialSettings, DiffractImport, DiffractMaterialPanel, DiffractRenderPanel)


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Scene.diffract = PointerProperty(type=DiffractSceneSettings)
    bpy.types.Material.diffract = PointerProperty(type=DiffractMaterialSettings)
    bpy.types.TOPBAR_MT_file_import.append(menu)
    engine.register()


def unregister():
    engine.unregister()
    bpy.types.TOPBAR_MT_file_import.remove(menu)
    del bpy.types.Scene.diffract, bpy.types.Material.diffract
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
