"""The taps that stand for the average over a footprint: shaders/footprint.glsl of diffract, on Dr.Jit."""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi

# Constants of shaders/footprint.glsl.
SPACING = 2.2
REACH, LONG_REACH = 2.8, 4.0
OVERHANG = 10.0
KEPT = 0.9775
MOST_OF_ROW = 201.0
ROUND = 0.2
LEAST = 1e-30


@dataclass
class Covariance:
    """Covariance of (u, v)."""

    uu: object
    uv: object
    vv: object

    def widened(self, variance):
        """Returns the covariance after a blur of this variance of u and of v."""
        return Covariance(self.uu + variance, self.uv, self.vv + variance)

    def det(self):
        return self.uu * self.vv - self.uv * self.uv

    def density(self, p):
        """Returns the normal distribution at `p`."""
        det = self.det()
        r2 = (self.vv * p.x * p.x - 2 * self.uv * p.x * p.y + self.uu * p.y * p.y) / det
        return dr.exp(-0.5 * r2) * dr.rsqrt(det) * (0.5 / dr.pi)

    def axes(self):
        """Returns the unit vector along the longer axis, the variance along it, and the variance across it."""
        mean, difference = 0.5 * (self.uu + self.vv), 0.5 * (self.uu - self.vv)
        spread = dr.sqrt(difference * difference + self.uv * self.uv)
        along_u = difference > 0
        x = dr.select(along_u, spread + difference, self.uv)
        y = dr.select(along_u, self.uv, spread - difference)
        scale = dr.rsqrt(dr.maximum(x * x + y * y, LEAST))
        return mi.Vector2f(x * scale, y * scale), mean + spread, dr.maximum(mean - spread, 0)


@dataclass
class Line:
    """Places on a line with Gaussian weights: n steps from the middle the weight is exp(-fall n^2) / norm."""

    count: object
    step: object
    fall: object
    norm: object


@dataclass
class Row:
    """Row of taps parallel to the longer axis, `aside` from it, whose weights add up to `weight`. It reads `level`."""

    line: Line
    aside: object
    weight: object
    level: object
    active: object


def line(deviation, tap):
    """Returns places for a standard deviation, where each averages over the standard deviation `tap`."""
    single = deviation <= ROUND * tap
    reach = dr.clip(LONG_REACH - OVERHANG * tap / dr.maximum(deviation, LEAST), REACH, LONG_REACH)
    count = dr.clip(dr.ceil(2 * reach * deviation / (KEPT * SPACING * tap) + 1), 2, MOST_OF_ROW)
    fall = 0.5 * dr.square(2 * reach / count)

    def add(n, norm, moment):
        weight = dr.exp(-fall * n * n)
        return n + 1, norm + weight, moment + weight * n * n

    first = -0.5 * (count - 1)
    _, norm, moment = dr.while_loop((first, dr.zeros(mi.Float), dr.zeros(mi.Float)), lambda n, *_: ~single & (n < 0.5 * count), add)
    step = deviation * dr.sqrt(norm / dr.select(single, 1, moment))
    choose = lambda one, many: dr.select(single, one, many)
    return Line(choose(1, count), choose(0, step), choose(0, fall), choose(1, norm))


def rows(covariance, export):
    """Returns the axis of the rows of taps for a footprint, and the rows: two, of which the second may not be active."""
    finest, blur = export.grid["finest"] ** 2, export.blur
    per_growth, last = 1 / export.grid["growth"] ** 2, export.grid["levels"] - 1
    axis, longer, shorter = covariance.axes()
    part = 2 * LONG_REACH / (KEPT * SPACING * MOST_OF_ROW)
    own = dr.maximum(dr.maximum(shorter, finest), longer * (part * part) - blur)
    level = dr.clip(dr.floor(dr.log2(dr.maximum((own - finest) * per_growth + 1, 1))), 0, last)
    read = finest + (dr.exp2(level) - 1) / per_growth
    following = finest + (dr.exp2(level + 1) - 1) / per_growth
    rest = dr.maximum(own - read, 0)
    along = lambda left, tap: line(dr.sqrt(dr.maximum(left, 0)), dr.sqrt(tap + blur))

    # Between two levels a row of each, both in the middle. Beyond the coarsest level, two rows of it side by side.
    between = level < last
    # Together as high in the middle as the footprint is across.
    finer, asked, coarser = (dr.rsqrt(variance + blur) for variance in (read, read + rest, following))
    share = dr.select(between, dr.minimum((finer - asked) / (finer - coarser), 1), 0)
    whole = (longer - share * dr.maximum(longer, following)) / dr.maximum(1 - share, 1e-3)
    beyond = ~between & (rest > ROUND * ROUND * (read + blur))
    aside = dr.select(beyond, dr.sqrt(rest), 0)
    second = dr.select(between, following, read)
    return axis, [
        Row(along(whole - read, read), -aside, dr.select(beyond, 0.5, 1 - share), level, mi.Bool(True)),
        Row(along(longer - second, second), aside, dr.select(beyond, 0.5, share), dr.minimum(level + 1, last), (share > 0) | beyond),
    ]
