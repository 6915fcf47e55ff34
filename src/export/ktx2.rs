//! Texels of a colour table as a KTX 2.0 container: a 2D array of RGBA16F with all mip levels, without supercompression.
//!
//! Mip level m has the layers of level 2m of the table and then those of level 2m + 1, each of which has layer = piece × texels per place + texel. Columns and rows grow with the x and y of light + viewer, −(u, v), which the container says by the orientation `ru`. The specification is "KTX File Format
//! Specification 2.0", Khronos Group; the data format descriptor is that of "Khronos Data Format Specification 1.3", section 5.

use crate::error::{Error, Result};
use crate::optics::energy::DirectionGrid;
use crate::table::{ColorTable, SPECULAR_SAMPLES, TableHeader};
use half::f16;
use ktx2::Reader;

const IDENTIFIER: [u8; 12] = *b"\xabKTX 20\xbb\r\n\x1a\n";
/// `VK_FORMAT_R16G16B16A16_SFLOAT`.
const FORMAT: u32 = 97;
/// `VK_FORMAT_R32G32B32A32_SFLOAT`.
const FORMAT_OF_FUNCTIONS: u32 = 109;
/// Bytes of the header with the index, and of each entry of the level index.
const HEADER: usize = 80;
const LEVEL_ENTRY: usize = 24;

/// A texture of four floats a texel.
struct KtxTexture<'a> {
    format: u32,
    /// Bytes of a float.
    float: usize,
    /// Columns and rows.
    size: [usize; 2],
    /// Layers of an array; 0 if it is none.
    layers: usize,
    /// Bytes of each level, the finest first.
    levels: Vec<Vec<u8>>,
    /// Directions in which columns and rows grow.
    orientation: &'a str,
}

/// Returns the container of the texels of `table`.
pub fn write(table: &ColorTable) -> Vec<u8> {
    let bytes = |level: &Vec<f16>| level.iter().flat_map(|number| number.to_le_bytes()).collect();
    container(&KtxTexture {
        format: FORMAT,
        float: size_of::<f16>(),
        size: [table.header.grid.side; 2],
        layers: table.header.layers(),
        levels: table.mips.iter().map(bytes).collect(),
        orientation: "ru",
    })
}

/// Returns the container of the [`function_rows`] of the table of `header`.
pub fn write_functions(header: &TableHeader) -> Vec<u8> {
    let texels = function_rows(header);
    container(&KtxTexture {
        format: FORMAT_OF_FUNCTIONS,
        float: size_of::<f32>(),
        size: [SPECULAR_SAMPLES, texels.len() / SPECULAR_SAMPLES],
        layers: 0,
        levels: vec![texels.iter().flatten().flat_map(|number| number.to_le_bytes()).collect()],
        orientation: "rd",
    })
}

/// Returns the functions of |w| and of the angle of the table of `header`, in rows of [`SPECULAR_SAMPLES`] texels: the rows of [`TableHeader::specular_rows`], then the cubics of
/// each piece in a row, X, Y and Z of one coordinate after the other, then the rows of the limit of energy, if there is one.
pub fn function_rows(header: &TableHeader) -> Vec<[f32; 4]> {
    let mut texels = header.specular_rows();
    for piece in 0..header.basis.pieces {
        let end = texels.len() + SPECULAR_SAMPLES;
        texels.extend(header.basis.of_piece(piece).iter().flatten());
        texels.resize(end, [0.0; 4]);
    }
    for row in header.energy.iter().flat_map(|points| points.chunks(DirectionGrid::SIDE)) {
        let end = texels.len() + SPECULAR_SAMPLES;
        texels.extend(row.iter().map(|[excess, passed]| [*excess, *passed, 0.0, 0.0]));
        texels.resize(end, [0.0; 4]);
    }
    texels
}

fn container(texture: &KtxTexture<'_>) -> Vec<u8> {
    let levels = &texture.levels;
    let (descriptor, notes) = (descriptor(texture.float), notes(texture.orientation));
    let descriptor_at = HEADER + LEVEL_ENTRY * levels.len();
    let notes_at = descriptor_at + descriptor.len();
    let begin = (notes_at + notes.len()).next_multiple_of(4 * texture.float);
    let mut file = Vec::with_capacity(begin + levels.iter().map(Vec::len).sum::<usize>());
    file.extend(IDENTIFIER);
    let [width, height] = texture.size;
    // Format, type size, width, height, depth, layers, faces, levels, supercompression.
    let sizes = [texture.float, width, height, 0, texture.layers, 1, levels.len(), 0];
    words(&mut file, &[texture.format]);
    words(&mut file, &sizes.map(|x| x as u32));
    words(&mut file, &[descriptor_at, descriptor.len(), notes_at, notes.len()].map(|x| x as u32));
    // No data of a supercompression.
    file.extend([0; 16]);
    file.extend(level_index(levels, begin));
    file.extend(descriptor);
    file.extend(notes);
    file.resize(begin, 0);
    // The smallest level stands first, so that a stream shows something early.
    file.extend(levels.iter().rev().flatten());
    file
}

/// Returns offset, length and uncompressed length of each level, where the smallest begins at `begin`.
fn level_index(levels: &[Vec<u8>], begin: usize) -> Vec<u8> {
    let mut offset = begin;
    let mut entries: Vec<[usize; 3]> = Vec::new();
    for level in levels.iter().rev() {
        entries.push([offset, level.len(), level.len()]);
        offset += level.len();
    }
    entries.iter().rev().flatten().flat_map(|x| (*x as u64).to_le_bytes()).collect()
}

/// Returns the data format descriptor of four linear floats of `float` bytes.
fn descriptor(float: usize) -> Vec<u8> {
    /// RGBSDA model, unspecified primaries, linear transfer, straight alpha.
    const MODEL: [u8; 4] = [1, 0, 1, 0];
    /// Channel numbers of R, G, B and A.
    const CHANNELS: [u8; 4] = [0, 1, 2, 15];
    /// Signed floats.
    const KIND: u8 = 0xC0;
    const BLOCK: u32 = 24 + 16 * 4;
    let mut bytes = Vec::new();
    words(&mut bytes, &[BLOCK + 4, 0, 2 | BLOCK << 16]);
    bytes.extend(MODEL);
    // A block of one texel, whose bytes are in the first plane.
    bytes.extend([0, 0, 0, 0, 4 * float as u8, 0, 0, 0, 0, 0, 0, 0]);
    let bits = 8 * float as u8;
    for (i, channel) in CHANNELS.into_iter().enumerate() {
        bytes.extend([bits * i as u8, 0, bits - 1, channel | KIND, 0, 0, 0, 0]);
        words(&mut bytes, &[(-1.0f32).to_bits(), 1.0f32.to_bits()]);
    }
    bytes
}

/// Returns the keys and values, in the order of the keys.
fn notes(orientation: &str) -> Vec<u8> {
    let writer = concat!("diffract ", env!("CARGO_PKG_VERSION"));
    let mut bytes = Vec::new();
    for (key, value) in [("KTXorientation", orientation), ("KTXwriter", writer)] {
        words(&mut bytes, &[(key.len() + value.len() + 2) as u32]);
        bytes.extend(key.bytes().chain([0]).chain(value.bytes()).chain([0]));
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}

fn words(bytes: &mut Vec<u8>, values: &[u32]) {
    bytes.extend(values.iter().flat_map(|x| x.to_le_bytes()));
}

/// Reads the mip levels of the table of `header` from the container `bytes`.
///
/// # Errors
/// A container that is damaged, of another format, or not of the size that `header` has.
pub fn read(bytes: &[u8], header: &TableHeader) -> Result<Vec<Vec<f16>>> {
    let refused = |what: String| Error::input(what, "export the material again");
    let reader = Reader::new(bytes).map_err(|e| refused(format!("it is no KTX2 file ({e})")))?;
    let held = reader.header();
    let grid = &header.grid;
    let expected = (FORMAT, grid.side, grid.side, header.layers(), grid.mips(), true);
    let found = (
        held.format.map_or(0, |format| format.value()),
        held.pixel_width as usize,
        held.pixel_height as usize,
        held.layer_count as usize,
        held.level_count as usize,
        held.supercompression_scheme.is_none(),
    );
    if found != expected {
        return Err(refused("it is not the texture that the table describes".to_owned()));
    }
    let half = |two: &[u8; 2]| f16::from_le_bytes(*two);
    Ok(reader.levels().map(|level| level.data.as_chunks().0.iter().map(half).collect()).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::conformance::tests::small_table;

    #[test]
    fn a_reader_of_others_finds_the_texels_where_the_container_says() {
        let (_, table) = small_table();
        let bytes = write(&table);
        let reader = Reader::new(&bytes[..]).unwrap();
        assert_eq!(reader.header().layer_count as usize, table.header.layers());
        assert_eq!(reader.header().type_size, 2);
        let notes: Vec<_> =
            reader.key_value_data().map(|(key, value)| (key.to_owned(), value.to_vec())).collect();
        assert_eq!(notes[0], ("KTXorientation".to_owned(), b"ru\0".to_vec()));
        assert_eq!(read(&bytes, &table.header).unwrap(), table.mips);
    }

    #[test]
    fn functions_are_rows_of_the_specular_order_and_then_of_cubics() {
        let (_, table) = small_table();
        let header = &table.header;
        let bytes = write_functions(header);
        let reader = Reader::new(&bytes[..]).unwrap();
        let rows = header.specular_rows().len() / SPECULAR_SAMPLES;
        let energy = header.energy.as_ref().unwrap();
        let height = rows + header.basis.pieces + DirectionGrid::SIDE;
        assert_eq!(reader.header().pixel_height as usize, height);
        let level = reader.levels().next().unwrap().data;
        let at = |row: usize, column: usize| -> Vec<f32> {
            let from = 16 * (row * SPECULAR_SAMPLES + column);
            level[from..from + 16].as_chunks().0.iter().map(|four| f32::from_le_bytes(*four)).collect()
        };
        assert_eq!(at(3, 7)[..3], header.specular.weights[3][7]);
        let last = header.basis.pieces - 1;
        assert_eq!(at(rows + last, 4), header.basis.of_piece(last)[1][1]);
        assert_eq!(at(height - 1, 5)[..2], energy[DirectionGrid::COUNT - DirectionGrid::SIDE + 5]);
    }

    #[test]
    fn a_damaged_container_or_one_of_another_size_is_refused() {
        let (_, table) = small_table();
        let bytes = write(&table);
        for bad in [&bytes[..40], &bytes[..bytes.len() - 8], &bytes[1..], &[]] {
            assert!(read(bad, &table.header).is_err(), "{} bytes", bad.len());
        }
        let mut other = table.header.clone();
        other.grid.side *= 2;
        assert!(read(&bytes, &other).unwrap_err().to_string().contains("not the texture"));
    }
}
