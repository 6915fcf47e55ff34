//! Limits of energy in the cache on disk.

use crate::brdf::energy_map::{EnergyMap, EnergyMapHeader};
use crate::cache::{EntryFormat, Kept, Payload};
use crate::optics::energy::DirectionGrid;

impl Kept for EnergyMap {
    /// The version changes whenever the map of the same key would change.
    const FORMAT: EntryFormat = EntryFormat { name: "energy", version: 2 };
    type Header = EnergyMapHeader;

    fn header(&self) -> EnergyMapHeader {
        EnergyMap::header(self)
    }

    fn payload(&self) -> Vec<&[u8]> {
        vec![bytemuck::cast_slice(self.points())]
    }

    fn build(header: EnergyMapHeader, payload: &mut Payload<'_>) -> Option<Self> {
        let numbers = payload.take::<f32>(2 * DirectionGrid::COUNT)?;
        let points = numbers.as_chunks().0.to_vec();
        Self::from_parts(header, points)
    }
}
