"""Scenes and their pictures."""

from __future__ import annotations

import os
from typing import Any, Callable, Iterable, Optional, Sequence, Tuple, Union

import numpy as np

from diffract import _diffract
from diffract._arrays import floats
from diffract._context import Context, core
from diffract._optics import documented, optics
from diffract._surface import HeightField

Progress = Optional[Callable[[int, int, str], Any]]
Triple = Sequence[float]


class Light:
    """Light of a scene.

    Parameters
    ----------
    theta, phi : float
        Angles in degrees from up, and around it from +x toward +y, of a point of the sky.
    intensity : float
        Its intensity.

    Examples
    --------
    >>> import diffract
    >>> diffract.Light(40, 90)
    Light("40,90,1")
    >>> diffract.Light.parse("disc:5deg:40,90")
    Light("disc:5deg:40,90,1")
    """

    __slots__ = ("_core",)

    def __init__(self, theta: float, phi: float, intensity: float = 1.0) -> None:
        self._core = _diffract.CoreLight.point(theta, phi, intensity)

    @classmethod
    def parse(cls, words: str) -> Light:
        """Returns the light of these words of the command line: ``40,90``, ``sun:40,90``,
        ``disc:5deg:40,90``, ``sphere:0.1:0,0,2``, ``rectangle:0.4x0.2:0,-1,1``, each with an
        optional spectrum behind ``@``."""
        light = cls.__new__(cls)
        light._core = _diffract.CoreLight.from_words(words)
        return light

    def __repr__(self) -> str:
        return repr(self._core)


class Mesh:
    """Mesh of triangles.

    Parameters
    ----------
    vertices : array of shape (n, 3)
        Positions; up is +z.
    faces : array of shape (m, 3)
        Numbers of the corners of each triangle, from 0, counter-clockwise as seen from outside.
    uv : array of shape (n, 2), optional
        Texture coordinates of each vertex: the x axis of a surface follows growing u. Without any
        they are projected along the axes.

    Examples
    --------
    >>> import diffract
    >>> square = [[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]
    >>> diffract.Mesh(square, [[0, 1, 2], [0, 2, 3]], uv=[[0, 0], [1, 0], [1, 1], [0, 1]])
    Mesh(2 triangles)
    """

    __slots__ = ("_core",)

    def __init__(self, vertices, faces, uv=None, *, context: Context | None = None) -> None:
        self._core = _diffract.CoreMesh(vertices, faces, uv, core(context))

    def __repr__(self) -> str:
        return f"Mesh({self._core.triangles()} triangles)"


class Object:
    """Mesh in a scene, with its surface and its place.

    Parameters
    ----------
    mesh : Mesh
        Its shape.
    surface : str or path, optional
        Built-in surface or file. The first object of a scene has the surface that is rendered
        instead.
    pigment : (float, float, float)
        Albedo below the surface, linear sRGB from 0 to 1.
    grooves : float, optional
        Angle in degrees by which the x axis of the surface is turned from growing u toward growing
        v.
    size : float
        Factor of its size.
    position : (float, float, float)
        Its place.
    """

    __slots__ = ("_core",)

    def __init__(
        self,
        mesh: Mesh,
        *,
        surface: Union[str, os.PathLike, None] = None,
        pigment: Triple = (0.0, 0.0, 0.0),
        grooves: float | None = None,
        size: float = 1.0,
        position: Triple = (0.0, 0.0, 0.0),
    ) -> None:
        if not isinstance(mesh, Mesh):
            raise TypeError(f"mesh is a {type(mesh).__name__}; give a diffract.Mesh")
        name = None if surface is None else os.fspath(surface)
        self._core = _diffract.CoreObject(
            mesh._core, name, _triple("pigment", pigment), grooves, size, _triple("position", position)
        )


class Scene:
    """Objects, lights and a camera.

    Parameters
    ----------
    objects : str, path, Mesh, or sequence of Object and Mesh
        Built-in scene (snake, plate, sphere, disc, cd, skin), scene file (.toml), mesh file (.obj,
        .gltf, .glb, .ply, .stl), or objects.
    lights : sequence of Light, or words of lights, optional
        Instead of the scene's.
    camera : (eye, target, angle), optional
        Place of the camera, the point that it looks at, and its vertical angle of view in degrees,
        instead of the scene's.
    surroundings : str, optional
        Built-in surroundings such as ``"sky"``, or an equirectangular .exr or .hdr picture.
    rotation, stops : float
        Turn of the surroundings in degrees, and their brightness in stops.
    background : (float, float, float), optional
        Linear sRGB.
    shadows : bool, optional
        Whether objects throw shadows.

    Examples
    --------
    >>> import diffract
    >>> lights = ["30,0", diffract.Light(50, 90)]
    >>> scene = diffract.Scene("plate", lights=lights, camera=((0, -3, 3), (0, 0, 0), 30))
    """

    __slots__ = ("_core",)

    def __init__(
        self,
        objects="snake",
        *,
        lights: Iterable[Union[Light, str]] | None = None,
        camera: Tuple[Triple, Triple, float] | None = None,
        surroundings: str | None = None,
        rotation: float = 0.0,
        stops: float = 0.0,
        background: Triple | None = None,
        shadows: bool | None = None,
        context: Context | None = None,
    ) -> None:
        found = _scene(objects, context)
        if lights is not None:
            found = found.with_lights([_light(light)._core for light in lights])
        if camera is not None:
            eye, target, angle = camera
            found = found.with_camera(_triple("camera", eye), _triple("camera", target), angle)
        if surroundings is not None:
            found = found.with_surroundings(os.fspath(surroundings), rotation, stops)
        if background is not None:
            found = found.with_background(_triple("background", background))
        if shadows is not None:
            found = found.with_shadows(shadows)
        self._core = found


def _scene(objects, context):
    if isinstance(objects, (str, os.PathLike)):
        return _diffract.CoreScene.open(os.fspath(objects), core(context))
    objects = [objects] if isinstance(objects, (Mesh, Object)) else list(objects)
    objects = [Object(one) if isinstance(one, Mesh) else one for one in objects]
    for one in objects:
        if not isinstance(one, Object):
            raise TypeError(f"objects has a {type(one).__name__}; give diffract.Object or diffract.Mesh")
    return _diffract.CoreScene.of_objects([one._core for one in objects])


def _light(light) -> Light:
    if isinstance(light, str):
        return Light.parse(light)
    if not isinstance(light, Light):
        raise TypeError(f"lights has a {type(light).__name__}; give diffract.Light, or words such as '40,90'")
    return light


def _triple(name, value):
    numbers = floats(name, value)
    if numbers.shape != (3,):
        raise ValueError(f"{name} has the shape {numbers.shape}; give three numbers")
    return tuple(numbers.tolist())


@documented
def render(
    scene: Union[Scene, str, os.PathLike] = "snake",
    surface: Union[HeightField, str] = "elaphe",
    *,
    size: Tuple[int, int] = (1280, 720),
    samples: int = 16,
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
) -> np.ndarray:
    """Draws a scene on a Vulkan device, a GPU or one in software.

    Parameters
    ----------
    scene : Scene, or what Scene takes
        Scene.
    surface : HeightField or str
        Surface of its first object; a name is that of a generated one.
    size : (int, int)
        Width and height in pixels.
    samples : int
        Samples of each pixel.
    {optics}

    Returns
    -------
    32-bit array of shape (height, width, 4)
        Linear radiance in sRGB, signed and premultiplied by alpha, the share of a pixel that
        objects cover; row 0 is the top. `srgb` makes what a screen shows.

    Raises
    ------
    DeviceError
        Without a Vulkan device; the text says what to install.

    Examples
    --------
    >>> import diffract
    >>> picture = diffract.render("plate", "blaze", size=(64, 36), samples=1, tolerance=0.1)
    >>> picture.shape, picture.dtype
    ((36, 64, 4), dtype('float32'))
    """
    if not isinstance(scene, Scene):
        scene = Scene(scene, context=context)
    if isinstance(surface, str):
        surface = HeightField.generate(surface, context=context)
    if not isinstance(surface, HeightField):
        raise TypeError(f"surface is a {type(surface).__name__}; give a diffract.HeightField, or a name")
    settings = optics(
        coherence, material, film, polarisation, theory, energy, beyond, illuminant, tolerance
    )
    return _diffract.render(
        scene._core, surface._core, tuple(size), samples, settings, core(context), progress
    )
