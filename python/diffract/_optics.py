"""Light and material, as keywords."""

import re
import textwrap

from diffract import _diffract

# The keywords that most methods share, for their documentation.
KEYWORDS = """
    coherence : float or (int, int), optional
        Coherence length of the light in metres: 65e-6, that of sunlight. Two whole numbers are a
        finite grating of so many copies of the patch along x and y, in fully coherent light.
    material : float or str, optional
        Refractive index of the surface, the name of a material (glass, keratin, aluminium, silver,
        gold, copper, nickel, silicon), or a CSV file of wavelength in nm, n and k. By default 1.5.
    film : (float, float), optional
        Thickness in metres and refractive index of a thin film on the material.
    polarisation : {"none", "te", "tm"}
        Polarisation of the light.
    theory : {"small-slope", "stam"}
        Theory of the brightness: the small-slope approximation of first order, limited to what a
        flat surface reflects, or Stam's factor without a limit.
    energy : bool, optional
        True for the theory with the limit of energy, False for that without: another name for
        `theory`.
    beyond : {"copies", "alike"}, optional
        Continuation of the surface beyond the patch. By default copies where the edges of the patch
        meet, else a surface that is alike.
    illuminant : str
        Spectrum of the light of colours: d65, d50, a, e, led, or a CSV file of wavelength in nm and
        power.
    tolerance : float
        Relative error that is accepted.
"""


def optics(
    coherence=None,
    material=None,
    film=None,
    polarisation=None,
    theory=None,
    energy=None,
    beyond=None,
    illuminant=None,
    tolerance=None,
    method=None,
    windows=None,
):
    """Returns the core of the settings."""
    if energy is not None:
        named = "small-slope" if energy else "stam"
        if theory not in (None, named):
            what = f"energy={energy} is the theory {named!r}, and theory={theory!r} is not"
            raise ValueError(f"{what}; leave one away")
        theory = named
    return _diffract.CoreOptics(
        coherence, material, film, polarisation, theory, beyond, illuminant, tolerance, method, windows
    )


def words(**keywords):
    """Returns the options of the command line that mean these keywords."""
    named = {name: value for name, value in keywords.items() if value is not None}
    found = []
    if "energy" in named:
        named["theory"] = "small-slope" if named.pop("energy") else "stam"
    if "coherence" in named:
        length = named.pop("coherence")
        found += ["--coherence", f"gaussian:{_diffract.micrometres_of(length)!r}um"]
    if "film" in named:
        thickness, index = named.pop("film")
        found += ["--film", f"{_diffract.micrometres_of(thickness)!r}um:{index!r}"]
    if isinstance(named.get("material"), (int, float)):
        found += ["--ior", repr(float(named.pop("material")))]
    for name, value in named.items():
        found += [f"--{name}", str(value)]
    return found


def documented(function):
    """Puts the shared keywords in place of ``{optics}`` in the documentation of `function`."""

    def indented(found):
        return textwrap.indent(textwrap.dedent(KEYWORDS).strip(), found.group(1))

    if function.__doc__:
        function.__doc__ = re.sub(r"^( *)\{optics\}$", indented, function.__doc__, flags=re.MULTILINE)
    return function
