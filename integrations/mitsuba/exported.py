"""Reads a folder that `diffract export` wrote into NumPy arrays. docs/EXPORT.md explains its files."""

import json
import math
import struct
from pathlib import Path

import numpy as np

LARGEST_W = 2.0
# XYZ to linear sRGB, IEC 61966-2-1.
TO_SRGB = np.array(
    [
        (3.240969941904521, -1.537383177570094, -0.498610760293003),
        (-0.969243636280880, 1.875967501507721, 0.041555057407176),
        (0.055630079696994, -0.203976958888977, 1.056971514242879),
    ]
)
FORMAT, VERSION = "diffract-material", 4
# Format of table.ktx2: VK_FORMAT_R16G16B16A16_SFLOAT.
HALVES = 97
# A material hides the pigment below if light is darker than 1/e at this depth [um], by k at this wavelength [um].
OPAQUE_WITHIN, MIDDLE = 10.0, 0.55


class ExportError(Exception):
    """A folder that cannot be read, and what to do about it."""


class Export:
    """Material in a folder.

    levels: arrays of texels, [layer][row][column][4], the finest first, two of each size. cubics: [piece][component][XYZ][power of t], in 1/sr. specular: [band][sample of
    |w|][XYZ]. variances: of u, for each band.

    By Stam's theory, mean: the mean reflectance over the cosine at the half vector. By the small-slope approximation, indices: n + ik for X, Y and Z;
    polarisation: of the light. What the other theory has is None. energy: the limit of energy over directions, [row along y][column along x][2]: the directional
    albedo over the reflectance of a flat surface, and the root of the factor of a pigment; None if the theory is not limited.
    """

    def __init__(self, folder):
        self.folder = Path(folder)
        about = self.json("material.json")
        if about.get("format") != FORMAT:
            raise ExportError(f"{folder} is no export; make one: diffract export SURFACE -o {folder}")
        if about.get("version") != VERSION:
            raise ExportError(f"{folder} has version {about.get('version')} of the format, {VERSION} is known here; export the material again")
        for name in ["table.json", "table.ktx2"]:
            bytes_ = about["files"][name]["bytes"]
            if not (self.folder / name).is_file() or (self.folder / name).stat().st_size != bytes_:
                raise ExportError(f"{self.folder / name} is missing or truncated; export the material again")
        table = self.json("table.json")
        self.about, self.smallest = about, about["smallest_footprint"]
        self.grid, self.blur = table["grid"], table["coherence_blur"]
        self.levels = self.texels()
        self.pieces, self.components = table["basis"]["pieces"], table["basis"]["components"]
        self.cubics = table["unit"] * np.array(table["basis"]["cubics"]).reshape(self.pieces, self.components, 3, 4)
        self.specular = np.array(table["specular"]["weights"])
        self.variances = np.array(table["specular"]["variances"])
        indices, energy = table.get("indices"), table.get("energy")
        self.mean = self.indices = self.polarisation = self.energy = None
        if indices:
            self.indices, self.polarisation = np.array(indices["n"]) + 1j * np.array(indices["k"]), indices["polarisation"]
        else:
            self.mean = np.array(table["mean_reflectance"])
        if indices and not energy:
            raise ExportError(f"{self.folder / 'table.json'} has refractive indices and no limit of energy; export the material again")
        if energy:
            side = math.isqrt(len(energy))
            self.energy = np.array(energy).reshape(side, side, 2)

    def hides_pigment(self):
        """Returns true if the material lets no light through to a pigment below."""
        fresnel = self.about["reflectance"].get("Fresnel")
        table = fresnel and fresnel["material"]["index"].get("Table")  # other materials do not absorb
        if not table:
            return False
        wavelengths, indices = table
        k = np.interp(1000 * MIDDLE, wavelengths, [k for _, k in indices])
        return k * 4 * math.pi / MIDDLE * OPAQUE_WITHIN > 1

    def json(self, name):
        """Returns the content of a file of the folder."""
        try:
            return json.loads((self.folder / name).read_text())
        except (OSError, ValueError) as error:
            why = getattr(error, "strerror", None) or error
            raise ExportError(f"{self.folder / name} cannot be read ({why}); make an export: diffract export SURFACE -o {self.folder}") from None

    def texels(self):
        """Returns the levels of table.ktx2, a KTX2 file of plain 16-bit floats."""
        data = (self.folder / "table.ktx2").read_bytes()
        form, _, side, _, _, layers, _, levels, packed = struct.unpack_from("<9I", data, 12)
        if (form, packed, side) != (HALVES, 0, self.grid["side"]):
            raise ExportError(f"{self.folder / 'table.ktx2'} is not the texture of table.json; export the material again")
        at = [struct.unpack_from("<Q", data, 80 + 24 * level)[0] for level in range(levels)]
        sides = [side >> level for level in range(levels)]
        read = lambda offset, n: np.frombuffer(data, "<f2", layers * n * n * 4, offset).reshape(2, layers // 2, n, n, 4)
        return [level for offset, n in zip(at, sides) for level in read(offset, n)]

    def variance(self, level):
        """Returns the variance of u and of v that a level averages over."""
        return self.grid["finest"] ** 2 + self.grid["growth"] ** 2 * (2.0**level - 1.0)
