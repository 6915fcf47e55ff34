"""Light diffracted by a height field. Lengths are metres, wavelengths too; angles are degrees.

Directions are unit vectors away from the surface in its tangent frame: x along the rows of the
height field, y up in its picture, z out of the surface. They are arrays of any shape (..., 3),
which are broadcast as numpy does.

=====================  ==========================================================================================
for                    take
=====================  ==========================================================================================
a surface              `HeightField`: of an array, `read` from a file, or generated; `prepare` it, see its `info`
the BRDF               `HeightField.brdf`, called with directions and wavelengths; its `rgb` and `map`
orders and periods     `HeightField.orders`, `HeightField.peaks`, `HeightField.periods`: structured arrays
many colours fast      `HeightField.table`; `load_export` reads the table of an export
a picture              `render` of a `Scene` with `Mesh`, `Object` and `Light`
a page in a notebook   `HeightField.show`
cache, threads         `Context`
=====================  ==========================================================================================

Work that takes long releases the interpreter's lock, calls the keyword ``progress`` with the number
of parts that are done, the number of all, and the name of the stage, and stops within a second
after Ctrl-C. With tqdm:

    bar = tqdm.tqdm()
    progress = lambda done, of, stage: bar.reset(of) or bar.update(done)

What cannot be meant raises ValueError, files raise OSError, too little memory MemoryError, and a
missing Vulkan device `DeviceError`; each text ends with what helps. All but `render` and the
standard error of `HeightField.peaks` works without Vulkan.

Examples
--------
Light 30° from the normal, the viewer on the other side, in the brightest order of 550 nm:

>>> import diffract
>>> field = diffract.HeightField.generate("blaze")
>>> brdf = field.brdf()
>>> light, view = diffract.direction(30, 0), diffract.direction(46.05, 180)
>>> float(brdf(light, view, 550e-9)) > 0
True

The command line is here, too: ``diffract --help``.
"""

import atexit as _atexit

from diffract import _diffract
from diffract._brdf import Brdf
from diffract._colour import direction, linear_srgb, srgb
from diffract._context import Context, set_default_context
from diffract._diffract import Cancelled, DeviceError
from diffract._page import Page
from diffract._scene import Light, Mesh, Object, Scene, render
from diffract._surface import HeightField, Peaks
from diffract._table import ColourTable, check_export, load_export

__version__ = _diffract.version()
__all__ = [
    "Brdf",
    "Cancelled",
    "ColourTable",
    "Context",
    "DeviceError",
    "HeightField",
    "Light",
    "Mesh",
    "Object",
    "Page",
    "Peaks",
    "Scene",
    "check_export",
    "direction",
    "linear_srgb",
    "load_export",
    "render",
    "set_default_context",
    "srgb",
]

for _name in __all__:
    # They are of this module, wherever they are written.
    globals()[_name].__module__ = "diffract"
del _name

# Work on other threads ends before the interpreter takes away what it stands on.
_atexit.register(_diffract.end_all)
