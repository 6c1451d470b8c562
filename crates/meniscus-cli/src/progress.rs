//! Progress, notes and warnings, all on standard error.
//!
//! With `--progress json` every line is one object with the key `event`:
//! - `start`: `frames`
//! - `frame`: `frame` (its number), `index` (from 0), `output`
//! - `progress`: `index`, `stage` (`read`, `build`, `render`, `write`, `trace`), `fraction` (of the
//!   whole work), `elapsed_secs`, `remaining_secs` (an estimate, null at first)
//! - `frame_done`: `index`, `output`
//! - `warning`, `note`: `message`
//! - `done`: `elapsed_secs`

use crate::args::output::{OutputArgs, ProgressMode};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde_json::{Value, json};
use std::io::{IsTerminal, Write};
use std::path::Path;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Steps of the bar.
const RESOLUTION: u64 = 10_000;
/// Least time between two JSON lines about the same stage.
const JSON_INTERVAL: Duration = Duration::from_millis(100);

enum Display {
    Bar(ProgressBar),
    Json,
    Silent,
    /// Keeps what is said, for [`Reporter::replay`].
    Held(Mutex<Vec<Message>>),
}

/// Something said while nobody was to hear it.
enum Message {
    Warning(String),
    Note(String),
}

struct State {
    frames: usize,
    index: usize,
    stage: &'static str,
    last_line: Option<Instant>,
}

/// Says what is going on.
pub(crate) struct Reporter {
    display: Display,
    quiet: bool,
    verbose: bool,
    started: Instant,
    state: Mutex<State>,
}

impl Reporter {
    /// A reporter as the options want it.
    pub(crate) fn new(options: &OutputArgs) -> Self {
        let bar = || {
            let bar = ProgressBar::with_draw_target(Some(RESOLUTION), ProgressDrawTarget::stderr());
            let template = "{bar:32} {percent:>3}% {msg}  {elapsed_precise} gone, {eta} to go";
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style);
            }
            Display::Bar(bar)
        };
        let display = match options.progress {
            _ if options.quiet && options.progress != ProgressMode::Json => Display::Silent,
            ProgressMode::None => Display::Silent,
            ProgressMode::Json => Display::Json,
            ProgressMode::Bar => bar(),
            ProgressMode::Auto if std::io::stderr().is_terminal() => bar(),
            ProgressMode::Auto => Display::Silent,
        };
        Self {
            display,
            quiet: options.quiet,
            verbose: options.verbose,
            started: Instant::now(),
            state: Mutex::new(State {
                frames: 1,
                index: 0,
                stage: "",
                last_line: None,
            }),
        }
    }

    /// A reporter that says nothing.
    pub(crate) fn silent() -> Self {
        Self::new(&OutputArgs {
            progress: ProgressMode::None,
            quiet: true,
            verbose: false,
        })
    }

    /// A reporter for work ahead of its turn: it shows nothing and keeps warnings and notes.
    pub(crate) fn held() -> Self {
        Self {
            display: Display::Held(Mutex::default()),
            quiet: false,
            verbose: true,
            ..Self::silent()
        }
    }

    /// Says what `held` has kept.
    pub(crate) fn replay(&self, held: Self) {
        let Display::Held(messages) = held.display else {
            return;
        };
        for message in messages.into_inner().unwrap_or_default() {
            match message {
                Message::Warning(text) => self.warn(&text),
                Message::Note(text) => self.note(&text),
            }
        }
    }

    /// Something that everybody who has not asked for silence should know.
    pub(crate) fn tell(&self, message: &str) {
        if !self.quiet {
            self.line(message);
        }
    }

    /// A warning that a user should read.
    pub(crate) fn warn(&self, message: &str) {
        if let Display::Held(messages) = &self.display {
            keep(messages, Message::Warning(message.to_owned()));
        } else if let Display::Json = self.display {
            self.json_line(&json!({"event": "warning", "message": message}));
        } else if !self.quiet {
            self.line(&format!("warning: {message}"));
        }
    }

    /// Something for those who asked for more.
    pub(crate) fn note(&self, message: &str) {
        if self.verbose {
            self.line(message);
        }
    }

    /// The work has this many frames.
    pub(crate) fn start(&self, frames: usize) {
        if let Ok(mut state) = self.state.lock() {
            state.frames = frames.max(1);
        }
        if let Display::Json = self.display {
            self.json_line(&json!({"event": "start", "frames": frames}));
        }
    }

    /// Frame `index` begins.
    pub(crate) fn frame(&self, index: usize, number: u64, output: &Path) {
        if let Ok(mut state) = self.state.lock() {
            state.index = index;
        }
        match &self.display {
            Display::Json => self.json_line(&json!({
                "event": "frame", "frame": number, "index": index,
                "output": output.display().to_string(),
            })),
            Display::Bar(bar) => bar.set_message(output.display().to_string()),
            Display::Silent | Display::Held(_) => {}
        }
    }

    /// A stage of the current frame begins.
    pub(crate) fn stage(&self, stage: &'static str) {
        if let Ok(mut state) = self.state.lock() {
            state.stage = stage;
            state.last_line = None;
        }
        let fraction = match stage {
            "write" => 0.99,
            "render" | "trace" => 0.1,
            "build" => 0.03,
            _ => 0.0,
        };
        self.advance_to(fraction);
    }

    /// `done` of `total` parts of the rendering (or tracing) are done.
    pub(crate) fn advance(&self, done: u64, total: u64) {
        self.advance_to(0.1 + 0.89 * done as f64 / total.max(1) as f64);
    }

    /// `fraction` of the current frame is done.
    fn advance_to(&self, fraction: f64) {
        let Ok(mut state) = self.state.lock() else {
            return;
        };
        // Of a running simulation nobody knows how many frames come.
        let whole = ((state.index as f64 + fraction) / state.frames as f64).min(1.0);
        match &self.display {
            Display::Bar(bar) => bar.set_position((whole * RESOLUTION as f64) as u64),
            Display::Json => {
                let now = Instant::now();
                let soon = |last: Instant| now.duration_since(last) < JSON_INTERVAL;
                if state.last_line.is_some_and(soon) {
                    return;
                }
                state.last_line = Some(now);
                let elapsed = self.started.elapsed().as_secs_f64();
                let remaining = (whole > 0.0).then(|| elapsed * (1.0 - whole) / whole);
                self.json_line(&json!({
                    "event": "progress", "index": state.index, "stage": state.stage,
                    "fraction": whole, "elapsed_secs": elapsed, "remaining_secs": remaining,
                }));
            }
            Display::Silent | Display::Held(_) => {}
        }
    }

    /// Frame `index` is written.
    pub(crate) fn frame_done(&self, index: usize, output: &Path) {
        if let Display::Json = self.display {
            let output = output.display().to_string();
            self.json_line(&json!({"event": "frame_done", "index": index, "output": output}));
        }
        self.note(&format!("wrote {}", output.display()));
    }

    /// All is done.
    pub(crate) fn finish(&self) {
        let elapsed = self.started.elapsed().as_secs_f64();
        match &self.display {
            Display::Bar(bar) => bar.finish_and_clear(),
            Display::Json => self.json_line(&json!({"event": "done", "elapsed_secs": elapsed})),
            Display::Silent | Display::Held(_) => {}
        }
    }

    fn line(&self, text: &str) {
        match &self.display {
            Display::Bar(bar) => bar.suspend(|| to_stderr(text)),
            Display::Json => self.json_line(&json!({"event": "note", "message": text})),
            Display::Silent => to_stderr(text),
            Display::Held(messages) => keep(messages, Message::Note(text.to_owned())),
        }
    }

    fn json_line(&self, value: &Value) {
        to_stderr(&value.to_string());
    }
}

fn keep(messages: &Mutex<Vec<Message>>, message: Message) {
    if let Ok(mut messages) = messages.lock() {
        messages.push(message);
    }
}

/// One line; if nobody can read it there is nobody to tell.
fn to_stderr(text: &str) {
    let _ = writeln!(std::io::stderr(), "{text}");
}
