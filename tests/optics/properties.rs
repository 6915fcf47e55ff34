//! Properties over whole ranges of input: geometry of a pair of directions, and units as they are written.

use diffract::internals::optics::brdf::schlick;
use diffract::internals::optics::geometry::{Pair, direction};
use diffract::internals::scene::FarLight;
use diffract::internals::units;
use glam::DVec3;
use proptest::prelude::*;

prop_compose! {
    /// A unit vector above the horizon, down to a millionth of a degree.
    fn above()(theta in 0.0..89.999_999, phi in -360.0..360.0) -> DVec3 {
        direction(theta, phi)
    }
}

proptest! {
    #[test]
    fn a_direction_is_a_unit_vector_at_its_angles(theta in 0.0..180.0f64, phi in -720.0..720.0f64) {
        let d = direction(theta, phi);
        prop_assert!((d.length() - 1.0).abs() < 1e-14);
        prop_assert!((d.z - theta.to_radians().cos()).abs() < 1e-14);
        prop_assert!((d.x - theta.to_radians().sin() * phi.to_radians().cos()).abs() < 1e-13);
        prop_assert!((d.y - theta.to_radians().sin() * phi.to_radians().sin()).abs() < 1e-13);
    }

    #[test]
    fn w_is_never_positive_and_uvw_is_at_most_2_long(light in above(), view in above()) {
        let pair = Pair::new(light, view);
        let uvw = pair.uvw();
        prop_assert!(uvw.z < 0.0);
        prop_assert!(uvw.length() <= 2.0 + 1e-15);
        prop_assert_eq!(uvw, Pair::new(view, light).uvw());
        prop_assert!((uvw.z + light.z + view.z).abs() < 1e-15);
    }

    #[test]
    fn the_half_angle_and_the_geometric_factor_are_their_definitions(light in above(), view in above()) {
        let pair = Pair::new(light, view);
        let half = light + view;
        // Where light and view are opposite, the definition has no digits left to compare with.
        prop_assume!(half.length() > 1e-3);
        prop_assert!((pair.cos_half_angle() - light.dot(half.normalize())).abs() < 1e-12);
        let definition = (1.0 + light.dot(view)).powi(2) / (light.z * view.z);
        let ours = pair.geometric_factor_times_cos_light() / light.z;
        // 1 + ω_i·ω_r rounds at 2e-16 of 1, which is half the square of the half vector's length.
        prop_assert!((ours / definition - 1.0).abs() < 1e-14 + 1e-15 / half.length_squared());
    }

    #[test]
    fn the_reflectance_lies_between_its_normal_value_and_one(ior in 1.0..5.0f64, cosine in 0.0..=1.0f64) {
        let r = schlick(ior, cosine);
        prop_assert!(r >= schlick(ior, 1.0) && r <= 1.0 + 1e-15);
        prop_assert!(r >= schlick(ior, (cosine + 0.01).min(1.0)));
    }

    #[test]
    fn a_length_means_the_same_in_every_unit(micrometres in 1e-3..1e6f64) {
        let units = [("nm", 1e3), ("um", 1.0), ("µm", 1.0), ("μm", 1.0), ("mm", 1e-3), ("m", 1e-6)];
        for (unit, factor) in units {
            for text in [format!("{}{unit}", micrometres * factor), format!(" {:e} {unit} ", micrometres * factor)] {
                let read = units::length(&text).unwrap();
                prop_assert!((read / micrometres - 1.0).abs() < 1e-14, "{text}");
            }
        }
    }

    #[test]
    fn an_angle_means_the_same_in_degrees_and_radians(degrees in -720.0..720.0f64) {
        let read = units::angle(&format!("{}rad", degrees.to_radians())).unwrap();
        prop_assert!((read - degrees).abs() < 1e-12);
        prop_assert_eq!(units::angle(&format!("{degrees}deg")).unwrap(), degrees);
        prop_assert_eq!(units::angle(&format!("{degrees}°")).unwrap(), degrees);
    }

    #[test]
    fn pairs_and_counts_come_back_as_written(x in 1u32..=10_000, y in 1u32..=10_000) {
        prop_assert_eq!(units::counts(&format!("{x}x{y}")).unwrap(), [x, y]);
        prop_assert_eq!(units::size(&format!("{x}×{y}")).unwrap(), [x, y]);
        let pair = units::length_pair(&format!("{x}umx{y}um")).unwrap();
        prop_assert_eq!(pair, [f64::from(x), f64::from(y)]);
    }

    #[test]
    fn no_text_makes_a_parser_panic_and_every_refusal_names_a_remedy(text in "\\PC{0,12}|[-+.0-9eEx×,numradeg°µ ]{0,16}") {
        let refusals = [
            units::length(&text).map(|_| ()).err(),
            units::length_pair(&text).map(|_| ()).err(),
            units::angle(&text).map(|_| ()).err(),
            FarLight::parse(&text).map(|_| ()).err(),
            units::counts(&text).map(|_| ()).err(),
            units::size(&text).map(|_| ()).err(),
        ];
        for error in refusals.into_iter().flatten() {
            prop_assert_eq!(error.kind(), diffract::internals::error::ErrorKind::Usage);
            prop_assert!(error.to_string().contains("; "), "{}", error);
        }
        if let Ok(length) = units::length(&text) {
            prop_assert!(length > 0.0 && length.is_finite());
        }
    }
}
