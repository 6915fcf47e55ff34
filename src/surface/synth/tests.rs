use super::*;
use crate::surface::statistics::line_periods;
use std::f64::consts::{PI, TAU};

fn made(kind: SurfaceKind) -> HeightField {
    generate(&Spec::new(kind)).unwrap()
}

/// Returns the largest step between neighbours, inside the patch and over its seams, along x and y.
fn steps(field: &HeightField) -> [[f64; 2]; 2] {
    let (columns, rows) = (field.columns(), field.rows());
    let mut largest = [[0.0_f64; 2]; 2];
    for row in 0..rows {
        for column in 0..columns {
            let h = field.row(row)[column];
            let right = field.row(row)[(column + 1) % columns];
            let below = field.row((row + 1) % rows)[column];
            let seam_x = usize::from(column + 1 == columns);
            let seam_y = usize::from(row + 1 == rows);
            largest[0][seam_x] = largest[0][seam_x].max((right - h).abs());
            largest[1][seam_y] = largest[1][seam_y].max((below - h).abs());
        }
    }
    largest
}

#[test]
fn every_name_means_its_kind() {
    for kind in SurfaceKind::ALL {
        assert_eq!(SurfaceKind::from_name(kind.name()), Some(kind));
    }
    assert_eq!(SurfaceKind::from_name("snake"), None);
}

#[test]
fn every_surface_meets_itself_at_its_edges() {
    for kind in SurfaceKind::ALL {
        for [inside, seam] in steps(&made(kind)) {
            assert!(
                seam <= inside * (1.0 + 1e-9) + 1e-15,
                "{}: {seam} over the seam, {inside} inside",
                kind.name()
            );
        }
    }
}

#[test]
fn the_seam_check_sees_a_patch_that_does_not_close() {
    let whole = made(SurfaceKind::Sinusoid);
    let columns = whole.columns() - 7;
    let heights = (0..whole.rows()).flat_map(|row| whole.row(row)[..columns].to_vec()).collect();
    let cut = HeightField::new(columns, whole.rows(), whole.pixel_size(), heights).unwrap();
    let [[inside, seam], _] = steps(&cut);
    assert!(seam > 1.5 * inside);
}

#[test]
fn every_surface_has_its_published_height_and_spacing() {
    for (kind, height) in [
        (SurfaceKind::Flat, 0.0),
        (SurfaceKind::Sinusoid, 0.2),
        (SurfaceKind::Blaze, 0.246_23 * 26.0 / 27.0), // 27 samples a period
        (SurfaceKind::Bumps, 0.15),
        (SurfaceKind::Elaphe, 0.43),
        (SurfaceKind::Xenopeltis, 0.82),
        (SurfaceKind::Cd, 0.12),
        (SurfaceKind::Dvd, 0.105),
        (SurfaceKind::Brushed, 0.5),
        (SurfaceKind::Tulip, 0.5),
    ] {
        let field = made(kind);
        let (low, high) = field.range();
        // Samples miss the very top of a bump or a crest of the sine by little.
        assert!(((high - low) - height).abs() <= 0.15 * height + 1e-15, "{}: {}", kind.name(), high - low);
        assert!(field.pixel_size().iter().all(|d| *d <= 0.095), "{}", kind.name());
    }
}

#[test]
fn the_design_periods_are_found_again() {
    for (kind, expected, within) in [
        (SurfaceKind::Sinusoid, [Some(2.0), None], 1e-6),
        (SurfaceKind::Blaze, [Some(2.5), None], 1e-6),
        (SurfaceKind::Bumps, [Some(0.5), Some(1.0)], 1e-6),
        (SurfaceKind::Elaphe, [Some(1.14), Some(3.1)], 0.02),
        (SurfaceKind::Xenopeltis, [Some(1.55), Some(6.5)], 0.02),
    ] {
        let found = line_periods(&made(kind));
        for axis in 0..2 {
            let near = match (found[axis], expected[axis]) {
                (Some(a), Some(b)) => (a / b - 1.0).abs() < within,
                (a, b) => a.is_none() && b.is_none(),
            };
            assert!(near, "{}: {found:?}", kind.name());
        }
    }
}

#[test]
fn tracks_and_striations_repeat_along_x() {
    // Tracks repeat exactly, but the pits on them differ: that moves the centre of a band of frequencies a little. Along y,
    // pits have lengths of few values, which the search may take for a period or not.
    for (kind, expected, within) in
        [(SurfaceKind::Cd, 1.6, 0.02), (SurfaceKind::Dvd, 0.74, 0.02), (SurfaceKind::Tulip, 1.2, 0.12)]
    {
        let found = line_periods(&made(kind))[0].unwrap();
        assert!((found / expected - 1.0).abs() < within, "{}: {found}", kind.name());
    }
}

#[test]
fn a_seed_is_one_surface_and_another_seed_another_where_chance_shapes_it() {
    for kind in SurfaceKind::ALL {
        let made = |seed| generate(&Spec { seed, patch: Some([10.0, 10.0]), ..Spec::new(kind) }).unwrap();
        assert_eq!(made(3), made(3), "{kind:?}");
        assert_eq!(made(3) != made(4), kind.is_random(), "{kind:?}");
    }
}

#[test]
fn lengths_in_the_plane_scale_with_the_period_and_heights_with_the_height() {
    for kind in SurfaceKind::ALL.into_iter().filter(|kind| kind.is_random()) {
        let patch = kind.dimensions().period.map(|period| if period > 0.0 { 8.0 * period } else { 10.0 });
        let small = Spec { patch: Some(patch), pixel_size: Some([0.05; 2]), ..Spec::new(kind) };
        let doubled = Spec {
            patch: Some(patch.map(|side| 2.0 * side)),
            pixel_size: Some([0.1; 2]),
            period: Some(2.0 * kind.dimensions().period[0]),
            height: Some(3.0 * kind.dimensions().height),
            ..small
        };
        let [small, doubled] = [small, doubled].map(|spec| generate(&spec).unwrap());
        assert!((doubled.pixel_size()[1] / small.pixel_size()[1] - 2.0).abs() < 1e-12);
        // The waves that bend a skin have fixed lengths, which do not scale.
        if matches!(kind, SurfaceKind::Elaphe | SurfaceKind::Xenopeltis) {
            continue;
        }
        for (a, b) in small.heights().iter().zip(doubled.heights()) {
            assert!((3.0 * a - b).abs() < 1e-9, "{kind:?}: {a} and {b}");
        }
    }
}

#[test]
fn fine_walls_are_sampled_finely_at_any_period() {
    for (period, spacing) in [(None, 0.05), (Some(0.8), 0.025), (Some(160.0), 0.095)] {
        let patch = period.map(|period| [4.0 * period; 2]);
        let field = generate(&Spec { period, patch, ..Spec::new(SurfaceKind::Cd) }).unwrap();
        for d in field.pixel_size() {
            assert!(d <= spacing * (1.0 + 1e-9) && d > 0.8 * spacing, "{period:?}: {d}");
        }
    }
}

#[test]
fn the_blaze_rises_along_x_with_its_slope_and_falls_at_once() {
    let field = made(SurfaceKind::Blaze);
    let slope = 0.246_23 / 2.5;
    let row = field.row(0);
    for (column, pair) in row.windows(2).enumerate() {
        let rise = pair[1] - pair[0];
        let expected = if (column + 1) % 27 == 0 { -26.0 } else { 1.0 } * slope * field.pixel_size()[0];
        assert!((rise - expected).abs() < 1e-12, "column {column}: {rise}");
    }
}

#[test]
fn a_wished_patch_is_rounded_to_whole_periods_and_a_spacing_never_grows() {
    let spec = Spec {
        patch: Some([9.3, 4.0]),
        pixel_size: Some([0.07, 0.09]),
        period: Some(3.0),
        height: Some(0.5),
        ..Spec::new(SurfaceKind::Sinusoid)
    };
    let field = generate(&spec).unwrap();
    assert!((field.patch_size()[0] - 9.0).abs() < 1e-12 && (field.patch_size()[1] - 4.0).abs() < 1e-12);
    assert!(field.pixel_size()[0] <= 0.07 && field.pixel_size()[1] <= 0.09);
    assert!((field.range().1 - 0.25).abs() < 1e-3);
}

#[test]
fn what_cannot_be_made_is_refused_with_exit_code_2() {
    let base = Spec::new(SurfaceKind::Elaphe);
    let mut wrong = vec![
        Spec { period: Some(1.0), ..Spec::new(SurfaceKind::Flat) },
        Spec { height: Some(1.0), ..Spec::new(SurfaceKind::Flat) },
        Spec { patch: Some([0.2, 65.0]), ..base },
        Spec { pixel_size: Some([0.9, 0.1]), ..base },
        Spec { pixel_size: Some([1e-9, 0.1]), ..base },
        Spec { patch: Some([1e9, 65.0]), ..base },
    ];
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        wrong.push(Spec { patch: Some([bad, 1.0]), ..base });
        wrong.push(Spec { pixel_size: Some([0.1, bad]), ..base });
        wrong.push(Spec { period: Some(bad), ..base });
        wrong.push(Spec { height: Some(bad), ..base });
    }
    wrong.push(Spec { period: Some(f64::MIN_POSITIVE), ..base });
    wrong.push(Spec { period: Some(f64::MAX), ..base });
    for spec in wrong {
        let e = generate(&spec).unwrap_err();
        assert_eq!(e.kind(), crate::error::ErrorKind::Usage, "{spec:?}: {e}");
    }
}

#[test]
fn ridges_of_a_lamellar_grating_have_their_duty_flanks_and_height() {
    let spec = Spec {
        duty: Some(0.4),
        flank: Some(0.1),
        period: Some(1.0),
        patch: Some([3.0, 0.5]),
        pixel_size: Some([0.002, 0.1]),
        ..Spec::new(SurfaceKind::Lamellar)
    };
    let field = generate(&spec).unwrap();
    assert_eq!(field.range(), (0.0, 0.2));
    let row = field.row(0);
    let share = |at: &dyn Fn(f64) -> bool| row.iter().filter(|h| at(**h)).count() as f64 / row.len() as f64;
    assert!((share(&|h| h >= 0.1) - 0.4).abs() < 0.01, "width at half height");
    assert!((share(&|h| h > 0.0 && h < 0.2) - 0.2).abs() < 0.01, "both flanks");
    let mean = row.iter().sum::<f64>() / row.len() as f64;
    assert!((mean - 0.08).abs() < 1e-3, "{mean}");
    let refused = |duty, flank| generate(&Spec { duty: Some(duty), flank: Some(flank), ..spec }).is_err();
    assert!(refused(0.0, 0.0) && refused(1.0, 0.0) && refused(0.4, 0.9) && !refused(0.4, 0.8));
    assert!(generate(&Spec { duty: Some(0.5), ..Spec::new(SurfaceKind::Blaze) }).is_err());
}

#[test]
fn orders_of_an_upright_lamellar_grating_are_those_of_a_rectangle() {
    for duty in [0.25, 0.3, 0.37] {
        let spec = Spec { duty: Some(duty), patch: Some([2.0, 0.5]), ..Spec::new(SurfaceKind::Lamellar) };
        let field = generate(&spec).unwrap();
        let (row, z) = (field.row(0), 9.0);
        let count = row.len() as f64;
        for m in 1..=5 {
            let (re, im) = row.iter().enumerate().fold((0.0, 0.0), |(re, im), (i, h)| {
                let (sin, cos) = (z * h - TAU * f64::from(m) * i as f64 / count).sin_cos();
                (re + cos / count, im + sin / count)
            });
            let power: f64 = re * re + im * im;
            let order = PI * f64::from(m);
            let expected =
                (z * 0.2 / 2.0_f64).sin().powi(2) * (order * duty).sin().powi(2) / (order / 2.0).powi(2);
            // A sum over samples has N sin(πm/N) for πm, which differs by (πm/N)²/6.
            let of_samples = (order / count).powi(2);
            let off = (power - expected).abs();
            assert!(off <= of_samples * expected + 1e-12, "{duty}, {m}: {power} {expected}");
        }
    }
    let tiny = Spec { period: Some(0.05), ..Spec::new(SurfaceKind::Lamellar) };
    assert_eq!(generate(&tiny).unwrap().columns() % 400, 0, "as many samples of each period as there may be");
}
