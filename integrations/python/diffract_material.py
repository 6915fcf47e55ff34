"""Reads a material that `diffract export` wrote, by Python's standard library alone.

    material = Material("skin")
    rgb = material.rgb(light, viewer, (dx, dy))

`python3 diffract_material.py FOLDER > answers.csv` answers the directions of FOLDER/conformance.csv;
`diffract export --check FOLDER --answers answers.csv` compares the answers with the table.

The function is written to be read and ported; docs/EXPORT.md explains it step by step.
"""

import cmath
import csv
import json
import math
import pathlib
import struct
import sys

VERSION = 4
LARGEST_W = 2.0
# Product of sines below which a direction is the normal.
NORMAL = 1e-12
# Rule for the taps of a footprint.
SPACING = 2.2
REACH = 2.8
TAPS_PER_DEVIATION = 5.729
MOST_OF_ROW = 201
ROUND = 0.2
# XYZ to linear sRGB, IEC 61966-2-1.
TO_SRGB = (
    (3.240969941904521, -1.537383177570094, -0.498610760293003),
    (-0.969243636280880, 1.875967501507721, 0.041555057407176),
    (0.055630079696994, -0.203976958888977, 1.056971514242879),
)


class Texels:
    """Levels of an RGBA16F array in a KTX2 file."""

    def __init__(self, path):
        self.data = data = pathlib.Path(path).read_bytes()
        if data[:12] != b"\xabKTX 20\xbb\r\n\x1a\n":
            raise ValueError(f"{path} is no KTX2 file")
        form, _, self.side, _, _, layers, _, mips, packed = struct.unpack_from("<9I", data, 12)
        if form != 97 or packed != 0:
            raise ValueError(f"{path} does not hold plain 16-bit floats")
        starts = [struct.unpack_from("<Q", data, 80 + 24 * mip)[0] for mip in range(mips)]
        # Each mip level has the layers of one level, and then those of the next.
        half = [4 * layers * (self.side >> mip) ** 2 for mip in range(mips)]
        self.offsets = [start + odd * half[mip] for mip, start in enumerate(starts) for odd in (0, 1)]

    def at(self, level, layer, row, column):
        """Returns the four numbers of a texel."""
        side = self.side >> level // 2
        return struct.unpack_from("<4e", self.data, self.offsets[level] + 8 * ((layer * side + row) * side + column))


def line(deviation, tap):
    """Returns places and weights that stand for a Gaussian of a standard deviation, where each averages over `tap`."""
    if deviation <= ROUND * tap:
        return [(0.0, 1.0)]
    count = int(min(max(math.ceil(TAPS_PER_DEVIATION * deviation / (SPACING * tap) + 1.0), 2), MOST_OF_ROW))
    fall = 0.5 * (2.0 * REACH / count) ** 2
    steps = [i - 0.5 * (count - 1) for i in range(count)]
    weights = [math.exp(-fall * n * n) for n in steps]
    norm = sum(weights)
    step = deviation * math.sqrt(norm / sum(weight * n * n for weight, n in zip(weights, steps)))
    return [(n * step, weight / norm) for weight, n in zip(weights, steps)]


def between(samples, place):
    """Returns samples over 0 ... 1, linear between two."""
    at = place * (len(samples) - 1)
    left = min(int(at), len(samples) - 2)
    return samples[left] + (at - left) * (samples[left + 1] - samples[left])


def small_slope(index, polarisation, light, viewer):
    """Returns |B|^2 for a refractive index n + ik, summed over the polarisations of the light that leaves."""
    squared = index * index
    sines = math.hypot(*light[:2]) * math.hypot(*viewer[:2])
    # At the normal the azimuth between the wave vectors is rounding, and the sum over polarisations does not depend on it.
    cosine = -(light[0] * viewer[0] + light[1] * viewer[1]) / sines if sines > NORMAL else 1.0
    cosine = min(max(cosine, -1.0), 1.0)
    sine2 = 1.0 - cosine * cosine
    q_i, q_r = (cmath.sqrt(squared - 1.0 + z * z) for z in (light[2], viewer[2]))
    s_i, s_r = light[2] + q_i, viewer[2] + q_r
    p_i, p_r = squared * light[2] + q_i, squared * viewer[2] + q_r
    te = abs(cosine / (s_r * s_i)) ** 2 + sine2 * abs(q_r / (p_r * s_i)) ** 2
    tm = abs((q_r * q_i * cosine - squared * sines) / (p_r * p_i)) ** 2 + sine2 * abs(q_i / (s_r * p_i)) ** 2
    return abs(squared - 1.0) ** 2 * {"none": 0.5 * (te + tm), "te": te, "tm": tm}[polarisation]


class Material:
    """Material in a folder that `diffract export` wrote."""

    def __init__(self, folder):
        folder = pathlib.Path(folder)
        about = json.loads((folder / "material.json").read_text())
        if about.get("format") != "diffract-material" or about.get("version") != VERSION:
            raise ValueError(f"{folder} is no export of a version that is known here")
        table = json.loads((folder / "table.json").read_text())
        self.texels = Texels(folder / "table.ktx2")
        self.grid = table["grid"]
        self.unit = table["unit"]
        self.blur = table["coherence_blur"]
        self.mean = table["mean_reflectance"]  # by Stam's theory
        self.indices = table.get("indices")  # by the small-slope approximation
        self.energy = table.get("energy")
        self.variances = table["specular"]["variances"]
        self.weights = table["specular"]["weights"]  # [band][sample of |w|][XYZ]
        self.pieces = table["basis"]["pieces"]
        self.components = table["basis"]["components"]
        self.cubics = table["basis"]["cubics"]  # [piece and component][XYZ][power of t]

    def variance(self, level):
        """Returns the variance of u and of v that a level averages over."""
        return self.grid["finest"] ** 2 + self.grid["growth"] ** 2 * (2.0**level - 1.0)

    def taps(self, uu, uv, vv):
        """Returns level, displacement and weight of each tap of a footprint with this covariance."""
        middle, difference = 0.5 * (uu + vv), 0.5 * (uu - vv)
        spread = math.hypot(difference, uv)
        longer, shorter = middle + spread, max(middle - spread, 0.0)
        angle = 0.5 * math.atan2(uv, difference)
        x, y = math.cos(angle), math.sin(angle)
        part = TAPS_PER_DEVIATION / (SPACING * MOST_OF_ROW)
        own = max(shorter, self.grid["finest"] ** 2, longer * part * part - self.blur)
        ratio = max((own - self.grid["finest"] ** 2) / self.grid["growth"] ** 2 + 1.0, 1.0)
        level = min(int(math.log2(ratio)), self.grid["levels"] - 1)
        read, blur = self.variance(level), self.blur
        rest = max(own - read, 0.0)

        def row(left, tap):
            return line(math.sqrt(max(left, 0.0)), math.sqrt(tap))

        if level + 1 < self.grid["levels"]:
            following = self.variance(level + 1)
            # Together as high in the middle as the footprint is across.
            finer, asked, coarser = (1.0 / math.sqrt(variance + blur) for variance in (read, read + rest, following))
            share = min((finer - asked) / (finer - coarser), 1.0)
            along = (longer - share * max(longer, following)) / max(1.0 - share, 1e-3) - read
            rows = [(level, 0.0, 1.0 - share, row(along, read + blur))]
            rows.append((level + 1, 0.0, share, row(longer - following, following + blur)))
        else:
            along = row(longer - read, read + blur)
            side_by_side = rest > ROUND**2 * (read + blur)
            sides = ((-1.0, 0.5), (1.0, 0.5)) if side_by_side else ((0.0, 1.0),)
            rows = [(level, side * math.sqrt(rest), weight, along) for side, weight in sides]
        for level, aside, weight, places in rows:
            for place, share in places:
                yield level, (x * place - y * aside, y * place + x * aside), weight * share

    def add(self, total, weight, piece, place, level):
        """Adds `weight` times the coordinates at a place, linear between texels and 0 outside."""
        side = self.texels.side >> level // 2
        at = [(x + self.grid["extent"]) * side / (2.0 * self.grid["extent"]) - 0.5 for x in place]
        left, low = (math.floor(x) for x in at)
        right_share, high_share = at[0] - left, at[1] - low
        layers = self.components // 4
        for row, row_share in ((low, 1.0 - high_share), (low + 1, high_share)):
            for column, column_share in ((left, 1.0 - right_share), (left + 1, right_share)):
                if 0 <= row < side and 0 <= column < side:
                    share = weight * row_share * column_share
                    for layer in range(layers):
                        for i, number in enumerate(self.texels.at(level, piece * layers + layer, row, column)):
                            total[4 * layer + i] += share * number

    def scattered(self, toward, w, taps):
        """Returns XYZ of all orders but the specular one, over |w|^2."""
        place = w / LARGEST_W * self.pieces
        piece = min(int(place), self.pieces - 1)
        t = 2.0 * (place - piece) - 1.0
        numbers = [0.0] * self.components
        for level, (x, y), weight in taps:
            if weight > 0.0:
                self.add(numbers, weight, piece, (toward[0] + x, toward[1] + y), level)
        powers = (1.0, t, t * t, t**3)
        xyz = [0.0, 0.0, 0.0]
        for number, cubics in zip(numbers, self.cubics[piece * self.components :]):
            for i in range(3):
                xyz[i] += number * sum(c * power for c, power in zip(cubics[i], powers))
        return [x * self.unit for x in xyz]

    def specular(self, toward, w, uu, uv, vv):
        """Returns XYZ of the specular order: a Gaussian of (u, v) for each band of wavelengths."""
        xyz = [0.0, 0.0, 0.0]
        for variance, weights in zip(self.variances, self.weights):
            xx, yy = variance + uu, variance + vv
            det = xx * yy - uv * uv
            r2 = (yy * toward[0] ** 2 - 2.0 * uv * toward[0] * toward[1] + xx * toward[1] ** 2) / det
            lobe = math.exp(-0.5 * r2) / (2.0 * math.pi * math.sqrt(det))
            for i in range(3):
                xyz[i] += lobe * between([sample[i] for sample in weights], w / LARGEST_W)
        return xyz

    def factors(self, light, viewer):
        """Returns the factors of X, Y and Z in f cos(theta_light), times w^2."""
        if self.indices:
            indices = [complex(n, k) for n, k in zip(self.indices["n"], self.indices["k"])]
            cosines = 4.0 * light[2] ** 2 * viewer[2]
            return [cosines * small_slope(index, self.indices["polarisation"], light, viewer) for index in indices]
        half2 = 0.5 * sum((a + b) ** 2 for a, b in zip(light, viewer))  # 1 + light . viewer
        reflectance = between(self.mean, min(math.sqrt(0.5 * half2), 1.0))  # over the cosine of the half angle
        return [reflectance * half2**2 / viewer[2]] * 3  # R G cos(theta_light)

    def excess(self, direction):
        """Returns the directional albedo over the reflectance of a flat surface, linear between the directions of a square grid."""
        side = math.isqrt(len(self.energy))
        scale = math.sqrt((1.0 + math.sqrt(direction[2])) * (1.0 + direction[2]))
        column, row = (min(max(0.5 + 0.5 * x / scale, 0.0), 1.0) * (side - 1) for x in direction[:2])
        left, low = min(int(column), side - 2), min(int(row), side - 2)

        def in_row(number):
            first, second = (self.energy[number * side + left + i][0] for i in (0, 1))
            return first + (column - left) * (second - first)

        return in_row(low) + (row - low) * (in_row(low + 1) - in_row(low))

    def limit(self, light, viewer):
        """Returns the divisor that keeps the surface from reflecting more than a flat one."""
        return max(1.0, self.excess(light), self.excess(viewer)) if self.energy else 1.0

    def rgb(self, light, viewer, footprint=((0.0, 0.0), (0.0, 0.0))):
        """Returns linear sRGB of f cos(theta_light) [1/sr].

        light, viewer: unit vectors away from the surface in its tangent frame, z along the normal.
        footprint: two vectors of (u, v) whose outer products add up to the covariance to average over.
        """
        (dx, dy) = footprint
        if light[2] <= 0.0 or viewer[2] <= 0.0:
            return [0.0, 0.0, 0.0]
        uu, uv, vv = dx[0] ** 2 + dy[0] ** 2, dx[0] * dx[1] + dy[0] * dy[1], dx[1] ** 2 + dy[1] ** 2
        toward, w = [light[0] + viewer[0], light[1] + viewer[1]], light[2] + viewer[2]  # -(u, v, w)
        scattered = self.scattered(toward, w, self.taps(uu, uv, vv))
        specular = self.specular(toward, w, uu, uv, vv)
        divisor = w * w * self.limit(light, viewer)
        xyz = [factor * (a * w * w + b) / divisor for factor, a, b in zip(self.factors(light, viewer), scattered, specular)]
        return [sum(m * x for m, x in zip(row, xyz)) for row in TO_SRGB]


def main(folder):
    material = Material(folder)
    out = csv.writer(sys.stdout)
    out.writerow(["r", "g", "b"])
    with open(pathlib.Path(folder) / "conformance.csv") as file:
        for row in csv.reader(file):
            if row[0] == "light_x":
                continue
            n = [float(cell) for cell in row]
            out.writerow(material.rgb(n[0:3], n[3:6], (n[6:8], n[8:10])))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit("usage: diffract_material.py FOLDER")
    main(sys.argv[1])
