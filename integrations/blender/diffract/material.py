"""Makes materials of exports: of plain nodes, or of a script in OSL."""

import bpy

from . import lights, nodes, script


def tangent(tree, uv_map):
    """Returns a socket with the direction in which u grows, or without coordinates one around the object's z."""
    node = tree.nodes.new("ShaderNodeTangent")
    if uv_map:
        node.direction_type, node.uv_map = "UV_MAP", uv_map
    else:
        node.direction_type, node.axis = "RADIAL", "Z"
    return node.outputs[0]


def shown(name, radiances):
    """Returns a material that sends the sum of vectors of `radiances`, functions of its tree, toward the viewer."""
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    total = None
    for radiance in radiances(tree):
        if total is None:
            total = radiance
            continue
        node = tree.nodes.new("ShaderNodeVectorMath")
        tree.links.new(total, node.inputs[0])
        tree.links.new(radiance, node.inputs[1])
        total = node.outputs[0]
    emission = tree.nodes.new("ShaderNodeEmission")
    tree.links.new(total, emission.inputs["Color"])
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    return material


def of_nodes(folder, suns, uv_map=None, turn=0.0):
    """Returns the material of the export in `folder` under the light objects `suns`, of plain nodes.

    uv_map: texture coordinates along whose u the rows of the height field run. turn: rotation of the rows about the normal [rad].
    """
    group = nodes.group(folder)

    def radiances(tree):
        along = tangent(tree, uv_map)
        graph, former = nodes.Graph(tree), None
        for sun in suns:
            node = tree.nodes.new("ShaderNodeGroup")
            node.node_tree = group
            toward, irradiance = lights.direction_and_irradiance(tree, sun)
            toward = graph.after(toward, former)
            for name, socket in (("Light", toward), ("Irradiance", irradiance), ("Tangent", along)):
                tree.links.new(socket, node.inputs[name])
            node.inputs["Turn"].default_value = turn
            former = node.outputs[0]
            yield former

    return shown(group.name, radiances)


def of_script(folder, suns, uv_map=None, turn=0.0, shadows=True):
    """Returns the material of the export in `folder` as a script in OSL, which only Cycles on CPUs and OptiX runs, with traced shadows."""
    text = script.text(folder)

    def radiances(tree):
        along = tangent(tree, uv_map)
        for sun in suns:
            node = tree.nodes.new("ShaderNodeScript")
            node.mode, node.script = "INTERNAL", text
            script.compile_node(node)
            toward, irradiance = lights.direction_and_irradiance(tree, sun)
            for name, socket in (("Light", toward), ("Irradiance", irradiance), ("Tangent", along)):
                tree.links.new(socket, node.inputs[name])
            node.inputs["Turn"].default_value = turn
            node.inputs["Shadows"].default_value = int(shadows)
            node.inputs["AtInfinity"].default_value = int(sun.data.type == "SUN")
            yield node.outputs["Radiance"]

    return shown(f"{text.name.removesuffix('.osl')} (OSL)", radiances)
