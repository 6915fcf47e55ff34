"""Builds the material of an export from plain shader nodes, which Cycles runs on any device, and EEVEE."""

import math

import bpy
import numpy as np

from .exported import LARGEST_W, SRGB_FROM_XYZ, Export, Slants

# Samples of the functions of one cosine, and of the specular order over |(u, v)|.
SAMPLES = 512
# Cosines below this are below the horizon: HORIZON of shaders/pair.glsl.
HORIZON = 1e-6


def image_of(name, texels):
    """Returns a float image, packed into the file, of [row from v = 0 on][column][RGBA or RGB]."""
    height, width, channels = texels.shape
    image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.alpha_mode = "CHANNEL_PACKED"
    full = np.ones((height, width, 4), np.float32)
    full[..., :channels] = texels
    image.pixels.foreach_set(full.ravel())
    image.update()
    image.pack()
    return image


def pixels_of(path):
    """Returns the pixels of a picture file, [line from the upper one on][column][RGBA]."""
    image = bpy.data.images.load(str(path))
    try:
        image.colorspace_settings.name = "Non-Color"
        image.alpha_mode = "CHANNEL_PACKED"
        width, height = image.size
        pixels = np.empty(4 * width * height, np.float32)
        image.pixels.foreach_get(pixels)
        return pixels.reshape(height, width, 4)[::-1]
    finally:
        bpy.data.images.remove(image)


class Graph:
    """Nodes of a group, by the operations of a formula. Operands are sockets and numbers."""

    def __init__(self, tree):
        self.tree = tree

    def node(self, kind, *inputs, **properties):
        node = self.tree.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        for socket, value in zip(node.inputs, inputs):
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            elif value is not None:
                socket.default_value = value
        return node

    def number(self, operation, *inputs):
        return self.node("ShaderNodeMath", *inputs, operation=operation).outputs[0]

    def vector(self, operation, *inputs):
        return self.node("ShaderNodeVectorMath", *inputs, operation=operation).outputs[0]

    def dot(self, a, b):
        return self.node("ShaderNodeVectorMath", a, b, operation="DOT_PRODUCT").outputs["Value"]

    def times(self, vector, number):
        node = self.node("ShaderNodeVectorMath", vector, operation="SCALE")
        if isinstance(number, bpy.types.NodeSocket):
            self.tree.links.new(number, node.inputs["Scale"])
        else:
            node.inputs["Scale"].default_value = number
        return node.outputs[0]

    def product(self, *numbers):
        result = numbers[0]
        for number in numbers[1:]:
            result = self.number("MULTIPLY", result, number)
        return result

    def combined(self, x, y, z=0.0):
        return self.node("ShaderNodeCombineXYZ", x, y, z).outputs[0]

    def separated(self, vector):
        return self.node("ShaderNodeSeparateXYZ", vector).outputs

    def texture(self, image, x, y):
        return self.texture_at(image, self.combined(x, y))

    def texture_at(self, image, place):
        node = self.node("ShaderNodeTexImage", place, image=image, interpolation="Linear", extension="EXTEND")
        return node.outputs["Color"], node.outputs["Alpha"]

    def after(self, vector, result):
        """Returns `vector`, known no sooner than another vector, `result`.

        Cycles computes whatever it has the operands of, and has room for 255 numbers: without an order it computes all at once and runs out of room. The factor
        is small enough to change nothing, and no 0, with which the sum would be simplified.
        """
        return vector if result is None else self.vector("MULTIPLY_ADD", result, (1e-30, 1e-30, 1e-30), vector)

    def linear(self, a, factor, offset):
        return self.number("MULTIPLY_ADD", a, factor, offset)


class Material:
    """Builder of the node group of one export."""

    def __init__(self, export):
        self.export = export
        self.tree = bpy.data.node_groups.new(f"diffract {export.name}", "ShaderNodeTree")
        self.graph = Graph(self.tree)
        for name, kind in (("Light", "NodeSocketVector"), ("Irradiance", "NodeSocketVector"), ("Tangent", "NodeSocketVector"), ("Turn", "NodeSocketFloat")):
            self.tree.interface.new_socket(name, in_out="INPUT", socket_type=kind)
        self.tree.interface.new_socket("Radiance", in_out="OUTPUT", socket_type="NodeSocketVector")
        self.image = pixels_of(export.folder / "table2d.exr")

    def build(self):
        """Returns the group: radiance toward the viewer under one light."""
        g = self.graph
        given = self.tree.nodes.new("NodeGroupInput").outputs
        geometry = self.tree.nodes.new("ShaderNodeNewGeometry").outputs
        normal, view = geometry["Normal"], geometry["Incoming"]
        light = g.vector("NORMALIZE", given["Light"])
        flat = g.vector("SUBTRACT", given["Tangent"], g.times(normal, g.dot(given["Tangent"], normal)))
        unturned = g.vector("NORMALIZE", flat)
        turned = self.tree.nodes.new("ShaderNodeVectorRotate")
        for name, value in (("Vector", unturned), ("Axis", normal), ("Angle", given["Turn"])):
            self.tree.links.new(value, turned.inputs[name])
        tangent = turned.outputs[0]
        bitangent = g.vector("CROSS_PRODUCT", normal, tangent)
        self.light, self.view = ([g.dot(direction, axis) for axis in (tangent, bitangent, normal)] for direction in (light, view))
        self.x, self.y, self.w = (g.number("ADD", a, b) for a, b in zip(self.light, self.view))
        xyz_over_w2 = g.vector("ADD", self.scattered(), self.specular())
        xyz = g.vector("MULTIPLY", xyz_over_w2, self.factor())
        rows = [g.dot(xyz, tuple(row)) for row in SRGB_FROM_XYZ]
        lit = g.product(*(g.number("GREATER_THAN", direction[2], HORIZON) for direction in (self.light, self.view)))
        radiance = g.vector("MULTIPLY", g.times(g.combined(*rows), lit), given["Irradiance"])
        out = self.tree.nodes.new("NodeGroupOutput")
        self.tree.links.new(radiance, out.inputs[0])
        return self.tree

    def scattered(self):
        """Returns XYZ of all orders but the specular one, over the factor."""
        g, export = self.graph, self.export
        # A border of zeros: beyond the outermost texels the numbers fall to 0.
        size = export.side + 2
        u, v = (g.linear(place, export.side / (2.0 * export.extent * size), 0.5) for place in (self.x, self.y))
        place = g.combined(u, v)
        position = g.number("MULTIPLY", self.w, export.pieces / LARGEST_W)
        total = None
        for piece in range(export.pieces):
            at = g.after(place, total)
            numbers = []
            for texel in range(export.texels):
                texels = np.pad(export.layer(self.image, piece, texel), ((1, 1), (1, 1), (0, 0)))
                color, alpha = g.texture_at(image_of(f"{export.name} {piece}.{texel}", texels), at)
                numbers += [*g.separated(color), alpha]
            # All pieces are read, and one of them counts: where one was chosen before it is read, EEVEE would draw a seam.
            first = -1.0 if piece == 0 else float(piece)
            last = 4.0 if piece == export.pieces - 1 else piece + 1.0
            inside = g.product(g.number("GREATER_THAN", position, first), g.number("LESS_THAN", position, last))
            t = g.linear(position, 2.0, -2.0 * piece - 1.0)
            powers = g.combined(t, t, t)
            part = None
            for number, cubic in zip(numbers, export.cubics[piece]):
                color = tuple(cubic[:, 3])
                for power in (2, 1, 0):
                    color = g.vector("MULTIPLY_ADD", color, powers, tuple(cubic[:, power]))
                term = g.times(color, number)
                part = term if part is None else g.vector("ADD", part, term)
            part = g.times(part, inside)
            total = part if total is None else g.vector("ADD", total, part)
        return total

    def specular(self):
        """Returns XYZ of the specular order over w^2 and the factor."""
        g = self.graph
        texels, most = self.export.lobe(SAMPLES)
        radius = g.number("SQRT", g.number("ADD", g.product(self.x, self.x), g.product(self.y, self.y)))
        place = g.number("MINIMUM", g.number("DIVIDE", radius, most), 1.0)
        image = image_of(f"{self.export.name} specular", texels.astype(np.float32))
        color = self.between_texels(image, place, g.number("DIVIDE", self.w, LARGEST_W))
        return g.vector("DIVIDE", color, g.combined(*[g.product(self.w, self.w)] * 3))

    def between_texels(self, image, *places):
        """Returns the color at places from 0 to 1, linear between texels that are read without any filter.

        The filter of EEVEE takes means of many texels where places change fast, and these would carry the peak far from it.
        """
        g = self.graph
        sides = []
        for place, count in zip(places, image.size):
            at = g.number("MULTIPLY", place, count - 1.0)
            low = g.number("MINIMUM", g.number("FLOOR", at), count - 2.0)
            sides.append((g.linear(low, 1.0 / count, 0.5 / count), g.linear(low, 1.0 / count, 1.5 / count), g.number("SUBTRACT", at, low)))
        (left, right, across), (lower, upper, up) = sides

        def read(x, y):
            return g.node("ShaderNodeTexImage", g.combined(x, y), image=image, interpolation="Closest", extension="EXTEND").outputs["Color"]

        def mixed(a, b, share):
            return g.vector("ADD", a, g.times(g.vector("SUBTRACT", b, a), share))

        return mixed(mixed(read(left, lower), read(right, lower), across), mixed(read(left, upper), read(right, upper), across), up)

    def sample(self, place, count):
        """Returns the texture coordinate of a place from 0 to 1 between the first and the last of so many samples."""
        return self.graph.linear(place, (count - 1.0) / count, 0.5 / count)

    def factor(self):
        """Returns w^2 F for X, Y and Z, where F is the factor of f cos(theta_i) that the theory has around the power."""
        g, export = self.graph, self.export
        if export.indices:
            factor = self.small_slope()
        elif export.mean_reflectance:
            half2 = g.number("MULTIPLY", self.sum_of_squares(), 0.5)  # 1 + light . viewer
            row = np.repeat(np.array(export.mean_reflectance)[None, :, None], 3, 2)
            cosine = g.number("MINIMUM", g.number("SQRT", g.number("MULTIPLY", half2, 0.5)), 1.0)
            mean, _ = g.texture(image_of(f"{export.name} R", row), self.sample(cosine, row.shape[1]), 0.5)
            factor = g.times(mean, g.number("DIVIDE", g.product(half2, half2), g.number("MAXIMUM", self.view[2], HORIZON)))
        else:
            cosines = g.product(self.light[2], self.light[2], self.view[2], 4.0)
            factor = g.combined(cosines, cosines, cosines)
        return g.times(factor, g.number("DIVIDE", 1.0, self.limit())) if export.energy is not None else factor

    def sum_of_squares(self):
        g = self.graph
        squares = [g.product(c, c) for c in (self.x, self.y, self.w)]
        return g.number("ADD", g.number("ADD", squares[0], squares[1]), squares[2])

    def small_slope(self):
        """Returns 4 cos^2(theta_i) cos(theta_r) |B|^2 for X, Y and Z."""
        g, export = self.graph, self.export
        slants = Slants(export.indices, SAMPLES)
        # Each row three times: the filter of a GPU would mix a little of its neighbours in.
        rows = np.repeat(slants.rows, 3, 0)
        image = image_of(f"{export.name} slants", rows.astype(np.float32))

        def read(row, cosine):
            place = self.sample(g.number("MAXIMUM", cosine, 0.0), SAMPLES)
            return g.texture(image, place, (3 * Slants.ROWS.index(row) + 1.5) / rows.shape[0])[0]

        a, b, p, re = ([read(row, direction[2]) for direction in (self.light, self.view)] for row in "abpg")
        squares = [g.number("MAXIMUM", g.linear(g.product(d[2], d[2]), -1.0, 1.0), 0.0) for d in (self.light, self.view)]
        sines2 = g.product(*squares)
        # Cosine of the azimuth between the wave vectors, times both sines.
        along = g.number("ADD", g.product(self.light[0], self.view[0]), g.product(self.light[1], self.view[1]))
        raw = g.number("DIVIDE", g.product(along, along), g.number("MAXIMUM", sines2, 1e-12))
        # At the normal the azimuth is rounding, and the sum over polarisations does not depend on it.
        at_normal = g.number("LESS_THAN", sines2, 1e-12)
        c2 = g.number("MINIMUM", g.number("MAXIMUM", raw, at_normal), 1.0)
        s2 = g.linear(c2, -1.0, 1.0)

        def products(first, second, factor):
            return g.times(g.vector("MULTIPLY", first, second), factor)

        real = g.vector("MULTIPLY", *re)
        if slants.absorbs:
            imaginary = [read("h", direction[2]) for direction in (self.light, self.view)]
            real = g.vector("SUBTRACT", real, g.vector("MULTIPLY", *imaginary))
        te = g.vector("ADD", products(*a, c2), products(a[0], b[1], s2))
        tm = g.vector("ADD", products(b[0], a[1], s2), products(*b, c2))
        tm = g.vector("ADD", tm, products(*p, sines2))
        tm = g.vector("ADD", tm, g.times(real, g.number("MULTIPLY", along, 2.0)))
        mean = g.times(g.vector("ADD", te, tm), 0.5)
        power = {"none": mean, "te": te, "tm": tm}[slants.polarisation]
        cosines = g.product(self.light[2], self.light[2], self.view[2], 4.0)
        return g.vector("MULTIPLY", g.times(power, cosines), tuple(slants.contrast))

    def limit(self):
        """Returns the divisor that keeps the surface from reflecting more than a flat one."""
        g = self.graph
        texels = np.repeat(self.export.energy[:, :, None], 3, 2)
        image = image_of(f"{self.export.name} energy", texels.astype(np.float32))
        side = texels.shape[0]

        def excess(direction):
            z = g.number("MAXIMUM", direction[2], 0.0)
            scale = g.product(g.number("ADD", g.number("SQRT", z), 1.0), g.number("ADD", z, 1.0))
            radius = g.number("INVERSE_SQRT", scale)
            u, v = (self.sample(g.linear(g.product(c, radius), 0.5, 0.5), side) for c in direction[:2])
            return g.separated(g.texture(image, u, v)[0])[0]

        return g.number("MAXIMUM", g.number("MAXIMUM", excess(self.light), excess(self.view)), 1.0)


def group(folder):
    """Returns the node group of the export in `folder`."""
    return Material(Export(folder)).build()
