//! Energy: under a white sky no surface is brighter than a flat one of its material, and a white pigment below it not
//! brighter than white.

use diffract::internals::brdf::albedo::{Decimation, DirectionalAlbedo};
use diffract::internals::brdf::energy_map::EnergyMap;
use diffract::internals::optics::coherence::Beyond;
use diffract::internals::optics::color::xyz_to_linear_srgb;
use diffract::internals::optics::colour_excess::ColourWeights;
use diffract::internals::optics::geometry::{Pair, direction};
use diffract::internals::optics::material::Material;
use diffract::internals::optics::quadrature::Wavelengths;
use diffract::internals::optics::reflectance::Reflectance;
use diffract::internals::optics::spectrum::Illuminant;
use diffract::internals::optics::theory::Theory;
use diffract::internals::spectra::power::{OrderSeries, PowerSettings};
use diffract::internals::surface::synth::{Spec, SurfaceKind, generate};
use diffract::internals::task::Task;
use glam::DVec3;

const ANGLES: [f64; 8] = [0.0, 30.0, 45.0, 60.0, 70.0, 80.0, 85.0, 89.0];

/// Returns silver, which reflects most, and for surfaces of short periods or large slopes gold and a refractive index, too.
fn materials(kind: SurfaceKind) -> Vec<Reflectance> {
    let [silver, gold] = ["silver", "gold"]
        .map(|name| Reflectance::of_material(Material::from_name_or_file(name).unwrap(), None));
    match kind {
        SurfaceKind::Blaze | SurfaceKind::Bumps | SurfaceKind::Xenopeltis => {
            vec![silver, gold, Reflectance::default()]
        }
        _ => vec![silver],
    }
}

/// Returns the series of the orders of a built-in surface.
fn series(kind: SurfaceKind) -> OrderSeries {
    let field = generate(&Spec::new(kind)).unwrap();
    let settings = PowerSettings::new(65.0 / 4.0, Beyond::Copies, 1e-2);
    OrderSeries::new(&field, &settings, &Task::silent()).unwrap()
}

/// Returns linear sRGB of the light that is sent toward `view` from a white sky, where each direction is divided by
/// `limit`, and that of a flat surface.
fn furnace(albedo: &DirectionalAlbedo, view: DVec3, limit: &dyn Fn(DVec3) -> f64) -> [DVec3; 2] {
    let nodes = Wavelengths::catmull_rom(&Illuminant::D65, ColourWeights::WAVENUMBERS);
    let [mut sent, mut flat, mut white] = [DVec3::ZERO; 3];
    for (q, weight) in nodes.wavenumbers.iter().zip(&nodes.weights) {
        // By reciprocity the light toward `view` is that sent from it.
        sent += *weight * albedo.sent(view, 1.0 / q, |other| 1.0 / limit(other));
        flat += *weight * albedo.allowed(view, 1.0 / q);
        white += *weight;
    }
    let white = xyz_to_linear_srgb(white);
    [sent, flat].map(|xyz| xyz_to_linear_srgb(xyz) / white)
}

#[test]
fn no_surface_reflects_more_of_a_white_sky_than_a_flat_one() {
    let mut limited = 0;
    for kind in SurfaceKind::ALL {
        let series = series(kind);
        for reflectance in materials(kind) {
            let albedo = |r: &Reflectance| DirectionalAlbedo::new(&series, r, Decimation::Coarse);
            let [small, stam] = [albedo(&reflectance), albedo(&reflectance.clone().by(Theory::Stam))];
            let map = EnergyMap::measured(&small, &Illuminant::D65);
            // Kinks where orders appear are narrower than the steps of the map.
            assert!(map.header().error < 3e-2, "{}: {}", kind.name(), map.header().error);
            let mut row = String::new();
            for (theta, phi) in ANGLES.into_iter().flat_map(|theta| [(theta, 10.0), (theta, 115.0)]) {
                let view = direction(theta, phi);
                let [before, _] = furnace(&stam, view, &|_| 1.0);
                let [free, flat] = furnace(&small, view, &|_| 1.0);
                let [within, _] = furnace(&small, view, &|other| map.limit(&Pair::new(view, other)));
                // A flat surface of gold has more red than the sky: its colour is outside of the gamut.
                let most = flat.max(DVec3::ONE) + 0.005;
                assert!(
                    within.cmple(most).all(),
                    "{} of {reflectance} at {theta}: {within} of {flat}",
                    kind.name()
                );
                limited += usize::from(free.max_element() > within.max_element() + 1e-3);
                if phi == 10.0 {
                    let [a, b, c] = [before, free, within].map(DVec3::max_element);
                    row += &format!(" {a:.3} → {b:.3} → {c:.3} |");
                }
            }
            eprintln!("| {} | {reflectance} |{row} map {:.1e}", kind.name(), map.header().error);
        }
    }
    assert!(limited > 5, "no surface was limited, so that the test shows nothing");
}

#[test]
fn a_white_pigment_and_the_surface_above_it_reflect_at_most_all_light() {
    let series = series(SurfaceKind::Elaphe);
    let albedo = DirectionalAlbedo::new(&series, &Reflectance::default(), Decimation::Coarse);
    let map = EnergyMap::new(&albedo, &Illuminant::D65);
    for theta in ANGLES {
        let view = direction(theta, 30.0);
        let [surface, _] = furnace(&albedo, view, &|other| map.limit(&Pair::new(view, other)));
        // ∫ cos θ/π over directions, in rings of equal weight.
        let (rings, turns) = (200, 64);
        let mut pigment = 0.0;
        for (ring, turn) in (0..rings).flat_map(|ring| (0..turns).map(move |turn| (ring, turn))) {
            let sine = ((f64::from(ring) + 0.5) / f64::from(rings)).sqrt();
            let light = direction(sine.asin().to_degrees(), 360.0 * f64::from(turn) / f64::from(turns));
            pigment += map.pigment(&Pair::new(light, view)) / f64::from(rings * turns);
        }
        let all = surface.max_element() + pigment;
        eprintln!("{theta}: {:.4} + {pigment:.4} = {all:.4}", surface.max_element());
        assert!(all <= 1.005 && all > 0.98, "{theta}: {all}");
    }
}
