//! Layers kept on disk, in the user's cache folder, under a key made of everything that they depend on.
//!
//! A file is written beside its place and renamed, so another process sees all of it or nothing; a check sum over the
//! whole is compared when it is read, and a file that does not match is made anew.

use super::coefficients::Coefficients;
use super::kernel::{Interpolation, Kernel};
use super::layers::{self, Errors, Layers, Settings};
use super::pairs::PairRule;
use super::texels::Texels;
use crate::error::{Error, Result};
use crate::memory;
use crate::output;
use crate::surface::HeightField;
use std::fs::File;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// First bytes of a file; the number changes whenever the layers of the same key would change.
const MAGIC: &[u8; 20] = b"diffract layers 0011";
/// Bytes of the check sum and of the key.
const HASH: usize = blake3::OUT_LEN;
/// Numbers of 8 bytes that describe the layers in front of the texels.
const HEADER: usize = 26;

/// The folder: `$XDG_CACHE_HOME/diffract`, else `~/.cache/diffract`; `None` where the user has neither.
pub fn folder() -> Option<PathBuf> {
    let absolute = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|p| p.is_absolute());
    absolute("XDG_CACHE_HOME")
        .or_else(|| absolute("HOME").map(|home| home.join(".cache")))
        .map(|base| base.join("diffract"))
}

/// The key of the layers of `field` under `settings`: a hash of every height and every number that matters.
pub fn key(field: &HeightField, settings: &Settings) -> blake3::Hash {
    key_at(field, settings, [0.0; 2])
}

/// The same for a window whose centre is `shift` \[µm\] from that of the patch.
pub fn key_at(field: &HeightField, settings: &Settings, shift: [f64; 2]) -> blake3::Hash {
    let mut hasher = blake3::Hasher::new();
    hasher.update(MAGIC);
    let terms = settings.terms.map_or(-1.0, |n| n as f64);
    let [dx, dy] = field.pixel_size();
    let numbers = [
        field.columns() as f64,
        field.rows() as f64,
        dx,
        dy,
        settings.sigma,
        settings.shortest_wavelength,
        settings.budget.interpolation,
        settings.budget.expansion,
        terms,
        f64::from(settings.basis as u8),
        settings.side_limit as f64,
    ];
    hasher.update(bytemuck::cast_slice(&numbers));
    hasher.update(bytemuck::cast_slice(field.heights()));
    // Most windows stand in the middle; their key has no shift.
    if shift != [0.0; 2] {
        hasher.update(bytemuck::cast_slice(&shift));
    }
    hasher.finalize()
}

/// The layers of `field` under `settings`, from the cache or made and kept there; beside them, why they could not be kept.
///
/// # Errors
/// As [`layers::compute`].
pub fn obtain(
    field: &HeightField,
    settings: &Settings,
    progress: &dyn Fn(usize, usize) -> Result<()>,
) -> Result<(Layers, Option<Error>)> {
    obtain_at(field, settings, [0.0; 2], progress)
}

/// As [`obtain`], with the centre of the window `shift` \[µm\] from that of the patch.
///
/// # Errors
/// As [`layers::compute`].
pub fn obtain_at(
    field: &HeightField,
    settings: &Settings,
    shift: [f64; 2],
    progress: &dyn Fn(usize, usize) -> Result<()>,
) -> Result<(Layers, Option<Error>)> {
    let folder = folder();
    let key = key_at(field, settings, shift);
    if let Some(layers) = folder.as_ref().and_then(|f| load(f, &key, settings.memory_limit)) {
        return Ok((layers, None));
    }
    let layers = layers::compute_at(field, settings, shift, progress)?;
    let kept = folder.map(|folder| store(&folder, &key, &layers));
    Ok((layers, kept.and_then(Result::err)))
}

/// Where the layers of `key` are kept in `folder`.
pub fn path(folder: &Path, key: &blake3::Hash) -> PathBuf {
    folder.join(format!("{}.layers", key.to_hex()))
}

/// The layers of `key` from `folder`, if they are there and whole. A damaged file counts as absent; it is replaced by the
/// next [`store`].
pub fn load(folder: &Path, key: &blake3::Hash, memory_limit: usize) -> Option<Layers> {
    let place = path(folder, key);
    // Asked before opening, since opening a pipe waits for its other end.
    let size = std::fs::metadata(&place).ok().filter(std::fs::Metadata::is_file)?.len();
    // Where there is none, making them says so.
    memory::ensure_room(size, "the spectra").ok()?;
    read(&mut File::open(&place).ok()?, size, key, memory_limit)
}

/// The layers of `key` in the next `size` bytes of `file`; `None` where they are not whole or not layers that this program
/// makes.
pub fn read(file: &mut impl Read, size: u64, key: &blake3::Hash, memory_limit: usize) -> Option<Layers> {
    let size = usize::try_from(size).ok()?;
    let head_bytes = MAGIC.len() + HASH + HEADER * 8;
    // The texels, and behind them the coefficients, which are little.
    const COEFFICIENTS: usize = 64 << 20;
    let limit = memory_limit.saturating_add(COEFFICIENTS);
    let payload = size.checked_sub(head_bytes + HASH).filter(|n| *n <= limit)?;
    let mut head = vec![0u8; head_bytes];
    file.read_exact(&mut head).ok()?;
    if head[..MAGIC.len() + HASH] != preamble(key) {
        return None;
    }
    let numbers: Vec<f64> = bytemuck::pod_collect_to_vec(&head[MAGIC.len() + HASH..]);
    let mut layers = from_numbers(&numbers, payload)?;
    file.read_exact(layers.texels.bytes_mut()).ok()?;
    file.read_exact(bytemuck::cast_slice_mut(&mut layers.coefficients.values)).ok()?;
    let mut sum = [0u8; HASH];
    file.read_exact(&mut sum).ok()?;
    (check_sum(&head, &layers) == sum).then_some(layers).filter(is_sound)
}

/// What a file of `key` begins with.
fn preamble(key: &blake3::Hash) -> Vec<u8> {
    [MAGIC.as_slice(), key.as_bytes()].concat()
}

/// A file of `key` whose numbers and texels are `body`, with the check sum that belongs to it: what a stranger would leave
/// in the folder who knows the format.
pub fn sealed(key: &blake3::Hash, body: &[u8]) -> Vec<u8> {
    let mut file = [&preamble(key), body].concat();
    let sum = *blake3::hash(&file).as_bytes();
    file.extend(sum);
    file
}

/// Whether `layers` are such as this program makes: what follows divides by their numbers, counts with them and makes
/// images of their sizes. The check sum finds accidents; it does not know who wrote it.
fn is_sound(layers: &Layers) -> bool {
    let l = layers;
    let positive = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite() && *x > 0.0);
    let rule = [l.pairs_needed.slope, l.pairs_needed.fewest];
    (0..2).all(|axis| l.origin[axis] < l.size[axis])
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

/// Writes the layers of `key` into `folder`.
///
/// # Errors
/// Where the folder or the file cannot be written; the layers are still good.
pub fn store(folder: &Path, key: &blake3::Hash, layers: &Layers) -> Result<()> {
    let place = path(folder, key);
    std::fs::create_dir_all(folder).map_err(|e| output::write_failed(folder, &e))?;
    sweep(folder);
    let mut head = MAGIC.to_vec();
    head.extend_from_slice(key.as_bytes());
    head.extend_from_slice(bytemuck::cast_slice(&to_numbers(layers)));
    let sum = check_sum(&head, layers);
    output::write_atomically(&place, |file| {
        std::iter::once(head.as_slice())
            .chain(payload(layers))
            .chain(std::iter::once(sum.as_slice()))
            .try_for_each(|part| file.write_all(part))
            .map_err(|e| output::write_failed(&place, &e))
    })
}

/// Takes away what programs that were killed while they wrote left in `folder`. What is in use is younger than a day.
pub fn sweep(folder: &Path) {
    const DAY: Duration = Duration::from_secs(24 * 60 * 60);
    for file in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let temporary = file.file_name().as_encoded_bytes().starts_with(output::TEMPORARY.as_bytes());
        let age = file.metadata().and_then(|m| m.modified()).ok().and_then(|time| time.elapsed().ok());
        if temporary && age.is_some_and(|age| age > DAY) {
            let _ = std::fs::remove_file(file.path()); // another process may have been faster
        }
    }
}

/// What stands behind the numbers, in order.
fn payload(layers: &Layers) -> [&[u8]; 2] {
    [layers.texels.bytes(), bytemuck::cast_slice(&layers.coefficients.values)]
}

fn check_sum(head: &[u8], layers: &Layers) -> [u8; HASH] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(head);
    for part in payload(layers) {
        hasher.update_rayon(part);
    }
    *hasher.finalize().as_bytes()
}

fn to_numbers(l: &Layers) -> [f64; HEADER] {
    let [sx, sy] = l.size.map(|n| n as f64);
    let [ox, oy] = l.origin.map(|n| n as f64);
    let [kx, ky] = l.interpolation.kernels.map(|kernel| f64::from(kernel == Kernel::Cubic));
    let [rx, ry] = l.interpolation.ratios;
    let flag = |b: bool| f64::from(b);
    let e = &l.errors;
    let counts = [l.terms, l.coefficients.columns].map(|n| n as f64);
    [
        [sx, sy, ox, oy, l.length[0], l.length[1], l.band[0], l.band[1]].as_slice(),
        &[l.sigma, l.z_max, kx, ky, rx, ry],
        &[flag(l.half_plane), flag(l.coefficients.taylor), l.coefficients.half_range],
        &counts,
        &[l.pairs_needed.slope, l.pairs_needed.fewest],
        &[e.expansion, e.interpolation, e.truncation_bound, e.rounding_bound],
    ]
    .concat()
    .into_iter()
    .chain([flag(l.texels.is_half())])
    .collect::<Vec<_>>()
    .try_into()
    .unwrap_or([0.0; HEADER])
}

/// A count of a file that fits into memory; products of four of them, and sixteen, fit a `u128`.
fn whole(n: f64) -> Option<usize> {
    const MOST: f64 = 1e6;
    ((0.0..=MOST).contains(&n) && n.fract() == 0.0).then_some(n as usize)
}

/// The product of `counts`, where it is no more than `most`.
fn product(counts: &[usize], most: usize) -> Option<usize> {
    counts.iter().try_fold(1usize, |all, n| all.checked_mul(*n)).filter(|n| *n <= most)
}

/// Layers of these numbers with room for their texels, which are `payload` bytes in all.
fn from_numbers(n: &[f64], payload: usize) -> Option<Layers> {
    let &[sx, sy, ox, oy, lx, ly, bx, by, sigma, z_max, kx, ky, rx, ry, ref rest @ ..] = n else {
        return None;
    };
    let &[half_plane, taylor, half_range, terms, columns, slope, fewest, ref rest @ ..] = rest else {
        return None;
    };
    let &[expansion, interpolation, truncation_bound, rounding_bound, half] = rest else { return None };
    let [sx, sy, ox, oy] = [whole(sx)?, whole(sy)?, whole(ox)?, whole(oy)?];
    let [terms, columns] = [whole(terms)?, whole(columns)?];
    let pairs = terms.div_ceil(2);
    let kernel = |cubic: f64| if cubic == 0.0 { Kernel::Linear } else { Kernel::Cubic };
    let layers = Layers {
        size: [sx, sy],
        origin: [ox, oy],
        length: [lx, ly],
        band: [bx, by],
        sigma,
        half_plane: half_plane != 0.0,
        terms,
        coefficients: Coefficients {
            taylor: taylor != 0.0,
            half_range,
            columns,
            values: vec![[0.0; 4]; product(&[pairs, columns], payload / 16)?],
        },
        z_max,
        pairs_needed: PairRule { slope, fewest },
        interpolation: Interpolation { kernels: [kernel(kx), kernel(ky)], ratios: [rx, ry] },
        errors: Errors { expansion, interpolation, truncation_bound, rounding_bound },
        texels: Texels::zeroed(half != 0.0, product(&[sx, sy, pairs, 4], payload / 2)?),
    };
    let bytes: usize = self::payload(&layers).iter().map(|part| part.len()).sum();
    (bytes == payload).then_some(layers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precompute::{Budget, compute};

    fn sample() -> (HeightField, Settings, Layers) {
        let heights = (0..256).map(|i| 0.05 * f64::from(i * 7 % 13) / 13.0).collect();
        let field = HeightField::new(16, 16, [0.1, 0.1], heights).unwrap();
        let settings = Settings {
            sigma: 1.0,
            shortest_wavelength: 0.38,
            budget: Budget { interpolation: 7e-2, expansion: 3.5e-2 },
            basis: crate::expansion::Basis::Taylor,
            terms: None,
            memory_limit: 1 << 28,
            side_limit: 16_384,
        };
        let layers = compute(&field, &settings, &|_, _| Ok(())).unwrap();
        (field, settings, layers)
    }

    #[test]
    fn what_is_stored_is_loaded_and_any_changed_byte_makes_it_absent() {
        let folder = tempfile::tempdir().unwrap();
        let (field, settings, layers) = sample();
        let key = key(&field, &settings);
        assert!(load(folder.path(), &key, 1 << 28).is_none());
        store(folder.path(), &key, &layers).unwrap();
        assert_eq!(load(folder.path(), &key, 1 << 28).as_ref(), Some(&layers));
        let place = path(folder.path(), &key);
        let whole = std::fs::read(&place).unwrap();
        for position in [0, 30, 60, 200, whole.len() / 2, whole.len() - 1] {
            let mut damaged = whole.clone();
            damaged[position] ^= 1;
            std::fs::write(&place, &damaged).unwrap();
            assert!(load(folder.path(), &key, 1 << 28).is_none(), "byte {position}");
        }
        for length in [0, 10, 100, whole.len() - 1] {
            std::fs::write(&place, &whole[..length]).unwrap();
            assert!(load(folder.path(), &key, 1 << 28).is_none(), "cut to {length}");
        }
        store(folder.path(), &key, &layers).unwrap();
        assert!(load(folder.path(), &key, 1 << 28).is_some());
    }

    /// The file of `key` with number `at` of its header, or one of its floats behind that, set to `value`, and a check sum
    /// that agrees.
    fn forged(whole: &[u8], key: &blake3::Hash, at: usize, value: &[u8]) -> Vec<u8> {
        let mut body = whole[MAGIC.len() + HASH..whole.len() - HASH].to_vec();
        body[at..at + value.len()].copy_from_slice(value);
        sealed(key, &body)
    }

    #[test]
    fn numbers_that_no_layers_have_make_a_file_absent_in_spite_of_its_check_sum() {
        let folder = tempfile::tempdir().unwrap();
        let (field, settings, layers) = sample();
        let key = key(&field, &settings);
        store(folder.path(), &key, &layers).unwrap();
        let whole = std::fs::read(path(folder.path(), &key)).unwrap();
        let load = |file: Vec<u8>| read(&mut file.as_slice(), file.len() as u64, &key, 1 << 28);
        let same = |at: usize| whole[MAGIC.len() + HASH..][at..at + 8].to_vec();
        assert_eq!(load(forged(&whole, &key, 0, &same(0))), Some(layers));
        let e = ["size", "size", "origin", "origin", "length", "length", "band", "band"];
        let names =
            [&e[..], &["sigma", "z_max", "kernel", "kernel", "ratio", "ratio", "half", "taylor"]].concat();
        let names = [&names[..], &["half_range", "terms", "columns", "slope", "fewest"]].concat();
        let flags = ["kernel", "half", "taylor"];
        for (number, name) in names.iter().enumerate().filter(|(_, n)| !flags.contains(n)) {
            for value in [f64::NAN, f64::INFINITY, -1.0, 0.0, 0.5, 1e18, 1e300] {
                let harmless = matches!(
                    (*name, value),
                    ("origin" | "slope" | "fewest" | "half_range", 0.0)
                        | ("slope" | "fewest", -1.0)
                        | ("sigma", f64::INFINITY)
                ) || (value > 0.0
                    && value.is_finite()
                    && ["length", "band", "sigma", "z_max", "ratio", "half_range", "slope", "fewest"]
                        .contains(name));
                let found = load(forged(&whole, &key, number * 8, &value.to_le_bytes()));
                assert_eq!(found.is_some(), harmless, "{name} {value}");
            }
        }
        for place in [HEADER * 8, whole.len() - MAGIC.len() - 2 * HASH - 4] {
            assert!(load(forged(&whole, &key, place, &f32::NAN.to_le_bytes())).is_none(), "{place}");
        }
    }

    #[test]
    fn every_input_changes_the_key() {
        let (field, settings, _) = sample();
        let first = key(&field, &settings);
        let mut heights = field.heights().to_vec();
        heights[17] += 1e-12;
        let other = HeightField::new(16, 16, [0.1, 0.1], heights).unwrap();
        assert_ne!(key(&other, &settings), first);
        assert_ne!(key(&field, &Settings { sigma: 1.1, ..settings }), first);
        let wider = Budget { interpolation: 8e-2, ..settings.budget };
        assert_ne!(key(&field, &Settings { budget: wider, ..settings }), first);
        assert_ne!(key(&field, &Settings { terms: Some(4), ..settings }), first);
        assert_ne!(key(&field, &Settings { shortest_wavelength: 0.4, ..settings }), first);
        assert_ne!(key(&field, &Settings { basis: crate::expansion::Basis::Optimal, ..settings }), first);
    }
}
