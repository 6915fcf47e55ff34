use super::*;
use crate::optics::coherence::Coherence;
use crate::optics::geometry::direction;
use crate::optics::quadrature::SPAN;
use crate::optics::spectrum::LONGEST;
use crate::random::Random;
use crate::surface::HeightField;
use crate::surface::synth::{self, Spec, SurfaceKind};
use crate::task::Task;

fn patch(kind: SurfaceKind, size: f64) -> HeightField {
    synth::generate(&Spec { patch: Some([size; 2]), ..Spec::new(kind) }).unwrap()
}

/// Returns pairs of directions above the horizon, seven tenths of which are anywhere and the rest near the specular direction.
fn pairs(count: usize, seed: u64) -> Vec<Pair> {
    let mut random = Random::new(seed);
    let mut uniform = || random.share();
    (0..count)
        .map(|i| {
            let (theta, phi) = (85.0 * uniform(), 360.0 * uniform());
            let light = direction(theta, phi);
            let view = if i % 10 < 7 {
                direction(85.0 * uniform(), 360.0 * uniform())
            } else {
                direction((theta + uniform()).min(85.0), phi + 180.0 + uniform())
            };
            Pair::new(light, view)
        })
        .collect()
}

/// Returns RMS and largest error of single wavelengths relative to their values; near zeros of the speckle relative to a floor.
fn worst(field: &HeightField, coherence: Coherence, windows: [u32; 2], seed: u64) -> (f64, f64) {
    let reference = Reference::new(field, coherence, windows, 1.5);
    let basis = HeightBasis::new(field, 4.0 * PI / SHORTEST);
    let pairs = pairs(60, seed);
    let [n, m] = windows;
    let patch = field.patch_size();
    let mut sums = vec![vec![0.0; 5]; pairs.len()];
    let step = SPAN / 4.0;
    for window in 0..n * m {
        let shift = [
            f64::from(window % n) / f64::from(n) * patch[0],
            f64::from(window / n) / f64::from(m) * patch[1],
        ];
        let spectra = Spectra::new(field, &coherence, shift, reach_of(&pairs, SHORTEST), &basis).unwrap();
        for (pair, sums) in pairs.iter().zip(&mut sums) {
            let power = spectra.power(pair.uvw(), 1.0 / LONGEST, step, 5);
            sums.iter_mut().zip(power).for_each(|(s, p)| *s += p / f64::from(n * m));
        }
    }
    let peak = match coherence {
        Coherence::Gaussian { length } => (PI * length * length / 8.0).powi(2),
        Coherence::Repeats(_) => coherence.area(patch).powi(2),
    };
    let (mut squares, mut largest, mut count) = (0.0, 0.0f64, 0.0);
    for (pair, fine) in pairs.iter().zip(&sums) {
        let exact = reference.power(pair.uvw(), 1.0 / LONGEST, step, 5);
        let typical = exact.iter().sum::<f64>() / 5.0;
        for (a, b) in fine.iter().zip(&exact) {
            assert_eq!(*b == 0.0, *a == 0.0, "the band ends elsewhere");
            // A zero of the speckle has no relative accuracy: its floor is a thousandth of its surroundings. Between the orders of a
            // grating there is no light at all: the floor is a billionth of the specular peak.
            let error = (a - b).abs() / b.max(1e-3 * typical).max(1e-9 * peak);
            squares += error * error;
            largest = largest.max(error);
            count += 1.0;
        }
    }
    (f64::sqrt(squares / count), largest)
}

#[test]
fn the_fine_spectra_are_the_direct_sum_in_every_direction() {
    let gaussian = |length| Coherence::Gaussian { length };
    for (kind, size, coherence, windows) in [
        (SurfaceKind::Elaphe, 12.0, gaussian(24.0), [1, 1]),
        (SurfaceKind::Blaze, 7.5, gaussian(20.0), [1, 1]),
        (SurfaceKind::Bumps, 4.0, gaussian(9.0), [1, 1]),
        (SurfaceKind::Xenopeltis, 6.0, gaussian(16.0), [1, 1]),
        (SurfaceKind::Elaphe, 6.0, gaussian(8.0), [3, 2]),
        (SurfaceKind::Elaphe, 6.0, Coherence::Repeats([3, 2]), [1, 1]),
        (SurfaceKind::Bumps, 3.0, Coherence::Repeats([2, 4]), [2, 3]),
    ] {
        let (rms, largest) = worst(&patch(kind, size), coherence, windows, 5);
        eprintln!("{kind:?} {coherence:?} {windows:?}: RMS {rms:.1e}, largest {largest:.1e}");
        assert!(rms < 1e-6 && largest < 2e-5, "{kind:?} {coherence:?}: {rms:e}, {largest:e}");
    }
}

#[test]
fn odd_and_even_numbers_of_samples_on_oblong_grids_agree_too() {
    for (columns, rows) in [(31, 20), (20, 31), (17, 17)] {
        let mut random = Random::new(3);
        let mut uniform = || random.share();
        let heights = (0..columns * rows).map(|_| 0.3 * uniform()).collect();
        let field = HeightField::new(columns, rows, [0.09, 0.13], heights).unwrap();
        for windows in [[1, 1], [2, 3]] {
            for coherence in [Coherence::Gaussian { length: 7.0 }, Coherence::Repeats([2, 1])] {
                let (rms, largest) = worst(&field, coherence, windows, 11);
                eprintln!("{columns} x {rows} {coherence:?}: RMS {rms:.1e}, largest {largest:.1e}");
                assert!(
                    rms < 1e-6 && largest < 2e-5,
                    "{columns} x {rows} {coherence:?}: {rms:e}, {largest:e}"
                );
            }
        }
    }
}

#[test]
fn colours_are_those_of_the_direct_sum() {
    let field = patch(SurfaceKind::Elaphe, 10.0);
    let reference = Reference::new(&field, Coherence::Gaussian { length: 16.0 }, [1, 1], 1.5);
    let pairs = pairs(600, 9);
    let counts: Vec<usize> = pairs.iter().map(|p| node_count(&reference, p).unwrap()).collect();
    assert!(!is_little(&reference, &counts, SHORTEST), "the direct sum would be compared with itself");
    let fine = cosine_weighted_xyz(&reference, &Illuminant::D65, &pairs, &Task::silent()).unwrap();
    for (pair, fine) in pairs.iter().zip(fine).step_by(23) {
        let exact = reference.cosine_weighted_xyz(pair, &Illuminant::D65).unwrap();
        let error = (fine - exact).length() / exact.length();
        assert!(error < 1e-5, "{pair:?}: {error:e}");
    }
}
