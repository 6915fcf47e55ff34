//! The setting that keeps a frame rate: the most accurate one that does, found by drawing, not by guessing.

use super::profile::Arguments;
use super::say;
use super::stage::Stage;
use crate::error::{Error, Result};
use crate::expansion::Basis;
use crate::measure::profile::measure;
use crate::setup::Method;

/// From the finest to the coarsest where no tolerance is named. Tables begin where they fit a usual device.
const LADDER: [(Method, f64); 6] = [
    (Method::Spectral, 1e-3),
    (Method::Spectral, 1e-2),
    (Method::Table, 1e-2),
    (Method::Table, 2e-2),
    (Method::Spectral, 1e-1),
    (Method::Table, 1e-1),
];
/// Frames that a setting is tried with, and the seconds beyond which no more are drawn.
const FRAMES: usize = 5;
const SECONDS: f64 = 1.0;

/// What was found.
pub struct Choice {
    /// The arguments of the setting.
    pub arguments: Arguments,
    /// The options to type for it.
    pub flags: String,
    /// Whether it keeps the rate; else it is the fastest there was.
    pub keeps: bool,
}

/// The most accurate setting of `arguments`' scene that draws `fps` frames a second on the device of `stage`. What is named stays:
/// method, basis and tolerance are chosen where they are not. Each setting that is tried is said.
///
/// # Errors
/// Where none can be drawn.
pub fn keeping(fps: f64, stage: &Stage, arguments: &Arguments) -> Result<Choice> {
    let mut fastest: Option<(f64, Choice)> = None;
    let mut refused = None;
    for own in candidates(arguments) {
        let flags = flags(&own);
        let rate = match rate(stage, &own) {
            Ok(rate) => rate,
            Err(error) => {
                say(&format_args!("{flags}: not possible here ({error})"));
                refused = Some(error);
                continue;
            }
        };
        say(&format_args!("{flags}: {rate:.2} frames a second"));
        let choice = Choice { arguments: own, flags, keeps: rate >= fps };
        if choice.keeps {
            return Ok(choice);
        }
        if fastest.as_ref().is_none_or(|(best, _)| rate > *best) {
            fastest = Some((rate, choice));
        }
    }
    let none = || Error::usage("--fps leaves no setting to choose", "name fewer of method and tolerance");
    fastest.map(|(_, choice)| choice).ok_or_else(|| refused.unwrap_or_else(none))
}

/// The settings to try, the most accurate first.
fn candidates(arguments: &Arguments) -> Vec<Arguments> {
    let optics = &arguments.optics;
    let rungs: Vec<(Method, f64)> = match optics.tolerance {
        Some(tolerance) => [Method::Spectral, Method::Table].map(|method| (method, tolerance)).to_vec(),
        None => LADDER.to_vec(),
    };
    // What names a part of the sum over layers asks for it.
    let spectral = optics.basis.is_some() || optics.terms.is_some();
    let wanted = |method: Method| match optics.method {
        Some(named) => named == method,
        None => !spectral || method == Method::Spectral,
    };
    let with = |(method, tolerance)| {
        let mut own = arguments.clone();
        own.optics.method = Some(method);
        own.optics.tolerance = Some(tolerance);
        own.optics.basis = optics.basis.or((method == Method::Spectral).then_some(Basis::Optimal));
        own
    };
    rungs.into_iter().filter(|(method, _)| wanted(*method)).map(with).collect()
}

/// Frames a second of a setting.
fn rate(stage: &Stage, own: &Arguments) -> Result<f64> {
    let shading = own.optics.for_pictures(&own.colour)?;
    let mut ready = stage.prepare(own, &shading)?;
    let times = measure(&mut ready.painter, &stage.view, FRAMES, SECONDS, &|_, _| Ok(()))?;
    Ok(1e3 / times.frame.p50)
}

/// A setting as it is typed.
fn flags(own: &Arguments) -> String {
    let tolerance = format!("--tolerance {:e}", own.optics.tolerance());
    match (own.optics.method(), own.optics.basis) {
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
    struct Words {
        #[command(flatten)]
        profile: Arguments,
    }

    fn tried(words: &str) -> Vec<String> {
        let words =
            Words::try_parse_from(std::iter::once("profile").chain(words.split_whitespace())).unwrap();
        candidates(&words.profile).iter().map(flags).collect()
    }

    #[test]
    fn what_is_named_is_kept_and_the_rest_goes_from_fine_to_coarse() {
        let all = tried("");
        assert_eq!(all[0], "--method spectral --basis optimal --tolerance 1e-3");
        assert_eq!(all.last().unwrap(), "--method table --tolerance 1e-1");
        assert!(tried("--method table").iter().all(|flags| flags.starts_with("--method table")));
        assert!(
            tried("--basis taylor").iter().all(|flags| flags.starts_with("--method spectral --basis taylor"))
        );
        assert_eq!(
            tried("--tolerance 3e-2"),
            ["--method spectral --basis optimal --tolerance 3e-2", "--method table --tolerance 3e-2"]
        );
        assert_eq!(tried("--tolerance 3e-2 --method table"), ["--method table --tolerance 3e-2"]);
    }
}
