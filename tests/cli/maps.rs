//! Maps of the hemisphere through one window and through repeats: they agree with the reference, and hold the energy that closed forms say.

use crate::sandbox::Sandbox;
use diffract::internals::optics::coherence::Coherence;
use diffract::internals::optics::color::xyz_to_linear_srgb;
use diffract::internals::optics::geometry::{Pair, direction};
use diffract::internals::optics::nufft;
use diffract::internals::optics::quadrature::gauss_legendre;
use diffract::internals::optics::reference::Reference;
use diffract::internals::optics::reflectance::Reflectance;
use diffract::internals::optics::spectrum::{Illuminant, observer};
use diffract::internals::optics::theory::Theory;
use diffract::internals::surface::HeightField;
use diffract::internals::surface::synth::{Spec, SurfaceKind, generate};
use diffract::internals::task::Task;
use glam::DVec3;
use std::f64::consts::TAU;

/// Pixels on a side of the maps here, and directions along a side of each over which the reference averages.
const SIDE: usize = 48;
const PARTS: u32 = 5;
/// Distance in (u, v) from the mirror direction up to which its peak reaches.
const MIRROR: f64 = 0.15;
/// θ_i, φ_i: in the grating's plane, out of it, and grazing.
const LIGHTS: [[f64; 2]; 3] = [[30.0, 0.0], [50.0, 120.0], [75.0, 200.0]];

/// A pixel of the disc and the direction that it shows, as the contract has it.
fn views(side: usize) -> impl Iterator<Item = (usize, DVec3)> {
    (0..side * side).filter_map(move |place| {
        let centre = |i: usize| 2.0 * (i as f64 + 0.5) / side as f64 - 1.0;
        let (x, y) = (centre(place % side), -centre(place / side));
        let z = 1.0 - x * x - y * y;
        (z > 0.0).then(|| (place, DVec3::new(x, y, z.sqrt())))
    })
}

/// Directions in the pixel about `view` and their weights in the average: by Gauss and Legendre's rule, or evenly where the horizon cuts the pixel.
fn parts(view: DVec3) -> Vec<(DVec3, f64)> {
    let even: Vec<(f64, f64)> = (0..8).map(|i| (f64::from(i) / 8.0 + 0.0625, 0.125)).collect();
    let inside = |rule: &[(f64, f64)]| -> Vec<(DVec3, f64)> {
        let at = |x: f64| 2.0 / SIDE as f64 * (x - 0.5);
        let mut found = Vec::new();
        for (i, a) in rule {
            for (j, b) in rule {
                let (x, y) = (view.x + at(*i), view.y + at(*j));
                let z = 1.0 - x * x - y * y;
                if z > 0.0 {
                    found.push((DVec3::new(x, y, z.sqrt()), a * b));
                }
            }
        }
        found
    };
    let all = inside(&gauss_legendre(PARTS));
    if all.len() == PARTS.pow(2) as usize {
        return all;
    }
    let some = inside(&even);
    let whole: f64 = some.iter().map(|(_, weight)| weight).sum();
    some.into_iter().map(|(view, weight)| (view, weight / whole)).collect()
}

/// Returns true for the pixels of a map that are compared: all about the mirror direction of each of [`LIGHTS`], and of the rest one in five, each
/// of another column than in the rows beside it.
fn is_compared(place: usize, view: DVec3) -> bool {
    let from_mirror = |[theta, phi]: [f64; 2]| (view + direction(theta, phi)).truncate().length();
    (place % SIDE + 2 * (place / SIDE)).is_multiple_of(5)
        || LIGHTS.into_iter().any(|light| from_mirror(light) <= MIRROR)
}

/// Returns the numbers of the compared pixels among those of the disc, and their directions.
fn compared() -> Vec<(usize, DVec3)> {
    let all = views(SIDE).enumerate();
    all.filter(|(_, (place, view))| is_compared(*place, *view)).map(|(i, (_, view))| (i, view)).collect()
}

/// A surface in a file, and what the program has to be told of it.
struct Subject {
    sandbox: Sandbox,
    field: HeightField,
    words: Vec<String>,
}

impl Subject {
    fn new(kind: SurfaceKind, side: f64) -> Self {
        let sandbox = Sandbox::new();
        let field = generate(&Spec::new(kind).with_patch([side, side]).with_seed(1)).unwrap();
        let patch = format!("{side}um");
        sandbox.run(["surface", "synth", kind.name(), "--patch", &patch, "-o", "s.png"]).done();
        let [dx, dy] = field.pixel_size().map(|x| x * 1e3);
        let (low, high) = field.range();
        let height = (high - low) * 1e3;
        let words = format!("s.png --pixel-size {dx}nmx{dy}nm --height {height}nm");
        Self { sandbox, field, words: words.split(' ').map(str::to_owned).collect() }
    }

    /// Linear sRGB over the disc under `setting`.
    #[track_caller]
    fn map(&self, [theta, phi]: [f64; 2], setting: &str, side: usize) -> Vec<DVec3> {
        let rest = format!("--light {theta},{phi} --size {side}x{side} -o m.exr {setting}");
        // Quiet, because a busy machine says that it takes long.
        let words =
            ["-q", "brdf"].into_iter().chain(self.words.iter().map(String::as_str)).chain(rest.split(' '));
        self.sandbox.run(words).done();
        let picture = image::open(self.sandbox.path("m.exr")).unwrap().to_rgba32f();
        let pixels: Vec<_> = picture.pixels().map(|p| p.0.map(f64::from)).collect();
        views(side)
            .map(|(place, _)| DVec3::new(pixels[place][0], pixels[place][1], pixels[place][2]))
            .collect()
    }

    /// The same of the [`compared`] pixels in f64, averaged over each.
    fn exact(&self, [theta, phi]: [f64; 2], coherence: Coherence) -> Vec<DVec3> {
        // Stam's theory has no limit of energy, which the reference does not know.
        let stam = Reflectance::default().by(Theory::Stam);
        let reference = Reference::new(&self.field, coherence, [1, 1], stam);
        let light = direction(theta, phi);
        let parts: Vec<Vec<(DVec3, f64)>> = compared().into_iter().map(|(_, view)| parts(view)).collect();
        let pairs: Vec<Pair> = parts.iter().flatten().map(|(view, _)| Pair::new(light, *view)).collect();
        let xyz = nufft::cosine_weighted_xyz(&reference, &Illuminant::D65, &pairs, &Task::silent()).unwrap();
        let mut values = xyz.into_iter().map(|f| xyz_to_linear_srgb(f / light.z));
        parts
            .iter()
            .map(|parts| parts.iter().map(|(_, weight)| values.next().unwrap() * *weight).sum())
            .collect()
    }
}

/// ‖found − exact‖/‖exact‖ over the pixels that `keep` takes.
fn deviation(found: &[DVec3], exact: &[DVec3], keep: impl Fn(usize) -> bool) -> f64 {
    let kept = || found.iter().zip(exact).enumerate().filter(|(i, _)| keep(*i)).map(|(_, pair)| pair);
    let off: f64 = kept().map(|(f, e)| (*f - *e).length_squared()).sum();
    (off / kept().map(|(_, e)| e.length_squared()).sum::<f64>()).sqrt()
}

/// The map of `kind` through `coherence` under each light agrees with the reference within a tolerance, over pixels of the whole disc and over what is
/// not the mirror's peak, which is the brightest of most maps; and the next map of the list does not.
fn agrees(kind: SurfaceKind, side: f64, coherence: &str, coherent: Coherence) {
    let subject = Subject::new(kind, side);
    let exact = LIGHTS.map(|light| subject.exact(light, coherent));
    let compared = compared();
    for ((number, light), tolerance) in LIGHTS.into_iter().enumerate().zip([1e-1, 2e-2, 5e-3]) {
        let setting = format!("--coherence {coherence} --windows 1x1 --theory stam --tolerance {tolerance}");
        let map = subject.map(light, &setting, SIDE);
        let found: Vec<DVec3> = compared.iter().map(|(i, _)| map[*i]).collect();
        let mirror = -direction(light[0], light[1]).truncate();
        let aside: Vec<bool> =
            compared.iter().map(|(_, view)| (view.truncate() - mirror).length() > MIRROR).collect();
        let whole = deviation(&found, &exact[number], |_| true);
        let colours = deviation(&found, &exact[number], |i| aside[i]);
        eprintln!("{} {coherence} {light:?} at {tolerance:e}: {whole:.2e}, aside {colours:.2e}", kind.name());
        assert!(whole <= tolerance, "under {light:?} at {tolerance}: {whole:e}");
        assert!(colours <= tolerance, "under {light:?} at {tolerance}, aside: {colours:e}");
        let other = deviation(&found, &exact[(number + 1) % LIGHTS.len()], |_| true);
        assert!(other > 0.3, "a map under another light agrees: {other:e}");
    }
}

const WINDOW: Coherence = Coherence::Gaussian { length: 12.0 };

#[test]
fn maps_of_an_elaphe_skin_agree_through_a_window() {
    agrees(SurfaceKind::Elaphe, 8.0, "gaussian:12um", WINDOW);
}

#[test]
fn maps_of_an_elaphe_skin_agree_through_repeats() {
    agrees(SurfaceKind::Elaphe, 6.0, "repeats:2x3", Coherence::Repeats([2, 3]));
}

#[test]
fn maps_of_a_blaze_agree_through_a_window() {
    agrees(SurfaceKind::Blaze, 7.5, "gaussian:12um", WINDOW);
}

#[test]
fn maps_of_a_blaze_agree_through_repeats() {
    agrees(SurfaceKind::Blaze, 5.0, "repeats:3x3", Coherence::Repeats([3, 3]));
}

#[test]
fn maps_of_a_sinusoid_agree_through_a_window() {
    agrees(SurfaceKind::Sinusoid, 6.0, "gaussian:12um", WINDOW);
}

#[test]
fn maps_of_a_sinusoid_agree_through_repeats() {
    agrees(SurfaceKind::Sinusoid, 4.0, "repeats:3x2", Coherence::Repeats([3, 2]));
}

/// J_m(x) = ∫ cos(mτ − x sin τ) dτ/2π, by the trapezoid rule, which is exact for a periodic function this smooth.
fn bessel(m: i32, x: f64) -> f64 {
    let term = |i: i32| {
        let t = f64::from(i) * TAU / 64.0;
        (f64::from(m) * t - x * t.sin()).cos()
    };
    (0..64).map(term).sum::<f64>() / 64.0
}

/// Reflectance of a dielectric of index 1.5 by Snell's law and Fresnel's coefficients, unpolarised.
pub fn fresnel(cosine: f64) -> f64 {
    let inside = (1.0 - (1.0 - cosine * cosine) / 2.25f64).sqrt();
    let s = (cosine - 1.5 * inside) / (cosine + 1.5 * inside);
    let p = (1.5 * cosine - inside) / (1.5 * cosine + inside);
    (s * s + p * p) / 2.0
}

/// ∫ f cos θ_r dω_r of order `m` of a sinusoid of period `d` and amplitude `a` \[µm\], light from `theta` in its plane:
/// R G/w² J_m²(k|w|a) at sin θ_r = mλ/d − sin θ_i along x.
fn of_order(m: i32, theta: f64, wavelength: f64, [d, a]: [f64; 2]) -> f64 {
    let light = direction(theta, 0.0);
    let x = f64::from(m) * wavelength / d - light.x;
    let pair = Pair::new(light, DVec3::new(x, 0.0, (1.0 - x * x).sqrt()));
    let w = pair.uvw().z.abs();
    let reflectance = fresnel(pair.cos_half_angle());
    let g = pair.geometric_factor_times_cos_light() / light.z;
    reflectance * g / (w * w) * bessel(m, TAU / wavelength * w * a).powi(2)
}

/// Its luminance, of light of luminance 1.
fn luminance_of_order(m: i32, theta: f64, grating: [f64; 2]) -> f64 {
    let (mut sum, mut whole) = (0.0, 0.0);
    for i in 0..=400 {
        let wavelength = 0.38 + 0.001 * f64::from(i);
        let seen = Illuminant::D65.power(1e3 * wavelength) * observer(1e3 * wavelength).y;
        whole += seen;
        sum += seen * of_order(m, theta, wavelength, grating);
    }
    sum / whole
}

#[test]
fn the_energy_of_each_order_of_a_colour_map_is_that_of_the_closed_forms_by_every_method_and_of_the_mean() {
    // Pixels a quarter of an order's width.
    const SIDE: usize = 160;
    let subject = Subject::new(SurfaceKind::Sinusoid, 6.0);
    // Its samples miss the crests by 0.3 %, and J_1 is steep here.
    let amplitude = 0.1;
    let luminance = DVec3::new(0.212_639, 0.715_169, 0.072_192);
    let pixel = (2.0 / SIDE as f64).powi(2);
    for theta in [0.0, 20.0] {
        let light = direction(theta, 0.0);
        // What the edges of repeats throw beyond the ends of an order, 1/(π² a f), is some hundredths.
        for (coherence, allowed) in [("gaussian:10um", 1e-2), ("repeats:2x2", 5e-2)] {
            // Repeats are one finite grating, of which there is no mean.
            let ways = ["--windows 1x1", "--method spectral", "--method table"];
            for method in if coherence.starts_with("gaussian") { &ways[..] } else { &ways[..1] } {
                let setting = format!("--coherence {coherence} {method} --theory stam --tolerance 5e-3");
                let map = subject.map([theta, 0.0], &setting, SIDE);
                for m in -1..=1 {
                    // Order 0 is faint here, and what edges throw into its place from the others outweighs it.
                    if m == 0 && coherence.starts_with("repeats") {
                        continue;
                    }
                    // Orders of 380 to 780 nm end before the next begin: at 0.19 to 0.39 times their number.
                    let ends = if m == 0 { (-0.12, 0.12) } else { (0.12, 0.385) };
                    let sign = if m < 0 { -1.0 } else { 1.0 };
                    let within = |view: DVec3| (ends.0..ends.1).contains(&(sign * (view.x + light.x)));
                    let kept = views(SIDE).zip(&map).filter(|((_, view), _)| within(*view));
                    let found = kept.map(|(_, f)| f.dot(luminance)).sum::<f64>() * pixel;
                    let closed = |amplitude| luminance_of_order(m, theta, [2.0, amplitude]);
                    let off = |amplitude| (found - closed(amplitude)).abs() / closed(amplitude).max(0.004);
                    eprintln!(
                        "{theta} {coherence} {method} order {m}: {found:.5} for {:.5}, off {:.1e}; {:.1e} a tenth higher",
                        closed(amplitude),
                        off(amplitude),
                        off(1.1 * amplitude)
                    );
                    assert!(off(amplitude) < allowed, "{coherence} {method} order {m}: {found}");
                    // One order by light from 20° hardly changes with the amplitude: less than what edges throw.
                    let telling = m != 0 && coherence.starts_with("gaussian");
                    assert!(!telling || off(1.1 * amplitude) > 2.0 * allowed, "any amplitude will do");
                }
            }
        }
    }
}
