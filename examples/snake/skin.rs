//! What covers the body: overlapping scales, the smooth skin below them, the head and the eyes.

use super::body::{Body, GIRTH, HEAD, smoothstep};
use super::grid::SkinGrid;
use glam::{DVec2, DVec3};
use std::f64::consts::{PI, TAU};

/// Rows of scales around the back and the flanks, on the body and on the thin part of the tail.
const ROWS: [usize; 2] = [21, 11];
/// Angle from the middle of the back to the lowest row.
const LOWEST: f64 = 2.3;
/// Length of a scale's visible part, per distance between rows.
const ELONGATION: f64 = 2.7;
/// Height of a scale's free edge, per half-width of the body.
const LIFT: f64 = 0.075;

/// Where a scale sits.
struct Seat {
    /// Arc length of its middle.
    s: f64,
    /// Angle of its middle.
    phi: f64,
    /// Half of the visible length.
    half_length: f64,
    /// Half of the angle that it spans.
    half_angle: f64,
    /// Tilt relative to the common one.
    tilt: f64,
}

/// All scales that can be seen.
pub fn scales(body: &Body) -> Vec<SkinGrid> {
    let mut s = 0.03;
    let mut grids = Vec::new();
    let mut ring = 0;
    while s < body.length() - 0.5 * HEAD {
        let tail = s < 0.5 * body.length() && body.half_width(s) < 0.4 * GIRTH;
        let rows = ROWS[usize::from(tail)];
        let spacing = 2.0 * LOWEST / (rows - 1) as f64;
        let pitch = (ELONGATION * spacing * body.half_width(s)).max(0.03);
        for row in 0..rows {
            let seat = Seat {
                s: if row % 2 == 0 { s } else { s + 0.5 * pitch },
                phi: spacing * row as f64 - LOWEST,
                half_length: 0.5 * pitch,
                half_angle: 1.08 * spacing,
                tilt: 1.0 + 0.2 * scatter(ring, row),
            };
            if !body.buries(seat.s, seat.phi, 0.03 * GIRTH) {
                grids.push(scale(body, &seat));
            }
        }
        s += pitch;
        ring += 1;
    }
    // From the neck, which lies on top, to the tail below it: what is hidden then finds its pixels taken.
    grids.reverse();
    grids
}

/// One scale: a shield with a rounded free edge toward the tail, lifted there, and curved across. `u` runs across the
/// body and `v` toward the tail, both 0 to 1 over the scale.
fn scale(body: &Body, seat: &Seat) -> SkinGrid {
    let r = body.half_width(seat.s);
    let on_head = smoothstep(body.length() - 1.3 * HEAD, body.length() - 0.5 * HEAD, seat.s);
    // From the grid to the shield: −1 to 1 across and along. Grid rows gather at the free edge, which is seen.
    let shield = |x: f64, y: f64| {
        let along = 2.0 * y.max(0.0).powf(0.75) - 1.0;
        let tip = if along > 0.0 { 0.28 } else { 0.1 };
        let width = tip + (1.0 - tip) * (1.0 - along.abs().powf(1.9)).max(0.0).powf(0.8);
        ((2.0 * x - 1.0) * width, along)
    };
    let surface = |x: f64, y: f64| {
        let (across, along) = shield(x, y);
        let rear = 0.5 * (along + 1.0);
        let tilt = LIFT * seat.tilt * (1.0 - 0.75 * on_head);
        let lift = tilt * (rear - 0.25 * rear.powi(4)) - 0.02 - 0.03 * across * across;
        let reach = if along > 0.0 { 1.4 } else { 1.05 };
        let s = seat.s - along * reach * seat.half_length;
        body.skin(s, seat.phi + across * seat.half_angle, r * lift)
    };
    SkinGrid::sample([3, 4], surface, |x, y| {
        let (across, along) = shield(x, y);
        DVec2::new(0.5 + 0.5 * across, 0.5 + 0.5 * along)
    })
}

/// The smooth skin below the scales, from the tail's tip to the neck.
pub fn tube(body: &Body) -> SkinGrid {
    let end = body.length() - HEAD;
    wrap(body, [17, 90], |y| end * (1.0 - y), |_, _| -0.02)
}

/// The head, closed at the snout, with a mouth line.
pub fn head(body: &Body) -> SkinGrid {
    // Rings gather where the snout is round, and the first is too small to see through.
    let arc = |y: f64| body.length() - 1.1 * HEAD * (0.004 + 0.996 * y).powi(2);
    wrap(body, [41, 30], arc, |s, phi| {
        let front = 1.0 - smoothstep(0.62 * HEAD, 0.72 * HEAD, body.length() - s);
        -0.08 * front * (-((phi.abs() - 1.75) / 0.09).powi(2)).exp()
    })
}

/// Both eyes.
pub fn eyes(body: &Body) -> Vec<SkinGrid> {
    let s = body.length() - 0.4 * HEAD;
    let size = 0.2 * body.half_width(s);
    [-1.0, 1.0]
        .into_iter()
        .map(|side| {
            let centre = body.skin(s, side * 1.0, -0.35 * size);
            let ball = move |x: f64, y: f64| {
                let (a, b) = (TAU * x, PI * (0.02 + 0.96 * y));
                centre + DVec3::new(b.sin() * a.cos(), b.cos(), b.sin() * -a.sin()) * -size
            };
            SkinGrid::sample([13, 9], ball, DVec2::new)
        })
        .collect()
}

/// Skin all around: row `y` (0 to 1, toward the tail) lies at arc length `arc(y)`, raised by `lift(s, phi)`
/// half-widths.
fn wrap(body: &Body, size: [usize; 2], arc: impl Fn(f64) -> f64, lift: impl Fn(f64, f64) -> f64) -> SkinGrid {
    let surface = |x: f64, y: f64| {
        let (s, phi) = (arc(y), PI * (2.0 * x - 1.0));
        body.skin(s, phi, lift(s, phi) * body.half_width(s))
    };
    SkinGrid::sample(size, surface, |x, y| DVec2::new(x, body.length() - arc(y)))
}

/// A fixed pseudo-random number in −1..1 for a scale.
fn scatter(ring: usize, row: usize) -> f64 {
    let mut h =
        (ring as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (row as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f);
    h = (h ^ (h >> 31)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    ((h ^ (h >> 29)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}
