//! What the thesis' own shader sums, drawn to compare with: right where its 3 × 3 bins hold the window's spectrum, wrong by what they
//! leave out where they do not.

use crate::device::with_device;
use crate::evaluation::patch;
use crate::measure::channel;
use crate::shared::Pictured;
use diffract::internals::optics::coherence::{Coherence, Windows};
use diffract::internals::optics::reflectance::Reflectance;
use diffract::internals::optics::spectrum::SHORTEST;
use diffract::internals::optics::theory::Theory;
use diffract::internals::render::frame::View;
use diffract::internals::render::source::{Source, Thesis};
use diffract::internals::scene::{Light, Scene};
use diffract::internals::settings::Optics;
use diffract::internals::spectra::amplitude::thesis;
use diffract::internals::surface::synth::SurfaceKind;
use glam::DVec3;
use std::sync::Arc;

const SIZE: [u32; 2] = [48, 36];

#[test]
fn the_thesis_sum_is_right_where_three_bins_hold_the_window() {
    let scene = Scene::open("sphere").unwrap();
    let view = View::of(&scene, vec![Light::point(45.0, -40.0, 2.0)]);
    with_device(|device| {
        for kind in [SurfaceKind::Elaphe, SurfaceKind::Sinusoid] {
            let field = patch(kind, 7.0);
            let (low, high) = field.range();
            let error = |length: f64| {
                let coherence = Coherence::Gaussian { length };
                let reflectance = Reflectance::default().by(Theory::Stam);
                let optics = Optics { coherence, windows: Windows::ONE, reflectance, ..Optics::default() };
                let optics = optics.for_pictures();
                let layers = Arc::new(thesis::layers(&field, length / 4.0, SHORTEST).unwrap());
                let source = Source::Thesis(Thesis { layers, half_range: (high - low) / 2.0 });
                let mut renderer = crate::renderer_of(device, &scene, &source, &optics, SIZE).unwrap();
                let picture = renderer.render_plain(&view, 0.0, DVec3::ZERO).unwrap();
                let directions = [renderer.directions(&view, 0).unwrap()];
                let exact =
                    Pictured { field: &field, optics: &optics, view: &view, size: SIZE }.by(&directions);
                (0..3).map(|c| channel(&picture.radiance, &exact, c)).fold(0.0, f64::max)
            };
            // The spectrum of a Gaussian of σ = 0.5 T falls to 1.5e-5 at one and a half bins, of σ = 0.25 T to 0.06.
            let (held, cut) = (error(2.0 * 7.0), error(7.0));
            eprintln!("{kind:?}: {held:.4} where three bins hold the window, {cut:.4} where they do not");
            // What is left are steps of 5 nm, which resolve these 14 µm.
            assert!(held < 1e-3, "{kind:?}: {held}");
            assert!(cut > 3.0 * held, "{kind:?}: {cut} beside {held}");
        }
    });
}
