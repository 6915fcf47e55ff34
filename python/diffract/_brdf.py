"""The BRDF of a surface."""

from __future__ import annotations

from typing import Any, Callable, Optional

import numpy as np

from diffract._context import Context, core

Progress = Optional[Callable[[int, int, str], Any]]


class Brdf:
    """BRDF f of a surface in 1/sr, as `HeightField.brdf` makes it.

    It is a function of unit vectors away from the surface in its tangent frame: x along the rows of
    the height field, y up in its picture, z out of the surface. Arrays of any shape (…, 3) are
    broadcast against each other and against the wavelengths, as numpy does. Below the horizon f is
    0; a NaN makes its answer NaN. What an answer takes beyond its directions is made for the first
    one. Threads may ask together.

    Examples
    --------
    >>> import numpy as np
    >>> import diffract
    >>> brdf = diffract.HeightField.generate("sinusoid").brdf(coherence=20e-6)
    >>> light = diffract.direction(30, 0)
    >>> views = diffract.direction(np.linspace(0, 60, 5), 180)
    >>> brdf(light, views[:, None], [450e-9, 550e-9, 650e-9]).shape
    (5, 3)
    >>> brdf.rgb(light, views).shape
    (5, 3)
    """

    __slots__ = ("_core", "_context")

    def __init__(self, found, context) -> None:
        self._core = found
        self._context = context

    def __call__(
        self, light, view, wavelength, *, progress: Progress = None, context: Context | None = None
    ) -> np.ndarray:
        """Returns f in 1/sr.

        Parameters
        ----------
        light, view : array of shape (..., 3)
            Directions to the light and to the viewer, unit vectors.
        wavelength : float or array
            Wavelengths in metres.

        Returns
        -------
        array
            Of the shape to which light[..., 0], view[..., 0] and wavelength are broadcast; a number
            for shape ().
        """
        return self._core.spectral(light, view, wavelength, core(context or self._context), progress)

    def xyz(self, light, view, *, progress: Progress = None, context: Context | None = None) -> np.ndarray:
        """Returns the colour of f in CIE XYZ per sr, of the shape (..., 3). The mirror image of the
        light in a perfect mirror has Y = 1/cos θ, spread over its solid angle.
        """
        return self._core.colours(light, view, False, core(context or self._context), progress)

    def rgb(self, light, view, *, progress: Progress = None, context: Context | None = None) -> np.ndarray:
        """Returns the colour of f in linear sRGB per sr, of the shape (..., 3). Colours out of
        gamut have negative numbers; `diffract.srgb` makes 8-bit ones.
        """
        return self._core.colours(light, view, True, core(context or self._context), progress)

    def map(
        self,
        light,
        *,
        size: int = 512,
        wavelength: float | None = None,
        progress: Progress = None,
        context: Context | None = None,
    ) -> np.ndarray:
        """Returns the map of the hemisphere of view directions, averaged over each pixel.

        Parameters
        ----------
        light : array of shape (3,)
            Direction to the light.
        size : int
            Pixels along each side.
        wavelength : float, optional
            Single wavelength in metres, instead of the colour.

        Returns
        -------
        32-bit array of shape (size, size, 3) or (size, size)
            Linear sRGB of f, or f at the wavelength, in 1/sr; NaN outside the hemisphere. Element
            [j, i] is the direction of x = 2(i + 0.5)/size − 1, y = 1 − 2(j + 0.5)/size.

        Examples
        --------
        >>> import diffract
        >>> brdf = diffract.HeightField.generate("sinusoid").brdf(coherence=20e-6)
        >>> brdf.map(diffract.direction(30, 0), size=32).shape
        (32, 32, 3)
        """
        return self._core.map(light, size, wavelength, core(context or self._context), progress)
