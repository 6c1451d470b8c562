//! Frames of a running simulation, as they appear.

use super::input::{self, FrameInput};
use crate::exit::{Failure, Outcome};
use crate::interrupt;
use crate::progress::Reporter;
use meniscus::particles::sequence::{self, FrameSelection, SequenceError};
use meniscus::scene::Scene;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime};

/// How often the folder is looked at.
const POLL: Duration = Duration::from_millis(100);
/// A file that stays as it is for so long is believed to be written.
const SETTLED: Duration = Duration::from_millis(600);
/// One that was changed so long ago needs no such proof.
const OLD: Duration = Duration::from_secs(3);
/// An unreadable file that stays as it is for so long, with later ones beside it, is given up.
const GIVEN_UP: Duration = Duration::from_secs(10);

/// Size and time of each file of a frame.
type Look = Vec<(u64, SystemTime)>;

/// The frame that comes next, as it was seen last.
struct Candidate {
    number: u64,
    look: Look,
    since: Instant,
    /// Why it could not be read.
    refused: Option<String>,
}

/// Waits for frames.
pub(crate) struct Watch<'a> {
    /// A pattern of particle files, or a scene that names one.
    input: PathBuf,
    selection: Option<&'a FrameSelection>,
    edit: &'a (dyn Fn(&mut Scene) -> Outcome + Sync),
    /// Longest wait for a new frame.
    timeout: Option<Duration>,
    last: Option<u64>,
    candidate: Option<Candidate>,
}

impl<'a> Watch<'a> {
    /// Watches the one input.
    pub(crate) fn new(
        inputs: &[PathBuf],
        selection: Option<&'a FrameSelection>,
        edit: &'a (dyn Fn(&mut Scene) -> Outcome + Sync),
        timeout: Option<Duration>,
    ) -> Outcome<Self> {
        let wrong = || {
            Failure::wrong(
                "--watch needs one pattern of particle files, or one scene that names one",
            )
            .with_help("as in: meniscus render 'frame_{}.vtk' --watch -o 'frame_{}.png'")
        };
        let [input] = inputs else {
            return Err(wrong());
        };
        if !sequence::is_pattern(input) {
            let is_scene = input.is_file() && input::is_scene(input)?;
            let names_pattern = is_scene
                && input::edited_scene(input, edit)?
                    .surfaces
                    .iter()
                    .any(|surface| sequence::is_pattern(&surface.file));
            if !names_pattern {
                return Err(wrong());
            }
        }
        let watch = Self {
            input: input.clone(),
            selection,
            edit,
            timeout,
            last: None,
            candidate: None,
        };
        // What is wrong with the pattern is wrong now.
        watch.list()?;
        Ok(watch)
    }

    /// The next frame whose files are written; `None` when the wait is over.
    pub(crate) fn next(&mut self, reporter: &Reporter) -> Outcome<Option<FrameInput>> {
        let mut quiet_since = Instant::now();
        loop {
            interrupt::check()?;
            if let (Some(selection), Some(last)) = (self.selection, self.last)
                && last >= selection.last()
            {
                return Ok(None);
            }
            let frames = self.list()?;
            if let Some(frame) = frames.first() {
                if self.is_changed(frame) {
                    quiet_since = Instant::now();
                }
                if self.is_ready() {
                    self.last = Some(frame.number);
                    return Ok(Some(frame.clone()));
                }
                if frames.len() > 1 && self.is_hopeless(GIVEN_UP) {
                    self.give_up(reporter);
                    continue;
                }
            }
            if self
                .timeout
                .is_some_and(|timeout| quiet_since.elapsed() >= timeout)
            {
                if self.is_hopeless(Duration::ZERO) {
                    self.give_up(reporter);
                }
                return Ok(None);
            }
            std::thread::sleep(POLL);
        }
    }

    /// The frame that was given last cannot be read, for the reason `message`: it may not be whole yet.
    pub(crate) fn refuse(&mut self, frame: &FrameInput, message: String) {
        if let Some(candidate) = &mut self.candidate
            && candidate.number == frame.number
        {
            candidate.refused = Some(message);
            self.last = frame.number.checked_sub(1).filter(|_| self.last.is_some());
        }
    }

    /// Wanted frames that are there and were not given yet.
    fn list(&self) -> Outcome<Vec<FrameInput>> {
        let is_wanted = |number: u64| {
            self.last.is_none_or(|last| number > last)
                && self
                    .selection
                    .is_none_or(|selection| selection.contains(number))
        };
        if sequence::is_pattern(&self.input) {
            let files = match sequence::matches(&self.input) {
                Err(SequenceError::NoMatch { .. }) => Vec::new(),
                found => found.map_err(input::sequence_failure)?,
            };
            let files = files.into_iter().filter(|file| is_wanted(file.number));
            // One that may be next and one more, to know that there is a later one.
            return files
                .take(2)
                .map(|file| input::frame_of(file, self.edit))
                .collect();
        }
        let scene = input::edited_scene(&self.input, self.edit)?;
        let mut frames = input::frames_there_of(scene)?;
        frames.retain(|frame| is_wanted(frame.number));
        Ok(frames)
    }

    /// Looks at a frame's files; whether they are new or other than before.
    fn is_changed(&mut self, frame: &FrameInput) -> bool {
        let look: Option<Look> = frame.files.iter().map(|path| look_at(path)).collect();
        let look = look.unwrap_or_default();
        if let Some(candidate) = &self.candidate
            && candidate.number == frame.number
            && candidate.look == look
        {
            return false;
        }
        self.candidate = Some(Candidate {
            number: frame.number,
            look,
            since: Instant::now(),
            refused: None,
        });
        true
    }

    fn is_ready(&self) -> bool {
        let Some(candidate) = &self.candidate else {
            return false;
        };
        let now = SystemTime::now();
        let is_old = |(_, changed): &(u64, SystemTime)| {
            now.duration_since(*changed).is_ok_and(|age| age >= OLD)
        };
        let is_settled = candidate.since.elapsed() >= SETTLED || candidate.look.iter().all(is_old);
        let is_there =
            !candidate.look.is_empty() && candidate.look.iter().all(|(size, _)| *size > 0);
        is_there && is_settled && candidate.refused.is_none()
    }

    fn is_hopeless(&self, patience: Duration) -> bool {
        let candidate = self.candidate.as_ref();
        candidate.is_some_and(|c| c.refused.is_some() && c.since.elapsed() >= patience)
    }

    fn give_up(&mut self, reporter: &Reporter) {
        if let Some(candidate) = self.candidate.take()
            && let Some(reason) = candidate.refused
        {
            reporter.warn(&format!("frame {} is left out: {reason}", candidate.number));
            self.last = Some(candidate.number);
        }
    }
}

fn look_at(path: &Path) -> Option<(u64, SystemTime)> {
    let found = path.metadata().ok()?;
    Some((found.len(), found.modified().ok()?))
}
