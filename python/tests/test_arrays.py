"""Arrays of any shape, type and layout."""

import numpy as np
import pytest

import diffract
from diffract import direction

LIGHT = direction(30, 0)
VIEWS = direction([0, 16.26, 30, 46.05, 50, 60], 180)


def test_shapes_are_broadcast_as_numpy_does(brdf):
    lights = direction([10, 30], 0)
    wavelengths = [450e-9, 550e-9, 650e-9]
    all_of = brdf(lights[:, None, None], VIEWS[:, None], wavelengths)
    assert all_of.shape == (2, 6, 3)
    for i, j, k in np.ndindex(2, 6, 3):
        assert all_of[i, j, k] == brdf(lights[i], VIEWS[j], wavelengths[k])
    assert brdf.xyz(lights[:, None], VIEWS).shape == brdf.rgb(lights[:, None], VIEWS).shape == (2, 6, 3)
    np.testing.assert_array_equal(
        brdf.rgb(lights[:, None], VIEWS), diffract.linear_srgb(brdf.xyz(lights[:, None], VIEWS))
    )


def test_a_single_pair_has_a_number(brdf):
    value = brdf(LIGHT, VIEWS[2], np.array(550e-9))
    assert np.ndim(value) == 0 and isinstance(value, float)
    assert brdf(tuple(LIGHT), list(VIEWS[2]), 550e-9) == value


@pytest.mark.parametrize(
    "change",
    [
        lambda v: v[::-1][::-1],
        lambda v: np.asfortranarray(v),
        lambda v: np.repeat(v, 2, axis=0)[::2],
        lambda v: np.concatenate([v, v], axis=1)[:, :3],
        lambda v: v.astype(">f8"),
        lambda v: v.astype(np.longdouble),
        lambda v: v.tolist(),
        lambda v: np.ma.masked_array(v, mask=False),
    ],
)
def test_layouts_and_types_change_nothing(brdf, change):
    np.testing.assert_array_equal(brdf(LIGHT, change(VIEWS), 550e-9), brdf(LIGHT, VIEWS, 550e-9))


def test_floats_of_32_bits_are_taken(brdf):
    single = VIEWS.astype(np.float32)
    np.testing.assert_array_equal(
        brdf(LIGHT, single, 550e-9), brdf(LIGHT, single.astype(np.float64), 550e-9)
    )
    whole = diffract.direction(np.array([30], dtype=np.int32), np.uint8(0))
    np.testing.assert_array_equal(whole, [LIGHT])


def test_nan_and_masks_give_nan_and_the_horizon_0(brdf):
    views = np.array([VIEWS[1], [np.nan, 0, 1], direction(120, 0), VIEWS[3]])
    values = brdf(LIGHT, views, [550e-9, 550e-9, 550e-9, np.nan])
    assert values[0] == brdf(LIGHT, VIEWS[1], 550e-9) and values[2] == 0
    assert np.isnan(values[[1, 3]]).all()
    masked = np.ma.masked_array(VIEWS, mask=np.zeros((6, 3), bool))
    masked[4] = np.ma.masked
    colours = brdf.rgb(LIGHT, masked)
    assert np.isnan(colours[4]).all() and np.isfinite(colours[[0, 1, 2, 3, 5]]).all()


def test_nothing_asked_is_nothing_answered(brdf, blaze):
    assert brdf(LIGHT, np.empty((0, 3)), 550e-9).shape == (0,)
    assert brdf(LIGHT, np.empty((4, 0, 3)), 550e-9).shape == (4, 0)
    assert brdf.rgb(LIGHT, np.empty((0, 3))).shape == (0, 3)
    assert direction([], 0).shape == (0, 3)
    assert blaze.orders(LIGHT, []).shape == (0,)


@pytest.mark.parametrize(
    ("call", "name", "kind"),
    [
        (lambda b: b([0, 1], VIEWS, 550e-9), "light", ValueError),
        (lambda b: b(LIGHT, 1.0, 550e-9), "view", ValueError),
        (lambda b: b(LIGHT, 2 * VIEWS, 550e-9), "view", ValueError),
        (lambda b: b(LIGHT, VIEWS, [550e-9, 600e-9]), "wavelength", ValueError),
        (lambda b: b(VIEWS[:2], VIEWS[:3], 550e-9), "view", ValueError),
        (lambda b: b(LIGHT, VIEWS, 550), "wavelength", ValueError),
        (lambda b: b(LIGHT, VIEWS, "green"), "wavelength", TypeError),
        (lambda b: b(LIGHT, VIEWS.astype(complex), 550e-9), "view", TypeError),
        (lambda b: b([[0, 0, 1], [0, 1]], VIEWS[:2], 550e-9), "light", ValueError),
        (lambda b: b.map(VIEWS), "light", ValueError),
        (lambda b: b.map(LIGHT, size=0), "size", ValueError),
        (lambda b: b.map([np.nan, 0, 1]), "light", ValueError),
        (lambda b: diffract.srgb([1, 2]), "linear", ValueError),
        (lambda b: direction([1, 2], [1, 2, 3]), "phi", ValueError),
    ],
)
def test_errors_name_the_argument(brdf, call, name, kind):
    with pytest.raises(kind, match=name):
        call(brdf)


@pytest.mark.parametrize(
    ("keywords", "name"),
    [
        ({"coherence": 65}, "coherence"),
        ({"coherence": (0, 1)}, "coherence"),
        ({"material": 0.5}, "material"),
        ({"material": "unobtainium"}, "unobtainium"),
        ({"film": (120e-9, 1.7)}, "film"),
        ({"polarisation": "s"}, "polarisation"),
        ({"theory": "kirchhoff"}, "theory"),
        ({"theory": "stam", "energy": True}, "energy"),
        ({"beyond": "mirrored"}, "beyond"),
        ({"illuminant": "candle"}, "candle"),
        ({"tolerance": 2.0}, "tolerance"),
        ({"method": "table"}, "method"),
        ({"windows": "3x3"}, "windows"),
        ({"shortest": 1.0}, "wavelength"),
    ],
)
def test_settings_without_meaning_are_refused(blaze, keywords, name):
    with pytest.raises((ValueError, OSError), match=name):
        blaze.brdf(**keywords)


def test_wavelengths_below_those_of_a_reference_are_refused(blaze):
    with pytest.raises(ValueError, match="shorter"):
        blaze.brdf(method="reference", energy=False)(LIGHT, VIEWS[0], 300e-9)


def test_footprints_are_numbers_or_covariances(blaze):
    table = blaze.table(tolerance=0.1, coherence=20e-6)
    round_one = table.rgb(LIGHT, VIEWS, 0.05)
    np.testing.assert_array_equal(round_one, table.rgb(LIGHT, VIEWS, covariance=np.eye(2) * 0.05**2))
    assert table.rgb(LIGHT, VIEWS, [[0.02], [0.1]]).shape == (2, 6, 3)
    long = table.rgb(LIGHT, VIEWS, covariance=[[0.05**2, 0], [0, 0.02**2]])
    assert not np.array_equal(long, round_one)
    # A wide footprint averages colours: their range shrinks.
    spread = lambda footprint: np.ptp(table.xyz(LIGHT, direction(np.linspace(0, 60, 90), 180), footprint)[:, 1])
    assert spread(0.2) < 0.5 * spread(0.02)
    for wrong in ({"footprint": -0.1}, {"covariance": [0.1, 0.2]}, {"footprint": 0.1, "covariance": np.eye(2)}):
        with pytest.raises(ValueError, match="footprint|covariance"):
            table.rgb(LIGHT, VIEWS, **wrong)


def test_the_tables_of_pandas_take_orders_and_peaks(blaze):
    import pandas

    orders = pandas.DataFrame(blaze.orders(LIGHT, [450e-9, 550e-9]))
    assert orders.groupby("wavelength").efficiency.sum().between(0.02, 0.06).all()
    assert orders.dtypes["m"] == np.int64
    peaks = blaze.peaks(-75, np.arange(38, 57, 0.1), wavelengths=[500e-9, 600e-9])
    assert pandas.DataFrame(peaks.table)["is_clear"].all()
    assert peaks.period == pytest.approx(2.5e-6, rel=2e-3) and peaks.branches == []
    assert "period 2.5 µm" in repr(peaks)
