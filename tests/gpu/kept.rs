//! Reference pictures in f64 that take long to compute. They are kept as EXR files; each run computes a random part of them again.
//!
//! `DIFFRACT_KEEP_REFERENCES=1 make test ARGS="--test gpu"` computes all of them and writes the files.

use diffract::internals::notes::{self, Notes, PreparationRecord};
use diffract::internals::picture_file::{self, PictureFormat};
use diffract::internals::random::Random;
use diffract::internals::render::renderer::Picture;
use diffract::internals::vk::device::Device;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/gpu/references");

/// Environment variable under which references are computed and written to their files.
const KEEP: &str = "DIFFRACT_KEEP_REFERENCES";

/// Device whose directions the kept pictures are shaded for. Those of others differ at silhouettes, so that they compute their own.
const DEVICE: &str = "llvmpipe";

/// Name of the note that tells what a picture follows from.
const FOLLOWS_FROM: &str = "Command";

/// Share of the pixels of a kept picture that each run computes again.
const COMPUTED: f64 = 0.03;

/// Largest difference between a kept and a computed pixel, relative to the RMS of the picture. Versions of a driver round directions in their own way.
const ALLOWED: f64 = 1e-3;

/// Function that returns the picture of the pixels for which its argument is true; what it returns for others counts for nothing.
pub type ComputePixels<'a> = dyn FnMut(&dyn Fn(usize) -> bool) -> Vec<[f32; 4]> + 'a;

/// Name of a kept picture, and what it follows from.
pub struct Kept {
    /// Name of the file.
    pub name: String,
    /// Words for what the picture follows from. A picture with other words is refused.
    pub follows_from: String,
    /// Width and height \[pixels\].
    pub size: [u32; 2],
}

impl Kept {
    /// Returns the picture, RGBA.
    pub fn picture(&self, device: &Device, compute: &mut ComputePixels<'_>) -> Vec<[f32; 4]> {
        if !device.candidate().name.starts_with(DEVICE) {
            return compute(&|_| true);
        }
        if std::env::var_os(KEEP).is_some() {
            let picture = compute(&|_| true);
            self.write(&picture);
            return picture;
        }
        let kept = self.read();
        let part = random_part(kept.len());
        let computed = compute(&|pixel| part.contains(&pixel));
        let apart = farthest(&kept, &computed, part.clone());
        let name = &self.name;
        assert!(
            apart <= ALLOWED,
            "pixels {part:?} of the kept reference {name} are {apart:.1e} off. If the reference has changed on purpose, compute it again with {KEEP}=1"
        );
        kept
    }

    fn path(&self) -> PathBuf {
        Path::new(FOLDER).join(&self.name).with_extension("exr")
    }

    fn write(&self, picture: &[[f32; 4]]) {
        let picture =
            Picture { size: self.size, radiance: picture.to_vec(), display: Vec::new(), is_opaque: false };
        let notes = Notes::new(self.follows_from.clone(), &PreparationRecord::default());
        picture_file::write(&self.path(), PictureFormat::Exr, &picture, &notes).unwrap();
    }

    /// Returns the picture of the file.
    fn read(&self) -> Vec<[f32; 4]> {
        let (path, remedy) = (self.path(), format!("compute it with {KEEP}=1"));
        assert!(path.exists(), "there is no reference {}: {remedy}", path.display());
        let found = picture_file::note(&path, FOLLOWS_FROM).unwrap_or_default();
        assert_eq!(found, notes::ascii(&self.follows_from), "{} is of something else: {remedy}", self.name);
        let picture = image::open(&path).unwrap().into_rgba32f();
        assert_eq!(picture.dimensions(), self.size.into(), "{}: {remedy}", self.name);
        picture.pixels().map(|pixel| pixel.0).collect()
    }
}

/// Returns consecutive pixels that are a random part of `count`, another one in each call.
fn random_part(count: usize) -> std::ops::Range<usize> {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    let length = (COMPUTED * count as f64).ceil() as usize;
    let start = (Random::new(since.as_nanos() as u64).share() * (count - length + 1) as f64) as usize;
    start..start + length
}

/// Returns the largest difference of a component over the pixels of `part`, relative to the RMS of `kept`.
fn farthest(kept: &[[f32; 4]], computed: &[[f32; 4]], part: std::ops::Range<usize>) -> f64 {
    assert_eq!(kept.len(), computed.len());
    let squares: f64 = kept.iter().flatten().map(|&x| f64::from(x).powi(2)).sum();
    let rms = (squares / (4 * kept.len()) as f64).sqrt();
    let components = kept[part.clone()].iter().flatten().zip(computed[part].iter().flatten());
    // NaN is as far as can be.
    let differences = components.map(|(a, b)| f64::from(a - b).abs() / rms);
    differences.fold(0.0, |most, d| if d.is_finite() { most.max(d) } else { f64::INFINITY })
}

#[test]
fn a_kept_picture_that_differs_by_a_hundredth_is_seen() {
    let picture: Vec<[f32; 4]> = (0..200).map(|i| [0.1 + 0.01 * i as f32, 1.0, -0.3, 1.0]).collect();
    let mut other = picture.clone();
    for pixel in &mut other {
        pixel[1] *= 1.01;
    }
    for _ in 0..100 {
        let part = random_part(picture.len());
        assert!(part.len() == 6 && part.end <= picture.len(), "{part:?}");
        assert!(farthest(&picture, &picture, part.clone()) == 0.0);
        assert!(farthest(&picture, &other, part) > 2.0 * ALLOWED);
    }
    other[3][0] = f32::NAN;
    assert!(farthest(&picture, &other, 0..200) > ALLOWED);
}

#[test]
#[should_panic(expected = "there is no reference")]
fn a_picture_that_is_not_kept_is_refused() {
    Kept { name: "none".to_owned(), follows_from: "nothing".to_owned(), size: [1, 1] }.read();
}
