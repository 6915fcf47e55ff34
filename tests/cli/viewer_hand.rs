//! The hand on the picture: what each drag and click moves and what it leaves alone; a window at rest.

use crate::display::wait_for;
use crate::sandbox::Sandbox;
use crate::viewer::Viewer;

const SHIFT: u32 = 0xffe1;
const CONTROL: u32 = 0xffe3;
const F1: u32 = 0xffbe;
/// Wide enough for the scene's own view beside the panel.
const SIZE: [&str; 2] = ["--size", "900x400"];
/// On the sphere, left of the panel.
const FROM: [i16; 2] = [270, 180];

/// The numbers of `option` in `command`, if they are there.
fn triple(command: &str, option: &str) -> Option<[f64; 3]> {
    let value = command.split(&format!("{option} ")).nth(1)?.split(' ').next()?;
    let numbers: Vec<f64> = value.split(',').map(|n| n.parse().unwrap()).collect();
    Some(numbers.try_into().unwrap())
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn length(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Eye and target after `something`, which moves the camera.
fn moved(viewer: &Viewer, something: impl Fn(&Viewer)) -> [[f64; 3]; 2] {
    something(viewer);
    let (picture, command, _) = viewer.save(&[]);
    assert!(picture == viewer.render(&command), "{command}");
    ["--eye", "--target"].map(|option| triple(&command, option).unwrap_or_else(|| panic!("{command}")))
}

#[test]
fn each_drag_moves_what_it_is_for_and_nothing_else() {
    // As small as the scene's own view fits beside the panel and the hemisphere in its corner.
    let viewer = Viewer::open(&["sphere", "--size", "760x330"]);
    let (from, to) = ([235, 165], [275, 192]);
    let reset = |viewer: &Viewer| {
        viewer.display.key('r'.into(), &[]);
        let (_, command, _) = viewer.save(&[]);
        assert!(!command.contains("--eye") && command.contains("--light 35,-50,2"), "{command}");
    };
    let orbit = moved(&viewer, |v| v.display.drag(1, from, to));
    // From here on, differences: an orbit leaves the target, pans move eye and target alike.
    let panned = moved(&viewer, |v| v.display.drag(2, from, to));
    let steps = [0, 1].map(|i| difference(panned[i], orbit[i]));
    assert!(length(steps[0]) > 1e-2 && length(difference(steps[0], steps[1])) < 1e-5, "{steps:?}");
    let shifted = moved(&viewer, |v| v.display.holding(&[SHIFT], || v.display.drag(1, from, to)));
    let steps = [0, 1].map(|i| difference(shifted[i], panned[i]));
    assert!(length(steps[0]) > 1e-2 && length(difference(steps[0], steps[1])) < 1e-5, "{steps:?}");
    let turned = moved(&viewer, |v| v.display.drag(1, to, from));
    assert!(turned[1] == shifted[1] && turned[0] != shifted[0], "an orbit leaves the target where it is");
    let zoomed = moved(&viewer, |v| v.display.click(4, from, 2));
    let distance = |[eye, target]: [[f64; 3]; 2]| length(difference(eye, target));
    assert!(zoomed[1] == turned[1] && distance(zoomed) < 0.95 * distance(turned));
    reset(&viewer);

    for (button, held) in [(3, &[][..]), (1, &[CONTROL][..])] {
        viewer.display.holding(held, || viewer.display.drag(button, from, to));
        let (picture, command, _) = viewer.save(&[]);
        assert!(picture == viewer.render(&command), "{command}");
        assert!(!command.contains("--light 35,-50,2") && !command.contains("--eye"), "{command}");
        reset(&viewer);
    }
    viewer.close();
}

#[test]
fn a_double_click_looks_at_the_point_under_it_and_f1_lists_the_keys() {
    // High enough for the whole list.
    let viewer = Viewer::open(&["sphere", "--size", "900x720"]);
    // On a busy machine two clicks may come too far apart to be one.
    let target = wait_for("a new target", || {
        viewer.display.click(1, FROM, 2);
        triple(&viewer.save(&[]).1, "--target")
    });
    // The sphere's radius is 1, and the point lies on it.
    assert!((length(target) - 1.0).abs() < 0.02, "{target:?}");
    let listed = |key: &str| viewer.words().iter().any(|word| word.text == key);
    viewer.display.key(F1, &[]);
    for key in ["left drag", "middle or Shift + left drag", "double click", "R", "S", "F1", "Esc"] {
        viewer.position_of(key);
    }
    viewer.display.key(F1, &[]);
    wait_for("the end of the list", || (!listed("left drag")).then_some(()));
    viewer.close();
}

#[test]
fn a_window_at_rest_uses_no_processor_and_a_continuous_one_does() {
    let viewer = Viewer::open(&[&["sphere"][..], &SIZE].concat());
    let second = std::time::Duration::from_secs(1);
    let rest = || {
        // Drivers and the display's connection may have something to say after a frame.
        std::thread::sleep(second);
        let before = viewer.ticks();
        std::thread::sleep(second);
        viewer.ticks() - before
    };
    // A window that draws all the time takes what there is of two processors, 200 hundredths.
    wait_for("rest", || (rest() <= 10).then_some(()));
    viewer.display.key(' '.into(), &[]);
    let before = viewer.ticks();
    wait_for("frames", || (viewer.ticks() > before + 60).then_some(()));
    viewer.display.key(' '.into(), &[]);
    wait_for("rest again", || (rest() <= 10).then_some(()));
    viewer.close();
}

/// Milliseconds from the press of F1 until the list of keys is on the screen, or gone if not `listed`. The press itself takes 50.
fn answer(viewer: &Viewer, listed: bool) -> u128 {
    // The list has one colour between its letters; the sphere behind it has many.
    let plain = || {
        let shown = viewer.display.look(viewer.window)?;
        let mut counts = std::collections::HashMap::<[u8; 3], usize>::new();
        (430..470)
            .for_each(|x| (180..220).for_each(|y| *counts.entry(shown.get_pixel(x, y).0).or_default() += 1));
        Some(counts.into_values().max()? > 40 * 40 * 9 / 10)
    };
    let start = std::time::Instant::now();
    viewer.display.key(F1, &[]);
    wait_for("an answer", || (plain()? == listed).then_some(()));
    start.elapsed().as_millis()
}

#[test]
fn no_key_is_lost_while_a_slow_picture_is_drawn() {
    let slow = ["--windows", "1x1", "--terms", "12", "--wavelengths", "120"];
    let viewer = Viewer::open(&[&["sphere"][..], &SIZE, &slow].concat());
    viewer.display.key(' '.into(), &[]);
    let mut times: Vec<u128> = (0..12).map(|press| answer(&viewer, press % 2 == 0)).collect();
    times.sort_unstable();
    // How long it takes depends on the machine: the times are for whoever reads them.
    eprintln!("from F1 to the screen: {times:?} ms");
    viewer.close();
}

#[test]
fn the_mesh_appears_before_its_colours_and_the_title_says_so() {
    // Its first colours take twenty times as long as the first picture of the mesh.
    let files = Sandbox::new();
    let large = files.path("large.gsf").into_os_string().into_string().unwrap();
    let synth = ["surface", "synth", "bumps", "--patch", "200um", "--pixel-size", "50nm", "-o"];
    files.run2(&synth, &[&large]).done();
    let viewer = Viewer::start(&[&["snake"][..], &SIZE, &["--surface", &large]].concat(), &[]);
    viewer.says("preparing");
    let title = || viewer.display.title(viewer.window);
    assert!(title().contains("preparing"), "{}", title());
    wait_for("the mesh on its background", || {
        let shown = viewer.display.look(viewer.window)?;
        let mut colors: Vec<[u8; 3]> = (0..500).map(|x| shown.get_pixel(x, 250).0).collect();
        colors.sort_unstable();
        colors.dedup();
        (title().contains("preparing") && colors.len() > 3).then_some(())
    });
    viewer.close();
}
