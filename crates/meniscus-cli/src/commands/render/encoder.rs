//! Pictures to H.264 in MP4 by the program ffmpeg.

use crate::exit::{Failure, Outcome};
use crate::interrupt;
use std::collections::VecDeque;
use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::Duration;

/// The program.
const PROGRAM: &str = "ffmpeg";
/// Its last lines that are worth reading when it fails.
const LAST_LINES: usize = 6;
/// Constant rate factor of x264: below 18 no loss is seen, and thin splashes keep their edges.
const RATE_FACTOR: &str = "16";
/// How often a waiting end looks for Ctrl-C.
const POLL: Duration = Duration::from_millis(20);

/// A running ffmpeg that takes PNG files, one after the other, on its standard input.
pub(super) struct Encoder {
    child: Child,
    input: Option<ChildStdin>,
    words: Option<JoinHandle<String>>,
    output: PathBuf,
}

impl Encoder {
    /// Starts ffmpeg, which writes `output` from now on.
    pub(super) fn start(output: &Path, fps: f64) -> Outcome<Self> {
        let mut command = Command::new(PROGRAM);
        command
            .args(["-hide_banner", "-nostdin", "-loglevel", "error", "-y"])
            .args(["-f", "image2pipe", "-c:v", "png"])
            .args(["-framerate", &fps.to_string(), "-i", "pipe:0"])
            .args(["-c:v", "libx264", "-preset", "medium", "-crf", RATE_FACTOR])
            // 4:2:0 is what every player shows, and it takes even sizes only.
            .args(["-pix_fmt", "yuv420p", "-vf"])
            .arg(
                "crop=trunc(iw/2)*2:trunc(ih/2)*2:0:0,\
                 scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_int",
            )
            .args(["-color_primaries", "bt709", "-color_trc", "bt709"])
            .args(["-colorspace", "bt709", "-color_range", "tv"])
            .args(["-movflags", "+faststart", "-f", "mp4"])
            .arg(output)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        #[cfg(unix)]
        {
            use std::os::unix::process::CommandExt;
            // A terminal's Ctrl-C is for us, who decide what becomes of the film.
            command.process_group(0);
        }
        let mut child = command.spawn().map_err(cannot_start)?;
        let words = child.stderr.take().map(|stderr| {
            std::thread::spawn(move || {
                let mut last = VecDeque::new();
                for line in BufReader::new(stderr).lines().map_while(Result::ok) {
                    if last.len() == LAST_LINES {
                        last.pop_front();
                    }
                    last.push_back(line);
                }
                Vec::from(last).join("\n    ")
            })
        });
        Ok(Self {
            input: child.stdin.take(),
            child,
            words,
            output: output.to_owned(),
        })
    }

    /// Encodes a picture, the content of a PNG file.
    pub(super) fn push(&mut self, png: &[u8]) -> Outcome {
        let written = match &mut self.input {
            Some(input) => input.write_all(png),
            None => Ok(()),
        };
        // It closes its end when it fails, and says why on standard error.
        written.or_else(|_| self.finish(false))
    }

    /// Ends the film, in spite of Ctrl-C if `is_sure`; without an error it is whole.
    pub(super) fn finish(&mut self, is_sure: bool) -> Outcome {
        let was_closed = self.input.take().is_none();
        let status = self.wait(is_sure)?;
        if status.success() && !was_closed {
            return Ok(());
        }
        let words = self.words.take().and_then(|words| words.join().ok());
        let words = words.filter(|words| !words.is_empty());
        let words = words.map_or_else(
            || "it gave no reason".to_owned(),
            |w| format!("it said:\n    {w}"),
        );
        Err(
            Failure::work(format!("{PROGRAM} failed ({status}); {words}"))
                .with_help("write pictures instead: -o 'frame_{}.png'"),
        )
    }

    fn wait(&mut self, is_sure: bool) -> Outcome<ExitStatus> {
        let failed = |error: std::io::Error| Failure::work(format!("{PROGRAM}: {error}"));
        loop {
            if let Some(status) = self.child.try_wait().map_err(failed)? {
                return Ok(status);
            }
            if !is_sure {
                interrupt::check()?;
            }
            std::thread::sleep(POLL);
        }
    }

    /// Ends an ffmpeg that still runs and takes away what it has written; a finished film has another
    /// name by now.
    pub(super) fn stop(&mut self) {
        self.input = None;
        if let Ok(None) = self.child.try_wait() {
            let _ = self.child.kill();
            let _ = self.child.wait();
        }
        let _ = std::fs::remove_file(&self.output);
    }
}

impl Drop for Encoder {
    fn drop(&mut self) {
        self.stop();
    }
}

fn cannot_start(error: std::io::Error) -> Failure {
    if error.kind() == std::io::ErrorKind::NotFound {
        return Failure::work(format!(
            "the program {PROGRAM}, which makes .mp4, is not there"
        ))
        .with_help(
            "install it (Debian: apt install ffmpeg), or write pictures: -o 'frame_{}.png'",
        );
    }
    Failure::work(format!("cannot start {PROGRAM}: {error}"))
}
