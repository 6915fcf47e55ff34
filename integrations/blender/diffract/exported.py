"""Reads the folder of an export as arrays."""

import json
import math
import pathlib

import numpy as np

VERSION = 4
# XYZ to linear sRGB, IEC 61966-2-1.
SRGB_FROM_XYZ = np.array(
    [
        [3.2409699419, -1.5373831776, -0.4986107603],
        [-0.9692436363, 1.8759675015, 0.0415550574],
        [0.0556300797, -0.2039769589, 1.0569715142],
    ]
)
LARGEST_W = 2.0
# Beyond this many variances a lobe of the specular order is negligible.
NOWHERE = 40.0


class Export:
    """Export in a folder: what `material.json` and `table.json` say, for single directions."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        about = json.loads((self.folder / "material.json").read_text())
        if about.get("format") != "diffract-material" or about.get("version") != VERSION:
            raise ValueError(f"{folder} holds no export of version {VERSION}; export it again, or take the add-on of its diffract")
        table = json.loads((self.folder / "table.json").read_text())
        basis = table["basis"]
        self.name = self.folder.resolve().name
        self.side = table["grid"]["side"]
        self.extent = table["grid"]["extent"]
        self.pieces = basis["pieces"]
        self.texels = basis["components"] // 4
        # [piece][component][XYZ][power of t], in 1/sr.
        self.cubics = np.array(basis["cubics"]).reshape(self.pieces, 4 * self.texels, 3, 4) * table["unit"]
        self.variances = np.array(table["specular"]["variances"])
        self.weights = np.array(table["specular"]["weights"])  # [band][sample of w][XYZ]
        self.mean_reflectance = table.get("mean_reflectance")
        self.indices = table.get("indices")
        energy = table.get("energy")
        self.energy = None
        if energy:
            side = math.isqrt(len(energy))
            self.energy = np.array(energy)[:, 0].reshape(side, side)

    def layer(self, image, piece, texel):
        """Returns a layer of the finest level from `image`, [line][column][RGBA] of table2d.exr from its upper line on."""
        columns = image.shape[1] // self.side
        row, column = divmod(piece * self.texels + texel, columns)
        return image[row * self.side :, column * self.side :][: self.side, : self.side]

    def lobe(self, count):
        """Returns XYZ of the specular order, [sample of w][sample of |(u, v)|], and the largest |(u, v)|."""
        most = math.sqrt(NOWHERE * self.variances.max())
        radii = np.linspace(0.0, most, count)
        lobes = np.exp(-0.5 * radii**2 / self.variances[:, None]) / (2.0 * math.pi * self.variances[:, None])
        return np.einsum("br,bwc->wrc", lobes, self.weights), most


class Slants:
    """Functions of the cosine of one direction whose products make |B|^2 of the small-slope approximation.

    With a = |1/(z + q)|^2, b = |q/(e z + q)|^2, p = |e/(e z + q)^2| and g = q sqrt(e*) / |e z + q|^2, where e is n + ik squared and q the root of
    e - 1 + z^2, the formulas of src/optics/small_slope.rs become

        te = c^2 a a' + s^2 a b'                                                              (light, viewer')
        tm = s^2 b a' + c^2 b b' + p p' (sin sin')^2 - 2 sin sin' c Re(g g')

    times |e - 1|^2, where c and s are cosine and sine of the azimuth between the wave vectors.
    """

    ROWS = ("a", "b", "p", "g", "h")  # h: imaginary part of g

    def __init__(self, indices, count):
        z = np.linspace(0.0, 1.0, count)[:, None]
        index = np.array(indices["n"]) + 1j * np.array(indices["k"])
        e = index**2
        q = np.sqrt(e - 1.0 + z * z + 0j)
        a = np.abs(1.0 / (z + q)) ** 2
        p = 1.0 / np.abs(e * z + q) ** 2
        g = q * np.sqrt(np.conj(e)) * p
        # [row][sample of z][X, Y and Z]
        self.rows = np.stack([a, np.abs(q) ** 2 * p, np.abs(e) * p, g.real, g.imag])
        self.contrast = np.abs(e - 1.0) ** 2
        self.polarisation = indices["polarisation"]
        self.absorbs = bool(np.any(np.array(indices["k"]) != 0.0))
