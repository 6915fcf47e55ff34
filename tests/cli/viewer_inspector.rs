//! The inspector in a window: its numbers are those that `eval` gives for the directions that it shows.

use crate::display::wait_for;
use crate::sandbox::SMALL;
use crate::viewer::Viewer;

const ESCAPE: u32 = 0xff1b;
/// On the plate, left of the panel and of the inspector.
const AT: [i16; 2] = [200, 330];

/// The numbers in `text`.
fn numbers(text: &str) -> Vec<f64> {
    let words = text.split(|c: char| !(c.is_ascii_digit() || ".-e".contains(c)));
    words.filter_map(|word| word.parse().ok()).collect()
}

#[test]
fn the_inspector_says_what_eval_says_for_the_directions_that_it_shows() {
    let light = ["--light", "40,180,2", "--environment", "sky"];
    let viewer = Viewer::open(&[&["plate", "--size", "1000x620"][..], &light].concat());
    let shown = || viewer.words().iter().any(|word| word.text == "Inspector");
    viewer.display.click(1, AT, 1);
    assert!(!shown(), "a click alone opens nothing");
    viewer.display.key('i'.into(), &[]);
    viewer.display.click(1, AT, 1);
    viewer.says("held");
    viewer.position_of("BRDF");
    let row = |label: &str| numbers(&viewer.row(label)[0].text);
    let ([theta_i, phi_i], [theta_r, phi_r]) =
        (row("to the light").try_into().unwrap(), row("to the viewer").try_into().unwrap());
    let query = format!("theta_i,phi_i,theta_r,phi_r\n{theta_i},{phi_i},{theta_r},{phi_r}\n");
    viewer.sandbox.write("q.csv", query);
    let eval = [&["eval", "--queries", "q.csv", "--method", "reference"][..], &SMALL].concat();
    let answer = viewer.sandbox.run(eval).done();
    let exact = numbers(answer.lines().nth(1).unwrap());
    let brdf = row("BRDF");
    // Three digits are shown, of directions that are shown to a hundredth of a degree.
    let apart = brdf.iter().zip(&exact[4..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(brdf.len() == 3 && apart < 0.01 * exact[5], "{brdf:?} {exact:?}");
    let (radiance, reference) = (row("radiance"), row("reference"));
    assert!(radiance.len() == 3 && reference.len() == 3);
    let error = row("error")[0];
    // The tolerance is 10 %.
    assert!(error < 20.0, "{error} %: {radiance:?} {reference:?}");
    viewer.display.key(ESCAPE, &[]);
    wait_for("the end of the inspector", || (!shown()).then_some(()));
    viewer.close();
}
