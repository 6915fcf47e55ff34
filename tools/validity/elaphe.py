"""Random profiles with the spectrum of *Elaphe* across its fingers, the built-in surface `elaphe` of diffract.

`python elaphe.py HEIGHTS.npy SPACING_UM` writes the spectrum anew, from what `diffract surface convert elaphe -o HEIGHTS.npy` wrote.
"""

import sys
from functools import lru_cache
from pathlib import Path

import numpy as np

from profiles import from_graph

SPECTRUM = Path(__file__).parents[2] / "assets/validity/elaphe-spectrum.csv"
# Frequencies of the table [1/µm]. What is longer than 3 µm tilts the surface and diffracts hardly any light.
STEP, SMALLEST, LARGEST = 0.05, 0.35, 4.0


def spectrum(heights, spacing):
    """Returns frequencies [1/µm] and the mean power spectral density of the rows [µm³], averaged over `STEP`. heights, spacing: µm."""
    n = heights.shape[1]
    power = 2 * spacing / n * np.mean(abs(np.fft.rfft(heights, axis=1)) ** 2, axis=0)
    frequency = np.fft.rfftfreq(n, spacing)
    centres = np.arange(SMALLEST, LARGEST, STEP)
    return centres, np.array([power[abs(frequency - f) <= STEP / 2].mean() for f in centres])


@lru_cache(maxsize=64)
def rough(period, height, length, seed):
    """Returns a random Gaussian profile, repeated after `length`. Of the ensemble, the mean period weighted by the power of the slope, Σ P f / Σ P f²,
    is `period`, and the RMS slope is that of a sinusoid of this period and of full height `height`."""
    frequency, density = np.loadtxt(SPECTRUM, delimiter=",", skiprows=1).T
    # Cycles over the length that the frequencies of the table become. Each harmonic has the power of the interval around it.
    cycles = frequency * np.sum(density * frequency) / np.sum(density * frequency**2) * length / period
    below = np.concatenate([[0], np.cumsum(density)])
    edges = np.concatenate([cycles, [2 * cycles[-1] - cycles[-2]]])
    m = np.arange(1, int(edges[-1]) + 1)
    k = 2j * np.pi * m / length
    power = np.interp(m + 0.5, edges, below) - np.interp(m - 0.5, edges, below)
    rms = np.sqrt(np.sum(power * abs(k) ** 2))
    slope = 2 * np.pi / period * height / np.sqrt(8)
    real, imaginary = np.random.default_rng(seed).standard_normal((2, len(m)))
    amplitude = slope / rms * np.sqrt(power) * (real + 1j * imaginary)

    def series(coefficients):
        return lambda x: (np.exp(np.multiply.outer(x, k)) @ coefficients).real

    return from_graph(length, series(amplitude), series(amplitude * k))


if __name__ == "__main__":
    frequencies, densities = spectrum(1e6 * np.load(sys.argv[1]), float(sys.argv[2]))
    SPECTRUM.parent.mkdir(parents=True, exist_ok=True)
    with open(SPECTRUM, "w") as file:
        file.write("frequency_per_um,density_um3\n")
        file.writelines(f"{f:.2f},{p:.4g}\n" for f, p in zip(frequencies, densities))
