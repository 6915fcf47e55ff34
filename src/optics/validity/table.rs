//! The table of errors that `tools/validity` computed, read between its points.

use crate::optics::polarisation::Polarisation;
use crate::optics::reflectance::Reflectance;
use crate::optics::theory::Theory;
use crate::surface::statistics::ProfileShape;
use serde::Serialize;
use std::sync::LazyLock;

/// Rows of kind, material, period and height \[wavelengths\], angle \[degrees\], and for each theory errors \[%\] of the mean of TE and TM, TE, TM and
/// the specular order.
const TABLE: &str = include_str!("../../../assets/validity/table.csv");
/// Errors below this are not told apart: an error that changes its sign passes 0, and reading beside that place would promise too much.
const SMALLEST: f64 = 0.01;

/// Period beyond which errors do not grow \[wavelengths\].
const LONG_ENOUGH: f64 = 3.0;

/// Materials that behave alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MaterialClass {
    /// Computed for aluminium.
    Metal,
    /// Computed for a refractive index of 1.5.
    Dielectric,
}

impl MaterialClass {
    /// Returns the class in light of `wavelength` \[µm\], or why there is none.
    pub fn of(reflectance: &Reflectance, wavelength: f64) -> Result<Self, String> {
        /// Extinction coefficient from which on light does not enter deeper than a tenth of a wavelength.
        const METALLIC: f64 = 1.5;
        /// Refractive indices and largest extinction coefficient of dielectrics.
        const DIELECTRIC: std::ops::RangeInclusive<f64> = 1.3..=1.8;
        const TRANSPARENT: f64 = 0.05;
        match reflectance {
            Reflectance::Schlick(_) => Err("computed with Fresnel's equations".to_owned()),
            Reflectance::Fresnel { film: Some(_), .. } => Err("computed without a film".to_owned()),
            Reflectance::Fresnel { material, film: None, .. } => {
                let index = material.index(wavelength);
                if index.im >= METALLIC {
                    Ok(Self::Metal)
                } else if index.im <= TRANSPARENT && DIELECTRIC.contains(&index.re) {
                    Ok(Self::Dielectric)
                } else {
                    Err(format!(
                        "computed for metals and for refractive indices near 1.5, not for {index:.2}"
                    ))
                }
            }
        }
    }

    /// Returns the name in the table.
    pub fn name(self) -> &'static str {
        match self {
            Self::Metal => "metal",
            Self::Dielectric => "dielectric",
        }
    }
}

/// Errors at an angle of incidence: shares of the diffracted light that scalar theory puts elsewhere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct AngleErrors {
    /// Angle of incidence \[degrees\].
    #[serde(rename = "angle_deg")]
    pub angle: f64,
    /// Error in unpolarised light.
    pub mean: f64,
    /// Error in light polarised along the grooves, with Fresnel's reflectance of this polarisation.
    pub te: f64,
    /// Error in light polarised across the grooves, likewise.
    pub tm: f64,
}

impl AngleErrors {
    /// Returns the error in light of this polarisation.
    pub fn in_light(&self, polarisation: Polarisation) -> f64 {
        match polarisation {
            Polarisation::None => self.mean,
            Polarisation::Te => self.te,
            Polarisation::Tm => self.tm,
        }
    }
}

/// A point of the table.
struct TablePoint {
    kind: &'static str,
    material: &'static str,
    /// In wavelengths.
    period: f64,
    height: f64,
    /// In the order of [`Theory::ALL`].
    errors: [AngleErrors; 2],
}

impl TablePoint {
    /// Returns the errors of a theory.
    fn errors(&self, theory: Theory) -> &AngleErrors {
        match theory {
            Theory::SmallSlope => &self.errors[0],
            Theory::Stam => &self.errors[1],
        }
    }
}

/// Rows of the table; a test of this module checks that every line is one.
static ROWS: LazyLock<Vec<TablePoint>> = LazyLock::new(|| TABLE.lines().skip(1).filter_map(row).collect());

fn row(line: &'static str) -> Option<TablePoint> {
    /// First columns of the errors of both theories.
    const ERRORS: [usize; 2] = [5, 9];
    let words: Vec<&'static str> = line.split(',').collect();
    let number = |column: usize| words.get(column)?.parse::<f64>().ok();
    let angle = number(4)?;
    let errors = |first: usize| {
        let error = |column: usize| Some((number(first + column)? / 100.0).max(SMALLEST));
        Some(AngleErrors { angle, mean: error(0)?, te: error(1)?, tm: error(2)? })
    };
    let errors = [errors(ERRORS[0])?, errors(ERRORS[1])?];
    Some(TablePoint { kind: words[0], material: words[1], period: number(2)?, height: number(3)?, errors })
}

/// Returns the errors of a theory for `grooves` in light of `wavelength` \[µm\] by the angle of incidence, or why they are not known. Periods above those of the
/// table are taken for its longest, and heights below for its lowest: errors are not larger there.
pub fn errors(
    grooves: &ProfileShape,
    class: MaterialClass,
    theory: Theory,
    wavelength: f64,
) -> Result<Vec<AngleErrors>, String> {
    let rows: Vec<&TablePoint> = ROWS
        .iter()
        .filter(|row| row.kind == grooves.profile.name() && row.material == class.name())
        .collect();
    let periods = axis(rows.iter().map(|row| row.period));
    let heights = axis(rows.iter().map(|row| row.height));
    let angles = axis(rows.iter().map(|row| row.errors(theory).angle));
    let [period, height] = [grooves.period, grooves.height].map(|length| length / wavelength);
    let ([shortest, .., longest], [.., highest]) = (&periods[..], &heights[..]) else {
        return Err("nothing was computed for this profile".to_owned());
    };
    if period < *shortest {
        return Err(format!("period {period:.2} λ, shorter than the {shortest} λ that were computed"));
    }
    if period > *longest && *longest < LONG_ENOUGH {
        return Err(format!("period {period:.2} λ, longer than the {longest} λ that were computed"));
    }
    if height > *highest {
        return Err(format!("height {height:.2} λ, higher than the {highest} λ that were computed"));
    }
    let corners = between(&periods, period);
    let corners = corners.iter().flat_map(|p| between(&heights, height).map(|h| [p.0, h.0, p.1 * h.1]));
    let corners: Vec<[f64; 3]> = corners.filter(|[.., weight]| *weight > 0.0).collect();
    let at_angle = |angle: &f64| -> Option<AngleErrors> {
        let mut logs = [0.0; 3];
        for [p, h, weight] in &corners {
            let beside = rows.iter().filter(|row| row.period == *p && row.height == *h);
            let AngleErrors { mean, te, tm, .. } =
                beside.map(|row| row.errors(theory)).find(|errors| errors.angle == *angle)?;
            for (log, error) in logs.iter_mut().zip([mean, te, tm]) {
                *log += weight * error.ln();
            }
        }
        let [mean, te, tm] = logs.map(f64::exp);
        Some(AngleErrors { angle: *angle, mean, te, tm })
    };
    let found: Vec<AngleErrors> = angles.iter().filter_map(at_angle).collect();
    if found.is_empty() {
        let steepest = rows.iter().map(|row| row.height / row.period).fold(0.0, f64::max);
        return Err(if height / period > steepest {
            format!(
                "height over period {:.2}, steeper than the {steepest:.2} that was computed",
                height / period
            )
        } else {
            format!("no solution for a period of {period:.2} λ and a height of {height:.2} λ")
        });
    }
    Ok(found)
}

/// Returns the different values, rising.
fn axis(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup();
    values
}

/// Returns the values of a rising axis beside `x` and their weights in linear interpolation over the logarithm; the end of the axis beyond it.
fn between(axis: &[f64], x: f64) -> [(f64, f64); 2] {
    let above = axis.partition_point(|value| *value < x);
    let high = axis[above.min(axis.len() - 1)];
    let low = axis[above.min(axis.len() - 1).saturating_sub(1)];
    if above == 0 || above == axis.len() || low == high {
        let end = if above == 0 { axis[0] } else { high };
        return [(end, 1.0), (end, 0.0)];
    }
    let share = (x / low).ln() / (high / low).ln();
    [(low, 1.0 - share), (high, share)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::statistics::ProfileKind;

    #[test]
    fn every_row_is_read_and_every_kind_is_there() {
        let head = "kind,material,period,height,angle,small_slope_mean,small_slope_te,small_slope_tm,small_slope_specular,\
                    stam_mean,stam_te,stam_tm,stam_specular,change,energy";
        assert_eq!(TABLE.lines().next(), Some(head));
        assert_eq!(ROWS.len(), TABLE.lines().count() - 1);
        for kind in ProfileKind::ALL {
            for class in [MaterialClass::Metal, MaterialClass::Dielectric] {
                let count =
                    ROWS.iter().filter(|r| r.kind == kind.name() && r.material == class.name()).count();
                assert!(count >= 20, "{kind:?} on {class:?}: {count} points");
            }
        }
    }

    fn at_60(theory: Theory, period: f64, height: f64) -> f64 {
        let grooves = ProfileShape { profile: ProfileKind::Sinusoid, period, height, slope_along: 0.0 };
        let found = errors(&grooves, MaterialClass::Dielectric, theory, 1.0).unwrap();
        found.iter().find(|e| e.angle == 60.0).unwrap().mean
    }

    #[test]
    fn points_of_the_table_are_returned_and_between_them_the_geometric_mean() {
        for theory in Theory::ALL {
            let row = |period: f64, height: f64| {
                let is_it = |r: &&TablePoint| {
                    (r.kind, r.material, r.period, r.height, r.errors(theory).angle)
                        == ("sinusoid", "dielectric", period, height, 60.0)
                };
                ROWS.iter().find(is_it).unwrap().errors(theory).mean
            };
            let error = |period, height| at_60(theory, period, height);
            assert!((error(3.3, 0.2) / row(3.3, 0.2) - 1.0).abs() < 1e-12);
            let middle = (row(3.3, 0.2) * row(4.1, 0.2)).sqrt();
            assert!((error((3.3_f64 * 4.1).sqrt(), 0.2) / middle - 1.0).abs() < 1e-12);
            assert_eq!((error(100.0, 0.2), error(3.3, 0.01)), (error(20.0, 0.2), error(3.3, 0.05)));
        }
    }

    #[test]
    fn small_slope_is_the_better_of_both_on_shallow_sinusoids() {
        let [small_slope, stam] = Theory::ALL.map(|theory| at_60(theory, 3.3, 0.1));
        assert!(small_slope < 0.03 && stam > 0.1, "{small_slope} {stam}");
    }
}
