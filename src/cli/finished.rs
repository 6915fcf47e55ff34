//! Pictures of a sequence that an earlier run finished: each file has notes of its settings and a hash of its contents.

use crate::cache::{EntryFormat, Key};
use crate::error::{self, Error, Result};
use crate::input::PictureFile;
use crate::memory;
use crate::notes::Notes;
use crate::picture_file::{self, PictureFormat};
use crate::render::frame::View;
use crate::render::object::ObjectTextures;
use crate::render::renderer::Picture;
use crate::render::sequence::Sequence;
use crate::scene::{Mesh, Object, Scene};
use crate::setup::ObjectSurface;
use image::{DynamicImage, ImageFormat};
use std::fmt::Debug;
use std::path::Path;

/// Name of the note whose value is [`SequenceOrigin::note`].
pub const NOTE: &str = "Drawn from";

/// Format of the hashed settings. Its version changes whenever the same settings lead to another picture.
const SEQUENCES: EntryFormat = EntryFormat { name: "sequences", version: 1 };

/// Hash of everything that the pictures of a sequence depend on.
pub struct SequenceOrigin(Key);

impl SequenceOrigin {
    /// Returns the origin of `sequence`, which begins with the view `first` of `scene`, whose objects have these `surfaces`, at an exposure
    /// that is `measured` or the scene's. It depends on the contents of files, not on their names.
    ///
    /// # Errors
    /// A picture that cannot be read: a pigment texture, or a map of grooves.
    pub fn of(
        sequence: &Sequence,
        first: &View,
        (scene, measured): (&Scene, bool),
        surfaces: &[ObjectSurface],
        settings: &impl Debug,
    ) -> Result<Self> {
        let hash = |bytes: &[u8]| blake3::hash(bytes).to_hex().to_string();
        let mesh = |mesh: &Mesh| {
            let [vertices, indices]: [&[u8]; 2] =
                [bytemuck::cast_slice(mesh.vertices()), bytemuck::cast_slice(mesh.indices())];
            [hash(vertices), hash(indices)]
        };
        let meshes: Vec<_> = scene.meshes().map(mesh).collect();
        let texture = |object: &ObjectTextures| {
            let ObjectTextures { pigment, grooves } = object;
            let map = hash(bytemuck::cast_slice(&grooves.texels));
            (pigment.size, hash(&pigment.texels), grooves.layout, grooves.turn, grooves.size, map)
        };
        let textures: Vec<_> = ObjectTextures::of(scene)?.iter().map(texture).collect();
        let other = |(object, surface): (&Object, &ObjectSurface)| {
            let field = surface.field.as_ref();
            let field = field
                .map(|f| ([f.columns(), f.rows()], f.pixel_size(), hash(bytemuck::cast_slice(f.heights()))));
            (object.base_color, object.is_ground, field, surface.source.clone())
        };
        let others: Vec<_> = scene.objects.iter().zip(surfaces).skip(1).map(other).collect();
        let shown =
            (scene.display.exposure, measured, scene.display.tone, scene.display.background, scene.shadows);
        // Rust writes numbers so that they are read back exactly.
        let turned = (sequence.motion, sequence.count, first);
        let settings = format!("{:?}", (turned, shown, meshes, textures, others, settings));
        let field = surfaces[0].field.as_deref();
        let nothing = || Error::bug("the first object has no surface");
        Key::new(&SEQUENCES, &settings, field.ok_or_else(nothing)?).map(Self)
    }

    /// Returns the note of picture number `frame`.
    pub fn note(&self, frame: u32) -> String {
        format!("{}, picture {frame}", self.0.to_hex())
    }
}

/// State of a picture file of an earlier run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeptPicture {
    /// No file.
    Missing,
    /// Complete file.
    Finished,
    /// File of this picture, cut short or changed.
    Damaged,
}

/// Returns the state of the file `path` of the picture with this `note`.
///
/// # Errors
/// A file with another note: no file is overwritten, and no sequence mixes pictures of different settings.
pub fn frame(path: &Path, note: &str) -> Result<KeptPicture> {
    if !path.exists() {
        return Ok(KeptPicture::Missing);
    }
    if picture_file::note(path, NOTE).is_some_and(|found| found == note) {
        return Ok(if is_whole(path) { KeptPicture::Finished } else { KeptPicture::Damaged });
    }
    Err(Error::usage(
        "is there already and is not this picture under these settings",
        "remove it and the rest of its sequence, or give the output another name",
    )
    .at(path.display()))
}

/// Name of the note with the hash of the other notes and the pixels; the last note of a file.
const SEAL: &str = "Hash";

/// Adds to `notes` of the file of `picture` the hash that [`frame`] checks.
pub fn sealed(mut notes: Notes, format: PictureFormat, picture: &Picture) -> Notes {
    let text = picture_file::text(format, &notes);
    let hash = hash(&text, picture.size, &picture_file::pixels(format, picture));
    notes.more.push((SEAL.to_owned(), hash));
    notes
}

fn hash(text: &str, size: [u32; 2], pixels: &[u8]) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes());
    hasher.update(bytemuck::cast_slice(&size)).update_rayon(pixels);
    hasher.finalize().to_hex().to_string()
}

/// Returns true if the picture file `path` has the notes and the pixels whose hash it names.
fn is_whole(path: &Path) -> bool {
    let Some(said) = picture_file::text_of(path) else { return false };
    let Some((text, named)) = said.rsplit_once(&format!("\n{SEAL}: ")) else { return false };
    let Ok((size, pixels)) = decoded(path) else { return false }; // a damaged picture is drawn again
    hash(text, size, &pixels) == named
}

/// Reads size and pixels of a picture file.
fn decoded(path: &Path) -> Result<([u32; 2], Vec<u8>)> {
    const PICTURE: PictureFile = PictureFile {
        formats: &[ImageFormat::Png, ImageFormat::OpenExr],
        names: "neither PNG nor EXR",
        expected: "a picture of diffract",
        role: "a picture",
        side: u32::MAX,
    };
    let unreadable =
        |e: std::io::Error| Error::files(error::cause(&e), "check the file").caused_by(e).at(path.display());
    let bytes = std::fs::read(path).map_err(unreadable)?;
    // The decoder does not look for the end of a PNG.
    const END_OF_PNG: &[u8] = b"\0\0\0\0IEND\xaeB`\x82";
    if PictureFormat::of(path)? == PictureFormat::Png && !bytes.ends_with(END_OF_PNG) {
        return Err(Error::input("the PNG has no end", "draw it again").at(path.display()));
    }
    let [width, height] = PICTURE.size(&bytes)?;
    /// Four floats, as decoded and as kept.
    const BYTES: u64 = 32;
    memory::ensure_room(
        u64::from(width).saturating_mul(u64::from(height)).saturating_mul(BYTES),
        "the picture",
    )?;
    let pixels = match PICTURE.decode(&bytes)? {
        DynamicImage::ImageRgba8(codes) => codes.into_raw(),
        radiance => bytemuck::cast_slice(radiance.into_rgba32f().as_raw()).to_vec(),
    };
    Ok(([width, height], pixels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::notes::PreparationRecord;

    /// Returns a picture with the notes of a frame in both formats.
    fn written(folder: &Path) -> Vec<std::path::PathBuf> {
        let count = 40 * 30;
        let picture = Picture {
            size: [40, 30],
            radiance: (0..count)
                .map(|i| [(i as f32 * 0.37).sin(), -1.5, 2.0, (i % 5) as f32 / 4.0])
                .collect(),
            // Hashes do not become shorter by compression: most of the file is pixels.
            display: (0..count)
                .map(|i: u32| blake3::hash(&i.to_le_bytes()).as_bytes()[..4].try_into().unwrap())
                .collect(),
            is_opaque: false,
        };
        let write = |name: &str| {
            let path = folder.join(name);
            let format = PictureFormat::of(&path).unwrap();
            let mut notes =
                Notes::new("diffract render plätze".to_owned(), &PreparationRecord::parse("despike"))
                    .with_scalar_theory("λ ≪ d".to_owned());
            notes.more.push((NOTE.to_owned(), "a key, picture 3".to_owned()));
            picture_file::write(&path, format, &picture, &sealed(notes, format, &picture)).unwrap();
            path
        };
        ["a.png", "a.exr"].map(write).into()
    }

    #[test]
    fn a_frame_that_is_cut_or_changed_anywhere_is_never_kept() {
        let folder = tempfile::tempdir().unwrap();
        for path in written(folder.path()) {
            let state = || frame(&path, "a key, picture 3");
            assert_eq!(state().unwrap(), KeptPicture::Finished, "{}", path.display());
            assert!(frame(&path, "a key, picture 4").is_err(), "another picture");
            let whole = std::fs::read(&path).unwrap();
            // A file that is cut before its notes is refused; the notes of so small a picture are longer than its pixels.
            std::fs::write(&path, &whole[..whole.len() - 20]).unwrap();
            assert_eq!(state().unwrap(), KeptPicture::Damaged, "most of {}", path.display());
            for cut in [0, 10, whole.len() / 10, whole.len() - 1] {
                std::fs::write(&path, &whole[..cut]).unwrap();
                assert_ne!(state().ok(), Some(KeptPicture::Finished), "{cut} of {}", path.display());
            }
            for place in (whole.len() / 2..whole.len()).step_by(97) {
                let mut changed = whole.clone();
                changed[place] ^= 0x40;
                std::fs::write(&path, &changed).unwrap();
                assert_ne!(state().ok(), Some(KeptPicture::Finished), "byte {place} of {}", path.display());
            }
            std::fs::write(&path, &whole).unwrap();
            assert_eq!(state().unwrap(), KeptPicture::Finished);
            std::fs::remove_file(&path).unwrap();
            assert_eq!(state().unwrap(), KeptPicture::Missing);
        }
    }
}
