//! The options of sequences of pictures.

use crate::error::{Error, Result};
use crate::render::sequence::{Motion, Sequence};
use clap::Args;
use std::ops::Range;

/// Largest number of pictures of a sequence: seven minutes at 24 a second.
const MOST: i64 = 10_000;

/// Options of a sequence of pictures.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Sequence")]
pub struct SequenceOptions {
    /// N pictures, once around: the camera turns about its target by 360/N degrees from each to the next, about the world's up. With `-o
    /// turn.png` the files are turn-0000.png, turn-0001.png and so on. Pictures that an earlier run finished are kept
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST), allow_hyphen_values = true, hide_short_help = true)]
    turntable: Option<u32>,
    /// N pictures, once around: all lights and the surroundings turn about the world's up by 360/N degrees from each to the next. Files as for --turntable
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=MOST), allow_hyphen_values = true, hide_short_help = true)]
    light_sweep: Option<u32>,
    /// Draw only pictures A to B-1 of the sequence, counted from 0: 0..24 are the first 24. In this way several machines can share a
    /// sequence
    #[arg(long, value_name = "A..B", value_parser = frames, allow_hyphen_values = true, hide_short_help = true)]
    frames: Option<Range<u32>>,
}

impl SequenceOptions {
    /// Returns the sequence that the options ask for, if any.
    ///
    /// # Errors
    /// Options that do not go together.
    pub fn chosen(&self) -> Result<Option<Sequence>> {
        let (motion, count) = match (self.turntable, self.light_sweep) {
            (Some(_), Some(_)) => {
                return Err(Error::usage(
                    "--turntable and --light-sweep are two sequences",
                    "give one of them, and the other in a run of its own",
                ));
            }
            (Some(count), None) => (Motion::Turntable, count),
            (None, Some(count)) => (Motion::LightSweep, count),
            (None, None) if self.frames.is_some() => {
                return Err(Error::usage(
                    "--frames is about a sequence of pictures",
                    "add --turntable N or --light-sweep N, or leave --frames away",
                ));
            }
            (None, None) => return Ok(None),
        };
        let frames = self.frames.clone().unwrap_or(0..count);
        if frames.end > count {
            let Range { start, end } = frames;
            return Err(Error::usage(
                format!("--frames {start}..{end} goes beyond the last of {count} pictures"),
                format!("end at {count} at most, which is one past the last"),
            ));
        }
        Ok(Some(Sequence { motion, count, frames }))
    }
}

/// Parses the pictures `A..B` of a sequence; the last one is excluded.
///
/// # Errors
/// Anything but two whole numbers, the first below the second.
pub fn frames(text: &str) -> Result<Range<u32>> {
    let number = |field: &str| field.trim().parse::<u32>().ok();
    let ends = text.split_once("..").and_then(|(a, b)| Some(number(a)?..number(b)?));
    ends.filter(|frames| !frames.is_empty()).ok_or_else(|| {
        Error::usage(
            format!("`{text}` are no pictures of a sequence"),
            "give the first and one past the last, as in 0..24 for the first 24",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(
        turntable: Option<u32>,
        light_sweep: Option<u32>,
        frames: Option<Range<u32>>,
    ) -> SequenceOptions {
        SequenceOptions { turntable, light_sweep, frames }
    }

    #[test]
    fn ranges_leave_their_end_out_and_have_two_ends_in_order() {
        assert_eq!(frames("0..24").unwrap(), 0..24);
        assert_eq!(frames(" 3 .. 4 ").unwrap(), 3..4);
        for bad in ["", "5", "..", "1..", "..5", "5..5", "6..5", "-1..5", "0..=5", "0...5", "0.5..3", "a..b"]
        {
            let e = frames(bad).unwrap_err();
            assert!(
                e.kind() == crate::error::ErrorKind::Usage && e.to_string().contains("as in 0..24"),
                "{bad}: {e}"
            );
        }
    }

    #[test]
    fn options_that_do_not_go_together_are_refused_with_a_remedy() {
        assert_eq!(options(None, None, None).chosen().unwrap(), None);
        let all = options(Some(24), None, None).chosen().unwrap().unwrap();
        assert_eq!(all, Sequence { motion: Motion::Turntable, count: 24, frames: 0..24 });
        let some = options(None, Some(24), Some(20..24)).chosen().unwrap().unwrap();
        assert_eq!(some, Sequence { motion: Motion::LightSweep, count: 24, frames: 20..24 });
        for (wrong, said) in [
            (options(Some(4), Some(4), None), "give one of them"),
            (options(None, None, Some(0..4)), "add --turntable N or --light-sweep N"),
            (options(Some(4), None, Some(0..5)), "end at 4 at most"),
            (options(Some(4), None, Some(4..5)), "end at 4 at most"),
        ] {
            let e = wrong.chosen().unwrap_err();
            assert!(e.kind() == crate::error::ErrorKind::Usage && e.to_string().contains(said), "{e}");
        }
    }
}
