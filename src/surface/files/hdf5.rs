//! Access to HDF5 files, in which several makers keep their measurements: attributes, and images in datasets.

use super::bytes::damaged;
use super::scan::{Channel, Quantity, flip};
use super::units;
use crate::error::{Error, Result};
use crate::notes::PreparationRecord;
use hdf5_reader::group::Group;
use hdf5_reader::messages::datatype::VarLenKind;
use hdf5_reader::{Attribute, Dataset, Datatype, H5Type, Hdf5File, SliceInfo, SliceInfoElem};

/// First bytes of a file.
pub const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";

/// Returns true if `bytes` are an HDF5 file that has `name` somewhere: names of attributes are never compressed.
pub fn has(bytes: &[u8], name: &str) -> bool {
    bytes.starts_with(SIGNATURE) && bytes.windows(name.len()).any(|window| window == name.as_bytes())
}

/// Returns the root group of the file in `bytes`.
///
/// # Errors
/// A file that is damaged or cut short.
pub fn root(bytes: &[u8]) -> Result<Group> {
    Hdf5File::from_bytes(bytes).and_then(|file| file.root_group()).map_err(explain)
}

/// Returns the error of a file that cannot be decoded.
pub fn explain(e: hdf5_reader::error::Error) -> Error {
    damaged(e.to_string().lines().next().unwrap_or_default()).caused_by(e)
}

/// Evaluates `$body` with `$name` as the type of the numbers of a datatype; `None` if they are no numbers.
macro_rules! for_type {
    ($datatype:expr, $name:ident => $body:block) => {{
        macro_rules! with {
            ($number:ty) => {{
                type $name = $number;
                Some($body)
            }};
        }
        match $datatype {
            Datatype::FloatingPoint { size: 4, .. } => with!(f32),
            Datatype::FloatingPoint { size: 8, .. } => with!(f64),
            Datatype::FixedPoint { size: 1, signed: true, .. } => with!(i8),
            Datatype::FixedPoint { size: 1, signed: false, .. } => with!(u8),
            Datatype::FixedPoint { size: 2, signed: true, .. } => with!(i16),
            Datatype::FixedPoint { size: 2, signed: false, .. } => with!(u16),
            Datatype::FixedPoint { size: 4, signed: true, .. } => with!(i32),
            Datatype::FixedPoint { size: 4, signed: false, .. } => with!(u32),
            Datatype::FixedPoint { size: 8, signed: true, .. } => with!(i64),
            Datatype::FixedPoint { size: 8, signed: false, .. } => with!(u64),
            _ => None,
        }
    }};
}

/// Attributes of a group or of a dataset.
pub struct Attributes<'a> {
    owner: &'a Group,
    list: Vec<Attribute>,
}

impl<'a> Attributes<'a> {
    /// Returns the attributes of `group`.
    ///
    /// # Errors
    /// A group that is damaged.
    pub fn of_group(group: &'a Group) -> Result<Self> {
        Ok(Self { owner: group, list: group.attributes().map_err(explain)? })
    }

    /// Returns the attributes of `dataset`, which is in `group`.
    pub fn of_dataset(group: &'a Group, dataset: &Dataset) -> Self {
        Self { owner: group, list: dataset.attributes() }
    }

    /// Returns a text, or the first of several.
    pub fn text(&self, name: &str) -> Option<String> {
        self.find(name)?.read_strings().ok()?.into_iter().next()
    }

    /// Returns a number, or the first of several.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.numbers(name).first().copied()
    }

    /// Returns all numbers of an attribute; none if it has none.
    pub fn numbers(&self, name: &str) -> Vec<f64> {
        let read = |attribute: &Attribute| decoded(&attribute.raw_data, &attribute.datatype);
        self.find(name).and_then(read).unwrap_or_default()
    }

    /// Returns the numbers in the field `field` of the record that an attribute is, a list of any length.
    pub fn list_in_record(&self, name: &str, field: &str) -> Option<Vec<f64>> {
        let attribute = self.find(name)?;
        let Datatype::Compound { fields, .. } = &attribute.datatype else { return None };
        let field = fields.iter().find(|f| f.name == field)?;
        let Datatype::VarLen { base, kind: VarLenKind::Sequence, .. } = &field.datatype else { return None };
        let reference = attribute.raw_data.get(usize::try_from(field.byte_offset).ok()?..)?;
        // Number of elements, place in the file, number within the heap.
        let reference = reference.get(..4 + usize::from(self.owner.offset_size()) + 4)?;
        let bytes = self.owner.resolve_vlen_reference_bytes(reference, width(base)?).ok()?;
        decoded(&bytes, base)
    }

    fn find(&self, name: &str) -> Option<&Attribute> {
        self.list.iter().find(|attribute| attribute.name == name)
    }
}

/// Image in a dataset, and what its numbers stand for.
pub struct StoredImage {
    /// The dataset: rows and columns, or all samples in a row.
    pub dataset: Dataset,
    /// Number of the image, if each of several is a column of the dataset.
    pub column: Option<u64>,
    /// Size of one unit of the stored number in `unit`, and value of a stored 0.
    pub scale: [f64; 2],
    /// Unit of the samples.
    pub unit: String,
    /// Least and largest stored number of samples that were not measured.
    pub missing: Option<[f64; 2]>,
    /// True if the first row is the lowest.
    pub is_bottom_first: bool,
}

impl StoredImage {
    /// Returns the channel `name` of `size`.
    pub fn channel<'a>(self, name: String, size: [usize; 2], spacing: [Option<f64>; 2]) -> Channel<'a> {
        let metres = units::length(&self.unit);
        Channel {
            name,
            unit: self.unit.clone(),
            size,
            spacing,
            quantity: if metres.is_some() { Quantity::Height } else { Quantity::Other },
            prepared: PreparationRecord::default(),
            decode: Box::new(move || self.samples(size, metres.unwrap_or(1.0))),
        }
    }

    /// Returns the samples in units of `unit`, from the top.
    fn samples(&self, size: [usize; 2], unit: f64) -> Result<Vec<f64>> {
        let columns =
            if self.column.is_some() { self.dataset.shape().get(1).copied().unwrap_or(1) } else { 1 };
        let count = self.dataset.num_elements().map_err(explain)?;
        if count != (size[0] * size[1]) as u64 * columns {
            return Err(damaged(format!(
                "an image of {} x {} has {} samples",
                size[0],
                size[1],
                count / columns.max(1)
            )));
        }
        let mut samples = numbers(&self.dataset, self.column)?;
        for x in &mut samples {
            let is_missing = self.missing.is_some_and(|[least, most]| (least..=most).contains(x));
            *x = if is_missing { f64::NAN } else { (*x * self.scale[0] + self.scale[1]) * unit };
        }
        if self.is_bottom_first && samples.len() == size[0] * size[1] {
            flip(&mut samples, size[0]);
        }
        Ok(samples)
    }
}

/// Returns the numbers of a dataset, or of one of its columns.
fn numbers(dataset: &Dataset, column: Option<u64>) -> Result<Vec<f64>> {
    let all = SliceInfoElem::Slice { start: 0, end: u64::MAX, step: 1 };
    let mut selections = vec![all; dataset.ndim()];
    if let (Some(column), [_, last]) = (column, &mut selections[..]) {
        *last = SliceInfoElem::Index(column);
    }
    let selection = SliceInfo { selections };
    let found = for_type!(dataset.dtype(), Number => {
        dataset.read_slice::<Number>(&selection).map(|array| array.iter().map(|x| *x as f64).collect())
    });
    found.ok_or_else(|| damaged("its samples are no numbers"))?.map_err(explain)
}

/// Returns the least and the largest number of the integers of a dataset; `None` if it holds none.
pub fn range_of_integers(dataset: &Dataset) -> Option<[f64; 2]> {
    match dataset.dtype() {
        Datatype::FixedPoint { size, signed: true, .. } => {
            let half = (8.0 * f64::from(*size) - 1.0).exp2();
            Some([-half, half - 1.0])
        }
        Datatype::FixedPoint { size, signed: false, .. } => {
            Some([0.0, (8.0 * f64::from(*size)).exp2() - 1.0])
        }
        _ => None,
    }
}

/// Returns the number that stands for samples of `dataset` that were never written, if the file names one.
pub fn fill_value(dataset: &Dataset) -> Option<f64> {
    let bytes = dataset.fill_value()?.value.as_ref()?;
    decoded(bytes, dataset.dtype())?.first().copied()
}

/// Returns the bytes of one number.
fn width(datatype: &Datatype) -> Option<usize> {
    match datatype {
        Datatype::FloatingPoint { size, .. } | Datatype::FixedPoint { size, .. } => {
            Some(usize::from(*size)).filter(|n| *n > 0)
        }
        _ => None,
    }
}

/// Returns the numbers in `bytes`; `None` if they are of no known type.
fn decoded(bytes: &[u8], datatype: &Datatype) -> Option<Vec<f64>> {
    let mut each = bytes.chunks_exact(width(datatype)?);
    let found: hdf5_reader::error::Result<Vec<f64>> = for_type!(datatype, Number => {
        each.try_fold(Vec::new(), |mut found, bytes| {
            found.push(Number::from_bytes(bytes, datatype)? as f64);
            Ok(found)
        })
    })?;
    found.ok()
}
