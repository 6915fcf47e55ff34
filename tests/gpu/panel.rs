//! The panel's textures: what changes in them is there in the frame that shows it, with frames before it still in flight.

use crate::device::with_device;
use ash::vk;
use diffract::internals::render::target::read_back;
use diffract::internals::viewer::atlas::FrameResources;
use diffract::internals::viewer::gui::{Gui, PaintJobs};
use diffract::internals::vk::access::Access;
use diffract::internals::vk::commands::Commands;
use diffract::internals::vk::device::Device;
use diffract::internals::vk::image::{Description, Image};
use egui::epaint::ImageDelta;
use egui::{Color32, ColorImage, Context, FontId, RawInput, Rect, TextureId, TextureOptions, Ui};
use egui::{pos2, vec2};
use std::sync::Arc;

const FORMAT: vk::Format = vk::Format::R8G8B8A8_UNORM;
const SIZE: [u32; 2] = [320, 96];
const FLIGHTS: usize = 2;

/// What egui wants drawn after one look at `show`.
fn look(context: &Context, show: impl FnMut(&mut Ui)) -> PaintJobs {
    let [width, height] = SIZE.map(|n| n as f32);
    let area = Rect::from_min_size(pos2(0.0, 0.0), vec2(width, height));
    let output = context.run_ui(RawInput { screen_rect: Some(area), ..RawInput::default() }, show);
    let scale = output.pixels_per_point;
    assert_eq!(scale, 1.0);
    let primitives = context.tessellate(output.shapes, scale);
    PaintJobs { primitives, textures: output.textures_delta, scale }
}

/// Frames on images of their own, none of which is waited for before the next but one.
struct Film {
    flights: Vec<(Commands, FrameResources)>,
    frames: Vec<Image>,
    gui: Gui,
    device: Arc<Device>,
}

impl Film {
    fn new(device: &Arc<Device>) -> Self {
        let flight = |_| (Commands::new(device, "panel").unwrap(), FrameResources::default());
        Self {
            flights: (0..FLIGHTS).map(flight).collect(),
            frames: Vec::new(),
            gui: Gui::new(device, FORMAT, FLIGHTS).unwrap(),
            device: device.clone(),
        }
    }

    fn draw(&mut self, mut painting: PaintJobs) {
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_SRC;
        let description =
            Description { name: "frame", format: FORMAT, size: SIZE, layers: 1, array: false, usage };
        let image = Image::new(&self.device, &description).unwrap();
        let (commands, kept) = &mut self.flights[self.frames.len() % FLIGHTS];
        let gui = &mut self.gui;
        commands.wait().unwrap();
        kept.clear();
        let record = |record: &diffract::internals::vk::commands::Recorder<'_>| {
            gui.upload(record, &mut painting.textures, kept)?;
            record.images(&[(&image, Access::Nothing, Access::ColorAttachment)]);
            record.render(&[(&image, Some([0.0, 0.0, 0.0, 1.0]))], None, |draw| {
                gui.draw(draw, SIZE, &mut painting, kept).unwrap();
            });
            Ok(())
        };
        commands.start(record, None, None).unwrap();
        assert!(painting.textures.is_empty());
        self.frames.push(image);
    }

    /// The pixels of every frame.
    fn develop(mut self) -> Vec<Vec<[u8; 4]>> {
        self.flights.iter_mut().for_each(|(commands, _)| commands.wait().unwrap());
        let pixels = |image| read_back(&self.device, image, Access::ColorAttachment).unwrap();
        self.frames.iter().map(|image| bytemuck::pod_collect_to_vec(&pixels(image))).collect()
    }
}

#[test]
fn new_glyphs_of_frames_in_flight_look_as_those_of_an_atlas_that_is_there_from_the_start() {
    // More glyphs of the same size, then so large ones that the atlas grows.
    let texts = [("a", 14.0), ("a cat", 14.0), ("the five boxing", 14.0), ("wizards", 80.0), ("JUMP", 90.0)];
    let (mut parts, mut sizes) = (0, Vec::new());
    with_device(|device| {
        let context = Context::default();
        let (mut film, mut expected) = (Film::new(device), Vec::new());
        for (text, size) in texts {
            let show = |ui: &mut Ui| {
                let painter = ui.painter();
                let (at, font) = (pos2(4.0, 2.0), FontId::proportional(size));
                painter.text(at, egui::Align2::LEFT_TOP, text, font, Color32::WHITE);
            };
            let painting = look(&context, show);
            for delta in painting.textures.set.values().flatten() {
                match delta.pos {
                    Some(_) => parts += 1,
                    None => sizes.push(delta.image.size()),
                }
            }
            let mut whole = egui::TexturesDelta::default();
            let atlas = context.fonts(|fonts| fonts.image());
            whole.push(TextureId::default(), ImageDelta::full(atlas, TextureOptions::LINEAR));
            let again = PaintJobs { primitives: painting.primitives.clone(), textures: whole, scale: 1.0 };
            film.draw(painting);
            let mut alone = Film::new(device);
            alone.draw(again);
            expected.extend(alone.develop());
        }
        for ((text, _), (frame, expected)) in texts.iter().zip(film.develop().iter().zip(&expected)) {
            let bright = frame.iter().filter(|pixel| pixel[0] > 200).count();
            assert!(bright >= 10 * text.len(), "{text}: {bright} bright pixels");
            assert!(frame == expected, "{text}");
        }
    });
    assert!(parts >= 2, "{parts} parts of the atlas");
    assert!(sizes.len() >= 2 && sizes[0] != sizes[1], "{sizes:?}");
}

/// A picture that is different for every `seed`, of colours that no transfer function changes.
fn pattern(size: [usize; 2], seed: usize) -> ColorImage {
    let level = |bits: usize, i: usize| if (bits >> i) & 1 == 1 { 255 } else { 0 };
    let color = |n: usize| ((n + 1) * (2 * seed + 3) * 0x9e37) >> 7;
    let texels =
        (0..size[0] * size[1]).map(color).map(|b| Color32::from_rgb(level(b, 0), level(b, 1), level(b, 2)));
    ColorImage::new(size, texels.collect())
}

#[test]
fn textures_are_changed_replaced_and_given_up_while_frames_that_show_them_are_in_flight() {
    // Interpolation between texels may leave a trace of the neighbour's, which the transfer function makes larger.
    let level = |code: u8| if code < 128 { 0 } else { 255 };
    let shown = |frame: &[[u8; 4]], size: [usize; 2]| {
        let pixel = |i: usize| frame[i / size[0] * SIZE[0] as usize + i % size[0]];
        let texels = (0..size[0] * size[1])
            .map(pixel)
            .map(|[r, g, b, _]| Color32::from_rgb(level(r), level(g), level(b)));
        ColorImage::new(size, texels.collect())
    };
    with_device(|device| {
        let context = Context::default();
        let mut film = Film::new(device);
        let mut now = pattern([48, 24], 0);
        let mut texture = context.load_texture("pattern", now.clone(), TextureOptions::LINEAR);
        let mut expected = Vec::new();
        for step in 1..8 {
            let (id, [width, height]) = (texture.id(), texture.size());
            let show = |ui: &mut Ui| {
                let area = Rect::from_min_size(pos2(0.0, 0.0), vec2(width as f32, height as f32));
                let all = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
                ui.painter().image(id, area, all, Color32::WHITE);
            };
            film.draw(look(&context, show));
            expected.push(now.clone());
            match step {
                // Two parts that overlap, also with those of the frame before.
                1 | 2 | 6 => {
                    for (seed, corner) in [(step, [5 * step, 2 * step]), (step + 10, [6 * step, step])] {
                        let part = pattern([9 + step, 7], seed);
                        for (i, texel) in part.pixels.iter().enumerate() {
                            now[(corner[0] + i % part.width(), corner[1] + i / part.width())] = *texel;
                        }
                        texture.set_partial(corner, part, TextureOptions::LINEAR);
                    }
                }
                // All of it; in another size; as another texture, with the end of the first.
                3 => {
                    now = pattern([48, 24], step);
                    texture.set(now.clone(), TextureOptions::LINEAR);
                }
                4 => {
                    now = pattern([64, 40], step);
                    texture.set(now.clone(), TextureOptions::LINEAR);
                }
                _ => {
                    now = pattern([64, 40], step);
                    texture = context.load_texture("pattern", now.clone(), TextureOptions::LINEAR);
                }
            }
        }
        for (step, (frame, expected)) in film.develop().iter().zip(&expected).enumerate() {
            assert!(shown(frame, expected.size) == *expected, "frame {step}");
        }
    });
}

#[test]
fn a_texture_that_is_given_up_leaves_no_memory_behind() {
    with_device(|device| {
        let (context, mut film) = (Context::default(), Film::new(device));
        let picture = pattern([256, 256], 1);
        let bytes = 4 * picture.pixels.len() as u64;
        let show = |film: &mut Film, texture: Option<TextureId>| {
            for _ in 0..2 * FLIGHTS {
                let shown = |ui: &mut Ui| {
                    ui.label("beside it");
                    let (all, area) = (Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), ui.max_rect());
                    if let Some(id) = texture {
                        ui.painter().image(id, area, all, Color32::WHITE);
                    }
                };
                film.draw(look(&context, shown));
            }
            film.flights.iter_mut().for_each(|(commands, _)| commands.wait().unwrap());
            film.frames.clear();
            device.memory_in_use()
        };
        let texture = context.load_texture("picture", picture.clone(), TextureOptions::LINEAR);
        let with = show(&mut film, Some(texture.id()));
        drop(texture);
        let without = show(&mut film, None);
        assert!(without + bytes <= with, "{with} to {without} bytes");
        let other = context.load_texture("picture", picture, TextureOptions::LINEAR);
        assert_eq!(show(&mut film, Some(other.id())), with);
        drop(other);
        assert_eq!(show(&mut film, None), without);
    });
}
