# Draws a shape by the material of an export, and writes its linear colours and its mesh: the project has asked.json and the folder skin.
extends SceneTree

func _init():
    var asked = JSON.parse_string(FileAccess.get_file_as_string("res://asked.json"))
    var view = SubViewport.new()
    view.size = Vector2i(asked.size, asked.size)
    view.use_hdr_2d = true
    view.own_world_3d = true
    view.render_target_update_mode = SubViewport.UPDATE_ALWAYS
    root.add_child(view)
    var world = WorldEnvironment.new()
    world.environment = Environment.new()
    world.environment.background_mode = Environment.BG_COLOR
    world.environment.background_color = Color.BLACK
    view.add_child(world)
    var camera = Camera3D.new()
    camera.fov = 35.0
    view.add_child(camera)
    camera.look_at_from_position(vector(asked.eye), Vector3.ZERO)
    for place in asked.lights:
        var light = DirectionalLight3D.new()
        view.add_child(light)
        light.look_at_from_position(vector(place), Vector3.ZERO)
    var body = MeshInstance3D.new()
    body.mesh = shape(asked.shape)
    body.material_override = material(asked)
    body.rotation_degrees = vector(asked.rotation)
    view.add_child(body)
    for frame in 3:
        await process_frame
    await RenderingServer.frame_post_draw
    var image = view.get_texture().get_image()
    image.convert(Image.FORMAT_RGBAF)
    FileAccess.open("res://pixels.bin", FileAccess.WRITE).store_buffer(image.get_data())
    write_mesh(body)
    quit()

func vector(numbers) -> Vector3:
    return Vector3(numbers[0], numbers[1], numbers[2])

func shape(name: String) -> PrimitiveMesh:
    match name:
        "sphere":
            var sphere = SphereMesh.new()
            sphere.radius = 1.0
            sphere.height = 2.0
            sphere.radial_segments = 128
            sphere.rings = 64
            return sphere
        "torus":
            var torus = TorusMesh.new()
            torus.inner_radius = 0.4
            torus.outer_radius = 1.0
            torus.rings = 128
            torus.ring_segments = 64
            return torus
    var plane = PlaneMesh.new()
    plane.orientation = PlaneMesh.FACE_Z
    return plane

func material(asked) -> ShaderMaterial:
    var made = ShaderMaterial.new()
    made.shader = load("res://skin/material.gdshader")
    made.set_shader_parameter("diffract_turn", float(asked.turn))
    var images = {"diffract_table": "res://skin/table2d.exr", "diffract_functions": "res://skin/functions.exr"}
    for name in images:
        made.set_shader_parameter(name, ImageTexture.create_from_image(Image.load_from_file(images[name])))
    return made

# Writes an OBJ file. Godot has v from the top of an image, and the corners of fronts clockwise.
func write_mesh(body: MeshInstance3D):
    var arrays = body.mesh.surface_get_arrays(0)
    var lines = PackedStringArray()
    for v in arrays[Mesh.ARRAY_VERTEX]:
        v = body.transform * v
        lines.append("v %.7f %.7f %.7f" % [v.x, v.y, v.z])
    for uv in arrays[Mesh.ARRAY_TEX_UV]:
        lines.append("vt %.7f %.7f" % [uv.x, 1.0 - uv.y])
    for n in arrays[Mesh.ARRAY_NORMAL]:
        n = body.transform.basis * n
        lines.append("vn %.7f %.7f %.7f" % [n.x, n.y, n.z])
    var index = arrays[Mesh.ARRAY_INDEX]
    for i in range(0, index.size(), 3):
        var corners = [index[i], index[i + 2], index[i + 1]].map(func(c): return "%d/%d/%d" % [c + 1, c + 1, c + 1])
        lines.append("f " + " ".join(corners))
    FileAccess.open("res://shape.obj", FileAccess.WRITE).store_string("\n".join(lines) + "\n")
