//! The report of `profile`, as text and as JSON.

use crate::cli::benchmark::{Benchmark, BenchmarkScene, MORE_SAMPLES, PictureErrors};
use crate::measure::budget::MeasuredBudget;
use crate::measure::error::PixelErrors;
use crate::measure::profile::{Bound, NOISY, Rates, TimeSummary, Times};
use serde::Serialize;

/// Lowest and highest frame rate of the thesis' shader on the GPU of its day [1/s].
const THESIS_FPS: [f64; 2] = [5.0, 15.0];
/// Width of the names in the text.
const NAME_WIDTH: usize = 26;

/// Report; its fields are those of the JSON.
#[derive(Serialize)]
pub struct ProfileReport {
    device: String,
    driver: String,
    size: [u32; 2],
    method: &'static str,
    basis: &'static str,
    tolerance: f64,
    terms: usize,
    layers: usize,
    kernel: String,
    wavelengths: f64,
    covered: f64,
    gpu_ms: TimeSummary,
    geometry_ms: TimeSummary,
    shade_ms: TimeSummary,
    display_ms: TimeSummary,
    record_ms: TimeSummary,
    frame_ms: TimeSummary,
    fps: f64,
    samples_per_covered_pixel: f64,
    sample_rate: f64,
    scattered_sample_rate: f64,
    sample_rate_fraction: f64,
    bound_by: Bound,
    spread: f64,
    noisy: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<PixelErrors>,
    #[serde(skip_serializing_if = "Option::is_none")]
    geometry: Option<PixelErrors>,
    #[serde(skip_serializing_if = "Option::is_none")]
    whole: Option<PixelErrors>,
    #[serde(skip_serializing_if = "Option::is_none")]
    flip: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    sampling_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    promised: Option<f64>,
    budget: MeasuredBudget,
}

impl ProfileReport {
    /// Returns the report of frames of `benchmark` that took `times`, on a device that reads at `rates`.
    pub fn new(
        scene: &BenchmarkScene,
        benchmark: Benchmark,
        times: &Times,
        rates: &Rates,
        errors: PictureErrors,
    ) -> Self {
        let candidate = scene.device.candidate();
        let Benchmark { optics, summary, cost, budget, .. } = benchmark;
        let reached = cost.samples as f64 / (times.shade.p50 * 1e-3);
        Self {
            device: candidate.name.clone(),
            driver: candidate.driver.clone(),
            size: scene.size,
            method: summary.method,
            basis: summary.basis.map_or("none", crate::spectra::amplitude::expansion::Basis::name),
            tolerance: optics.tolerance,
            terms: summary.terms,
            layers: summary.layers,
            kernel: summary.kernel,
            wavelengths: cost.wavelengths_per_pixel(),
            covered: cost.covered as f64 / scene.pixels() as f64,
            gpu_ms: times.gpu,
            geometry_ms: times.geometry,
            shade_ms: times.shade,
            display_ms: times.display,
            record_ms: times.record,
            frame_ms: times.frame,
            fps: 1e3 / times.frame.p50,
            samples_per_covered_pixel: cost.samples_per_pixel(),
            sample_rate: rates.coherent,
            scattered_sample_rate: rates.scattered,
            sample_rate_fraction: reached / rates.coherent,
            bound_by: Bound::of(times, cost.samples, rates),
            spread: times.spread,
            noisy: times.spread > NOISY,
            error: errors.pixels,
            geometry: errors.geometry,
            whole: errors.whole,
            flip: errors.flip,
            sampling_error: errors.sampling,
            promised: optics.promised_of_one_sample(),
            budget,
        }
    }

    /// Returns the report as text, one line per subject.
    pub fn text(&self) -> String {
        let mut text = line("device", &format!("{}, {}", self.device, self.driver));
        let [width, height] = self.size;
        text += &line("picture", &format!("{width} x {height}, {:.1} % covered", self.covered * 100.0));
        text += &line("setting", &self.setting());
        text += &self.times();
        text += &line("frames a second", &format!("{:.2}, {}", self.fps, self.verdict()));
        text += &line("samples", &format!("{:.0} a covered pixel", self.samples_per_covered_pixel));
        text += &line("sample rate", &self.sample_rates());
        text += &line("bound by", self.bound_by.description());
        for (name, error, against) in [
            ("error of shading", &self.error, "f64 for the same directions"),
            ("error of geometry", &self.geometry, "rays cast in f64"),
            ("error of the whole", &self.whole, "f64 for these rays"),
        ] {
            text += &error.as_ref().map_or_else(String::new, |error| line(name, &error_text(error, against)));
        }
        if let (Some(error), Some(promised)) = (&self.error, self.promised) {
            let is_kept = if error.exceeds(promised) { "NOT kept" } else { "kept" };
            text += &line("promise", &format!("{is_kept}: shading of one sample within {promised:.0e}"));
        }
        if let Some(sampling) = self.sampling_error {
            let change = format!("{sampling:.1e} relative L2 between one sample a pixel and {MORE_SAMPLES}");
            text += &line("error of sampling", &change);
        }
        if let Some(flip) = self.flip {
            text += &line("seen", &format!("FLIP {flip:.1e} (0 is no visible difference, 1 the largest)"));
        }
        if self.noisy {
            let warning = format!(
                "too noisy to tell: the medians of three parts of the series differ by a factor of {:.2}",
                self.spread
            );
            text += &line("warning", &warning);
        }
        text
    }

    /// Returns the error budget, with the measured error if there is one.
    pub fn budget_text(&self) -> String {
        let measured = match &self.error {
            Some(e) => {
                format!("{:.1e} ± {:.0e} over {} pixels", e.relative_l2, e.relative_l2_interval, e.pixels)
            }
            None => "not asked for: --error 2000".to_owned(),
        };
        self.budget.to_text() + &line("measured", &measured)
    }

    fn setting(&self) -> String {
        let Self { method, basis, terms, layers, kernel, wavelengths, tolerance, .. } = self;
        if *method == "table" {
            return format!("table, {layers} layers, {kernel}, tolerance {tolerance:.0e}");
        }
        format!(
            "{method}, {basis}, {terms} terms in {layers} layers, {kernel}, {wavelengths:.1} wavelengths a covered pixel, \
             tolerance {tolerance:.0e}"
        )
    }

    fn times(&self) -> String {
        let ms = |s: &TimeSummary| format!("{:.1} / {:.1} / {:.1} / {:.1} ms", s.min, s.p50, s.p95, s.max);
        [
            ("frame (min/p50/p95/max)", &self.frame_ms),
            ("device: mesh", &self.geometry_ms),
            ("device: shading", &self.shade_ms),
            ("device: display", &self.display_ms),
            ("CPU: recording", &self.record_ms),
        ]
        .map(|(name, summary)| line(name, &ms(summary)))
        .concat()
    }

    fn verdict(&self) -> &'static str {
        let [low, high] = THESIS_FPS;
        match self.fps {
            fps if fps < low => "below the 5 to 15 fps of the thesis",
            fps if fps <= high => "within the 5 to 15 fps of the thesis",
            _ => "above the 5 to 15 fps of the thesis",
        }
    }

    fn sample_rates(&self) -> String {
        let mega = |rate: f64| rate * 1e-6;
        format!(
            "{:.0} M/s are possible here side by side, {:.0} M/s scattered; the frame reaches {:.0} M/s, {:.0} % of the first",
            mega(self.sample_rate),
            mega(self.scattered_sample_rate),
            mega(self.sample_rate * self.sample_rate_fraction),
            self.sample_rate_fraction * 100.0
        )
    }
}

/// Describes `errors` of a picture.
fn error_text(errors: &PixelErrors, against: &str) -> String {
    let PixelErrors { pixels, relative_l2, relative_l2_interval, p99, .. } = errors;
    format!(
        "{relative_l2:.1e} ± {relative_l2_interval:.0e} relative L2, 99 % of pixels within {p99:.1e} of their own value \
         ({pixels} pixels against {against})"
    )
}

/// Returns a line of the report.
fn line(name: &str, value: &str) -> String {
    format!("{name:<NAME_WIDTH$}{value}\n")
}
