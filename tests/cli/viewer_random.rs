//! Random hands on the window: whatever they do, no validation message, no panic, and one line at most.

use crate::viewer::Viewer;

const CONTROL: u32 = 0xffe3;
const ESCAPE: u32 = 0xff1b;
const F1: u32 = 0xffbe;
/// Hands of a test, unless `DIFFRACT_HANDS` says how many.
const HANDS: u32 = 25;

/// Random numbers, the same each time (Marsaglia's xorshift).
struct Chance(u64);

impl Chance {
    /// A number below `end`.
    fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % end
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len() as u64) as usize]
    }

    fn place(&mut self, [width, height]: [u32; 2]) -> [i16; 2] {
        [width, height].map(|side| self.below(side.into()) as i16)
    }
}

/// Does something to the window of `size`, and returns its new size.
fn act(viewer: &Viewer, chance: &mut Chance, size: [u32; 2]) -> [u32; 2] {
    let keys = ['b', 'l', 'i', 'h', 'c', 'x', 'p', 'f', 'r', 's', 'e', 'k', '+', '-'].map(u32::from);
    match chance.below(10) {
        0..=4 => {
            let (from, to) = (chance.place(size), chance.place(size));
            viewer.display.drag(chance.one_of(&[1, 1, 2, 3]), from, to);
        }
        5 => viewer.display.click(chance.one_of(&[1, 4, 5]), chance.place(size), 2),
        6 => {
            let wanted = [200 + chance.below(800) as u32, 150 + chance.below(600) as u32];
            viewer.display.resize(viewer.window, wanted);
            return wanted;
        }
        7 => viewer.display.key(F1, &[]),
        8 => viewer.display.key(chance.one_of(&['z', 'y', 'p'].map(u32::from)), &[CONTROL]),
        _ => viewer.display.key(chance.one_of(&keys), &[]),
    }
    size
}

#[test]
fn random_hands_end_a_window_with_nothing_to_say() {
    let hands = std::env::var("DIFFRACT_HANDS").map_or(HANDS, |count| count.parse().unwrap());
    let mut chance = Chance(20_261_129);
    let mut left = hands;
    while left > 0 {
        let mut size = [700, 500];
        let mut viewer = Viewer::start(&["sphere", "--size", "700x500"], &[]);
        if chance.below(2) == 0 {
            viewer.says("full quality");
        }
        // Closed at random.
        for _ in 0..=chance.below(24) {
            size = act(&viewer, &mut chance, size);
            left = left.saturating_sub(1);
            if left == 0 || viewer.program.try_wait().unwrap().is_some() {
                break;
            }
        }
        if viewer.program.try_wait().unwrap().is_none() {
            if chance.below(2) == 0 {
                viewer.display.close(viewer.window);
            } else {
                // Lists, panes and comparisons close first.
                while viewer.program.try_wait().unwrap().is_none() {
                    viewer.display.key(ESCAPE, &[]);
                }
            }
        }
        assert_eq!(viewer.end().0.done(), "");
    }
}
