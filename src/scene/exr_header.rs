//! Header of OpenEXR pictures: the channels, and the primaries of the colours (attribute `chromaticities`; "Technical Introduction to OpenEXR", 2013). The decoder
//! leaves the primaries to its users.

use crate::error::{Error, Result};
use crate::optics::color::{adapted_to_d65, xyz_to_linear_srgb};
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::Chromaticities;
use glam::{DMat3, DVec2, DVec3};

/// Beginning of an OpenEXR picture.
const SIGNATURE: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
/// Primaries and white of Rec. 709, which are those of pictures that name none.
const REC_709: [[f64; 2]; 4] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]];
/// Largest difference of equal chromaticities: half a unit of the fourth place, to which standards give them.
const ROUNDING: f64 = 5e-5;
/// Largest coordinate of a chromaticity; those of real and imaginary primaries in use lie within −1 to 2.
const LARGEST: f64 = 10.0;
/// Smallest determinant of the primaries, twice the area of their triangle; that of Rec. 709 is 0.22.
const SMALLEST_TRIANGLE: f64 = 1e-4;
/// Largest number of channels that an error lists.
const LISTED: usize = 8;

/// Returns the matrix from the colours of the picture `bytes` to linear sRGB; `None` if they are linear sRGB already, as those of other formats.
///
/// # Errors
/// Fails for pictures without channels R, G and B, and for primaries that span no triangle.
pub fn to_linear_srgb(bytes: &[u8]) -> Result<Option<DMat3>> {
    if !bytes.starts_with(&SIGNATURE) {
        return Ok(None);
    }
    // A damaged header is told by the decoder.
    let Ok(meta) = MetaData::read_from_buffered(bytes, false) else { return Ok(None) };
    check_channels(&meta)?;
    let chromaticities =
        meta.headers.iter().find_map(|header| header.shared_attributes.chromaticities.as_ref());
    chromaticities.map_or(Ok(None), matrix)
}

/// Fails if no layer has channels R, G and B, with the names of the channels.
fn check_channels(meta: &MetaData) -> Result<()> {
    let names = meta.headers.iter().map(|header| {
        let channels = &header.channels.list;
        channels.iter().map(|channel| channel.name.to_string()).collect::<Vec<_>>()
    });
    let layers: Vec<Vec<String>> = names.collect();
    let has = |layer: &Vec<String>, name: &str| layer.iter().any(|channel| channel == name);
    if layers.is_empty() || layers.iter().any(|layer| ["R", "G", "B"].iter().all(|name| has(layer, name))) {
        return Ok(());
    }
    let is_luminance_chroma = layers.iter().any(|layer| has(layer, "Y") && has(layer, "RY"));
    let what = if is_luminance_chroma {
        "the EXR holds luminance and chroma (channels Y, RY and BY)".to_owned()
    } else {
        let listed: Vec<&str> = layers.iter().flatten().take(LISTED).map(String::as_str).collect();
        format!("the EXR has no channels R, G and B, but {}", listed.join(", "))
    };
    Err(Error::input(what, "save it again with channels R, G and B"))
}

/// Returns the matrix from colours of these primaries to linear sRGB, white to white; `None` for those of Rec. 709.
///
/// The primaries' XYZ are (x, y, 1 − x − y), each times the factor that makes their sum the white (SMPTE RP 177).
fn matrix(chromaticities: &Chromaticities) -> Result<Option<DMat3>> {
    let Chromaticities { red, green, blue, white } = *chromaticities;
    let points = [red, green, blue, white].map(|Vec2(x, y)| DVec2::new(f64::from(x), f64::from(y)));
    let is_known = |(point, known): (&DVec2, [f64; 2])| (*point - DVec2::from(known)).length() < ROUNDING;
    if points.iter().zip(REC_709).all(is_known) {
        return Ok(None);
    }
    let [red, green, blue, white] = points.map(|point| point.extend(1.0 - point.x - point.y));
    let primaries = DMat3::from_cols(red, green, blue);
    // NaN is not bounded, and would not be a maximum.
    let is_bounded = points.iter().all(|point| point.to_array().iter().all(|x| x.abs() <= LARGEST));
    if !is_bounded || primaries.determinant().abs() < SMALLEST_TRIANGLE || white.y < SMALLEST_TRIANGLE {
        return Err(Error::input(
            "the chromaticities in the header of the EXR span no triangle of colours",
            "save it again as linear sRGB",
        ));
    }
    let white = white / white.y;
    let to_xyz = primaries * DMat3::from_diagonal(primaries.inverse() * white);
    let converted = |colour: DVec3| xyz_to_linear_srgb(adapted_to_d65(to_xyz * colour, white));
    Ok(Some(DMat3::from_cols(converted(DVec3::X), converted(DVec3::Y), converted(DVec3::Z))))
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use exr::prelude::{
        Encoding, Image, ImageAttributes, IntegerBounds, Layer, LayerAttributes, SpecificChannels,
        WritableImage,
    };
    use std::io::Cursor;

    /// Primaries and white of Rec. 2020 (ITU-R BT.2020-2).
    pub const REC_2020: [[f32; 2]; 4] = [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], [0.3127, 0.3290]];
    /// Those of ACES2065-1 (SMPTE ST 2065-1), whose blue and green are no colours.
    const ACES: [[f32; 2]; 4] = [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.0770], [0.32168, 0.33767]];

    fn chromaticities(points: [[f32; 2]; 4]) -> Chromaticities {
        let [red, green, blue, white] = points.map(|[x, y]| Vec2(x, y));
        Chromaticities { red, green, blue, white }
    }

    /// Returns an EXR of 8 × 4 pixels of this `colour`, of these primaries.
    pub fn picture(colour: [f32; 3], primaries: Option<[[f32; 2]; 4]>) -> Vec<u8> {
        let channels = SpecificChannels::rgb(move |_: Vec2<usize>| (colour[0], colour[1], colour[2]));
        let attributes = LayerAttributes::named("");
        let layer = Layer::new(Vec2(8, 4), attributes, Encoding::UNCOMPRESSED, channels);
        let mut image = Image::from_layer(layer);
        image.attributes = ImageAttributes {
            chromaticities: primaries.map(chromaticities),
            ..ImageAttributes::new(IntegerBounds::from_dimensions((8, 4)))
        };
        let mut bytes = Cursor::new(Vec::new());
        image.write().to_buffered(&mut bytes).unwrap();
        bytes.into_inner()
    }

    fn matrix_of(primaries: [[f32; 2]; 4]) -> Result<Option<DMat3>> {
        to_linear_srgb(&picture([1.0; 3], Some(primaries)))
    }

    #[test]
    fn pictures_without_primaries_and_those_of_rec_709_stay_as_they_are() {
        assert_eq!(to_linear_srgb(&picture([1.0; 3], None)).unwrap(), None);
        assert_eq!(matrix_of(REC_709.map(|point| point.map(|x| x as f32))).unwrap(), None);
        assert_eq!(to_linear_srgb(b"#?RADIANCE\n").unwrap(), None);
    }

    #[test]
    fn the_matrix_from_rec_2020_is_the_published_one() {
        // ITU-R BT.2087-0 gives the inverse to four places: linear Rec. 709 to Rec. 2020.
        let published = DMat3::from_cols(
            DVec3::new(0.6274, 0.0691, 0.0164),
            DVec3::new(0.3293, 0.9195, 0.0880),
            DVec3::new(0.0433, 0.0114, 0.8956),
        );
        let found = matrix_of(REC_2020).unwrap().unwrap().inverse();
        assert!(found.abs_diff_eq(published, 1e-4), "{found}");
    }

    #[test]
    fn white_stays_white_whatever_it_is() {
        let to_srgb = matrix_of(ACES).unwrap().unwrap();
        assert!((to_srgb * DVec3::ONE - DVec3::ONE).length() < 1e-4, "{}", to_srgb * DVec3::ONE);
        // Its red is far outside sRGB.
        assert!((to_srgb * DVec3::X).x > 2.0 && (to_srgb * DVec3::X).y < -0.2, "{to_srgb}");
    }

    #[test]
    fn primaries_on_a_line_and_numbers_that_are_none_are_refused() {
        let line = [[0.1, 0.1], [0.2, 0.2], [0.3, 0.3], [0.3127, 0.3290]];
        let mut none = REC_2020;
        none[1][0] = f32::NAN;
        let mut black = REC_2020;
        black[3] = [0.3, 0.0];
        for wrong in [line, none, black, [[0.0; 2]; 4]] {
            let e = matrix_of(wrong).unwrap_err().to_string();
            assert!(e.contains("chromaticities") && e.contains("; "), "{e}");
        }
    }

    #[test]
    fn channels_of_other_kinds_are_named() {
        let sound = picture([1.0; 3], None);
        let renamed = |names: [&[u8; 1]; 3]| {
            let mut bytes = sound.clone();
            // Channels stand as name, 0, type 2 (32-bit float), sorted by name.
            for (old, new) in [b"B", b"G", b"R"].into_iter().zip(names) {
                let entry = [old[0], 0, 2, 0, 0, 0];
                let place = bytes.windows(6).position(|window| window == entry).unwrap();
                bytes[place] = new[0];
            }
            bytes
        };
        let e = to_linear_srgb(&renamed([b"X", b"Y", b"Z"])).unwrap_err().to_string();
        assert!(e.contains("X, Y, Z"), "{e}");
        let names = ["BY", "RY", "Y"].iter().map(|name| [name.as_bytes(), b"\0"].concat());
        let entry = |name: Vec<u8>| {
            let sampling: u8 = if name.len() == 3 { 2 } else { 1 };
            [&name[..], &[1, 0, 0, 0, 0, 0, 0, 0], &[sampling, 0, 0, 0, sampling, 0, 0, 0]].concat()
        };
        let list: Vec<u8> = names.flat_map(entry).chain([0]).collect();
        let length = u32::try_from(list.len()).unwrap().to_le_bytes();
        let start = sound.windows(7).position(|window| window == b"chlist\0").unwrap() + 7;
        let old = u32::from_le_bytes(sound[start..start + 4].try_into().unwrap()) as usize;
        let bytes = [&sound[..start], &length, &list, &sound[start + 4 + old..]].concat();
        let e = to_linear_srgb(&bytes).unwrap_err().to_string();
        assert!(e.contains("luminance and chroma") && e.contains("R, G and B"), "{e}");
    }
}
