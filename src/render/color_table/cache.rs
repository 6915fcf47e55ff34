//! Colour tables kept on disk, under a key made of everything that they depend on.

use super::ColorTable;
use super::grid::{Grid, LEVELS};
use crate::cache::{Format, Key, Payload, Store};
use crate::error::Result;
use crate::precompute::Settings;
use crate::render::shading::Shading;
use crate::surface::HeightField;
use serde::{Deserialize, Serialize};

/// Kept tables; the version changes whenever the table of the same key would change.
pub const FORMAT: Format = Format { name: "colours", version: 5 };

/// The key of the table of `field` under `shading`, made from layers of `settings`.
///
/// # Errors
/// As [`Key::new`].
pub fn key(field: &HeightField, settings: &Settings, shading: &Shading) -> Result<Key> {
    #[derive(Serialize)]
    struct Depends<'a> {
        layers: &'a Settings,
        shading: &'a Shading,
    }
    Key::new(&FORMAT, &Depends { layers: settings, shading }, field)
}

/// The table of `key` from `store`, if it takes at most `limit` bytes.
pub fn load(store: &Store, key: &Key, limit: u64) -> Option<ColorTable> {
    store.load(&FORMAT, key, limit, build)
}

/// Keeps the table of `key` in `store`.
///
/// # Errors
/// As [`Store::save`].
pub fn save(store: &Store, key: &Key, table: &ColorTable) -> Result<()> {
    let Grid { side, spacing, pieces } = table.grid;
    let header = Header { side, spacing, pieces, sigma: table.sigma, unit: table.unit };
    let levels: Vec<&[u8]> = table.levels.iter().map(|level| bytemuck::cast_slice(level)).collect();
    store.save(&FORMAT, key, &header, &levels)
}

/// Everything of a table but its texels.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    side: usize,
    spacing: f64,
    pieces: usize,
    sigma: f64,
    unit: f32,
}

/// The table of `header` and `payload`; `None` where it is not such as this program makes.
pub fn build(header: Header, payload: &mut Payload<'_>) -> Option<ColorTable> {
    const LARGEST_SIDE: usize = 1 << 16;
    let grid = Grid { side: header.side, spacing: header.spacing, pieces: header.pieces };
    if grid.side > LARGEST_SIDE || grid.pieces > super::nodes::MOST || grid.bytes() != payload.left() {
        return None;
    }
    let texels = |level: usize| (grid.side >> level).pow(2) * grid.layers() * 4;
    let levels = (0..LEVELS).map(|level| payload.take(texels(level))).collect::<Option<_>>()?;
    let table = ColorTable { grid, sigma: header.sigma, unit: header.unit, levels };
    Some(table).filter(is_sound)
}

/// Whether `table` is such as this program makes: what follows divides by its numbers and makes images of its sizes. The check
/// sum finds accidents; it does not know who wrote it.
fn is_sound(table: &ColorTable) -> bool {
    /// All bits of the exponent, which infinities and what is no number have.
    const EXPONENT: u16 = 0x7c00;
    let positive = |x: f64| x.is_finite() && x > 0.0;
    table.grid.side >= 1 << (LEVELS - 1)
        && table.grid.side.is_multiple_of(1 << (LEVELS - 1))
        && table.grid.pieces >= 1
        && [table.grid.spacing, table.sigma, f64::from(table.unit)].into_iter().all(positive)
        && table.levels.iter().all(|level| level.iter().all(|x| x & EXPONENT != EXPONENT))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::{read, seal};
    use crate::expansion::Basis;
    use crate::optics::coherence::Coherence;
    use crate::optics::spectrum::Illuminant;
    use crate::precompute::{Aim, Budget};
    use serde_json::{Value, json};

    #[test]
    fn what_is_stored_is_loaded_and_any_changed_byte_makes_it_absent() {
        let folder = tempfile::tempdir().unwrap();
        let grid = Grid { side: 256, spacing: 0.02, pieces: 1 };
        let levels = (0..LEVELS)
            .map(|l| (0..(256 >> l) * (256 >> l) * 12).map(|i| (i % 0x7c00) as u16).collect())
            .collect();
        let table = ColorTable { grid, sigma: 1.5, unit: 0.25, levels };
        let key = Key::named("a table");
        let store = Store::at(folder.path().join("cache"), 1 << 30);
        assert!(load(&store, &key, 1 << 30).is_none());
        save(&store, &key, &table).unwrap();
        assert!(load(&store, &key, 1 << 30).as_ref() == Some(&table));
        assert!(load(&store, &key, 1 << 10).is_none(), "more than there is room for");
        let place = store.path(&FORMAT, &key);
        let whole = std::fs::read(&place).unwrap();
        for position in [0, 30, 60, 80, whole.len() / 2, whole.len() - 1] {
            let mut damaged = whole.clone();
            damaged[position] ^= 1;
            std::fs::write(&place, &damaged).unwrap();
            assert!(load(&store, &key, 1 << 30).is_none(), "byte {position}");
        }
        for length in [0, 10, 100, whole.len() - 1] {
            std::fs::write(&place, &whole[..length]).unwrap();
            assert!(load(&store, &key, 1 << 30).is_none(), "cut to {length}");
        }
    }

    #[test]
    fn numbers_that_no_table_has_make_a_file_absent_in_spite_of_its_check_sum() {
        let key = Key::named("a table");
        let found = |header: &Value, first: &[u16]| {
            let mut payload = bytemuck::cast_slice::<u16, u8>(first).to_vec();
            payload.resize(Grid { side: 128, spacing: 1.0, pieces: 1 }.bytes() as usize, 0);
            let file = seal(&FORMAT, &key, header, &payload);
            read(&mut file.as_slice(), file.len() as u64, &FORMAT, &key, 1 << 30, build)
        };
        let sound = json!({ "side": 128, "spacing": 4.0 / 126.0, "pieces": 1, "sigma": 1.5, "unit": 0.25 });
        assert!(found(&sound, &[0x3c00; 7]).is_some_and(|table| table.levels[0][6] == 0x3c00));
        for name in ["side", "spacing", "pieces", "sigma", "unit"] {
            for value in [json!(null), json!(-1.0), json!(0.0), json!(0), json!(1e300), json!(u64::MAX)] {
                let mut header = sound.clone();
                header[name] = value.clone();
                // Any spacing and any window is one, if it is one.
                let large = value.as_f64().is_some_and(|value| value > 1.0);
                let harmless = large && ["spacing", "sigma"].contains(&name)
                    || name == "unit" && value == json!(u64::MAX);
                assert_eq!(found(&header, &[]).is_some(), harmless, "{name} {value}");
            }
        }
        for side in [64, 130, 256] {
            let mut header = sound.clone();
            header["side"] = json!(side);
            assert!(found(&header, &[]).is_none(), "side {side}");
        }
        for texel in [0x7c00, 0xfc00, 0x7e00] {
            assert!(found(&sound, &[0, texel]).is_none(), "{texel:x}");
        }
    }

    #[test]
    fn everything_that_a_table_depends_on_changes_its_key() {
        let field = HeightField::new(4, 4, [0.1, 0.1], vec![0.0; 16]).unwrap();
        let settings = Settings {
            sigma: 1.0,
            shortest_wavelength: 0.38,
            budget: Budget { interpolation: 7e-2, expansion: 3.5e-2 },
            basis: Basis::Taylor,
            terms: None,
            aim: Aim::FewTransforms,
            lines: None,
            memory_limit: 1 << 28,
            side_limit: 16_384,
        };
        let shading = Shading::default();
        let key = |settings: &Settings, shading: &Shading| key(&field, settings, shading).unwrap();
        let first = key(&settings, &shading);
        assert_eq!(key(&settings, &shading), first);
        // R is a factor of the shader's.
        assert_eq!(key(&settings, &Shading { ior: 2.0, ..shading.clone() }), first);
        assert_ne!(key(&Settings { sigma: 1.1, ..settings }, &shading), first);
        for other in [
            Shading { tolerance: 2e-2, ..shading.clone() },
            Shading { wavelengths: Some(20), ..shading.clone() },
            Shading { windows: [2, 1], ..shading.clone() },
            Shading { windows: [1, 2], ..shading.clone() },
            Shading { illuminant: Illuminant::A, ..shading.clone() },
            Shading { coherence: Coherence::Repeats([2, 1]), ..shading.clone() },
            Shading { coherence: Coherence::Repeats([1, 2]), ..shading.clone() },
        ] {
            assert_ne!(key(&settings, &other), first, "{other:?}");
        }
    }
}
