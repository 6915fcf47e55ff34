//! The grating equation in the signs of this program: u = m λ/d along the grating's axis.

/// Returns the period d \[µm\] of a grating that sends `wavelength` \[µm\] to `sin_view` from `sin_light` (both from +N toward the axis) in
/// order `order`: d = m λ / |sin θ_r + sin θ_i|. `None` in the specular direction, where every period fits.
pub fn period(wavelength: f64, sin_light: f64, sin_view: f64, order: u32) -> Option<f64> {
    let u = (sin_light + sin_view).abs();
    (u > 0.0).then(|| f64::from(order) * wavelength / u)
}

/// Returns sin θ_r of order `order` of a grating of period `period` \[µm\]; `None` if the order does not propagate. sin θ_i + sin θ_r = −m
/// λ/d, because u = −sin θ_i − sin θ_r = m λ/d.
pub fn sin_view(wavelength: f64, sin_light: f64, period: f64, order: i32) -> Option<f64> {
    let s = -f64::from(order) * wavelength / period - sin_light;
    (s.abs() < 1.0).then_some(s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_order_s_direction_gives_its_period_back() {
        for order in [-2, -1, 1, 3] {
            let s = sin_view(0.55, 0.3, 2.5, order).unwrap();
            let d = period(0.55, 0.3, s, order.unsigned_abs()).unwrap();
            assert!((d - 2.5).abs() < 1e-12);
        }
        assert_eq!(sin_view(0.55, 0.3, 0.4, 1), None);
        assert_eq!(period(0.55, 0.3, -0.3, 1), None);
    }
}
