"""Mitsuba BSDF `diffract`: a material that `diffract export` wrote. Importing this module after `mitsuba.set_variant` registers it.

    mi.load_dict({"type": "diffract", "folder": "skin"})

| parameter | meaning |
| --- | --- |
| `folder` | folder of the export |
| `footprint` | standard deviation of (u, v) that every evaluation averages over; by default, and at least, the smallest footprint of the export |
| `base_color` | albedo of a matt pigment below the surface, linear sRGB; black by default. Metals hide it, except where the theory is not limited |
| `tangent` | name of a mesh attribute with the direction of the rows of the height field, as `vertex_tangent`; by default dp/du |

Evaluations average over the footprint of the pixel, too, where `si` has the differentials of its texture coordinates. Mitsuba's own integrators compute none in
these variants: each of their samples is a direction of its own, blurred by `footprint`.

`eval` returns linear sRGB of f cos(theta_light) in 1/sr, whose components may be negative: colours of diffraction leave the gamut of sRGB. The specular order is
part of it, a narrow lobe that coherence blurs, and no delta function. docs/EXPORT.md of diffract has the function step by step.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

import small_slope
from exported import LARGEST_W, TO_SRGB, Export, ExportError
from footprint import Covariance, rows
from lobes import Lobes

# Smallest cosine above the horizon.
HORIZON = 1e-6
# Standard deviation of the pixel filter that a footprint stands for [pixels].
FILTER = 0.5


def buffer(numbers):
    """Returns an array of floats on the device."""
    return mi.TensorXf(np.float32(np.ravel(numbers))).array


class Diffract(mi.BSDF):
    """Material of an export."""

    def __init__(self, props):
        super().__init__(props)
        if not (mi.variant().startswith(("llvm", "cuda")) and mi.variant().endswith("_rgb")):
            raise ExportError(f"{mi.variant()} cannot draw an export, which has colours and no spectra; use mitsuba.set_variant('llvm_ad_rgb')")
        self.export = export = Export(props["folder"])
        self.least = max(props.get("footprint", export.smallest), export.smallest)
        self.base_color = mi.ScalarColor3f(props.get("base_color", mi.ScalarColor3f(0)))
        self.tangent = props.get("tangent", "")
        self.texels = buffer(np.concatenate([level.ravel() for level in export.levels]))
        starts = np.cumsum([0] + [level.size // 4 for level in export.levels[:-1]])
        self.starts = mi.TensorXu(starts.astype(np.uint32)).array
        self.cubics = buffer(export.cubics)
        specular = np.zeros((*export.specular.shape[:2], 4))
        specular[..., :3] = export.specular
        self.specular_weights = buffer(specular)
        self.variances = buffer(export.variances)
        self.mean = None if export.mean is None else buffer(export.mean)
        self.energy = None if export.energy is None else buffer(export.energy)
        self.lobes = Lobes(export, self.least, max(self.base_color))
        flags = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.Anisotropic | mi.BSDFFlags.FrontSide
        self.m_components = [flags]
        self.m_flags = flags

    # ------------------------------------------------------------------------------------------------ the function

    def between(self, kind, samples, row, count, place, active):
        """Returns the samples of a row over 0 ... 1, linear between two. A sample is of `kind`."""
        at = dr.clip(place, 0, 1) * (count - 1)
        left = dr.minimum(dr.floor(at), count - 2)
        index = mi.UInt32(left) + row * count
        return dr.lerp(dr.gather(kind, samples, index, active), dr.gather(kind, samples, index + 1, active), at - left)

    def specular(self, p, w, covariance, active):
        """Returns XYZ of the specular order: a Gaussian of (u, v) for each band of wavelengths."""
        bands, count = self.export.specular.shape[:2]
        variances = self.variances

        def add(band, sum):
            weight = self.between(mi.Vector4f, self.specular_weights, band, count, w / LARGEST_W, active)
            density = covariance.widened(dr.gather(mi.Float, variances, band, active)).density(p)
            return band + 1, sum + density * mi.Vector3f(weight.x, weight.y, weight.z)

        _, xyz = dr.while_loop((mi.UInt32(0), dr.zeros(mi.Vector3f)), lambda band, _: active & (band < bands), add)
        return xyz

    def texel(self, start, side, column, row, active):
        """Returns the four numbers of a texel, 0 outside of the table."""
        active = active & (column >= 0) & (row >= 0) & (column < side) & (row < side)
        index = start + mi.UInt32(dr.select(active, row * side + column, 0))
        return dr.gather(mi.Vector4f, self.texels, index, active)

    def coordinates(self, p, piece, level, active):
        """Returns the coordinates of the table at p, linear between texels: a list of vectors of four."""
        extent = self.export.grid["extent"]
        number = mi.UInt32(level)
        side = mi.Int32(mi.UInt32(self.export.grid["side"]) >> (number >> 1))
        start = dr.gather(mi.UInt32, self.starts, number, active)
        at = (p + extent) * (mi.Float(side) / (2 * extent)) - 0.5
        low = dr.floor(at)
        share = at - low
        column, row = mi.Int32(low.x), mi.Int32(low.y)
        layers = self.export.components // 4
        result = []
        for layer in range(layers):
            of_layer = start + (piece * layers + layer) * mi.UInt32(side * side)
            at = lambda i, j: self.texel(of_layer, side, column + i, row + j, active)
            result.append(dr.lerp(dr.lerp(at(0, 0), at(1, 0), share.x), dr.lerp(at(0, 1), at(1, 1), share.x), share.y))
        return result

    def scattered(self, p, w, covariance, active):
        """Returns XYZ of all orders but the specular one, over w^2."""
        place = w * (self.export.pieces / LARGEST_W)
        number = dr.minimum(dr.floor(place), self.export.pieces - 1)
        piece, t = mi.UInt32(number), 2 * (place - number) - 1
        axis, taps = rows(covariance, self.export)
        across = mi.Vector2f(-axis.y, axis.x)
        sums = [mi.Vector4f(0) for _ in range(self.export.components // 4)]
        for row in taps:
            middle = p + across * row.aside
            used = active & row.active
            weight = row.weight / row.line.norm

            def add(n, *sums, row=row, middle=middle, used=used, weight=weight):
                read = self.coordinates(middle + axis * (n * row.line.step), piece, row.level, used)
                share = weight * dr.exp(-row.line.fall * n * n)
                return n + 1, *[total + share * numbers for total, numbers in zip(sums, read)]

            more = lambda n, *_, row=row, used=used: used & (n < 0.5 * row.line.count)
            _, *sums = dr.while_loop((-0.5 * (row.line.count - 1), *sums), more, add)
        powers = mi.Vector4f(1, t, t * t, t * t * t)
        xyz = [0, 0, 0]
        for component in range(self.export.components):
            number = sums[component // 4][component % 4]
            first = (piece * self.export.components + component) * 3
            for i in range(3):
                xyz[i] += number * dr.dot(dr.gather(mi.Vector4f, self.cubics, first + i, active), powers)
        return mi.Vector3f(*xyz)

    def reflectance(self, both, active):
        """Returns the mean reflectance at the half vector, by Stam's theory. `both`: light + viewer."""
        return self.between(mi.Float, self.mean, 0, len(self.export.mean), 0.5 * dr.norm(both), active)

    def factors(self, light, viewer, active):
        """Returns the factors of X, Y and Z in f cos(theta_light), times w^2."""
        if self.export.indices is not None:
            of_index = lambda index: small_slope.on_device(index, light, viewer, self.export.polarisation)
            return mi.Vector3f(*map(of_index, self.export.indices)) * (4 * light.z * light.z * viewer.z)
        both = light + viewer
        half2 = 0.5 * dr.squared_norm(both)  # 1 + light . viewer
        return mi.Vector3f(self.reflectance(both, active) * half2 * half2 / dr.maximum(viewer.z, HORIZON))

    def energy_at(self, direction, active):
        """Returns the directional albedo over the reflectance of a flat surface, and the root of the factor of a pigment."""
        side = self.export.energy.shape[0]
        z = dr.maximum(direction.z, 0)
        at = 0.5 + 0.5 * mi.Vector2f(direction.x, direction.y) * dr.rsqrt((1 + dr.sqrt(z)) * (1 + z))
        at = dr.clip(at, 0, 1) * (side - 1)
        low = dr.minimum(dr.floor(at), side - 2)
        share, first = at - low, mi.UInt32(low.y) * side + mi.UInt32(low.x)
        point = lambda number: dr.gather(mi.Vector2f, self.energy, first + number, active)
        return dr.lerp(dr.lerp(point(0), point(1), share.x), dr.lerp(point(side), point(side + 1), share.x), share.y)

    def rgb(self, light, viewer, covariance, active=True):
        """Returns linear sRGB of f cos(theta_light) [1/sr] for unit vectors in the frame of the height field, averaged over a footprint."""
        active = mi.Mask(active) & (light.z > HORIZON) & (viewer.z > HORIZON)
        both = light + viewer
        p, w = mi.Vector2f(both.x, both.y), dr.maximum(both.z, HORIZON)
        diffracted = self.scattered(p, w, covariance, active) * (w * w) + self.specular(p, w, covariance, active)
        xyz = diffracted * self.factors(light, viewer, active) / (w * w)
        if self.energy is None:
            passed = 1 - self.reflectance(both, active)
        else:
            of_light, of_viewer = self.energy_at(light, active), self.energy_at(viewer, active)
            # No surface reflects more than a flat one.
            xyz /= dr.maximum(1, dr.maximum(of_light.x, of_viewer.x))
            passed = 0 if self.export.hides_pigment() else of_light.y * of_viewer.y
        pigment = mi.Color3f(self.base_color) * (passed * light.z * dr.inv_pi)
        # Rows of Python's numbers: a matrix of Dr.Jit from a NumPy array is garbage within Mitsuba's calls.
        rgb = mi.Color3f(*(dr.dot(mi.ScalarVector3f(row), xyz) for row in TO_SRGB.tolist()))
        return dr.select(active, rgb + pigment, 0)

    # ------------------------------------------------------------------------------------------------ frames and footprints

    def turn(self, si, active):
        """Returns cosine and sine of the angle from dp/du to the rows of the height field, and -1 where texture coordinates are mirrored."""
        handed = dr.select(dr.dot(si.dp_dv, si.sh_frame.t) < 0, mi.Float(-1), mi.Float(1))
        if not self.tangent:
            return mi.Vector2f(1, 0), handed
        t = si.to_local(mi.Vector3f(si.shape.eval_attribute_3(self.tangent, si, active)))
        size = dr.rsqrt(dr.maximum(t.x * t.x + t.y * t.y, HORIZON))
        return mi.Vector2f(t.x * size, t.y * size), handed

    def to_patch(self, turn, v):
        """Returns a vector of the shading frame in the frame of the height field."""
        (x, y), handed = turn
        return mi.Vector3f(x * v.x + y * v.y, handed * (x * v.y - y * v.x), v.z)

    def from_patch(self, turn, v):
        """Returns a vector of the frame of the height field in the shading frame."""
        (x, y), handed = turn
        return mi.Vector3f(x * v.x - y * handed * v.y, y * v.x + x * handed * v.y, v.z)

    def change(self, si, turn, light_z, duv):
        """Returns the change of light + viewer over a pixel, times the standard deviation of the pixel filter, in the frame of the height field.

        `duv`: change of the texture coordinates. The light is far away. The curvature of the surface counts where the ray was intersected with
        RayFlags.dNSdUV; Mitsuba's integrators leave it out.
        """
        moved = si.to_local(si.dp_du * duv.x + si.dp_dv * duv.y)
        turned = si.to_local(si.dn_du * duv.x + si.dn_dv * duv.y)
        view = (moved - si.wi * dr.dot(si.wi, moved)) / dr.maximum(si.t, HORIZON)
        across = self.to_patch(turn, view + turned * (light_z + si.wi.z))
        return FILTER * mi.Vector3f(across.x, across.y, view.z - dr.dot(si.wi, turned))

    def footprint(self, si, turn, light_z):
        """Returns the covariance of (u, v) to average over, that of `footprint` and of the pixel as far as Mitsuba tells its differentials, and the change of
        the viewer's cosine over the pixel."""
        dx, dy = self.change(si, turn, light_z, si.duv_dx), self.change(si, turn, light_z, si.duv_dy)
        least = self.least**2
        covariance = Covariance(dx.x * dx.x + dy.x * dy.x + least, dx.x * dx.y + dy.x * dy.y, dx.y * dx.y + dy.y * dy.y + least)
        return covariance, dr.sqrt(dx.z * dx.z + dy.z * dy.z)

    # ------------------------------------------------------------------------------------------------ Mitsuba's interface

    def patch(self, si, wo, active):
        """Returns light and viewer in the frame of the height field, and the covariances of (u, v) for the value and for the density."""
        turn = self.turn(si, active)
        of_value, spread = self.footprint(si, turn, wo.z)
        # The density must not depend on the light: that in the specular direction stands for all.
        of_density, _ = self.footprint(si, turn, si.wi.z)
        viewer = self.to_patch(turn, si.wi)
        # At a silhouette the cosine is at least its change within the pixel, because the pixel averages over the visible part.
        viewer.z = dr.select(viewer.z > 0, dr.maximum(viewer.z, dr.minimum(spread, 1)), viewer.z)
        return self.to_patch(turn, wo), viewer, of_value, of_density

    def above(self, si, wo, active):
        return mi.Mask(active) & (wo.z > HORIZON) & (si.wi.z > HORIZON)

    def eval_pdf(self, ctx, si, wo, active=True):
        light, viewer, of_value, of_density = self.patch(si, wo, active)
        active = self.above(si, wo, active)
        return self.rgb(light, viewer, of_value, active), dr.select(active, self.lobes.pdf(light, viewer, of_density, active), 0)

    def eval(self, ctx, si, wo, active=True):
        light, viewer, covariance, _ = self.patch(si, wo, active)
        return self.rgb(light, viewer, covariance, active)

    def pdf(self, ctx, si, wo, active=True):
        light, viewer, _, covariance = self.patch(si, wo, active)
        active = self.above(si, wo, active)
        return dr.select(active, self.lobes.pdf(light, viewer, covariance, active), 0)

    def sample(self, ctx, si, sample1, sample2, active=True):
        _, viewer, _, covariance = self.patch(si, si.wi, active)
        bs = mi.BSDFSample3f()
        bs.wo = self.from_patch(self.turn(si, active), self.lobes.sample(viewer, covariance, sample1, sample2, active))
        value, bs.pdf = self.eval_pdf(ctx, si, bs.wo, active)
        bs.eta = 1
        bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
        bs.sampled_component = mi.UInt32(0)
        return bs, dr.select(bs.pdf > 0, value / dr.select(bs.pdf > 0, bs.pdf, 1), 0)

    def traverse(self, callback):
        pass

    def parameters_changed(self, keys):
        pass

    def to_string(self):
        return f"Diffract[folder={self.export.folder}, footprint={self.least}]"


mi.register_bsdf("diffract", Diffract)
