"""Height fields."""

from __future__ import annotations

import json
import os
import pathlib
from typing import Any, Callable, Optional, Sequence, Tuple, Union

import numpy as np

from diffract import _diffract
from diffract._arrays import floats, pair, records
from diffract._brdf import Brdf
from diffract._context import Context, core
from diffract._optics import documented, optics, words
from diffract._table import ColourTable

Progress = Optional[Callable[[int, int, str], Any]]
Length = Union[float, Tuple[float, float]]

# Visible light in steps of 1 nm, as the command `peaks` has it.
_VISIBLE = np.arange(380, 781) / 1e9
_INTEGERS = {"m": "i8", "n": "i8", "branch": "i8", "is_clear": "?"}


class HeightField:
    """Heights of a patch of surface on a regular grid.

    Row 0 is the top of a height image: x grows along a row, y grows up, and heights grow toward the
    viewer. Nothing changes a field; `prepare` returns another one.

    Parameters
    ----------
    heights : array of shape (rows, columns)
        Heights in metres, of any type of real numbers. NaN and masked elements were not measured:
        each is filled with the mean of its measured neighbours, and a warning tells how many.
    pixel_size : float or (float, float)
        Distance of samples along x and y in metres.

    Examples
    --------
    A sinusoid of 0.2 µm over a period of 2 µm, in samples of 0.1 µm:

    >>> import numpy as np
    >>> import diffract
    >>> x = np.arange(200) * 0.1e-6
    >>> heights = np.broadcast_to(0.1e-6 * np.sin(2 * np.pi * x / 2e-6), (200, 200))
    >>> field = diffract.HeightField(heights, 0.1e-6)
    >>> field
    HeightField(200 x 200, 100 nm apart, heights over 200 nm)
    >>> field.shape, field.pixel_size, field.patch_size
    ((200, 200), (1e-07, 1e-07), (2e-05, 2e-05))
    """

    def __init__(self, heights, pixel_size: Length, *, context: Context | None = None) -> None:
        self._core = _diffract.CoreField.from_heights(heights, pair("pixel_size", pixel_size), core(context))

    @classmethod
    def _of(cls, found) -> HeightField:
        field = cls.__new__(cls)
        field._core = found
        return field

    @classmethod
    def read(
        cls,
        path: Union[str, os.PathLike],
        *,
        channel: Union[str, int, None] = None,
        pixel_size: Length | None = None,
        height: float | None = None,
        context: Context | None = None,
    ) -> HeightField:
        """Reads the file of a microscope, of a program for surfaces, or a grey image.

        The formats are those of the command line: .gwy, .gsf, .sur, .x3p, .spm, .ibw, .nid, .tif,
        .png, .npy and some forty others. What a user should know of the file is told as a warning.

        Parameters
        ----------
        path : path
            File.
        channel : str or int, optional
            Channel of a file that has several, by name or by number from 1. By default the first
            height.
        pixel_size : float or (float, float), optional
            Distance of samples along x and y in metres, instead of the file's.
        height : float, optional
            Height in metres of white above black for an image; the range of the heights for another
            file, instead of the file's.

        Examples
        --------
        >>> import diffract
        >>> field = diffract.HeightField.generate("blaze")
        >>> field.save("blaze.gsf")
        >>> diffract.HeightField.read("blaze.gsf").shape
        (216, 216)
        """
        pixels = None if pixel_size is None else pair("pixel_size", pixel_size)
        channel = None if channel is None else str(channel)
        return cls._of(_diffract.CoreField.read(os.fspath(path), channel, pixels, height, core(context)))

    @classmethod
    def generate(
        cls,
        kind: str,
        *,
        seed: int = 1,
        patch: Length | None = None,
        pixel_size: Length | None = None,
        period: float | None = None,
        height: float | None = None,
        duty: float | None = None,
        flank: float | None = None,
        context: Context | None = None,
    ) -> HeightField:
        """Generates a surface of published dimensions.

        Parameters
        ----------
        kind : str
            flat, sinusoid, blaze, lamellar, bumps, elaphe, xenopeltis, cd, dvd, brushed or tulip.
        seed : int
            Seed of a random surface.
        patch : float or (float, float), optional
            Sides of the patch in metres, rounded to whole periods.
        pixel_size : float or (float, float), optional
            Largest distance between samples in metres.
        period : float, optional
            Period along x in metres.
        height : float, optional
            Full height in metres.
        duty : float, optional
            Width of the ridges of a lamellar grating at half of their height, over the period.
        flank : float, optional
            Width of the flanks of a lamellar grating in metres.

        Examples
        --------
        >>> import diffract
        >>> diffract.HeightField.generate("lamellar", period=1e-6, height=150e-9, duty=0.4)
        HeightField(2000 x 216, 10 nm x 92.6 nm apart, heights over 150 nm)
        """
        patch = None if patch is None else pair("patch", patch)
        pixels = None if pixel_size is None else pair("pixel_size", pixel_size)
        found = _diffract.CoreField.generate(
            kind, seed, patch, pixels, period, height, duty, flank, core(context)
        )
        return cls._of(found)

    @property
    def heights(self) -> np.ndarray:
        """Heights in metres, (rows, columns), as a view that may only be read: it is made once, and
        each access is the same memory.
        """
        return self._core.heights()

    @property
    def pixel_size(self) -> Tuple[float, float]:
        """Distance of samples along x and y in metres."""
        return tuple(self._core.pixel_size())

    @property
    def shape(self) -> Tuple[int, int]:
        """Number of rows and of columns."""
        columns, rows = self._core.size()
        return rows, columns

    @property
    def patch_size(self) -> Tuple[float, float]:
        """Sides of the patch along x and y in metres."""
        return tuple(self._core.patch_size())

    @property
    def name(self) -> str:
        """Name of the file or of the generated surface."""
        return self._core.name()

    @property
    def prepared(self) -> Tuple[str, ...]:
        """Steps that prepared the heights, oldest first."""
        return tuple(self._core.steps())

    def prepare(self, *steps: str, context: Context | None = None) -> HeightField:
        """Returns the field after these steps, in the words of the command line and in their order.

        Steps are ``level mean``, ``level plane``, ``level polynomial:2``, ``level rows``, ``level
        rows-median``, ``despike``, ``destripe``, ``crop 40um``, ``crop 10umx20um``, ``resample
        95nm``, ``rotate 30deg``, ``taper 5um``, ``tile blend``, ``invert`` and others.

        Examples
        --------
        >>> import diffract
        >>> scan = diffract.HeightField.generate("elaphe", seed=7)
        >>> part = scan.prepare("level plane", "crop 40um")
        >>> part.prepared
        ('level plane', 'crop 40um')
        """
        return self._of(self._core.prepare(list(steps), core(context)))

    def save(self, path: Union[str, os.PathLike], *, context: Context | None = None) -> None:
        """Writes the field in the format of the extension: .gsf, .gwy, .npy, .tif, .txt or .x3p;
        whole or not at all.
        """
        self._core.save(os.fspath(path), core(context))

    def info(
        self,
        *,
        material: Union[float, str, None] = None,
        polarisation: str | None = None,
        theory: str | None = None,
        illuminant: str | None = None,
        context: Context | None = None,
    ) -> dict:
        """Measures the field; returns what the command ``surface info --json`` tells, in metres and
        degrees.

        Examples
        --------
        >>> import diffract
        >>> info = diffract.HeightField.generate("sinusoid").info()
        >>> info["samples"], f"{info['rms_m'] * 1e9:.2f} nm", info["beyond"]
        ([240, 216], '70.71 nm', 'copies')
        """
        settings = optics(
            material=material, polarisation=polarisation, theory=theory, illuminant=illuminant
        )
        return json.loads(self._core.report(settings, core(context)))

    def periods(self, *, context: Context | None = None) -> np.ndarray:
        """Finds the periods that stand out of the power spectrum, strongest first.

        Returns
        -------
        structured array
            length, length_spread, amplitude in metres; direction, direction_spread in degrees from
            +x, across the grooves. Spreads are standard deviations over parts of the field, NaN
            where parts are too small.

        Examples
        --------
        >>> import diffract
        >>> periods = diffract.HeightField.generate("sinusoid").periods()
        >>> f"{periods['length'][0] * 1e6:.3f} µm"
        '2.000 µm'
        """
        found = self.info(context=context)["statistics"]["periods"]
        names = {
            "length": "length_m",
            "length_spread": "length_spread_m",
            "direction": "direction_deg",
            "direction_spread": "direction_spread_deg",
            "amplitude": "amplitude_m",
        }

        def column(key):
            return [np.nan if row[key] is None else row[key] for row in found]

        return records({name: column(key) for name, key in names.items()})

    @documented
    def brdf(
        self,
        *,
        coherence=None,
        material=None,
        film=None,
        polarisation=None,
        theory=None,
        energy=None,
        beyond=None,
        illuminant=None,
        tolerance=None,
        method: str = "spectral",
        windows: str = "all",
        shortest: float = 380e-9,
        progress: Progress = None,
        context: Context | None = None,
    ) -> Brdf:
        """Returns the BRDF of the surface.

        Parameters
        ----------
        {optics}
        method : {"spectral", "reference"}
            Sum over the orders to the tolerance, or the reference in 64-bit floats without any.
        windows : {"all", "one"}
            Mean over all places of the coherence window, as a pixel sees it, or one window in the
            middle, which shows speckle and takes the reference.
        shortest : float
            Shortest wavelength in metres that the reference answers.

        Examples
        --------
        >>> import diffract
        >>> brdf = diffract.HeightField.generate("blaze").brdf()
        >>> light, view = diffract.direction(30, 0), diffract.direction([10, 13, 16], 180)
        >>> brdf(light, view, 550e-9).shape
        (3,)
        """
        settings = optics(
            coherence,
            material,
            film,
            polarisation,
            theory,
            energy,
            beyond,
            illuminant,
            tolerance,
            method,
            windows,
        )
        is_quick = method == "spectral" and windows == "all" and not isinstance(coherence, tuple)
        found = _diffract.CoreBrdf(
            self._core, settings, is_quick, shortest, core(context), progress
        )
        return Brdf(found, context)

    @documented
    def orders(
        self,
        light,
        wavelength,
        *,
        material=None,
        film=None,
        polarisation=None,
        theory=None,
        energy=None,
        least: float = 1e-9,
        progress: Progress = None,
        context: Context | None = None,
    ) -> np.ndarray:
        """Computes the orders of diffraction of copies of the patch.

        Parameters
        ----------
        light : array of shape (3,)
            Direction to the light, a unit vector.
        wavelength : float or array
            Wavelengths in metres.
        least : float
            Smallest efficiency of an order that is returned.
        material, film, polarisation, theory, energy
            As for `brdf`.

        Returns
        -------
        structured array
            A row for each order above the horizon: wavelength in metres; m and n, its numbers along
            x and y; theta and phi, its direction in degrees; efficiency, the share of the light
            that it takes; reflectance, with which Stam's factor would give the efficiency; period
            in metres of the grating whose first order it is, NaN for the specular one.

        Examples
        --------
        >>> import diffract
        >>> field = diffract.HeightField.generate("blaze")
        >>> orders = field.orders(diffract.direction(30, 0), 550e-9, material="aluminium")
        >>> brightest = orders[orders["efficiency"].argmax()]
        >>> int(brightest["m"]), f"{brightest['theta']:.2f}°"
        (1, '46.05°')
        """
        settings = optics(
            material=material, film=film, polarisation=polarisation, theory=theory, energy=energy
        )
        columns = _diffract.orders(self._core, light, wavelength, least, settings, core(context), progress)
        return records(columns, _INTEGERS)

    @documented
    def peaks(
        self,
        theta_i: float,
        angles,
        *,
        wavelengths=_VISIBLE,
        axis: Union[str, float] = "x",
        order: int = 1,
        period: float | None = None,
        over_windows: bool = True,
        coherence=None,
        material=None,
        film=None,
        polarisation=None,
        theory=None,
        energy=None,
        beyond=None,
        tolerance=None,
        method: str = "spectral",
        progress: Progress = None,
        context: Context | None = None,
    ) -> Peaks:
        """Finds the angle of the brightest light of each wavelength, and the period that follows by
        the grating equation.

        Parameters
        ----------
        theta_i : float
            Angle of the light in degrees from the normal, positive toward the axis.
        angles : array
            Growing angles of view to search, in degrees from the normal toward the axis; the mirror
            direction stands at −theta_i.
        wavelengths : array
            Growing wavelengths in metres; by default 380 nm to 780 nm in steps of 1 nm.
        axis : {"x", "y"} or float
            Axis of the plane of incidence, or its azimuth in degrees.
        order : int
            Order of diffraction that the peaks have.
        period : float, optional
            Expected period in metres: peaks are then sought within half an order of it.
        over_windows : bool
            True for the standard error of the period over windows of the surface, which takes a
            Vulkan device; without one, it is left out with a warning.
        {optics}
        method : {"spectral", "reference"}
            As for `brdf`.

        Examples
        --------
        >>> import numpy as np
        >>> import diffract
        >>> field = diffract.HeightField.generate("blaze")
        >>> peaks = field.peaks(-75, np.arange(38, 57, 0.1), wavelengths=[500e-9, 600e-9])
        >>> f"{peaks.period * 1e6:.2f} µm"
        '2.50 µm'
        """
        azimuth = {"x": 0.0, "y": 90.0}.get(axis, axis)
        if isinstance(azimuth, str):
            raise ValueError(f"axis is {axis!r}; give 'x', 'y' or an azimuth in degrees")
        settings = optics(
            coherence, material, film, polarisation, theory, energy, beyond, None, tolerance, method, None
        )
        columns, whole, branches = _diffract.peaks(
            self._core, theta_i, azimuth, angles, wavelengths, order, period, over_windows,
            settings, core(context), progress,
        )
        return Peaks(records(columns, _INTEGERS), whole, branches)

    @documented
    def table(
        self,
        *,
        footprint: float = 0.02,
        coherence=None,
        material=None,
        film=None,
        polarisation=None,
        theory=None,
        energy=None,
        beyond=None,
        illuminant=None,
        tolerance=None,
        progress: Progress = None,
        context: Context | None = None,
    ) -> ColourTable:
        """Returns a table of the colours in all directions, which is read in no time and kept in
        the cache.

        Parameters
        ----------
        footprint : float
            Smallest footprint that it serves, as a standard deviation of (u, v), the sum of the
            directions to light and viewer along x and y; 0 for single directions.
        {optics}

        Examples
        --------
        >>> import diffract
        >>> field = diffract.HeightField.generate("blaze")
        >>> table = field.table(tolerance=0.1, coherence=20e-6)
        >>> table.rgb(diffract.direction(30, 0), diffract.direction(13, 180)).shape
        (3,)
        """
        settings = optics(
            coherence, material, film, polarisation, theory, energy, beyond, illuminant, tolerance
        )
        found = _diffract.CoreTable(self._core, settings, footprint, core(context), progress)
        return ColourTable(found, footprint, context)

    def show(
        self,
        *,
        height: int = 640,
        coherence: float | None = None,
        material: Union[float, str, None] = None,
        film: Tuple[float, float] | None = None,
        polarisation: str | None = None,
        theory: str | None = None,
        energy: bool | None = None,
        beyond: str | None = None,
        illuminant: str | None = None,
        tolerance: float | None = None,
    ) -> Any:
        """Returns the page that the command ``export --html`` writes: the material on a turning
        body, in a notebook of this height in pixels.

        The page loads nothing; ``field.show().save("page.html")`` writes it to a file.
        """
        from diffract._page import made

        options = words(
            coherence=coherence, material=material, film=film, polarisation=polarisation, theory=theory,
            energy=energy, beyond=beyond, illuminant=illuminant, tolerance=tolerance,
        )
        return made(self, pathlib.PurePath(self.name).stem or "surface", options, height)

    def __array__(self, dtype=None, copy=None) -> np.ndarray:
        """Returns the heights in metres."""
        heights = self.heights
        if copy is False and dtype not in (None, heights.dtype):
            raise ValueError("another type takes a copy")
        return np.array(heights, dtype=dtype) if copy else np.asarray(heights, dtype=dtype)

    def __eq__(self, other: object) -> bool:
        """Returns True for the same heights and distances, whatever they are called."""
        return self._core.equals(other._core) if isinstance(other, HeightField) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __reduce__(self):
        return _field, self._core.state()

    def __repr__(self) -> str:
        (columns, rows), (dx, dy) = self._core.size(), self._core.pixel_size()
        low, high = self._core.range()
        apart = _words(dx) if dx == dy else f"{_words(dx)} x {_words(dy)}"
        return f"HeightField({columns} x {rows}, {apart} apart, heights over {_words(high - low)})"

    def _repr_png_(self) -> bytes:
        """Returns a picture of the heights in false colour, which notebooks show."""
        return self._core.preview(400)


class Peaks:
    """Peaks of the diffracted light, as `HeightField.peaks` finds them.

    Attributes
    ----------
    table : structured array
        A row for each wavelength: wavelength in metres; angle of the peak in degrees; period in
        metres; response, the BRDF in 1/sr; is_clear, True if the maximum lies inside the range of
        angles; branch, the number of the branch of maxima on which the largest lies, or −1 where
        there is one alone. NaN where nothing is found.
    period : float
        Mean period in metres, of the strongest branch if there are several; NaN if there is none.
    deviation : float
        Standard deviation over the wavelengths in metres. All of them see the same piece of
        surface: quote `error` where there is one.
    error : float
        Standard error over windows of the surface in metres; NaN where there are too few, or no
        device, and 0 where the peaks of all of them lie at the same angles.
    interval : float
        Half the width of the 95 % confidence interval in metres; NaN where the error is 0 or fewer
        than four windows are independent.
    branches : list of dict
        Period, deviation, error, interval and number of wavelengths of each branch; empty for one
        alone.
    """

    def __init__(self, table, whole, branches) -> None:
        self.table: np.ndarray = table
        found = _period(whole)
        self.period: float = found["period"]
        self.deviation: float = found["deviation"]
        self.error: float = found["error"]
        self.interval: float = found["interval"]
        self.branches: Sequence[dict] = [_period(branch) for branch in branches]

    def __repr__(self) -> str:
        clear = int(np.count_nonzero(self.table["is_clear"]))
        uncertain = self.error if self.error > 0 else self.deviation
        period = f"period {_words(self.period)} ± {_words(uncertain)}"
        return f"Peaks({period}, {clear} of {len(self.table)} wavelengths clear)"


def _period(found) -> dict:
    lengths, wavelengths = found
    names = ("period", "deviation", "error", "interval")
    period = {name: np.nan if length is None else length for name, length in zip(names, lengths)}
    return {**period, "wavelengths": wavelengths}


def _words(metres: float) -> str:
    for factor, unit in ((1e9, "nm"), (1e6, "µm"), (1e3, "mm")):
        if not abs(metres * factor) >= 1000:
            return f"{metres * factor:.3g} {unit}"
    return f"{metres:.3g} m"


def _field(heights, size, pixel_size, steps, name) -> HeightField:
    return HeightField._of(_diffract.CoreField.from_state(heights, size, pixel_size, steps, name))
