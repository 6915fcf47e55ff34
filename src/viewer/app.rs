//! Between winit and the program: events in, redraws out.

use super::Start;
use super::judge::Verdict;
use super::live::Live;
use super::studio::{Stage, Word};
use super::worker::Report;
use crate::error::{Error, Result};
use crate::vk::instance::Instance;
use std::sync::Arc;
use std::time::Instant;
use winit::application::ApplicationHandler;
use winit::dpi::PhysicalSize;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::window::{Window, WindowId};

/// What threads tell the window.
pub enum Event {
    /// The worker.
    Worker(Report),
    /// The studio.
    Studio(Word),
    /// The judge.
    Judge(Result<Verdict>),
    /// A scene was opened under its name.
    Scene(String, Box<Result<Stage>>),
}

/// The program behind the event loop.
pub struct App {
    start: Start,
    proxy: EventLoopProxy<Event>,
    live: Option<Live>,
    instance: Option<Arc<Instance>>,
    error: Option<Error>,
}

impl App {
    /// Before the window is there.
    pub fn new(start: Start, proxy: EventLoopProxy<Event>) -> Self {
        Self { start, proxy, live: None, instance: None, error: None }
    }

    /// Ends threads, frees the device, and tells how it went.
    pub fn end(mut self) -> (Option<Arc<Instance>>, Result<()>) {
        let lost = self.error.is_some().then(|| self.live.as_ref().map(Live::command)).flatten();
        self.live = None;
        let result = match (self.error, lost) {
            (None, _) => Ok(()),
            // The scene is not lost: it can be drawn from this line.
            (Some(e), Some(command)) => Err(e.or(format!("draw what was shown by: {command}"))),
            (Some(e), None) => Err(e),
        };
        (self.instance, result)
    }

    fn open(&mut self, events: &ActiveEventLoop) -> Result<()> {
        let [width, height] = self.start.size;
        let attributes = Window::default_attributes()
            .with_title("diffract")
            .with_inner_size(PhysicalSize::new(width, height))
            .with_min_inner_size(PhysicalSize::new(1, 1));
        let window = events
            .create_window(attributes)
            .map_err(|e| Error::failed(format!("the display gives no window ({e})"), super::RENDER))?;
        let live = Live::new(&self.start, Arc::new(window), self.proxy.clone(), &mut self.instance)?;
        self.live = Some(live);
        Ok(())
    }

    /// Ends the loop where something failed.
    fn check(&mut self, events: &ActiveEventLoop, result: Result<()>) {
        if let Err(e) = result {
            self.error.get_or_insert(e);
            events.exit();
        }
    }
}

impl ApplicationHandler<Event> for App {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.live.is_none() {
            let opened = self.open(events);
            self.check(events, opened);
        }
    }

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let Some(live) = &mut self.live else { return };
        let result = match event {
            WindowEvent::CloseRequested | WindowEvent::Destroyed => {
                events.exit();
                Ok(())
            }
            WindowEvent::RedrawRequested => live.redraw(),
            event => {
                live.event(&event);
                Ok(())
            }
        };
        let close = live.closes();
        self.check(events, result);
        if close {
            events.exit();
        }
    }

    fn user_event(&mut self, events: &ActiveEventLoop, event: Event) {
        let Some(live) = &mut self.live else { return };
        let result = live.hear(event);
        self.check(events, result);
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        let Some(live) = &mut self.live else { return };
        let mut wake = live.wake();
        if wake.is_some_and(|at| at <= Instant::now()) {
            live.request_redraw();
            wake = None;
        }
        let wake = wake.into_iter().chain(live.look()).min();
        events.set_control_flow(wake.map_or(ControlFlow::Wait, ControlFlow::WaitUntil));
    }
}
