//! Power spectra kept on disk.

use super::make::{FEWEST_TERMS, MOST_LEVELS, MOST_TERMS, PowerHeader, PowerSpectra};
use super::texture::PER_TEXEL;
use crate::cache::{EntryFormat, Kept, Payload, count, positive};

/// Larger than any side of a texture.
const LARGEST_SIDE: usize = 1 << 16;

impl Kept for PowerSpectra {
    /// The version changes whenever the power spectra of the same key would change.
    const FORMAT: EntryFormat = EntryFormat { name: "spectra", version: 8 };
    type Header = PowerHeader;

    fn header(&self) -> PowerHeader {
        self.header.clone()
    }

    fn payload(&self) -> Vec<&[u8]> {
        self.levels.iter().map(|level| bytemuck::cast_slice(level)).collect()
    }

    fn build(header: PowerHeader, payload: &mut Payload<'_>) -> Option<Self> {
        if !is_sound(&header) {
            return None;
        }
        let level = |level: usize| {
            let [columns, rows] = header.grid.size_of(level);
            payload.take_halves(count(&[columns, rows, header.terms])?)
        };
        let levels = (0..header.grid.levels).map(level).collect::<Option<_>>()?;
        Some(Self { header, levels })
    }
}

/// Whether `header` is such as this program makes: what follows divides by its numbers, counts with them and makes textures of its sizes.
/// The check sum finds accidents; it does not know who wrote it.
fn is_sound(header: &PowerHeader) -> bool {
    let PowerHeader {
        grid,
        terms,
        z_max,
        unit,
        specular,
        sigma,
        orders_blur,
        band,
        series_error,
        reading_error,
        effective_orders,
    } = header;
    (1..=MOST_LEVELS).contains(&grid.levels)
        && grid
            .size
            .iter()
            .all(|n| (1..=LARGEST_SIDE).contains(n) && n.is_multiple_of(1 << (grid.levels - 1)))
        && (FEWEST_TERMS..=MOST_TERMS).contains(terms)
        && terms.is_multiple_of(PER_TEXEL)
        && specular.len() == *terms
        && specular.iter().all(|x| x.is_finite())
        && positive(&[grid.range, grid.blur.variance, orders_blur.variance, *band].concat())
        && positive(&[*z_max, *unit, *sigma, *effective_orders])
        && [series_error, reading_error].into_iter().all(|x| x.is_finite() && *x >= 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::{Key, Store, read, seal};
    use crate::spectra::power::{Beyond, PowerSettings, power_spectra};
    use crate::surface::HeightField;
    use half::f16;
    use serde_json::{Value, json};

    fn field() -> HeightField {
        let heights = (0..256).map(|i| 0.05 * f64::from(i * 7 % 13) / 13.0).collect();
        HeightField::new(16, 16, [0.1, 0.1], heights).unwrap()
    }

    fn settings() -> PowerSettings {
        PowerSettings {
            sigma: 1.0,
            beyond: Beyond::Copies,
            shortest: 0.38,
            series_error: 1e-2,
            reading_error: 1e-1,
            least_footprint: 0.0,
            side_limit: 16_384,
            memory_limit: 1 << 28,
        }
    }

    fn sample() -> PowerSpectra {
        power_spectra(&field(), &settings(), &|_, _| Ok(())).unwrap()
    }

    fn found(header: &Value, payload: &[u8]) -> Option<PowerSpectra> {
        let key = Key::named("spectra");
        let file = seal(&PowerSpectra::FORMAT, &key, header, payload);
        let size = file.len() as u64;
        read(&mut file.as_slice(), size, &PowerSpectra::FORMAT, &key, 1 << 28, PowerSpectra::build)
    }

    #[test]
    fn power_spectra_come_back_from_the_disk_as_they_went() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path().join("cache"), 1 << 28);
        let key = Key::new(&PowerSpectra::FORMAT, &settings(), &field()).unwrap();
        assert!(store.load_kept::<PowerSpectra>(&key, 1 << 28).is_none());
        let spectra = sample();
        assert!(spectra.levels.len() > 1, "several levels");
        store.save_kept(&key, &spectra).unwrap();
        assert_eq!(store.load_kept(&key, 1 << 28), Some(spectra));
        assert!(store.load_kept::<PowerSpectra>(&key, 1).is_none(), "more than the memory limit");
    }

    #[test]
    fn numbers_that_no_power_spectra_have_make_a_file_absent_in_spite_of_its_check_sum() {
        let spectra = sample();
        let payload = spectra.payload().concat();
        let sound = serde_json::to_value(spectra.header()).unwrap();
        assert!(found(&sound, &payload) == Some(spectra));
        let with = |path: &str, value: Value| {
            let mut header = sound.clone();
            *header.pointer_mut(path).unwrap() = value;
            found(&header, &payload).is_some()
        };
        for path in ["/z_max", "/unit", "/sigma", "/band/0", "/grid/range/1", "/grid/blur/variance/0"] {
            assert!(with(path, json!(0.5)), "{path}");
            for value in [json!(0.0), json!(-1.0), json!(null), json!("1")] {
                assert!(!with(path, value.clone()), "{path} {value}");
            }
        }
        for path in ["/grid/size/0", "/grid/size/1", "/grid/levels", "/terms"] {
            for value in [json!(0), json!(1), json!(3), json!(-1), json!(1u64 << 40), json!(u64::MAX)] {
                if sound.pointer(path) == Some(&value) {
                    continue;
                }
                assert!(!with(path, value.clone()), "{path} {value}");
            }
        }
        assert!(!with("/specular", json!([1.0])) && !with("/specular/1", json!(null)));
        for place in [0, payload.len() - 2] {
            for bits in [f16::NAN, f16::INFINITY, f16::NEG_INFINITY] {
                let mut damaged = payload.clone();
                damaged[place..place + 2].copy_from_slice(&bits.to_ne_bytes());
                assert!(found(&sound, &damaged).is_none(), "{bits} at {place}");
            }
        }
        assert!(
            found(&sound, &payload[2..]).is_none()
                && found(&sound, &[&payload[..], &[0; 2]].concat()).is_none()
        );
    }

    #[test]
    fn every_setting_but_the_memory_changes_the_key() {
        let key = |settings: PowerSettings| Key::new(&PowerSpectra::FORMAT, &settings, &field()).unwrap();
        let all = settings();
        // A setting that is added has to be varied below.
        let PowerSettings {
            sigma,
            beyond: _,
            shortest,
            series_error,
            reading_error,
            least_footprint,
            side_limit,
            memory_limit,
        } = all;
        let others = [
            PowerSettings { sigma: 1.1 * sigma, ..all },
            PowerSettings { beyond: Beyond::Alike, ..all },
            PowerSettings { shortest: 1.1 * shortest, ..all },
            PowerSettings { series_error: 1.1 * series_error, ..all },
            PowerSettings { reading_error: 1.1 * reading_error, ..all },
            PowerSettings { least_footprint: least_footprint + 1e-3, ..all },
            PowerSettings { side_limit: side_limit / 2, ..all },
            all,
        ];
        let keys: std::collections::HashSet<Key> = others.iter().map(|other| key(*other)).collect();
        assert_eq!(keys.len(), others.len());
        assert_eq!(key(PowerSettings { memory_limit: memory_limit / 2, ..all }), key(all));
    }
}
