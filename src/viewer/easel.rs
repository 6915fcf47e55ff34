//! What the studio draws with: a painter for each setting, and what is kept between pictures.

use super::compare::Compare;
use super::inset::{self, Inset};
use super::judge;
use super::pace::{Degree, Rung};
use super::studio::{Counted, Errand, Exhibit, Shared, Stage, Wish, Word};
use super::worker::Prepared;
use crate::error::{Error, Result};
use crate::render::difference::DifferencePass;
use crate::render::frame::View;
use crate::render::picture::Painter;
use crate::render::source::Source;
use crate::vk::device::Device;
use std::sync::{Arc, PoisonError};
use std::time::Instant;

/// A painter and what it was made for.
struct Slot {
    painter: Painter,
    prepared: Arc<Prepared>,
    stage: Arc<Stage>,
    // What its display shows: view, exposure, pixels.
    shown: Option<(View, f64, [u32; 2])>,
}

impl Slot {
    /// Whether all that is large of `prepared` and of the scene of `wish` is on the device.
    fn serves(&self, prepared: &Prepared, wish: &Wish) -> bool {
        Arc::ptr_eq(&self.stage, &wish.stage)
            && self.prepared.shaded_from.shares_data_with(&prepared.shaded_from)
    }

    /// Shades by `prepared` from now on: of what is on the device, only what depends on its settings is made anew.
    fn take_over(&mut self, prepared: &Arc<Prepared>) -> Result<()> {
        if self.prepared.number != prepared.number {
            self.shown = None;
            self.painter.shade_by(&prepared.shaded_from, &prepared.shading)?;
            self.prepared = prepared.clone();
        }
        Ok(())
    }
}

/// What the thread keeps between pictures.
pub struct Easel {
    own: Option<Slot>,
    other: Option<Slot>,
    // For moving pictures: fewer wavelengths and layers, and fewer wavelengths alone.
    lighter: [Option<Slot>; 2],
    difference: Option<DifferencePass>,
    inset: Option<(Arc<Inset>, u64)>,
    counted: Option<(u64, View, [u32; 2], Counted)>,
    device: Arc<Device>,
}

/// A moving picture that takes so many times its budget is given up.
const PATIENCE: f64 = 400.0;

impl Easel {
    /// Without any painter yet.
    pub fn new(device: Arc<Device>) -> Self {
        Self {
            own: None,
            other: None,
            lighter: [None, None],
            difference: None,
            inset: None,
            counted: None,
            device,
        }
    }

    /// Does what is asked for until it is stopped.
    pub fn run(mut self, shared: &Shared, say: &dyn Fn(Word)) {
        loop {
            let (wish, errand) = {
                let mut desk = shared.desk();
                loop {
                    if desk.stop {
                        return;
                    }
                    if !desk.errands.is_empty() {
                        break (None, Some(desk.errands.remove(0)));
                    }
                    if let Some(wish) = desk.wish.take() {
                        break (Some(wish), None);
                    }
                    desk = shared.wake.wait(desk).unwrap_or_else(PoisonError::into_inner);
                }
            };
            let word = match (wish, errand) {
                (Some(wish), _) => self.draw(&wish, shared),
                (_, Some(errand)) => self.go(errand).map(Some),
                _ => Ok(None),
            };
            match word {
                Ok(Some(word)) => say(word),
                Ok(None) => {}
                Err(e) => say(Word::Failed(e)),
            }
        }
    }

    /// Draws `wish`; `None` where a newer wish made it vain.
    fn draw(&mut self, wish: &Wish, shared: &Shared) -> Result<Option<Word>> {
        let start = Instant::now();
        let moving = wish.moving;
        let superseded = || {
            let desk = shared.desk();
            desk.stop || desk.wish.is_some()
        };
        let newer = || superseded() || !shared.desk().errands.is_empty();
        let milliseconds = || start.elapsed().as_secs_f64() * 1e3;
        let mut go_on = || !(newer() && (!moving || milliseconds() > PATIENCE));
        self.tidy(wish);
        let slot = match (wish.rung.degree, &wish.lighter) {
            (Degree::Own, _) | (_, None) => &mut self.own,
            (Degree::Coarse, _) => &mut self.lighter[0],
            (Degree::FewerWavelengths, _) => &mut self.lighter[1],
        };
        let prepared = wish.lighter.as_ref().unwrap_or(&wish.own);
        let size = wish.rung.size(wish.size);
        let first = slot.as_ref().is_none_or(|slot| !slot.serves(prepared, wish));
        let painted = match paint(&self.device, slot, prepared, wish, size, &mut go_on) {
            Err(_) if wish.lighter.is_some() && !self.device.is_lost() => {
                *slot = None;
                return Ok(Some(Word::NoRoom(wish.rung.degree)));
            }
            painted => painted?,
        };
        let Some([mut gpu, mut wall]) = painted else {
            return Ok(moving.then(|| Word::TooSlow(wish.rung, milliseconds())));
        };
        let Some(left) = slot.as_ref().map(|s| s.painter.target().display.clone()) else { return Ok(None) };
        let (mut right, mut right_size) = (left.clone(), size);
        if let Some(other) = wish.other.as_ref().filter(|_| wish.compare != Compare::Alone) {
            let Some(more) = paint(&self.device, &mut self.other, other, wish, size, &mut go_on)? else {
                return Ok(None);
            };
            (gpu, wall) = (gpu + more[0], wall + more[1]);
            if let (Some(a), Some(b)) = (&self.own, &self.other) {
                right = match wish.compare {
                    Compare::Error => {
                        let pass = match &mut self.difference {
                            Some(pass) => pass,
                            none => none.insert(DifferencePass::new(&self.device, wish.size)?),
                        };
                        let targets = [a, b].map(|slot| slot.painter.target());
                        let geometry = b.painter.geometry();
                        pass.draw(geometry, targets, wish.exposure, wish.background)?.clone()
                    }
                    _ => b.painter.target().display.clone(),
                };
                right_size = size;
            }
        } else {
            self.other = None;
        }
        let inset = if wish.inset { self.hemisphere(wish)? } else { None };
        // A newer wish has its own counted; an errand draws nothing that would.
        let cost = match wish.rung {
            Rung::WHOLE if !superseded() => self.count(wish)?,
            _ => None,
        };
        Ok(Some(Word::Drawn(Box::new(Exhibit {
            images: [left, right],
            sizes: [size, right_size],
            rung: wish.rung,
            gpu,
            wall,
            first,
            cost,
            inset,
            number: wish.own.number,
        }))))
    }

    /// Gives up the lighter spectra of a setting that is no more.
    fn tidy(&mut self, wish: &Wish) {
        let own = wish.own.number;
        // They are asked for after the user's own.
        self.lighter.iter_mut().for_each(|slot| drop(slot.take_if(|slot| slot.prepared.number < own)));
    }

    /// The hemisphere of the first light, with the layers that are on the device anyway.
    fn hemisphere(&mut self, wish: &Wish) -> Result<Option<Arc<Inset>>> {
        let Some(light) = wish.view.lights.first().copied() else { return Ok(None) };
        let number = wish.own.number;
        if let Some((inset, of)) = &self.inset
            && (inset.light, *of) == (light, number)
        {
            return Ok(Some(inset.clone()));
        }
        let of = |slot: &&mut Slot, number: u64| slot.prepared.number == number;
        let own = self.own.as_mut().filter(|slot| of(slot, number));
        // Lighter spectra do for some thousand points.
        let lighter = wish.lighter.as_ref().map(|prepared| prepared.number);
        let mut others = self.lighter.iter_mut().flatten();
        let other = others.find(|slot| lighter.is_some_and(|number| of(slot, number)));
        let Some(slot) = own.or(other) else { return Ok(None) };
        let inset = Arc::new(inset::hemisphere(&mut slot.painter, light)?);
        self.inset = Some((inset.clone(), number));
        Ok(Some(inset))
    }

    /// Counts the work of the whole picture, once for each.
    fn count(&mut self, wish: &Wish) -> Result<Option<Counted>> {
        let key = (wish.own.number, &wish.view, wish.size);
        if let Some((number, view, size, counted)) = &self.counted
            && (*number, view, *size) == key
        {
            return Ok(Some(*counted));
        }
        let Some(slot) = &mut self.own else { return Ok(None) };
        let pixels = wish.size[0] as usize * wish.size[1] as usize;
        let directions = judge::directions(&mut slot.painter, &wish.view)?;
        let Prepared { shaded_from, shading, .. } = &*wish.own;
        // How far apart neighbours are decides what a table reads.
        let judged = match shaded_from {
            Source::Table(_) => directions,
            _ => judge::thinned(&directions, pixels),
        };
        let cost = shaded_from.cost(shading, &judged);
        let seen = judged.first().map_or(1, |d| d.view.len()).max(1);
        let counted = Counted {
            covered: cost.covered as f64 / seen as f64,
            wavelengths: cost.wavelengths_per_pixel(),
            samples: cost.samples_per_pixel(),
        };
        self.counted = Some((wish.own.number, wish.view.clone(), wish.size, counted));
        Ok(Some(counted))
    }

    fn go(&mut self, errand: Errand) -> Result<Word> {
        let (Errand::Picture(wish) | Errand::Samples(wish)) = &errand;
        paint(&self.device, &mut self.own, &wish.own, wish, wish.size, &mut || true)?;
        let Some(slot) = &mut self.own else {
            return Err(Error::failed("there is no picture", "report this as a bug of diffract"));
        };
        match &errand {
            Errand::Picture(_) => Ok(Word::Picture(Box::new(slot.painter.picture()?))),
            Errand::Samples(wish) => {
                let samples = judge::samples(&mut slot.painter, &wish.view)?;
                Ok(Word::Samples(wish.own.clone(), Box::new((wish.view.clone(), wish.exposure)), samples))
            }
        }
    }
}

/// Draws `wish` from `prepared` into the painter of `slot`, which is made where it is not there; milliseconds on the device
/// and on the wall, 0 for a frame that was there, or `None` where `go_on` said no.
fn paint(
    device: &Arc<Device>,
    slot: &mut Option<Slot>,
    prepared: &Arc<Prepared>,
    wish: &Wish,
    size: [u32; 2],
    go_on: &mut dyn FnMut() -> bool,
) -> Result<Option<[f64; 2]>> {
    let lights = wish.view.lights.len();
    let slot = match slot {
        Some(slot) if slot.serves(prepared, wish) => {
            slot.painter.resize(wish.size, lights)?;
            slot.take_over(prepared)?;
            slot
        }
        slot => {
            *slot = None; // its memory first
            let Stage { scene, pigment } = &*wish.stage;
            let Prepared { shaded_from, shading, .. } = &**prepared;
            let painter =
                Painter::new(device, shaded_from, shading, &scene.mesh, pigment, wish.size, lights)?;
            let (prepared, stage) = (prepared.clone(), wish.stage.clone());
            slot.insert(Slot { painter, prepared, stage, shown: None })
        }
    };
    let (view, exposure, background) = (&wish.view, wish.exposure, wish.background);
    if let Some((shown, at, pixels)) = &slot.shown
        && !wish.again
        && (shown, *pixels, slot.painter.target().size()) == (view, size, wish.size)
    {
        if *at == exposure {
            return Ok(Some([0.0; 2]));
        }
        if slot.painter.display_again(size, exposure, background)? {
            slot.shown = Some((view.clone(), exposure, size));
            return Ok(Some([0.0; 2]));
        }
    }
    if prepared.shaded_from.has_limits(&prepared.shading) {
        let directions = judge::directions(&mut slot.painter, view)?;
        prepared.shaded_from.check(&prepared.shading, &directions)?;
    }
    slot.shown = None;
    let start = Instant::now();
    let gpu = slot.painter.draw_while(view, exposure, background, size, go_on)?;
    Ok(gpu.map(|gpu| {
        slot.shown = Some((view.clone(), exposure, size));
        [gpu, start.elapsed().as_secs_f64() * 1e3]
    }))
}
