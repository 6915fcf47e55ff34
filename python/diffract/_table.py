"""Colour tables."""

from __future__ import annotations

import os
from typing import Any, Callable, Optional, Union

import numpy as np

from diffract import _diffract
from diffract._context import Context, core

Progress = Optional[Callable[[int, int, str], Any]]


class ColourTable:
    """Colours of a surface in all directions, averaged over footprints, as `HeightField.table`
    makes it or `load_export` reads it.

    A footprint is what a pixel, a lens and a light cover: the standard deviation of (u, v), the
    sums of the directions to light and viewer along x and y. Covariances of (u, v), of the shape
    (..., 2, 2), serve footprints that are longer than wide.
    """

    __slots__ = ("_core", "_footprint", "_context")

    def __init__(self, found, footprint, context) -> None:
        self._core = found
        self._footprint = footprint
        self._context = context

    def xyz(self, light, view, footprint=None, *, covariance=None) -> np.ndarray:
        """Returns CIE XYZ of f in 1/sr, of the shape (..., 3): `rgb` in another space."""
        return self._read(light, view, footprint, covariance, False)

    def rgb(self, light, view, footprint=None, *, covariance=None) -> np.ndarray:
        """Returns linear sRGB of f in 1/sr.

        Parameters
        ----------
        light, view : array of shape (..., 3)
            Directions to the light and to the viewer, unit vectors.
        footprint : float or array, optional
            Standard deviations of (u, v); by default the smallest that the table serves.
        covariance : array of shape (..., 2, 2), optional
            Covariances of (u, v) instead.

        Returns
        -------
        array of shape (..., 3)
            The arguments are broadcast against each other; below the horizon colours are 0.
        """
        return self._read(light, view, footprint, covariance, True)

    def _read(self, light, view, footprint, covariance, is_rgb):
        if covariance is None:
            chosen = self._footprint if footprint is None else footprint
            return self._core.colours(light, view, chosen, False, is_rgb)
        if footprint is not None:
            raise ValueError("footprint and covariance are both given; leave one away")
        return self._core.colours(light, view, covariance, True, is_rgb)

    @property
    def nbytes(self) -> int:
        """Size of the table in bytes."""
        return self._core.nbytes()

    def export(
        self,
        folder: Union[str, os.PathLike],
        *,
        progress: Progress = None,
        context: Context | None = None,
    ) -> None:
        """Writes the table into a `folder` for other programs: textures, shaders, and directions
        with exact colours to check them by. A former export there is replaced.
        """
        self._core.export(os.fspath(folder), core(context or self._context), progress)

    def __repr__(self) -> str:
        return f"ColourTable({self.nbytes / 1e6:.2f} MB, footprints from {self._footprint:g} on)"


def load_export(folder: Union[str, os.PathLike], *, context: Context | None = None) -> ColourTable:
    """Reads the colour table of the export in `folder`.

    Examples
    --------
    >>> import diffract
    >>> table = diffract.HeightField.generate("blaze").table(tolerance=0.1, coherence=20e-6)
    >>> table.export("material")
    >>> light, view = diffract.direction(30, 0), diffract.direction(13, 180)
    >>> bool((diffract.load_export("material").rgb(light, view, 0.02) == table.rgb(light, view, 0.02)).all())
    True
    """
    return ColourTable(_diffract.CoreTable.open(os.fspath(folder), core(context)), 0.0, context)


def check_export(folder: Union[str, os.PathLike], *, context: Context | None = None) -> float:
    """Reads every file of the export in `folder`, and returns the relative L2 error of its colours
    against the exact ones.
    """
    return _diffract.CoreTable.check(os.fspath(folder), core(context))
