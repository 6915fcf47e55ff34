//! Pictures that are the mean of samples, and the footprints of their pixels.

use crate::device::with_device;
use crate::evaluation::{layers, optics, patch, window};
use diffract::internals::error::ErrorKind;
use diffract::internals::optics::color::Tone;
use diffract::internals::render::footprints::{Distribution, median_pixel_area};
use diffract::internals::render::frame::{Shown, View};
use diffract::internals::render::reference_picture::displayed;
use diffract::internals::render::renderer::{Picture, PictureRequest, Renderer};
use diffract::internals::render::sampling::{PixelWeights, Sample, Sampling};
use diffract::internals::scene::{Camera, Lens, Light, Scene};
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::task::Task;
use diffract::internals::vk::device::Device;
use glam::{DVec2, DVec3, DVec4, Vec3};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

const SIZE: [u32; 2] = [48, 36];
const SHOWN: Shown = Shown::plain(0.5, DVec3::new(0.1, 0.2, 0.3));

fn renderer(device: &Arc<Device>, scene: &Scene) -> Renderer {
    let optics = optics(4.0, 1e-1);
    let layers = layers(&patch(SurfaceKind::Flat, 2.0), &optics);
    crate::renderer_of(device, scene, &window(&layers), &optics, SIZE).unwrap()
}

fn view(scene: &Scene) -> View {
    let mut view = View::of(scene, vec![Light::point(40.0, -30.0, 1.0)]);
    view.base_colors = vec![Vec3::new(0.9, 0.5, 0.2)];
    view
}

fn all(renderer: &mut Renderer, view: &View, sampling: Sampling) -> Picture {
    renderer.render(view, &sampling, SHOWN, &Task::silent()).unwrap()
}

/// The largest relative difference of colours, and the largest difference of alpha.
fn difference(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(a, b)| (a - b).abs() / b.abs().max(1e-3)).fold(0.0, f32::max)
}

/// What a sample counts for pixel number `i`: the sum over the pixel and its neighbours, of which there are none beside the picture.
fn counted(sample: &[[f32; 4]], i: usize, weights: &PixelWeights) -> DVec4 {
    let [width, height] = SIZE.map(|n| n as isize);
    let (x, y) = (i as isize % width, i as isize / width);
    let at = |column: isize, row: isize| {
        let place = row.clamp(0, height - 1) * width + column.clamp(0, width - 1);
        DVec4::from_array(sample[place as usize].map(f64::from))
    };
    let weights = |dx: isize, dy: isize| weights.across[(dx + 1) as usize] * weights.down[(dy + 1) as usize];
    (-1..2)
        .flat_map(|dy| (-1..2).map(move |dx| (dx, dy)))
        .map(|(dx, dy)| at(x + dx, y + dy) * weights(dx, dy))
        .sum()
}

#[test]
fn a_sum_of_one_sample_is_the_single_sample_to_the_bit() {
    let scene = Scene::open("snake").unwrap();
    let view = view(&scene);
    with_device(|device| {
        let mut renderer = renderer(device, &scene);
        let plain = renderer.render_plain(&view, SHOWN.exposure, SHOWN.background).unwrap();
        let one = Sampling { count: 1, seed: 9 };
        assert!(all(&mut renderer, &view, one) == plain);
        let added = renderer
            .draw(&PictureRequest { view: &view, sampling: one, size: SIZE, shown: SHOWN }, &Task::silent())
            .unwrap();
        assert_eq!(added.samples, 1);
        assert!(renderer.read_back().unwrap() == plain);
    });
}

#[test]
fn a_picture_is_the_mean_of_its_samples_each_drawn_alone() {
    let scene = Scene::open("snake").unwrap();
    let view = view(&scene);
    let sampling = Sampling { count: 8, seed: 3 };
    with_device(|device| {
        let mut renderer = renderer(device, &scene);
        let mean = all(&mut renderer, &view, sampling);
        assert!(all(&mut renderer, &view, sampling) == mean, "the second time it is another picture");
        assert!(all(&mut renderer, &view, Sampling { seed: 4, ..sampling }) != mean, "no seed changes it");
        let mut sum = vec![DVec4::ZERO; mean.radiance.len()];
        for index in 0..8 {
            renderer.draw_sample(&view, &sampling.sample(index), SHOWN).unwrap();
            let single = renderer.read_back().unwrap().radiance;
            assert!(difference(&single, &mean.radiance) > 1e-2, "sample {index} is not jittered");
            let weights = sampling.sample(index).weights();
            for (i, sum) in sum.iter_mut().enumerate() {
                *sum += counted(&single, i, &weights) / 8.0;
            }
        }
        let whole: Vec<[f32; 4]> = sum.into_iter().map(|pixel| pixel.as_vec4().to_array()).collect();
        // Eight sums of nine products of 32 bits.
        let found = difference(&mean.radiance, &whole);
        assert!(found < 32.0 * f32::EPSILON, "{found}");
        let partial = mean.radiance.iter().filter(|p| p[3] > 0.0 && p[3] < 1.0).count();
        assert!(partial > 20, "only {partial} pixels lie on edges");
        // The display is the twin's, at edges too.
        let twin = displayed(&mean.radiance, SHOWN);
        for (code, expected) in mean.display.iter().zip(&twin) {
            assert!((0..4).all(|c| code[c].abs_diff(expected[c]) <= 1), "{code:?}, expected {expected:?}");
        }
        // So it is by another tone.
        let neutral = Shown { tone: Tone::Neutral, ..SHOWN };
        let shown = renderer.render(&view, &sampling, neutral, &Task::silent()).unwrap().display;
        for (code, expected) in shown.iter().zip(&displayed(&mean.radiance, neutral)) {
            assert!((0..4).all(|c| code[c].abs_diff(expected[c]) <= 1), "{code:?}, expected {expected:?}");
        }
        assert!(shown != mean.display);
        let bare = displayed(&[[0.0; 4]], SHOWN)[0];
        let uncovered = mean.radiance.iter().zip(&mean.display).filter(|(p, _)| p[3] == 0.0);
        assert!(uncovered.into_iter().all(|(_, code)| *code == bare));
    });
}

#[test]
fn samples_start_anew_when_anything_changes_and_go_on_after_one_that_was_given_up() {
    let scene = Scene::open("sphere").unwrap();
    let (view, sampling) = (view(&scene), Sampling { count: 4, seed: 1 });
    let mut other = view.clone();
    other.camera.phi += 0.2;
    with_device(|device| {
        let (mut fresh, mut renderer) = (renderer(device, &scene), renderer(device, &scene));
        let expected = [all(&mut fresh, &view, sampling), all(&mut fresh, &other, sampling)];
        let add = |renderer: &mut Renderer, view: &View, sampling: &Sampling, go_on: bool| {
            renderer
                .draw(
                    &PictureRequest { view, sampling: *sampling, size: SIZE, shown: SHOWN },
                    &Task::while_true(move |_| go_on),
                )
                .map(|progress| progress.samples)
                .map_err(|e| e.kind())
        };
        assert_eq!(add(&mut renderer, &view, &sampling, true), Ok(1));
        assert_eq!(add(&mut renderer, &view, &sampling, true), Ok(2));
        assert_eq!(add(&mut renderer, &view, &sampling, false), Err(ErrorKind::Cancelled));
        // Neither another picture nor a look at directions disturbs the sum.
        renderer.draw_plain(&other, 0.0, DVec3::ZERO).unwrap();
        renderer.directions(&other, 0).unwrap();
        assert_eq!(add(&mut renderer, &view, &sampling, true), Ok(3));
        assert_eq!(add(&mut renderer, &view, &sampling, true), Ok(4));
        assert!(renderer.read_back().unwrap() == expected[0]);
        assert_eq!(add(&mut renderer, &view, &sampling, true), Ok(4), "there are no more");
        assert!(renderer.read_back().unwrap() == expected[0]);
        assert!(renderer.display(SIZE, Shown { exposure: SHOWN.exposure + 1.0, ..SHOWN }).unwrap());
        let brighter = renderer.read_back().unwrap();
        assert!(brighter.radiance == expected[0].radiance && brighter.display != expected[0].display);

        let seeded = Sampling { seed: 2, ..sampling };
        for (view, sampling) in [(&other, &sampling), (&other, &seeded), (&other, &sampling)] {
            assert_eq!(add(&mut renderer, view, sampling, true), Ok(1), "it does not start anew");
        }
        for _ in 1..4 {
            add(&mut renderer, &other, &sampling, true).unwrap();
        }
        assert!(renderer.read_back().unwrap() == expected[1]);
        renderer.resize([24, 18]).unwrap();
        renderer.resize(SIZE).unwrap();
        assert_eq!(add(&mut renderer, &other, &sampling, true), Ok(1), "another size keeps a sum");
    });
}

#[test]
fn the_first_samples_of_a_mean_that_are_given_up_leave_no_picture_for_read_back() {
    let scene = Scene::open("sphere").unwrap();
    let (view, sampling) = (view(&scene), Sampling { count: 4, seed: 1 });
    with_device(|device| {
        let mut renderer = renderer(device, &scene);
        renderer.draw(&PictureRequest::one_sample(&view, SIZE, SHOWN), &Task::silent()).unwrap();
        assert!(renderer.has_picture());
        let pieces = AtomicUsize::new(0);
        let request = PictureRequest { view: &view, sampling, size: SIZE, shown: SHOWN };
        let one_piece = Task::while_true(move |_| pieces.fetch_add(1, Ordering::Relaxed) < 1);
        let given_up = renderer.draw(&request, &one_piece);
        assert!(given_up.is_err_and(|e| e.is_cancelled()), "one piece is all samples");
        assert!(!renderer.has_picture());
        renderer.draw(&request, &Task::silent()).unwrap();
        assert!(renderer.has_picture());
    });
}

#[test]
fn sample_after_sample_the_device_holds_the_same() {
    let scene = Scene::open("sphere").unwrap();
    let (view, sampling) = (view(&scene), Sampling { count: 64, seed: 1 });
    with_device(|device| {
        let mut renderer = renderer(device, &scene);
        renderer
            .draw(&PictureRequest { view: &view, sampling, size: SIZE, shown: SHOWN }, &Task::silent())
            .unwrap();
        let before = device.memory_in_use();
        for _ in 1..64 {
            renderer
                .draw(&PictureRequest { view: &view, sampling, size: SIZE, shown: SHOWN }, &Task::silent())
                .unwrap();
            assert_eq!(device.memory_in_use(), before);
        }
    });
}

/// Part of the pixel filter of one axis below `x`: of the quadratic B-spline to the part `spline`, and else of the box.
fn filter_below(x: f64, spline: f64) -> f64 {
    let of_spline = match x {
        _ if x <= -1.5 => 0.0,
        _ if x <= -0.5 => (x + 1.5).powi(3) / 6.0,
        _ if x <= 0.5 => 0.5 + 0.75 * x - x.powi(3) / 3.0,
        _ if x <= 1.5 => 1.0 - (1.5 - x).powi(3) / 6.0,
        _ => 1.0,
    };
    spline * of_spline + (1.0 - spline) * (x + 0.5).clamp(0.0, 1.0)
}

/// Part of the filter of a pixel that lies on one side of a line at the distance `d` from its middle, whose unit normal is `normal`.
fn filter_beside_a_line(d: f64, normal: DVec2, spline: f64) -> f64 {
    const STEPS: u32 = 600;
    let normal = normal.abs();
    let (across, along) = (normal.max_element(), normal.min_element());
    let h = 3.0 / f64::from(STEPS);
    let slice = |i: u32| {
        let y = -1.5 + f64::from(i) * h;
        let share = filter_below(y + h, spline) - filter_below(y, spline);
        share * filter_below((d - along * (y + h / 2.0)) / across, spline)
    };
    (0..STEPS).map(slice).sum()
}

#[test]
fn coverage_beside_a_straight_edge_is_that_of_the_filter() {
    let scene = Scene::open("plate").unwrap();
    let mut view = view(&scene);
    // On the plate's edge x = 1/2, askew in the picture, whose other edges are outside.
    view.camera =
        Camera::looking(Vec3::new(0.45, -0.2, 0.9), Vec3::new(0.5, 0.03, 0.0), Lens::perspective(0.5))
            .unwrap();
    let clip = view.clip_from_world(SIZE).as_dmat4();
    let pixel = |y: f64| {
        let place = clip.project_point3(DVec3::new(0.5, y, 0.0));
        DVec2::new((place.x + 1.0) / 2.0 * f64::from(SIZE[0]), (place.y + 1.0) / 2.0 * f64::from(SIZE[1]))
    };
    let (start, along) = (pixel(-0.1), (pixel(0.1) - pixel(-0.1)).normalize());
    let exact = |i: usize, sampling: Sampling| {
        // What the footprint leaves of the variance of 1/4 pixel², between the box's 1/12 and the spline's.
        let spline = 1.0 - 6.0 * sampling.footprint().powi(2);
        let place = DVec2::new((i % SIZE[0] as usize) as f64 + 0.5, (i / SIZE[0] as usize) as f64 + 0.5);
        filter_beside_a_line((place - start).perp_dot(along), along, spline)
    };
    with_device(|device| {
        let mut renderer = renderer(device, &scene);
        let mut former = f64::INFINITY;
        for count in [16u32, 64, 256, 1024] {
            let sampling = Sampling { count, seed: 5 };
            let picture = all(&mut renderer, &view, sampling);
            let covered = picture.radiance[SIZE[0] as usize * 18];
            assert_eq!(covered[3], 1.0, "the plate is to the left");
            let error = |(i, p): (usize, &[f32; 4])| (f64::from(p[3]) - exact(i, sampling)).abs();
            let error = picture.radiance.iter().enumerate().map(error);
            let worst = error.fold(0.0, f64::max);
            eprintln!("coverage by {count} samples: within {worst:.4}");
            // What random samples reach in the mean over pixels is ½/√N at an edge's middle; stratified ones keep it everywhere.
            assert!(worst < 1.0 / f64::from(count).sqrt(), "{count}: {worst}");
            assert!(worst < former, "{count} samples are no better: {worst}");
            former = worst;
        }
    });
}

#[test]
fn footprints_are_the_differences_of_directions() {
    let lights: Vec<_> = [(40.0, -30.0), (20.0, 100.0), (60.0, 10.0), (30.0, 200.0)]
        .map(|(theta, phi)| Light::point(theta, phi, 1.0))
        .to_vec();
    with_device(|device| {
        for (name, count, tolerance) in [("plate", 4, 2e-5), ("plate", 1, 2e-5), ("sphere", 3, 2e-2)] {
            let scene = Scene::open(name).unwrap();
            let view = View::of(&scene, lights[..count].to_vec());
            let mut renderer = renderer(device, &scene);
            let plain = renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap();
            renderer.directions(&view, count - 1).unwrap();
            assert!(
                renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap() == plain,
                "{name}: shading is disturbed"
            );
            let mut errors = Vec::new();
            for light in 0..count {
                let seen = renderer.directions(&view, light).unwrap();
                let uv = |i: usize| {
                    let at = |v: &[f32; 4]| DVec2::new(v[0].into(), v[1].into());
                    (seen.view[i][3] == 1.0).then(|| -(at(&seen.light[i]) + at(&seen.view[i])))
                };
                for i in 0..seen.view.len() {
                    let found = seen.footprints[i].map(f64::from);
                    assert!(found.iter().all(|x| x.abs() <= 4.0), "{name}: {found:?}");
                    if uv(i).is_none() {
                        assert_eq!(found, [0.0; 4]);
                    }
                    // The partner in the quad of 2 × 2 pixels.
                    let (x, y, width) = (i % SIZE[0] as usize, i / SIZE[0] as usize, SIZE[0] as usize);
                    let pairs = [[i - x % 2, i - x % 2 + 1], [i - y % 2 * width, i + (1 - y % 2) * width]];
                    for (axis, [from, to]) in pairs.into_iter().enumerate() {
                        let (Some(from), Some(to)) = (uv(from), uv(to)) else { continue };
                        let found = DVec2::new(found[2 * axis], found[2 * axis + 1]);
                        errors.push((found - (to - from)).length());
                    }
                }
            }
            errors.sort_by(f64::total_cmp);
            // Beside the edge between two triangles a neighbour's direction is extrapolated: on the plate along its diagonal, on the sphere
            // at every other pixel.
            let share = if name == "plate" { 0.9 } else { 0.5 };
            let error = errors[((errors.len() - 1) as f64 * share) as usize];
            eprintln!("footprints of the {name} under {count} lights: within {error:.1e}");
            assert!(errors.len() > 500 * count && error < tolerance, "{name}: {error:e}");
        }
    });
}

#[test]
fn footprints_of_a_sphere_are_those_of_exact_normals() {
    let scene = Scene::open("sphere").unwrap();
    let light = Light::point(35.0, -50.0, 1.0);
    let view = View::of(&scene, vec![light.clone()]);
    let clip = view.clip_from_world(SIZE).as_dmat4().inverse();
    let eye = view.camera.eye().as_dvec3();
    let to_light = light.emitter.from_afar(&view.room()).direction().as_dvec3();
    // (u, v) at a place of the picture, on the exact unit sphere; T points east.
    let uv = |x: f64, y: f64| {
        let ndc = DVec3::new(2.0 * x / f64::from(SIZE[0]) - 1.0, 2.0 * y / f64::from(SIZE[1]) - 1.0, 0.9);
        let ray = (clip.project_point3(ndc) - eye).normalize();
        let along = -eye.dot(ray);
        let inside = 1.0 - (eye + ray * along).length_squared();
        let normal = (inside > 0.1).then(|| eye + ray * (along - inside.sqrt()))?;
        let east = DVec3::new(-normal.y, normal.x, 0.0).normalize();
        let sum = -(to_light + (eye - normal).normalize());
        Some(DVec2::new(sum.dot(east), sum.dot(normal.cross(east))))
    };
    with_device(|device| {
        let mut renderer = renderer(device, &scene);
        let seen = renderer.directions(&view, 0).unwrap();
        let mut errors = Vec::new();
        for (i, found) in seen.footprints.iter().enumerate().filter(|(i, _)| seen.view[*i][3] == 1.0) {
            let (x, y) = ((i % SIZE[0] as usize) as f64 + 0.5, (i / SIZE[0] as usize) as f64 + 0.5);
            let change = |h: DVec2| Some(uv(x + h.x, y + h.y)? - uv(x - h.x, y - h.y)?);
            let (Some(dx), Some(dy)) = (change(DVec2::X / 2.0), change(DVec2::Y / 2.0)) else { continue };
            let [a, b, c, d] = found.map(f64::from);
            let error = (DVec2::new(a, b) - dx).length() + (DVec2::new(c, d) - dy).length();
            errors.push(error / (dx.length() + dy.length()));
        }
        errors.sort_by(f64::total_cmp);
        let at = |share: f64| errors[((errors.len() - 1) as f64 * share) as usize];
        eprintln!("footprints against exact normals: median {:.3}, p95 {:.3}", at(0.5), at(0.95));
        // A derivative by half a pixel to one side, of directions that are linear over triangles of a few degrees.
        assert!(
            errors.len() > 300 && at(0.5) < 0.05 && at(0.95) < 0.25,
            "{} {} {}",
            errors.len(),
            at(0.5),
            at(0.95)
        );
        let distribution = Distribution::of(&[seen]);
        assert!(distribution.count() > 300 && distribution.minor(0.5) <= distribution.major(0.5));
    });
}

#[test]
fn a_pixel_of_the_plate_shows_as_much_of_it_as_it_covers() {
    let scene = Scene::open("plate").unwrap();
    let mut view = view(&scene);
    // Straight from above, but for the pole's margin: a pixel is a square.
    view.camera = Camera::looking(Vec3::new(0.0, 0.0, 2.0), Vec3::ZERO, Lens::perspective(0.4)).unwrap();
    let side = 2.0 * 2.0 * 0.2f64.tan() / f64::from(SIZE[1]);
    with_device(|device| {
        let mut renderer = renderer(device, &scene);
        let area = median_pixel_area(&mut renderer, &view).unwrap().unwrap();
        assert!((area / (side * side) - 1.0).abs() < 5e-3, "{area} for {}", side * side);
        // From 60° the same pixel shows twice as much. From afar, where all pixels of the plate are seen from 60°.
        let eye = Vec3::new(3f32.sqrt(), 0.0, 1.0) * 20.0;
        view.camera = Camera::looking(eye, Vec3::ZERO, Lens::perspective(0.02)).unwrap();
        let side = 2.0 * 40.0 * 0.01f64.tan() / f64::from(SIZE[1]);
        let area = median_pixel_area(&mut renderer, &view).unwrap().unwrap();
        assert!((area / (2.0 * side * side) - 1.0).abs() < 5e-3, "{area} for {}", 2.0 * side * side);
        view.camera = Camera::looking(eye, eye * 2.0, Lens::perspective(0.05)).unwrap();
        assert_eq!(median_pixel_area(&mut renderer, &view).unwrap(), None);
    });
}

#[test]
fn the_jitter_moves_what_is_seen_and_not_how_it_is_lit() {
    let scene = Scene::open("plate").unwrap();
    let view = view(&scene);
    let whole = Sample { jitter: [2.0, -1.0], ..Sampling::ONE.sample(0) };
    with_device(|device| {
        let mut renderer = renderer(device, &scene);
        let still = renderer.directions(&view, 0).unwrap();
        let moved = renderer.directions_of(&view, 0, &whole).unwrap();
        let mut compared = 0;
        for y in 1..SIZE[1] as usize {
            for x in 0..SIZE[0] as usize - 2 {
                // A jitter of whole pixels to the right and up shows the pixel there.
                let (from, to) = (y * SIZE[0] as usize + x, (y - 1) * SIZE[0] as usize + x + 2);
                if moved.view[from][3] == 1.0 && still.view[to][3] == 1.0 {
                    let [a, b] = [moved.view[from], still.view[to]].map(|v| Vec3::new(v[0], v[1], v[2]));
                    assert!((a - b).length() < 1e-4, "{a} {b}");
                    assert!((0..3).all(|c| (moved.light[from][c] - still.light[to][c]).abs() < 1e-5));
                    compared += 1;
                }
            }
        }
        assert!(compared > 300, "{compared}");
    });
}
