"""Feeds direction and irradiance of light objects to nodes, by drivers that follow the objects."""

import math

# The direction toward a sun, the z axis of its rotation x, y, z.
TOWARD_SUN = ("cos(x)*sin(y)*cos(z)+sin(x)*sin(z)", "cos(x)*sin(y)*sin(z)-sin(x)*cos(z)", "cos(x)*cos(y)")


def follow(socket, index, expression, target, transforms=(), paths=()):
    """Lets a socket's value follow an object: variables x, y, z of `transforms`, or of the `paths` of its data."""
    curve = socket.driver_add("default_value", index) if index is not None else socket.driver_add("default_value")
    driver = curve.driver
    for name, transform in zip("xyz", transforms):
        variable = driver.variables.new()
        variable.name, variable.type = name, "TRANSFORMS"
        variable.targets[0].id = target
        variable.targets[0].transform_type = transform
        variable.targets[0].transform_space = "WORLD_SPACE"
        variable.targets[0].rotation_mode = "XYZ"
    for name, path in zip("xyz", paths):
        variable = driver.variables.new()
        variable.name, variable.type = name, "SINGLE_PROP"
        variable.targets[0].id_type = "OBJECT"
        variable.targets[0].id = target
        variable.targets[0].data_path = path
    driver.expression = expression


def vector(tree, expressions, **driver):
    """Returns a socket of a vector whose components follow an object."""
    node = tree.nodes.new("ShaderNodeCombineXYZ")
    for socket, expression in zip(node.inputs, expressions):
        follow(socket, None, expression, **driver)
    return node.outputs[0]


def direction_and_irradiance(tree, light):
    """Returns sockets of the direction toward a sun or point light, and of the linear RGB of its irradiance.

    A sun has its strength, a point light its power over the sphere of its distance.
    """
    colors = [f"data.color[{i}]" for i in range(3)]
    if light.data.type == "SUN":
        toward = vector(tree, TOWARD_SUN, target=light, transforms=("ROT_X", "ROT_Y", "ROT_Z"))
        irradiance = tree.nodes.new("ShaderNodeCombineXYZ")
        for socket, color in zip(irradiance.inputs, colors):
            follow(socket, None, "x*y", light, paths=("data.energy", color))
        return toward, irradiance.outputs[0]
    place = vector(tree, "xyz", target=light, transforms=("LOC_X", "LOC_Y", "LOC_Z"))
    position = tree.nodes.new("ShaderNodeNewGeometry").outputs["Position"]
    toward = tree.nodes.new("ShaderNodeVectorMath")
    toward.operation = "SUBTRACT"
    tree.links.new(place, toward.inputs[0])
    tree.links.new(position, toward.inputs[1])
    squared = tree.nodes.new("ShaderNodeVectorMath")
    squared.operation = "DOT_PRODUCT"
    tree.links.new(toward.outputs[0], squared.inputs[0])
    tree.links.new(toward.outputs[0], squared.inputs[1])
    power = tree.nodes.new("ShaderNodeCombineXYZ")
    for socket, color in zip(power.inputs, colors):
        follow(socket, None, f"x*y/{4.0 * math.pi!r}", light, paths=("data.energy", color))
    spread = tree.nodes.new("ShaderNodeCombineXYZ")
    for socket in spread.inputs:
        tree.links.new(squared.outputs["Value"], socket)
    irradiance = tree.nodes.new("ShaderNodeVectorMath")
    irradiance.operation = "DIVIDE"
    tree.links.new(power.outputs[0], irradiance.inputs[0])
    tree.links.new(spread.outputs[0], irradiance.inputs[1])
    return toward.outputs[0], irradiance.outputs[0]


def usable(objects):
    """Returns those of the objects that are suns or point lights."""
    return [thing for thing in objects if thing.type == "LIGHT" and thing.data.type in ("SUN", "POINT")]
