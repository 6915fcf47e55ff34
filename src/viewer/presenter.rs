//! Presents frames of the window: the pictures, with the panel on top, two frames in flight.

use super::atlas::FrameResources;
use super::gui::{Gui, PaintJobs};
use crate::error::Result;
use crate::render::window_pass::{PicturePlace, WindowPass, WindowPictures};
use crate::vk::access::Access;
use crate::vk::commands::Commands;
use crate::vk::device::Device;
use crate::vk::image::Image;
use crate::vk::semaphore::Semaphore;
use crate::vk::swapchain::{Presented, Swapchain};
use crate::vk::window_surface::Surface;
use ash::vk;
use std::sync::Arc;
use winit::window::Window;

/// Number of frames in flight: one is recorded while the previous one is shown.
const FRAMES_IN_FLIGHT: usize = 2;

/// Resources of one frame in flight.
struct FrameInFlight {
    // First: dropping it waits for the work that uses the other fields.
    commands: Commands,
    acquired: Semaphore,
    pictures: WindowPictures,
    resources: FrameResources,
}

/// Pictures to show and their positions.
pub struct ShownPictures<'a> {
    /// Pictures left and right of the split.
    pub images: [&'a Arc<Image>; 2],
    /// Positions in the window.
    pub place: PicturePlace,
}

/// Surface of a window, and everything that draws to it.
pub struct Presenter {
    frames: Vec<FrameInFlight>,
    next: usize,
    gui: Gui,
    pass: WindowPass,
    // `None` while the window has no area.
    swapchain: Option<Swapchain>,
    outdated: bool,
    mode: vk::PresentModeKHR,
    // Size of the window [pixels].
    size: [u32; 2],
    surface: Arc<Surface>,
    window: Arc<Window>,
    device: Arc<Device>,
}

impl Presenter {
    /// Makes a presenter for `window`, in presentation mode `mode` if the device supports it.
    ///
    /// # Errors
    /// Fails if Vulkan reports an error.
    pub fn new(
        device: &Arc<Device>,
        surface: &Arc<Surface>,
        window: &Arc<Window>,
        mode: vk::PresentModeKHR,
    ) -> Result<Self> {
        let format = Swapchain::format_of(device, surface)?;
        let pass = WindowPass::new(device, format)?;
        let frame = || {
            Ok(FrameInFlight {
                commands: Commands::new(device, "window")?,
                acquired: Semaphore::new(device, "image acquired")?,
                pictures: pass.pictures()?,
                resources: FrameResources::default(),
            })
        };
        Ok(Self {
            frames: (0..FRAMES_IN_FLIGHT).map(|_| frame()).collect::<Result<_>>()?,
            next: 0,
            gui: Gui::new(device, format, FRAMES_IN_FLIGHT)?,
            pass,
            swapchain: None,
            outdated: true,
            mode,
            size: window.inner_size().into(),
            surface: surface.clone(),
            window: window.clone(),
            device: device.clone(),
        })
    }

    /// Returns the device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// Recreates the swapchain before the next frame, because the window has `size` pixels now.
    pub fn resized(&mut self, size: [u32; 2]) {
        (self.size, self.outdated) = (size, true);
    }

    /// Returns the presentation mode.
    pub fn mode(&self) -> vk::PresentModeKHR {
        self.swapchain.as_ref().map_or(self.mode, Swapchain::mode)
    }

    /// Draws a frame and presents it; false if nothing was shown because the window has no area or was resized
    /// meanwhile.
    ///
    /// # Errors
    /// Fails if the device is lost.
    pub fn draw(&mut self, pictures_shown: Option<&ShownPictures<'_>>, jobs: &mut PaintJobs) -> Result<bool> {
        if self.outdated {
            self.recreate_swapchain()?;
        }
        let Some(swapchain) = &self.swapchain else { return Ok(false) };
        let frame = &mut self.frames[self.next];
        frame.commands.wait()?;
        frame.resources.clear();
        let index = match swapchain.acquire(&frame.acquired)? {
            Presented::Done(index) => index,
            Presented::Outdated => {
                self.outdated = true;
                return Ok(false);
            }
            Presented::Lost => return self.recreate_surface(),
        };
        self.next = (self.next + 1) % FRAMES_IN_FLIGHT;
        if let Some(ShownPictures { images: [left, right], .. }) = pictures_shown {
            self.pass.show(&mut frame.pictures, left, right);
        }
        let image = swapchain.image(index);
        let (pass, pictures, gui, resources) =
            (&self.pass, &frame.pictures, &mut self.gui, &mut frame.resources);
        let record = |record: &crate::vk::commands::Recorder<'_>| {
            gui.upload(record, &mut jobs.textures, resources)?;
            record.images(&[(image, Access::Nothing, Access::ColorAttachment)]);
            let mut drawn = Ok(());
            record.render(&[(image, Some(BACKGROUND))], None, |draw| {
                if let Some(pictures_shown) = pictures_shown {
                    pass.draw(draw, pictures, &pictures_shown.place);
                }
                drawn = gui.draw(draw, image.size(), jobs, resources);
            });
            record.images(&[(image, Access::ColorAttachment, Access::Present)]);
            drawn
        };
        frame.commands.start(record, Some(&frame.acquired), Some(swapchain.drawn(index)))?;
        match swapchain.present(index)? {
            Presented::Done(()) => Ok(true),
            Presented::Outdated => {
                self.outdated = true;
                Ok(true)
            }
            Presented::Lost => self.recreate_surface(),
        }
    }

    /// Recreates the swapchain.
    fn recreate_swapchain(&mut self) -> Result<()> {
        self.frames.iter_mut().try_for_each(|frame| frame.commands.wait())?;
        match Swapchain::new(&self.device, &self.surface, self.size, self.mode, self.swapchain.take())? {
            Presented::Done(swapchain) => {
                // A window without area gets a swapchain once it has one.
                self.outdated = swapchain.is_none();
                self.swapchain = swapchain;
                Ok(())
            }
            Presented::Outdated => Ok(()),
            Presented::Lost => self.recreate_surface().map(drop),
        }
    }

    /// Recreates surface and swapchain.
    fn recreate_surface(&mut self) -> Result<bool> {
        self.frames.iter_mut().try_for_each(|frame| frame.commands.wait())?;
        self.swapchain = None;
        self.surface = Arc::new(Surface::new(self.device.instance(), &self.window)?);
        self.outdated = true;
        Ok(false)
    }
}

/// Colour behind picture and panel, linear.
const BACKGROUND: [f32; 4] = [0.07, 0.075, 0.085, 1.0];
