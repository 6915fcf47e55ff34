//! Gratings that copies of the patch break: the orders of the copies lie at whole periods over the patch.

use crate::error::Result;
use crate::optics::coherence::Beyond;
use crate::settings::Optics;
use crate::surface::HeightField;
use crate::surface::statistics::with_periods;
use crate::surface::tiling::tiles;
use std::fmt;

/// Distance of the number of periods from a whole one below which nothing is said: a tenth of what breaks copies.
const SMALL: f64 = 0.01;

/// Periods over the patch along an axis, of which copies make a whole number.
pub struct CopiedPeriods {
    axis: &'static str,
    periods: f64,
}

impl CopiedPeriods {
    /// Returns those of `field` along the axis where copies shift the period more; `None` if they shift it by little, or if the field does not
    /// continue by copies.
    ///
    /// # Errors
    /// Too little memory for the spectrum of the heights.
    pub fn of(optics: &Optics, field: &HeightField) -> Result<Option<Self>> {
        if optics.beyond != Beyond::Copies {
            return Ok(None);
        }
        let tiling = with_periods(field, tiles(field))?;
        let axes = ["x", "y"].into_iter().zip(tiling.periods);
        let all = axes.filter_map(|(axis, periods)| periods.map(|periods| Self { axis, periods }));
        let broken = all.filter(|copied| copied.periods >= 1.0 && copied.distance() > SMALL);
        Ok(broken.max_by(|a, b| a.relative_shift().total_cmp(&b.relative_shift())))
    }

    fn distance(&self) -> f64 {
        (self.periods - self.periods.round()).abs()
    }

    /// Returns the largest shift of the period, relative to it.
    pub fn relative_shift(&self) -> f64 {
        self.distance() / self.periods
    }
}

impl fmt::Display for CopiedPeriods {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { axis, periods } = self;
        write!(
            f,
            "the patch holds {periods:.2} periods along {axis}, and its copies {:.0}: that may shift the period by {:.2} %, which \
             --beyond alike avoids",
            periods.round(),
            100.0 * self.relative_shift()
        )
    }
}
