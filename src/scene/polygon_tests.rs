//! Polygons whose areas are known, in every plane.

use super::*;
use glam::DQuat;
use proptest::prelude::*;
use std::time::Instant;

/// An L: a square of 2 × 2 without its upper right quarter, which is its notch. Area 3.
const L: [[f64; 2]; 6] = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];

fn flat(corners: &[[f64; 2]]) -> Vec<DVec3> {
    corners.iter().map(|&[x, y]| DVec3::new(x, y, 0.0)).collect()
}

/// Returns the triangles of a polygon in the plane z = 0.
fn cut(corners: &[[f64; 2]]) -> Vec<[[f64; 2]; 3]> {
    let mut cutter = PolygonCutter::default();
    let numbers = cutter.cut(&flat(corners)).unwrap();
    numbers.chunks(3).map(|t| [0, 1, 2].map(|k| corners[t[k] as usize])).collect()
}

fn area([a, b, c]: [[f64; 2]; 3]) -> f64 {
    ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0
}

/// Returns the sum of the areas, none of which may be negative.
fn sound_area(triangles: &[[[f64; 2]; 3]]) -> f64 {
    assert!(triangles.iter().all(|&t| area(t) >= 0.0), "{triangles:?}");
    triangles.iter().map(|&t| area(t)).sum()
}

fn covers(triangles: &[[[f64; 2]; 3]], p: [f64; 2]) -> bool {
    triangles.iter().any(|&[a, b, c]| [[a, b, p], [b, c, p], [c, a, p]].into_iter().all(|t| area(t) > 0.0))
}

#[test]
fn an_l_is_covered_and_its_notch_is_not_wherever_it_begins() {
    for start in 0..L.len() {
        let mut corners = L;
        corners.rotate_left(start);
        let triangles = cut(&corners);
        assert_eq!((triangles.len(), sound_area(&triangles)), (4, 3.0), "{start}");
        for (i, j) in (0..10).flat_map(|i| (0..10).map(move |j| (i, j))) {
            let p = [0.2 * f64::from(i) + 0.0917, 0.2 * f64::from(j) + 0.113];
            assert_eq!(covers(&triangles, p), p[0] < 1.0 || p[1] < 1.0, "{start}: {p:?}");
        }
    }
    // The fan that these faces had covers the notch.
    let mut corners = L;
    corners.rotate_left(1);
    let filled: Vec<_> = fan(6).map(|t| t.map(|k| corners[k as usize])).collect();
    assert!(filled.iter().any(|&t| area(t) < 0.0));
}

#[test]
fn convex_polygons_are_fans_from_their_first_corner() {
    let octagon: Vec<[f64; 2]> =
        (0..8).map(|k| (std::f64::consts::FRAC_PI_4 * f64::from(k)).sin_cos().into()).collect();
    let mut cutter = PolygonCutter::default();
    for corners in [&octagon[..], &octagon[..4], &octagon[..3]] {
        let expected: Vec<u32> = fan(corners.len()).flatten().collect();
        assert_eq!(cutter.cut(&flat(corners)).unwrap(), expected);
    }
}

#[test]
fn corners_that_are_twice_there_or_in_a_line_change_no_area() {
    let twice: Vec<[f64; 2]> = L.into_iter().flat_map(|corner| [corner, corner]).collect();
    let lined: Vec<[f64; 2]> = (0..6)
        .flat_map(|k| {
            let ([a, b], [c, d]) = (L[k], L[(k + 1) % 6]);
            [[a, b], [(a + c) / 2.0, (b + d) / 2.0]]
        })
        .collect();
    for mut corners in [twice, lined] {
        for _ in 0..corners.len() {
            corners.rotate_left(1);
            let triangles = cut(&corners);
            assert!((sound_area(&triangles) - 3.0).abs() < 1e-12, "{corners:?}");
            assert!(!covers(&triangles, [1.5, 1.6]) && covers(&triangles, [0.4, 1.7]));
        }
    }
}

#[test]
fn a_hole_with_a_slit_to_it_stays_open() {
    // A square of 4 × 4 with a hole of 2 × 2, whose ring is walked the other way.
    let corners = [
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 4.0],
        [0.0, 4.0],
        [0.0, 0.0],
        [1.0, 1.0],
        [1.0, 3.0],
        [3.0, 3.0],
        [3.0, 1.0],
        [1.0, 1.0],
    ];
    let triangles = cut(&corners);
    assert_eq!(sound_area(&triangles), 12.0);
    assert!(!covers(&triangles, [2.1, 1.8]));
}

#[test]
fn polygons_without_an_area_and_tangled_ones_neither_panic_nor_take_long() {
    let nothing = [[1.0, 1.0]; 7];
    let line: Vec<[f64; 2]> = (0..9).map(|k| [f64::from(k % 4), 0.0]).collect();
    let eight = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
    for corners in [&nothing[..], &line, &eight] {
        cut(corners);
    }
    // Pseudo-random corners: every edge crosses most others.
    let tangle: Vec<[f64; 2]> = (0..MAX_CORNERS)
        .map(|k| [(k as f64 * 0.754_877_666).fract(), (k as f64 * k as f64 * 0.569_840_291).fract()])
        .collect();
    let mut busy = PolygonCutter { work: MOST_WORK, ..PolygonCutter::default() };
    assert!(busy.cut(&flat(&L)).is_ok(), "small faces do not count");
    let e = busy.cut(&flat(&tangle)).unwrap_err().to_string();
    assert!(e.contains("too long; cut large faces"), "{e}");
    let start = Instant::now();
    cut(&tangle);
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
    let more: Vec<[f64; 2]> = [tangle, L.to_vec()].concat();
    let e = PolygonCutter::default().cut(&flat(&more)).unwrap_err().to_string();
    assert!(
        e.contains(&format!("a concave face has {} corners", MAX_CORNERS + 6))
            && e.contains("; cut large faces"),
        "{e}"
    );
}

proptest! {
    /// Checks stars around the origin, turned anywhere: the area of the polygon is known, and each triangle has the winding of the polygon.
    #[test]
    fn stars_in_any_plane_are_covered_once(
        radii in prop::collection::vec(0.2f64..1.0, 3..40),
        axis in prop::array::uniform3(-1.0f64..1.0),
        angle in 0.0f64..6.0,
    ) {
        let axis = DVec3::from(axis).try_normalize().unwrap_or(DVec3::X);
        let turn = DQuat::from_axis_angle(axis, angle);
        let step = std::f64::consts::TAU / radii.len() as f64;
        let corners: Vec<DVec3> = radii.iter().enumerate().map(|(k, r)| {
            let (y, x) = (k as f64 * step).sin_cos();
            turn * DVec3::new(r * x, r * y, 0.3)
        }).collect();
        let expected: f64 = (0..radii.len()).map(|k| radii[k] * radii[(k + 1) % radii.len()] * step.sin() / 2.0).sum();
        let mut cutter = PolygonCutter::default();
        let triangles: Vec<u32> = cutter.cut(&corners).unwrap().to_vec();
        let areas = triangles.chunks(3).map(|t| cross(&corners, [t[0], t[1], t[2]]).dot(turn * DVec3::Z) / 2.0);
        prop_assert!(areas.clone().all(|a| a > -1e-6));
        prop_assert!((areas.sum::<f64>() - expected).abs() < 1e-5);
    }
}
