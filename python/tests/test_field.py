"""Height fields: arrays, files, pickles."""

import pickle
import warnings

import numpy as np
import pytest

from diffract import HeightField


def bowl(rows=30, columns=40):
    y, x = np.mgrid[:rows, :columns]
    return 1e-9 * ((x - 20.0) ** 2 + (y - 15.0) ** 2)


def test_heights_are_a_view_that_may_only_be_read():
    field = HeightField(bowl(), 0.1e-6)
    heights = field.heights
    np.testing.assert_allclose(heights, bowl(), rtol=3e-16)
    assert heights.shape == field.shape == (30, 40) and not heights.flags.writeable
    assert np.shares_memory(heights, field.heights)
    with pytest.raises(ValueError):
        heights[0, 0] = 1
    with pytest.raises(ValueError):
        heights.flags.writeable = True
    del field
    assert heights.sum() > 0, "they outlive the field"
    np.testing.assert_array_equal(np.asarray(HeightField(bowl(), 0.1e-6)), heights)


@pytest.mark.parametrize(
    "change",
    [
        lambda h: h[::-1][::-1],
        np.asfortranarray,
        lambda h: np.repeat(h, 2, axis=1)[:, ::2],
        lambda h: h.astype(">f8"),
        lambda h: h.tolist(),
        lambda h: np.ma.masked_array(h),
    ],
)
def test_layouts_change_no_heights(change):
    assert HeightField(change(bowl()), 0.1e-6) == HeightField(bowl(), 0.1e-6)


def test_integers_and_32_bit_floats_are_heights():
    single = bowl().astype(np.float32)
    assert HeightField(single, 1e-7) == HeightField(single.astype(float), 1e-7)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # a metre high
        assert HeightField(np.eye(3, dtype=int), 1e-7) == HeightField(np.eye(3), 1e-7)


def test_gaps_are_filled_and_told():
    heights = bowl()
    heights[5, 5] = np.nan
    with pytest.warns(UserWarning, match="1 of 1200 samples were not measured"):
        field = HeightField(heights, 0.1e-6)
    around = np.delete(bowl()[4:7, 4:7].ravel(), 4)
    assert field.heights[5, 5] == pytest.approx(around.mean())
    masked = np.ma.masked_array(bowl(), mask=np.isnan(heights))
    with pytest.warns(UserWarning, match="array: 1 of"):
        assert HeightField(masked, 0.1e-6) == field
    assert field.info()["invalid"] == 1


def test_heights_in_another_unit_are_questioned():
    with pytest.warns(UserWarning, match="unit"):
        HeightField(bowl() * 1e6, 0.1e-6)


@pytest.mark.parametrize(
    ("heights", "pixel_size", "name"),
    [
        (np.zeros(3), 1e-7, "heights"),
        (np.zeros((2, 2, 2)), 1e-7, "heights"),
        (5.0, 1e-7, "heights"),
        (np.zeros((0, 3)), 1e-7, "heights"),
        (np.full((3, 3), np.nan), 1e-7, "heights"),
        (np.full((3, 3), np.inf), 1e-7, "heights"),
        (np.zeros((3, 3)), 0, "pixel size"),
        (np.zeros((3, 3)), (1e-7, -1e-7), "pixel size"),
        (np.zeros((3, 3)), (1e-7, 1e-7, 1e-7), "pixel_size"),
        (np.zeros((3, 3)), np.nan, "pixel size"),
    ],
)
def test_wrong_arrays_are_refused_by_name(heights, pixel_size, name):
    with pytest.raises(ValueError, match=name):
        HeightField(heights, pixel_size)


def test_words_are_no_heights():
    with pytest.raises(TypeError, match="heights"):
        HeightField([["high", "low"]], 1e-7)
    with pytest.raises(TypeError, match="pixel_size"):
        HeightField(bowl(), "100nm")


def test_a_pickle_holds_everything():
    field = HeightField.generate("elaphe", seed=3, patch=10e-6).prepare("level plane", "crop 5um")
    again = pickle.loads(pickle.dumps(field))
    assert again == field and again.prepared == field.prepared and again.name == "elaphe"
    assert again.heights.tobytes() == field.heights.tobytes()
    assert again.info() == field.info()


def test_files_are_read_with_their_channels(tmp_path):
    field = HeightField.generate("elaphe", patch=8e-6).prepare("level mean")
    for extension in ("gsf", "gwy", "npy", "txt", "x3p", "tif"):
        path = tmp_path / f"field.{extension}"
        field.save(path)
        pixel_size = field.pixel_size if extension in ("npy", "tif") else None
        again = HeightField.read(path, pixel_size=pixel_size)
        np.testing.assert_allclose(again.heights, field.heights, atol=2e-14)
        assert again.pixel_size == pytest.approx(field.pixel_size)
    assert HeightField.read("field.gwy", channel=1) == HeightField.read("field.gwy")
    with pytest.raises(ValueError, match="channel"):
        HeightField.read("field.gwy", channel="Colour")
    doubled = HeightField.read("field.gwy", height=2e-6)
    assert np.ptp(doubled.heights) == pytest.approx(2e-6)


def test_errors_of_files_and_steps_are_those_of_python():
    with pytest.raises(OSError, match="no/such.gwy"):
        HeightField.read("no/such.gwy")
    open("empty.gwy", "wb").close()
    with pytest.raises(ValueError, match="empty"):
        HeightField.read("empty.gwy")
    with pytest.raises(ValueError, match="jpg"):
        HeightField(bowl(), 1e-7).save("heights.jpg")
    with pytest.raises(OSError, match="nowhere"):
        HeightField(bowl(), 1e-7).save("nowhere/heights.gsf")
    with pytest.raises(ValueError, match="flat"):
        HeightField(bowl(), 1e-7).prepare("level flat")
    with pytest.raises(ValueError, match="kind"):
        HeightField.generate("python")
    with pytest.raises(ValueError, match="period|positive"):
        HeightField.generate("sinusoid", period=-1e-6)


def test_a_field_shows_itself():
    field = HeightField(bowl(), (0.1e-6, 50e-9))
    assert repr(field) == "HeightField(40 x 30, 100 nm x 50 nm apart, heights over 625 nm)"
    assert field._repr_png_().startswith(b"\x89PNG")
    assert field != "a field" and field.patch_size == pytest.approx((4e-6, 1.5e-6))
    with pytest.raises(TypeError):
        hash(field)


def test_a_page_holds_the_material():
    page = HeightField.generate("blaze", patch=10e-6).show(tolerance=0.2, coherence=20e-6, height=300)
    assert page.html.startswith("<!doctype html>") or page.html.startswith("<!DOCTYPE html>")
    assert "height:300px" in page._repr_html_() and len(page.html) < 10_000_000
    page.save("page.html")
    with open("page.html", encoding="utf-8") as file:
        assert file.read() == page.html
    with pytest.raises(ValueError, match="tolerance"):
        HeightField.generate("blaze").show(tolerance=7)


def test_surfaces_of_surfacetopography_go_both_ways():
    from SurfaceTopography import Topography

    field = HeightField.generate("elaphe", patch=8e-6)
    there = Topography(field.heights[::-1].T, field.patch_size, unit="m")
    assert there.rms_height_from_area() == pytest.approx(field.info()["rms_m"])
    back = HeightField(there.heights().T[::-1], [size / n for size, n in zip(there.physical_sizes, there.nb_grid_pts)])
    np.testing.assert_allclose(back.heights, field.heights, rtol=4e-16)
    assert back.pixel_size == pytest.approx(field.pixel_size, rel=1e-14)
