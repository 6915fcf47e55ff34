//! Replay of a log of recorded events: every access must be ordered after those that it conflicts with, and must see their
//! writes.
//!
//! The rules are those of the specification's chapter "Synchronization", for one thread and one queue:
//!
//! - A barrier orders what its source stages did before its destination stages, directly or by a chain of barriers.
//! - A write is available once a barrier has its access in the source scope, or a fence was waited for. It is then
//!   visible to the destination scopes of that barrier and of later ones. A fence makes nothing visible, neither to the
//!   host nor to later work.
//! - A change of layout is a write that happens in its barrier.
//!
//! Passes that share a descriptor set use parts of it. An attachment of a pass counts as unused by its shaders, which
//! must not read it; validation reports those that do.

use ash::vk::{self, AccessFlags2 as A, ImageLayout, PipelineStageFlags2 as S};
use diffract::internals::vk::access::Access;
use diffract::internals::vk::event_log::{RecordedEvent, Resource, Scopes, TexelArea};
use std::collections::HashMap;

/// Replays `events`. Returns one line per finding.
pub fn check(events: &[RecordedEvent]) -> Vec<String> {
    let mut replay = Replay::default();
    for event in events {
        replay.event(event);
    }
    replay.findings
}

/// Past access.
struct Past {
    what: String,
    part: Option<TexelArea>,
    /// Number of submissions before it.
    submission: usize,
    stages: S,
    writes: A,
    is_write: bool,
    /// True if the host has waited for it.
    waited: bool,
    /// True if its writes are available.
    available: bool,
    /// Stages that are ordered after it.
    before: S,
    /// Scopes to which its writes are visible.
    seen: Vec<(S, A)>,
}

impl Past {
    /// Applies a barrier. Returns true if this access and its writes are in the first scope.
    fn pass(&mut self, scopes: &Scopes) -> bool {
        let (source, destination) = (scopes.source, scopes.destination);
        let direct = self.waited || source.0.contains(self.stages);
        if !direct && !self.before.intersects(source.0) {
            return false;
        }
        self.before |= destination.0;
        self.available |= self.waited || direct && source.1.contains(self.writes);
        if self.available {
            self.seen.push(destination);
        }
        self.available
    }
}

#[derive(Default)]
struct State {
    name: String,
    /// `None` if the image is older than the log.
    layout: Option<ImageLayout>,
    past: Vec<Past>,
}

#[derive(Default)]
struct Replay {
    states: HashMap<Resource, State>,
    bound: Vec<(Resource, Access)>,
    /// Attachments of the open pass.
    attachments: Vec<Resource>,
    /// Submissions so far, and the number of the last one of each fence.
    submissions: usize,
    fences: HashMap<vk::Fence, usize>,
    findings: Vec<String>,
}

impl Replay {
    fn event(&mut self, event: &RecordedEvent) {
        match event {
            RecordedEvent::Made(resource, name) => {
                let layout = Some(ImageLayout::UNDEFINED);
                self.states.insert(*resource, State { name: name.clone(), layout, past: Vec::new() });
            }
            RecordedEvent::Bound(accesses) => self.bound.clone_from(accesses),
            RecordedEvent::Work => {
                for (resource, access) in self.bound.clone() {
                    if !self.attachments.contains(&resource) {
                        self.use_of(resource, access, None);
                    }
                }
            }
            RecordedEvent::Used(resource, access, part) => {
                if matches!(access, Access::ColorAttachment | Access::DepthAttachment) {
                    self.attachments.push(*resource);
                }
                self.use_of(*resource, *access, *part);
            }
            RecordedEvent::Ended => self.attachments.clear(),
            RecordedEvent::Barrier(scopes) => {
                for past in self.states.values_mut().flat_map(|state| &mut state.past) {
                    past.pass(scopes);
                }
            }
            RecordedEvent::ImageBarrier(image, scopes, layouts) => {
                self.image_barrier(*image, scopes, *layouts)
            }
            RecordedEvent::Submitted(fence) => {
                self.fences.insert(*fence, self.submissions);
                self.submissions += 1;
            }
            RecordedEvent::Waited(fence) => self.waited(*fence),
        }
    }

    fn waited(&mut self, fence: vk::Fence) {
        // A submission before the log began contains nothing of it.
        let Some(&last) = self.fences.get(&fence) else { return };
        for state in self.states.values_mut() {
            state.past.retain(|past| past.is_write || past.submission > last); // reads are complete
            let done = state.past.iter_mut().filter(|past| past.submission <= last);
            done.for_each(|past| (past.waited, past.available) = (true, true));
        }
    }

    fn image_barrier(&mut self, image: Resource, scopes: &Scopes, [old, new]: [ImageLayout; 2]) {
        let state = self.states.entry(image).or_default();
        let passed: Vec<bool> = state.past.iter_mut().map(|past| past.pass(scopes)).collect();
        if old != ImageLayout::UNDEFINED && state.layout.is_some_and(|layout| layout != old) {
            self.findings
                .push(format!("{}: a barrier from {old:?}, it is in {:?}", state.name, state.layout));
        }
        state.layout = Some(new);
        if old == new {
            return;
        }
        for (past, passed) in state.past.iter().zip(passed) {
            if !passed && !past.waited {
                self.findings
                    .push(format!("{}: its layout changes and nothing waits for {}", state.name, past.what));
            }
        }
        state.past = vec![Past {
            what: format!("the change of its layout to {new:?}"),
            part: None,
            submission: self.submissions,
            stages: scopes.destination.0,
            writes: A::NONE,
            is_write: true,
            waited: false,
            available: true,
            before: scopes.destination.0,
            seen: vec![scopes.destination],
        }];
    }

    fn use_of(&mut self, resource: Resource, access: Access, part: Option<TexelArea>) {
        let (stages, mask, layout) = access.row();
        let state = self.states.entry(resource).or_default();
        let mask = match resource {
            Resource::Buffer(_) => mask,
            Resource::Image(_) => mask & !A::UNIFORM_READ,
        };
        if matches!(resource, Resource::Image(_)) && *state.layout.get_or_insert(layout) != layout {
            self.findings.push(format!("{}: {access:?} while it is in {:?}", state.name, state.layout));
        }
        let (reads, writes) = (mask & READS, mask & !READS);
        let is_write = writes != A::NONE;
        let meets = |past: &&Past| match (&past.part, &part) {
            (Some(one), Some(other)) => meet(one, other),
            _ => true,
        };
        for past in state.past.iter().filter(meets) {
            let ordered = past.waited || past.before.contains(stages);
            let seen = past.seen.iter().any(|s| s.0.contains(stages) && s.1.contains(mask));
            let fine = match (past.is_write, is_write) {
                (false, false) => true,
                (false, true) => ordered,
                // After a fence no execution dependency is needed, and overwritten contents need not be visible.
                (true, _) => seen || reads == A::NONE && past.waited,
            };
            if !fine {
                self.findings
                    .push(format!("{}: no barrier between {} and {access:?}", state.name, past.what));
            }
        }
        if is_write && part.is_none() {
            state.past.clear(); // all of them are ordered before this one
        }
        let what = format!("{access:?}");
        // A repeated read adds nothing, and reads by the host come before later submissions.
        let repeats = |p: &Past| !p.is_write && p.what == what && p.before == S::NONE;
        if is_write || access != Access::HostRead && !state.past.iter().any(repeats) {
            state.past.push(Past {
                what,
                part,
                submission: self.submissions,
                stages,
                writes,
                is_write,
                waited: false,
                available: !is_write,
                before: S::NONE,
                seen: Vec::new(),
            });
        }
    }
}

/// Returns true if the areas overlap.
fn meet(one: &TexelArea, other: &TexelArea) -> bool {
    let overlap = |i: usize| one.from[i] < other.to[i] && other.from[i] < one.to[i];
    one.layer == other.layer && overlap(0) && overlap(1)
}

/// Read accesses.
const READS: A = A::from_raw(
    A::TRANSFER_READ.as_raw()
        | A::COLOR_ATTACHMENT_READ.as_raw()
        | A::DEPTH_STENCIL_ATTACHMENT_READ.as_raw()
        | A::SHADER_READ.as_raw()
        | A::UNIFORM_READ.as_raw()
        | A::VERTEX_ATTRIBUTE_READ.as_raw()
        | A::INDEX_READ.as_raw()
        | A::HOST_READ.as_raw(),
);
