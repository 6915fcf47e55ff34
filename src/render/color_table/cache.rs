//! Colour tables kept on disk, beside the layers and under the same rules: a key made of everything that they depend on,
//! whole files or none, a check sum.

use super::ColorTable;
use super::grid::{Grid, LEVELS};
use crate::error::Result;
use crate::memory;
use crate::optics::coherence::Coherence;
use crate::output;
use crate::precompute::Settings;
use crate::precompute::cache::{key as layers_key, sweep};
use crate::render::shading::Shading;
use crate::surface::HeightField;
use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

/// First bytes of a file; the number changes whenever the table of the same key would change.
const MAGIC: &[u8; 20] = b"diffract colours 004";
/// Numbers of 8 bytes behind magic and key: side, spacing, pieces, σ, unit.
const HEADER: usize = 5;
const HASH: usize = blake3::OUT_LEN;
const HEAD: usize = MAGIC.len() + HASH + HEADER * 8;

/// The key of the table of `field` under `shading`, made from layers of `settings`.
pub fn key(field: &HeightField, settings: &Settings, shading: &Shading) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    hasher.update(MAGIC);
    hasher.update(layers_key(field, settings).as_bytes());
    let wavelengths = shading.wavelengths.map_or(-1.0, |n| n as f64);
    let [n, m] = shading.windows.map(f64::from);
    hasher.update(bytemuck::cast_slice(&[shading.tolerance, wavelengths, n, m]));
    if let Coherence::Repeats(copies) = shading.coherence {
        hasher.update(bytemuck::cast_slice(&copies));
    }
    // Written out, numbers are exact and different tables differ.
    hasher.update(format!("{:?}", shading.illuminant).as_bytes());
    hasher.finalize()
}

/// Where the table of `key` is kept in `folder`.
pub fn path(folder: &Path, key: &blake3::Hash) -> PathBuf {
    folder.join(format!("{}.colours", key.to_hex()))
}

/// The table of `key` from `folder`, if it is there and whole, and takes at most `limit` bytes.
pub fn load(folder: &Path, key: &blake3::Hash, limit: u64) -> Option<ColorTable> {
    let place = path(folder, key);
    // Asked before opening, since opening a pipe waits for its other end.
    let size = std::fs::metadata(&place).ok().filter(std::fs::Metadata::is_file)?.len();
    // Where there is none, baking says so.
    memory::ensure_room(size, "the colour table").ok()?;
    read(&mut File::open(&place).ok()?, size, key, limit)
}

/// The table of `key` in the next `size` bytes of `file`; `None` where it is not whole or not one that this program makes.
pub fn read(file: &mut impl Read, size: u64, key: &blake3::Hash, limit: u64) -> Option<ColorTable> {
    let mut head = vec![0u8; HEAD];
    file.read_exact(&mut head).ok()?;
    if head[..MAGIC.len() + HASH] != preamble(key) {
        return None;
    }
    let numbers: Vec<f64> = bytemuck::pod_collect_to_vec(&head[MAGIC.len() + HASH..]);
    let grid = Grid { side: numbers[0] as usize, spacing: numbers[1], pieces: numbers[2] as usize };
    let expected = grid.side <= 1 << 16 && grid.pieces <= super::nodes::MOST;
    if !expected || grid.bytes() > limit || size != HEAD as u64 + grid.bytes() + HASH as u64 {
        return None;
    }
    let mut levels = Vec::with_capacity(LEVELS);
    for level in 0..LEVELS {
        let mut texels = vec![0u16; (grid.side >> level).pow(2) * grid.layers() * 4];
        file.read_exact(bytemuck::cast_slice_mut(&mut texels)).ok()?;
        levels.push(texels);
    }
    let mut sum = [0u8; HASH];
    file.read_exact(&mut sum).ok()?;
    let table = ColorTable { grid, sigma: numbers[3], unit: numbers[4] as f32, levels };
    (check_sum(&head, &table.levels) == sum).then_some(table).filter(is_sound)
}

/// What a file of `key` begins with.
fn preamble(key: &blake3::Hash) -> Vec<u8> {
    [MAGIC.as_slice(), key.as_bytes()].concat()
}

/// A file of `key` whose numbers and texels are `body`, with the check sum that belongs to it, filled up with zeros to the
/// length that its numbers ask for where that is at most `most` bytes: what a stranger would leave in the folder who knows
/// the format.
pub fn sealed(key: &blake3::Hash, body: &[u8], most: u64) -> Vec<u8> {
    let mut file = [&preamble(key), body].concat();
    if let Some(numbers) = body.get(..HEADER * 8) {
        let numbers: Vec<f64> = bytemuck::pod_collect_to_vec(numbers);
        let grid = Grid { side: numbers[0] as usize, spacing: numbers[1], pieces: numbers[2] as usize };
        let few = grid.side <= 1 << 16 && grid.pieces <= super::nodes::MOST && grid.bytes() <= most;
        let whole = if few { HEAD + grid.bytes() as usize } else { 0 };
        file.resize(file.len().max(whole), 0);
    }
    let sum = *blake3::hash(&file).as_bytes();
    file.extend(sum);
    file
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

/// Writes the table of `key` into `folder`.
///
/// # Errors
/// Where the folder or the file cannot be written; the table is still good.
pub fn store(folder: &Path, key: &blake3::Hash, table: &ColorTable) -> Result<()> {
    let place = path(folder, key);
    std::fs::create_dir_all(folder).map_err(|e| output::write_failed(folder, &e))?;
    sweep(folder);
    let grid = &table.grid;
    let numbers: [f64; HEADER] =
        [grid.side as f64, grid.spacing, grid.pieces as f64, table.sigma, f64::from(table.unit)];
    let mut head = MAGIC.to_vec();
    head.extend_from_slice(key.as_bytes());
    head.extend_from_slice(bytemuck::cast_slice(&numbers));
    let sum = check_sum(&head, &table.levels);
    output::write_atomically(&place, |file| {
        let levels = table.levels.iter().map(|level| bytemuck::cast_slice::<u16, u8>(level));
        [head.as_slice()]
            .into_iter()
            .chain(levels)
            .chain([sum.as_slice()])
            .try_for_each(|part| file.write_all(part))
            .map_err(|e| output::write_failed(&place, &e))
    })
}

fn check_sum(head: &[u8], levels: &[Vec<u16>]) -> [u8; HASH] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(head);
    for level in levels {
        hasher.update_rayon(bytemuck::cast_slice(level));
    }
    *hasher.finalize().as_bytes()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expansion::Basis;
    use crate::optics::spectrum::Illuminant;
    use crate::precompute::Budget;

    #[test]
    fn what_is_stored_is_loaded_and_any_changed_byte_makes_it_absent() {
        let folder = tempfile::tempdir().unwrap();
        let grid = Grid { side: 256, spacing: 0.02, pieces: 1 };
        let levels = (0..LEVELS)
            .map(|l| (0..(256 >> l) * (256 >> l) * 12).map(|i| (i % 0x7c00) as u16).collect())
            .collect();
        let table = ColorTable { grid, sigma: 1.5, unit: 0.25, levels };
        let key = blake3::hash(b"a table");
        assert!(load(folder.path(), &key, 1 << 30).is_none());
        store(folder.path(), &key, &table).unwrap();
        assert!(load(folder.path(), &key, 1 << 30).as_ref() == Some(&table));
        assert!(load(folder.path(), &key, 1 << 10).is_none(), "more than there is room for");
        let place = path(folder.path(), &key);
        let whole = std::fs::read(&place).unwrap();
        for position in [0, 30, 60, 80, whole.len() / 2, whole.len() - 1] {
            let mut damaged = whole.clone();
            damaged[position] ^= 1;
            std::fs::write(&place, &damaged).unwrap();
            assert!(load(folder.path(), &key, 1 << 30).is_none(), "byte {position}");
        }
        for length in [0, 10, 100, whole.len() - 1] {
            std::fs::write(&place, &whole[..length]).unwrap();
            assert!(load(folder.path(), &key, 1 << 30).is_none(), "cut to {length}");
        }
    }

    #[test]
    fn numbers_that_no_table_has_make_a_file_absent_in_spite_of_its_check_sum() {
        let key = blake3::hash(b"a table");
        let sound = [128.0, 4.0 / 126.0, 1.0, 1.5, 0.25];
        let body = |numbers: [f64; HEADER], texels: &[u16]| {
            [bytemuck::cast_slice::<f64, u8>(&numbers), bytemuck::cast_slice(texels)].concat()
        };
        let found = |body: Vec<u8>| {
            let file = sealed(&key, &body, 1 << 22);
            read(&mut file.as_slice(), file.len() as u64, &key, 1 << 30)
        };
        assert!(found(body(sound, &[0x3c00; 7])).is_some_and(|table| table.levels[0][6] == 0x3c00));
        for number in 0..HEADER {
            for value in [f64::NAN, f64::INFINITY, -1.0, 0.0, 1e300] {
                let mut numbers = sound;
                numbers[number] = value;
                // Any spacing and any window is one, if it is one.
                let harmless = value == 1e300 && (number == 1 || number == 3);
                assert_eq!(found(body(numbers, &[])).is_some(), harmless, "number {number}: {value}");
            }
        }
        assert!(found(body([130.0, 1.0, 1.0, 1.0, 1.0], &[])).is_none(), "no side that halves");
        for texel in [0x7c00, 0xfc00, 0x7e00] {
            assert!(found(body(sound, &[0, texel])).is_none(), "{texel:x}");
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
            memory_limit: 1 << 28,
            side_limit: 16_384,
        };
        let shading = Shading::default();
        let first = key(&field, &settings, &shading);
        assert_eq!(key(&field, &settings, &shading), first);
        // R is a factor of the shader's.
        assert_eq!(key(&field, &settings, &Shading { ior: 2.0, ..shading.clone() }), first);
        assert_ne!(key(&field, &Settings { sigma: 1.1, ..settings }, &shading), first);
        for other in [
            Shading { tolerance: 2e-2, ..shading.clone() },
            Shading { wavelengths: Some(20), ..shading.clone() },
            Shading { windows: [2, 1], ..shading.clone() },
            Shading { windows: [1, 2], ..shading.clone() },
            Shading { illuminant: Illuminant::A, ..shading.clone() },
            Shading { coherence: Coherence::Repeats([2, 1]), ..shading.clone() },
            Shading { coherence: Coherence::Repeats([1, 2]), ..shading.clone() },
        ] {
            assert_ne!(key(&field, &settings, &other), first, "{other:?}");
        }
    }
}
