//! Frames of the window: pictures below, the panel above, two frames in flight.

use super::atlas::Kept;
use super::gui::{Gui, Painting};
use crate::error::Result;
use crate::render::window::{Pictures, Place, WindowPass};
use crate::vk::access::Access;
use crate::vk::commands::Commands;
use crate::vk::device::Device;
use crate::vk::image::Image;
use crate::vk::semaphore::Semaphore;
use crate::vk::surface::Surface;
use crate::vk::swapchain::{Shown, Swapchain};
use ash::vk;
use std::sync::Arc;
use winit::window::Window;

/// Frames in flight: one is drawn while the one before is shown.
const FLIGHTS: usize = 2;

/// What one frame in flight uses.
struct Flight {
    // First: waits for its work before anything that the work uses goes.
    commands: Commands,
    acquired: Semaphore,
    pictures: Pictures,
    kept: Kept,
}

/// The pictures to show and where.
pub struct Scenery<'a> {
    /// Left and right of the split.
    pub images: [&'a Arc<Image>; 2],
    /// Where they lie.
    pub place: Place,
}

/// A window's surface and all that draws to it.
pub struct Screen {
    flights: Vec<Flight>,
    next: usize,
    gui: Gui,
    pass: WindowPass,
    // None: for now there is nothing to draw to.
    swapchain: Option<Swapchain>,
    outdated: bool,
    mode: vk::PresentModeKHR,
    surface: Arc<Surface>,
    window: Arc<Window>,
    device: Arc<Device>,
}

impl Screen {
    /// The screen of `window`, presenting by `mode` where the device can.
    ///
    /// # Errors
    /// Where the device refuses.
    pub fn new(
        device: &Arc<Device>,
        surface: &Arc<Surface>,
        window: &Arc<Window>,
        mode: vk::PresentModeKHR,
    ) -> Result<Self> {
        let format = Swapchain::format_of(device, surface)?;
        let pass = WindowPass::new(device, format)?;
        let flight = || {
            Ok(Flight {
                commands: Commands::new(device, "window")?,
                acquired: Semaphore::new(device, "image acquired")?,
                pictures: pass.pictures()?,
                kept: Kept::default(),
            })
        };
        Ok(Self {
            flights: (0..FLIGHTS).map(|_| flight()).collect::<Result<_>>()?,
            next: 0,
            gui: Gui::new(device, format, FLIGHTS)?,
            pass,
            swapchain: None,
            outdated: true,
            mode,
            surface: surface.clone(),
            window: window.clone(),
            device: device.clone(),
        })
    }

    /// The swapchain no longer fits the window.
    pub fn resized(&mut self) {
        self.outdated = true;
    }

    /// How frames are presented.
    pub fn mode(&self) -> vk::PresentModeKHR {
        self.swapchain.as_ref().map_or(self.mode, Swapchain::mode)
    }

    /// Draws a frame and hands it to the window; false where the window has no area or changed meanwhile, so that nothing is
    /// shown yet.
    ///
    /// # Errors
    /// Where the device is lost.
    pub fn draw(&mut self, scenery: Option<&Scenery<'_>>, painting: &mut Painting) -> Result<bool> {
        if self.outdated {
            self.renew()?;
        }
        let Some(swapchain) = &self.swapchain else { return Ok(false) };
        let flight = &mut self.flights[self.next];
        flight.commands.wait()?;
        flight.kept.clear();
        let index = match swapchain.acquire(&flight.acquired)? {
            Shown::Done(index) => index,
            Shown::Outdated => {
                self.outdated = true;
                return Ok(false);
            }
            Shown::Lost => return self.lost(),
        };
        self.next = (self.next + 1) % FLIGHTS;
        if let Some(Scenery { images: [left, right], .. }) = scenery {
            self.pass.show(&mut flight.pictures, left, right);
        }
        let image = swapchain.image(index);
        let (pass, pictures, gui, kept) = (&self.pass, &flight.pictures, &mut self.gui, &mut flight.kept);
        let record = |record: &crate::vk::commands::Recorder<'_>| {
            gui.upload(record, &mut painting.textures, kept)?;
            record.images(&[(image, Access::Nothing, Access::ColorAttachment)]);
            let mut drawn = Ok(());
            record.render(&[(image, Some(BACKDROP))], None, |draw| {
                if let Some(scenery) = scenery {
                    pass.draw(draw, pictures, &scenery.place);
                }
                drawn = gui.draw(draw, image.size(), painting, kept);
            });
            record.images(&[(image, Access::ColorAttachment, Access::Present)]);
            drawn
        };
        flight.commands.start(record, Some(&flight.acquired), Some(swapchain.drawn(index)))?;
        match swapchain.present(index)? {
            Shown::Done(()) => Ok(true),
            Shown::Outdated => {
                self.outdated = true;
                Ok(true)
            }
            Shown::Lost => self.lost(),
        }
    }

    /// Makes the swapchain anew.
    fn renew(&mut self) -> Result<()> {
        self.flights.iter_mut().try_for_each(|flight| flight.commands.wait())?;
        let size: [u32; 2] = self.window.inner_size().into();
        match Swapchain::new(&self.device, &self.surface, size, self.mode, self.swapchain.take())? {
            Shown::Done(swapchain) => {
                // A window without area is outdated until it has one.
                self.outdated = swapchain.is_none();
                self.swapchain = swapchain;
                Ok(())
            }
            Shown::Outdated => Ok(()),
            Shown::Lost => self.lost().map(drop),
        }
    }

    /// Makes surface and swapchain anew.
    fn lost(&mut self) -> Result<bool> {
        self.flights.iter_mut().try_for_each(|flight| flight.commands.wait())?;
        self.swapchain = None;
        self.surface = Arc::new(Surface::new(self.device.instance(), &self.window)?);
        self.outdated = true;
        Ok(false)
    }
}

/// Behind picture and panel.
const BACKDROP: [f32; 4] = [0.07, 0.075, 0.085, 1.0];
