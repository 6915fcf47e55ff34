//! Cameras that show all of a scene for any aspect ratio of the picture.

use crate::scene::{Bounds, Camera, Lens, LensProjection, Mesh};
use glam::Vec3;

/// Aspect ratio, width and height, that scenes are composed for.
const USUAL: [u32; 2] = [4, 3];
/// Fraction of the picture that a framed mesh fills.
const FILLED: f32 = 0.95;

/// Aims `camera` at the centre of `meshes` without changing its direction, at a distance where a picture of `size`
/// pixels shows all of them. Its picture is no longer shifted.
pub fn whole(camera: Camera, meshes: &[&Mesh], size: [u32; 2]) -> Camera {
    let lens = Lens { shift: [0.0; 2], ..camera.lens };
    let aimed = Camera { target: Bounds::enclosing(meshes).centre, lens, ..camera };
    aimed.showing(factor(&aimed, meshes, size, FILLED))
}

/// Moves the `camera` of a scene back if a picture of `size` pixels would cut off `meshes` that fit into a picture of
/// the usual shape. A scene that cuts them off there does so by intention and is unchanged.
pub fn of_scene(camera: Camera, meshes: &[&Mesh], size: [u32; 2]) -> Camera {
    let shows_all = |size| factor(&camera, meshes, size, 1.0) <= 1.0;
    // A picture that is shifted was composed for its own size.
    if camera.lens.shift != [0.0; 2] || shows_all(size) || !shows_all(USUAL) {
        return camera;
    }
    camera.showing(factor(&camera, meshes, size, FILLED))
}

/// Returns the smallest factor with which [`Camera::showing`] shows `meshes` within the fraction `filled` of a picture of `size`.
fn factor(camera: &Camera, meshes: &[&Mesh], size: [u32; 2], filled: f32) -> f32 {
    let [width, height] = size.map(|n| n.max(1) as f32);
    let tangent = camera.height_at(1.0) / 2.0 * filled;
    let forward = camera.forward().as_vec3();
    let [right, up] = camera.right_and_up();
    let least = |vertex: &crate::scene::Vertex| {
        let offset = Vec3::from(vertex.position) - camera.target;
        let across = (offset.dot(right).abs() * height / width).max(offset.dot(up).abs());
        match camera.lens.projection {
            LensProjection::Perspective { .. } => (across / tangent - offset.dot(forward)) / camera.distance,
            LensProjection::Orthographic { .. } => across / tangent,
        }
    };
    meshes.iter().flat_map(|mesh| mesh.vertices()).map(least).fold(f32::MIN_POSITIVE, f32::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Scene;
    use crate::scene::scene_file::BUILT_IN;

    /// Returns the largest |x| or |y| of the mesh in clip space: 1 at the edge of the picture.
    fn reach(camera: &Camera, mesh: &Mesh, size: [u32; 2]) -> f32 {
        let bounds = mesh.bounds();
        let clip = camera.clip_from_world(size, bounds.centre, bounds.radius);
        let place = |v: &crate::scene::Vertex| clip.project_point3(v.position.into()).truncate().abs();
        mesh.vertices().iter().map(place).fold(0.0, |most, p| most.max(p.max_element()))
    }

    #[test]
    fn a_framed_mesh_fills_pictures_of_every_shape_from_every_side() {
        for name in ["snake", "disc", "plate"] {
            let scene = Scene::open(name).unwrap();
            for size in [[640, 480], [300, 900], [900, 200]] {
                for (theta, phi) in [(0.3, 0.0), (1.2, 2.0), (2.6, 4.0)] {
                    let away = Camera { target: Vec3::splat(7.0), distance: 0.1, theta, phi, ..scene.camera };
                    let framed = whole(away, &scene.standing(), size);
                    let reach = reach(&framed, &scene.main_object().mesh, size);
                    assert!((0.6..=FILLED + 1e-3).contains(&reach), "{name} {size:?}: {reach}");
                    assert_eq!((framed.theta, framed.phi), (theta, phi));
                }
            }
        }
    }

    #[test]
    fn all_objects_but_the_ground_are_framed() {
        let text = include_str!("../../assets/scenes/objects.toml");
        let scene = Scene::parse(text, std::path::Path::new("")).unwrap();
        let meshes = scene.standing();
        assert_eq!((meshes.len(), scene.objects.len()), (3, 4));
        assert_eq!(of_scene(scene.camera, &meshes, USUAL), scene.camera);
        for size in [[640, 480], [300, 900]] {
            let framed = [whole(scene.camera, &meshes, size), of_scene(scene.camera, &meshes, size)];
            for camera in framed {
                let reach = meshes.iter().map(|mesh| reach(&camera, mesh, size)).fold(0.0, f32::max);
                assert!(reach <= 1.0, "{size:?}: {reach}");
            }
        }
    }

    #[test]
    fn a_scene_s_own_view_changes_only_where_it_would_be_cut_off() {
        for (name, _) in BUILT_IN {
            let scene = Scene::open(name).unwrap();
            let of_size = |size| of_scene(scene.camera, &scene.standing(), size);
            assert_eq!(of_size(USUAL), scene.camera, "{name}");
            let composed = reach(&scene.camera, &scene.main_object().mesh, USUAL) <= 1.0;
            let narrow = of_size([300, 900]);
            if composed {
                let reach = reach(&narrow, &scene.main_object().mesh, [300, 900]);
                assert!(reach <= FILLED + 1e-3, "{name}: {reach}");
            } else {
                assert_eq!(narrow, scene.camera, "{name} shows a part");
            }
            eprintln!("{name}: composed {composed}");
        }
    }
}
