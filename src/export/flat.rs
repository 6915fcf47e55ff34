//! Texels of a colour table and its functions as plain OpenEXR images, which any loader opens: no levels, no arrays.
//!
//! `table2d.exr` has 16-bit floats. Of each level all layers stand side by side in rows, from the first on, and the rows of the next level below; a row of a level
//! has twice as many layers as one of the finer level, so that all rows are equally long. The first line of a layer is that of the smallest y of light + viewer, as in the
//! KTX2 file. `functions.exr` has 32-bit floats, line by line those of `functions.ktx2`.

use super::ktx2::function_rows;
use crate::error::{Error, Result};
use crate::table::{ColorTable, SPECULAR_SAMPLES, TableHeader};
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer, LayerAttributes, WritableImage,
};
use half::f16;
use std::io::Cursor;

/// Places of the layers of all levels in one image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FlatLayout {
    /// Texels along a side of a layer of the finest level.
    pub side: usize,
    /// Layers of each level.
    pub layers: usize,
    /// Layers in a row of the finest level.
    pub columns: usize,
    /// Number of levels.
    levels: usize,
}

impl FlatLayout {
    /// Returns the places for the table of `header`, in an image that is about as wide as high.
    pub fn new(header: &TableHeader) -> Self {
        /// Texels of all levels over those of the finest.
        const ALL_LEVELS: f64 = 4.0 / 3.0;
        let layers = header.layers();
        let columns = (ALL_LEVELS * layers as f64).sqrt().round() as usize;
        Self { side: header.grid.side, layers, columns: columns.max(1), levels: header.grid.mips() }
    }

    /// Returns the width of the image.
    pub fn width(&self) -> usize {
        self.columns * self.side
    }

    /// Returns the height of the image.
    pub fn height(&self) -> usize {
        self.first_row(self.levels)
    }

    /// Returns the first line of a level.
    fn first_row(&self, level: usize) -> usize {
        (0..level).map(|finer| (self.side >> finer) * self.layers.div_ceil(self.columns << finer)).sum()
    }

    /// Returns the place (x, y) of the first texel of a layer.
    fn corner(&self, level: usize, layer: usize) -> [usize; 2] {
        let (side, columns) = (self.side >> level, self.columns << level);
        [layer % columns * side, self.first_row(level) + layer / columns * side]
    }
}

/// Returns the file of the texels of `table`.
///
/// # Errors
/// Numbers that the format cannot hold, which is a bug.
pub fn write(table: &ColorTable) -> Result<Vec<u8>> {
    let layout = FlatLayout::new(&table.header);
    let [width, height] = [layout.width(), layout.height()];
    let mut image = vec![[f16::ZERO; 4]; width * height];
    for (level, numbers) in table.mips.iter().enumerate() {
        let side = layout.side >> level;
        let (texels, _) = numbers.as_chunks::<4>();
        for (layer, texels) in texels.chunks_exact(side * side).enumerate() {
            let [x, y] = layout.corner(level, layer);
            for (line, texels) in texels.chunks_exact(side).enumerate() {
                image[(y + line) * width + x..][..side].copy_from_slice(texels);
            }
        }
    }
    let channel = |i: usize| FlatSamples::F16(image.iter().map(|texel| texel[i]).collect());
    encoded([width, height], channel)
}

/// Returns the file of the functions of the table of `header`.
///
/// # Errors
/// Same as [`write()`].
pub fn write_functions(header: &TableHeader) -> Result<Vec<u8>> {
    let texels = function_rows(header);
    let channel = |i: usize| FlatSamples::F32(texels.iter().map(|texel| texel[i]).collect());
    encoded([SPECULAR_SAMPLES, texels.len() / SPECULAR_SAMPLES], channel)
}

/// Returns the file of an image whose channels R, G, B and A `channel` returns by their numbers.
fn encoded([width, height]: [usize; 2], channel: impl Fn(usize) -> FlatSamples) -> Result<Vec<u8>> {
    let named = |(i, name): (usize, &str)| AnyChannel::new(name, channel(i));
    let channels = AnyChannels::sort(["R", "G", "B", "A"].into_iter().enumerate().map(named).collect());
    let layer = Layer::new((width, height), LayerAttributes::default(), Encoding::SMALL_LOSSLESS, channels);
    let mut file = Cursor::new(Vec::new());
    Image::from_layer(layer)
        .write()
        .to_buffered(&mut file)
        .map_err(|e| Error::bug(format!("an image cannot be written as OpenEXR ({e})")).caused_by(e))?;
    Ok(file.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::conformance::tests::small_table;
    use exr::prelude::{MetaData, read_all_flat_layers_from_file};

    /// Returns the texels of an image file of one part without a name, and its size.
    fn read(bytes: &[u8]) -> (Vec<[f32; 4]>, [usize; 2]) {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), bytes).unwrap();
        let meta = MetaData::read_from_file(file.path(), true).unwrap();
        assert!(meta.headers.len() == 1 && meta.headers[0].own_attributes.layer_name.is_none());
        let image = read_all_flat_layers_from_file(file.path()).unwrap();
        let layer = &image.layer_data[0];
        let mut texels = vec![[0.0; 4]; layer.size.area()];
        for channel in &layer.channel_data.list {
            let i = ["R", "G", "B", "A"].iter().position(|name| channel.name.eq(name)).unwrap();
            let values = channel.sample_data.values_as_f32();
            texels.iter_mut().zip(values).for_each(|(texel, value)| texel[i] = value);
        }
        (texels, [layer.size.x(), layer.size.y()])
    }

    #[test]
    fn every_texel_stands_once_where_the_reading_function_looks() {
        let (_, table) = small_table();
        let layout = FlatLayout::new(&table.header);
        let (texels, [width, height]) = read(&write(&table).unwrap());
        assert_eq!([width, height], [layout.width(), layout.height()]);
        let mut read_texels = vec![false; texels.len()];
        for (level, numbers) in table.mips.iter().enumerate() {
            let side = table.header.grid.side >> level;
            for (place, expected) in numbers.as_chunks::<4>().0.iter().enumerate() {
                let (layer, line, column) = (place / side / side, place / side % side, place % side);
                let [x, y] = layout.corner(level, layer);
                let at = (y + line) * width + x + column;
                assert_eq!(texels[at], expected.map(f32::from));
                assert!(!std::mem::replace(&mut read_texels[at], true), "level {level}, layer {layer}");
            }
        }
        let used = read_texels.iter().filter(|read| **read).count() as f64;
        assert!(used > 0.7 * texels.len() as f64, "{used} of {}", texels.len());
    }

    #[test]
    fn functions_are_those_of_the_texture() {
        let (_, table) = small_table();
        let (texels, size) = read(&write_functions(&table.header).unwrap());
        assert_eq!(texels, function_rows(&table.header));
        assert_eq!(size, [SPECULAR_SAMPLES, texels.len() / SPECULAR_SAMPLES]);
    }
}
