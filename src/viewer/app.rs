//! Event loop: handles window events and requests redraws.

use super::event::Event;
use super::start::Start;
use super::viewer_window::ViewerWindow;
use super::work_area;
use crate::error::{Error, Remedy, Result};
use crate::vk::instance::Instance;
use std::sync::Arc;
use std::time::Instant;
use winit::application::ApplicationHandler;
use winit::dpi::{LogicalSize, PhysicalSize, Size};
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::window::{Window, WindowId};

/// Handler of the event loop.
pub struct App {
    start: Start,
    proxy: EventLoopProxy<Event>,
    window: Option<ViewerWindow>,
    instance: Option<Arc<Instance>>,
    error: Option<Error>,
}

impl App {
    /// Makes a handler that opens the window when the event loop starts.
    pub fn new(start: Start, proxy: EventLoopProxy<Event>) -> Self {
        Self { start, proxy, window: None, instance: None, error: None }
    }

    /// Ends the threads and frees the device; returns the instance and the first error.
    pub fn end(mut self) -> (Option<Arc<Instance>>, Result<()>) {
        let kept = self.window.as_ref().map_or(Ok(()), ViewerWindow::keep);
        let command = self.error.is_some().then(|| self.window.as_ref().map(ViewerWindow::command)).flatten();
        self.window = None;
        let result = match (self.error, command) {
            (None, _) => kept,
            // The command that draws the same picture keeps the settings from being lost.
            (Some(e), Some(command)) => Err(e.or(format!("draw the same picture with: {command}"))),
            (Some(e), None) => Err(e),
        };
        (self.instance, result)
    }

    fn open(&mut self, events: &ActiveEventLoop) -> Result<()> {
        let size: Size = match work_area::fitting(events, self.start.size) {
            Some([width, height]) => PhysicalSize::new(width, height).into(),
            None => LogicalSize::new(self.start.size[0], self.start.size[1]).into(),
        };
        let attributes = Window::default_attributes()
            .with_title("diffract")
            .with_inner_size(size)
            .with_min_inner_size(PhysicalSize::new(1, 1));
        let opened = events.create_window(attributes).map_err(|e| {
            Error::device(format!("the display gives no window ({e})"), Remedy::PictureFile).caused_by(e)
        })?;
        let (proxy, instance) = (self.proxy.clone(), &mut self.instance);
        self.window = Some(ViewerWindow::new(&self.start, Arc::new(opened), proxy, instance)?);
        Ok(())
    }

    /// Ends the event loop on an error.
    fn check(&mut self, events: &ActiveEventLoop, result: Result<()>) {
        if let Err(e) = result {
            self.error.get_or_insert(e);
            events.exit();
        }
    }
}

impl ApplicationHandler<Event> for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.window.is_none() {
            let opened = self.open(events);
            self.check(events, opened);
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(window) = &mut self.window else { return };
        let result = match event {
            WindowEvent::CloseRequested => {
                events.exit();
                Ok(())
            }
            WindowEvent::Destroyed => {
                // An error that came before is one of its consequences.
                self.error = None;
                Err(Error::device("another program has destroyed the window", "open it again"))
            }
            WindowEvent::RedrawRequested => window.redraw(),
            event => {
                window.event(&event);
                Ok(())
            }
        };
        let close = window.closes();
        self.check(events, result);
        if close {
            events.exit();
        }
    }

    fn user_event(&mut self, events: &ActiveEventLoop, event: Event) {
        let Some(window) = &mut self.window else { return };
        let result = window.handle(event);
        self.check(events, result);
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let Some(window) = &mut self.window else { return };
        let mut wake = window.wake();
        if wake.is_some_and(|at| at <= Instant::now()) {
            window.request_redraw();
            wake = None;
        }
        let wake = wake.into_iter().chain(window.poll()).min();
        events.set_control_flow(wake.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}
