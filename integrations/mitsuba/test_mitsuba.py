"""Judges of the BSDF: the directions of an export, pictures of diffract, energy, and Mitsuba's chi-square test. Run: python -m unittest test_mitsuba"""

import contextlib
import csv
import json
import tempfile
import unittest
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")
mi.set_log_level(mi.LogLevel.Error)

import drjit as dr  # noqa: E402
from mitsuba import chi2  # noqa: E402

import compare  # noqa: E402
import diffract_bsdf  # noqa: E402, F401
import first_hit  # noqa: E402
import render  # noqa: E402
import scenes  # noqa: E402
from exported import Export, ExportError  # noqa: E402
from footprint import Covariance  # noqa: E402
from program import diffract, picture, relative_l2  # noqa: E402

OPTICS = ["--coherence", "gaussian:16um", "--tolerance", "2e-2"]
# Directions of the viewer for energy and samples: degrees from the normal and around it.
VIEWERS = [(0, 0), (30, 20), (55, 200), (70, 75)]


def setUpModule():
    global held, folder, skin, bsdf
    held = tempfile.TemporaryDirectory()
    folder = Path(held.name)
    skin = folder / "skin"
    diffract("export", "elaphe", "-o", skin, "--footprint", "0", *OPTICS)
    bsdf = mi.load_dict({"type": "diffract", "folder": str(skin)})


def tearDownModule():
    held.cleanup()


def seen_from(theta, phi, count):
    """Returns an interaction that is seen from a direction, as often as directions of light are asked for."""
    si = dr.zeros(mi.SurfaceInteraction3f, count)
    si.wi = mi.Vector3f(scenes.toward(theta, phi))
    return si


def conformance(skin, bsdf):
    """Returns answers to the directions of an export, and the columns of its file."""
    rows = np.genfromtxt(skin / "conformance.csv", delimiter=",", names=True)
    vector = lambda name: mi.Vector3f(*(mi.Float(rows[f"{name}_{axis}"]) for axis in "xyz"))
    xu, xv, yu, yv = (mi.Float(rows[name]) for name in ["dx_u", "dx_v", "dy_u", "dy_v"])
    around = Covariance(xu * xu + yu * yu, xu * xv + yu * yv, xv * xv + yv * yv)
    return lambda turn: np.array(bsdf.rgb(turn(vector("light")), turn(vector("viewer")), around)).T, rows


def from_table(skin):
    """Returns the relative L2 of the answers to the directions of an export from the colours of its table."""
    answer, rows = conformance(skin, mi.load_dict({"type": "diffract", "folder": str(skin)}))
    return relative_l2(answer(lambda v: v), np.stack([rows[f"table_{c}"] for c in "rgb"], axis=1))


class TheFunction(unittest.TestCase):
    def check(self, answers):
        """Returns what the program says of answers."""
        with open(folder / "mine.csv", "w") as file:
            csv.writer(file).writerows([["r", "g", "b"], *answers.tolist()])
        return diffract("export", "--check", skin, "--answers", folder / "mine.csv")

    def test_the_directions_of_the_export_have_the_colours_of_the_table(self):
        answer, _ = conformance(skin, bsdf)
        self.assertTrue(self.check(answer(lambda v: v)).startswith("right: "))
        off = from_table(skin)
        print(f"conformance: {off:.1e} relative L2 from the table")
        self.assertLess(off, 1e-5)  # sums of 32-bit floats; 1.4e-6 is measured

    def test_a_turned_footprint_is_noticed(self):
        answer, _ = conformance(skin, bsdf)
        turned = answer(lambda v: mi.Vector3f(v.y, -v.x, v.z))
        self.assertRaisesRegex(RuntimeError, "not those of the table", self.check, turned)


class Theories(unittest.TestCase):
    def test_each_theory_and_material_has_the_colours_of_its_table(self):
        for name, words in [("stam", ["--theory", "stam"]), ("gold", ["--material", "gold"]), ("tm", ["--polarisation", "tm"]), ("film", ["--film", "120nm:1.7"])]:
            diffract("export", "blaze", "-o", folder / name, "--footprint", "0.02", *OPTICS, *words)
            off = from_table(folder / name)
            print(f"blaze, {name}: {off:.1e} relative L2 from the table")
            self.assertLess(off, 1e-5, name)

    def test_gold_hides_a_pigment_and_glass_does_not(self):
        diffract("export", "blaze", "-o", folder / "metal", "--footprint", "0.02", *OPTICS, "--material", "gold")
        light, viewer = mi.Vector3f(scenes.toward(30, 0)), mi.Vector3f(scenes.toward(50, 90))
        around = Covariance(mi.Float(1e-4), mi.Float(0), mi.Float(1e-4))
        for name, hides in [("metal", True), ("skin", False)]:
            black, white = ({"type": "diffract", "folder": str(folder / name), "base_color": {"type": "rgb", "value": albedo}} for albedo in [0, 1])
            seen = [np.array(mi.load_dict(material).rgb(light, viewer, around)) for material in (black, white)]
            self.assertEqual(np.array_equal(*seen), hides, name)


class Pictures(unittest.TestCase):
    def ours(self, name, *words):
        path = folder / f"{name}.exr"
        camera, light = render.CAMERAS[name], ",".join(map(str, render.LIGHTS[name]))
        join = lambda point: ",".join(map(str, point))
        view = ["--eye", join(camera[0]), "--target", join(camera[1]), "--field-of-view", f"{camera[2]}deg", "--light", light]
        black = ["--base-color", "0,0,0", "--surface", "elaphe", "--table", skin]
        diffract("render", name, *view, *black, *OPTICS, *words, "-o", path)
        return picture(path)

    def scene(self, name, size, **others):
        return render.scene(name, {"type": "diffract", "folder": str(skin)}, size, **others)

    def one_sample(self, name, size, turned=0, **how):
        """Returns the relative L2 of one sample a pixel from that of diffract, where both show the surface alone."""
        ours, cover = self.ours(name, "--samples", "1", "--size", f"{size[0]}x{size[1]}", "--shadows", "on" if how.get("shadows", True) else "off")
        theta, phi, intensity = render.LIGHTS[name]
        found, seen = first_hit.picture(self.scene(name, size), theta + turned, phi, intensity, **how)
        both = seen & (cover == 1)
        self.assertGreater(both.sum(), 0.99 * (cover > 0).sum())
        return relative_l2(found[both], ours[both])

    def test_a_plate_is_that_of_diffract(self):
        off = self.one_sample("plate", (160, 120))
        print(f"plate, one sample: {off:.1e} relative L2")
        self.assertLess(off, 1e-3)  # 7.8e-5 is measured
        self.assertGreater(self.one_sample("plate", (160, 120), turned=0.2), 0.1)

    def test_a_snake_is_that_of_diffract(self):
        # Footprints of one are derivatives, of the other differences between pixels, and edges of shadows those of rays and of a depth map.
        for shadows, limit in [(False, 0.06), (True, 0.15)]:
            off = self.one_sample("snake", (640, 360), shadows=shadows)
            print(f"snake, one sample, shadows {shadows}: {off:.3f} relative L2")
            self.assertLess(off, limit)

    def test_a_path_traced_snake_is_that_of_diffract(self):
        size, block = (640, 360), 4
        ours, cover = self.ours("snake", "--samples", "64", "--size", "640x360")
        found = render.path_traced(self.scene("snake", size, light=render.LIGHTS["snake"]), 64, 2)
        mean = lambda x: x.reshape(size[1] // block, block, size[0] // block, block, -1).mean(axis=(1, 3))
        # Mitsuba has no quadratic B-spline for a filter; blocks of pixels hardly see a difference.
        inside = mean(cover)[..., 0] > 0.999
        found, ours = mean(found)[inside], mean(ours)[inside]
        off = relative_l2(found, ours)
        print(f"snake, 64 samples, blocks of {block}: {off:.3f} relative L2; mean {found.mean(axis=0) / ours.mean(axis=0)}")
        self.assertLess(off, 0.08)
        self.assertLess(abs(found.mean(axis=0) / ours.mean(axis=0) - 1).max(), 0.02)


class ThreePrograms(unittest.TestCase):
    def test_a_plate_by_diffract_by_mitsuba_and_by_a_browser_is_the_same(self):
        shown, _ = compare.plates()
        for pair, off in compare.differences(shown).items():
            print(f"plate, {' from '.join(pair)}: {off:.1e} relative L2")
            self.assertLess(off, 1e-3, pair)  # 7e-6 is measured
        self.assertGreater(relative_l2(shown["Mitsuba"][:, ::-1], shown["diffract"]), 0.1)


def furnace(material, theta, phi):
    """Returns the mean light that a viewer sees of a plate in white surroundings, linear sRGB, and its standard error."""
    light = {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}}
    scene = mi.load_dict({"type": "scene", "light": light, "plate": scenes.plate(material)})
    count = 1 << 19
    toward = mi.Vector3f(scenes.toward(theta, phi))
    ray = mi.RayDifferential3f(mi.Point3f(3 * toward), dr.repeat(-toward, count))
    sampler = mi.load_dict({"type": "independent"})
    sampler.seed(0, count)
    seen, _, _ = mi.load_dict({"type": "path", "max_depth": 2}).sample(scene, sampler, ray)
    seen = np.array(seen).T
    return seen.mean(axis=0), seen.std(axis=0) / np.sqrt(count)


class Energy(unittest.TestCase):
    def test_a_white_furnace_has_the_albedo_that_diffract_has(self):
        for theta, phi in VIEWERS:
            # By reciprocity the light that a viewer sees of a white surroundings is the albedo toward the viewer's direction.
            diffract("brdf", "elaphe", "--light", f"{theta},{phi}", *OPTICS, "--method", "table", "--size", "1024x1024", "-o", folder / "map.exr")
            values, _ = picture(folder / "map.exr")
            albedo = values.sum(axis=(0, 1)) * (2 / 1024) ** 2
            mean, spread = furnace({"type": "diffract", "folder": str(skin)}, theta, phi)
            print(f"furnace at {theta}, {phi}: {mean} ± {spread}, diffract {albedo}")
            # The sum over the map errs, too: 0.6 % are measured.
            self.assertTrue((abs(mean - albedo) < 0.01 * albedo.mean() + 4 * spread).all(), (theta, phi))
            self.assertTrue((mean < 1).all())

    def test_a_white_pigment_and_the_surface_together_reflect_all_light_and_no_more(self):
        for theta, phi in VIEWERS:
            white = {"type": "diffract", "folder": str(skin), "base_color": {"type": "rgb", "value": 1.0}}
            mean, spread = furnace(white, theta, phi)
            print(f"furnace of a white pigment at {theta}, {phi}: {mean} ± {spread}")
            self.assertTrue((mean < 1.01 + 4 * spread).all() and (mean > 0.95 - 4 * spread).all(), (theta, phi))


class Samples(unittest.TestCase):
    def test_directions_follow_their_density(self):
        for theta, phi in [(10, 30), (40, 200), (65, 75)]:
            adapter = chi2.BSDFAdapter("diffract", {"type": "diffract", "folder": str(skin)}, wi=scenes.toward(theta, phi))
            # 16 places along each side of a cell resolve the specular order, whose standard deviation is 0.02.
            test = chi2.ChiSquareTest(chi2.SphericalDomain(), *adapter, sample_dim=3, sample_count=1_000_000, res=101, ires=16)
            with contextlib.chdir(folder):
                self.assertTrue(test.run(significance_level=0.01, test_count=3), (theta, phi, test.messages))

    def test_a_density_that_is_wrong_is_noticed(self):
        sample, pdf = chi2.BSDFAdapter("diffract", {"type": "diffract", "folder": str(skin)}, wi=scenes.toward(40, 200))
        turned = lambda wo: pdf(mi.Vector3f(wo.x, -wo.y, wo.z))
        test = chi2.ChiSquareTest(chi2.SphericalDomain(), sample, turned, sample_dim=3, sample_count=100_000, res=51, ires=4)
        with contextlib.chdir(folder):  # where Mitsuba writes what it rejects
            self.assertFalse(test.run())

    def test_weights_are_the_value_over_the_density_and_vary_little(self):
        count = 200_000
        for theta, phi in VIEWERS:
            si, random = seen_from(theta, phi, count), mi.PCG32(size=count)
            context = mi.BSDFContext()
            sample, weight = bsdf.sample(context, si, random.next_float32(), mi.Point2f(random.next_float32(), random.next_float32()))
            value, density = bsdf.eval(context, si, sample.wo), bsdf.pdf(context, si, sample.wo)
            used = np.array(sample.pdf) > 0
            expected = (np.array(value) / np.maximum(np.array(density), 1e-30))[:, used]
            np.testing.assert_allclose(np.array(weight)[:, used], expected, rtol=1e-3, atol=1e-5)
            green = np.array(weight)[1]
            spread = green.var() / green.mean() ** 2
            print(f"samples from {theta}, {phi}: relative variance {spread:.2f}, {100 * used.mean():.0f} % above the horizon")
            # Directions drawn evenly have a relative variance of 10 to 100.
            self.assertLess(spread, 3)


class Refusals(unittest.TestCase):
    def test_an_export_that_is_truncated_newer_or_none_is_refused(self):
        copy = folder / "copy"
        copy.mkdir()
        self.assertRaisesRegex(ExportError, "make an export", Export, copy)
        for name in ["material.json", "table.json", "table.ktx2"]:
            (copy / name).write_bytes((skin / name).read_bytes())
        Export(copy)
        (copy / "table.ktx2").write_bytes((skin / "table.ktx2").read_bytes()[:-1])
        self.assertRaisesRegex(ExportError, "truncated", Export, copy)
        about = json.loads((skin / "material.json").read_text())
        (copy / "material.json").write_text(json.dumps(about | {"version": 5}))
        self.assertRaisesRegex(ExportError, "has version 5", Export, copy)


if __name__ == "__main__":
    unittest.main()
