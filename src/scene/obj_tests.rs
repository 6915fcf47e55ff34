//! Sound and hostile OBJ files.

use super::super::mesh::tests::assert_sound;
use super::super::{loaded_mesh, mesh_file};
use super::*;
use crate::task::Task;
use proptest::prelude::*;
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn parse(text: &str) -> Result<Mesh> {
    from_bytes(text.as_bytes())
}

/// Returns a file of `faces` triangles beside each other.
fn strip(faces: usize) -> String {
    let vertices: String = (0..faces + 2).map(|i| format!("v {} {} 0\n", i / 2, i % 2)).collect();
    vertices + &(1..=faces).map(|i| format!("f {} {} {}\n", i, i + 1, i + 2)).collect::<String>()
}

/// Asserts that `text` is refused with an error that names `part`.
fn assert_refused(text: &str, part: &str) {
    let e = parse(text).map(|m| m.triangle_count()).unwrap_err().to_string();
    assert!(e.contains(part) && e.contains("; ") && !e.contains('\n'), "{text:?}: {e}");
}

#[test]
fn separate_indices_for_position_texture_and_normal_are_followed() {
    let text = format!("{SQUARE}vt 5 5\nvt 1 0\nvt 0 0\nvn 0 1 0\nvn 0 0 2\nf 1/3/2 2/2/2 3/1/2\n");
    let mesh = parse(&text).unwrap();
    assert_sound(&mesh);
    let uvs: Vec<_> = mesh.vertices().iter().map(|v| v.uv).collect();
    assert_eq!(uvs, [[0.0, 0.0], [1.0, 0.0], [5.0, 5.0]]);
    assert!(mesh.vertices().iter().all(|v| v.normal == [0.0, 0.0, 1.0]));
}

#[test]
fn a_part_has_the_faces_of_its_object_its_group_or_its_material() {
    let text = format!(
        "{SQUARE}f 1 2 3\no body\nf 1 2 3\ng back left\nusemtl skin\nf 1 2 3 4\nusemtl eye\nf -1 -2 -3\no tail\nv 0 0 9\nf 1 2 5\n"
    );
    let faces = |part: Option<&str>| {
        super::parse(text.as_bytes(), part, &Task::silent()).map(|mesh| mesh.triangle_count())
    };
    let parts = [None, Some("body"), Some("back"), Some("left"), Some("skin"), Some("eye"), Some("tail")];
    assert_eq!(parts.map(|part| faces(part).unwrap()), [6, 4, 4, 4, 2, 2, 1]);
    let error = faces(Some("head")).unwrap_err().to_string();
    assert!(
        error.contains("no face belongs to the part `head`") && error.contains("back, body, eye"),
        "{error}"
    );
}

#[test]
fn objects_are_merged_and_polygons_cut_into_triangles() {
    let text = format!(
        "mtllib none.mtl\no one\n{SQUARE}usemtl x\nf 1 2 3 4\nl 1 2 3\np 1\ns off\no two\nv 0 0 5\nv 1 0 5\nv 1 1 5\nv .5 2 5\nv 0 1 5\n\
         f -5 -4 -3 \\\n -2 -1\n"
    );
    let mesh = parse(&text).unwrap();
    assert_sound(&mesh);
    assert_eq!(mesh.triangle_count(), 5);
}

/// Returns the area of the triangles of a mesh in the plane z = 0.
fn area(mesh: &Mesh) -> f32 {
    let corner = |&i: &u32| Vec3::from(mesh.vertices()[i as usize].position);
    let double = |t: &[u32]| (corner(&t[1]) - corner(&t[0])).cross(corner(&t[2]) - corner(&t[0])).z;
    mesh.indices().chunks(3).map(double).sum::<f32>() / 2.0
}

#[test]
fn a_concave_face_leaves_its_notch_open_and_keeps_its_attributes() {
    // An L that begins at the end of an arm, so that a fan from there covers the notch.
    let corners = [[2, 0], [2, 1], [1, 1], [1, 2], [0, 2], [0, 0]];
    let vertices: String = corners.iter().map(|[x, y]| format!("v {x} {y} 0\nvt {y} {x}\n")).collect();
    let mesh = parse(&format!("{vertices}f 1/1 2/2 3/3 4/4 5/5 6/6\n")).unwrap();
    assert_sound(&mesh);
    assert_eq!((mesh.vertices().len(), mesh.triangle_count(), area(&mesh)), (6, 4, 3.0));
    for v in mesh.vertices() {
        assert_eq!((v.uv, v.normal), ([v.position[1], v.position[0]], [0.0, 0.0, 1.0]));
    }
    for triangle in mesh.indices().chunks(3) {
        let centre =
            |c: usize| triangle.iter().map(|&i| mesh.vertices()[i as usize].position[c]).sum::<f32>() / 3.0;
        assert!(centre(0) < 1.0 || centre(1) < 1.0, "{triangle:?} is over the notch");
    }
    // The same with a corner twice, one on an edge, and faces without an area beside it.
    let more = format!("{vertices}v 1 0 0\nf 1 1 2 3 4 4 5 6 7\nf 1 1 1 1 1\nf 6 7 1 7\n");
    let mesh = parse(&more).unwrap();
    assert_sound(&mesh);
    assert_eq!(area(&mesh), 3.0);
}

#[test]
fn without_normals_and_texture_coordinates_both_are_made() {
    let mesh = parse(&format!("{SQUARE}f 1 2 3 4\n")).unwrap();
    assert_eq!(mesh.vertices().len(), 4);
    for v in mesh.vertices() {
        assert_eq!((v.normal, v.tangent), ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0, 1.0]));
        assert_eq!(v.uv[..], v.position[..2]);
    }
}

#[test]
fn one_face_without_texture_coordinates_puts_the_whole_file_under_the_projection() {
    let text = format!("{SQUARE}vt 9 9\nvt 8 9\nvt 9 8\nf 1/1 2/2 3/3\nf 1 3 4\n");
    let mesh = parse(&text).unwrap();
    assert_sound(&mesh);
    assert!(mesh.vertices().iter().all(|v| v.uv[..] == v.position[..2]));
}

#[test]
fn windows_line_ends_weights_colours_and_foreign_letters_are_read() {
    let mut bytes = b"# caf\xe9\r\nv 0 0 0 1\r\nv 2 0 0 2\r\nv 0 1 0 .1 .2 .3 1\r\nf 1 2 3\r\n".to_vec();
    assert_eq!(from_bytes(&bytes).unwrap().triangle_count(), 1);
    bytes.push(0);
    assert!(from_bytes(&bytes).unwrap_err().to_string().contains("not a Wavefront OBJ"));
}

#[test]
fn comments_behind_data_and_comments_that_end_in_a_backslash_leave_the_mesh_as_it_is() {
    let plain = parse(&format!("{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n")).unwrap();
    for text in [
        "v 0 0 0 # corner\nv 1 0 0# 2\nv 1 1 0\nv 0 1 0 1 # weight\nvt 0 0 # uv\nvt 1 0\nvt 1 1 #\nf 1/1 2/2 3/3 # front\n",
        "# D:\\a\\\nv 0 0 0\n #\\\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 2/2 3/3\n",
        "v 0 0 0\nv 1 0 0 # \\\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nf 1/1 \\\n 2/2 3/3#\\",
    ] {
        assert_eq!(parse(text).unwrap(), plain, "{text}");
    }
    // A comment is no corner, and a name may have the sign of one.
    assert_refused(&format!("{SQUARE}f 1 2 # 3\n"), "line 5: a face needs 3 corners and has 2");
    let named = format!("{SQUARE}usemtl #25\nf 1 2 3\nusemtl other\nf 1 2 3 4\n");
    let part = super::parse(named.as_bytes(), Some("#25"), &Task::silent()).unwrap();
    assert_eq!(part.triangle_count(), 1);
}

#[test]
fn indices_of_normals_count_for_nothing_in_a_file_without_normals() {
    let plain = parse(&format!("{SQUARE}f 1 2 3 4\n")).unwrap();
    for face in ["1//1 2//2 3//3 4//4", "1//-1 2//-1 3//-1 4//-1", "1//1 2 3//1 4", "1//9 2// 3/ 4"] {
        assert_eq!(parse(&format!("{SQUARE}f {face}\n")).unwrap(), plain, "{face}");
    }
    let textured = |more: &str| {
        parse(&format!("{SQUARE}vt 0 0\nvt 3 0\nvt 3 3\nf 1/1{more} 2/2{more} 3/3{more}\n")).unwrap()
    };
    assert_eq!(textured("/7"), textured(""));
    assert_ne!(textured(""), plain);
}

#[test]
fn a_byte_order_mark_and_every_kind_of_line_end_leave_the_mesh_as_it_is() {
    let text = format!("{SQUARE}f 1 2 3 \\\n 4\n");
    let plain = parse(&text).unwrap();
    assert_eq!(plain.vertices().len(), 4);
    assert_eq!(parse(&format!("\u{feff}{text}")).unwrap(), plain);
    for end in ["\r\n", "\r"] {
        assert_eq!(parse(&text.replace('\n', end)).unwrap(), plain, "{end:?}");
        assert_eq!(parse(&format!("\u{feff}{}", text.replace('\n', end))).unwrap(), plain, "{end:?}");
    }
    assert_refused("\u{feff}", "empty");
}

#[test]
fn a_weight_that_is_no_number_and_a_face_of_too_many_corners_are_refused() {
    for weight in ["inf", "-inf", "nan", "1e99", "x"] {
        assert_refused(&format!("v 0 0 0 {weight}\n"), "line 1");
    }
    let face = |corners: usize| format!("{SQUARE}f{}\n", " 1 2 3 4".repeat(corners / 4));
    assert!(parse(&face(1 << 17)).is_ok());
    assert_refused(&face((1 << 17) + 4), "line 5: a face has 131076 corners");
}

#[test]
fn reading_tells_how_far_it_is_and_ends_at_once_when_it_is_cancelled() {
    let text = strip(100_000);
    let told = Arc::new(Mutex::new(Vec::new()));
    let task = Task::reporting({
        let told = Arc::clone(&told);
        move |progress| told.lock().unwrap().push(progress)
    });
    assert_eq!(super::parse(text.as_bytes(), None, &task).unwrap().triangle_count(), 100_000);
    let told = told.lock().unwrap();
    assert!(told.iter().all(|progress| progress.done <= progress.of), "{told:?}");
    for what in ["counting faces", "reading faces"] {
        let times = told.iter().filter(|progress| progress.stage == what).count();
        assert!(times > text.len() / REPORT_EVERY, "{what} {times} times in {} bytes", text.len());
    }
    // A report of cancelled work is the last one.
    for last in 1..=told.len() {
        let (task, reports) = Task::cancelled_at(last);
        let e = super::parse(text.as_bytes(), None, &task).unwrap_err();
        assert!(e.is_cancelled(), "{e}");
        assert_eq!(reports.load(Ordering::Relaxed), last);
    }
}

#[test]
fn a_line_that_goes_on_is_one_line_and_the_next_has_the_number_of_an_editor() {
    for end in ["\n", "\r\n", "\r"] {
        let text = format!("{SQUARE}f 1 2\\\n\\\n 3\nf 1 2 x\n").replace('\n', end);
        assert_refused(&text, "line 8: \"x\" is not a corner");
    }
    assert_refused(&format!("{SQUARE}f 1 2 3 \\"), "line 5");
    assert_refused(&format!("{SQUARE}f 1 2\\ 3\n"), "line 5: \"2\\\\\" is not a corner");
}

#[test]
fn an_error_shows_the_beginning_of_a_long_word_only() {
    let long = "9".repeat(1 << 20);
    for text in [format!("v 0 0 {long}\n"), format!("{SQUARE}f 1 2 {long}\n")] {
        let e = parse(&text).unwrap_err().to_string();
        assert!(e.len() < 200 && e.contains("999\""), "{e:.300}");
    }
}

#[test]
fn what_is_not_a_mesh_is_refused_with_a_reason() {
    assert_refused("", "empty");
    assert_refused(" \n\n", "empty");
    assert_refused("hello\nworld\n", "not a Wavefront OBJ");
    assert_refused(SQUARE, "no faces");
    assert_refused(&format!("{SQUARE}f 1 1 2\n"), "no triangle with an area");
}

#[test]
fn a_malformed_line_is_named_by_its_number() {
    assert_refused("v 0 0\n", "line 1: \"v\" needs 3 numbers and has 2");
    assert_refused("v 0 0 nan\n", "line 1");
    assert_refused("v 0 1e99 0\n", "line 1");
    assert_refused("vt\n", "line 1: \"vt\" needs 2");
    assert_refused(&format!("{SQUARE}vn 0 x 0\n"), "line 5");
    for face in
        ["f", "f 1 2", "f 1 2 x", "f 1 2 3/4/5/6", "f 1 2 /1/1", "f 1 2 3.5", "f 1 2 99999999999999999999"]
    {
        assert_refused(&format!("{SQUARE}{face}\n"), "line 5");
    }
}

#[test]
fn an_index_that_points_at_nothing_is_refused() {
    let huge = i64::MAX;
    for face in ["1 2 5", "1 2 0", "1 2 -5", "1/1 2/1 3/1", "1/-1 2/-1 3/-1"] {
        assert_refused(&format!("{SQUARE}f {face}\n"), "line 5: a face asks for");
    }
    for face in ["1//1 2//1 3//2", "1//1 2//1 3//-2", "1//1 2//0 3//1"] {
        assert_refused(&format!("{SQUARE}vn 0 0 1\nf {face}\n"), "line 6: a face asks for \"vn\"");
    }
    assert_refused(&format!("{SQUARE}f 1//-1 2//-1 3//-1\nvn 0 0 1\n"), "line 5: a face asks for \"vn\"");
    assert_refused(&format!("{SQUARE}vt 0 0\nf 1/{huge} 2/1 3/1\n"), "line 6: a face asks for \"vt\"");
    assert_refused(&format!("{SQUARE}f 1 2 {}\n", i64::MIN), "line 5");
}

#[test]
fn a_weight_of_zero_and_coordinates_out_of_reach_are_refused() {
    assert_refused("v 0 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "line 1: the weight of a position is 0");
    assert_refused("v 1e20 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "beyond");
    assert_refused("v 1 0 0 1e-30\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "beyond");
}

#[test]
fn files_that_are_missing_directories_or_huge_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("none.obj");
    let e = mesh_file::load(&missing, None, &Task::silent()).unwrap_err().to_string();
    assert!(e.contains("none.obj") && e.contains("there is no such file"), "{e}");
    assert!(
        mesh_file::load(folder.path(), None, &Task::silent())
            .unwrap_err()
            .to_string()
            .contains("it is a folder")
    );
    let huge = folder.path().join("huge.obj");
    std::fs::File::create(&huge).unwrap().set_len(loaded_mesh::MAX_BYTES + 1).unwrap();
    assert!(mesh_file::load(&huge, None, &Task::silent()).unwrap_err().to_string().contains("more than the"));
}

#[test]
fn a_file_cut_anywhere_is_read_or_refused_and_never_panics() {
    let text =
        format!("{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nf 1/1/1 2/2/1 3/3/1\nf -4//-1 -2//-1 -1//-1\n");
    for end in 0..text.len() {
        if let Ok(mesh) = parse(&text[..end]) {
            assert_sound(&mesh);
        }
    }
}

#[test]
fn a_face_of_a_hundred_thousand_corners_neither_hangs_nor_overflows_the_stack() {
    let count = 100_000;
    let angle = |i: usize| std::f64::consts::TAU * i as f64 / count as f64;
    let mut text: String =
        (0..count).map(|i| format!("v {} {} 0\n", angle(i).cos(), angle(i).sin())).collect();
    text += &(0..count).fold("f".to_string(), |line, i| line + &format!(" {}", i + 1));
    // A point of the circle may lie too close to the first for its triangle to count.
    let fan = parse(&text).unwrap();
    assert!(fan.triangle_count() > count / 2, "{}", fan.triangle_count());
    // The same circle as spokes around one hub, and a heap of equal triangles.
    text = text[..text.find('f').unwrap()].to_string() + "v 0 0 0\n";
    text += &(0..count)
        .map(|i| format!("f {} {} {}\n", count + 1, i + 1, (i + 1) % count + 1))
        .collect::<String>();
    assert_sound(&parse(&text).unwrap());
    assert_sound(&parse(&format!("{SQUARE}{}", "f 1 2 3\n".repeat(count))).unwrap());
}

proptest! {
    #[test]
    fn any_lines_of_obj_words_are_read_or_refused(
        lines in prop::collection::vec(
            ("(v|vt|vn|f|f|f|l|o|g|usemtl|mtllib|#|p|)", prop::collection::vec("(-?[0-9]{1,2}|-?[0-4](/-?[0-4]?){0,3}|1e40|nan|\\\\)", 0..7)),
            0..20,
        ),
    ) {
        let tail: Vec<_> = lines.iter().map(|(tag, words)| format!("{tag} {}\n", words.join(" "))).collect();
        for head in ["", SQUARE, "v 1 2 3\nv 3 2 2\nv 0 1 9\nvt 0 1\nvt 1 1\nvn 0 1 0\n"] {
            if let Ok(mesh) = parse(&format!("{head}{}", tail.concat())) {
                assert_sound(&mesh);
            }
        }
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = from_bytes(&bytes);
    }
}

#[test]
fn colours_of_materials_beside_the_file_are_its_pigment() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.obj");
    let text = format!(
        "mtllib paint shop.mtl\n{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nusemtl dark red\nf 1/1 2/2 3/3\nusemtl blue\nf 1/1 3/3 4/2\n"
    );
    std::fs::write(&path, &text).unwrap();
    let read = |part: Option<&str>| mesh_file::load(&path, part, &Task::silent()).unwrap();
    let unpainted = read(None);
    assert_eq!(unpainted.color, None);
    assert!(
        unpainted.notes.len() == 1 && unpainted.notes[0].contains("no such file"),
        "{:?}",
        unpainted.notes
    );
    let materials = "newmtl dark red\nKd 0.5 0.25 0\nnewmtl blue\nKd 0 0.25 1\n";
    std::fs::write(folder.path().join("paint shop.mtl"), materials).unwrap();
    let painted = read(None);
    assert_eq!(painted.color, Some(Vec3::new(0.25, 0.25, 0.5)));
    assert!(painted.notes.len() == 1 && painted.notes[0].contains("2 colours"), "{:?}", painted.notes);
    let blue = read(Some("blue"));
    assert!(blue.color == Some(Vec3::new(0.0, 0.25, 1.0)) && blue.notes.is_empty(), "{:?}", blue.notes);
}
