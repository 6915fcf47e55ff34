//! The display pass against its f64 twin.

use crate::device::with_device;
use crate::evaluation::{layers, optics, patch, window};
use diffract::internals::optics::color::{Tone, display, display_over};
use diffract::internals::render::frame::{Shown, View};
use diffract::internals::render::sampling::Sampling;
use diffract::internals::scene::Scene;
use diffract::internals::surface::synth::SurfaceKind;
use glam::DVec3;

const SIZE: [u32; 2] = [160, 120];

#[test]
fn the_displayed_picture_is_the_twin_s_within_one_code() {
    let field = patch(SurfaceKind::Elaphe, 6.0);
    let scene = Scene::open("snake").unwrap();
    let view = View::of(&scene, scene.lights.clone());
    let optics = optics(16.0, 1e-1);
    let background = DVec3::new(0.1, 0.2, 0.3);
    with_device(|device| {
        let layers = layers(&field, &optics);
        let mut renderer = crate::renderer_of(device, &scene, &window(&layers), &optics, SIZE).unwrap();
        let shows = |exposure, tone| Shown { exposure, tone, background };
        let one = Sampling::ONE.sample(0);
        for (exposure, tone) in
            [-3.0, 0.0, 2.5, 6.0].into_iter().flat_map(|ev| Tone::ALL.map(|tone| (ev, tone)))
        {
            renderer.draw_sample(&view, &one, shows(exposure, tone)).unwrap();
            let picture = renderer.read_back().unwrap();
            let mut differing = 0;
            for (linear, code) in picture.radiance.iter().zip(&picture.display) {
                let [r, g, b, alpha] = linear.map(f64::from);
                let expected = match (alpha > 0.0, tone) {
                    (false, _) => display(background, 0.0),
                    (true, Tone::None) => display(DVec3::new(r, g, b), exposure),
                    (true, tone) => display_over(DVec3::new(r, g, b), exposure, tone, 1.0, background),
                };
                for (a, b) in code[..3].iter().zip(expected) {
                    // f32 against f64 may round to the neighbouring code, now and then.
                    assert!(a.abs_diff(b) <= 1, "{code:?} for {linear:?}, expected {expected:?}");
                    differing += usize::from(*a != b);
                }
            }
            assert!(
                differing < picture.display.len() / 50,
                "{differing} codes differ at exposure {exposure} by {tone:?}"
            );
        }
        // The twin is not indifferent: another exposure gives another picture.
        let (dark, bright) = (
            renderer.render_plain(&view, -3.0, background).unwrap(),
            renderer.render_plain(&view, 0.0, background).unwrap(),
        );
        assert!(dark.display != bright.display && dark.radiance == bright.radiance);
        // Neither is it to the tone, and what is on the device needs no drawing to be displayed by another.
        assert!(renderer.display(SIZE, shows(0.0, Tone::Neutral)).unwrap());
        let neutral = renderer.read_back().unwrap();
        assert!(neutral.display != bright.display && neutral.radiance == bright.radiance);
        assert!(renderer.display(SIZE, shows(0.0, Tone::None)).unwrap());
        assert!(renderer.read_back().unwrap() == bright);
    });
}
