//! Long work that is cancelled from another thread, and what may cross threads.

use crate::device::with_device;
use crate::evaluation::patch;
use diffract::internals::brdf::albedo::{Decimation, DirectionalAlbedo};
use diffract::internals::brdf::mean::MeanBrdf;
use diffract::internals::brdf::tabulated::TabulatedMean;
use diffract::internals::brdf::{Brdf, DirectSum, MeanFromOrders, MeanReference};
use diffract::internals::error::{Error, Result};
use diffract::internals::export::{ExportSettings, ExportedMaterial};
use diffract::internals::measure::profile;
use diffract::internals::optics::coherence::Coherence;
use diffract::internals::optics::geometry::{Pair, direction};
use diffract::internals::optics::reference::Reference;
use diffract::internals::optics::spectrum::Illuminant;
use diffract::internals::render::device_brdf::DeviceBrdf;
use diffract::internals::render::frame::{Shown, View};
use diffract::internals::render::reference_picture::PixelReference;
use diffract::internals::render::renderer::Renderer;
use diffract::internals::render::sampling::Sampling;
use diffract::internals::render::source::{ClassicalGrating, Source};
use diffract::internals::scene::{Light, Scene};
use diffract::internals::settings::Optics;
use diffract::internals::setup::{InUse, PictureSettings, PreparedScene};
use diffract::internals::spectra::power::{Beyond, OrderSeries, PowerSettings};
use diffract::internals::surface::HeightField;
use diffract::internals::surface::synth::SurfaceKind;
use diffract::internals::table::{ColorTable, TableReader, TableSettings, bake};
use diffract::internals::task::Task;
use diffract::internals::vk::device::Device;
use std::sync::mpsc;
use std::thread;
use std::time::{Duration, Instant};

/// Number of directions, enough for minutes of direct sums.
const DIRECTIONS: usize = 20_000;

/// Fails unless `work` ends cancelled when its task is cancelled at its first report, from another thread. Prints the time that it took to end.
fn ends_when_cancelled<T: Send>(name: &str, work: impl FnOnce(&Task) -> Result<T> + Send) {
    let (sender, reports) = mpsc::channel();
    let task = Task::reporting(move |progress| {
        let _ = sender.send(progress); // nobody listens any more after the first one
    });
    thread::scope(|scope| {
        let running = task.clone();
        let worker = scope.spawn(move || work(&running).map(drop));
        reports.recv_timeout(Duration::from_secs(60)).unwrap_or_else(|_| panic!("{name} reports nothing"));
        let cancelled = Instant::now();
        task.cancel();
        let ended = worker.join().unwrap();
        eprintln!("{name} ends {:.3} s after it is cancelled", cancelled.elapsed().as_secs_f64());
        assert!(ended.as_ref().is_err_and(Error::is_cancelled), "{name}: {ended:?}");
    });
}

/// Returns heights that need many terms.
fn rough() -> HeightField {
    let heights = (0..512 * 512).map(|i| 1.5 * (f64::from(i) * 0.618_034).fract()).collect();
    HeightField::new(512, 512, [0.1; 2], heights).unwrap()
}

fn pairs() -> Vec<Pair> {
    let view =
        |i: usize| direction(80.0 * (i as f64 * 0.618_034).fract(), 360.0 * (i as f64 * 0.414_214).fract());
    (0..DIRECTIONS).map(|i| Pair::new(direction(30.0, 0.0), view(i))).collect()
}

#[test]
fn values_tables_and_exports_end_when_they_are_cancelled() {
    let (field, pairs) = (rough(), pairs());
    let mean = MeanBrdf::in_sunlight(&field, 1.5);
    let optics = Optics::default();
    let powers = PowerSettings::new(2.0, Beyond::Copies, 1e-3);
    let low = patch(SurfaceKind::Elaphe, 20.0);
    let series = OrderSeries::new(&low, &powers, &Task::silent()).unwrap();
    ends_when_cancelled("the series of orders", |task| OrderSeries::new(&field, &powers, task));
    ends_when_cancelled("a colour table", |task| {
        bake(&series, &TableSettings::new(Illuminant::D65, 2e-3), task)
    });
    ends_when_cancelled("the limit of energy", |task| {
        DirectionalAlbedo::new(&series, &1.5.into(), Decimation::Fine).make_table(task)
    });
    ends_when_cancelled("the tabulated mean", |task| TabulatedMean::new(mean.clone(), 0.38, task));
    ends_when_cancelled("colours of the mean", |task| {
        MeanFromOrders::new(mean.clone(), Illuminant::D65, 1e-2).xyz(&pairs, task)
    });
    ends_when_cancelled("values of the reference", |task| {
        MeanReference::new(mean.clone(), Illuminant::D65, 0.38).spectral(&pairs[..20], 0.5, task)
    });
    ends_when_cancelled("direct sums", |task| {
        let reference = Reference::new(&field, optics.coherence, [1, 1], 1.5);
        DirectSum { reference, illuminant: Illuminant::D65 }.xyz(&pairs, task)
    });
    ends_when_cancelled("an export", |task| {
        let settings = ExportSettings {
            sigma: 2.0,
            beyond: Beyond::Copies,
            illuminant: Illuminant::D65,
            reflectance: 1.5.into(),
            tolerance: 2e-3,
            wavelengths: None,
            footprint: 0.0,
            most_bytes: None,
        };
        ExportedMaterial::new(&low, &settings, task)
    });
    ends_when_cancelled("a pixel's reference", |task| PixelReference::new(&field, &optics, task));
}

#[test]
fn pictures_and_measurements_end_when_they_are_cancelled() {
    let scene = Scene::open("sphere").unwrap();
    let view = View::of(&scene, vec![Light::point(40.0, -97.0, 1.0)]);
    with_device(|device| {
        let source = Source::ClassicalGrating(ClassicalGrating::default());
        let mut renderer =
            crate::renderer_of(device, &scene, &source, &Optics::default(), [320, 240]).unwrap();
        let sampling = Sampling { count: 1 << 16, seed: 0 };
        let shown = Shown::plain(0.0, glam::DVec3::ZERO);
        ends_when_cancelled("a picture", |task| renderer.render(&view, &sampling, shown, task));
        ends_when_cancelled("a measurement", |task| {
            profile::measure(&mut renderer, &view, usize::MAX, f64::INFINITY, task)
        });
    });
}

#[test]
fn what_a_program_keeps_may_cross_threads() {
    fn crosses<T: Send + Sync + 'static>() {}
    fn moves<T: Send + 'static>() {}
    crosses::<Task>();
    crosses::<Error>();
    crosses::<HeightField>();
    crosses::<Coherence>();
    crosses::<Illuminant>();
    crosses::<MeanBrdf>();
    crosses::<MeanFromOrders>();
    crosses::<MeanReference>();
    crosses::<Reference>();
    crosses::<DirectSum>();
    crosses::<DeviceBrdf>();
    crosses::<Box<dyn Brdf>>();
    crosses::<TabulatedMean>();
    crosses::<PixelReference>();
    crosses::<OrderSeries>();
    crosses::<ColorTable>();
    crosses::<TableReader>();
    crosses::<Scene>();
    crosses::<View>();
    crosses::<Source>();
    crosses::<Device>();
    crosses::<PictureSettings>();
    crosses::<ExportedMaterial>();
    crosses::<InUse>();
    moves::<Renderer>();
    moves::<PreparedScene>();
}
