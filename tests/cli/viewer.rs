//! The viewer on a display of its own: what it says, where its buttons are, what it saves.

use crate::display::{Display, wait_for};
use crate::sandbox::{Outcome, SMALL, Sandbox, outcome};
use image::RgbImage;
use std::process::{Child, Stdio};
use x11rb::protocol::xproto::Window;

/// Quick to compute.
const QUICK: [&str; 2] = ["--tolerance", "1e-1"];
const ONE_SAMPLE: [&str; 2] = ["--samples", "1"];

/// A window of the viewer in [`SMALL`]'s sandbox.
pub struct Viewer {
    /// Dropped before the files that it reads.
    _last_state: LastState,
    pub sandbox: Sandbox,
    pub display: Display,
    pub program: Child,
    pub window: Window,
}

/// The state of a window whose test fails, which is printed.
struct LastState {
    words: std::path::PathBuf,
    process: u32,
}

impl Drop for LastState {
    fn drop(&mut self) {
        if std::thread::panicking() {
            let words = std::fs::read_to_string(&self.words);
            let status = std::fs::read_to_string(format!("/proc/{}/stat", self.process));
            eprintln!("the window's words: {words:?}\nits process: {status:?}");
        }
    }
}

/// A text in the window, and where its middle is.
#[derive(Clone, Debug)]
pub struct Word {
    pub text: String,
    pub at: [i16; 2],
}

/// All that can be read in the window whose words are in `sandbox`, the last drawn first.
pub fn words_of(sandbox: &Sandbox) -> Vec<Word> {
    let text = std::fs::read_to_string(sandbox.path("words")).unwrap_or_default();
    let word = |line: &str| {
        let mut parts = line.splitn(3, ' ');
        let mut number = || parts.next()?.parse().ok();
        Some(Word { at: [number()?, number()?], text: parts.next().unwrap_or_default().to_owned() })
    };
    text.lines().filter_map(word).collect()
}

impl Viewer {
    /// The viewer with `arguments`, when it has drawn its picture.
    pub fn open(arguments: &[&str]) -> Self {
        let viewer = Self::start(arguments, &[]);
        viewer.says("full quality");
        viewer
    }

    /// The viewer with `arguments` and environment variables.
    pub fn start(arguments: &[&str], variables: &[(&str, &str)]) -> Self {
        let (sandbox, display) = (Sandbox::with_small_surface(), Display::new());
        let small = match arguments {
            _ if arguments.contains(&"--surface") => &[],
            _ if arguments.contains(&"--coherence") => &SMALL[..6],
            _ => &SMALL[..],
        };
        let quick: &[&str] = if arguments.contains(&"--tolerance") { &[] } else { &QUICK };
        let one: &[&str] = if arguments.contains(&"--samples") { &[] } else { &ONE_SAMPLE };
        let mut command = sandbox.command([&["view"], arguments, small, quick, one].concat());
        command.env("DISPLAY", &display.name).env("DIFFRACT_VALIDATION", "1");
        command.env("DIFFRACT_WORDS", sandbox.path("words"));
        command.envs(variables.iter().copied());
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let program = command.spawn().unwrap();
        let window = display.window();
        let _last_state = LastState { words: sandbox.path("words"), process: program.id() };
        Self { _last_state, sandbox, display, program, window }
    }

    /// Hundredths of a second of processor time that the program has taken so far.
    pub fn ticks(&self) -> u64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.program.id())).unwrap();
        let fields: Vec<&str> = stat.rsplit_once(") ").unwrap().1.split(' ').collect();
        fields[11..13].iter().map(|n| n.parse::<u64>().unwrap()).sum()
    }

    /// All that can be read in the window, the last drawn first.
    pub fn words(&self) -> Vec<Word> {
        words_of(&self.sandbox)
    }

    /// Waits until something in the window contains `part`.
    #[track_caller]
    pub fn says(&self, part: &str) -> String {
        let said = || self.words().into_iter().find(|word| word.text.contains(part)).map(|word| word.text);
        wait_for(part, said)
    }

    /// Waits until the window shows `text` itself; where.
    #[track_caller]
    pub fn position_of(&self, text: &str) -> [i16; 2] {
        wait_for(text, || self.words().into_iter().find(|word| word.text == text)).at
    }

    /// Waits until the middle of `text` can be read from what is on the screen: strokes against their ground.
    #[track_caller]
    pub fn reads(&self, text: &str) {
        let [x, y] = self.position_of(text);
        wait_for(&format!("the look of `{text}`"), || {
            let shown = self.display.look(self.window)?;
            let near = (x - 9..x + 9).flat_map(|x| (y - 4..y + 5).map(move |y| (x, y)));
            let green: Vec<u8> = near.map(|(x, y)| shown.get_pixel(x as u32, y as u32).0[1]).collect();
            let [least, most] = [green.iter().min(), green.iter().max()].map(|level| *level.unwrap());
            (most - least > 90).then_some(())
        });
    }

    /// What stands in the row that is called `label`, from left to right.
    #[track_caller]
    pub fn row(&self, label: &str) -> Vec<Word> {
        let [left, y] = self.position_of(label);
        let mut row: Vec<Word> = self.words();
        row.retain(|word| word.at[0] > left && (word.at[1] - y).abs() <= 6);
        row.sort_by_key(|word| word.at[0]);
        row
    }

    /// Presses what is called `text`.
    #[track_caller]
    pub fn press(&self, text: &str) {
        self.display.click(1, self.position_of(text), 1);
    }

    /// Presses what is called `text` in the row that is called `label`.
    #[track_caller]
    pub fn press_in(&self, label: &str, text: &str) {
        let at = wait_for(text, || self.row(label).into_iter().find(|word| word.text == text)).at;
        self.display.click(1, at, 1);
    }

    /// Drags the word number `index` in the row that is called `label` by `pixels` to the right; what it has become.
    #[track_caller]
    pub fn drag(&self, label: &str, index: usize, pixels: i16) -> String {
        let Word { text: before, at: [x, y] } = self.row(label)[index].clone();
        self.display.drag(1, [x, y], [x + pixels, y]);
        let now = || self.row(label).get(index).map(|word| word.text.clone());
        // The last steps of the drag may still be on their way.
        wait_for("another number", || {
            let first = now().filter(|text| *text != before)?;
            std::thread::sleep(std::time::Duration::from_millis(1500));
            now().filter(|text| *text == first)
        })
    }

    /// Chooses `text` in the list of the row that is called `label`.
    #[track_caller]
    pub fn choose(&self, label: &str, text: &str) {
        self.display.click(1, self.row(label)[0].at, 1);
        self.press(text);
    }

    /// Saves the picture by its key; the picture, and the command in it.
    #[track_caller]
    pub fn save(&self, held: &[u32]) -> (RgbImage, String, String) {
        let free = |n: &u32| !self.sandbox.path(format!("diffract-{n:03}.png")).exists();
        let stem = format!("diffract-{:03}", (1..).find(free).unwrap());
        let name = format!("{stem}.png");
        self.display.key('s'.into(), held);
        wait_for(&name, || self.sandbox.path(&name).is_file().then_some(()));
        let file = std::fs::File::open(self.sandbox.path(&name)).unwrap();
        let reader = png::Decoder::new(std::io::BufReader::new(file)).read_info().unwrap();
        let texts = reader.info().utf8_text.iter().map(|t| t.get_text().unwrap());
        let command =
            texts.filter_map(|t| t.split_once("diffract render ").map(|c| c.1.to_owned())).next().unwrap();
        (image::open(self.sandbox.path(&name)).unwrap().to_rgb8(), command, stem)
    }

    /// The picture that `command` draws.
    #[track_caller]
    pub fn render(&self, command: &str) -> RgbImage {
        let words: Vec<&str> = command.split(' ').collect();
        let output = words.iter().position(|word| *word == "-o").unwrap();
        self.sandbox.run([&["render"], &words[..output], &["-o", "told.png"]].concat()).done();
        image::open(self.sandbox.path("told.png")).unwrap().to_rgb8()
    }

    /// Waits until a saved picture says a value of `option` that a panel shows as `text`, and checks the picture.
    #[track_caller]
    pub fn shows_number(&self, option: &str, text: &str) -> (RgbImage, String) {
        let digits = text.split_once('.').map_or(0, |(_, digits)| digits.len() as i32);
        let shown: f64 = text.replace('−', "-").parse().unwrap(); // as egui writes it
        self.shows_where(text, |command| {
            let value = command.split(&format!("{option} ")).nth(1).unwrap().split(' ').next().unwrap();
            let number = value.trim_start_matches("gaussian:").trim_end_matches("um").parse::<f64>();
            number.is_ok_and(|n| (n - shown).abs() <= 0.51 * 10_f64.powi(-digits))
        })
    }

    /// Waits until a saved picture says `option`, and makes sure that it is the picture of the command in it.
    #[track_caller]
    pub fn shows(&self, option: &str) -> (RgbImage, String) {
        self.shows_where(option, |command| format!(" {command} ").contains(&format!(" {option} ")))
    }

    #[track_caller]
    fn shows_where(&self, what: &str, wanted: impl Fn(&str) -> bool) -> (RgbImage, String) {
        let (picture, command, _) = wait_for(what, || {
            let saved = self.save(&[]);
            wanted(&saved.1).then_some(saved)
        });
        assert!(picture == self.render(&command), "the window shows something else than {command}");
        (picture, command)
    }

    /// Closes the window; the program has to end without a word.
    #[track_caller]
    pub fn close(self) {
        self.display.close(self.window);
        assert_eq!(outcome(self.program).done(), "");
    }

    /// Waits for the end of a program that ends by itself.
    pub fn end(self) -> (Outcome, Sandbox) {
        (outcome(self.program), self.sandbox)
    }
}
