//! Colour tables against the f64 mean.

use super::basis::MOST_COMPONENTS;
use super::projection::Projection;
use super::sums::{DirectionWavelengths, Scratch, Sums};
use super::*;
use crate::brdf::mean::MeanBrdf;
use crate::brdf::tabulated::{SummedOrders, TabulatedMean};
use crate::budget::MeanBudget;
use crate::filter::Covariance;
use crate::optics::color::xyz_to_linear_srgb;
use crate::optics::geometry::{Pair, direction};
use crate::optics::material::Material;
use crate::optics::quadrature::{SPAN, density_table};
use crate::optics::reflectance::Reflectance;
use crate::optics::spectrum::{Illuminant, LONGEST};
use crate::random::Random;
use crate::spectra::power::{Beyond, OrderReader, OrderSeries, PowerSettings, Square};
use crate::surface::HeightField;
use crate::surface::synth::{self, Spec, SurfaceKind};
use crate::task::Task;
use glam::{DVec2, DVec3, Vec3, Vec4};
use std::f64::consts::PI;
use std::sync::Arc;

const IOR: f64 = 1.5;

fn series(field: &HeightField, sigma: f64, tolerance: f64) -> OrderSeries {
    OrderSeries::new(field, &PowerSettings::new(sigma, Beyond::Copies, tolerance), &Task::silent()).unwrap()
}

fn table(series: &OrderSeries, tolerance: f64, finest: f64) -> ColorTable {
    let settings = TableSettings { finest, ..TableSettings::new(Illuminant::D65, tolerance) };
    bake(series, &settings, &Task::silent()).unwrap()
}

fn pairs(count: usize, seed: u64) -> Vec<Pair> {
    let mut random = Random::new(seed);
    (0..count)
        .map(|_| {
            let light = direction(70.0 * random.share(), 360.0 * random.share());
            let mut view = direction(75.0 * random.share(), 360.0 * random.share());
            if random.share() < 0.5 {
                // Near the specular direction, which has most of the power.
                let near = DVec3::new(random.share() - 0.5, random.share() - 0.5, 0.0) * 0.4;
                view = (DVec3::new(-light.x, -light.y, light.z) + near).normalize();
                view.z = view.z.abs();
            }
            Pair::new(light, view)
        })
        .collect()
}

/// Returns the relative L2 error and the RMS of the relative errors of single colours.
fn errors(colours: &[DVec3], exact: &[DVec3]) -> (f64, f64) {
    let (mut error, mut energy, mut each) = (0.0, 0.0, 0.0);
    for (a, b) in colours.iter().zip(exact) {
        error += (*a - *b).length_squared();
        energy += b.length_squared();
        each += (*a - *b).length_squared() / b.length_squared().max(1e-30);
    }
    ((error / energy).sqrt(), (each / exact.len() as f64).sqrt())
}

/// Returns settings whose basis may err by `basis`.
fn with_basis(basis: f64) -> TableSettings {
    let settings = TableSettings::new(Illuminant::D65, 2e-2);
    TableSettings { budget: MeanBudget { basis, ..settings.budget }, ..settings }
}

#[test]
fn a_flat_surface_takes_one_texel_and_scatters_nothing() {
    let field = synth::generate(&Spec { patch: Some([13.0, 11.0]), ..Spec::new(SurfaceKind::Flat) }).unwrap();
    let series = series(&field, 3.0, 2e-2);
    assert!(series.specular_power(0.0) > 0.9, "what it reflects is the specular order");
    let table = table(&series, 2e-2, 1e-2);
    assert_eq!(table.header.basis.layers(), 1);
    assert!(table.mips.iter().flatten().all(|texel| texel.to_f32() == 0.0));
}

#[test]
fn the_bands_of_the_specular_order_hold_the_lobe_of_a_mirror() {
    /// Number of wavelengths over the visible range, ends included.
    const COUNT: usize = 401;
    let field = synth::generate(&Spec { patch: Some([13.0, 11.0]), ..Spec::new(SurfaceKind::Flat) }).unwrap();
    let sigma = 3.0;
    let specular = table(&series(&field, sigma, 2e-2), 2e-2, 1e-2).header.specular;
    let lobe = |r: f64, variance: f64| (-0.5 * r * r / variance).exp() / (2.0 * PI * variance);
    let step = SPAN / (COUNT - 1) as f64;
    let density = density_table(&Illuminant::D65, COUNT);
    let exact = |r: f64| -> DVec3 {
        let node = |(i, xyz): (usize, &DVec3)| {
            let q = 1.0 / LONGEST + i as f64 * step;
            let end = if i == 0 || i == COUNT - 1 { 0.5 } else { 1.0 };
            // Lobe of the window's power, of standard deviation 1/(√2·2πσ) in frequency.
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
    // With 16 bands it is 1.2e-3, and pixels beside the specular direction err by 0.028.
    assert!(worst < 1.5e-4 && peak.min_element() > 1.0, "{worst}");
}

#[test]
fn sums_of_bands_serve_footprints_that_are_wider_than_the_lobe() {
    let field = synth::generate(&Spec { patch: Some([13.0, 11.0]), ..Spec::new(SurfaceKind::Flat) }).unwrap();
    let specular = table(&series(&field, 3.0, 2e-2), 2e-2, 1e-2).header.specular;
    // Density of a lobe of variance v, averaged over a round footprint of this variance, as the shader adds it.
    let density = |r: f64, v: f64| (-0.5 * r * r / v).exp() / (2.0 * PI * v);
    let sum = |together: usize, r: f64, footprint: f64| -> DVec3 {
        let lobe = |(variance, weights): (f64, Vec<[f32; 3]>)| {
            DVec3::from_array(weights[SPECULAR_SAMPLES - 1].map(f64::from)) * density(r, variance + footprint)
        };
        specular.groups(together).map(lobe).sum()
    };
    let widest = specular.variances[0];
    for together in [4, 16, 64] {
        let footprint = (together as f64 - 1.0) * widest;
        let reach = 4.0 * (footprint + widest).sqrt();
        let peak = sum(1, 0.0, footprint);
        let radii = (0..100).map(|i| reach * f64::from(i) / 100.0);
        let off =
            radii.map(|r| ((sum(together, r, footprint) - sum(1, r, footprint)) / peak).abs().max_element());
        let worst = off.fold(0.0, f64::max);
        eprintln!("{together} together: {worst:.1e} of the peak");
        assert!(worst < 2e-3, "{together}: {worst}");
    }
    assert_eq!(specular.groups(4).count(), specular.variances.len() / 4);
}

#[test]
fn colours_of_metals_keep_the_tolerance() {
    let field = synth::generate(&Spec { patch: Some([12.0; 2]), ..Spec::new(SurfaceKind::Elaphe) }).unwrap();
    let (sigma, tolerance) = (3.0, 2e-2);
    let series = series(&field, sigma, tolerance);
    for name in ["gold", "copper", "silver", "glass"] {
        let reflectance = Reflectance::of_material(Material::from_name_or_file(name).unwrap(), None);
        let settings = TableSettings {
            reflectance: Some(reflectance.clone()),
            ..TableSettings::new(Illuminant::D65, tolerance)
        };
        let table = bake(&series, &settings, &Task::silent()).unwrap();
        let mean = MeanBrdf {
            field: field.clone(),
            sigma,
            beyond: Beyond::Copies,
            reflectance: reflectance.clone(),
        };
        let exact = TabulatedMean::new(mean, 0.38, &Task::silent()).unwrap();
        let reader = TableReader::new(Arc::new(table.clone()));
        let pairs = pairs(300, 3);
        let asked: Vec<_> = pairs.iter().map(|pair| (*pair, Covariance::default())).collect();
        let exact = exact.xyz(&Illuminant::D65, &asked, SummedOrders::All, &Task::silent()).unwrap();
        let colours: Vec<DVec3> =
            pairs.iter().map(|pair| reader.xyz(pair, &reflectance, &Covariance::default())).collect();
        let (l2, each) = errors(&colours, &exact);
        eprintln!("{name}: L2 {l2:.1e}, each {each:.1e}");
        assert!(l2 <= tolerance, "{name}: {l2}");
    }
}

#[test]
fn a_table_gives_the_colours_of_the_mean_over_every_footprint() {
    let field = synth::generate(&Spec { patch: Some([12.0; 2]), ..Spec::new(SurfaceKind::Elaphe) }).unwrap();
    let (sigma, tolerance) = (3.0, 2e-2);
    let mean = MeanBrdf { field: field.clone(), sigma, beyond: Beyond::Copies, reflectance: IOR.into() };
    let exact = TabulatedMean::new(mean, 0.38, &Task::silent()).unwrap();
    let table = table(&series(&field, sigma, tolerance), tolerance, 0.0);
    let reader = TableReader::new(Arc::new(table.clone()));
    for footprint in [
        Covariance::default(),
        Covariance { uu: 1e-4, uv: 0.0, vv: 1e-4 },
        Covariance { uu: 4e-4, uv: 3e-4, vv: 3e-4 },
        Covariance { uu: 1e-3, uv: -2e-3, vv: 5e-3 },
    ] {
        let pairs = pairs(300, 3);
        let asked: Vec<_> = pairs.iter().map(|pair| (*pair, footprint)).collect();
        let exact = exact.xyz(&Illuminant::D65, &asked, SummedOrders::All, &Task::silent()).unwrap();
        let colours: Vec<DVec3> =
            pairs.iter().map(|pair| reader.xyz(pair, &IOR.into(), &footprint)).collect();
        let (l2, each) = errors(&colours, &exact);
        eprintln!("{footprint:?}: L2 {l2:.1e}, each {each:.1e}");
        assert!(l2 <= tolerance, "{footprint:?}: {l2}");
    }
}

/// Returns the relative L2 error of the colours of `projection` at places and |w| that were not used to make it, and the RMS of the
/// relative errors of single colours, weighted by |w|.
fn errors_elsewhere(
    projection: &Projection,
    reader: &OrderReader<'_>,
    spectrum: &DirectionWavelengths,
) -> (f64, f64) {
    let basis = &projection.basis;
    let at_nodes = Sums::new(reader, spectrum, basis.pieces);
    let w: Vec<f64> = (0..30).map(|i| 0.03 + 0.065 * f64::from(i)).collect();
    let exact = Sums::at(reader, spectrum, w.clone());
    let (mut scratch, mut random) = (Scratch::default(), Random::new(7));
    let (mut error, mut energy, mut each, mut weights) = (0.0, 0.0, 0.0, 0.0);
    for _ in 0..300 {
        let place = DVec2::from_angle(2.0 * PI * random.share()) * 1.9 * random.share();
        let mut numbers = Vec::new();
        let mut values = at_nodes.at_nodes(&Square::point(place), &mut scratch);
        projection.project(values.next().unwrap(), &mut numbers);
        for (w, exact) in w.iter().zip(exact.colours(place, &mut scratch)) {
            if w.hypot(place.length()) > 2.0 {
                break;
            }
            let (piece, t) = basis.piece(*w);
            let numbers = &numbers[piece * basis.components..][..basis.components];
            let found = ColorBasis::colour(basis.of_piece(piece), numbers, t).as_dvec3();
            let [found, exact] = [found, Vec3::from(exact).as_dvec3()].map(xyz_to_linear_srgb);
            let off = (found - exact).length_squared();
            error += off;
            energy += exact.length_squared();
            each += w * off / exact.length_squared();
            weights += w;
        }
    }
    ((error / energy).sqrt(), (each / weights).sqrt())
}

#[test]
fn a_basis_errs_by_what_it_says_and_a_larger_one_by_less() {
    let field = synth::generate(&Spec { patch: Some([12.0; 2]), ..Spec::new(SurfaceKind::Elaphe) }).unwrap();
    let series = series(&field, 3.0, 2e-2);
    let reader = OrderReader::new(&series);
    let mut components = Vec::new();
    for error in [0.3, 5e-2, 1e-2] {
        let settings = with_basis(error);
        let spectrum = DirectionWavelengths::new(&series, &settings);
        let projection = Projection::choose(&reader, &spectrum, &settings).unwrap();
        let (l2, each) = errors_elsewhere(&projection, &reader, &spectrum);
        let ColorBasis { pieces, components: own_components, .. } = projection.basis;
        eprintln!(
            "{error}: {pieces} pieces of {own_components}, {:.1e} expected, L2 {l2:.1e}, each {each:.1e}",
            projection.error
        );
        assert!(projection.error <= error && each < 1.5 * error && l2 < 1.5 * error, "{each}, {l2}");
        assert!(each > 0.1 * projection.error, "it says too much: {each}");
        components.push(own_components);
    }
    assert!(components[0] < components[2], "a larger tolerance reads less: {components:?}");
}

#[test]
fn all_components_hold_any_three_cubics() {
    let field = synth::generate(&Spec { patch: Some([12.0; 2]), ..Spec::new(SurfaceKind::Elaphe) }).unwrap();
    let series = series(&field, 3.0, 2e-2);
    let reader = OrderReader::new(&series);
    let settings = with_basis(4e-3);
    let spectrum = DirectionWavelengths::new(&series, &settings);
    let Projection { basis, .. } = &Projection::choose(&reader, &spectrum, &settings).unwrap();
    assert_eq!(basis.components, MOST_COMPONENTS);
    let projection = Projection::choose(&reader, &spectrum, &settings).unwrap();
    // Colours that no surface has: the values of cubics in t at the Chebyshev nodes, different ones for each channel and piece.
    let cubic = |channel: usize, piece: usize, t: f64| {
        let k = (1 + channel + 3 * piece) as f64;
        (0.3 * k).cos() + (1.7 * k).sin() * t - (2.9 * k).cos() * t * t + (0.7 * k).sin() * t * t * t
    };
    let node = |j: usize| -(PI * (j as f64 + 0.5) / 4.0).cos();
    let values = |channel: usize, piece: usize| {
        Vec4::from_array(std::array::from_fn(|j| cubic(channel, piece, node(j)) as f32))
    };
    let of_channel = |channel| (0..basis.pieces).map(move |piece| values(channel, piece));
    let mut numbers = Vec::new();
    projection.project(&(0..3).flat_map(of_channel).collect::<Vec<_>>(), &mut numbers);
    for i in 0..40 {
        let (piece, t) = basis.piece(0.05 * f64::from(i));
        let numbers = &numbers[piece * basis.components..][..basis.components];
        let found = ColorBasis::colour(basis.of_piece(piece), numbers, t);
        let exact = Vec3::from_array(std::array::from_fn(|channel| cubic(channel, piece, t) as f32));
        assert!((found - exact).length() < 2e-3 * exact.length(), "piece {piece}, t = {t}: {found} {exact}");
    }
}

#[test]
fn light_of_one_wavelength_takes_one_texel() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("sodium.csv");
    std::fs::write(&file, "588,0\n589,1\n590,0\n").unwrap();
    let field = synth::generate(&Spec { patch: Some([12.0; 2]), ..Spec::new(SurfaceKind::Elaphe) }).unwrap();
    let series = series(&field, 3.0, 2e-2);
    let table = |illuminant| bake(&series, &TableSettings::new(illuminant, 2e-2), &Task::silent()).unwrap();
    let sodium = table(Illuminant::from_name_or_file(&file).unwrap()).header.basis;
    assert_eq!(sodium.texels(), 1, "{} pieces", sodium.pieces);
    assert!(table(Illuminant::D65).header.basis.texels() > 1);
}
