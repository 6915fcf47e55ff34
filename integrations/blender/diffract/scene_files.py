"""Writes a Blender scene as the files that `diffract render` takes: a scene file, and an OBJ for each object."""

import math
import pathlib

import bpy
import numpy as np

# Elevation below which an eye counts as above or below its target.
POLE = 1e-6


def quoted(text):
    """Returns a string as TOML has it."""
    escaped = str(text).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{escaped}"'


def triple(values):
    return "[" + ", ".join(f"{float(np.float32(x))!r}" for x in values) + "]"


def write_obj(path, thing, depsgraph):
    """Writes the mesh of an object as the renderer has it, in world space."""
    evaluated = thing.evaluated_get(depsgraph)
    mesh = evaluated.to_mesh()
    try:
        mesh.transform(evaluated.matrix_world)
        if evaluated.matrix_world.is_negative:
            mesh.flip_normals()
        mesh.calc_loop_triangles()
        triangles = mesh.loop_triangles
        if not triangles:
            return False
        lines = [f"v {v.co.x:.9g} {v.co.y:.9g} {v.co.z:.9g}" for v in mesh.vertices]
        uvs = mesh.uv_layers.active
        if uvs:
            lines += [f"vt {uv.vector.x:.9g} {uv.vector.y:.9g}" for uv in uvs.uv]
        lines += [f"vn {n.vector.x:.9g} {n.vector.y:.9g} {n.vector.z:.9g}" for n in mesh.corner_normals]
        corner = "{0}/{1}/{1}" if uvs else "{0}//{1}"
        for triangle in triangles:
            corners = zip(triangle.vertices, triangle.loops)
            lines.append("f " + " ".join(corner.format(vertex + 1, loop + 1) for vertex, loop in corners))
        path.write_text("\n".join(lines) + "\n")
        return True
    finally:
        evaluated.to_mesh_clear()


def camera_lines(scene, camera, depsgraph, size):
    """Returns the table of the camera."""
    matrix = camera.matrix_world.normalized()
    right, up, back = (np.array(matrix.col[i][:3]) for i in range(3))
    eye = np.array(matrix.translation)
    target = eye - back
    if math.hypot(back[0], back[1]) < POLE:
        # The azimuth of an eye that stands above its target is that of +x.
        target[:2] = eye[:2]
    eye, target = (place.astype(np.float32) for place in (eye, target))
    offset = eye - target
    azimuth = math.atan2(offset[1], offset[0])
    level = np.array([-math.sin(azimuth), math.cos(azimuth), 0.0])
    # Turned clockwise, the camera's up leans to its right.
    roll = math.atan2(up @ level, right @ level)
    render = scene.render
    projection = camera.calc_matrix_camera(depsgraph, x=size[0], y=size[1], scale_x=render.pixel_aspect_x, scale_y=render.pixel_aspect_y)
    aspect = size[0] / size[1]
    if camera.data.type == "ORTHO":
        lens = f"height = {2.0 / projection[1][1]!r}"
        shift = (-0.5 * aspect * projection[0][3], -0.5 * projection[1][3])
    else:
        lens = f'field_of_view = "{2.0 * math.atan(1.0 / projection[1][1])!r}rad"'
        shift = (0.5 * aspect * projection[0][2], 0.5 * projection[1][2])
    return ["[camera]", f"eye = {triple(eye)}", f"target = {triple(target)}", lens, f'roll = "{roll!r}rad"', f"shift = [{shift[0]!r}, {shift[1]!r}]"]


def luminance(color):
    return 0.2126 * color[0] + 0.7152 * color[1] + 0.0722 * color[2]


def polar(direction):
    """Returns degrees from up and around it."""
    x, y, z = direction
    return math.degrees(math.acos(max(-1.0, min(1.0, z)))), math.degrees(math.atan2(y, x))


def light_words(light):
    """Returns a light as after `--light`, or None for a kind that diffract has not."""
    data, matrix = light.data, light.matrix_world
    strength = data.energy * luminance(data.color)
    place = ",".join(f"{x:.9g}" for x in matrix.translation)
    if data.type == "SUN":
        theta, phi = polar(matrix.to_3x3().col[2].normalized())
        kind = f"disc:{math.degrees(data.angle):.9g}deg:" if data.angle > 1e-4 else ""
        return f"{kind}{theta:.9g},{phi:.9g},{strength / math.pi:.9g}"
    if data.type == "POINT":
        return f"sphere:{2.0 * max(data.shadow_soft_size, 1e-3):.9g}:{place},{strength:.9g}W"
    if data.type == "AREA" and data.shape in ("SQUARE", "RECTANGLE"):
        height = data.size if data.shape == "SQUARE" else data.size_y
        faced = ",".join(f"{x:.9g}" for x in matrix.translation - matrix.to_3x3().col[2].normalized())
        return f"rectangle:{data.size:.9g}x{height:.9g}:{place},{strength:.9g}W:{faced}"
    return None


def world_lines(scene, folder):
    """Returns the table of the surroundings, for a background of one colour or one equirectangular picture."""
    world = scene.world
    if world is None:
        return []
    background = None
    if world.node_tree and (bpy.app.version >= (5, 0, 0) or world.use_nodes):
        background = next((node for node in world.node_tree.nodes if node.type == "BACKGROUND"), None)
    color, strength = (world.color, 1.0) if background is None else (background.inputs["Color"].default_value, background.inputs["Strength"].default_value)
    links = [] if background is None else background.inputs["Color"].links
    source = links[0].from_node if links else None
    if strength <= 0.0:
        return []
    if source is not None and source.type == "TEX_ENVIRONMENT" and source.image:
        name = bpy.path.abspath(source.image.filepath)
    elif source is None and max(color[:3]) > 0.0:
        name = str(folder / "world.exr")
        constant(folder / "world.exr", color[:3])
    else:
        return []
    return ["[environment]", f"name = {quoted(name)}", f"exposure = {math.log2(strength)!r}"]


def constant(path, color):
    """Writes an equirectangular picture of one colour."""
    image = bpy.data.images.new("world", 8, 4, float_buffer=True)
    try:
        image.pixels.foreach_set([*color, 1.0] * 32)
        image.file_format = "OPEN_EXR"
        image.filepath_raw = str(path)
        image.save()
    finally:
        bpy.data.images.remove(image)


def surface_lines(material):
    """Returns the lines of an object with this material, whose settings are those of the panel."""
    if material is None:
        return ["base_color = [0.8, 0.8, 0.8]"]
    settings = material.diffract
    color = settings.base_color if settings.surface else material.diffuse_color
    lines = [f"base_color = {triple(color[:3])}"]
    if not settings.surface:
        return lines
    is_file = pathlib.Path(bpy.path.abspath(settings.surface)).suffix != ""
    surface = bpy.path.abspath(settings.surface) if is_file else settings.surface
    lines.append(f"surface = {quoted(surface)}")
    for key in ("pixel_size", "height", "material", "film", "grooves"):
        value = getattr(settings, key)
        if value:
            lines.append(f"{key} = {quoted(value)}")
    return lines


def write(folder, depsgraph, size):
    """Writes the scene of `depsgraph` into `folder`, and returns the path of its file and the names of what is left out."""
    folder = pathlib.Path(folder)
    scene = depsgraph.scene_eval
    left_out, things = [], []
    instances = [instance.object for instance in depsgraph.object_instances if not instance.is_instance]
    left_out += sorted({f"instances of {i.object.name}" for i in depsgraph.object_instances if i.is_instance})
    for thing in instances:
        if thing.type in ("MESH", "CURVE", "SURFACE", "FONT", "META"):
            path = folder / f"{len(things)}.obj"
            if write_obj(path, thing.original, depsgraph):
                material = thing.active_material.original if thing.active_material else None
                things.append((path.name, material))
    # The first object has a surface.
    things.sort(key=lambda pair: not (pair[1] and pair[1].diffract.surface))
    if not things or not (things[0][1] and things[0][1].diffract.surface):
        raise ValueError("no object has a material with a surface; name one under diffract in a material's panel")
    lights = [thing for thing in instances if thing.type == "LIGHT"]
    words = [light_words(light) for light in lights]
    left_out += [f"the light {light.name}" for light, word in zip(lights, words) if word is None]
    lines = [f"mesh = {quoted(things[0][0])}", 'up = "z"', f'scale = "{scene.unit_settings.scale_length!r}m"']
    lines += surface_lines(things[0][1])
    lines.append("lights = [" + ", ".join(quoted(word) for word in words if word) + "]")
    lines += camera_lines(scene, scene.camera.original, depsgraph, size)
    lines += world_lines(scene, folder)
    for name, material in things[1:]:
        lines += ["[[objects]]", f"mesh = {quoted(name)}", 'up = "z"', *surface_lines(material)]
    path = folder / "scene.toml"
    path.write_text("\n".join(lines) + "\n")
    return path, left_out
