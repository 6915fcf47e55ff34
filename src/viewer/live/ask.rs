//! What the threads are asked for.

use super::Live;
use crate::render::frame::View;
use crate::setup::{self, Method};
use crate::viewer::compare::{self, Compare};
use crate::viewer::pace::Rung;
use crate::viewer::settings::{Needs, Settings};
use crate::viewer::studio::Wish;
use crate::viewer::worker::{Prepared, Request, Role};
use std::sync::Arc;

impl Live {
    /// Asks the worker for what is set and not asked for yet.
    pub(super) fn prepare(&mut self) {
        let own = self.model.settings.clone();
        self.ask(Role::Own, &own);
        if self.model.compare != Compare::Alone {
            let optics = self.model.other.clone();
            self.ask(Role::Other, &Settings { optics, ..own.clone() });
        }
        let ready = self.model.own.as_ref().map(|p| p.number) == self.asked[0].as_ref().map(|a| a.0);
        // No layers are as fast as a table: its moving picture has its resolution to give.
        if self.model.pace.is_slow() && ready && own.optics.method == Method::Spectral {
            self.ask(Role::Coarse, &Settings { optics: compare::coarse(&own.optics), ..own.clone() });
            // Through repeats wavelengths stand where the orders are.
            if !own.repeats() && compare::looser_colours(&own.optics).is_some() {
                self.ask(Role::FewerWavelengths, &own);
            }
        }
    }

    pub(super) fn ask(&mut self, role: Role, settings: &Settings) {
        let asked = &mut self.asked[role as usize];
        if asked.as_ref().is_some_and(|(_, asked)| {
            let alike = Settings { scene: asked.scene.clone(), ..settings.clone() };
            alike.needs(asked) < Needs::Layers
        }) {
            return;
        }
        self.number += 1;
        *asked = Some((self.number, settings.clone()));
        match settings.shading(&settings.optics) {
            Ok(mut shading) => {
                if role == Role::FewerWavelengths {
                    shading.looser_colours = compare::looser_colours(&settings.optics).unwrap_or(1.0);
                    shading.wavelengths = None;
                }
                let surface = settings.surface.clone();
                let method = settings.method(&settings.optics);
                let settings = setup::Settings::new(method, shading);
                self.worker.ask(Request { role, number: self.number, surface, settings });
                self.model.progress[role as usize] = Some((0, 1));
                self.window.request_redraw();
            }
            Err(e) => self.model.complain(&e),
        }
        match role {
            // What was made for the former setting shows another thing.
            Role::Other => self.model.judge = None,
            Role::Coarse => self.model.lighter[0] = None,
            Role::FewerWavelengths => self.model.lighter[1] = None,
            Role::Own => self.title(),
        }
    }

    /// What is to be seen now, drawn whole; `None` before the first layers are there.
    pub(super) fn wish_now(&self) -> Option<Wish> {
        let model = &self.model;
        let own = model.own.clone().filter(|_| !model.size.contains(&0))?;
        let (shown, scene) = (model.shown(), &model.stage.scene);
        let view = View {
            camera: shown.shown_camera(scene),
            base_color: shown.base_color,
            pigment: scene.pigment.is_some(),
            ..View::of(scene, shown.lights)
        };
        Some(Wish {
            stage: model.stage.clone(),
            own,
            other: model.judge.clone(),
            lighter: None,
            rung: Rung::WHOLE,
            moving: false,
            again: false,
            view,
            exposure: shown.exposure,
            background: scene.background,
            size: model.size,
            compare: model.compare,
            inset: model.inset,
        })
    }

    /// Asks the studio for what is to be seen, if that has changed.
    pub(super) fn wish(&mut self, again: bool) {
        let Some(wish) = self.wish_now() else { return };
        let rung = self.model.rung();
        let lighter = self.model.lighter(rung.degree).cloned();
        let wish = Wish { rung, lighter, moving: self.model.moving, again, ..wish };
        if !again && self.wished.as_ref().is_some_and(|w| alike(w, &wish)) {
            return;
        }
        let same_picture =
            |w: &Wish| w.view == wish.view && w.own.number == wish.own.number && w.size == wish.size;
        if !self.wished.as_ref().is_some_and(same_picture) {
            // A measured error belongs to the picture that it was measured on.
            self.judge = None;
            self.model.verdict = None;
        }
        self.studio.wish(wish.clone());
        self.wished = Some(wish);
    }
}

/// Whether both show the same.
fn alike(a: &Wish, b: &Wish) -> bool {
    let number = |p: &Option<Arc<Prepared>>| p.as_ref().map(|p| p.number);
    Arc::ptr_eq(&a.stage, &b.stage)
        && a.own.number == b.own.number
        && number(&a.other) == number(&b.other)
        && (a.compare, a.rung, a.moving, a.size, a.inset) == (b.compare, b.rung, b.moving, b.size, b.inset)
        && (a.exposure, a.background) == (b.exposure, b.background)
        && a.view == b.view
}
