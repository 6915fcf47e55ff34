//! Pass that draws the displayed pictures into a window.

use super::shader;
use crate::error::Result;
use crate::vk::commands::Recorder;
use crate::vk::descriptors::{Binding, Descriptors};
use crate::vk::device::Device;
use crate::vk::image::Image;
use crate::vk::pipeline::{Drawing, Pipeline};
use crate::vk::sampler::Sampler;
use ash::vk;
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

/// Positions of the pictures in the window \[pixels\]; the push constants of `window.frag`.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct PicturePlace {
    /// Area of the pictures in the window, from the upper left corner.
    pub area: [f32; 2],
    /// Drawn size of the left picture.
    pub left: [f32; 2],
    /// Drawn size of the right picture.
    pub right: [f32; 2],
    /// First column of the right picture; `area[0]` if the left one is shown alone.
    pub split: f32,
}

/// Pipeline for window images of one format.
pub struct WindowPass {
    pipeline: Pipeline,
    sampler: Sampler,
    device: Arc<Device>,
}

/// Pictures shown by one frame; kept until the device is done with the frame.
pub struct WindowPictures {
    descriptors: Descriptors,
    images: Option<[Arc<Image>; 2]>,
}

impl WindowPass {
    /// Makes a pass into images of `format`.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn new(device: &Arc<Device>, format: vk::Format) -> Result<Self> {
        let layout = bindings(device)?;
        let drawing = Drawing { vertex_stride: 0, attributes: &[], colors: &[format], depth: None };
        let (vertex, fragment) = (shader!("display.vert"), Some(shader!("window.frag")));
        let push = size_of::<PicturePlace>() as u32;
        let pipeline = Pipeline::graphics(device, vertex, fragment, &drawing, &[&layout], push)?;
        let sampler = Sampler::linear(device, "window sampler", vk::SamplerAddressMode::CLAMP_TO_EDGE)?;
        Ok(Self { pipeline, sampler, device: device.clone() })
    }

    /// Makes the set for the pictures of one frame in flight.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn pictures(&self) -> Result<WindowPictures> {
        Ok(WindowPictures { descriptors: bindings(&self.device)?, images: None })
    }

    /// Points `pictures` at two images. The device must be done with the frame.
    pub fn show(&self, pictures: &mut WindowPictures, left: &Arc<Image>, right: &Arc<Image>) {
        let same = |[a, b]: &[Arc<Image>; 2]| Arc::ptr_eq(a, left) && Arc::ptr_eq(b, right);
        if pictures.images.as_ref().is_some_and(same) {
            return;
        }
        pictures.descriptors.image(0, left, &self.sampler);
        pictures.descriptors.image(1, right, &self.sampler);
        pictures.images = Some([left.clone(), right.clone()]);
    }

    /// Draws `pictures`; rendering to the window must have begun.
    pub fn draw(&self, draw: &Recorder<'_>, pictures: &WindowPictures, place: &PicturePlace) {
        draw.bind(&self.pipeline, &[&pictures.descriptors]);
        draw.push(&self.pipeline, bytemuck::bytes_of(place));
        draw.draw(3);
    }
}

/// Makes a set with two images for the fragment stage.
pub(super) fn bindings(device: &Arc<Device>) -> Result<Descriptors> {
    Descriptors::new(device, "two pictures", &[Binding::texture(0), Binding::texture(1)])
}
