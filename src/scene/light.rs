//! Directional lights.

use crate::optics::geometry::direction;
pub use crate::units::Light;
use glam::Vec3;

/// Most lights of a scene: each costs a whole spectrum per fragment. Twin of `MAX_LIGHTS` in `interface.glsl`.
pub const MAX_LIGHTS: usize = 4;

impl Light {
    /// The unit vector to the light, `theta` from the world's up (+z), `phi` from +x toward +y. Its intensity is the
    /// irradiance over π: a white diffuse surface that faces a light of intensity 1 has a radiance of 1.
    pub fn direction(&self) -> Vec3 {
        direction(self.theta, self.phi).as_vec3()
    }
}
