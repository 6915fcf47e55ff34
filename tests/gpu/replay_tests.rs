//! Recordings as made by the passes, complete and with a part removed.

use crate::replay::check;
use Access::{
    ColorAttachment, ComputeWrite, DepthAttachment, HostRead, Nothing, ShaderRead, TransferRead,
    TransferWrite, VertexRead,
};
use ash::vk::{self, AccessFlags2 as A, PipelineStageFlags2 as S};
use diffract::internals::vk::access::Access;
use diffract::internals::vk::event_log::{RecordedEvent, Resource, TexelArea};

const BUFFER: Resource = Resource::Buffer(1);
const HOST: Resource = Resource::Buffer(2);
const IMAGE: Resource = Resource::Image(1);

fn made(resource: Resource) -> RecordedEvent {
    RecordedEvent::Made(resource, format!("{resource:?}"))
}

fn used(resource: Resource, access: Access) -> RecordedEvent {
    RecordedEvent::Used(resource, access, None)
}

const FENCE: vk::Fence = vk::Fence::null();

fn memory(from: Access, to: Access) -> RecordedEvent {
    RecordedEvent::barrier(&from.memory_barrier(to))
}

fn image(from: Access, to: Access) -> RecordedEvent {
    let barrier = from.image_barrier(to, vk::Image::null(), vk::ImageSubresourceRange::default());
    RecordedEvent::image_barrier(IMAGE, &barrier)
}

fn rows(from: u32, to: u32) -> Option<TexelArea> {
    Some(TexelArea { layer: [0; 2], from: [0, from], to: [8, to] })
}

/// Returns an evaluation and the host's reading of the result, twice.
fn evaluation() -> Vec<RecordedEvent> {
    let once = || {
        [
            RecordedEvent::Bound(vec![(HOST, ShaderRead), (BUFFER, ComputeWrite)]),
            RecordedEvent::Work,
            memory(ComputeWrite, HostRead),
            RecordedEvent::Submitted(FENCE),
            RecordedEvent::Waited(FENCE),
            used(BUFFER, HostRead),
        ]
    };
    [made(BUFFER), made(HOST)].into_iter().chain(once()).chain(once()).collect()
}

/// Returns a buffer that is filled in one submission and drawn from in the next.
fn upload() -> Vec<RecordedEvent> {
    vec![
        made(BUFFER),
        memory(ShaderRead, TransferWrite),
        used(BUFFER, TransferWrite),
        memory(TransferWrite, ShaderRead),
        memory(TransferWrite, VertexRead),
        RecordedEvent::Submitted(FENCE),
        RecordedEvent::Waited(FENCE),
        used(BUFFER, VertexRead),
        RecordedEvent::Bound(vec![(BUFFER, ShaderRead)]),
        RecordedEvent::Work,
    ]
}

/// Returns a picture that is drawn, sampled, drawn again and read back.
fn picture() -> Vec<RecordedEvent> {
    vec![
        made(IMAGE),
        made(HOST),
        image(Nothing, ColorAttachment),
        used(IMAGE, ColorAttachment),
        RecordedEvent::Ended,
        image(ColorAttachment, ShaderRead),
        RecordedEvent::Bound(vec![(IMAGE, ShaderRead)]),
        RecordedEvent::Work,
        memory(ShaderRead, ColorAttachment),
        image(Nothing, ColorAttachment),
        RecordedEvent::Used(IMAGE, ColorAttachment, rows(0, 4)),
        RecordedEvent::Used(IMAGE, ColorAttachment, rows(4, 6)),
        image(ColorAttachment, TransferRead),
        used(IMAGE, TransferRead),
        used(HOST, TransferWrite),
        memory(TransferWrite, HostRead),
        RecordedEvent::Submitted(FENCE),
        RecordedEvent::Waited(FENCE),
        used(HOST, HostRead),
    ]
}

#[test]
fn whole_recordings_pass() {
    for events in [evaluation(), upload(), picture()] {
        assert_eq!(check(&events), [""; 0], "{events:#?}");
    }
}

#[test]
fn every_barrier_that_is_left_out_is_noticed() {
    for events in [evaluation(), upload(), picture()] {
        let is_barrier =
            |e: &RecordedEvent| matches!(e, RecordedEvent::Barrier(_) | RecordedEvent::ImageBarrier(..));
        for i in (0..events.len()).filter(|&i| is_barrier(&events[i])) {
            // Nothing reads the buffer before the upload; the barrier in front of it serves uploads over earlier ones.
            if i == 1 && matches!(events[i + 1], RecordedEvent::Used(BUFFER, TransferWrite, _)) {
                continue;
            }
            let mut lacking = events.clone();
            let barrier = lacking.remove(i);
            assert!(!check(&lacking).is_empty(), "without {barrier:?}");
        }
    }
}

/// Index of a barrier event, and the parts of it that something depends on: 0 source stages, 1 source accesses, 2
/// destination stages, 3 destination accesses.
type Needed = (usize, &'static [usize]);

#[test]
fn every_scope_that_is_left_out_is_noticed() {
    let recordings: [(Vec<RecordedEvent>, &[Needed]); 3] = [
        (evaluation(), &[(4, &[0, 1, 2, 3])]),
        // The first barrier to readers makes the write available to the second, too.
        (upload(), &[(3, &[0, 1, 2, 3]), (4, &[0, 2, 3])]),
        // A new image has no past; after a read only an execution dependency is needed.
        (
            picture(),
            &[
                (2, &[2, 3]),
                (5, &[0, 1, 2, 3]),
                (8, &[0, 2]),
                (9, &[0, 2, 3]),
                (12, &[0, 1, 2, 3]),
                (15, &[0, 1, 2, 3]),
            ],
        ),
    ];
    for (events, needed) in recordings {
        for &(i, parts) in needed {
            for part in parts {
                let mut lacking = events.clone();
                let (RecordedEvent::Barrier(scopes) | RecordedEvent::ImageBarrier(_, scopes, _)) =
                    &mut lacking[i]
                else {
                    panic!("{:?} is no barrier", events[i]);
                };
                match part {
                    0 => scopes.source.0 = S::NONE,
                    1 => scopes.source.1 = A::NONE,
                    2 => scopes.destination.0 = S::NONE,
                    _ => scopes.destination.1 = A::NONE,
                }
                assert!(!check(&lacking).is_empty(), "{:?} without part {part}", events[i]);
            }
        }
    }
}

#[test]
fn what_is_wrong_is_named() {
    let mut events = evaluation();
    events.remove(4);
    assert_eq!(check(&events), ["Buffer(1): no barrier between ComputeWrite and HostRead"]);
    let mut events = upload();
    events.remove(4);
    assert_eq!(check(&events), ["Buffer(1): no barrier between TransferWrite and VertexRead"]);
    let mut events = picture();
    events.remove(8);
    let found = check(&events);
    assert!(
        found.contains(&"Image(1): its layout changes and nothing waits for ShaderRead".into()),
        "{found:?}"
    );
}

#[test]
fn a_layout_other_than_the_present_one_is_noticed() {
    let drawn = [made(IMAGE), image(Nothing, ColorAttachment), used(IMAGE, ColorAttachment)];
    let with = |more: &[RecordedEvent]| check(&[drawn.as_slice(), more].concat());
    assert_eq!(with(&[]), [""; 0]);
    assert!(with(&[image(ShaderRead, TransferRead)])[0].contains("it is in"));
    assert!(
        with(&[memory(ColorAttachment, ShaderRead), used(IMAGE, ShaderRead)])[0].contains("while it is in")
    );
}

#[test]
fn parts_that_meet_need_a_barrier_and_parts_that_do_not_need_none() {
    let begin = [made(IMAGE), image(Nothing, DepthAttachment)];
    let draw = |part| RecordedEvent::Used(IMAGE, DepthAttachment, part);
    let with = |more: &[RecordedEvent]| check(&[begin.as_slice(), more].concat()).len();
    assert_eq!(with(&[draw(rows(0, 4)), draw(rows(4, 8))]), 0);
    assert_eq!(with(&[draw(rows(0, 4)), draw(rows(3, 8))]), 1);
    assert_eq!(with(&[draw(rows(0, 4)), draw(None)]), 1);
    let between = image(DepthAttachment, DepthAttachment);
    assert_eq!(with(&[draw(rows(0, 4)), between, draw(None)]), 0);
}

#[test]
fn a_read_is_waited_for_before_the_next_write() {
    let begin = upload();
    let write = used(BUFFER, TransferWrite);
    let with = |more: &[RecordedEvent]| {
        check(&[begin.as_slice(), more, std::slice::from_ref(&write)].concat()).len()
    };
    assert!(with(&[]) > 0);
    assert!(with(&[memory(ShaderRead, TransferWrite)]) > 0, "vertices are read, too");
    assert_eq!(with(&[memory(ShaderRead, TransferWrite), memory(VertexRead, TransferWrite)]), 0);
    assert_eq!(with(&[RecordedEvent::Submitted(FENCE), RecordedEvent::Waited(FENCE)]), 0);
}

#[test]
fn a_fence_waits_for_its_submission_and_earlier_ones_but_not_for_later_ones() {
    use ash::vk::Handle;
    let [one, other] = [1, 2].map(vk::Fence::from_raw);
    let read = || [RecordedEvent::Bound(vec![(BUFFER, ShaderRead)]), RecordedEvent::Work];
    let events = |waited: vk::Fence| {
        let mut events = vec![made(BUFFER)];
        events.extend([RecordedEvent::Submitted(one)]);
        events.extend(read());
        events.extend([RecordedEvent::Submitted(other), RecordedEvent::Waited(waited)]);
        events.push(used(BUFFER, TransferWrite));
        events
    };
    assert_eq!(check(&events(other)).len(), 0);
    assert_eq!(check(&events(one)).len(), 1, "the read is in the later submission");
}
