"""Writes the material of an export as a shader in the Open Shading Language."""

import pathlib

import bpy
import numpy as np

from .exported import LARGEST_W, SRGB_FROM_XYZ, Export

TEMPLATE = pathlib.Path(__file__).parent / "diffract.osl"


def numbers(values):
    """Returns numbers as the elements of an array in OSL."""
    return ", ".join(f"{x:.9g}" for x in np.asarray(values, float).ravel())


def constants(export):
    """Returns the lines that stand for `CONSTANTS` in the template."""
    indices = export.indices or {"n": [1.0] * 3, "k": [0.0] * 3, "polarisation": "none"}
    law = "SMALL_SLOPE" if export.indices else "STAM" if export.mean_reflectance else "PLAIN"
    mean = export.mean_reflectance or [1.0, 1.0]
    energy = export.energy if export.energy is not None else np.ones((2, 2))
    polarisation = {"none": (0.5, 0.5), "te": (1.0, 0.0), "tm": (0.0, 1.0)}[indices["polarisation"]]
    values = {
        "float CUBICS": export.cubics,
        "float WEIGHTS": export.weights,
        "float VARIANCES": export.variances,
        "float MEAN": mean,
        "float ENERGY": energy,
        "float INDEX_N": indices["n"],
        "float INDEX_K": indices["k"],
        "float POLARISATIONS": polarisation,
        "float SRGB": SRGB_FROM_XYZ,
    }
    lines = [f"{name}[{np.asarray(value).size}] = {{ {numbers(value)} }};" for name, value in values.items()]
    image = bpy.data.images.load(str(export.folder / "table2d.exr"))
    width, height = image.size
    bpy.data.images.remove(image)
    integers = {
        "PIECES": export.pieces,
        "TEXELS": export.texels,
        "SIDE": export.side,
        "COLUMNS": width // export.side,
        "WIDTH": width,
        "HEIGHT": height,
        "BANDS": export.variances.size,
        "SAMPLES": export.weights.shape[1],
        "MEANS": len(mean),
        "ENERGY_SIDE": energy.shape[0],
    }
    defines = [f"#define {name} {value}" for name, value in integers.items()]
    defines += [f"#define EXTENT {export.extent:.9g}", f"#define LARGEST_W {LARGEST_W}", f"#define {law} 1"]
    return defines, lines


def text(folder):
    """Returns the shader of the export in `folder` as a text of the file, which reads the export's images."""
    export = Export(folder)
    defines, lines = constants(export)
    source = TEMPLATE.read_text()
    source = source.replace("// DEFINES", "\n".join(defines)).replace("// ARRAYS", "\n    ".join(lines))
    source = source.replace("table2d.exr", str((export.folder / "table2d.exr").resolve()).replace("\\", "/"))
    block = bpy.data.texts.new(f"diffract {export.name}.osl")
    block.from_string(source)
    return block


def compile_node(node):
    """Compiles the script of a node, as its button does."""
    from cycles import osl

    said = []
    if not osl.update_script_node(node, lambda kind, message: said.append(message)) and not node.inputs:
        raise RuntimeError(f"the shader does not compile: {'; '.join(said)}")


