//! Errors averaged over the wavelengths of a light.

use super::table::{AngleErrors, MaterialClass, errors};
use crate::optics::reflectance::Reflectance;
use crate::optics::spectrum::{Illuminant, midpoints, observer};
use crate::surface::statistics::ProfileShape;

/// Half nanometres in a band: 10 nm, because the table's periods are 25 % apart, 140 nm.
const WIDTH: usize = 20;
/// Share of the light whose errors must be known at an angle. Single points of the table have not converged; for *Elaphe* at 45° one such point
/// covers the reds, a fifth of daylight.
const KNOWN: f64 = 0.75;

/// Light for which errors are looked up.
#[derive(Clone, Copy, Debug)]
pub enum LightColour<'a> {
    /// Light of many wavelengths, each of which counts as it does in colours: by S (x̄ + ȳ + z̄).
    Spectrum(&'a Illuminant),
    /// Light of one wavelength \[µm\].
    Wavelength(f64),
}

/// Part of the light.
#[derive(Clone, Copy, Debug)]
pub struct Band {
    /// Mean wavelength \[µm\].
    wavelength: f64,
    /// Share of the light.
    share: f64,
}

/// Returns the bands of light of this colour; their shares add up to 1.
pub fn bands(colour: LightColour<'_>) -> Vec<Band> {
    let illuminant = match colour {
        LightColour::Wavelength(wavelength) => return vec![Band { wavelength, share: 1.0 }],
        LightColour::Spectrum(illuminant) => illuminant,
    };
    let wavelengths: Vec<f64> = midpoints().collect();
    let sums = wavelengths.chunks(WIDTH).map(|band| {
        band.iter().fold([0.0; 2], |[light, moment], &wavelength| {
            let weight = illuminant.power(wavelength) * observer(wavelength).element_sum();
            [light + weight, moment + weight * wavelength]
        })
    });
    let sums: Vec<[f64; 2]> = sums.filter(|[light, _]| *light > 0.0).collect();
    let total: f64 = sums.iter().map(|[light, _]| light).sum();
    sums.iter()
        .map(|[light, moment]| Band { wavelength: moment / light * 1e-3, share: light / total })
        .collect()
}

/// Returns the mean wavelength \[µm\].
pub fn mean_wavelength(bands: &[Band]) -> f64 {
    bands.iter().map(|band| band.share * band.wavelength).sum()
}

/// Returns the mean over `bands` of the errors of `grooves`, by the angle of incidence, or why they are not known. An angle is left out where more than a quarter
/// of the light is outside of the table.
pub fn mean_errors(
    grooves: &ProfileShape,
    reflectance: &Reflectance,
    bands: &[Band],
) -> Result<Vec<AngleErrors>, String> {
    let mut sums: Vec<(f64, AngleErrors)> = Vec::new(); // known share of the light, errors weighted by it
    let mut missing: Option<(f64, String)> = None; // share and reason of the brightest band without errors
    for Band { wavelength, share } in bands {
        let class = MaterialClass::of(reflectance, *wavelength);
        match class.and_then(|class| errors(grooves, class, reflectance.theory(), *wavelength)) {
            Ok(found) => found.into_iter().for_each(|errors| add(&mut sums, *share, errors)),
            Err(reason) if missing.as_ref().is_none_or(|(brightest, _)| share > brightest) => {
                missing = Some((*share, reason));
            }
            Err(_) => {} // of a darker band than the one in `missing`
        }
    }
    sums.retain(|(known, _)| *known >= KNOWN);
    for (known, AngleErrors { mean, te, tm, .. }) in &mut sums {
        [mean, te, tm].into_iter().for_each(|sum| *sum /= *known);
    }
    sums.sort_by(|a, b| a.1.angle.total_cmp(&b.1.angle));
    if sums.is_empty() {
        let partly = || "too little of the light is within what was computed".to_owned();
        return Err(missing.map_or_else(partly, |(_, reason)| reason));
    }
    Ok(sums.into_iter().map(|(_, errors)| errors).collect())
}

/// Adds the errors of a share of the light to the sums of their angle.
fn add(sums: &mut Vec<(f64, AngleErrors)>, share: f64, errors: AngleErrors) {
    let AngleErrors { angle, mean, te, tm } = errors;
    let [mean, te, tm] = [mean, te, tm].map(|error| share * error);
    match sums.iter_mut().find(|(_, sum)| sum.angle == angle) {
        Some((known, sum)) => {
            *known += share;
            *sum = AngleErrors { angle, mean: sum.mean + mean, te: sum.te + te, tm: sum.tm + tm };
        }
        None => sums.push((share, AngleErrors { angle, mean, te, tm })),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::statistics::ProfileKind;

    fn grooves(period: f64, height: f64) -> ProfileShape {
        ProfileShape { profile: ProfileKind::Sinusoid, period, height, slope_along: 0.0 }
    }

    #[test]
    fn a_narrow_line_is_looked_up_at_its_wavelength() {
        let line = Illuminant::from_text("632.7,0\n632.8,1\n632.9,0\n").unwrap();
        let spectrum = bands(LightColour::Spectrum(&line));
        assert!((mean_wavelength(&spectrum) - 0.6328).abs() < 1e-4, "{spectrum:?}");
        let of = |bands: &[Band]| mean_errors(&grooves(3.0, 0.2), &Reflectance::default(), bands).unwrap();
        let [broad, single] = [of(&spectrum), of(&bands(LightColour::Wavelength(0.6328)))];
        assert_eq!(broad.len(), single.len());
        for (a, b) in broad.iter().zip(&single) {
            assert!((a.mean / b.mean - 1.0).abs() < 2e-3 && a.angle == b.angle, "{a:?} {b:?}");
        }
    }

    #[test]
    fn white_light_errs_by_the_mean_of_its_wavelengths() {
        let spectrum = bands(LightColour::Spectrum(&Illuminant::E));
        assert!((spectrum.iter().map(|band| band.share).sum::<f64>() - 1.0).abs() < 1e-12);
        let at_60 = |bands: &[Band]| {
            let found = mean_errors(&grooves(2.0, 0.2), &Reflectance::default(), bands).unwrap();
            found.iter().find(|errors| errors.angle == 60.0).unwrap().mean
        };
        let single = |band: &Band| band.share * at_60(&bands(LightColour::Wavelength(band.wavelength)));
        let expected: f64 = spectrum.iter().map(single).sum();
        assert!((at_60(&spectrum) / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn light_that_is_partly_outside_of_the_table_is_told_while_it_is_a_quarter() {
        let of = |height: f64| {
            let spectrum = bands(LightColour::Spectrum(&Illuminant::E));
            mean_errors(&grooves(8.0, height), &Reflectance::default(), &spectrum)
        };
        assert!(of(0.405).is_ok(), "a height of 1 λ at 405 nm");
        assert!(of(0.6).unwrap_err().contains("higher than the 1 λ"));
    }
}
