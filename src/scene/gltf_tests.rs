//! Sound and hostile glTF files.

use super::super::mesh::tests::assert_sound;
use super::*;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;

/// Returns positions, texture coordinates and indices of a unit square as bytes: 48, 32 and 12.
fn square() -> Vec<u8> {
    let positions = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let uvs = [[0.0f32, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let floats = positions.as_flattened().iter().chain(uvs.as_flattened());
    let indices = [0u16, 1, 2, 0, 2, 3];
    floats.flat_map(|x| x.to_le_bytes()).chain(indices.iter().flat_map(|i| i.to_le_bytes())).collect()
}

/// Returns the description of the square, red and at (0, 0, 2), mirrored and blue at (0, 0, −2); `uri` names its buffer.
fn description(uri: &str) -> String {
    r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
    "nodes":[{"children":[1,2]},{"name":"front","mesh":0,"translation":[0,0,2]},{"name":"back","mesh":1,"scale":[1,1,-1],"translation":[0,0,-2]}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,"material":0}]},
      {"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2,"material":1}]}],
    "materials":[{"name":"red","pbrMetallicRoughness":{"baseColorFactor":[1,0,0,1]}},{"name":"blue","pbrMetallicRoughness":{"baseColorFactor":[0,0,1,1]}}],
    "buffers":[{URI"byteLength":92}],
    "bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":32},{"buffer":0,"byteOffset":80,"byteLength":12}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
      {"bufferView":1,"componentType":5126,"count":4,"type":"VEC2"},{"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}]}"#
        .replace("URI", uri)
}

/// Returns a binary file of a description and data.
fn glb(json: &str, data: &[u8]) -> Vec<u8> {
    let mut json = json.as_bytes().to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let length = FIRST_CHUNK + json.len() + 8 + data.len();
    let word = |n: usize| (n as u32).to_le_bytes();
    [SIGNATURE, &word(2), &word(length), &word(json.len()), b"JSON", &json, &word(data.len()), b"BIN\0", data]
        .concat()
}

fn read(bytes: &[u8], part: Option<&str>) -> Result<LoadedMesh> {
    load(bytes, Path::new(""), part, &Task::silent())
}

fn refusal(bytes: &[u8]) -> String {
    let e = read(bytes, None).map(|_| ()).unwrap_err().to_string();
    assert!(e.contains("; ") && !e.contains('\n'), "{e}");
    e
}

#[test]
fn text_and_binary_are_the_same_mesh_at_the_places_of_their_nodes() {
    let LoadedMesh { mesh, color, notes } = read(&glb(&description(""), &square()), None).unwrap();
    assert_sound(&mesh);
    assert_eq!((mesh.triangle_count(), mesh.vertices().len()), (4, 8));
    for vertex in mesh.vertices() {
        let [x, y, z] = vertex.position;
        assert_eq!((z.abs(), vertex.uv), (2.0, [x, y]));
        // The winding of the mirrored square is turned over.
        assert_eq!(vertex.normal[2], z.signum());
    }
    assert_eq!(color, Some(Vec3::new(0.5, 0.0, 0.5)));
    assert!(notes.len() == 1 && notes[0].contains("2 colours"), "{notes:?}");
    let data = format!(r#""uri":"data:application/octet-stream;base64,{}","#, STANDARD.encode(square()));
    assert_eq!(read(description(&data).as_bytes(), None).unwrap().mesh, mesh);
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a b.bin"), square()).unwrap();
    let text = description(r#""uri":"a%20b.bin","#);
    assert_eq!(load(text.as_bytes(), folder.path(), None, &Task::silent()).unwrap().mesh, mesh);
}

#[test]
fn parts_are_nodes_meshes_and_materials() {
    let file = glb(&description(""), &square());
    for (part, z) in [("front", 2.0), ("blue", -2.0)] {
        let LoadedMesh { mesh, notes, .. } = read(&file, Some(part)).unwrap();
        assert!(mesh.vertices().iter().all(|v| v.position[2] == z) && notes.is_empty(), "{part}: {notes:?}");
    }
    let e = read(&file, Some("top")).map(|_| ()).unwrap_err().to_string();
    assert!(
        e.contains("`top`") && e.contains("blue, front, red") | e.contains("back, blue, front, red"),
        "{e}"
    );
}

#[test]
fn strips_and_fans_are_the_triangles_that_they_stand_for() {
    assert_eq!(triangles(&[5, 6, 7, 8], Mode::TriangleStrip), [[5, 6, 7], [7, 6, 8]]);
    assert_eq!(triangles(&[5, 6, 7, 8], Mode::TriangleFan), [[5, 6, 7], [5, 7, 8]]);
    assert!(triangles(&[], Mode::TriangleFan).is_empty() && triangles(&[1, 2], Mode::Triangles).is_empty());
}

#[test]
fn files_cut_anywhere_are_refused() {
    let binary = glb(&description(""), &square());
    let data = format!(r#""uri":"data:;base64,{}","#, STANDARD.encode(square()));
    let text = description(&data).into_bytes();
    for whole in [&binary, &text] {
        for length in 0..whole.len() {
            refusal(&whole[..length]);
        }
    }
}

#[test]
fn descriptions_that_lie_are_refused() {
    let sound = description("");
    for (old, new, said) in [
        (r#""byteLength":92"#, r#""byteLength":93"#, "92 bytes where 93"),
        (r#""byteLength":92"#, r#""byteLength":99999999999999"#, "simplify"),
        (r#""byteOffset":80"#, r#""byteOffset":84"#, "beyond its buffer"),
        (r#""byteOffset":80"#, r#""byteOffset":18446744073709551615"#, "beyond its buffer"),
        (r#""count":6"#, r#""count":7"#, "beyond its buffer"),
        (r#""count":6"#, r#""count":18446744073709551615"#, "simplify"),
        (r#""count":4,"type":"VEC3""#, r#""count":3,"type":"VEC3""#, "vertex 3 of 3"),
        (r#""count":4,"type":"VEC3""#, r#""count":0,"type":"VEC3""#, "beyond its buffer"),
        (r#""children":[1,2]"#, r#""children":[1,1]"#, "child twice"),
        (r#""children":[1,2]"#, r#""children":[0]"#, "child twice"),
        (r#""children":[1,2]"#, r#""children":[9]"#, "damaged"),
        (r#""children":[1,2]"#, r#""children":[]"#, "no triangles"),
        (r#""scene":0"#, r#""scene":7"#, "damaged"),
        (r#""POSITION":0"#, r#""POSITION":3"#, "data that it does not have"),
        (
            r#""scene":0"#,
            r#""extensionsRequired":["KHR_draco_mesh_compression"],"scene":0"#,
            "KHR_draco_mesh_compression",
        ),
        (
            r#""componentType":5126,"count":4,"type":"VEC3""#,
            r#""componentType":5126,"count":4,"type":"VEC2""#,
            "3 numbers",
        ),
        (r#""componentType":5123"#, r#""componentType":5126"#, "no indices"),
        (r#""componentType":5123"#, r#""componentType":7"#, "damaged"),
        (r#""translation":[0,0,2]"#, r#""translation":[0,0,1e30]"#, "1e30"),
        (
            r#""bufferView":0"#,
            r#""sparse":{"count":1,"indices":{"bufferView":2,"componentType":5123},"values":{"bufferView":0}}"#,
            "sparse",
        ),
    ] {
        let changed = sound.replacen(old, new, 1);
        assert_ne!(changed, sound, "{old}");
        let e = refusal(&glb(&changed, &square()));
        assert!(e.contains(said), "{new}: {e}");
    }
    let mut short = glb(&sound, &square());
    short[8..12].copy_from_slice(&3u32.to_le_bytes());
    assert!(refusal(&short).contains("not a glTF"));
    assert!(refusal(b"v 0 0 0\n").contains("not a glTF"));
    // A hundred thousand nodes in a row, which are no recursion.
    let chain: String = (0..100_000).map(|i| format!(r#"{{"children":[{}]}},"#, i + 1)).collect();
    let deep = format!(r#"{{"asset":{{"version":"2.0"}},"scenes":[{{"nodes":[0]}}],"nodes":[{chain}{{}}]}}"#);
    assert!(refusal(deep.as_bytes()).contains("no triangles"));
}
