//! Power spectra and colour tables against the f64 mean.

use super::*;
use crate::brdf::mean::{MeanBrdf, SummedOrders, TabulatedMean};
use crate::optics::footprint::Covariance;
use crate::optics::geometry::{Pair, direction};
use crate::optics::quadrature::{SPAN, density_table};
use crate::optics::spectrum::{Illuminant, LONGEST};
use crate::random::Random;
use crate::spectra::power::{Beyond, PowerSettings, PowerSpectra, power_spectra};
use crate::surface::HeightField;
use crate::surface::synth::{self, Spec, SurfaceKind};
use glam::DVec3;
use std::f64::consts::PI;

const IOR: f64 = 1.5;

fn spectra(field: &HeightField, sigma: f64, tolerance: f64, finest: f64) -> PowerSpectra {
    let settings =
        PowerSettings { least_footprint: finest, ..PowerSettings::new(sigma, Beyond::Copies, tolerance) };
    power_spectra(field, &settings, &|_, _| Ok(())).unwrap()
}

fn table(spectra: &PowerSpectra, tolerance: f64, finest: f64) -> ColorTable {
    let settings = TableSettings { finest, ..TableSettings::new(Illuminant::D65, tolerance) };
    bake(spectra, &settings, &|_, _| Ok(())).unwrap()
}

fn pairs(count: usize, seed: u64) -> Vec<Pair> {
    let mut random = Random::new(seed);
    (0..count)
        .map(|_| {
            let light = direction(70.0 * random.share(), 360.0 * random.share());
            let mut view = direction(75.0 * random.share(), 360.0 * random.share());
            if random.share() < 0.5 {
                // Near the specular direction, where most of the power is.
                let near = DVec3::new(random.share() - 0.5, random.share() - 0.5, 0.0) * 0.4;
                view = (DVec3::new(-light.x, -light.y, light.z) + near).normalize();
                view.z = view.z.abs();
            }
            Pair::new(light, view)
        })
        .collect()
}

/// Relative L2 error and the RMS of each colour's own.
fn errors(colours: &[DVec3], exact: &[DVec3]) -> (f64, f64) {
    let (mut error, mut energy, mut own) = (0.0, 0.0, 0.0);
    for (a, b) in colours.iter().zip(exact) {
        error += (*a - *b).length_squared();
        energy += b.length_squared();
        own += (*a - *b).length_squared() / b.length_squared().max(1e-30);
    }
    ((error / energy).sqrt(), (own / exact.len() as f64).sqrt())
}

#[test]
fn a_flat_surface_takes_one_cubic_and_scatters_nothing() {
    let field = synth::generate(&Spec { patch: Some([13.0, 11.0]), ..Spec::new(SurfaceKind::Flat) }).unwrap();
    let spectra = spectra(&field, 3.0, 2e-2, 1e-3);
    assert!(spectra.header.specular[0] > 0.9, "what it reflects is the specular order");
    let table = table(&spectra, 2e-2, 1e-2);
    assert_eq!(table.header.pieces, 1);
    assert!(table.levels.iter().flatten().all(|texel| texel.to_f32() == 0.0));
}

#[test]
fn the_bands_of_the_specular_order_hold_the_lobe_of_a_mirror() {
    /// Of the visible range, ends included.
    const COUNT: usize = 401;
    let field = synth::generate(&Spec { patch: Some([13.0, 11.0]), ..Spec::new(SurfaceKind::Flat) }).unwrap();
    let sigma = 3.0;
    let specular = table(&spectra(&field, sigma, 2e-2, 1e-3), 2e-2, 1e-2).header.specular;
    let lobe = |r: f64, variance: f64| (-0.5 * r * r / variance).exp() / (2.0 * PI * variance);
    let step = SPAN / (COUNT - 1) as f64;
    let density = density_table(&Illuminant::D65, COUNT);
    let exact = |r: f64| -> DVec3 {
        let node = |(i, xyz): (usize, &DVec3)| {
            let q = 1.0 / LONGEST + i as f64 * step;
            let end = if i == 0 || i == COUNT - 1 { 0.5 } else { 1.0 };
            // Of the window's power, of standard deviation 1/(√2·2πσ) in frequency.
            *xyz * (step * end * lobe(r, (q * 2.0 * PI * sigma).powi(-2) / 2.0))
        };
        density.iter().enumerate().map(node).sum()
    };
    let of_bands = |r: f64| -> DVec3 {
        let band = |(variance, weights): (&f64, &Vec<[f32; 3]>)| {
            DVec3::from_array(weights[SPECULAR_SAMPLES - 1].map(f64::from)) * lobe(r, *variance)
        };
        specular.variances.iter().zip(&specular.weights).map(band).sum()
    };
    let peak = exact(0.0);
    let radii = (0..200).map(|i| 0.15 * f64::from(i) / 200.0);
    let worst = radii.map(|r| ((of_bands(r) - exact(r)).abs() / peak).max_element()).fold(0.0, f64::max);
    eprintln!("the lobe of a mirror differs by {worst:.1e} of its peak");
    // With 8 bands it is 5e-3, which tables at 3e-3 miss.
    assert!(worst < 1.5e-3 && peak.min_element() > 1.0, "{worst}");
}

#[test]
fn a_table_gives_the_colours_of_the_mean_over_every_footprint() {
    let field = synth::generate(&Spec { patch: Some([12.0; 2]), ..Spec::new(SurfaceKind::Elaphe) }).unwrap();
    let (sigma, tolerance) = (3.0, 2e-2);
    let mean = MeanBrdf { field: &field, sigma, beyond: Beyond::Copies, reflectance: IOR.into() };
    let exact = TabulatedMean::new(mean, 0.38, &|_, _| Ok(())).unwrap();
    let spectra = spectra(&field, sigma, tolerance, 0.0);
    let table = table(&spectra, tolerance, 0.0);
    let reader = TableReader::new(&table);
    for around in [
        Covariance::default(),
        Covariance { uu: 1e-4, uv: 0.0, vv: 1e-4 },
        Covariance { uu: 4e-4, uv: 3e-4, vv: 3e-4 },
        Covariance { uu: 1e-3, uv: -2e-3, vv: 5e-3 },
    ] {
        let pairs = pairs(300, 3);
        let asked: Vec<_> = pairs.iter().map(|pair| (*pair, around)).collect();
        let exact = exact.xyz(&Illuminant::D65, &asked, SummedOrders::All, &|_, _| Ok(())).unwrap();
        let colours: Vec<DVec3> = pairs.iter().map(|pair| reader.xyz(pair, IOR, &around)).collect();
        let (l2, own) = errors(&colours, &exact);
        eprintln!("{around:?}: L2 {l2:.1e}, own {own:.1e}");
        assert!(l2 <= tolerance, "{around:?}: {l2}");
    }
}
