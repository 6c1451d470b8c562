//! Scene files: TOML or JSON with one schema, told by content.
//!
//! Text → a tree of values with their places (`toml_text`, `json_text`) → [`Scene`] (`de`) →
//! [`Scene::validate`]. Every error points at the bytes that are wrong.

mod de;
mod error;
mod json_text;
mod node;
mod set;
pub(in crate::scene) mod suggest;
mod toml_text;

pub use error::{Excerpt, SceneError, SceneErrorKind};

use super::Scene;
use de::DeError;
use node::Node;
use serde::Deserialize;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Largest scene file.
pub const MAX_BYTES: u64 = 16 << 20;

/// Reads and validates a scene file. Relative `file` keys are taken relative to its folder.
///
/// # Errors
/// When the file cannot be read, is neither TOML nor JSON, has unknown keys or wrong values, or when
/// [`Scene::validate`] refuses the scene.
pub fn load(path: &Path) -> Result<Scene, SceneError> {
    let name = path.display().to_string();
    let text = read_text(path, &name)?;
    let mut scene = parse(&text, &name)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let files = (scene.surfaces.iter_mut().map(|surface| &mut surface.file))
        .chain(scene.meshes.iter_mut().map(|mesh| &mut mesh.file))
        .chain(
            scene
                .lights
                .iter_mut()
                .filter_map(|light| light.file.as_mut()),
        );
    for file in files {
        resolve(file, folder);
    }
    Ok(scene)
}

/// Reads and validates a scene from text; `name` stands in error messages. Relative `file` keys stay
/// as they are.
///
/// # Errors
/// As [`load`].
pub fn parse(text: &str, name: &str) -> Result<Scene, SceneError> {
    let is_json = text
        .trim_start_matches('\u{feff}')
        .trim_start()
        .starts_with('{');
    let parsed = if is_json {
        // A byte order mark is white space to us, not to the JSON parser.
        match text.strip_prefix('\u{feff}') {
            Some(rest) => return parse(rest, name),
            None => json_text::parse(text),
        }
    } else {
        toml_text::parse(text)
    };
    let root = parsed.map_err(|error| {
        let format = if is_json { "JSON" } else { "TOML" };
        SceneError::new(
            SceneErrorKind::Syntax,
            format!("not valid {format}: {}", error.message),
        )
        .pointing(name, text, error.span)
    })?;
    let scene = from_node(&root).map_err(|error| {
        let span = error.span.clone().unwrap_or_default();
        error.into_scene_error().pointing(name, text, span)
    })?;
    scene.validate().map_err(|error| {
        let span = if error.key.is_empty() {
            0..0
        } else {
            root.locate(&error.key)
        };
        error.pointing(name, text, span)
    })?;
    Ok(scene)
}

fn from_node(root: &Node) -> Result<Scene, DeError> {
    Scene::deserialize(root)
}

fn resolve(file: &mut PathBuf, folder: &Path) {
    if file.is_relative() && !file.as_os_str().is_empty() {
        *file = folder.join(&file);
    }
}

fn read_text(path: &Path, name: &str) -> Result<String, SceneError> {
    let cannot = |reason: String| {
        SceneError::new(SceneErrorKind::Io, format!("cannot read {name}: {reason}"))
    };
    let file = std::fs::File::open(path).map_err(|error| cannot(error.to_string()))?;
    let mut bytes = Vec::new();
    file.take(MAX_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(|error| cannot(error.to_string()))?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(SceneError::new(
            SceneErrorKind::Syntax,
            format!(
                "{name} is larger than {} MiB: not a scene file",
                MAX_BYTES >> 20
            ),
        ));
    }
    String::from_utf8(bytes).map_err(|error| {
        SceneError::new(
            SceneErrorKind::Syntax,
            format!(
                "{name} is not UTF-8 text (byte {}): not a scene file",
                error.utf8_error().valid_up_to()
            ),
        )
    })
}

impl Scene {
    /// The scene as TOML, ready to be saved as a scene file.
    ///
    /// # Errors
    /// When a file name is not Unicode, or a number is not one that TOML can write.
    pub fn to_toml(&self) -> Result<String, SceneError> {
        toml::to_string(self).map_err(|error| {
            SceneError::new(
                SceneErrorKind::Invalid,
                format!("cannot write the scene: {error}"),
            )
        })
    }

    /// The scene as JSON.
    ///
    /// # Errors
    /// When a file name is not Unicode.
    pub fn to_json(&self) -> Result<String, SceneError> {
        serde_json::to_string_pretty(self).map_err(|error| {
            SceneError::new(
                SceneErrorKind::Invalid,
                format!("cannot write the scene: {error}"),
            )
        })
    }
}

#[cfg(test)]
mod tests;
