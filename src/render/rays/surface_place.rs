//! Surface at a point of a triangle: its tangent frame, and the orientation of the patch of the height field.

use super::RayObject;
use super::triangles::Triangle;
use crate::scene::Vertex;
use glam::{DMat3, DVec2, DVec3, Vec2, Vec3};

/// Point of a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct SurfacePlace {
    /// Position in world space.
    pub position: DVec3,
    /// Unit vectors T, B and N as columns: normal and tangent are interpolated, then N is normalised and T is made
    /// orthonormal to it.
    pub frame: DMat3,
    /// Unit vector along the patch's x, in components of T and B.
    pub turn: DVec2,
}

impl SurfacePlace {
    /// Interpolates the `triangle` of `object` at the barycentric coordinates `weights`, which may lie outside the
    /// triangle.
    pub fn new(object: &RayObject<'_>, triangle: &Triangle, weights: [f64; 3]) -> Self {
        let (mesh, first) = (object.mesh, 3 * triangle.number);
        let corners = [0, 1, 2].map(|i| &mesh.vertices()[mesh.indices()[first + i] as usize]);
        let mix = |of: &dyn Fn(&Vertex) -> DVec3| -> DVec3 {
            corners.iter().zip(weights).map(|(corner, weight)| of(corner) * weight).sum()
        };
        let normal = mix(&|corner| Vec3::from(corner.normal).as_dvec3()).normalize_or(DVec3::Z);
        let tangent =
            mix(&|corner| Vec3::from_slice(&corner.tangent).as_dvec3()).reject_from_normalized(normal);
        let tangent = tangent.try_normalize().unwrap_or_else(|| normal.any_orthonormal_vector());
        // All corners of a triangle have the same handedness.
        let handedness = f64::from(corners[0].tangent[3]);
        let uv = mix(&|corner| Vec2::from(corner.uv).as_dvec2().extend(0.0)).truncate();
        Self {
            position: mix(&|corner| Vec3::from(corner.position).as_dvec3()),
            frame: DMat3::from_cols(tangent, handedness * normal.cross(tangent), normal),
            turn: object.grooves.turn_at(uv),
        }
    }

    /// Returns the direction of `vector`, given in world space, in the frame of the patch. The frame of a surface seen
    /// from its `back` is turned about the patch's x, as in `geometry.frag`.
    pub fn direction(&self, vector: DVec3, back: bool) -> DVec3 {
        let DVec3 { x, y, z } = (self.frame.transpose() * vector).normalize_or_zero();
        let along = DVec2::new(x, y);
        let [x, y] = [self.turn.dot(along), self.turn.perp_dot(along)];
        if back { DVec3::new(x, -y, -z) } else { DVec3::new(x, y, z) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::triangles::{Ray, Triangles};
    use super::*;
    use crate::render::grooves::GrooveDirections;
    use crate::scene::primitives;

    #[test]
    fn the_frame_of_a_sphere_is_that_of_its_closed_form() {
        let (mesh, grooves) = (primitives::sphere(), GrooveDirections::along().clone());
        let object = RayObject { mesh: &mesh, grooves: &grooves, casts_shadows: true };
        let triangles = Triangles::new(std::iter::once((&mesh, true)));
        for toward in [DVec3::new(0.3, 0.4, -1.0), DVec3::new(-1.0, 0.1, 0.2), DVec3::new(0.5, -1.0, 0.6)] {
            let (triangle, crossing) =
                triangles.nearest(&Ray { origin: toward * 3.0, direction: -toward }).unwrap();
            let place = SurfacePlace::new(&object, triangle, crossing.weights);
            // The poles lie on y; T points east.
            let normal = toward.normalize();
            let east = DVec3::Y.cross(normal).normalize();
            let exact = DMat3::from_cols(east, normal.cross(east), normal);
            let apart = (place.frame - exact).to_cols_array().iter().fold(0f64, |m, x| m.max(x.abs()));
            assert!(apart < 1e-3, "{toward}: {apart}");
            let unit = place.frame.transpose() * place.frame - DMat3::IDENTITY;
            assert!(unit.to_cols_array().iter().all(|x| x.abs() < 1e-12));
            // From the back the frame is turned about T: a vector along −N points up.
            let below = place.direction(-normal, true);
            assert!(below.z > 0.999 && place.direction(east, true).x > 0.999, "{below}");
        }
    }
}
