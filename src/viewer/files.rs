//! Files that the user chooses to open or to write, and recently opened files.

use crate::scene::mesh_file;
use crate::surface::files;
use egui::Key;
use egui_file_dialog::{DialogState, FileDialog};
use std::path::{Path, PathBuf};

/// Maximum number of recently opened files in the list.
const MOST_RECENT: usize = 12;

/// Purpose of choosing a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DialogPurpose {
    /// Open a scene, a mesh or a height field.
    Open,
    /// Write a scene file.
    SaveScene,
}

/// File chosen in the dialog.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Chosen {
    /// Purpose.
    pub purpose: DialogPurpose,
    /// Path of the file.
    pub path: PathBuf,
}

/// File dialog, and the list of recently opened files.
#[derive(Default)]
pub struct FileChoice {
    dialog: Option<(DialogPurpose, FileDialog)>,
    // Newest first.
    recent: Vec<String>,
}

impl FileChoice {
    /// Makes a closed dialog with a list of recently opened files, newest first.
    pub fn with_recent(recent: Vec<String>) -> Self {
        Self { dialog: None, recent }
    }

    /// Returns true while the dialog is open.
    pub fn is_open(&self) -> bool {
        self.dialog.is_some()
    }

    /// Opens the dialog for a file to open.
    pub fn open(&mut self) {
        let all = [&["toml"][..], &mesh_file::EXTENSIONS, &files::extensions()].concat();
        let mut dialog = dialog("Open a scene, a mesh or a height field")
            .add_file_filter_extensions("all that can be shown", all)
            .add_file_filter_extensions("scenes", vec!["toml"])
            .add_file_filter_extensions("meshes", mesh_file::EXTENSIONS.to_vec())
            .add_file_filter_extensions("height fields", files::extensions())
            .default_file_filter("all that can be shown");
        dialog.pick_file();
        self.dialog = Some((DialogPurpose::Open, dialog));
    }

    /// Opens the dialog for the scene file to write.
    pub fn save_scene(&mut self) {
        let mut dialog = dialog("Save the scene with all settings")
            .add_save_extension("scene", "toml")
            .default_save_extension("scene")
            .default_file_name("scene.toml");
        dialog.save_file();
        self.dialog = Some((DialogPurpose::SaveScene, dialog));
    }

    /// Closes the dialog.
    pub fn close(&mut self) {
        self.dialog = None;
    }

    /// Shows the dialog if it is open, and returns the chosen file.
    pub fn update(&mut self, context: &egui::Context) -> Option<Chosen> {
        let (purpose, dialog) = self.dialog.as_mut()?;
        let purpose = *purpose;
        // The dialog itself ignores Enter while its search has the focus.
        let enters = purpose == DialogPurpose::Open && context.input(|input| input.key_pressed(Key::Enter));
        let selected = dialog.selected_entry().filter(|entry| enters && entry.is_file());
        let chosen = selected.map(|entry| entry.as_path().to_owned());
        dialog.update(context);
        let path = dialog.take_picked().or(chosen);
        if path.is_some() || !matches!(dialog.state(), DialogState::Open) {
            self.dialog = None;
        }
        path.map(|path| Chosen { purpose, path })
    }

    /// Adds an opened file to the list; returns the list if it has changed.
    pub fn remember(&mut self, name: &str) -> Option<&[String]> {
        let path = Path::new(name);
        let absolute = std::path::absolute(path).ok().filter(|_| path.is_file())?;
        let name = absolute.to_str()?.to_owned();
        if self.recent.first() == Some(&name) {
            return None;
        }
        self.recent.retain(|known| *known != name);
        self.recent.insert(0, name);
        self.recent.truncate(MOST_RECENT);
        Some(&self.recent)
    }

    /// Returns the recently opened files that still exist, newest first.
    pub fn recent(&self) -> Vec<String> {
        self.recent.iter().filter(|name| Path::new(name).is_file()).cloned().collect()
    }
}

fn dialog(title: &str) -> FileDialog {
    FileDialog::new().title(title).as_modal(true).default_size([620.0, 400.0]).min_size([320.0, 200.0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_newest_files_are_listed_once_as_long_as_they_are_there() {
        let folder = tempfile::tempdir().unwrap();
        let file = |n: usize| {
            let path = folder.path().join(format!("{n}.png"));
            std::fs::write(&path, "x").unwrap();
            path.to_str().unwrap().to_owned()
        };
        let mut choice = FileChoice::with_recent(vec![file(0)]);
        for n in 1..20 {
            assert_eq!(choice.remember(&file(n)).unwrap()[0], file(n));
        }
        assert!(choice.remember(&file(19)).is_none(), "nothing new");
        assert!(choice.remember("sinusoid").is_none(), "no file");
        choice.remember(&file(15)).unwrap();
        let recent = choice.recent();
        assert_eq!((recent.len(), &recent[0], &recent[1]), (MOST_RECENT, &file(15), &file(19)));
        std::fs::remove_file(folder.path().join("19.png")).unwrap();
        assert_eq!(choice.recent()[1], file(18));
    }
}
