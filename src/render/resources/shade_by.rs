//! Other settings for what is on the device already: the layers or the table stay, what is small is uploaded anew.

use super::{Optics, Resources, lines_block, numbers, optics_block, repeated, table_optics_block};
use crate::error::Result;
use crate::precompute::{Layers, thesis};
use crate::render::interface::binding;
use crate::render::shading::Shading;
use crate::render::tables::Combs;
use crate::render::upload;
use crate::vk::device::Device;
use std::sync::Arc;

/// Where [`Resources::new`] puts what is replaced here.
const NODES: usize = 2;
const LINE_WEIGHTS: usize = 5;

impl Resources {
    /// Shades by `shading`; `optics` is what is on the device. The device must not be using the set.
    ///
    /// # Errors
    /// Where the device has no room, or is lost.
    pub fn shade_by(&mut self, device: &Arc<Device>, optics: Optics<'_>, shading: &Shading) -> Result<()> {
        match optics {
            Optics::Layers(layers) => {
                let combs = Combs::of(layers, shading);
                self.of_layers_by(device, (layers, layers.sigma), combs, shading.ior)
            }
            Optics::Repeats(layers, repeats) => {
                let (block, combs) = repeated(&repeats, shading);
                self.of_layers_by(device, (layers, repeats.sigma()), combs, shading.ior)?;
                self.copies = Some(block);
                Ok(())
            }
            Optics::Thesis(layers, _) => {
                let combs = Combs::even_wavelengths(&shading.illuminant, thesis::WAVELENGTHS);
                self.of_layers_by(device, (layers, layers.sigma), combs, shading.ior)
            }
            // Of a table only the reflectance depends on more than the table.
            Optics::Table(table, filter) => {
                let block = table_optics_block(table, filter, shading.ior);
                upload::into(device, &self.buffers[0], bytemuck::bytes_of(&block))
            }
        }
    }

    fn of_layers_by(
        &mut self,
        device: &Arc<Device>,
        (layers, sigma): (&Layers, f64),
        combs: Combs,
        ior: f64,
    ) -> Result<()> {
        let nodes = numbers(device, "nodes", &combs.nodes)?;
        let weights = numbers(device, "weights of lines", &combs.line_weights())?;
        // These keep their sizes and their places: other bindings of the set may hold them, too.
        let [optics, bins, lines, ..] = self.buffers.as_slice() else { return Ok(()) };
        upload::into(device, optics, bytemuck::bytes_of(&optics_block(layers, sigma, ior)))?;
        upload::into(device, bins, bytemuck::cast_slice(&combs.bins))?;
        upload::into(device, lines, bytemuck::bytes_of(&lines_block(layers, &combs)))?;
        self.descriptors.image(binding::NODES, &nodes, &self.edge);
        self.descriptors.image(binding::LINE_WEIGHTS, &weights, &self.edge);
        self.images[NODES] = nodes;
        self.images[LINE_WEIGHTS] = weights;
        self.combs = combs;
        Ok(())
    }
}
