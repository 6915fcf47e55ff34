"""Directions drawn by the luminance of an export: a mixture of three lobes, each with its exact density.

With p = -(u, v) = light + viewer across the normal, a density of p is one of solid angle times cos(theta_light): d(omega) = d(p) / cos(theta_light).

1. The table. Its luminance times the factor of f cos(theta_light) / cos(theta_light) is tabulated over p for directions of the viewer, and interpolated between
   them.
2. The specular order: a Gaussian of p as wide as that of the longest wavelengths, so that no wavelength has a wider one.
3. The hemisphere, evenly. By Stam's theory f cos(theta_light) does not fall to 0 at the horizon, so that a cosine lobe would have weights without a bound there.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

import small_slope
from exported import LARGEST_W

# Directions of the viewer of which the table is tabulated.
COSINES = np.array([0.05, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9, 1.0])
AZIMUTHS = np.linspace(-np.pi, np.pi, 17)
# Most cells along u or v.
CELLS = 200
# Smallest share of the hemisphere among the samples.
EVEN = 0.1
# Distance from the horizon within which light counts as on it: directions of the viewer between the tabulated ones see beyond their horizons.
MARGIN, LEAST_COSINE = 0.05, 0.2


def coordinates(export, footprint):
    """Returns the coordinates of the level for a footprint, [piece][row][column][component], averaged to at most CELLS cells a side."""
    levels = [i for i in range(export.grid["levels"]) if export.variance(i) <= footprint**2 * (1 + 1e-6)]
    texels = export.levels[levels[-1] if levels else 0].astype(np.float32)
    while texels.shape[1] > CELLS:
        texels = 0.25 * (texels[:, ::2, ::2] + texels[:, 1::2, ::2] + texels[:, ::2, 1::2] + texels[:, 1::2, 1::2])
    layers, side = export.components // 4, texels.shape[1]
    return texels.reshape(export.pieces, layers, side, side, 4).transpose(0, 2, 3, 1, 4).reshape(export.pieces, side, side, -1)


def luminance(export, coordinates, w):
    """Returns the luminance of the table over w^2 at each cell, whose |w| is in the array `w`."""
    place = np.clip(w, 0, LARGEST_W) / LARGEST_W * export.pieces
    piece = np.minimum(place.astype(int), export.pieces - 1)
    t = (2 * (place - piece) - 1)[..., None]
    powers = np.concatenate([np.ones_like(t), t, t**2, t**3], axis=-1)
    row, column = np.indices(w.shape)
    return np.einsum("ijc,ijck,ijk->ij", coordinates[piece, row, column], export.cubics[piece, :, 1], powers, optimize=False)


def excess(export, direction):
    """Returns the directional albedo over the reflectance of a flat surface, of the nearest direction of the grid."""
    x, y, z = direction
    scale = 1 / np.sqrt((1 + np.sqrt(z)) * (1 + z))
    side = export.energy.shape[0]
    column, row = (np.rint(np.clip(0.5 + 0.5 * at * scale, 0, 1) * (side - 1)).astype(int) for at in (x, y))
    return export.energy[row, column, 0]


def factor(export, light, viewer):
    """Returns the factor of Y in f cos(theta_light), times w^2. `light` and `viewer` are lists of three arrays."""
    limit = 1 if export.energy is None else np.maximum(1, np.maximum(excess(export, light), excess(export, viewer)))
    if export.indices is not None:
        kernel = small_slope.on_host(export.indices[1], light, viewer, export.polarisation)
        return 4 * light[2] ** 2 * viewer[2] * kernel / limit
    half2 = 0.5 * sum((a + b) ** 2 for a, b in zip(light, viewer))
    mean = np.interp(np.sqrt(0.5 * half2), np.linspace(0, 1, len(export.mean)), export.mean)
    return mean * half2**2 / (viewer[2] * limit)


def slices(export, footprint):
    """Returns the density of p, not normalised, [azimuth of the viewer][cosine of the viewer][row][column], and the position of the last cell."""
    held = coordinates(export, footprint)
    side = held.shape[1]
    last = export.grid["extent"] * (1 - 1 / side)
    x, y = np.meshgrid(*2 * [np.linspace(-last, last, side)])

    def of_viewer(azimuth, cosine):
        sine = np.sqrt(1 - cosine**2)
        viewer = sine * np.cos(azimuth), sine * np.sin(azimuth), cosine
        light_x, light_y = x - viewer[0], y - viewer[1]
        r2 = light_x**2 + light_y**2
        light_z = np.sqrt(np.maximum(1 - r2, LEAST_COSINE**2))
        of_light = factor(export, (light_x, light_y, light_z), viewer) / light_z
        return np.where(r2 < (1 + MARGIN) ** 2, of_light * np.maximum(luminance(export, held, cosine + light_z), 0), 0)

    return np.array([[of_viewer(a, c) for c in COSINES] for a in AZIMUTHS], dtype=np.float32), last


def mirrored(export):
    """Returns the share of light that the specular order of a flat surface reflects toward each of COSINES, the mean over AZIMUTHS."""
    azimuth, z = np.meshgrid(AZIMUTHS[:-1], COSINES, indexing="ij")
    x, y = np.sqrt(1 - z**2) * (np.cos(azimuth), np.sin(azimuth))
    return (factor(export, (-x, -y, z), (x, y, z)) / (4 * z**3)).mean(axis=0)


class Lobes:
    """The mixture, for an export and the footprint that it is read with. `pigment`: largest albedo of the pigment."""

    def __init__(self, export, footprint, pigment):
        density, self.last = slices(export, footprint)
        cell = (2 * self.last / (density.shape[-1] - 1)) ** 2
        of_table = density.sum(axis=(-1, -2)).mean(axis=0) * cell
        at = np.linspace(0, LARGEST_W, export.specular.shape[1])
        of_bands = np.array([np.interp(2 * COSINES, at, weights[:, 1]) for weights in export.specular])
        of_specular = of_bands.sum(axis=0) * mirrored(export)
        total = of_table + of_specular + pigment
        even = EVEN + (1 - EVEN) * pigment / total
        self.even = even.tolist()
        self.both = (even + (1 - even) * of_specular / (of_table + of_specular)).tolist()
        self.widest = float(export.variances.max())
        # A slice of zeros has no density.
        density += 1e-6 * density.max() + 1e-30
        self.table = mi.MarginalContinuous2D2(density, [AZIMUTHS.tolist(), COSINES.tolist()])

    def shares(self, cosine):
        """Returns the part of samples for the hemisphere, and the part for it and the specular order together, linear between the tabulated cosines."""
        at = COSINES.tolist()
        even, both = mi.Float(self.even[0]), mi.Float(self.both[0])
        for low, high, i in zip(at, at[1:], range(len(at))):
            share = dr.clip((cosine - low) / (high - low), 0, 1)
            even += share * (self.even[i + 1] - self.even[i])
            both += share * (self.both[i + 1] - self.both[i])
        return even, both

    def of_viewer(self, viewer):
        """Returns the parameters of the table's distribution."""
        return mi.Vector2f(dr.atan2(viewer.y, viewer.x), dr.clip(viewer.z, float(COSINES[0]), 1))

    def sample(self, viewer, covariance, sample1, sample2, active):
        """Returns a unit vector to the light, which may lie below the horizon: then the density is 0."""
        even, both = self.shares(viewer.z)
        hemisphere = mi.warp.square_to_uniform_hemisphere(sample2)
        place, _ = self.table.sample(sample2, self.of_viewer(viewer), active)
        in_table = (2 * place - 1) * self.last
        # Cholesky's root of the covariance.
        c = covariance.widened(self.widest)
        n = mi.warp.square_to_std_normal(sample2)
        u = dr.sqrt(c.uu)
        v = c.uv / u
        in_specular = mi.Vector2f(u * n.x, v * n.x + dr.sqrt(dr.maximum(c.vv - v * v, 0)) * n.y)
        p = dr.select(sample1 < both, in_specular, mi.Vector2f(in_table.x, in_table.y))
        across = p - mi.Vector2f(viewer.x, viewer.y)
        z2 = 1 - dr.squared_norm(across)
        scattered = mi.Vector3f(across.x, across.y, dr.select(z2 > 0, dr.safe_sqrt(z2), -1))
        return dr.select(sample1 < even, hemisphere, scattered)

    def pdf(self, light, viewer, covariance, active):
        """Returns the density of solid angle of directions above the horizon."""
        even, both = self.shares(viewer.z)
        p = mi.Vector2f(light.x + viewer.x, light.y + viewer.y)
        place = (p / self.last + 1) * 0.5
        inside = dr.all((place >= 0) & (place <= 1))
        in_table = self.table.eval(dr.clip(place, 0, 1), self.of_viewer(viewer), active) / dr.square(2 * self.last)
        of_p = (1 - both) * dr.select(inside, in_table, 0) + (both - even) * covariance.widened(self.widest).density(p)
        return even * (0.5 * dr.inv_pi) + of_p * light.z
