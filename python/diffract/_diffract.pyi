"""The extension in Rust, for this package alone: lengths are metres, and every argument is given."""

import os
from typing import Any, Callable, Optional, Sequence

import numpy as np

_Progress = Optional[Callable[[int, int, str], Any]]
_Path = str | os.PathLike[str]
_Period = tuple[list[float | None], int]

class Cancelled(Exception): ...
class DeviceError(Exception): ...

class CoreContext:
    def __init__(
        self, folder: _Path | None, limit: int, threads: int | None, device: str | None
    ) -> None: ...

class CoreOptics:
    def __init__(
        self,
        coherence: float | tuple[int, int] | None,
        material: float | str | None,
        film: tuple[float, float] | None,
        polarisation: str | None,
        theory: str | None,
        beyond: str | None,
        illuminant: str | None,
        tolerance: float | None,
        method: str | None,
        windows: str | None,
    ) -> None: ...

class CoreField:
    @staticmethod
    def from_heights(heights: Any, pixel_size: Sequence[float], context: CoreContext) -> CoreField: ...
    @staticmethod
    def read(
        path: _Path,
        channel: str | None,
        pixel_size: Sequence[float] | None,
        height: float | None,
        context: CoreContext,
    ) -> CoreField: ...
    @staticmethod
    def generate(
        kind: str,
        seed: int,
        patch: Sequence[float] | None,
        pixel_size: Sequence[float] | None,
        period: float | None,
        height: float | None,
        duty: float | None,
        flank: float | None,
        context: CoreContext,
    ) -> CoreField: ...
    @staticmethod
    def from_state(
        heights: bytes, size: list[int], pixel_size: list[float], steps: list[str], name: str
    ) -> CoreField: ...
    def state(self) -> tuple[bytes, list[int], list[float], list[str], str]: ...
    def heights(self) -> np.ndarray: ...
    def size(self) -> list[int]: ...
    def pixel_size(self) -> list[float]: ...
    def patch_size(self) -> list[float]: ...
    def range(self) -> tuple[float, float]: ...
    def name(self) -> str: ...
    def steps(self) -> list[str]: ...
    def equals(self, other: CoreField) -> bool: ...
    def prepare(self, steps: list[str], context: CoreContext) -> CoreField: ...
    def report(self, optics: CoreOptics, context: CoreContext) -> str: ...
    def save(self, path: _Path, context: CoreContext) -> None: ...
    def preview(self, most: int) -> bytes: ...

class CoreBrdf:
    def __init__(
        self,
        field: CoreField,
        optics: CoreOptics,
        is_quick: bool,
        shortest: float,
        context: CoreContext,
        progress: _Progress,
    ) -> None: ...
    def spectral(
        self, light: Any, view: Any, wavelength: Any, context: CoreContext, progress: _Progress
    ) -> np.ndarray: ...
    def colours(
        self, light: Any, view: Any, is_rgb: bool, context: CoreContext, progress: _Progress
    ) -> np.ndarray: ...
    def map(
        self,
        light: Any,
        side: int,
        wavelength: float | None,
        context: CoreContext,
        progress: _Progress,
    ) -> np.ndarray: ...

class CoreTable:
    def __init__(
        self,
        field: CoreField,
        optics: CoreOptics,
        footprint: float,
        context: CoreContext,
        progress: _Progress,
    ) -> None: ...
    @staticmethod
    def open(folder: _Path, context: CoreContext) -> CoreTable: ...
    @staticmethod
    def check(folder: _Path, context: CoreContext) -> float: ...
    def colours(
        self, light: Any, view: Any, footprint: Any, is_covariance: bool, is_rgb: bool
    ) -> np.ndarray: ...
    def nbytes(self) -> int: ...
    def export(self, folder: _Path, context: CoreContext, progress: _Progress) -> None: ...

class CoreLight:
    @staticmethod
    def point(theta: float, phi: float, intensity: float) -> CoreLight: ...
    @staticmethod
    def from_words(words: str) -> CoreLight: ...

class CoreMesh:
    def __init__(self, vertices: Any, faces: Any, uv: Any, context: CoreContext) -> None: ...
    def triangles(self) -> int: ...

class CoreObject:
    def __init__(
        self,
        mesh: CoreMesh,
        surface: _Path | None,
        pigment: Sequence[float],
        grooves: float | None,
        size: float,
        position: Sequence[float],
    ) -> None: ...

class CoreScene:
    @staticmethod
    def open(name: _Path, context: CoreContext) -> CoreScene: ...
    @staticmethod
    def of_objects(objects: list[CoreObject]) -> CoreScene: ...
    def with_lights(self, lights: list[CoreLight]) -> CoreScene: ...
    def with_camera(self, eye: Sequence[float], target: Sequence[float], angle: float) -> CoreScene: ...
    def with_surroundings(self, name: str, rotation: float, stops: float) -> CoreScene: ...
    def with_background(self, color: Sequence[float]) -> CoreScene: ...
    def with_shadows(self, shadows: bool) -> CoreScene: ...

def render(
    scene: CoreScene,
    field: CoreField,
    size: Sequence[int],
    samples: int,
    optics: CoreOptics,
    context: CoreContext,
    progress: _Progress,
) -> np.ndarray: ...
def orders(
    field: CoreField,
    light: Any,
    wavelengths: Any,
    least: float,
    optics: CoreOptics,
    context: CoreContext,
    progress: _Progress,
) -> dict[str, np.ndarray]: ...
def peaks(
    field: CoreField,
    theta_i: float,
    azimuth: float,
    angles: Any,
    wavelengths: Any,
    order: int,
    period: float | None,
    over_windows: bool,
    optics: CoreOptics,
    context: CoreContext,
    progress: _Progress,
) -> tuple[dict[str, np.ndarray], _Period, list[_Period]]: ...
def direction(theta: Any, phi: Any) -> np.ndarray: ...
def linear_srgb(xyz: Any) -> np.ndarray: ...
def srgb(linear: Any, exposure: float) -> np.ndarray: ...
def run(words: list[str], validates: bool) -> int: ...
def version() -> str: ...
def micrometres_of(metres: float) -> float: ...
def metres_of(micrometres: float) -> float: ...
def end_all() -> None: ...
