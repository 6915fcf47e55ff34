//! An X display of its own (Xvfb) and a hand on it: pointer and keys by XTEST, drops by XDND, looks by `GetImage`.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use x11rb::connection::Connection;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    Atom, ClientMessageEvent, ConfigureWindowAux, ConnectionExt as _, CreateWindowAux, EventMask,
    ImageFormat, InputFocus, PropMode, SelectionNotifyEvent, Window, WindowClass,
};
use x11rb::protocol::xtest::ConnectionExt as _;
use x11rb::rust_connection::RustConnection;
use x11rb::wrapper::ConnectionExt as _;

/// Longer than anything here takes on two cores that others use, too.
const PATIENCE: Duration = Duration::from_secs(300);

const KEY: [u8; 2] = [2, 3];
const BUTTON: [u8; 2] = [4, 5];
const MOTION: u8 = 6;

/// A display that goes with its value.
pub struct Display {
    server: Child,
    pub name: String,
    connection: RustConnection,
    root: Window,
}

/// Asks `look` until it finds something.
#[track_caller]
pub fn wait_for<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let deadline = Instant::now() + PATIENCE;
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(Instant::now() < deadline, "waited in vain for {what}");
        std::thread::sleep(Duration::from_millis(30));
    }
}

impl Display {
    pub fn new() -> Self {
        let mut server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1100x1080x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|e| panic!("Xvfb does not start ({e}): tools/setup.sh test installs it"));
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let name = format!(":{}", number.trim());
        let (connection, screen) = RustConnection::connect(Some(&name)).unwrap();
        let root = connection.setup().roots[screen].root;
        Self { server, name, connection, root }
    }

    /// Ends the display under its windows.
    pub fn vanish(mut self) {
        self.server.kill().unwrap();
    }

    fn atom(&self, name: &str) -> Atom {
        self.connection.intern_atom(false, name.as_bytes()).unwrap().reply().unwrap().atom
    }

    /// The title of `window`.
    pub fn title(&self, window: Window) -> String {
        let (name, text) = (self.atom("_NET_WM_NAME"), self.atom("UTF8_STRING"));
        let reply = self.connection.get_property(false, window, name, text, 0, 1000).unwrap().reply();
        reply.map(|r| String::from_utf8_lossy(&r.value).into_owned()).unwrap_or_default()
    }

    /// The window of the program, with the keyboard's focus.
    pub fn window(&self) -> Window {
        wait_for("a window", || {
            let tree = self.connection.query_tree(self.root).unwrap().reply().unwrap();
            let window = tree.children.into_iter().find(|&w| self.title(w).starts_with("diffract"))?;
            let state = self.connection.get_window_attributes(window).unwrap().reply().ok()?.map_state;
            if state != x11rb::protocol::xproto::MapState::VIEWABLE {
                return None;
            }
            self.connection.set_input_focus(InputFocus::PARENT, window, x11rb::CURRENT_TIME).unwrap();
            self.connection.sync().unwrap();
            Some(window)
        })
    }

    fn fake(&self, kind: u8, detail: u8, at: [i16; 2]) {
        self.connection.xtest_fake_input(kind, detail, 0, self.root, at[0], at[1], 0).unwrap();
        self.connection.sync().unwrap();
        std::thread::sleep(Duration::from_millis(25));
    }

    /// The key that makes `keysym`.
    fn code(&self, keysym: u32) -> u8 {
        let setup = self.connection.setup();
        let first = setup.min_keycode;
        let count = setup.max_keycode - first + 1;
        let map = self.connection.get_keyboard_mapping(first, count).unwrap().reply().unwrap();
        let width = usize::from(map.keysyms_per_keycode);
        let place = map.keysyms.chunks(width).position(|syms| syms.contains(&keysym));
        first + place.unwrap_or_else(|| panic!("no key for {keysym:#x}")) as u8
    }

    /// Presses `keysym` while `held` are down.
    pub fn key(&self, keysym: u32, held: &[u32]) {
        self.holding(held, || KEY.into_iter().for_each(|kind| self.fake(kind, self.code(keysym), [0; 2])));
    }

    /// Does `something` while the keys `held` are down.
    pub fn holding(&self, held: &[u32], something: impl FnOnce()) {
        held.iter().for_each(|&k| self.fake(KEY[0], self.code(k), [0; 2]));
        something();
        held.iter().for_each(|&k| self.fake(KEY[1], self.code(k), [0; 2]));
    }

    /// Drags with `button` from one point to another.
    pub fn drag(&self, button: u8, from: [i16; 2], to: [i16; 2]) {
        self.fake(MOTION, 0, from);
        self.fake(BUTTON[0], button, [0; 2]);
        for step in 1..=6 {
            let at = |i: usize| from[i] + (to[i] - from[i]) * step / 6;
            self.fake(MOTION, 0, [at(0), at(1)]);
        }
        self.fake(BUTTON[1], button, [0; 2]);
    }

    /// Clicks `button` (4 and 5: the wheel) `times` times at a point.
    pub fn click(&self, button: u8, at: [i16; 2], times: u32) {
        self.fake(MOTION, 0, at);
        for _ in 0..times {
            BUTTON.into_iter().for_each(|kind| self.fake(kind, button, [0; 2]));
        }
    }

    /// Destroys `window`, which is of another program.
    pub fn destroy(&self, window: Window) {
        self.connection.destroy_window(window).unwrap();
        self.connection.sync().unwrap();
    }

    pub fn resize(&self, window: Window, size: [u32; 2]) {
        let change = ConfigureWindowAux::new().width(size[0]).height(size[1]);
        self.connection.configure_window(window, &change).unwrap();
        self.connection.sync().unwrap();
    }

    /// Takes `window` away and puts it back.
    pub fn hide_and_show(&self, window: Window) {
        self.connection.unmap_window(window).unwrap();
        self.connection.sync().unwrap();
        std::thread::sleep(Duration::from_millis(300));
        self.connection.map_window(window).unwrap();
        self.connection.sync().unwrap();
        self.window(); // what is hidden has lost the focus
    }

    fn send(&self, window: Window, kind: &str, data: [u32; 5]) {
        let event = ClientMessageEvent::new(32, window, self.atom(kind), data);
        self.connection.send_event(false, window, EventMask::NO_EVENT, event).unwrap();
        self.connection.sync().unwrap();
    }

    /// Asks `window` to close, as a window manager's cross does.
    pub fn close(&self, window: Window) {
        self.send(window, "WM_PROTOCOLS", [self.atom("WM_DELETE_WINDOW"), 0, 0, 0, 0]);
    }

    /// Drops the file `path` on `window`, as a file manager does (XDND 5).
    pub fn drop_file(&self, window: Window, path: &Path) {
        let c = &self.connection;
        let own = c.generate_id().unwrap();
        let aux = CreateWindowAux::new().event_mask(EventMask::PROPERTY_CHANGE);
        c.create_window(0, own, self.root, 0, 0, 1, 1, 0, WindowClass::INPUT_ONLY, 0, &aux).unwrap();
        let (selection, list) = (self.atom("XdndSelection"), self.atom("text/uri-list"));
        c.set_selection_owner(own, selection, x11rb::CURRENT_TIME).unwrap();
        self.send(window, "XdndEnter", [own, 5 << 24, list, 0, 0]);
        self.send(window, "XdndPosition", [own, 0, 60 << 16 | 60, 0, self.atom("XdndActionCopy")]);
        let (status, finished) = (self.atom("XdndStatus"), self.atom("XdndFinished"));
        let mut dropped = false;
        wait_for("the end of a drop", || {
            match c.poll_for_event().unwrap() {
                Some(Event::SelectionRequest(r)) => {
                    let uri = format!("file://{}\r\n", path.display());
                    c.change_property8(PropMode::REPLACE, r.requestor, r.property, list, uri.as_bytes())
                        .unwrap();
                    let answer = SelectionNotifyEvent {
                        response_type: x11rb::protocol::xproto::SELECTION_NOTIFY_EVENT,
                        sequence: 0,
                        time: r.time,
                        requestor: r.requestor,
                        selection: r.selection,
                        target: r.target,
                        property: r.property,
                    };
                    c.send_event(false, r.requestor, EventMask::NO_EVENT, answer).unwrap();
                    c.flush().unwrap();
                }
                Some(Event::ClientMessage(m)) if m.type_ == status && !dropped => {
                    assert_eq!(m.data.as_data32()[1] & 1, 1, "the window takes the file");
                    dropped = true;
                    self.send(window, "XdndDrop", [own, 0, 0, 0, 0]);
                }
                Some(Event::ClientMessage(m)) if m.type_ == finished => return Some(()),
                _ => {}
            }
            None
        });
        c.destroy_window(own).unwrap();
    }

    /// What `window` shows, if it is on the screen.
    pub fn look(&self, window: Window) -> Option<image::RgbImage> {
        let size = self.connection.get_geometry(window).unwrap().reply().ok()?;
        let (width, height) = (size.width, size.height);
        let cookie =
            self.connection.get_image(ImageFormat::Z_PIXMAP, window, 0, 0, width, height, !0).unwrap();
        let data = cookie.reply().ok()?.data;
        let rgb = data.chunks_exact(4).flat_map(|p| [p[2], p[1], p[0]]).collect();
        image::RgbImage::from_raw(width.into(), height.into(), rgb)
    }
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}
