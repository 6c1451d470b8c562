//! Runs the program in a folder of its own.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

/// A folder that goes away with its files.
pub(crate) struct Folder(tempfile::TempDir);

/// How a run ended.
pub(crate) struct Ended {
    pub(crate) code: Option<i32>,
    pub(crate) stdout: String,
    pub(crate) stderr: String,
}

impl Ended {
    /// Runs a command to its end.
    pub(crate) fn of(mut command: Command) -> Self {
        let Output {
            status,
            stdout,
            stderr,
        } = command.output().unwrap();
        Self {
            code: status.code(),
            stdout: String::from_utf8(stdout).unwrap(),
            stderr: String::from_utf8(stderr).unwrap(),
        }
    }
}

impl Folder {
    pub(crate) fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).unwrap();
    }

    pub(crate) fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub(crate) fn json(&self, name: &str) -> serde_json::Value {
        serde_json::from_slice(&self.read(name)).unwrap()
    }

    /// Names of all files, hidden ones too, sorted.
    pub(crate) fn names(&self) -> Vec<String> {
        let mut names: Vec<String> = std::fs::read_dir(self.0.path())
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

    pub(crate) fn command(&self, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_meniscus"));
        command
            .current_dir(self.0.path())
            .args(split(words))
            .env_remove("NO_COLOR")
            // The same on machines with a card.
            .env("MENISCUS_GPU", "off")
            .stdin(Stdio::null());
        command
    }

    /// Runs `meniscus` with these words; single quotes hold words together.
    pub(crate) fn run(&self, words: &str) -> Ended {
        Ended::of(self.command(words))
    }

    /// Runs it and wants success.
    pub(crate) fn done(&self, words: &str) -> Ended {
        let ended = self.run(words);
        assert_eq!(ended.code, Some(0), "{words}: {}", ended.stderr);
        ended
    }

    /// Runs it, wants this exit code, a message with all of these parts, no panic, and no file beside
    /// those that were there.
    pub(crate) fn fails(&self, words: &str, code: i32, parts: &[&str]) -> Ended {
        let before = self.names();
        let ended = self.run(words);
        assert_eq!(ended.code, Some(code), "{words}: {}", ended.stderr);
        for part in parts {
            assert!(
                ended.stderr.contains(part),
                "{words}: no `{part}` in: {}",
                ended.stderr
            );
        }
        assert!(
            !ended.stderr.contains("panicked"),
            "{words}: {}",
            ended.stderr
        );
        assert_eq!(self.names(), before, "{words} left files behind");
        ended
    }

    /// A small particle file, `water.vtk`, and its scene `water.toml`.
    pub(crate) fn with_water() -> Self {
        let folder = Self::new();
        folder.done("generate pool -o water.vtk --count 300");
        folder
    }
}

fn split(words: &str) -> Vec<String> {
    let mut split = Vec::new();
    for (i, part) in words.split('\'').enumerate() {
        if i % 2 == 1 {
            split.push(part.to_owned());
        } else {
            split.extend(part.split_whitespace().map(str::to_owned));
        }
    }
    split
}

/// Whether a file is a whole PNG: signature and end chunk.
pub(crate) fn is_whole_png(path: &Path) -> bool {
    let bytes = std::fs::read(path).unwrap();
    bytes.starts_with(b"\x89PNG\r\n\x1a\n") && bytes.ends_with(b"IEND\xaeB`\x82")
}

/// Control characters other than line breaks: what a terminal may get and a file must not.
pub(crate) fn has_control_characters(text: &str) -> bool {
    text.chars().any(|c| c.is_control() && c != '\n')
}
