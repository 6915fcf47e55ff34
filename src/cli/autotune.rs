//! Autotuning: the most accurate setting that keeps a frame rate, found by timing each candidate.

use super::benchmark::{BenchmarkOptions, BenchmarkScene, is_impossible};
use super::remedies::in_options;
use crate::error::{Error, Result};
use crate::measure::profile::measure;
use crate::optics::coherence::Windows;
use crate::settings::Method;
use crate::spectra::amplitude::expansion::Basis;
use crate::task::Task;

/// Candidates without --tolerance, the most accurate of each method first. Tables of smaller tolerances do not fit usual devices.
const CANDIDATES: [(Method, f64); 7] = [
    (Method::Spectral, 1e-3),
    (Method::Spectral, 1e-2),
    (Method::Spectral, 1e-1),
    (Method::Table, 1e-2),
    (Method::Table, 2e-2),
    (Method::Table, 5e-2),
    (Method::Table, 1e-1),
];
/// Number of timed frames of a candidate; no frame is begun after this many seconds.
const FRAMES: usize = 5;
const SECONDS: f64 = 1.0;

/// The result of autotuning.
pub struct TunedSetting {
    /// The options of the setting.
    pub options: BenchmarkOptions,
    /// Command line options of the setting.
    pub flags: String,
    /// True if the setting keeps the frame rate; otherwise it is the fastest candidate.
    pub keeps: bool,
}

/// Finds the most accurate setting that draws `fps` frames a second of `scene`. Method, basis and tolerance that `options` name are kept.
/// Reports each candidate on stderr.
///
/// # Errors
/// No candidate that can be drawn.
pub fn tune(fps: f64, scene: &BenchmarkScene, options: &BenchmarkOptions) -> Result<TunedSetting> {
    let mut fastest: Option<(f64, TunedSetting)> = None;
    let mut refused = None;
    for options in candidates(options) {
        let flags = flags(&options);
        let rate = match frame_rate(scene, &options) {
            Ok(rate) => rate,
            Err(error) if is_impossible(&error) => {
                scene.console.say(&format_args!("{flags}: not possible here ({})", in_options(&error)));
                refused = Some(error);
                continue;
            }
            Err(error) => return Err(error),
        };
        scene.console.say(&format_args!("{flags}: {rate:.2} frames a second"));
        let setting = TunedSetting { options, flags, keeps: rate >= fps };
        if setting.keeps {
            return Ok(setting);
        }
        if fastest.as_ref().is_none_or(|(best, _)| rate > *best) {
            fastest = Some((rate, setting));
        }
    }
    let none = || Error::usage("--fps leaves no setting to choose", "name fewer of method and tolerance");
    fastest.map(|(_, setting)| setting).ok_or_else(|| refused.unwrap_or_else(none))
}

/// Returns the candidates, the most accurate first.
fn candidates(options: &BenchmarkOptions) -> Vec<BenchmarkOptions> {
    let optics = &options.optics;
    let settings: Vec<(Method, f64)> = match optics.tolerance {
        Some(tolerance) => [Method::Spectral, Method::Table].map(|method| (method, tolerance)).to_vec(),
        None => CANDIDATES.to_vec(),
    };
    // Tables hold the mean over all windows, and bases are of one window.
    let mean = optics.windows() == Windows::All;
    let method = optics.picture_method();
    let with = |(method, tolerance)| {
        let mut tried = options.clone();
        tried.optics.method = Some(method);
        tried.optics.tolerance = Some(tolerance);
        tried.optics.basis = optics.basis.or((!mean).then_some(Basis::Optimal));
        tried
    };
    settings.into_iter().filter(|(known, _)| *known == method).map(with).collect()
}

/// Measures the frames a second of a setting.
fn frame_rate(scene: &BenchmarkScene, options: &BenchmarkOptions) -> Result<f64> {
    let mut renderer = scene.prepare(options)?.renderer;
    let times = measure(&mut renderer, &scene.view, FRAMES, SECONDS, &Task::silent())?;
    Ok(1e3 / times.frame.p50)
}

/// Returns a setting as command line options.
fn flags(options: &BenchmarkOptions) -> String {
    let tolerance = format!("--tolerance {:e}", options.optics.tolerance());
    match (options.optics.method(), options.optics.basis) {
        (Method::Spectral, Some(basis)) => format!("--method spectral --basis {} {tolerance}", basis.name()),
        (Method::Spectral, None) => format!("--method spectral {tolerance}"),
        _ => format!("--method table {tolerance}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser, Debug)]
    struct CommandLine {
        #[command(flatten)]
        options: BenchmarkOptions,
    }

    fn tried(flags: &str) -> Vec<String> {
        let words = std::iter::once("profile").chain(flags.split_whitespace());
        candidates(&CommandLine::try_parse_from(words).unwrap().options).iter().map(super::flags).collect()
    }

    #[test]
    fn what_is_named_is_kept_and_the_rest_goes_from_fine_to_coarse() {
        let all = tried("");
        assert_eq!(all[0], "--method table --tolerance 1e-2");
        assert_eq!(all.last().unwrap(), "--method table --tolerance 1e-1");
        assert!(tried("--method table").iter().all(|flags| flags.starts_with("--method table")));
        let taylor = tried("--windows 1x1 --basis taylor");
        assert!(taylor.iter().all(|flags| flags.starts_with("--method spectral --basis taylor")));
        assert_eq!(tried("--tolerance 3e-2"), ["--method table --tolerance 3e-2"]);
        assert_eq!(
            tried("--windows 1x1 --tolerance 3e-2"),
            ["--method spectral --basis optimal --tolerance 3e-2"]
        );
        assert_eq!(tried("--tolerance 3e-2 --method table"), ["--method table --tolerance 3e-2"]);
    }
}
