//! Layers in the cache on disk, under a key made of everything that they depend on.

use super::coefficients::Coefficients;
use super::kernel::{Interpolation, Kernel, Transformed};
use super::layers::{Errors, Layers};
use super::pairs::PairRule;
use super::settings::LayerSettings;
use super::texels::Texels;
use crate::cache::{EntryFormat, Kept, Key, Payload, count, positive};
use crate::error::Result;
use crate::surface::HeightField;
use serde::{Deserialize, Serialize};

/// Largest size of the coefficients, beside the texels \[bytes\].
const LARGEST_COEFFICIENTS: u64 = 64 << 20;

/// Returns the key of the layers of `field` under `settings`, for a window whose centre is `shift` \[µm\] from that of the patch.
///
/// # Errors
/// Those of [`Key::new`].
pub fn key(field: &HeightField, settings: &LayerSettings, shift: [f64; 2]) -> Result<Key> {
    #[derive(Serialize)]
    struct Depends<'a> {
        settings: &'a LayerSettings,
        shift: [f64; 2],
    }
    Key::new(&Layers::FORMAT, &Depends { settings, shift }, field)
}

/// Returns the largest size of cached layers of `settings` \[bytes\].
pub fn memory_limit(settings: &LayerSettings) -> u64 {
    (settings.memory_limit as u64).saturating_add(LARGEST_COEFFICIENTS)
}

/// Fields of [`Layers`] without texels and coefficients.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayersHeader {
    size: [usize; 2],
    origin: [usize; 2],
    length: [f64; 2],
    band: [f64; 2],
    /// Standard deviation of the window \[µm\]; absent if it is infinite.
    sigma: Option<f64>,
    half_plane: bool,
    terms: usize,
    taylor: bool,
    half_range: f64,
    columns: usize,
    z_max: f64,
    pairs_needed: PairRule,
    kernels: [Kernel; 2],
    ratios: [f64; 2],
    errors: Errors,
    half_floats: bool,
}

impl Kept for Layers {
    /// The version changes whenever the layers of the same key would change.
    const FORMAT: EntryFormat = EntryFormat { name: "layers", version: 13 };
    type Header = LayersHeader;

    fn header(&self) -> LayersHeader {
        LayersHeader {
            size: self.size,
            origin: self.origin,
            length: self.length,
            band: self.band,
            sigma: self.sigma.is_finite().then_some(self.sigma),
            half_plane: self.half_plane,
            terms: self.terms,
            taylor: self.coefficients.taylor,
            half_range: self.coefficients.half_range,
            columns: self.coefficients.columns,
            z_max: self.z_max,
            pairs_needed: self.pairs_needed,
            kernels: self.interpolation.kernels,
            ratios: self.interpolation.ratios,
            errors: self.errors,
            half_floats: self.texels.is_half(),
        }
    }

    fn payload(&self) -> Vec<&[u8]> {
        vec![self.texels.bytes(), bytemuck::cast_slice(&self.coefficients.values)]
    }

    fn build(header: LayersHeader, payload: &mut Payload<'_>) -> Option<Self> {
        let h = header;
        let pairs = h.terms.div_ceil(2);
        let texels = count(&[h.size[0], h.size[1], pairs, 4])?;
        let texels = if h.half_floats {
            Texels::Half(payload.take(texels)?)
        } else {
            Texels::Single(payload.take(texels)?)
        };
        let values = payload.take(count(&[pairs, h.columns])?)?;
        let layers = Self {
            size: h.size,
            origin: h.origin,
            length: h.length,
            band: h.band,
            sigma: h.sigma.unwrap_or(f64::INFINITY),
            half_plane: h.half_plane,
            terms: h.terms,
            coefficients: Coefficients {
                taylor: h.taylor,
                half_range: h.half_range,
                columns: h.columns,
                values,
            },
            z_max: h.z_max,
            pairs_needed: h.pairs_needed,
            interpolation: Interpolation {
                of: if h.sigma.is_some() { Transformed::Window } else { Transformed::Period },
                kernels: h.kernels,
                ratios: h.ratios,
            },
            errors: h.errors,
            texels,
        };
        Some(layers).filter(is_sound)
    }
}

/// Limit of all counts: larger than any side and any number of terms; products of two fit a `usize`.
const LARGEST_COUNT: usize = 1_000_000;

/// Returns true if `layers` are valid: the code that uses them divides by their numbers, counts with them and makes images of their sizes.
/// The check sum finds accidental damage, not forged files.
fn is_sound(layers: &Layers) -> bool {
    let l = layers;
    let rule = [l.pairs_needed.slope, l.pairs_needed.fewest];
    (0..2).all(|axis| l.origin[axis] < l.size[axis])
        && [l.size[0], l.size[1], l.terms].iter().all(|n| *n <= LARGEST_COUNT)
        && positive(&[l.length, l.band, l.interpolation.ratios].concat())
        && positive(&[l.z_max])
        && l.sigma > 0.0
        && l.terms >= 1
        && l.coefficients.columns >= 2
        && rule.iter().all(|x| x.is_finite())
        && l.texels.are_finite()
        && l.coefficients.half_range.is_finite()
        && l.coefficients.half_range >= 0.0
        && l.coefficients.values.iter().flatten().all(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::budget::{ErrorBudget, WindowBudget};
    use crate::cache::{Store, read, seal};
    use crate::spectra::amplitude::compute;
    use crate::task::Task;
    use serde_json::{Value, json};

    fn sample() -> (HeightField, LayerSettings, Layers) {
        let heights = (0..256).map(|i| 0.05 * f64::from(i * 7 % 13) / 13.0).collect();
        let field = HeightField::new(16, 16, [0.1, 0.1], heights).unwrap();
        let settings = LayerSettings {
            sigma: 1.0,
            shortest_wavelength: 0.38,
            budget: ErrorBudget::of_directions(1e-1).window,
            basis: crate::spectra::amplitude::expansion::Basis::Taylor,
            terms: None,
            memory_limit: 1 << 28,
            side_limit: 16_384,
        };
        let layers = compute(&field, &settings, &Task::silent()).unwrap();
        (field, settings, layers)
    }

    fn load(store: &Store, key: &Key) -> Option<Layers> {
        store.load_kept(key, 1 << 28)
    }

    fn centred(field: &HeightField, settings: &LayerSettings) -> Key {
        key(field, settings, [0.0; 2]).unwrap()
    }

    #[test]
    fn what_is_saved_is_loaded_and_any_changed_byte_makes_it_absent() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path().join("cache"), 1 << 28);
        let (field, settings, layers) = sample();
        let key = centred(&field, &settings);
        assert!(load(&store, &key).is_none());
        store.save_kept(&key, &layers).unwrap();
        assert_eq!(load(&store, &key).as_ref(), Some(&layers));
        let place = store.path(&Layers::FORMAT, &key);
        let whole = std::fs::read(&place).unwrap();
        for position in [0, 30, 60, 200, whole.len() / 2, whole.len() - 1] {
            let mut damaged = whole.clone();
            damaged[position] ^= 1;
            std::fs::write(&place, &damaged).unwrap();
            assert!(load(&store, &key).is_none(), "byte {position}");
        }
        for length in [0, 10, 100, whole.len() - 1] {
            std::fs::write(&place, &whole[..length]).unwrap();
            assert!(load(&store, &key).is_none(), "cut to {length}");
        }
        store.save_kept(&key, &layers).unwrap();
        assert!(load(&store, &key).is_some());
    }

    #[test]
    fn numbers_that_no_layers_have_make_a_file_absent_in_spite_of_its_check_sum() {
        let (_, _, layers) = sample();
        let key = Key::named("layers");
        let coefficients: &[u8] = bytemuck::cast_slice(&layers.coefficients.values);
        let payload = [layers.texels.bytes(), coefficients].concat();
        let found = |header: &Value, payload: &[u8]| {
            let file = seal(&Layers::FORMAT, &key, header, payload);
            read(&mut file.as_slice(), file.len() as u64, &Layers::FORMAT, &key, 1 << 28, Layers::build)
        };
        let sound = serde_json::to_value(layers.header()).unwrap();
        assert_eq!(found(&sound, &payload), Some(layers));
        // Every number of the header, by its path; those of the kernels and flags are words.
        let mut numbers = Vec::new();
        leaves(&sound, String::new(), &mut numbers);
        assert!(numbers.len() > 20, "{numbers:?}");
        for path in &numbers {
            for value in [-1.0, 0.0, 0.5, 1e18, 1e300] {
                let mut header = sound.clone();
                *header.pointer_mut(path).unwrap() = json!(value);
                let is = |names: &[&str]| names.iter().any(|name| path[1..].starts_with(name));
                // The errors of the layers are only shown to the user.
                let harmless = is(&["errors"])
                    || value <= 0.0 && is(&["pairs_needed"])
                    || value == 0.0 && is(&["half_range"])
                    || value > 0.0
                        && is(&["length", "band", "sigma", "z_max", "ratios", "pairs_needed", "half_range"]);
                assert_eq!(found(&header, &payload).is_some(), harmless, "{path} {value}");
            }
            for value in [json!(null), json!("1"), json!([1])] {
                let mut header = sound.clone();
                *header.pointer_mut(path).unwrap() = value.clone();
                let harmless = path == "/sigma" && value.is_null();
                assert_eq!(found(&header, &payload).is_some(), harmless, "{path} {value}");
            }
        }
        for place in [0, payload.len() - 4] {
            let mut damaged = payload.clone();
            damaged[place..place + 4].copy_from_slice(&f32::NAN.to_le_bytes());
            assert!(found(&sound, &damaged).is_none(), "{place}");
        }
    }

    /// Collects the paths of all numbers in `value`.
    fn leaves(value: &Value, path: String, found: &mut Vec<String>) {
        match value {
            Value::Object(fields) => fields.iter().for_each(|(k, v)| leaves(v, format!("{path}/{k}"), found)),
            Value::Array(list) => {
                list.iter().enumerate().for_each(|(i, v)| leaves(v, format!("{path}/{i}"), found))
            }
            Value::Number(_) => found.push(path),
            _ => {}
        }
    }

    #[test]
    fn every_setting_changes_the_key() {
        let (field, settings, _) = sample();
        let first = centred(&field, &settings);
        // A new setting has to be varied below.
        let LayerSettings {
            sigma,
            shortest_wavelength,
            budget,
            basis: _,
            terms: _,
            memory_limit,
            side_limit,
        } = settings;
        let others = [
            LayerSettings { sigma: sigma * 1.1, ..settings },
            LayerSettings { sigma: f64::INFINITY, ..settings },
            LayerSettings { shortest_wavelength: shortest_wavelength + 0.02, ..settings },
            LayerSettings { budget: WindowBudget { interpolation: 0.1, ..budget }, ..settings },
            LayerSettings {
                budget: WindowBudget { expansion: budget.expansion + 1e-9, ..budget },
                ..settings
            },
            LayerSettings { basis: crate::spectra::amplitude::expansion::Basis::Optimal, ..settings },
            LayerSettings { terms: Some(4), ..settings },
            LayerSettings { terms: Some(5), ..settings },
            LayerSettings { side_limit: side_limit / 2, ..settings },
        ];
        let mut keys: Vec<Key> = others.iter().map(|other| centred(&field, other)).collect();
        keys.extend([[0.1, 0.0], [0.0, 0.1]].map(|shift| key(&field, &settings, shift).unwrap()));
        keys.push(first);
        let different: std::collections::HashSet<Key> = keys.iter().copied().collect();
        assert_eq!(different.len(), keys.len());
        // The memory limit decides whether layers are made, and does not change them.
        assert_eq!(centred(&field, &LayerSettings { memory_limit: memory_limit / 2, ..settings }), first);
    }
}
