//! Signs and axes: a facet sends light where a mirror of its tilt does, and no flip of the image goes unnoticed.

use crate::plain::{MIRROR, mirrored, scaled, surface, swapped, toward, upside_down, view_at};
use ::image::{GrayImage, Luma};
use diffract::internals::optics::coherence::Coherence;
use diffract::internals::optics::geometry::Pair;
use diffract::internals::optics::reference::Reference;
use diffract::internals::surface::HeightField;
use diffract::internals::surface::files::{self, ReadSettings, image};
use diffract::internals::surface::synth::{Spec, SurfaceKind, generate};
use diffract::internals::task::Task;
use glam::{DVec2, DVec3};

/// 100 × 100 samples, close enough for |u| ≤ 2 at [`WAVELENGTH`].
const SAMPLES: usize = 100;
const PIXEL: f64 = 0.14;
const WAVELENGTH: f64 = 0.6;
/// σ = 1.5 µm: the sawtooth's edge, 7 µm away, is seen with g² = 3e-10, so the window holds one facet.
const WINDOW: Coherence = Coherence::Gaussian { length: 6.0 };

/// One facet h = s_x x + s_y y, which repeats as a sawtooth.
fn facet(slope: DVec2) -> HeightField {
    surface([SAMPLES; 2], [PIXEL; 2], |x, y| slope.dot(DVec2::new(x, y)))
}

/// The brightest view direction on a grid of direction cosines of this step, finer than the peak, 1/(kσ) = 0.064.
const STEP: f64 = 0.04;

fn brightest(field: &HeightField, light: DVec3) -> DVec3 {
    let reference = Reference::new(field, WINDOW, [1, 1], MIRROR);
    let side = (0.98 / STEP) as i32;
    let grid = (-side..=side).flat_map(|j| (-side..=side).map(move |i| (i, j)));
    let views = grid.filter_map(|(i, j)| {
        let across = DVec2::new(f64::from(i), f64::from(j)) * STEP;
        view_at(light, -light.truncate() - across)
    });
    let bright = views.map(|view| (reference.brdf(&Pair::new(light, view), WAVELENGTH), view));
    bright.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap().1
}

/// How far, in direction cosines, the brightest view is from the mirror direction of a facet of slope `slope`: the
/// normal is (−s_x, −s_y, 1), the light is reflected at it.
fn facet_deviation(field: &HeightField, slope: DVec2, light: DVec3) -> f64 {
    let normal = (-slope).extend(1.0).normalize();
    let expected = 2.0 * normal.dot(light) * normal - light;
    brightest(field, light).truncate().distance(expected.truncate())
}

/// Half a diagonal of the grid; the slowly varying factors of B.12 move the peak by less than the rest.
const TOLERANCE: f64 = STEP;

const SLOPES: [DVec2; 4] =
    [DVec2::new(0.1, 0.0), DVec2::new(-0.1, 0.0), DVec2::new(0.0, 0.1), DVec2::new(0.0, -0.1)];

#[test]
fn a_facet_sends_light_where_a_mirror_of_its_slope_does() {
    for slope in SLOPES {
        for light in [DVec3::Z, toward(25.0, 40.0)] {
            let deviation = facet_deviation(&facet(slope), slope, light);
            assert!(deviation < TOLERANCE, "slope {slope}, light {light}: {deviation}");
        }
    }
}

#[test]
fn a_facet_that_rises_along_x_sends_light_toward_minus_x_at_u_of_plus_twice_its_slope() {
    let view = brightest(&facet(DVec2::new(0.1, 0.0)), DVec3::Z);
    assert!(view.x < 0.0);
    // u = 2s/(1 + s²) exactly.
    assert!((-view.x - 0.2).abs() < TOLERANCE && view.y.abs() < TOLERANCE, "{view}");
}

#[test]
fn the_facet_check_fails_for_every_flip() {
    let flips: [fn(&HeightField) -> HeightField; 4] =
        [mirrored, upside_down, swapped, |field| scaled(field, -1.0)];
    let slope = DVec2::new(0.1, 0.06);
    assert!(facet_deviation(&facet(slope), slope, DVec3::Z) < TOLERANCE);
    for (which, flip) in flips.iter().enumerate() {
        // Exchanging the axes moves the light least: by 2·√2·(0.1 − 0.06).
        let deviation = facet_deviation(&flip(&facet(slope)), slope, DVec3::Z);
        assert!(deviation > 2.0 * TOLERANCE, "flip {which}: {deviation}");
    }
}

/// The height image at `path`, whose largest code means `full_height` \[µm\].
fn read(path: &std::path::Path, full_height: f64) -> HeightField {
    let settings = ReadSettings::new().with_pixel_size([PIXEL; 2]).with_height(full_height);
    files::read(path, &settings, &Task::silent()).unwrap().into_field().unwrap()
}

#[test]
fn a_facet_keeps_its_direction_through_a_height_image_and_the_flipped_image_does_not() {
    let folder = tempfile::tempdir().unwrap();
    let slope = DVec2::new(0.1, -0.06);
    for name in ["facet.png", "facet.tif"] {
        let path = folder.path().join(name);
        let full_height = image::write(&path, &facet(slope)).unwrap();
        let back = read(&path, full_height);
        let deviation = facet_deviation(&back, slope, DVec3::Z);
        assert!(deviation < TOLERANCE, "{name}: {deviation}");
        assert!(facet_deviation(&upside_down(&back), slope, DVec3::Z) > 2.0 * TOLERANCE);
    }
}

#[test]
fn an_image_that_is_bright_at_the_top_is_a_slope_up_along_y() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bright-top.png");
    // Row 0, the top, has the largest code: 198, and each row below 2 less.
    let picture = GrayImage::from_fn(SAMPLES as u32, SAMPLES as u32, |_, row| Luma([198 - 2 * row as u8]));
    picture.save(&path).unwrap();
    let slope = DVec2::new(0.0, 0.1);
    // One row is 0.1·PIXEL = 2 codes of 255.
    let back = read(&path, 0.1 * PIXEL / 2.0 * 255.0);
    let deviation = facet_deviation(&back, slope, DVec3::Z);
    assert!(deviation < TOLERANCE, "{deviation}");
    assert!(facet_deviation(&upside_down(&back), slope, DVec3::Z) > 2.0 * TOLERANCE);
}

/// u of the strongest of the orders −3 … 3 of a blazed grating of period `period` at normal incidence.
fn strongest_order(field: &HeightField, wavelength: f64, period: f64) -> f64 {
    let reference = Reference::new(field, Coherence::SUNLIGHT, [1, 1], MIRROR);
    let orders = (-3..=3).map(|m| f64::from(m) * wavelength / period).map(|u| {
        let view = view_at(DVec3::Z, DVec2::new(u, 0.0)).unwrap();
        (reference.power(DVec3::new(u, 0.0, -1.0 - view.z), 1.0 / wavelength, 0.0, 1)[0], u)
    });
    orders.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap().1
}

#[test]
fn the_generated_blaze_sends_its_light_into_the_first_order_on_the_positive_side() {
    let blaze = generate(&Spec::new(SurfaceKind::Blaze).with_patch([10.0, 1.0])).unwrap();
    // Slope 0.24623/2.5: u = −w s = 0.195 is the first order of a period of 2.5 µm at 0.4878 µm.
    let (wavelength, u) = (0.4878, 0.1951);
    assert!((strongest_order(&blaze, wavelength, 2.5) - u).abs() < 1e-3);
    assert!((strongest_order(&mirrored(&blaze), wavelength, 2.5) + u).abs() < 1e-3);
}
