//! Texels of a colour table as an OpenEXR file of many parts, for programs that read no KTX2.
//!
//! Part `levelL.layerNN` has the channels R, G, B and A of layer NN of mip level L as 16-bit floats. Its first row is that of the smallest y of light + viewer, as in the KTX2
//! file, although pictures in OpenEXR usually begin at the top.

use crate::error::{Error, Result};
use crate::table::ColorTable;
use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer,
    LayerAttributes, WritableImage,
};
use half::f16;
use std::io::Cursor;

/// Returns the file of the texels of `table`.
///
/// # Errors
/// Numbers that the format cannot hold.
pub fn write(table: &ColorTable) -> Result<Vec<u8>> {
    let mut parts = Vec::new();
    for (level, numbers) in table.mips.iter().enumerate() {
        let side = table.header.grid.side >> level;
        for (layer, texels) in numbers.chunks_exact(side * side * 4).enumerate() {
            let attributes = LayerAttributes::named(format!("level{level}.layer{layer:02}").as_str());
            parts.push(Layer::new((side, side), attributes, Encoding::SMALL_LOSSLESS, channels(texels)));
        }
    }
    let side = table.header.grid.side;
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((side, side)));
    let image = Image::from_layers(attributes, parts);
    let mut file = Cursor::new(Vec::new());
    image
        .write()
        .to_buffered(&mut file)
        .map_err(|e| Error::bug(format!("the texels cannot be written as OpenEXR ({e})")).caused_by(e))?;
    Ok(file.into_inner())
}

/// Returns the channels of `texels`, four numbers each.
fn channels(texels: &[f16]) -> AnyChannels<FlatSamples> {
    let channel = |(i, name): (usize, &str)| {
        let samples = texels.iter().skip(i).step_by(4).copied().collect();
        AnyChannel::new(name, FlatSamples::F16(samples))
    };
    AnyChannels::sort(["R", "G", "B", "A"].into_iter().enumerate().map(channel).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::conformance::tests::small_table;
    use exr::prelude::read_all_flat_layers_from_file;

    #[test]
    fn every_layer_of_every_level_is_a_part_with_the_same_numbers() {
        let (_, table) = small_table();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.exr");
        std::fs::write(&path, write(&table).unwrap()).unwrap();
        let image = read_all_flat_layers_from_file(&path).unwrap();
        let layers = table.header.layers();
        assert_eq!(image.layer_data.len(), layers * table.header.grid.mips());
        for (i, part) in image.layer_data.iter().enumerate() {
            let (level, layer) = (i / layers, i % layers);
            assert_eq!(
                part.attributes.layer_name.as_ref().unwrap().to_string(),
                format!("level{level}.layer{layer:02}")
            );
            let side = table.header.grid.side >> level;
            let texels = &table.mips[level][layer * side * side * 4..][..side * side * 4];
            for channel in &part.channel_data.list {
                let place = ["R", "G", "B", "A"].iter().position(|name| channel.name.eq(name)).unwrap();
                let FlatSamples::F16(held) = &channel.sample_data else { panic!("no 16-bit floats") };
                assert!(held.iter().eq(texels.iter().skip(place).step_by(4)));
            }
        }
    }
}
