"""Directions and colours."""

from __future__ import annotations

import numpy as np

from diffract import _diffract


def direction(theta, phi=0.0) -> np.ndarray:
    """Returns unit vectors at polar angles `theta` from the normal and azimuths `phi` from +x
    toward +y, in degrees.

    The angles are broadcast; the result has a last axis of 3.

    Examples
    --------
    >>> import diffract
    >>> diffract.direction(30, 0).round(3)
    array([0.5  , 0.   , 0.866])
    >>> diffract.direction([0, 30, 60], 90).shape
    (3, 3)
    """
    return _diffract.direction(theta, phi)


def linear_srgb(xyz) -> np.ndarray:
    """Returns the linear sRGB of colours in CIE XYZ, arrays of the shape (..., 3)."""
    return _diffract.linear_srgb(xyz)


def srgb(linear, exposure: float = 0.0) -> np.ndarray:
    """Returns the 8-bit sRGB that shows colours of linear sRGB after an exposure of so many stops.

    Colours out of gamut lose saturation and keep their hue. A fourth number of each pixel, as
    `render` has, is left out.

    Examples
    --------
    >>> import diffract
    >>> diffract.srgb([[0.0, 0.2, 1.0], [0.5, 0.5, 0.5]])
    array([[  0, 124, 255],
           [188, 188, 188]], dtype=uint8)
    """
    linear = np.asarray(linear)
    if linear.ndim and linear.shape[-1] == 4:
        linear = linear[..., :3]
    return _diffract.srgb(linear, exposure)
