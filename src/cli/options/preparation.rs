//! Options that prepare a height field: one for each kind of [`PreparationStep`], applied in the order of the command line.
//!
//! Derived arguments forget their order, so these are built by hand: each step is parsed as one value of its option, and the indices that
//! clap records put the values of all options in order.

use crate::surface::prepare::{PreparationStep, WORDS};
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};

/// The steps that the command line names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PreparationOptions {
    given: Vec<PreparationStep>,
}

impl PreparationOptions {
    /// Returns the steps in their order, `--level none` left out; `None` if no option names one.
    pub fn steps(&self) -> Option<Vec<PreparationStep>> {
        let all = self.given.iter().copied().filter(|step| !step.is_nothing()).collect();
        (!self.given.is_empty()).then_some(all)
    }
}

/// Returns the options that repeat `steps`: `--level plane --crop 40um`.
#[cfg(any(feature = "viewer", test))]
pub fn as_options(steps: &[PreparationStep]) -> String {
    steps.iter().map(|step| format!("--{step}")).collect::<Vec<_>>().join(" ")
}

/// Returns the help text of a step's option.
fn help(word: &str) -> &'static str {
    match word {
        "level" => {
            "Subtract the mean, a plane, a polynomial, each row's mean or median, or the tilt that most facets share"
        }
        "despike" => "Replace single samples that stand far out of their neighbours",
        "destripe" => "Replace streaks along rows by what is above and below",
        "deconvolve-tip" => {
            "Take away what a probe's tip of this radius added to the scan, as in 10nm, where the tip touched the surface"
        }
        "crop" => {
            "Keep a rectangle, from the middle or with a corner from the left and from the top, as in 40um or 40umx20um+5um+3um"
        }
        "resample" => "Change the distance between samples, as in 50nm or 50nmx80nm",
        "rotate" => {
            "Turn counter-clockwise by an angle, as in 12.5deg, or until the grooves are parallel to an axis"
        }
        "taper" => "Let the heights fade to their mean over this length at each edge",
        "tile" => "Make the edges meet: by mirror images, or by blending each edge into the opposite one",
        _ => "Turn hills into valleys: the mould of the surface",
    }
}

/// Steps that most scans need.
const USUAL: [&str; 2] = ["level", "crop"];

/// Returns the option of a step.
fn option(word: &'static str, value: &'static str) -> Arg {
    let parse = move |text: &str| PreparationStep::from_option(word, text);
    let arg = Arg::new(word)
        .long(word)
        .help(help(word))
        .help_heading("Preparing the surface, in the order given")
        .action(ArgAction::Append)
        .hide_short_help(!USUAL.contains(&word))
        .value_parser(parse);
    if value.is_empty() {
        return arg.num_args(0).default_missing_value("");
    }
    arg.value_name(value).allow_hyphen_values(true)
}

impl Args for PreparationOptions {
    fn augment_args(command: Command) -> Command {
        command.args(WORDS.map(|(word, value)| option(word, value)))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for PreparationOptions {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut placed: Vec<(usize, PreparationStep)> = Vec::new();
        for (word, _) in WORDS {
            let places = matches.indices_of(word).into_iter().flatten();
            placed
                .extend(places.zip(matches.get_many::<PreparationStep>(word).into_iter().flatten().copied()));
        }
        placed.sort_by_key(|(place, _)| *place);
        Ok(Self { given: placed.into_iter().map(|(_, step)| step).collect() })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::prepare;

    fn parsed(line: &str) -> Result<Option<Vec<PreparationStep>>, clap::Error> {
        let command = PreparationOptions::augment_args(Command::new("test"));
        let matches = command.try_get_matches_from(["test"].into_iter().chain(line.split_whitespace()))?;
        Ok(PreparationOptions::from_arg_matches(&matches)?.steps())
    }

    #[test]
    fn steps_keep_the_order_of_the_command_line_whatever_their_options() {
        for line in [
            "--crop 40um --level plane --invert --level rows --despike --rotate -12.5deg --despike",
            "--invert --taper 5um --tile blend --destripe --deconvolve-tip 10nm --resample 50nm --crop 20umx10um+1um+2um",
        ] {
            assert_eq!(as_options(&parsed(line).unwrap().unwrap()), line);
        }
    }

    #[test]
    fn no_option_and_level_none_are_told_apart() {
        assert_eq!(parsed("").unwrap(), None, "a scene's own steps stay");
        assert_eq!(parsed("--level none").unwrap(), Some(vec![]), "a scene's own steps go");
        assert_eq!(prepare::describe(&parsed("--level none --invert").unwrap().unwrap()), "invert");
    }

    #[test]
    fn values_that_cannot_be_meant_are_refused() {
        for line in ["--level", "--level x", "--despike=3", "--crop", "--rotate 12", "--tile", "--taper 0um"]
        {
            assert!(parsed(line).is_err(), "{line}");
        }
    }
}
