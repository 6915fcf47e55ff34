//! Which pictures of a sequence an earlier run finished: each says in its file what it was drawn from.

use crate::cache::{EntryFormat, Key};
use crate::error::{Error, Result};
use crate::picture_file;
use crate::render::frame::View;
use crate::render::object::ObjectTextures;
use crate::render::sequence::Sequence;
use crate::scene::{Mesh, Object, Scene};
use crate::setup::ObjectSurface;
use std::fmt::Debug;
use std::path::Path;

/// The note of a picture file that [`SequenceOrigin::note`] is the value of.
pub const NOTE: &str = "Drawn from";

/// What the hash is of. Its version changes whenever the same settings lead to another picture.
const SEQUENCES: EntryFormat = EntryFormat { name: "sequences", version: 1 };

/// Everything that a sequence follows from.
pub struct SequenceOrigin(Key);

impl SequenceOrigin {
    /// Of `sequence`, which begins with the view `first` of `scene`, whose objects have these `surfaces`, at an exposure that is `measured` or the
    /// scene's. What files hold counts, and not their names.
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
        let texture = |own: &ObjectTextures| {
            let ObjectTextures { pigment, grooves } = own;
            let map = hash(bytemuck::cast_slice(&grooves.texels));
            (pigment.size, hash(&pigment.texels), grooves.layout, grooves.turn, grooves.size, map)
        };
        let textures: Vec<_> = ObjectTextures::of(scene)?.iter().map(texture).collect();
        let other = |(object, surface): (&Object, &ObjectSurface)| {
            let field = surface.field.as_ref();
            let field = field
                .map(|f| ([f.columns(), f.rows()], f.pixel_size(), hash(bytemuck::cast_slice(f.heights()))));
            (object.base_color, object.is_ground, field, surface.optics.clone())
        };
        let others: Vec<_> = scene.objects.iter().zip(&surfaces[1..]).map(other).collect();
        let shown = (scene.exposure, measured, scene.tone, scene.background, scene.shadows);
        // Rust writes numbers so that they are read back exactly.
        let turned = (sequence.motion, sequence.count, first);
        let settings = format!("{:?}", (turned, shown, meshes, textures, others, settings));
        let field = surfaces[0].field.as_deref();
        let nothing = || Error::failed("the first object has no surface", "report this as a bug of diffract");
        Key::new(&SEQUENCES, &settings, field.ok_or_else(nothing)?).map(Self)
    }

    /// What picture number `frame` says of itself.
    pub fn note(&self, frame: u32) -> String {
        format!("{}, picture {frame}", self.0.to_hex())
    }
}

/// Whether the file `path` is there and is the picture that says `note` of itself.
///
/// # Errors
/// Where the file is another one: nothing that is there is written over, and no sequence has pictures of two kinds.
pub fn is_there(path: &Path, note: &str) -> Result<bool> {
    if !path.exists() {
        return Ok(false);
    }
    if picture_file::note(path, NOTE).is_some_and(|own| own == note) {
        return Ok(true);
    }
    Err(Error::usage(
        "is there already and is not this picture under these settings",
        "remove it and the rest of its sequence, or give the output another name",
    )
    .at(path.display()))
}
