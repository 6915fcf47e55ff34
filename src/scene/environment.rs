//! Environment maps, which light a scene from everywhere: equirectangular pictures of radiance.
//!
//! The picture's middle column stands at azimuth 0, the world's +x; azimuth grows to the left, as seen from inside. Its top row is up, +z.
//! A radiance of 1 is that of a white diffuse surface that faces a light of intensity 1.

use super::environment_cells::{Cell, LightSums};
use super::incident::{Incident, WIDER};
use super::{exr_header, radiance_header};
use crate::error::{Error, Result};
use crate::input::PictureFile;
use crate::memory;
use crate::optics::color::LUMINANCE;
use glam::{DMat3, DQuat, DVec2, DVec3, Vec3};
use image::ImageFormat;
use std::f64::consts::{PI, TAU};
use std::ffi::OsStr;
use std::fmt;
use std::path::Path;
use std::sync::Arc;

/// Names of the built-in environment maps.
pub const BUILT_IN: [&str; 2] = ["sky", "studio"];

/// Returns true if `name` is that of a built-in environment map.
pub fn is_built_in(name: impl AsRef<OsStr>) -> bool {
    BUILT_IN.iter().any(|known| name.as_ref() == *known)
}

/// Width of built-in environment maps, and the largest width from which light is sampled \[pixels\]. Larger maps are averaged.
const WIDTH: usize = 512;
const LARGEST_WIDTH: usize = 2048;
/// Largest side of a picture that is read \[pixels\].
const LARGEST_SIDE: u32 = 1 << 14;
/// Variance of the directions of a hemisphere, along each axis across its middle: the largest variance of a sample.
const LARGEST_VARIANCE: f64 = 1.0 / 3.0;
/// Largest radiance: the largest 16-bit float, at which cameras and other programs clip theirs. A pixel beyond, infinite or a fault, would light the scene alone.
const LARGEST_RADIANCE: f32 = 65504.0;

/// Rotation and exposure of an environment map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Placement {
    /// Rotation about the world's up, from +x toward +y \[degrees\].
    pub rotation: f64,
    /// Exposure: the radiance is multiplied by two to the power of this number \[stops\].
    pub exposure: f64,
}

impl Placement {
    /// Returns the placement with this rotation \[degrees\] and exposure \[stops\].
    ///
    /// # Errors
    /// An exposure beyond −40 to 40 stops.
    pub fn new(rotation: f64, exposure: f64) -> Result<Self> {
        if (-40.0..=40.0).contains(&exposure) {
            return Ok(Self { rotation, exposure });
        }
        Err(Error::input(
            "the exposure of the surroundings is not within -40 to 40 stops",
            "0 is a good start",
        ))
    }
}

/// Environment map of a scene.
#[derive(Clone)]
pub struct Environment {
    /// Name or file.
    pub name: String,
    /// Rotation and exposure.
    pub placement: Placement,
    picture: Arc<EnvironmentMap>,
}

/// Compares the pictures number by number only if they are not shared.
impl PartialEq for Environment {
    fn eq(&self, other: &Self) -> bool {
        let is_same = self.shares_picture_with(other) || self.picture == other.picture;
        is_same && self.name == other.name && self.placement == other.placement
    }
}

/// Shows a hash instead of the millions of numbers of the picture.
impl fmt::Debug for Environment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let EnvironmentMap { width, radiance, .. } = &*self.picture;
        let numbers: Vec<[f32; 3]> = radiance.iter().map(Vec3::to_array).collect();
        let hash = blake3::hash(bytemuck::cast_slice(&numbers)).to_hex();
        let Self { placement, .. } = self;
        f.debug_struct("Environment")
            .field("placement", placement)
            .field("width", width)
            .field("radiance", &hash)
            .finish_non_exhaustive()
    }
}

/// Mip level of an environment map.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentLevel {
    /// Width and height \[pixels\].
    pub size: [usize; 2],
    /// Linear sRGB, row by row from the top.
    pub radiance: Vec<Vec3>,
}

impl EnvironmentLevel {
    /// Returns means over 2 × 2 pixels; over 3 along a side with an odd number of pixels, so that none is left out.
    fn halved(&self) -> Self {
        let [width, height] = self.size;
        let size = self.size.map(|n| (n / 2).max(1));
        let covered = |i: usize, of: usize, from: usize| i * from / of..((i + 1) * from).div_ceil(of);
        let mean = |i: usize| {
            let columns = covered(i % size[0], size[0], width);
            let rows = covered(i / size[0], size[1], height);
            let count = (columns.len() * rows.len()) as f32;
            rows.flat_map(|r| &self.radiance[r * width..][columns.clone()]).sum::<Vec3>() / count
        };
        Self { size, radiance: (0..size[0] * size[1]).map(mean).collect() }
    }
}

/// Radiance over directions.
#[derive(Debug, PartialEq)]
struct EnvironmentMap {
    width: usize,
    height: usize,
    /// Linear sRGB, row by row from the top.
    radiance: Vec<Vec3>,
    /// Sums of the brightness of the pixels.
    light: LightSums,
    /// Value of [`Environment::extent`].
    extent: f64,
    /// Cosine and sine of the azimuth of each column.
    azimuths: Vec<DVec2>,
    /// Pixels of the file that were changed.
    changed: ChangedPixels,
}

impl Environment {
    /// Opens an environment map by name, `sky` or `studio`, or an equirectangular picture, .exr or .hdr.
    ///
    /// # Errors
    /// A name that is neither, a file that cannot be read, or a file that holds no light.
    pub fn open(name: impl AsRef<OsStr>) -> Result<Self> {
        let name = name.as_ref();
        let picture = match name.to_str() {
            Some("sky") => EnvironmentMap::of(WIDTH, &sky),
            Some("studio") => EnvironmentMap::of(WIDTH, &studio),
            _ => EnvironmentMap::read(Path::new(name))?,
        };
        Ok(Self::showing(&name.to_string_lossy(), picture))
    }

    /// Reads the environment map called `name` from the bytes of an .exr or .hdr file.
    ///
    /// # Errors
    /// Bytes that are no such picture, a picture that is not twice as wide as high, or one that holds no light.
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self> {
        EnvironmentMap::from_bytes(bytes).map(|picture| Self::showing(name, picture))
    }

    /// Returns a note about pixels of the file whose radiance was changed; `None` if there are none.
    pub fn note(&self) -> Option<String> {
        let ChangedPixels { unsound, outside } = self.picture.changed;
        let pixels = |count: usize, one: &str, several: &str| match count {
            1 => format!("1 pixel {one}"),
            _ => format!("{count} pixels {several}"),
        };
        let unsound = (unsound > 0).then(|| {
            let pixels = pixels(unsound, "is", "are");
            format!(
                "{pixels} negative, not a number, infinite or beyond {LARGEST_RADIANCE}: negative radiance and what is not a number count as black, the rest as {LARGEST_RADIANCE}"
            )
        });
        let outside = (outside > 0).then(|| {
            let pixels = pixels(outside, "has a colour", "have colours");
            format!("{pixels} outside sRGB, whose negative parts count as 0")
        });
        let notes: Vec<String> = unsound.into_iter().chain(outside).collect();
        (!notes.is_empty()).then(|| format!("{}: {}", self.name, notes.join("; ")))
    }

    fn showing(name: &str, picture: EnvironmentMap) -> Self {
        Self { name: name.to_owned(), placement: Placement::default(), picture: Arc::new(picture) }
    }

    /// Returns the environment map of this radiance, linear sRGB, over directions.
    pub fn of(radiance: &dyn Fn(DVec3) -> Vec3) -> Self {
        Self::showing("", EnvironmentMap::of(WIDTH, radiance))
    }

    /// Returns the effective solid angle of the light \[sr\], (∫ L dω)² / ∫ L² dω: that of a uniform light with the same total and the same
    /// mean of L, weighted by L.
    pub fn extent(&self) -> f64 {
        self.picture.extent
    }

    /// Returns sample number `index` of `count`: the light of one cell, from its mean direction. There are as many cells as samples. Cells
    /// have about the same light, so that bright parts of the map get more samples.
    pub fn incident(&self, index: u32, count: u32) -> Incident {
        let count = count.max(1);
        let cell = self.picture.light.cell(index, count);
        let samples = f64::from(cell.samples);
        let CellLight { irradiance, middle } = self.picture.light_of(&cell);
        let centre = [&cell.rows, &cell.columns].map(|range| usize::midpoint(range.start, range.end - 1));
        // The length of the mean of unit vectors falls with their spread: 1 − |m|² is the sum of the variances.
        let spread = 0.5 * (1.0 - middle.length_squared());
        let of_pixel = (PI / self.picture.height as f64).powi(2) / 12.0;
        // A single sample has no neighbours to overlap with.
        let wider = WIDER.min(f64::from(count));
        let direction =
            middle.try_normalize().unwrap_or_else(|| self.picture.direction(centre[0], centre[1]));
        Incident {
            direction: self.turned(direction),
            place: None,
            irradiance: (irradiance * (self.placement.exposure.exp2() * f64::from(count) / (PI * samples)))
                .as_vec3(),
            variance: (wider * (spread + of_pixel) / samples).min(LARGEST_VARIANCE),
            mean: middle.length(),
        }
    }

    /// Returns the mip levels of the picture, the finest first, without rotation and exposure.
    pub fn levels(&self) -> Vec<EnvironmentLevel> {
        let EnvironmentMap { width, height, radiance, .. } = &*self.picture;
        let finest = EnvironmentLevel { size: [*width, *height], radiance: radiance.clone() };
        let halved = |level: &EnvironmentLevel| (level.size != [1, 1]).then(|| level.halved());
        std::iter::successors(Some(finest), halved).collect()
    }

    /// Returns the same environment map with another rotation and exposure.
    #[must_use]
    pub fn placed(&self, placement: Placement) -> Self {
        Self { placement, ..self.clone() }
    }

    /// Returns true if both share the very same picture.
    pub fn shares_picture_with(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.picture, &other.picture)
    }

    /// Returns the radiance from the unit vector `toward`, linear sRGB, interpolated linearly between the pixels' centres.
    pub fn radiance(&self, toward: DVec3) -> DVec3 {
        let picture = &*self.picture;
        let azimuth = toward.y.atan2(toward.x) - self.placement.rotation.to_radians();
        let across = ((PI - azimuth) / TAU).rem_euclid(1.0) * picture.width as f64 - 0.5;
        let down = toward.z.clamp(-1.0, 1.0).acos() / PI * picture.height as f64 - 0.5;
        let [left, top] = [across.floor(), down.floor()];
        // A row continues at its other end; the first and the last row end at the poles.
        let column = |i: f64| i.rem_euclid(picture.width as f64) as usize;
        let row = |i: f64| i.clamp(0.0, picture.height as f64 - 1.0) as usize;
        let along = |i: f64| {
            let pixels = &picture.radiance[row(i) * picture.width..];
            pixels[column(left)].as_dvec3().lerp(pixels[column(left + 1.0)].as_dvec3(), across - left)
        };
        along(top).lerp(along(top + 1.0), down - top) * self.placement.exposure.exp2()
    }

    /// Returns the irradiance over π of a surface that faces `normal`, linear sRGB.
    pub fn irradiance(&self, normal: DVec3) -> DVec3 {
        let picture = &*self.picture;
        let mut sum = DVec3::ZERO;
        for (i, radiance) in picture.radiance.iter().enumerate() {
            let (row, column) = (i / picture.width, i % picture.width);
            let cosine = self.turned(picture.direction(row, column)).dot(normal).max(0.0);
            sum += radiance.as_dvec3() * (cosine * solid_angle(row, [picture.width, picture.height]));
        }
        sum * self.placement.exposure.exp2() / PI
    }

    /// Rotates a direction of the picture into the world.
    fn turned(&self, direction: DVec3) -> DVec3 {
        DQuat::from_rotation_z(self.placement.rotation.to_radians()) * direction
    }
}

/// Returns the angle from up, at row 0 of `height`, to `row` \[rad\].
fn polar_angle(row: f64, height: usize) -> f64 {
    PI * row / height as f64
}

/// Returns the cosine and sine of the azimuth of the middle of each column.
fn azimuths(width: usize) -> Vec<DVec2> {
    (0..width).map(|column| DVec2::from_angle(PI - TAU * (column as f64 + 0.5) / width as f64)).collect()
}

/// Returns the direction of the middle of a pixel of `row`, at the azimuth of this cosine and sine.
fn direction(row: usize, height: usize, azimuth: DVec2) -> DVec3 {
    let (sin, cos) = polar_angle(row as f64 + 0.5, height).sin_cos();
    (azimuth * sin).extend(cos)
}

/// Returns the solid angle of a pixel of `row` in a picture of this size \[sr\].
fn solid_angle(row: usize, [width, height]: [usize; 2]) -> f64 {
    let [top, bottom] = [row, row + 1].map(|row| polar_angle(row as f64, height).cos());
    TAU / width as f64 * (top - bottom)
}

/// Light of a cell.
struct CellLight {
    /// Irradiance of a surface that faces the cell, linear sRGB.
    irradiance: DVec3,
    /// Mean direction, weighted by brightness; not a unit vector.
    middle: DVec3,
}

/// Returns the luminance of a radiance.
fn brightness(radiance: DVec3) -> f64 {
    LUMINANCE.dot(radiance).max(0.0)
}

impl EnvironmentMap {
    /// Returns a picture `width` pixels wide of this radiance over directions.
    fn of(width: usize, radiance: &dyn Fn(DVec3) -> Vec3) -> Self {
        let height = width / 2;
        let azimuths = azimuths(width);
        let at = |i: usize| radiance(direction(i / width, height, azimuths[i % width]));
        Self::new(width, height, (0..width * height).map(at).collect())
    }

    fn new(width: usize, height: usize, radiance: Vec<Vec3>) -> Self {
        let light = |(i, radiance): (usize, &Vec3)| {
            brightness(radiance.as_dvec3()) * solid_angle(i / width, [width, height])
        };
        let light: Vec<f64> = radiance.iter().enumerate().map(light).collect();
        let all: f64 = light.iter().sum();
        let weighed: f64 =
            radiance.iter().zip(&light).map(|(c, light)| brightness(c.as_dvec3()) * light).sum();
        let extent = if weighed > 0.0 { all.powi(2) / weighed } else { 0.0 };
        let (light, azimuths) = (LightSums::new(width, &light), azimuths(width));
        Self { width, height, radiance, light, extent, azimuths, changed: ChangedPixels::default() }
    }

    /// Returns the direction of the middle of a pixel, without rotation.
    fn direction(&self, row: usize, column: usize) -> DVec3 {
        direction(row, self.height, self.azimuths[column])
    }

    /// Returns the light of `cell` before rotation. A window with a moving map asks for the whole picture in every frame.
    fn light_of(&self, cell: &Cell) -> CellLight {
        let (mut irradiance, mut light, mut middle) = (DVec3::ZERO, 0.0, DVec3::ZERO);
        for row in cell.rows.clone() {
            let radiance = &self.radiance[row * self.width..][cell.columns.clone()];
            let (mut sum, mut across) = (DVec3::ZERO, DVec3::ZERO);
            for (radiance, azimuth) in radiance.iter().zip(&self.azimuths[cell.columns.clone()]) {
                let radiance = radiance.as_dvec3();
                sum += radiance;
                across += azimuth.extend(1.0) * brightness(radiance);
            }
            let solid_angle = solid_angle(row, [self.width, self.height]);
            let (sin, cos) = polar_angle(row as f64 + 0.5, self.height).sin_cos();
            irradiance += sum * solid_angle;
            light += across.z * solid_angle;
            middle += across * DVec3::new(sin, sin, cos) * solid_angle;
        }
        CellLight { irradiance, middle: if light > 0.0 { middle / light } else { DVec3::ZERO } }
    }

    fn read(path: &Path) -> Result<Self> {
        Self::from_bytes(&PICTURE.read(path)?).map_err(|e| e.at(path.display()))
    }

    /// Decodes the picture in the bytes of an .exr or .hdr file.
    fn from_bytes(bytes: &[u8]) -> Result<Self> {
        let to_srgb = exr_header::to_linear_srgb(bytes)?;
        let [width, height] = PICTURE.size(bytes)?;
        if height == 0 || u64::from(width) != 2 * u64::from(height) {
            return Err(Error::input(
                format!("the surroundings have {width} x {height} pixels"),
                "give an equirectangular picture, twice as wide as high",
            ));
        }
        /// Memory of a pixel: as read, as three floats, and averaged with its distribution \[bytes\].
        const BYTES: u64 = 64;
        let pixels = u64::from(width).saturating_mul(u64::from(height));
        memory::ensure_room(pixels.saturating_mul(BYTES), "the surroundings")?;
        let exposure = radiance_header::exposure(bytes)?.as_vec3();
        let texels = PICTURE.decode(bytes)?.into_rgb32f().into_raw();
        let mut changed = ChangedPixels::default();
        let texels = texels.chunks_exact(3).map(|texel| Vec3::from_slice(texel) / exposure);
        let colors = texels.map(|texel| changed.bounded(texel, to_srgb)).collect();
        let map = averaged(width as usize, height as usize, colors);
        let map = Self { changed, ..map };
        if map.radiance.iter().all(|c| *c == Vec3::ZERO) {
            return Err(Error::input("the surroundings are black", "give a picture that holds light"));
        }
        Ok(map)
    }
}

/// Numbers of pixels whose radiance in the file differs from that of the map.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct ChangedPixels {
    /// Pixels that were NaN, negative, infinite or beyond [`LARGEST_RADIANCE`].
    unsound: usize,
    /// Other pixels whose colours are outside sRGB.
    outside: usize,
}

impl ChangedPixels {
    /// Returns the radiance of a `pixel` in linear sRGB, within 0 to [`LARGEST_RADIANCE`], and counts the pixel if that changes it.
    fn bounded(&mut self, pixel: Vec3, to_srgb: Option<DMat3>) -> Vec3 {
        /// Rounding of a colour at the edge of sRGB, relative to the largest channel.
        const ROUNDING: f32 = 1e-5;
        let finite = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(-LARGEST_RADIANCE, LARGEST_RADIANCE) };
        let sound = pixel.map(finite);
        let converted = to_srgb.map_or(sound, |matrix| (matrix * sound.as_dvec3()).as_vec3());
        let is_negative = converted.min_element() < -ROUNDING * converted.max_element().max(0.0);
        if sound != pixel || (to_srgb.is_none() && is_negative) || converted.max_element() > LARGEST_RADIANCE
        {
            self.unsound += 1;
        } else if is_negative {
            self.outside += 1;
        }
        converted.clamp(Vec3::ZERO, Vec3::splat(LARGEST_RADIANCE))
    }
}

/// File formats and limits of environment maps.
const PICTURE: PictureFile = PictureFile {
    formats: &[ImageFormat::Hdr, ImageFormat::OpenExr],
    names: "neither EXR nor Radiance HDR",
    expected: "sky, studio or an equirectangular .exr or .hdr picture",
    role: "surroundings",
    side: LARGEST_SIDE,
};

/// Returns the picture with at most [`LARGEST_WIDTH`] columns: means over whole squares of pixels. An incomplete square at the edge is left
/// out.
fn averaged(width: usize, height: usize, colors: Vec<Vec3>) -> EnvironmentMap {
    let by = width.div_ceil(LARGEST_WIDTH);
    if by == 1 {
        return EnvironmentMap::new(width, height, colors);
    }
    let (columns, rows) = (width / by, height / by);
    let mean = |i: usize| {
        let (row, column) = (i / columns * by, i % columns * by);
        let sum: Vec3 = (row..row + by).flat_map(|r| &colors[r * width + column..][..by]).sum();
        sum / (by * by) as f32
    };
    EnvironmentMap::new(columns, rows, (0..columns * rows).map(mean).collect())
}

/// Returns the radiance of an overcast sky by the CIE's formula, L = L_z (1 + 2 sin γ)/3 (Moon and Spencer 1942), bluish, over a dark
/// ground. The sun is not part of it; add it as a light.
fn sky(direction: DVec3) -> Vec3 {
    const ZENITH: Vec3 = Vec3::new(0.26, 0.31, 0.38);
    const GROUND: Vec3 = Vec3::new(0.030, 0.026, 0.022);
    if direction.z > 0.0 { ZENITH * ((1.0 + 2.0 * direction.z as f32) / 3.0) } else { GROUND }
}

/// Returns the radiance of a dim room with a window of four panes and two softboxes.
fn studio(direction: DVec3) -> Vec3 {
    const ROOM: Vec3 = Vec3::new(0.035, 0.034, 0.033);
    const WINDOW: Vec3 = Vec3::new(4.6, 5.0, 5.6);
    const SOFTBOX: Vec3 = Vec3::new(3.2, 3.1, 3.0);
    let azimuth = direction.y.atan2(direction.x).to_degrees();
    let height = direction.z.asin().to_degrees();
    // Halves of the openings' sides, about their centres [degrees].
    let within = |centre: [f64; 2], half: [f64; 2]| {
        let around = (azimuth - centre[0] + 540.0).rem_euclid(360.0) - 180.0;
        [around, height - centre[1]].iter().zip(half).all(|(x, half)| x.abs() <= half)
    };
    let panes = [[-9.0, 9.0], [9.0, 9.0], [-9.0, -9.0], [9.0, -9.0]];
    if panes.iter().any(|[x, y]| within([-60.0 + x, 38.0 + y], [8.0, 8.0])) {
        return WINDOW;
    }
    if within([120.0, 45.0], [22.0, 12.0]) || within([30.0, 70.0], [30.0, 8.0]) {
        return SOFTBOX;
    }
    ROOM
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns points of a regular lattice.
    fn points(side: u32) -> impl Iterator<Item = [f64; 2]> {
        let place = move |i: u32| (f64::from(i) + 0.5) / f64::from(side);
        (0..side * side).map(move |i| [place(i % side), place(i / side)])
    }

    fn mean(environment: &Environment, normal: DVec3) -> DVec3 {
        let count = 1 << 14;
        let sum: DVec3 = (0..count)
            .map(|index| environment.incident(index, count))
            .map(|i| i.irradiance.as_dvec3() * i.direction.dot(normal).max(0.0))
            .sum();
        sum / f64::from(count)
    }

    #[test]
    fn a_white_sphere_of_surroundings_lights_every_surface_by_its_radiance() {
        let white = Environment::of(&|_| Vec3::ONE);
        for normal in [DVec3::Z, DVec3::X, DVec3::new(-0.3, 0.4, -0.866).normalize()] {
            assert!((mean(&white, normal) - DVec3::ONE).length() < 1e-3, "{}", mean(&white, normal));
            assert!((white.irradiance(normal) - DVec3::ONE).length() < 1e-3);
        }
    }

    #[test]
    fn pixels_of_a_radiance_picture_are_divided_by_its_exposures() {
        let read = |header: &str| {
            let mut bytes = format!("#?RADIANCE\n{header}FORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n").into_bytes();
            // Eight grey pixels of radiance 1: a mantissa of 128/256 times 2^(129 − 128).
            bytes.extend([128, 128, 128, 129].repeat(8));
            Environment::from_bytes("test", &bytes).unwrap().radiance(DVec3::X)
        };
        assert!((read("") - DVec3::ONE).length() < 0.01, "{}", read(""));
        let exposed = read("EXPOSURE=4\nCOLORCORR=1 2 0.5\n");
        let ratio = exposed / read("");
        assert!((ratio - DVec3::new(0.25, 0.125, 0.5)).length() < 1e-6, "{ratio}");
    }

    #[test]
    fn colours_of_an_exr_are_converted_from_its_primaries() {
        use super::exr_header::tests::{REC_2020, picture};
        let read = |colour: [f32; 3], primaries| {
            let environment = Environment::from_bytes("test.exr", &picture(colour, primaries)).unwrap();
            (environment.radiance(DVec3::X), environment.note())
        };
        // ITU-R BT.2087-0: linear Rec. 709 (0, 1, 0) is (0.3293, 0.9195, 0.0880) in Rec. 2020.
        let (green, _) = read([0.3293, 0.9195, 0.0880], Some(REC_2020));
        assert!((green - DVec3::Y).length() < 5e-4, "{green}");
        assert_eq!(read([1.0, 2.0, 3.0], None), (DVec3::new(1.0, 2.0, 3.0), None));
        let (outside, note) = read([0.0, 1.0, 0.0], Some(REC_2020));
        assert!(outside.x == 0.0 && outside.y > 1.1, "{outside}");
        assert!(note.unwrap().contains("32 pixels have colours outside sRGB"));
    }

    #[test]
    fn radiance_over_the_directions_is_the_irradiance_however_it_is_turned() {
        for name in BUILT_IN {
            let mut environment = Environment::open(name).unwrap();
            for rotation in [0.0, 77.0] {
                environment.placement = Placement { rotation, exposure: 1.0 };
                for normal in [DVec3::X, DVec3::new(0.6, -0.5, 0.62).normalize()] {
                    let side = 512;
                    // Points that are even over the sphere.
                    let sum: DVec3 = points(side)
                        .map(|[x, y]| {
                            let (z, azimuth) = (1.0 - 2.0 * y, TAU * x);
                            let flat = (1.0 - z * z).sqrt();
                            let toward = DVec3::new(flat * azimuth.cos(), flat * azimuth.sin(), z);
                            environment.radiance(toward) * toward.dot(normal).max(0.0)
                        })
                        .sum();
                    let found = sum * (4.0 / f64::from(side * side));
                    let exact = environment.irradiance(normal);
                    assert!((found - exact).length() < 0.01 * exact.length(), "{name}: {found} {exact}");
                }
            }
        }
    }

    #[test]
    fn radiance_is_continuous_between_pixels_across_the_seam_and_at_the_poles() {
        const WAVES: f64 = 30.0;
        let waves = |d: DVec3| (WAVES * d).map(f64::sin);
        let mut environment = Environment::of(&|d| waves(d).as_vec3());
        environment.placement.rotation = 70.0;
        // Interpolation between pixels that are an angle t apart leaves an error of (k t)²/8, along a row and across rows.
        let limit = 2.0 * (WAVES * TAU / WIDTH as f64).powi(2) / 8.0;
        for [x, y] in points(64) {
            for azimuth in [360.0 * x, 179.0 + 2.0 * x] {
                let toward = |turn: f64| crate::optics::geometry::direction(180.0 * y, azimuth + turn);
                let error = environment.radiance(toward(70.0)) - waves(toward(0.0));
                assert!(error.abs().max_element() < limit, "{}: {error}", toward(0.0));
            }
        }
    }

    #[test]
    fn drawn_light_adds_up_to_the_light_of_all_pixels_however_it_is_turned() {
        for name in BUILT_IN {
            let mut environment = Environment::open(name).unwrap();
            environment.placement = Placement { rotation: 77.0, exposure: 1.0 };
            for normal in [DVec3::Z, DVec3::new(0.6, -0.5, 0.62).normalize()] {
                let (found, exact) = (mean(&environment, normal), environment.irradiance(normal));
                assert!((found - exact).length() < 0.01 * exact.length(), "{name}: {found} {exact}");
            }
        }
    }

    #[test]
    fn what_is_drawn_stands_where_the_light_is_and_turns_with_it() {
        // A spot at azimuth 40 degrees, height 30.
        let centre = crate::optics::geometry::direction(60.0, 40.0);
        let spot = |d: DVec3| if d.dot(centre) > 0.99 { Vec3::ONE } else { Vec3::ZERO };
        let mut environment = Environment::of(&spot);
        for turn in [0.0, 120.0] {
            environment.placement.rotation = turn;
            let expected = crate::optics::geometry::direction(60.0, 40.0 + turn);
            for index in 0..64 {
                assert!(environment.incident(index, 64).direction.dot(expected) > 0.985);
            }
        }
        // Along each axis a spot of solid angle Ω has the variance Ω/4π, and a square Ω/12; cells that are not square have more.
        let share = (0..64).map(|index| environment.incident(index, 64).variance).sum::<f64>() / 64.0;
        let square = WIDER * TAU * 0.01 / 64.0 / 12.0;
        assert!((1.0..2.0).contains(&(share / square)), "{share}, {square}");
    }

    fn picture_of_ones() -> image::Rgb32FImage {
        image::Rgb32FImage::from_pixel(8, 4, image::Rgb([1.0; 3]))
    }

    #[test]
    fn pictures_are_read_with_their_orientation_and_others_are_refused() {
        // One bright pixel in the middle of the right half, above the horizon: azimuth −90 degrees.
        let (width, height) = (64u32, 32u32);
        let mut picture = image::Rgb32FImage::new(width, height);
        picture.put_pixel(48, 8, image::Rgb([8.0, 4.0, 2.0]));
        for format in [ImageFormat::Hdr, ImageFormat::OpenExr] {
            let mut bytes = std::io::Cursor::new(Vec::new());
            image::DynamicImage::from(picture.clone()).write_to(&mut bytes, format).unwrap();
            let picture = Arc::new(EnvironmentMap::from_bytes(bytes.get_ref()).unwrap());
            let environment = Environment { name: String::new(), placement: Placement::default(), picture };
            let incident = environment.incident(0, 1);
            assert!(incident.direction.y < -0.7 && incident.direction.z > 0.6, "{incident:?}");
            let ratio = incident.irradiance / incident.irradiance.z;
            assert!((ratio - Vec3::new(4.0, 2.0, 1.0)).length() < 0.05, "{ratio}");
        }
        let square = image::DynamicImage::from(image::Rgb32FImage::new(8, 8));
        let black = image::DynamicImage::from(image::Rgb32FImage::new(8, 4));
        for (picture, said) in [(square, "8 x 8"), (black, "black")] {
            let mut bytes = std::io::Cursor::new(Vec::new());
            picture.write_to(&mut bytes, ImageFormat::OpenExr).unwrap();
            let error = EnvironmentMap::from_bytes(bytes.get_ref()).unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        }
        assert!(EnvironmentMap::from_bytes(b"no picture").is_err());
        let mut doubtful = picture_of_ones();
        for (column, value) in [f32::NAN, -1.0, f32::INFINITY].into_iter().enumerate() {
            doubtful.put_pixel(column as u32, 1, image::Rgb([value, 1.0, 1.0]));
        }
        let mut bytes = std::io::Cursor::new(Vec::new());
        image::DynamicImage::from(doubtful).write_to(&mut bytes, ImageFormat::OpenExr).unwrap();
        let environment = Environment::from_bytes("doubtful.exr", bytes.get_ref()).unwrap();
        assert!(environment.note().unwrap().contains("3 pixels are"), "{:?}", environment.note());
        let brightest = environment.levels()[0].radiance.iter().map(|c| c.max_element()).fold(0.0, f32::max);
        assert_eq!(brightest, LARGEST_RADIANCE);
        assert_eq!(Environment::open("sky").unwrap().note(), None);
        let header = |size: &str| format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n").into_bytes();
        for size in ["-Y 0 +X 0", "-Y 8 +X 16", "-Y 16000 +X 32000", "-Y 2147483648 +X 4294967295"] {
            assert!(EnvironmentMap::from_bytes(&header(size)).is_err(), "{size} and no pixels");
        }
    }
}
