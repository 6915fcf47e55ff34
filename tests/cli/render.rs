//! Pictures in files.

use crate::sandbox::{SMALL, Sandbox};
use std::fs;

/// A picture of the small surface that is quick to make.
fn render(sandbox: &Sandbox, scene: &str, output: &str, more: &[&str]) {
    let mut arguments = vec!["render", scene, "-o", output];
    let given = |option: &str| more.contains(&option);
    let quick = [&["--size", "64x48"][..], &["--tolerance", "1e-1"], &["--samples", "1"]];
    for pair in SMALL.chunks(2).chain(quick) {
        if !given(pair[0]) {
            arguments.extend(pair);
        }
    }
    let silent = sandbox.run2(&arguments, more).done();
    assert_eq!(silent, "");
}

/// Width, height and RGBA of an EXR file of 32-bit floats.
pub fn exr(sandbox: &Sandbox, name: &str) -> (u32, u32, Vec<[f32; 4]>) {
    match image::open(sandbox.path(name)).unwrap() {
        image::DynamicImage::ImageRgba32F(p) => (p.width(), p.height(), p.pixels().map(|p| p.0).collect()),
        other => panic!("{name} is {:?}", other.color()),
    }
}

fn png(sandbox: &Sandbox, name: &str) -> image::RgbaImage {
    match image::open(sandbox.path(name)).unwrap() {
        image::DynamicImage::ImageRgba8(p) => p,
        other => panic!("{name} is {:?}", other.color()),
    }
}

/// ‖a − b‖/‖b‖ over the colours of all pixels.
pub fn deviation(a: &[[f32; 4]], b: &[[f32; 4]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let square = |x: f32| f64::from(x).powi(2);
    let pairs = || a.iter().zip(b).flat_map(|(a, b)| (0..3).map(move |c| (a[c], b[c])));
    (pairs().map(|(a, b)| square(a - b)).sum::<f64>() / pairs().map(|(_, b)| square(b)).sum::<f64>()).sqrt()
}

#[test]
fn a_png_and_an_exr_of_the_size_appear_and_nothing_else() {
    let sandbox = Sandbox::with_small_surface();
    for scene in ["plate", "sphere"] {
        let mut expected = sandbox.content().len();
        for output in [format!("{scene}.png"), format!("{scene}.exr")] {
            render(&sandbox, scene, &output, &[]);
            expected += 1;
            assert_eq!(sandbox.content().len(), expected, "{output}");
        }
        assert_eq!(png(&sandbox, &format!("{scene}.png")).dimensions(), (64, 48));
        let (width, height, _) = exr(&sandbox, &format!("{scene}.exr"));
        assert_eq!((width, height), (64, 48));
    }
    render(&sandbox, "sphere", "narrow.PNG", &["--size", "7x23"]);
    assert_eq!(png(&sandbox, "narrow.PNG").dimensions(), (7, 23));
    render(&sandbox, "sphere", "point.exr", &["--size", "1x1"]);
}

#[test]
fn an_exr_is_signed_and_covered_exactly_where_its_alpha_is_1() {
    let sandbox = Sandbox::with_small_surface();
    // Orders of one window are sharp, and their colours lie outside sRGB.
    let colourful = ["--surface", "blaze", "--pixel-size", "90nm", "--height", "250nm", "--windows", "1x1"];
    render(&sandbox, "sphere", "s.exr", &colourful);
    render(&sandbox, "sphere", "s.png", &colourful);
    let (width, height, pixels) = exr(&sandbox, "s.exr");
    assert!(pixels.iter().flatten().all(|x| x.is_finite()));
    assert!(pixels.iter().any(|p| p[..3].iter().any(|&x| x < 0.0)), "no colour lies outside sRGB");
    let alpha = |x: u32, y: u32| pixels[(y * width + x) as usize][3];
    assert!(pixels.iter().all(|p| p[3] == 1.0 || *p == [0.0; 4]));
    assert_eq!(alpha(width / 2, height / 2), 1.0);
    assert!([(0, 0), (width - 1, 0), (0, height - 1)].iter().all(|&(x, y)| alpha(x, y) == 0.0));
    // A convex thing covers one run of each row, and the PNG shows one background everywhere else.
    let shown = png(&sandbox, "s.png");
    for y in 0..height {
        let changes = (1..width).filter(|&x| alpha(x, y) != alpha(x - 1, y)).count();
        assert!(changes <= 2, "row {y} is torn");
        for x in (0..width).filter(|&x| alpha(x, y) == 0.0) {
            assert_eq!(shown.get_pixel(x, y), shown.get_pixel(0, 0), "pixel {x}, {y}");
        }
    }
}

#[test]
fn more_samples_smooth_the_alpha_of_both_formats_and_a_seed_is_one_picture() {
    let sandbox = Sandbox::with_small_surface();
    let draw = |name: &str, more: &[&str]| {
        render(&sandbox, "sphere", &format!("{name}.exr"), more);
        exr(&sandbox, &format!("{name}.exr")).2
    };
    let draw_codes = |name: &str, more: &[&str]| {
        render(&sandbox, "sphere", &format!("{name}.png"), more);
        png(&sandbox, &format!("{name}.png"))
    };
    let one = draw("one", &[]);
    let many = ["--samples", "16"];
    let (radiance, shown) = (draw("many", &many), draw_codes("many", &many));
    let inside = |p: &&[f32; 4]| p[3] > 0.0 && p[3] < 1.0;
    assert_eq!(one.iter().filter(inside).count(), 0);
    let edge = radiance.iter().filter(inside).count();
    assert!(edge > 50, "only {edge} pixels lie on the edge");
    for (pixel, code) in radiance.iter().zip(shown.pixels()) {
        assert_eq!(code[3], (pixel[3] * 255.0).round() as u8);
        assert!((0.0..=1.0 + 1e-6).contains(&pixel[3]), "{}", pixel[3]);
        assert!(pixel[3] > 0.0 || *pixel == [0.0; 4]);
    }
    // The same light, spread a little: the whole is as bright, and no pixel's coverage is far from that of its centre's surroundings.
    let sum = |p: &[[f32; 4]]| -> f64 { p.iter().map(|p| f64::from(p[3])).sum() };
    assert!((sum(&radiance) / sum(&one) - 1.0).abs() < 1e-2);
    assert!(draw("again", &many) == radiance && draw_codes("again", &many) == shown);
    let seeded = draw("seeded", &["--samples", "16", "--seed", "2"]);
    assert!(seeded != radiance, "the seed does not reach the samples");
    // The reference looks at the same places.
    let tight = ["--samples", "6", "--tolerance", "1e-2", "--size", "32x24", "--windows", "1x1"];
    let fast = draw("fast", &tight);
    let exact = draw("exact", &[&tight[..], &["--method", "reference"]].concat());
    assert!(
        fast.iter().zip(&exact).all(|(a, b)| (a[3] - b[3]).abs() < 1e-6) && fast.iter().any(|p| inside(&p))
    );
    // At the rim few samples of the sky differ by more: within it all light is compared.
    let inner = |picture: &[[f32; 4]]| -> Vec<[f32; 4]> {
        picture.iter().zip(&exact).filter(|(_, e)| e[3] == 1.0).map(|(p, _)| *p).collect()
    };
    let (fast, exact) = (inner(&fast), inner(&exact));
    assert!(exact.len() > 100 && deviation(&fast, &exact) <= 1e-2, "{}", deviation(&fast, &exact));
    // Without a sky the rim is compared too.
    let lit = [&tight[..], &["--light", "35,-50,2"]].concat();
    let fast = draw("lit", &lit);
    let exact = draw("exactly-lit", &[&lit[..], &["--method", "reference"]].concat());
    assert!(deviation(&fast, &exact) <= 1e-2, "{}", deviation(&fast, &exact));
}

#[test]
fn coverage_of_coherence_areas_is_told_on_request_and_where_it_is_little() {
    let sandbox = Sandbox::with_small_surface();
    let square =
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    sandbox.write("square.obj", square);
    let scene = |scale: &str| {
        format!(
            "mesh = \"square.obj\"\nup = \"z\"\nsurface = \"bumps\"\nscale = \"{scale}\"\nlights = [\"40,180,2\"]\n[camera]\n\
             eye = [0, 0, 40]\ntarget = [0, 0, 0]\nfield_of_view = \"1deg\"\n"
        )
    };
    sandbox.write("large.toml", scene("1 m"));
    sandbox.write("small.toml", scene("100 um"));
    let run = |scene: &str, more: &[&str]| {
        let words = ["render", scene, "-o", "a.exr", "--coherence", "gaussian:4um", "--tolerance", "1e-1"];
        sandbox.run2(&words, &[&["--size", "16x12", "--samples", "1"], more].concat())
    };
    assert_eq!(run("large.toml", &[]).done(), "");
    let told = run("large.toml", &["-v"]);
    // A pixel is 40·2·tan(½°)/12 m wide.
    let areas = (80.0 * 0.5f64.to_radians().tan() / 12.0 / 4e-6).powi(2);
    let said: f64 =
        told.stderr.split_once("(median), ").unwrap().1.split(' ').next().unwrap().parse().unwrap();
    assert!((said / areas - 1.0).abs() < 1e-2, "{said} for {areas}: {}", told.stderr);
    let warned = run("small.toml", &[]);
    assert!(warned.code == Some(0) && warned.stderr.lines().count() == 1, "{warned:?}");
    assert!(
        warned.stderr.contains("not what is seen") && warned.stderr.contains("2.1 coherence areas"),
        "{warned:?}"
    );
    assert_eq!(run("small.toml", &["-q"]).done(), "");
    run("small.toml", &["-q", "-v"]).refused(2);
    // The filter of several samples averages over the areas of neighbouring pixels, too.
    sandbox.write("middle.toml", scene("170 um"));
    assert!(run("middle.toml", &[]).stderr.contains("not what is seen"));
    let words =
        ["render", "middle.toml", "-o", "a.exr", "--coherence", "gaussian:4um", "--tolerance", "1e-1"];
    sandbox.run2(&words, &["--size", "16x12", "--samples", "2"]).done();
}

#[test]
fn the_same_command_writes_the_same_bytes_and_the_second_time_from_the_cache() {
    let sandbox = Sandbox::with_small_surface();
    let kept = || -> Vec<_> {
        let files = fs::read_dir(sandbox.cache()).unwrap().map(Result::unwrap);
        files.map(|f| (f.file_name(), f.metadata().unwrap().modified().unwrap())).collect()
    };
    render(&sandbox, "sphere", "a.png", &[]);
    let first = kept();
    assert_eq!(first.len(), 2, "the colour table and the limit of energy: {first:?}");
    render(&sandbox, "sphere", "b.png", &[]);
    render(&sandbox, "sphere", "a.exr", &[]);
    render(&sandbox, "sphere", "b.exr", &[]);
    assert_eq!(kept(), first);
    assert_eq!(sandbox.read("a.png"), sandbox.read("b.png"));
    assert_eq!(sandbox.read("a.exr"), sandbox.read("b.exr"));
}

#[test]
fn a_picture_that_fails_keeps_the_former_file() {
    let sandbox = Sandbox::with_small_surface();
    render(&sandbox, "plate", "kept.png", &[]);
    let before = sandbox.content();
    for more in [&["--surface", "nothing.png"][..], &["--height", "40um"], &["--device", "7"]] {
        let mut arguments = vec!["render", "plate", "-o", "kept.png", "--pixel-size", "90nm"];
        let rest: Vec<_> = [["--surface", "small.png"], ["--height", "100nm"]].concat();
        arguments.extend(rest.chunks(2).filter(|pair| !more.contains(&pair[0])).flatten());
        sandbox.run2(&arguments, more).without_questions().refused_somehow(&format!("{more:?}"));
        assert_eq!(sandbox.content(), before, "{more:?}");
    }
    render(&sandbox, "sphere", "kept.png", &[]);
    assert_ne!(sandbox.content(), before, "a picture that succeeds replaces it");
}

#[test]
fn spectral_agrees_with_the_reference_within_the_tolerance_and_another_light_does_not() {
    let sandbox = Sandbox::with_small_surface();
    let of = |name: &str, more: &[&str]| {
        render(&sandbox, "plate", name, &[&["--size", "12x8", "--windows", "1x1"], more].concat());
        exr(&sandbox, name).2
    };
    let reference = of("r.exr", &["--method", "reference"]);
    let covered = reference.iter().filter(|p| p[3] == 1.0).count();
    assert!(covered > 20, "{covered}");
    for tolerance in ["1e-1", "1e-2"] {
        let error = deviation(&of("s.exr", &["--tolerance", tolerance]), &reference);
        assert!(error <= tolerance.parse().unwrap(), "{tolerance}: {error}");
    }
    let other = of("o.exr", &["--tolerance", "1e-2", "--light", "42,180,2"]);
    assert!(deviation(&other, &reference) > 1e-1);
}

#[test]
fn options_change_the_picture() {
    let sandbox = Sandbox::with_small_surface();
    let one = ["--windows", "1x1"];
    render(&sandbox, "sphere", "plain.exr", &one);
    let plain = exr(&sandbox, "plain.exr").2;
    sandbox.write("red.csv", "wavelength,power\n380,0\n600,0\n610,1\n780,1\n");
    for more in [
        &["--light", "20,100"][..],
        &["--light", "45,-40,2", "--light", "80,0,1"],
        &["--light", "45,-40,4"],
        &["--ior", "1.8"],
        &["--material", "gold"],
        &["--material", "glass"],
        &["--film", "120nm:1.7"],
        &["--environment", "none"],
        &["--environment", "studio"],
        &["--environment-exposure", "1"],
        &["--illuminant", "a"],
        &["--illuminant", "E"],
        &["--illuminant", "red.csv"],
        &["--coherence", "gaussian:5um"],
        &["--pixel-size", "80nm"],
        &["--height", "200nm"],
        &["--tolerance", "1e-3"],
        &["--terms", "3"],
        &["--wavelengths", "7"],
        &["--surface", "blaze"],
    ] {
        render(&sandbox, "sphere", "other.exr", &[&one[..], more].concat());
        let change = deviation(&exr(&sandbox, "other.exr").2, &plain);
        assert!(change > 1e-6, "{more:?} changes nothing");
    }
    for same in [
        &["--light", "35,-50,2", "--environment", "sky", "--environment-exposure", "-0.5"][..],
        &["--environment", "sky", "--environment-exposure", "-0.5"],
        &["--illuminant", "d65"],
        &["--ior", "1.5"],
        &["--level", "none"],
    ] {
        render(&sandbox, "sphere", "other.exr", &[&one[..], same].concat());
        // The files differ in the command that they carry.
        assert!(exr(&sandbox, "other.exr").2 == plain, "{same:?} is not the default");
    }
    // A light that is named is all that there is, and a convex mesh casts no shadow of it on itself.
    render(&sandbox, "sphere", "light.exr", &["--light", "35,-50,2"]);
    let light = exr(&sandbox, "light.exr").2;
    for same in [&["--environment", "none"][..], &["--shadows", "off"]] {
        render(&sandbox, "sphere", "other.exr", &[&["--light", "35,-50,2"], same].concat());
        assert!(exr(&sandbox, "other.exr").2 == light, "{same:?} changes what a light shows");
    }
    // The mean over all windows is the default, by a table.
    render(&sandbox, "sphere", "mean.exr", &[]);
    let mean = exr(&sandbox, "mean.exr").2;
    render(&sandbox, "sphere", "other.exr", &["--windows", "all", "--method", "table"]);
    assert!(exr(&sandbox, "other.exr").2 == mean);
    let [copies, alike] = ["copies", "alike"].map(|beyond| {
        render(&sandbox, "sphere", "other.exr", &["--beyond", beyond]);
        exr(&sandbox, "other.exr").2
    });
    assert!(deviation(&mean, &plain) > 1e-2 && deviation(&copies, &alike) > 1e-3);
    assert!(mean == copies || mean == alike);
}

#[test]
fn a_snake_casts_shadows_and_a_sky_lights_them() {
    let sandbox = Sandbox::with_small_surface();
    let brightness = |more: &[&str]| -> f64 {
        render(&sandbox, "snake", "out.exr", &[&["--tolerance", "1e-1", "--samples", "4"], more].concat());
        exr(&sandbox, "out.exr").2.iter().map(|p| f64::from(p[1])).sum()
    };
    let without = brightness(&["--environment", "none", "--shadows", "off"]);
    let with = brightness(&["--environment", "none"]);
    let below_a_sky = brightness(&[]);
    let brighter = brightness(&["--environment-exposure", "2"]);
    assert!(with < 0.95 * without && with > 0.2 * without, "{with} of {without}");
    assert!(
        below_a_sky > 1.05 * with && brighter - with > 3.0 * (below_a_sky - with),
        "{below_a_sky}, {brighter}"
    );
    let refused = |more: &[&str], said: &str| {
        let line = sandbox.run2(&["render", "snake", "-o", "no.png"], more).refused(2);
        assert!(line.contains(said), "{line}");
    };
    refused(&["--environment", "none", "--rotate-environment", "90deg"], "the scene has none");
    refused(&["--light", "1,0", "--rotate-environment", "90deg"], "the scene has none");
}

#[test]
fn a_lamp_lights_what_is_near_it_and_surroundings_stand_behind_the_mesh() {
    let sandbox = Sandbox::with_small_surface();
    let halves = |lamp: &str| -> [f64; 2] {
        let more = ["--tolerance", "1e-1", "--samples", "4", "--base-color", "1,1,1", "--light", lamp];
        render(&sandbox, "plate", "out.exr", &more);
        let (width, _, pixels) = exr(&sandbox, "out.exr");
        let half = |right: bool| {
            let of = |(i, p): (usize, &[f32; 4])| {
                f64::from(p[1]) * f64::from(u8::from((2 * (i % width as usize) >= width as usize) == right))
            };
            pixels.iter().enumerate().map(of).sum::<f64>()
        };
        [half(false), half(true)]
    };
    let [left, right] = halves("sphere:0.1:0,0.6,0.2");
    assert!(right > 2.0 * left && left > 0.0, "{left}, {right}");
    let [left, right] = halves("rectangle:0.3x0.1:0,-0.6,0.2:0,0,0");
    assert!(left > 2.0 * right && right > 0.0, "{left}, {right}");
    let ([weak, _], [strong, _]) = (halves("sphere:0.1:0,0,1,10"), halves("sphere:0.1:0,0,1,20"));
    assert!((strong / weak - 2.0).abs() < 1e-3, "{weak}, {strong}");
    let refused = |more: &[&str], said: &str| {
        let line = sandbox.run2(&["render", "plate", "-o", "no.png"], more).refused(2);
        assert!(line.contains(said), "{line}");
    };
    refused(&["--light", "sphere:0:1,1,1"], "size '0'");
    refused(&["--light", "rectangle:1x1:1,1"], "write rectangle:WIDTHxHEIGHT");
    refused(&["--light", "sphere:1:0,0,1,-3W"], "strength '-3W'");
    // Any number of lights: five as bright as a fifth each are as bright as one.
    let brightness = |lights: &[&str]| {
        render(&sandbox, "plate", "out.exr", &[&["--tolerance", "1e-1"], lights].concat());
        exr(&sandbox, "out.exr").2.iter().map(|p| f64::from(p[1])).sum::<f64>()
    };
    let (five, one) = (["--light", "20,0,0.2"].repeat(5), ["--light", "20,0,1"]);
    let ratio = brightness(&five) / brightness(&one);
    // 32-bit sums round to 1e-7.
    assert!((ratio - 1.0).abs() < 1e-4, "{ratio}");
    // A background that is asked for is opaque, so that every program shows it.
    let opaque = |background: &str| {
        let more =
            ["--tolerance", "1e-1", "--samples", "2", "--environment", "studio", "--background", background];
        render(&sandbox, "sphere", "around.png", &more);
        let shown = image::open(sandbox.path("around.png")).unwrap().into_rgba8();
        shown.pixels().filter(|pixel| pixel.0[3] == 255).count() == shown.pixels().len()
    };
    assert!(opaque("surroundings") && opaque("0.1,0.1,0.1"));
    refused(&["--light", "1,0", "--background", "surroundings"], "no surroundings to be the background");
    refused(&["--background", "blue"], "no background");
}

#[test]
fn a_light_has_a_spectrum_of_its_own_by_name_or_in_a_file() {
    let sandbox = Sandbox::with_small_surface();
    let draw = |more: &[&str]| {
        render(&sandbox, "sphere", "out.exr", more);
        exr(&sandbox, "out.exr").2
    };
    // Alone it is what the illuminant of that name is.
    let tungsten = draw(&["--light", "40,30,2@a"]);
    assert!(tungsten == draw(&["--light", "40,30,2", "--illuminant", "a"]));
    assert!(tungsten != draw(&["--light", "40,30,2"]));
    // Red light has no blue.
    sandbox.write("red lamp.csv", "600,0\n605,1\n700,1\n");
    sandbox.write(
        "lit.toml",
        "mesh = \"sphere\"\nsurface = \"small.png\"\nheight = \"0.2um\"\npixel_size = \"0.1um\"\nlights = [\"40,30,2@red lamp.csv\"]\n\
         base_color = [0.5, 0.5, 0.5]\n[camera]\neye = [0.0, -4.0, 2.0]\ntarget = [0.0, 0.0, 0.0]\nfield_of_view = \"35deg\"\n",
    );
    render(&sandbox, "lit.toml", "red.exr", &["--tolerance", "1e-1"]);
    let mean = |c: usize| exr(&sandbox, "red.exr").2.iter().map(|p| p[c]).sum::<f32>();
    let [red, green, blue] = [0, 1, 2].map(mean);
    assert!(red > 0.0 && green < 0.1 * red && blue < 0.1 * red, "{red}, {green}, {blue}");
    // Beside others it adds what it gives alone.
    let [one, other, both] = [
        draw(&["--light", "40,30@red lamp.csv"]),
        draw(&["--light", "60,-90,2@led"]),
        draw(&["--light", "40,30@red lamp.csv", "--light", "60,-90,2@led"]),
    ];
    let sum: Vec<[f32; 4]> =
        one.iter().zip(&other).map(|(a, b)| [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3]]).collect();
    let error = deviation(&both, &sum);
    assert!(error < 1e-4, "{error}");
    for (light, code, said) in [
        ("40,30@", 2, "names no spectrum"),
        ("40,30@nowhere.csv", 1, "nowhere.csv: there is no such file"),
        ("40@a", 2, "is not a light"),
    ] {
        let line = sandbox.run(["render", "plate", "-o", "no.png", "--light", light]).refused(code);
        assert!(line.contains(said), "{line}");
    }
    let over_input =
        sandbox.run(["render", "plate", "-o", "red lamp.csv", "--light", "40,30@red lamp.csv"]).refused(2);
    assert!(over_input.contains("red lamp.csv"), "{over_input}");
}

#[test]
fn lenses_of_a_scene_and_of_options_are_one_picture() {
    let sandbox = Sandbox::with_small_surface();
    let scene = |lens: &str| {
        format!(
            "mesh = \"plate\"\nsurface = \"flat\"\nlights = [\"35,20\"]\nbase_color = [0.5, 0.4, 0.3]\n\
             [camera]\neye = [0.0, -1.0, 3.0]\ntarget = [0.0, 0.0, 0.0]\n{lens}\n"
        )
    };
    sandbox.write("plain.toml", scene("field_of_view = \"35deg\""));
    sandbox.write("parallel.toml", scene("height = 1.5\nroll = \"20deg\"\nshift = [0.1, -0.2]"));
    let draw = |scene: &str, file: &str, more: &[&str]| {
        sandbox.run2(&["render", scene, "-o", file, "--size", "24x24"], more).done();
        exr(&sandbox, file).2
    };
    let options = ["--orthographic", "1.5", "--roll", "20deg", "--lens-shift", "0.1,-0.2"];
    let parallel = draw("parallel.toml", "scene.exr", &[]);
    assert!(parallel == draw("plain.toml", "options.exr", &options));
    assert!(parallel != draw("plain.toml", "two.exr", &options[..4]), "the shift is left out");
    assert!(parallel != draw("plain.toml", "one.exr", &options[..2]), "the roll is left out");
    for (lens, said) in [
        ("field_of_view = \"35deg\"\nheight = 1", "not one of field_of_view and height"),
        ("roll = \"1deg\"", "not one of field_of_view and height"),
        ("height = 0", "not a positive number"),
        ("height = 1\nshift = [0, 1e9]", "shift of the lens"),
        ("height = 1\nshift = [0, 0.1, 0.2]", "3 numbers where 2 belong"),
        ("height = 1\nroll = \"1\"", "deg"),
    ] {
        sandbox.write("bad.toml", scene(lens));
        let refused = sandbox.run(["render", "bad.toml", "-o", "no.png"]);
        let line = refused.refused_somehow(lens);
        assert!(line.contains(said), "{lens}: {line}");
    }
}

#[test]
fn a_channel_of_depth_holds_distances_along_the_axis_of_the_camera() {
    let sandbox = Sandbox::with_small_surface();
    // Straight down onto a plate of side 1 at z = 0.
    let down = ["--eye", "0,0,5", "--target", "0,0,0", "--orthographic", "1.5", "--surface", "flat"];
    let depth = ["render", "plate", "--size", "30x30", "--depth", "-o", "z.exr"];
    sandbox.run2(&depth, &down).done();
    let image = exr::prelude::read_first_flat_layer_from_file(sandbox.path("z.exr")).unwrap();
    let channel = |name: &str| {
        let channel = image.layer_data.channel_data.list.iter().find(|channel| channel.name.eq(name));
        channel.unwrap().sample_data.values_as_f32().collect::<Vec<f32>>()
    };
    let (distances, alpha) = (channel("Z"), channel("A"));
    for (distance, alpha) in distances.iter().zip(&alpha) {
        match alpha {
            0.0 => assert_eq!(*distance, f32::INFINITY),
            1.0 => assert!((distance - 5.0).abs() < 1e-4, "{distance}"),
            _ => {}
        }
    }
    let covered = distances.iter().filter(|distance| distance.is_finite()).count();
    assert!((380..=420).contains(&covered), "{covered} of 900 pixels where 400 are covered");
    let line = sandbox.run(["render", "plate", "--depth", "-o", "z.png"]).refused(2);
    assert!(line.contains(".exr"), "{line}");
    sandbox.run2(&depth, &["--turntable", "3"]).refused(2);
}

#[test]
fn a_scene_prepares_its_surface_and_the_command_line_does_it_instead() {
    let sandbox = Sandbox::with_small_surface();
    let scene = |prepare: &str| {
        format!(
            "mesh = \"plate\"\nsurface = \"blaze\"\nlights = [\"35,0\"]\nprepare = [{prepare}]\n\
             [camera]\neye = [0.0, -1.0, 3.0]\ntarget = [0.0, 0.0, 0.0]\nfield_of_view = \"35deg\"\n"
        )
    };
    sandbox.write("plain.toml", scene(""));
    sandbox.write("prepared.toml", scene("\"crop 5umx2um+0um+0um\", \"invert\""));
    let draw = |scene: &str, file: &str, more: &[&str]| {
        let common = ["render", scene, "-o", file, "--size", "24x24", "--coherence", "gaussian:4um"];
        sandbox.run2(&common, more).done();
        // The files carry different commands.
        exr(&sandbox, file).2
    };
    let plain = draw("plain.toml", "plain.exr", &[]);
    let by_scene = draw("prepared.toml", "scene.exr", &[]);
    let by_options = draw("plain.toml", "options.exr", &["--crop", "5umx2um+0um+0um", "--invert"]);
    assert!(by_scene == by_options && by_scene != plain);
    assert!(draw("prepared.toml", "none.exr", &["--level", "none"]) == plain, "the scene's steps stay");
}

#[test]
fn a_light_of_twice_the_intensity_is_twice_as_bright() {
    let sandbox = Sandbox::with_small_surface();
    render(&sandbox, "sphere", "one.exr", &["--light", "45,-40,1"]);
    render(&sandbox, "sphere", "two.exr", &["--light", "45,-40,2"]);
    let doubled: Vec<[f32; 4]> = exr(&sandbox, "one.exr").2.iter().map(|p| p.map(|x| 2.0 * x)).collect();
    assert!(deviation(&doubled, &exr(&sandbox, "two.exr").2) < 1e-6);
}

#[test]
fn exposure_changes_the_png_and_not_the_exr() {
    let sandbox = Sandbox::with_small_surface();
    for (ev, name) in [("0", "a"), ("-2.5", "b"), ("2", "c")] {
        render(&sandbox, "sphere", &format!("{name}.png"), &["--exposure", ev]);
        render(&sandbox, "sphere", &format!("{name}.exr"), &["--exposure", ev]);
    }
    // The files differ in the command that they carry.
    assert_eq!(exr(&sandbox, "a.exr").2, exr(&sandbox, "b.exr").2);
    let brightness = |name: &str| -> u64 { png(&sandbox, name).iter().map(|&b| u64::from(b)).sum() };
    assert!(brightness("b.png") < brightness("a.png") && brightness("a.png") < brightness("c.png"));
}

#[test]
fn a_tone_changes_the_png_and_not_the_exr_and_wins_over_the_scene() {
    let sandbox = Sandbox::with_small_surface();
    let plate = include_str!("../../assets/scenes/plate.toml");
    let tone = "tone = \"neutral\"\n";
    assert!(plate.contains(tone));
    sandbox.write("hard.toml", plate.replace(tone, ""));
    let bright = ["--exposure", "2"];
    for (scene, name, more) in [
        ("hard.toml", "plain", &[][..]),
        ("hard.toml", "none", &["--tone", "none"]),
        ("hard.toml", "neutral", &["--tone", "neutral"]),
        ("plate", "of-scene", &[]),
        ("plate", "named", &["--tone", "none"]),
    ] {
        for output in [format!("{name}.png"), format!("{name}.exr")] {
            render(&sandbox, scene, &output, &[&bright, more].concat());
        }
        assert_eq!(exr(&sandbox, &format!("{name}.exr")).2, exr(&sandbox, "plain.exr").2, "{name}");
    }
    let [plain, none, neutral, of_scene, named] =
        ["plain", "none", "neutral", "of-scene", "named"].map(|name| png(&sandbox, &format!("{name}.png")));
    assert!(plain == none && plain == named, "no tone is not what is displayed without one");
    assert!(neutral == of_scene && neutral != plain, "the tone is not that of the scene");
}

/// What `render` tells of the exposure that it measured \[stops\].
fn told_exposure(stderr: &str) -> f64 {
    let told =
        stderr.lines().find_map(|line| line.split_once("exposure ")).unwrap_or_else(|| panic!("{stderr}"));
    told.1.trim_end_matches(" stops").parse().unwrap_or_else(|_| panic!("{stderr}"))
}

#[test]
fn an_automatic_exposure_follows_the_light_and_is_told() {
    let sandbox = Sandbox::with_small_surface();
    let quick = ["--size", "32x24", "--tolerance", "1e-1", "--samples", "2", "--exposure"];
    let draw = |stops: &str, output: &str, more: &[&str]| {
        let own = [&["render", "plate"], &SMALL[..], &quick, &[stops, "-o", output]].concat();
        let outcome = sandbox.run2(&own, more);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        outcome.stderr
    };
    let of_light = |light: &str| told_exposure(&draw("auto", "auto.png", &["--light", light]));
    let (once, twice) = (of_light("40,180,1"), of_light("40,180,2"));
    assert!((once - twice - 1.0).abs() < 1e-9, "{once} and {twice} stops");
    // The picture is the one that the number gives.
    let auto = png(&sandbox, "auto.png");
    draw(&twice.to_string(), "named.png", &["--light", "40,180,2"]);
    assert!(auto == png(&sandbox, "named.png"));
    assert_eq!(draw("auto", "auto.png", &["-q"]), "");
    // The f64 reference exposes alike, and what nothing lights has the scene's own exposure.
    let exact = told_exposure(&draw("auto", "exact.png", &["--light", "40,180,2", "--method", "reference"]));
    assert!((exact - twice).abs() < 0.15, "{exact} and {twice} stops");
    let below = "mesh = \"plate\"\nsurface = \"flat\"\nlights = [\"90,0,1\"]\n[camera]\neye = [0, 0, 3]\n\
                 target = [0, 0, 0]\nfield_of_view = \"35deg\"\n";
    sandbox.write("below.toml", below);
    let unlit = ["render", "below.toml", "--size", "8x6", "--exposure", "auto", "-o", "unlit.png"];
    let said = sandbox.run2(&unlit, &["--tolerance", "1e-1"]);
    assert!(said.code == Some(0) && said.stderr.contains("exposure 0.0 stops, the scene's own"), "{said:?}");
}

#[test]
fn another_seed_is_another_skin() {
    let sandbox = Sandbox::with_small_surface();
    let of = |seed: &str, name: &str| {
        let skin = ["--surface", "xenopeltis", "--coherence", "gaussian:4um", "--tolerance", "1e-1"];
        let small = ["--height", "100nm", "--size", "16x12", "--seed", seed];
        sandbox.run2(&["render", "plate", "-o", name], &[&skin[..], &small].concat()).done();
        exr(&sandbox, name).2
    };
    assert_eq!(of("3", "a.exr"), of("3", "b.exr"));
    assert!(deviation(&of("4", "c.exr"), &of("3", "a.exr")) > 1e-3);
}

#[test]
fn a_scene_file_finds_its_mesh_and_surface_beside_itself() {
    let sandbox = Sandbox::with_small_surface();
    let folder = sandbox.path("my scenes");
    fs::create_dir(&folder).unwrap();
    fs::copy(sandbox.path("small.png"), folder.join("skin.png")).unwrap();
    let square =
        "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\n";
    fs::write(folder.join("square.obj"), square).unwrap();
    let scene = "mesh = \"square.obj\"\nup = \"z\"\nsurface = \"skin.png\"\npixel_size = \"83nm\"\nheight = \"137nm\"\n\
                 lights = [\"40,180,2\"]\n[camera]\neye = [1.1, -0.9, 1.5]\ntarget = [0, 0, 0]\n\
                 field_of_view = \"35deg\"\n";
    fs::write(folder.join("a scene.toml"), scene).unwrap();
    let small = ["--coherence", "gaussian:4um", "--tolerance", "1e-1", "--size", "16x12"];
    sandbox.run2(&["render", "my scenes/a scene.toml", "-o", "a picture.exr"], &small).done();
    let covered = exr(&sandbox, "a picture.exr").2.iter().filter(|p| p[3] == 1.0).count();
    assert!(covered > 50, "{covered}");
    let mesh = ["render", "my scenes/square.obj", "-o", "b.exr", "--surface", "bumps"];
    sandbox.run2(&mesh, &small).done();
}

#[test]
fn a_sample_of_the_reference_is_a_part_of_the_whole_and_the_whole_is_what_the_layers_draw() {
    let sandbox = Sandbox::with_small_surface();
    let reference = ["--method", "reference", "--windows", "1x1"];
    render(&sandbox, "plate", "whole.exr", &reference);
    render(&sandbox, "plate", "part.exr", &[&reference[..], &["--sample-pixels", "50"]].concat());
    render(&sandbox, "plate", "layers.exr", &["--tolerance", "1e-3", "--windows", "1x1"]);
    let (_, _, whole) = exr(&sandbox, "whole.exr");
    let (_, _, part) = exr(&sandbox, "part.exr");
    let (_, _, layers) = exr(&sandbox, "layers.exr");
    let chosen: Vec<usize> = (0..part.len()).filter(|&i| part[i][3] > 0.0).collect();
    assert_eq!(chosen.len(), 50);
    // A few pixels go through the direct sum, many through transforms of their own.
    let of = |all: &[[f32; 4]]| chosen.iter().map(|&i| all[i]).collect::<Vec<_>>();
    let both = deviation(&of(&part), &of(&whole));
    assert!(both < 1e-5, "{both:e}");
    // Directions on the two triangles of a plate are those of the rays.
    let error = deviation(&layers, &whole);
    assert!(error < 1e-3, "{error:e}");
}

#[test]
fn repeats_are_drawn_as_the_reference_draws_them_and_refused_where_they_take_too_many_wavelengths() {
    let sandbox = Sandbox::with_small_surface();
    let draw = |name: &str, more: &[&str]| {
        render(&sandbox, "sphere", name, more);
        exr(&sandbox, name).2
    };
    let exact = draw("exact.exr", &["--coherence", "repeats:3x20", "--method", "reference"]);
    let drawn = draw("drawn.exr", &["--coherence", "repeats:3x20", "--tolerance", "1e-2"]);
    assert!(deviation(&drawn, &exact) <= 1e-2, "{}", deviation(&drawn, &exact));
    let other = draw("other.exr", &["--coherence", "repeats:4x20", "--tolerance", "1e-2"]);
    assert!(deviation(&other, &exact) > 2e-2, "{}", deviation(&other, &exact));

    let refused = |code: i32, more: &[&str]| {
        let words = ["render", "sphere", "--surface", "blaze", "--size", "16x12", "-o", "none.png"];
        sandbox.run2(&words, more).refused(code)
    };
    let many = refused(1, &["--coherence", "repeats:10000x10000"]);
    assert!(many.contains("wavelengths") && many.contains("20000") && many.contains("repeats"), "{many}");
    let named = refused(2, &["--coherence", "repeats:3x3", "--wavelengths", "40"]);
    assert!(named.contains("--wavelengths"), "{named}");
    let table = refused(2, &["--coherence", "repeats:30x30", "--method", "table"]);
    assert!(table.contains("the mean over all windows") && table.contains("--method spectral"), "{table}");
    let mean = refused(2, &["--coherence", "repeats:3x3", "--windows", "all"]);
    assert!(mean.contains("--windows 1x1"), "{mean}");
    assert!(!sandbox.path("none.png").exists());
}

#[test]
fn what_belongs_to_one_window_is_refused_with_the_mean_and_the_other_way_round() {
    let sandbox = Sandbox::with_small_surface();
    let refused = |more: &[&str]| {
        sandbox.run2(&["render", "sphere", "-o", "none.png"], &[&SMALL[..], more].concat()).refused(2)
    };
    for own in [&["--basis", "taylor"][..], &["--terms", "9"]] {
        let line = refused(own);
        assert!(line.contains(own[0]) && line.contains("--windows 1x1"), "{line}");
    }
    assert!(refused(&["--windows", "1x1", "--beyond", "alike"]).contains("--beyond"));
    let grid = refused(&["--windows", "2x2", "--method", "table"]);
    assert!(grid.contains("--windows all") && grid.contains("--method spectral"), "{grid}");
    let mean = refused(&["--method", "spectral"]);
    assert!(mean.contains("--method table") && mean.contains("--windows 1x1"), "{mean}");
    assert!(!sandbox.path("none.png").exists());
}

#[test]
fn every_picture_says_where_scalar_theory_holds_in_the_words_of_info() {
    let sandbox = Sandbox::with_small_surface();
    let info = sandbox.run2(&["surface", "info"], &SMALL[..6]).done();
    let line = info.lines().find_map(|line| line.strip_prefix("scalar theory")).unwrap().trim().to_owned();
    assert!(line.starts_with("diffracted orders err by ") || line.starts_with("not known: "), "{line}");
    assert!(line.ends_with("angles of orders are exact"), "{line}");
    render(&sandbox, "plate", "a.png", &[]);
    render(&sandbox, "plate", "a.exr", &[]);
    let map = ["brdf", "--light", "30,0", "--size", "16x16", "-o", "map.png"];
    sandbox.run2(&map, &SMALL).done();
    for name in ["a.png", "map.png"] {
        let file = std::io::BufReader::new(fs::File::open(sandbox.path(name)).unwrap());
        let reader = png::Decoder::new(file).read_info().unwrap();
        let texts = &reader.info().utf8_text;
        let note = texts.iter().find(|text| text.keyword == "Scalar theory").unwrap();
        assert_eq!(note.get_text().unwrap(), line, "{name}");
    }
    let meta = exr::meta::MetaData::read_from_file(sandbox.path("a.exr"), false).unwrap();
    let comments = meta.headers[0].own_attributes.comments.as_ref().unwrap().to_string();
    let signs = [('λ', "lambda"), ('σ', "sigma "), ('°', "deg"), ('²', "^2")];
    let ascii = signs.iter().fold(line.clone(), |line, (sign, word)| line.replace(*sign, word));
    assert!(comments.contains(&format!("\nScalar theory: {ascii}")) && comments.is_ascii(), "{comments}");
    // Another surface has another line.
    render(&sandbox, "plate", "other.png", &["--surface", "sinusoid"]);
    let other = fs::read(sandbox.path("other.png")).unwrap();
    assert!(!other.windows(line.len()).any(|window| window == line.as_bytes()));
}

#[test]
fn a_background_that_is_asked_for_makes_a_picture_opaque() {
    let sandbox = Sandbox::with_small_surface();
    let clear = |output: &str, more: &[&str]| {
        render(&sandbox, "sphere", output, more);
        let picture = image::open(sandbox.path(output)).unwrap().to_rgba8();
        picture.pixels().filter(|pixel| pixel.0[3] < 255).count()
    };
    assert!(clear("clear.png", &[]) > 0);
    assert_eq!(clear("opaque.png", &["--background", "1,1,1"]), 0);
}
