//! Meshes of several formats, options of the mesh, and what is told about meshes, materials and surroundings.

use crate::render::{deviation, exr};
use crate::sandbox::{Outcome, Sandbox};
use diffract::internals::scene::scene_file::BUILT_IN;

/// A square that stands upright if z is up, as OBJ and PLY.
const OBJ: &str =
    "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float s\nproperty float t\n\
                   element face 2\nproperty list uchar int vertex_indices\nend_header\n-1 -1 0 0 0\n1 -1 0 1 0\n1 1 0 1 1\n-1 1 0 0 1\n3 0 1 2\n3 0 2 3\n";

/// Draws the blazed grating on `scene`.
fn draw(sandbox: &Sandbox, scene: &str, output: &str, more: &[&str]) -> Outcome {
    let words = ["render", scene, "-o", output, "--surface", "blaze", "--coherence", "gaussian:16um"];
    let small = ["--tolerance", "1e-1", "--size", "24x16", "--samples", "1"];
    sandbox.run2(&words, &[&small[..], more].concat())
}

#[test]
fn a_mesh_is_the_same_picture_in_every_format_and_its_options_are_those_of_scene_files() {
    let sandbox = Sandbox::new();
    sandbox.write("a.obj", OBJ);
    sandbox.write("a.ply", PLY);
    draw(&sandbox, "a.obj", "obj.exr", &["--up", "z"]).done();
    draw(&sandbox, "a.ply", "ply.exr", &[]).done();
    let picture = |name: &str| exr(&sandbox, name).2;
    assert_eq!(picture("ply.exr"), picture("obj.exr"));
    draw(&sandbox, "a.ply", "turned.exr", &["--grooves", "90deg"]).done();
    assert!(deviation(&picture("turned.exr"), &picture("ply.exr")) > 1e-2);
    let plate = BUILT_IN[1].1.replace("mesh = \"plate\"", "mesh = \"a.ply\"");
    let lines = plate.lines().filter(|line| !line.starts_with("scale")).collect::<Vec<_>>().join("\n");
    sandbox.write("plain.toml", &lines);
    sandbox.write("named.toml", format!("scale = \"30mm\"\ngrooves = \"40deg\"\n{lines}"));
    draw(&sandbox, "named.toml", "named.exr", &[]).done();
    draw(&sandbox, "plain.toml", "options.exr", &["--scale", "30mm", "--grooves", "40deg"]).done();
    assert_eq!(picture("options.exr"), picture("named.exr"));
    // A part of a file that names no parts, and an axis of a mesh that comes from no file.
    let part = format!("part = \"a\"\n{lines}");
    sandbox.write("part.toml", part);
    assert!(draw(&sandbox, "part.toml", "no.exr", &[]).refused(1).contains("name no parts"));
    assert!(draw(&sandbox, "plate", "no.exr", &["--up", "y"]).refused(2).contains("built in"));
}

#[test]
fn what_a_mesh_a_material_and_surroundings_lack_is_told() {
    let sandbox = Sandbox::new();
    sandbox.write("line.obj", OBJ.replace("vt 1 0", "vt 0 0").replace("vt 0 1", "vt 1 1"));
    sandbox.write("none.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nf 1 2 3\n");
    sandbox.write("a.csv", "wl,n\n0.4,1.5\n0.7,1.6\nwl,k\n0.4,0.1\n0.7,0.2\n");
    let mut sky = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    sky.extend([128, 128, 128, 160].into_iter().chain([128, 128, 128, 129].repeat(7)));
    sandbox.write("sun.hdr", sky);
    for (scene, more, said) in [
        ("line.obj", &[][..], "line.obj: the texture coordinates of each triangle are equal or on a line"),
        ("none.obj", &[], "none.obj: without texture coordinates"),
        ("plate", &["--material", "a.csv"], "a.csv: the refractive index is given from 400 to 700 nm"),
        (
            "plate",
            &["--environment", "sun.hdr"],
            "sun.hdr: 1 pixel is negative, not a number, infinite or beyond 65504",
        ),
    ] {
        let outcome = draw(&sandbox, scene, "a.exr", more);
        assert!(outcome.code == Some(0) && outcome.stderr.contains(said), "{outcome:?}");
        assert_eq!(outcome.stderr.lines().count(), 1, "{outcome:?}");
    }
}
