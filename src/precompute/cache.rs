//! Layers kept on disk, under a key made of everything that they depend on.

use super::coefficients::{Coefficients, Source};
use super::kernel::{Interpolation, Kernel};
use super::layers::{self, Errors, Layers, Settings};
use super::lines::Lines;
use super::near;
use super::pairs::PairRule;
use super::texels::Texels;
use crate::cache::{Format, Key, Payload, Store};
use crate::error::{Error, Result};
use crate::surface::HeightField;
use serde::{Deserialize, Serialize};

/// Kept layers; the version changes whenever the layers of the same key would change.
pub const FORMAT: Format = Format { name: "layers", version: 11 };

/// Most bytes of the coefficients, beside the texels.
const LARGEST_COEFFICIENTS: u64 = 64 << 20;

/// The key of the layers of `field` under `settings`, for a window whose centre is `shift` \[µm\] from that of the patch.
///
/// # Errors
/// As [`Key::new`].
pub fn key(field: &HeightField, settings: &Settings, shift: [f64; 2]) -> Result<Key> {
    #[derive(Serialize)]
    struct Depends<'a> {
        settings: &'a Settings,
        shift: [f64; 2],
    }
    Key::new(&FORMAT, &Depends { settings, shift }, field)
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
    let key = key(field, settings, shift)?;
    let store = Store::open();
    if let Some(layers) = store.as_ref().and_then(|store| load(store, &key, settings.memory_limit)) {
        return Ok((layers, None));
    }
    let layers = layers::compute_at(field, settings, shift, progress)?;
    let kept = store.map(|store| save(&store, &key, &layers));
    Ok((layers, kept.and_then(Result::err)))
}

/// The layers of `key` from `store`, whose texels take at most `memory_limit` bytes.
pub fn load(store: &Store, key: &Key, memory_limit: usize) -> Option<Layers> {
    store.load(&FORMAT, key, (memory_limit as u64).saturating_add(LARGEST_COEFFICIENTS), build)
}

/// Keeps the layers of `key` in `store`.
///
/// # Errors
/// As [`Store::save`].
pub fn save(store: &Store, key: &Key, layers: &Layers) -> Result<()> {
    let lines = layers.lines.as_ref().map_or(&[][..], |lines| lines.texels.bytes());
    let coefficients = bytemuck::cast_slice(&layers.coefficients.values);
    store.save(&FORMAT, key, &Header::of(layers), &[layers.texels.bytes(), lines, coefficients])
}

/// Everything of [`Layers`] but texels and coefficients.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Header {
    size: [usize; 2],
    origin: [usize; 2],
    length: [f64; 2],
    band: [f64; 2],
    /// Absent where it is infinite.
    sigma: Option<f64>,
    half_plane: bool,
    z_bands: usize,
    terms: usize,
    columns: usize,
    source: Source,
    z_max: f64,
    pairs_needed: PairRule,
    kernels: [Kernel; 2],
    ratios: [f64; 2],
    errors: Errors,
    half_floats: bool,
    lines: Option<LinesHeader>,
}

/// Everything of [`Lines`] but the texels.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct LinesHeader {
    from: f64,
    level: f64,
    across: [f64; 2],
    along: [f64; 2],
    kernel: Kernel,
    size: [usize; 2],
    origin: [usize; 2],
    near: Vec<[usize; 2]>,
    grouped: usize,
    half_floats: bool,
}

impl Header {
    fn of(l: &Layers) -> Self {
        Self {
            size: l.size,
            origin: l.origin,
            length: l.length,
            band: l.band,
            sigma: l.sigma.is_finite().then_some(l.sigma),
            half_plane: l.half_plane,
            z_bands: l.z_bands,
            terms: l.terms,
            columns: l.coefficients.columns,
            source: l.coefficients.source,
            z_max: l.z_max,
            pairs_needed: l.pairs_needed,
            kernels: l.interpolation.kernels,
            ratios: l.interpolation.ratios,
            errors: l.errors,
            half_floats: l.texels.is_half(),
            lines: l.lines.as_ref().map(|lines| LinesHeader {
                from: lines.from,
                level: lines.level,
                across: lines.across,
                along: lines.along,
                kernel: lines.kernel,
                size: lines.size,
                origin: lines.origin,
                near: lines.near.clone(),
                grouped: lines.grouped,
                half_floats: lines.texels.is_half(),
            }),
        }
    }
}

/// The layers of `header` and `payload`; `None` where they are not such as this program makes.
pub fn build(header: Header, payload: &mut Payload<'_>) -> Option<Layers> {
    let h = header;
    let [sx, sy] = h.size;
    let pairs = h.terms.div_ceil(2);
    let texels = texels(payload, h.half_floats, &[sx, sy, pairs, h.z_bands, 4])?;
    let lines = match h.lines {
        None => None,
        Some(lines) => Some(build_lines(lines, pairs, h.z_bands, payload)?),
    };
    let values = payload.take(product(&[pairs, h.z_bands, h.columns])?)?;
    let layers = Layers {
        size: h.size,
        origin: h.origin,
        length: h.length,
        band: h.band,
        sigma: h.sigma.unwrap_or(f64::INFINITY),
        half_plane: h.half_plane,
        z_bands: h.z_bands,
        terms: h.terms,
        coefficients: Coefficients { columns: h.columns, source: h.source, values },
        z_max: h.z_max,
        pairs_needed: h.pairs_needed,
        interpolation: Interpolation { kernels: h.kernels, ratios: h.ratios },
        errors: h.errors,
        texels,
        lines,
    };
    Some(layers).filter(is_sound)
}

/// Lines of `pairs` pairs in each of `bands` bands.
fn build_lines(h: LinesHeader, pairs: usize, bands: usize, payload: &mut Payload<'_>) -> Option<Lines> {
    // Products of sizes are taken before they are checked below.
    let most = h.size.iter().chain(&h.origin).chain(h.near.iter().flatten()).chain([&h.grouped]);
    if h.near.len() != near::OCTAVES
        || h.grouped == 0
        || most.into_iter().any(|n| *n > LARGEST_COUNT)
        || bands > LARGEST_COUNT
    {
        return None;
    }
    let empty = Lines {
        from: h.from,
        level: h.level,
        across: h.across,
        along: h.along,
        kernel: h.kernel,
        size: h.size,
        origin: h.origin,
        near: h.near,
        grouped: h.grouped,
        texels: Texels::zeroed(false, 0),
    };
    let counts = [h.size[0], h.size[1], h.grouped, empty.layers(pairs, bands), 4];
    Some(Lines { texels: texels(payload, h.half_floats, &counts)?, ..empty })
}

/// Larger than any side and any number of layers; products of two fit a `usize`.
const LARGEST_COUNT: usize = 1_000_000;

fn product(counts: &[usize]) -> Option<usize> {
    counts.iter().try_fold(1usize, |all, n| all.checked_mul(*n))
}

fn texels(payload: &mut Payload<'_>, half: bool, counts: &[usize]) -> Option<Texels> {
    let count = product(counts)?;
    Some(if half { Texels::Half(payload.take(count)?) } else { Texels::Single(payload.take(count)?) })
}

/// Whether `layers` are such as this program makes: what follows divides by their numbers, counts with them and makes
/// images of their sizes. The check sum finds accidents; it does not know who wrote it.
fn is_sound(layers: &Layers) -> bool {
    let l = layers;
    let positive = |numbers: &[f64]| numbers.iter().all(|x| x.is_finite() && *x > 0.0);
    let rule = [l.pairs_needed.slope, l.pairs_needed.fewest];
    (0..2).all(|axis| l.origin[axis] < l.size[axis])
        && [l.size[0], l.size[1], l.terms, l.z_bands].iter().all(|n| *n <= LARGEST_COUNT)
        && positive(&[l.length, l.band, l.interpolation.ratios].concat())
        && positive(&[l.z_max])
        && l.sigma > 0.0
        && l.terms >= 1
        && l.z_bands >= 1
        && l.coefficients.columns >= 2
        && rule.iter().all(|x| x.is_finite())
        && l.texels.are_finite()
        && l.lines.iter().all(|lines| {
            let inside = |origin: &[usize; 2]| (0..2).all(|axis| origin[axis] < lines.size[axis]);
            inside(&lines.origin)
                && lines.near.iter().all(inside)
                && positive(&[lines.across, lines.along, [lines.from, lines.level]].concat())
                && (1..=l.pairs() + 1).contains(&lines.grouped)
                && lines.texels.are_finite()
        })
        && l.coefficients.values.iter().flatten().all(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cache::{read, seal};
    use crate::precompute::lines::Spacing;
    use crate::precompute::{Aim, Budget, compute};
    use serde_json::{Value, json};

    fn sample() -> (HeightField, Settings, Layers) {
        let heights = (0..256).map(|i| 0.05 * f64::from(i * 7 % 13) / 13.0).collect();
        let field = HeightField::new(16, 16, [0.1, 0.1], heights).unwrap();
        let settings = Settings {
            sigma: 1.0,
            shortest_wavelength: 0.38,
            budget: Budget { interpolation: 7e-2, expansion: 3.5e-2 },
            basis: crate::expansion::Basis::Taylor,
            terms: None,
            aim: Aim::FewTransforms,
            lines: None,
            memory_limit: 1 << 28,
            side_limit: 16_384,
        };
        let layers = compute(&field, &settings, &|_, _| Ok(())).unwrap();
        (field, settings, layers)
    }

    fn centred(field: &HeightField, settings: &Settings) -> Key {
        key(field, settings, [0.0; 2]).unwrap()
    }

    #[test]
    fn what_is_saved_is_loaded_and_any_changed_byte_makes_it_absent() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::at(folder.path().join("cache"), 1 << 28);
        let (field, settings, layers) = sample();
        let key = centred(&field, &settings);
        assert!(load(&store, &key, 1 << 28).is_none());
        save(&store, &key, &layers).unwrap();
        assert_eq!(load(&store, &key, 1 << 28).as_ref(), Some(&layers));
        let place = store.path(&FORMAT, &key);
        let whole = std::fs::read(&place).unwrap();
        for position in [0, 30, 60, 200, whole.len() / 2, whole.len() - 1] {
            let mut damaged = whole.clone();
            damaged[position] ^= 1;
            std::fs::write(&place, &damaged).unwrap();
            assert!(load(&store, &key, 1 << 28).is_none(), "byte {position}");
        }
        for length in [0, 10, 100, whole.len() - 1] {
            std::fs::write(&place, &whole[..length]).unwrap();
            assert!(load(&store, &key, 1 << 28).is_none(), "cut to {length}");
        }
        save(&store, &key, &layers).unwrap();
        assert!(load(&store, &key, 1 << 28).is_some());
    }

    #[test]
    fn numbers_that_no_layers_have_make_a_file_absent_in_spite_of_its_check_sum() {
        let (_, _, layers) = sample();
        let key = Key::named("layers");
        let coefficients: &[u8] = bytemuck::cast_slice(&layers.coefficients.values);
        let payload = [layers.texels.bytes(), coefficients].concat();
        let found = |header: &Value, payload: &[u8]| {
            let file = seal(&FORMAT, &key, header, payload);
            read(&mut file.as_slice(), file.len() as u64, &FORMAT, &key, 1 << 28, build)
        };
        let sound = serde_json::to_value(Header::of(&layers)).unwrap();
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
                // What the layers are accurate to is told to the user only.
                let harmless = is(&["errors"])
                    || value <= 0.0 && is(&["pairs_needed"])
                    || value > 0.0 && is(&["length", "band", "sigma", "z_max", "ratios", "pairs_needed"]);
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

    /// The paths of all numbers in `value`.
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
        // A setting that is added has to be varied below.
        let Settings {
            sigma,
            shortest_wavelength,
            budget: Budget { interpolation, expansion },
            basis: _,
            terms: _,
            aim: _,
            lines: _,
            memory_limit,
            side_limit,
        } = settings;
        let lines = |sigma: f64, level: f64, across: f64, fewest: f64, interpolation: f64| {
            let lines = Spacing::new(sigma, (level, across), fewest, 5.0, interpolation);
            Settings { lines: Some(lines.unwrap()), ..settings }
        };
        let others = [
            Settings { sigma: sigma * 1.1, ..settings },
            Settings { sigma: f64::INFINITY, ..settings },
            Settings { shortest_wavelength: shortest_wavelength + 0.02, ..settings },
            Settings { budget: Budget { interpolation: interpolation + 1e-2, expansion }, ..settings },
            Settings { budget: Budget { interpolation, expansion: expansion + 1e-9 }, ..settings },
            Settings { basis: crate::expansion::Basis::Optimal, ..settings },
            Settings { terms: Some(4), ..settings },
            Settings { terms: Some(5), ..settings },
            Settings { aim: Aim::FewSamples, ..settings },
            Settings { side_limit: side_limit / 2, ..settings },
            lines(1.0, 1e-2, 8.0, 4.0, 1e-2),
            lines(1.0, 1e-2, 8.0, 5.0, 1e-2),
            lines(1.0, 2e-2, 8.0, 4.0, 1e-2),
            lines(1.0, 1e-2, 9.0, 4.0, 1e-2),
            lines(1.0, 1e-2, 8.0, 4.0, 1e-3),
        ];
        let mut keys: Vec<Key> = others.iter().map(|other| centred(&field, other)).collect();
        keys.extend([[0.1, 0.0], [0.0, 0.1]].map(|shift| key(&field, &settings, shift).unwrap()));
        keys.push(first);
        let different: std::collections::HashSet<Key> = keys.iter().copied().collect();
        assert_eq!(different.len(), keys.len());
        // It decides whether there are layers, not which.
        assert_eq!(centred(&field, &Settings { memory_limit: memory_limit / 2, ..settings }), first);
    }
}
