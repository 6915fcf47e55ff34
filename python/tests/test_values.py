"""Values equal those of the command line to the last digit."""

import csv
import json

import numpy as np
import OpenEXR
import pytest

import diffract
from diffract import HeightField, direction

# θ_i, φ_i, θ_r, φ_r in degrees and wavelengths in nanometres, some of which are no whole numbers.
DIRECTIONS = [(30, 0, 46.05, 180), (30, 0, 16.25, 180), (75, 10, 48.3, 180), (0, 0, 33, 90), (60, 5, 89, 185)]
NANOMETRES = [380, 550, 550.1, 700, 780]


def table_of(rows):
    """Returns the queries of the command `eval`."""
    names = ["theta_i", "phi_i", "theta_r", "phi_r", "wavelength"][: len(rows[0])]
    return "\n".join([",".join(names), *(",".join(map(str, row)) for row in rows)])


def pairs(rows):
    """Returns the directions to light and viewer of some rows of angles."""
    theta_i, phi_i, theta_r, phi_r = np.array(rows, dtype=float).T[:4]
    return direction(theta_i, phi_i), direction(theta_r, phi_r)


@pytest.mark.parametrize(
    ("options", "keywords"),
    [
        ([], {}),
        (["--method", "reference"], {"method": "reference"}),
        (["--material", "gold", "--polarisation", "te"], {"material": "gold", "polarisation": "te"}),
        (["--ior", "1.7", "--theory", "stam"], {"material": 1.7, "energy": False}),
        (["--material", "glass", "--film", "120nm:1.7"], {"material": "glass", "film": (120e-9, 1.7)}),
        (["--coherence", "gaussian:17.3um", "--beyond", "alike"], {"coherence": 17.3e-6, "beyond": "alike"}),
    ],
)
def test_the_brdf_at_single_wavelengths(answers, blaze, options, keywords):
    rows = [(*angles, nm) for angles in DIRECTIONS for nm in NANOMETRES]
    if "reference" in options:
        rows = rows[::5]
    found = answers("eval", "blaze", "--queries", "-", *options, stdin=table_of(rows))
    wavelengths = np.array([row[4] for row in rows]) * 1e-9
    shortest = wavelengths.min()
    values = blaze.brdf(**keywords, shortest=shortest)(*pairs(rows), wavelengths)
    assert [float(row["brdf"]) for row in found] == values.tolist()
    assert (values > 0).any()


def test_colours_under_another_illuminant(answers, blaze):
    found = answers("eval", "blaze", "--queries", "-", "--illuminant", "a", stdin=table_of(DIRECTIONS))
    values = blaze.brdf(illuminant="a").xyz(*pairs(DIRECTIONS))
    assert [[float(row[name]) for name in "XYZ"] for row in found] == values.tolist()


def test_the_brdf_of_heights_in_an_array(answers):
    rng = np.random.default_rng(1)
    heights = 50e-9 * rng.standard_normal((40, 50))
    np.save("rough.npy", heights)
    rows = [(*angles, 550) for angles in DIRECTIONS]
    options = ["--pixel-size", "48.83nmx0.1um"]
    found = answers("eval", "rough.npy", "--queries", "-", *options, stdin=table_of(rows))
    values = HeightField(heights, (48.83e-9, 100e-9)).brdf()(*pairs(rows), 550e-9)
    assert [float(row["brdf"]) for row in found] == values.tolist()


def test_orders(answers):
    words = ["--wavelength", "450nm", "--wavelength", "700nm", "--material", "aluminium", "--least", "1e-6"]
    found = answers("orders", "sinusoid", "--light", "60,30", *words)
    orders = HeightField.generate("sinusoid").orders(
        direction(60, 30), [450e-9, 700e-9], material="aluminium", least=1e-6
    )
    assert len(found) == len(orders) > 10
    for row, order in zip(found, orders):
        assert float(row["wavelength"]) == pytest.approx(order["wavelength"] * 1e9, rel=1e-15)
        assert (int(row["m"]), int(row["n"])) == (order["m"], order["n"])
        told = [f"{order['theta']:.6f}", f"{order['phi']:.6f}", f"{order['efficiency']:.9e}"]
        number = lambda text: text.replace("e-0", "e-").replace("e+0", "e")
        assert [row["theta_r"], row["phi_r"], row["efficiency"]] == [*told[:2], number(told[2])]
        assert row["reflectance"] == number(f"{order['reflectance']:.9e}")
        period = "" if np.isnan(order["period"]) else f"{order['period'] * 1e9:.6f}"
        assert row["period"] == period


def test_peaks_and_the_period_with_its_uncertainty(answers):
    words = ["--theta-i", "75", "--angles", "-40:-10:0.5", "--wavelengths", "400:700:100"]
    found = answers("peaks", "elaphe", *words, "--json", "peaks.json")
    angles = np.arange(-80, -19) / 2
    peaks = HeightField.generate("elaphe").peaks(75, angles, wavelengths=np.arange(400, 701, 100) * 1e-9)
    table = peaks.table
    assert [float(row["angle"]) for row in found] == table["angle"].tolist()
    assert [float(row["response"]) for row in found] == table["response"].tolist()
    assert [float(row["period"]) for row in found] == pytest.approx(table["period"] * 1e9, rel=1e-12)
    with open("peaks.json", encoding="utf-8") as file:
        report = json.load(file)
    assert report["period_nm"]["mean"] == pytest.approx(peaks.period * 1e9, rel=1e-14)
    assert report["period_nm"]["standard_deviation"] == pytest.approx(peaks.deviation * 1e9, rel=1e-14)
    error = report.get("over_windows", {}).get("standard_error_nm", np.nan)
    assert error == pytest.approx(peaks.error * 1e9, rel=1e-14, nan_ok=True)


@pytest.mark.parametrize(("options", "keywords"), [(["--wavelength", "550nm"], {"wavelength": 550e-9}), ([], {})])
def test_maps_of_the_hemisphere(program, blaze, options, keywords):
    words = ["--light", "30,10", "--size", "24x24", "--coherence", "gaussian:20um"]
    program("brdf", "blaze", *words, *options, "-o", "map.npy")
    found = blaze.brdf(coherence=20e-6).map(direction(30, 10), size=24, **keywords)
    assert found.dtype == np.float32
    np.testing.assert_array_equal(np.load("map.npy"), found)
    assert np.isnan(found[0, 0]).all() and not np.isnan(found[12, 12]).any()


def test_reports_of_surfaces_and_files(program):
    def report(*words):
        found = json.loads(program("surface", "info", *words, "--json"))
        found.pop("origin")
        return found

    assert report("blaze") == HeightField.generate("blaze").info()
    heights = np.linspace(0, 1e-6, 4000).reshape(50, 80) ** 2
    heights[3:5, 7] = np.nan
    np.save("scan.npy", heights)
    with pytest.warns(UserWarning, match="2 of 4000 samples were not measured"):
        field = HeightField.read("scan.npy", pixel_size=0.1e-6)
    assert report("scan.npy", "--pixel-size", "100nm") == field.info()
    steps = ["--level", "plane", "--crop", "4um"]
    prepared = field.prepare("level plane", "crop 4um")
    assert report("scan.npy", "--pixel-size", "100nm", *steps) == prepared.info()
    assert prepared.info()["invalid"] == 2 and prepared.prepared == ("level plane", "crop 4um")


def test_prepared_heights(program):
    words = ["--seed", "7", "--patch", "20um", "--pixel-size", "100nm"]
    program("surface", "synth", "elaphe", *words, "-o", "scan.gwy")
    program("surface", "convert", "scan.gwy", "--level", "rows-median", "--crop", "10um", "-o", "part.npy")
    part = HeightField.read("scan.gwy").prepare("level rows-median", "crop 10um")
    part.save("again.npy")
    np.testing.assert_array_equal(np.load("again.npy"), np.load("part.npy"))
    field = HeightField.generate("elaphe", seed=7, patch=20e-6, pixel_size=100e-9)
    again = field.prepare("level rows-median", "crop 10um")
    np.testing.assert_allclose(again.heights, part.heights, rtol=0, atol=1e-18)


def test_tables_and_exports(program, blaze):
    words = ["--coherence", "gaussian:20um", "--tolerance", "0.1", "--footprint", "0.03"]
    program("export", "blaze", *words, "-o", "material")
    table = blaze.table(coherence=20e-6, tolerance=0.1, footprint=0.03)
    light, view = pairs(DIRECTIONS)
    np.testing.assert_array_equal(
        diffract.load_export("material").rgb(light, view, 0.03), table.rgb(light, view, 0.03)
    )
    with open("material/conformance.csv", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(line for line in file if not line.startswith("#"))]
    assert len(rows) > 100
    table.export("again")
    assert diffract.check_export("again") == diffract.check_export("material") < 0.1


def test_a_picture(program):
    words = ["--samples", "4", "--tolerance", "0.1", "--size", "64x40"]
    program("render", "sphere", "--surface", "blaze", *words, "-o", "sphere.exr")
    picture = diffract.render("sphere", "blaze", samples=4, tolerance=0.1, size=(64, 40))
    with OpenEXR.File("sphere.exr") as file:
        found = file.channels()["RGBA"].pixels
    np.testing.assert_array_equal(found.astype(np.float32), picture)
    assert picture.shape == (40, 64, 4) and 0.1 < (picture[..., 3] > 0.5).mean() < 0.9


def test_decimal_numbers_of_metres_are_the_command_lines(program):
    from diffract import _diffract

    tenths = np.arange(100, 10_000)
    metres = [float(f"{number}e-10") for number in tenths]
    for given in (metres, (tenths * 1e-10).tolist(), (tenths / 10 * 1e-9).tolist()):
        assert [_diffract.micrometres_of(length) for length in given] == (tenths / 10_000).tolist()
    assert [_diffract.metres_of(length) for length in tenths / 10_000] == metres
    third = 1e-6 / 3
    assert _diffract.micrometres_of(third) == pytest.approx(1 / 3, rel=4e-16)
