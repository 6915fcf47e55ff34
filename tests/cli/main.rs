//! The program as its users run it: what each command does, what it refuses, and what it leaves behind.
//!
//! Every test runs the built program in a folder of its own with a cache of its own. Pictures need a Vulkan device.

#![allow(clippy::unwrap_used, reason = "a test that cannot be set up has failed")]

mod answers;
mod brdf;
mod browser;
mod cache;
mod colour;
mod devices;
mod display;
mod eval;
mod export;
mod export_page;
mod export_page_access;
mod export_wgsl;
mod faults;
mod figures;
mod hostile_files;
mod hostile_options;
mod lights;
mod maps;
mod mesh_files;
mod notes;
mod objects;
mod orders;
mod outputs;
mod peaks;
mod profile;
mod regressions;
mod render;
mod sampling;
mod sandbox;
mod scans;
mod sequence;
mod surface;
mod table;
mod tolerance;
mod trade;
mod usage;
mod view;
mod viewer;
mod viewer_files;
mod viewer_hand;
mod viewer_inspector;
mod viewer_losses;
mod viewer_panel;
mod viewer_random;
mod viewer_record;
mod viewer_samples;
mod viewer_start;
mod viewer_wayland;
mod wayland;
