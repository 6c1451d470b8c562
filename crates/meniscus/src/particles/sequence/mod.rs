//! Sequences of frames: file patterns such as `frame_{}.vtk`, explicit lists, selections of frame
//! numbers, and the output path that belongs to an input.

mod gaps;
mod selection;

pub use gaps::{gaps, usual_step};
pub use selection::{FrameSelection, SelectionError};

use std::cmp::Ordering;
use std::path::{Component, Path, PathBuf};

/// Stands for the frame number in a pattern.
pub const PLACEHOLDER: &str = "{}";

/// One input file of a sequence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameFile {
    /// The file.
    pub path: PathBuf,
    /// Its frame number.
    pub number: u64,
    /// The number as it stands in the file's name, padding included: `0042`.
    pub text: String,
}

/// What is wrong with a pattern or a list of inputs.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SequenceError {
    /// More than one `{{}}`.
    #[error("{pattern}: a pattern has one {{}} for the frame number, this has {count}")]
    Placeholders {
        /// The pattern.
        pattern: String,
        /// How many there are.
        count: usize,
    },
    /// A shell's or printf's notation.
    #[error("{pattern}: write {{}} for the frame number: {suggestion}")]
    Notation {
        /// What was given.
        pattern: String,
        /// The same as we write it.
        suggestion: String,
    },
    /// No file there.
    #[error("{wanted}: no such file in {folder}{}", there(nearest))]
    NoMatch {
        /// The pattern or file.
        wanted: String,
        /// Where it was looked for.
        folder: PathBuf,
        /// Names that are there and come close.
        nearest: Vec<String>,
    },
    /// The folder cannot be listed.
    #[error("{wanted}: cannot list {folder}: {reason}")]
    Folder {
        /// The pattern or file.
        wanted: String,
        /// Where it was looked for.
        folder: PathBuf,
        /// The system's words.
        reason: String,
    },
    /// The selection leaves nothing.
    #[error("frames {selection} match none of the {count} there are, {first} to {last}")]
    NothingSelected {
        /// The selection.
        selection: String,
        /// Number of frames.
        count: usize,
        /// Lowest number.
        first: u64,
        /// Highest number.
        last: u64,
    },
}

fn there(nearest: &[String]) -> String {
    if nearest.is_empty() {
        "; the folder is empty".to_owned()
    } else {
        format!("; there are {}", nearest.join(", "))
    }
}

/// Whether a path has a `{}`.
pub fn is_pattern(path: &Path) -> bool {
    path.to_string_lossy().contains(PLACEHOLDER)
}

/// The files that the inputs of a command line stand for, in order of their frames.
///
/// A single pattern gives its files by number. Several inputs are one sequence in natural order;
/// their number is the last one in the file's name where that tells them apart, else their place in
/// the list, from 1.
///
/// # Errors
/// When a pattern is wrong, or a file or every file of a pattern is missing.
pub fn expand(inputs: &[PathBuf]) -> Result<Vec<FrameFile>, SequenceError> {
    if let [pattern] = inputs
        && is_pattern(pattern)
    {
        return matches(pattern);
    }
    let mut paths = Vec::new();
    for input in inputs {
        if is_pattern(input) {
            paths.extend(matches(input)?.into_iter().map(|frame| frame.path));
        } else if input.exists() {
            paths.push(input.clone());
        } else {
            return Err(missing(input));
        }
    }
    paths.sort_by(|a, b| natural_order(a, b));
    Ok(numbered(paths))
}

fn numbered(paths: Vec<PathBuf>) -> Vec<FrameFile> {
    let texts: Vec<Option<(u64, String)>> = paths
        .iter()
        .map(|path| {
            let text = last_number(&path.file_stem()?.to_string_lossy())?;
            Some((text.parse().ok()?, text))
        })
        .collect();
    let mut numbers: Vec<u64> = texts.iter().flatten().map(|(number, _)| *number).collect();
    numbers.sort_unstable();
    numbers.dedup();
    let distinct = numbers.len() == paths.len();
    let width = paths.len().to_string().len();
    paths
        .into_iter()
        .zip(texts)
        .zip(1..)
        .map(|((path, text), place)| {
            let (number, text) = text
                .filter(|_| distinct)
                .unwrap_or_else(|| (place, format!("{place:0width$}")));
            FrameFile { path, number, text }
        })
        .collect()
}

/// The last run of digits in a name.
fn last_number(name: &str) -> Option<String> {
    let end = name.rfind(|c: char| c.is_ascii_digit())? + 1;
    let start = name[..end]
        .rfind(|c: char| !c.is_ascii_digit())
        .map_or(0, |before| {
            before + name[before..].chars().next().map_or(1, char::len_utf8)
        });
    Some(name[start..end].to_owned())
}

/// The existing files of a pattern with one `{}`, by number. `{}` stands for one or more digits, in
/// the file's name or in that of a folder.
///
/// # Errors
/// When the pattern is wrong, the folder cannot be listed, or nothing matches.
pub fn matches(pattern: &Path) -> Result<Vec<FrameFile>, SequenceError> {
    let wanted = pattern.display().to_string();
    let count = wanted.matches(PLACEHOLDER).count();
    if count != 1 {
        return Err(SequenceError::Placeholders {
            pattern: wanted,
            count,
        });
    }
    let mut folder = PathBuf::new();
    let mut components = pattern.components();
    let name = loop {
        match components.next() {
            Some(Component::Normal(name)) if is_pattern(Path::new(name)) => {
                break name.to_string_lossy().into_owned();
            }
            Some(other) => folder.push(other),
            None => {
                return Err(SequenceError::Placeholders {
                    pattern: wanted,
                    count: 0,
                });
            }
        }
    };
    let rest = components.as_path();
    let (prefix, suffix) = name.split_once(PLACEHOLDER).unwrap_or((&name, ""));
    let names = names_in(&folder).map_err(|reason| SequenceError::Folder {
        wanted: wanted.clone(),
        folder: shown(&folder),
        reason,
    })?;
    let mut frames: Vec<FrameFile> = names
        .iter()
        .filter_map(|name| {
            let text = name.strip_prefix(prefix)?.strip_suffix(suffix)?;
            let digits = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
            let number = text.parse().ok().filter(|_| digits)?;
            let mut path = folder.join(name);
            if rest != Path::new("") {
                path.push(rest);
            }
            path.is_file().then(|| FrameFile {
                path,
                number,
                text: text.to_owned(),
            })
        })
        .collect();
    if frames.is_empty() {
        let nearest = nearest(names, &name);
        return Err(SequenceError::NoMatch {
            wanted,
            folder: shown(&folder),
            nearest,
        });
    }
    frames.sort_by(|a, b| (a.number, &a.text).cmp(&(b.number, &b.text)));
    Ok(frames)
}

/// The path that `pattern` gives for a frame: its `{}` replaced by the number's text.
pub fn output_path(pattern: &Path, text: &str) -> PathBuf {
    PathBuf::from(pattern.to_string_lossy().replacen(PLACEHOLDER, text, 1))
}

/// The error for an input that is not there.
fn missing(input: &Path) -> SequenceError {
    let wanted = input.display().to_string();
    if let Some(suggestion) = as_placeholder(&wanted) {
        return SequenceError::Notation {
            pattern: wanted,
            suggestion,
        };
    }
    let folder = input.parent().unwrap_or(Path::new(""));
    let name = input
        .file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned();
    match names_in(folder) {
        Ok(names) => SequenceError::NoMatch {
            wanted,
            folder: shown(folder),
            nearest: nearest(names, &name),
        },
        Err(reason) => SequenceError::Folder {
            wanted,
            folder: shown(folder),
            reason,
        },
    }
}

/// `frame_*.vtk`, `frame_%04d.vtk`, `frame_####.vtk` and `frame_$F4.vtk` with `{}`.
fn as_placeholder(wanted: &str) -> Option<String> {
    let (start, tail) = match wanted.find(['*', '?', '%', '#']) {
        Some(at) if wanted[at..].starts_with('%') => {
            let digits = wanted[at + 1..]
                .bytes()
                .take_while(u8::is_ascii_digit)
                .count();
            let letter = wanted[at + 1 + digits..].starts_with(['d', 'i', 'u']);
            (letter.then_some(at)?, at + digits + 2)
        }
        Some(at) => {
            let mark = wanted.as_bytes()[at];
            let length = wanted[at..]
                .bytes()
                .take_while(|&byte| byte == mark)
                .count();
            (at, at + length)
        }
        None => {
            let at = wanted.find("$F")?;
            let digits = wanted[at + 2..]
                .bytes()
                .take_while(u8::is_ascii_digit)
                .count();
            (at, at + 2 + digits)
        }
    };
    Some(format!(
        "{}{PLACEHOLDER}{}",
        &wanted[..start],
        &wanted[tail..]
    ))
}

fn shown(folder: &Path) -> PathBuf {
    let here = folder.as_os_str().is_empty();
    if here {
        PathBuf::from(".")
    } else {
        folder.to_owned()
    }
}

fn names_in(folder: &Path) -> Result<Vec<String>, String> {
    std::fs::read_dir(shown(folder))
        .and_then(|entries| {
            entries
                .map(|entry| Ok(entry?.file_name().to_string_lossy().into_owned()))
                .collect()
        })
        .map_err(|error| error.to_string())
}

/// Up to five names that begin most like `wanted`, in natural order.
fn nearest(mut names: Vec<String>, wanted: &str) -> Vec<String> {
    let ending = |name: &str| name.rsplit_once('.').map(|(_, ending)| ending.to_owned());
    let likeness = |name: &str| {
        let common = name
            .chars()
            .zip(wanted.chars())
            .take_while(|(a, b)| a.eq_ignore_ascii_case(b))
            .count();
        2 * common + usize::from(ending(name) == ending(wanted))
    };
    names.sort_by(|a, b| {
        likeness(b)
            .cmp(&likeness(a))
            .then_with(|| natural_order(Path::new(a), Path::new(b)))
    });
    names.truncate(5);
    names.sort_by(|a, b| natural_order(Path::new(a), Path::new(b)));
    names
}

/// Orders paths as people do: runs of digits by their value (`f2` before `f10`), the rest by
/// characters.
pub fn natural_order(a: &Path, b: &Path) -> Ordering {
    let (a_text, b_text) = (a.to_string_lossy(), b.to_string_lossy());
    let (mut left, mut right) = (a_text.as_ref(), b_text.as_ref());
    loop {
        let (Some(l), Some(r)) = (left.chars().next(), right.chars().next()) else {
            let by_length = left.len().cmp(&right.len());
            return by_length.then_with(|| a_text.cmp(&b_text));
        };
        if l.is_ascii_digit() && r.is_ascii_digit() {
            let (l_digits, l_rest) = split_digits(left);
            let (r_digits, r_rest) = split_digits(right);
            let (l_value, r_value) = (
                l_digits.trim_start_matches('0'),
                r_digits.trim_start_matches('0'),
            );
            let order = (l_value.len(), l_value).cmp(&(r_value.len(), r_value));
            if order != Ordering::Equal {
                return order;
            }
            (left, right) = (l_rest, r_rest);
        } else {
            if l != r {
                return l.cmp(&r);
            }
            (left, right) = (&left[l.len_utf8()..], &right[r.len_utf8()..]);
        }
    }
}

fn split_digits(text: &str) -> (&str, &str) {
    let end = text
        .find(|c: char| !c.is_ascii_digit())
        .unwrap_or(text.len());
    text.split_at(end)
}

#[cfg(test)]
mod tests;
