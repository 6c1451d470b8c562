//! Selections of frame numbers: `5`, `1-100`, `1-100x2`, `1-10,20,30-40`.

use super::{FrameFile, SequenceError};
use std::fmt;
use std::str::FromStr;

/// Frame numbers `first`, `first + step`, … up to `last`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Span {
    first: u64,
    last: u64,
    step: u64,
}

/// Which frames of a sequence are wanted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameSelection {
    spans: Vec<Span>,
}

/// A selection that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{part:?} is no selection of frames: {reason}; write 5, 1-100, 1-100x2 or 1-10,20")]
pub struct SelectionError {
    part: String,
    reason: &'static str,
}

impl FromStr for FrameSelection {
    type Err = SelectionError;

    fn from_str(text: &str) -> Result<Self, SelectionError> {
        let spans = text
            .split(',')
            .map(|part| span(part.trim()))
            .collect::<Result<_, _>>()?;
        Ok(Self { spans })
    }
}

fn span(part: &str) -> Result<Span, SelectionError> {
    let error = |reason| SelectionError {
        part: part.to_owned(),
        reason,
    };
    let number = |text: &str| {
        let digits = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
        text.parse::<u64>()
            .ok()
            .filter(|_| digits)
            .ok_or_else(|| error("a whole number is missing"))
    };
    let (range, step) = match part.split_once('x') {
        Some((range, step)) => (range, number(step)?),
        None => (part, 1),
    };
    let (first, last) = match range.split_once('-') {
        Some((first, last)) => (number(first)?, number(last)?),
        None if part.contains('x') => return Err(error("a step needs a range before it")),
        None => (number(range)?, number(range)?),
    };
    if step == 0 {
        return Err(error("the step is 0"));
    }
    if first > last {
        return Err(error("the last frame comes before the first"));
    }
    Ok(Span { first, last, step })
}

impl fmt::Display for FrameSelection {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, Span { first, last, step }) in self.spans.iter().enumerate() {
            let comma = if i > 0 { "," } else { "" };
            write!(f, "{comma}{first}")?;
            if last > first {
                write!(f, "-{last}")?;
            }
            if *step > 1 && last > first {
                write!(f, "x{step}")?;
            }
        }
        Ok(())
    }
}

impl FrameSelection {
    /// Whether frame `number` is wanted.
    pub fn contains(&self, number: u64) -> bool {
        self.spans.iter().any(|&Span { first, last, step }| {
            (first..=last).contains(&number) && (number - first).is_multiple_of(step)
        })
    }

    /// The last number that is wanted.
    pub fn last(&self) -> u64 {
        let last = |span: &Span| span.last - (span.last - span.first) % span.step;
        self.spans.iter().map(last).max().unwrap_or(0)
    }

    /// The wanted ones of some frames, in their order.
    ///
    /// # Errors
    /// When none is wanted.
    pub fn select(&self, frames: Vec<FrameFile>) -> Result<Vec<FrameFile>, SequenceError> {
        let numbers = || frames.iter().map(|frame| frame.number);
        let nothing = SequenceError::NothingSelected {
            selection: self.to_string(),
            count: frames.len(),
            first: numbers().min().unwrap_or(0),
            last: numbers().max().unwrap_or(0),
        };
        let selected: Vec<FrameFile> = frames
            .into_iter()
            .filter(|frame| self.contains(frame.number))
            .collect();
        if selected.is_empty() {
            Err(nothing)
        } else {
            Ok(selected)
        }
    }
}
