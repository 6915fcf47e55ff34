//! The viewer under a Wayland compositor: what it draws, its keys, its scale, its end.

use crate::display::wait_for;
use crate::sandbox::{SMALL, Sandbox, outcome};
use crate::viewer::words_of;
use crate::wayland::Wayland;
use std::process::Stdio;

#[test]
fn a_window_of_wayland_draws_answers_keys_and_closes_without_a_word() {
    for (scale, closes_by_key) in [(1.0_f64, true), (1.5, false), (2.0, true)] {
        let (sandbox, wayland) = (Sandbox::with_small_surface(), Wayland::new(scale));
        let arguments = ["view", "sphere", "--tolerance", "1e-1", "--samples", "1"];
        let mut command = sandbox.command([&arguments[..], &SMALL].concat());
        command.envs(wayland.variables());
        command.env("DIFFRACT_VALIDATION", "1").env("DIFFRACT_WORDS", sandbox.path("words"));
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let program = command.spawn().unwrap();
        let find = |text: &str| words_of(&sandbox).into_iter().find(|word| word.text == text);
        wait_for("full quality", || find("full quality"));
        // The window fills the output of 1200 × 900 pixels, whatever the scale, and the panel's rows keep their height in points.
        let heading = |text: &str| f64::from(wait_for(text, || find(text)).at[1]);
        let rows = heading("tone mapping") - heading("exposure");
        // The compositor asks for whole scales and makes the window smaller itself where its own is none.
        assert!((rows / scale.ceil() - 24.0).abs() < 3.0, "{rows} pixels at a scale of {scale}");
        wayland.key("F1");
        wait_for("the list of keys", || find("left drag"));
        wayland.key("Escape");
        wait_for("the end of the list", || find("left drag").is_none().then_some(()));
        if closes_by_key {
            wayland.key("Escape")
        } else {
            wayland.close()
        }
        assert_eq!(outcome(program).done(), "", "at a scale of {scale}");
    }
}
