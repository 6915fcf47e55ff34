//! Surroundings as directional lights.

use crate::sandbox::Sandbox;
use serde_json::Value;
use std::f64::consts::PI;

/// Returns three numbers of each light under `key`.
fn triples(list: &Value, key: &str) -> Vec<[f64; 3]> {
    let lights = list["lights"].as_array().unwrap();
    lights.iter().map(|light| std::array::from_fn(|i| light[key][i].as_f64().unwrap())).collect()
}

fn lights(sandbox: &Sandbox, arguments: &[&str]) -> Value {
    serde_json::from_str(&sandbox.run([&["lights"], arguments].concat()).done()).unwrap()
}

/// Returns a Radiance picture of 8 × 4 pixels, black but for those of these places (column, row), which have radiance 1.
fn picture(bright: &[[usize; 2]]) -> Vec<u8> {
    let mut file = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
    for (row, column) in (0..4).flat_map(|row| (0..8).map(move |column| (row, column))) {
        // 128 · 2^(129 − 128 − 8) = 1
        let pixel = if bright.contains(&[column, row]) { [128, 128, 128, 129] } else { [0; 4] };
        file.extend(pixel);
    }
    file
}

#[test]
fn lights_of_an_even_sky_add_up_to_its_whole_sphere() {
    let sandbox = Sandbox::new();
    let all: Vec<[usize; 2]> = (0..4).flat_map(|row| (0..8).map(move |column| [column, row])).collect();
    sandbox.write("even.hdr", picture(&all));
    for count in ["1", "7", "64"] {
        let list = lights(&sandbox, &["even.hdr", "-n", count]);
        let irradiances = triples(&list, "irradiance");
        assert_eq!(irradiances.len(), count.parse::<usize>().unwrap());
        for channel in 0..3 {
            let sum: f64 = irradiances.iter().map(|light| light[channel]).sum();
            assert!((sum / (4.0 * PI) - 1.0).abs() < 1e-5, "{count}: {sum}");
        }
        let lengths = triples(&list, "direction").into_iter().map(|[x, y, z]| x * x + y * y + z * z);
        assert!(lengths.into_iter().all(|square| (square - 1.0).abs() < 1e-9));
    }
}

#[test]
fn a_bright_pixel_is_light_from_its_direction_and_turns_with_the_surroundings() {
    let sandbox = Sandbox::new();
    // The middle of the picture is toward +x, and columns go toward −y; the second row is above the horizon.
    sandbox.write("spot.hdr", picture(&[[4, 1]]));
    let (theta, phi) = (PI * 1.5 / 4.0, -PI / 8.0);
    let solid_angle = PI / 4.0 * ((PI / 4.0).cos() - (PI / 2.0).cos());
    for turn in [0.0, 90.0] {
        let rotation = format!("--rotate-environment={turn}deg");
        let list = lights(&sandbox, &["spot.hdr", "-n", "4", &rotation]);
        let azimuth = phi + f64::to_radians(turn);
        let expected = [theta.sin() * azimuth.cos(), theta.sin() * azimuth.sin(), theta.cos()];
        let directions = triples(&list, "direction");
        assert!((1..=4).contains(&directions.len()));
        for direction in directions {
            let cosine: f64 = direction.iter().zip(expected).map(|(a, b)| a * b).sum();
            assert!(cosine > 0.999, "{direction:?} is not {expected:?}");
        }
        let sum: f64 = triples(&list, "irradiance").iter().map(|light| light[0]).sum();
        assert!((sum / solid_angle - 1.0).abs() < 1e-5, "{sum} is not {solid_angle}");
    }
    let written = sandbox.run(["lights", "sky", "-o", "sky.json"]).done();
    assert!(written.is_empty());
    let list: Value = serde_json::from_slice(&sandbox.read("sky.json")).unwrap();
    assert_eq!(triples(&list, "irradiance").len(), 64);
    assert!(sandbox.run(["lights", "nothing.hdr"]).refused(1).contains("nothing.hdr"));
}
