//! The snake's body: a coiled centreline that rests on the ground and on itself, and the skin around it.

use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Largest half-width of the body.
pub const GIRTH: f64 = 0.17;
/// Length of the head along the centreline.
pub const HEAD: f64 = 0.40;
/// Samples of the centreline.
const SAMPLES: usize = 2400;
/// Turns from the tail's tip to where the neck leaves the coil.
const TURNS: f64 = 2.3;
/// Height of the belly below the centreline, per half-width: a resting body is flattened.
const BELLY: f64 = 0.8;
/// Contact distance per sum of half-widths: soft bodies in contact dent each other.
const SOFTNESS: f64 = 0.95;

/// Steepest slope of the resting body.
const STEEPEST: f64 = 0.3;

/// The centreline, sampled evenly by arc length from the tail's tip (0) to the snout (`length`).
pub struct Body {
    points: Vec<DVec3>,
    step: f64,
}

/// Local frame of the centreline.
pub struct BodyFrame {
    pub centre: DVec3,
    pub up: DVec3,
    /// Toward the snake's left when it looks along its head: y × forward.
    pub left: DVec3,
}

impl Body {
    /// Lays the coil down.
    pub fn coiled() -> Self {
        let plan = resample(&rounded(&resample(&plan_curve(), SAMPLES), 40), SAMPLES);
        let step = length(&plan) / (SAMPLES - 1) as f64;
        let mut body = Self { points: plan, step };
        body.settle();
        // Climbing stretches the curve a little; make the samples even again.
        body.points = resample(&body.points, SAMPLES);
        body.step = length(&body.points) / (SAMPLES - 1) as f64;
        body
    }

    /// Arc length from the tail's tip to the snout.
    pub fn length(&self) -> f64 {
        self.step * (SAMPLES - 1) as f64
    }

    /// Half-width of the cross-section at arc length `s`.
    pub fn half_width(&self, s: f64) -> f64 {
        profile(s, self.length()).0
    }

    /// Frame at arc length `s`, interpolated between samples.
    pub fn frame(&self, s: f64) -> BodyFrame {
        let centre = self.at(s);
        let d = 4.0 * self.step;
        let forward = (self.at(s + d) - self.at(s - d)).normalize();
        let left = DVec3::Y.cross(forward).normalize();
        BodyFrame { centre, up: forward.cross(left), left }
    }

    /// Skin at arc length `s` and angle `phi` from the back (0) over the left side (π/2) to the belly (π), raised
    /// by `lift` (in model units).
    pub fn skin(&self, s: f64, phi: f64, lift: f64) -> DVec3 {
        let frame = self.frame(s);
        let (side, top, bottom) = profile(s, self.length());
        let (sin, cos) = phi.sin_cos();
        // An ellipse whose lower half is shallower, with a continuous tangent.
        let up = cos * (0.5 * (top + bottom) + 0.5 * (top - bottom) * cos);
        let normal = (frame.left * (sin / side) + frame.up * (cos / (0.5 * (top + bottom)))).normalize();
        frame.centre + frame.left * (side * sin) + frame.up * up + normal * lift
    }

    /// Whether the skin point at (`s`, `phi`) is buried in another stretch of the body, by more than `depth`.
    pub fn buries(&self, s: f64, phi: f64, depth: f64) -> bool {
        let p = self.skin(s, phi, 0.0);
        let own = self.half_width(s);
        (0..SAMPLES).step_by(4).any(|j| {
            let t = j as f64 * self.step;
            let r = self.half_width(t);
            (t - s).abs() > 3.0 * (own + r) && (self.points[j] - p).length() < r - depth
        })
    }

    /// The centreline at `s`; beyond its ends it goes on straight.
    fn at(&self, s: f64) -> DVec3 {
        let x = s / self.step;
        let i = (x.floor().max(0.0) as usize).min(SAMPLES - 2);
        self.points[i] + (self.points[i + 1] - self.points[i]) * (x - i as f64)
    }

    /// Drops every stretch onto the ground and onto the stretches laid before it.
    fn settle(&mut self) {
        let total = self.length();
        let r: Vec<_> = (0..SAMPLES).map(|i| profile(i as f64 * self.step, total)).collect();
        for _ in 0..6 {
            let raw: Vec<f64> = (0..SAMPLES).map(|i| self.support(i, &r)).collect();
            for (p, y) in self.points.iter_mut().zip(smooth_over(&raw, self.step)) {
                p.y = y;
            }
        }
    }

    /// The lowest height at which sample `i` rests.
    fn support(&self, i: usize, r: &[(f64, f64, f64)]) -> f64 {
        let p = self.points[i];
        (0..i).step_by(3).fold(r[i].2, |y, j| {
            let reach = SOFTNESS * (r[i].0 + r[j].0);
            let q = self.points[j];
            let gap = (p.x - q.x).hypot(p.z - q.z);
            if ((i - j) as f64) * self.step < 4.0 * reach || gap >= reach {
                return y;
            }
            y.max(q.y + SOFTNESS * (r[j].1 + r[i].2) * (1.0 - (gap / reach).powi(2)).sqrt())
        })
    }
}

/// Half-width, height above and depth below the centreline at arc length `s` of `total`.
fn profile(s: f64, total: f64) -> (f64, f64, f64) {
    let x = (s - (total - HEAD)) / HEAD;
    let u = (s / (total - HEAD)).clamp(0.0, 1.0);
    let tail = (u / 0.62).min(1.0);
    let swell = 0.004 + 0.996 * (0.5 * PI * tail).sin().powf(1.15);
    let neck = 1.0 - 0.5 * smoothstep(0.72, 1.0, u);
    let body = GIRTH * swell * neck;
    if x <= 0.0 {
        return (body, body, BELLY * body);
    }
    let x = x.min(1.0);
    let jaw = 1.0 + 0.42 * smoothstep(0.0, 0.38, x) - 0.72 * smoothstep(0.4, 1.0, x);
    let snout = (1.0 - ((x - 0.8) / 0.2).max(0.0).powi(2)).max(0.0).sqrt();
    let crown = 1.0 - 0.05 * smoothstep(0.0, 0.5, x) - 0.45 * smoothstep(0.5, 1.0, x);
    let chin = BELLY * (1.0 - 0.25 * smoothstep(0.0, 0.4, x) - 0.25 * smoothstep(0.5, 1.0, x));
    (body * jaw * snout, body * crown * snout, body * chin * snout)
}

/// The coil seen from above, tail first: a loosening spiral, then the neck's bend and the head across the loops.
fn plan_curve() -> Vec<DVec3> {
    let mut controls = Vec::new();
    let count = 28;
    for i in 0..=count {
        let turn = TURNS * i as f64 / count as f64;
        let flick = 0.10 * (1.0 - turn / 0.25).max(0.0).powi(2);
        controls.push(polar(turn, 0.82 - 0.205 * turn + flick));
    }
    for (turn, distance) in
        [(0.08, 0.32), (0.18, 0.25), (0.30, 0.15), (0.58, 0.07), (0.72, 0.24), (0.75, 0.44), (0.745, 0.68)]
    {
        controls.push(polar(TURNS + turn, distance));
    }
    spline(&controls, 40)
}

/// A point on the ground: `turn` full turns around the vertical axis, with a slightly uneven coil.
fn polar(turn: f64, distance: f64) -> DVec3 {
    let angle = turn * TAU;
    let uneven = 1.0 + 0.05 * (2.0 * angle + 0.7).cos() + 0.02 * (3.0 * angle).sin();
    DVec3::new(angle.cos(), 0.0, -angle.sin()) * (distance * uneven)
}

/// Catmull-Rom spline through `controls`, `parts` segments between neighbours.
fn spline(controls: &[DVec3], parts: usize) -> Vec<DVec3> {
    let last = controls.len() - 1;
    let mut curve = Vec::with_capacity(last * parts + 1);
    for i in 0..last {
        let [b, c] = [controls[i], controls[i + 1]];
        let a = if i == 0 { b * 2.0 - c } else { controls[i - 1] };
        let d = if i + 1 == last { c * 2.0 - b } else { controls[i + 2] };
        for k in 0..parts {
            let t = k as f64 / parts as f64;
            let cubic = (b - c) * 3.0 + d - a;
            let square = a * 2.0 - b * 5.0 + c * 4.0 - d;
            curve.push(b + ((cubic * t + square) * t + (c - a)) * (0.5 * t));
        }
    }
    curve.push(controls[last]);
    curve
}

fn length(curve: &[DVec3]) -> f64 {
    curve.windows(2).map(|w| w[0].distance(w[1])).sum()
}

/// `count` points at even distances along `curve`.
fn resample(curve: &[DVec3], count: usize) -> Vec<DVec3> {
    let step = length(curve) / (count - 1) as f64;
    let mut points = Vec::with_capacity(count);
    let (mut i, mut before) = (0, 0.0);
    for k in 0..count {
        let target = step * k as f64;
        while i + 2 < curve.len() && before + curve[i].distance(curve[i + 1]) < target {
            before += curve[i].distance(curve[i + 1]);
            i += 1;
        }
        let t = (target - before) / curve[i].distance(curve[i + 1]);
        points.push(curve[i].lerp(curve[i + 1], t));
    }
    points
}

/// `curve` with its bends rounded over `reach` samples each way; the ends stay.
fn rounded(curve: &[DVec3], reach: usize) -> Vec<DVec3> {
    let mean = |points: &[DVec3]| points.iter().copied().sum::<DVec3>() / points.len() as f64;
    let mut curve = curve.to_vec();
    for _ in 0..2 {
        curve = (0..curve.len())
            .map(|i| {
                let near = reach.min(i).min(curve.len() - 1 - i);
                mean(&curve[i - near..=i + near])
            })
            .collect();
    }
    curve
}

/// Heights that stay above `raw`, bend gently and are never steeper than a heavy body hangs. Samples lie `step` apart.
fn smooth_over(raw: &[f64], step: f64) -> Vec<f64> {
    let reach = (0.16 / step) as usize;
    let around = |i: usize| i.saturating_sub(reach)..(i + reach + 1).min(raw.len());
    let mut v: Vec<f64> =
        (0..raw.len()).map(|i| raw[around(i)].iter().copied().fold(0.0, f64::max)).collect();
    let fall = STEEPEST * step;
    for i in 1..v.len() {
        v[i] = v[i].max(v[i - 1] - fall);
    }
    for i in (1..v.len()).rev() {
        v[i - 1] = v[i - 1].max(v[i] - fall);
    }
    for _ in 0..2 {
        v = (0..v.len()).map(|i| v[around(i)].iter().sum::<f64>() / around(i).len() as f64).collect();
    }
    v
}

/// 0 below `a`, 1 above `b`, smooth between.
pub fn smoothstep(a: f64, b: f64, x: f64) -> f64 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn loops_rest_on_each_other_and_do_not_run_through_each_other() {
        let body = Body::coiled();
        let stretch = |k: usize| (body.half_width(k as f64 * body.step), body.points[k]);
        let mut touching = 0;
        for i in (0..SAMPLES).step_by(8) {
            for j in (0..i).step_by(8) {
                let ((r, p), (q, o)) = (stretch(i), stretch(j));
                if (i - j) as f64 * body.step > 4.0 * (r + q) {
                    // Flat bellies and the flat head bring centrelines closer than half-widths add up to.
                    let closeness = p.distance(o) / (r + q);
                    assert!(closeness > 0.7, "{closeness} at {p} and {o}");
                    touching += usize::from(closeness < 1.0);
                }
            }
        }
        assert!(touching > 100, "{touching}");
    }

    #[test]
    fn the_body_swells_from_a_pointed_tail_and_narrows_at_the_neck() {
        let body = Body::coiled();
        let neck = body.length() - HEAD;
        assert!(body.half_width(0.0) < 0.01 * GIRTH);
        assert!(body.half_width(0.65 * neck) > 0.99 * GIRTH);
        assert!(body.half_width(neck) < 0.55 * GIRTH);
        assert!(body.half_width(neck + 0.38 * HEAD) > 1.2 * body.half_width(neck));
    }

    #[test]
    fn the_frame_is_right_handed_and_the_back_is_up() {
        let body = Body::coiled();
        for k in 1..50 {
            let s = body.length() * k as f64 / 50.0;
            let f = body.frame(s);
            assert!((f.up.dot(f.left).abs() < 1e-9) && f.up.y > 0.9);
            assert!(body.skin(s, 0.0, 0.0).y > f.centre.y && body.skin(s, PI, 0.0).y < f.centre.y);
        }
    }
}
