//! Error messages: one sentence, a caret under the place where there is one, what to do.

use miette::{
    GraphicalReportHandler, GraphicalTheme, LabeledSpan, NamedSource, Severity, SourceCode,
};
use std::io::IsTerminal;
use std::ops::Range;

/// What is said about a failure.
#[derive(Debug)]
pub(crate) struct Message {
    /// What is wrong, in one sentence.
    pub text: String,
    /// What to do about it.
    pub help: Option<String>,
    /// The text that holds the mistake.
    pub excerpt: Option<Excerpt>,
}

/// A place in a text.
#[derive(Debug)]
pub(crate) struct Excerpt {
    source: NamedSource<String>,
    span: Range<usize>,
}

impl Excerpt {
    /// Points at bytes `span` of `text`, which is called `name`. Where something is missing the span
    /// is empty: the caret then stands under the place after the text before it.
    pub(crate) fn new(name: &str, text: &str, span: Range<usize>) -> Self {
        let mut text = text.to_owned();
        let mut span = span;
        if span.is_empty() {
            if span.start == text.len() {
                text.push(' ');
            }
            span.end = text.ceil_char_boundary(span.start + 1);
        }
        Self {
            source: NamedSource::new(name, text),
            span,
        }
    }
}

impl Message {
    /// A message without place or advice.
    pub(crate) fn new(text: impl Into<String>) -> Self {
        Self {
            text: text.into(),
            help: None,
            excerpt: None,
        }
    }

    /// The message as printed, with a line break at the end.
    pub(crate) fn rendered(&self) -> String {
        let Some(excerpt) = &self.excerpt else {
            let help = self.help.as_ref();
            let help = help.map_or_else(String::new, |help| format!("  help: {help}\n"));
            return format!("error: {}\n{help}", self.text);
        };
        let styled = std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none();
        let theme = if styled {
            GraphicalTheme::unicode()
        } else {
            GraphicalTheme::none()
        };
        let handler = GraphicalReportHandler::new_themed(theme)
            .without_cause_chain()
            .with_wrap_lines(false)
            .with_context_lines(1);
        let mut out = String::new();
        let located = Located {
            message: self,
            excerpt,
        };
        match handler.render_report(&mut out, &located) {
            Ok(()) => format!("error: {}\n", out.trim_start_matches(['\n', ' ', 'x', '×'])),
            Err(_) => format!("error: {}\n", self.text),
        }
    }
}

/// A message with a place, as miette draws it.
#[derive(Debug)]
struct Located<'a> {
    message: &'a Message,
    excerpt: &'a Excerpt,
}

impl std::fmt::Display for Located<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message.text)
    }
}

impl std::error::Error for Located<'_> {}

impl miette::Diagnostic for Located<'_> {
    fn severity(&self) -> Option<Severity> {
        Some(Severity::Error)
    }

    fn help<'b>(&'b self) -> Option<Box<dyn std::fmt::Display + 'b>> {
        let help = self.message.help.as_ref()?;
        Some(Box::new(help))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        Some(&self.excerpt.source)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let label = LabeledSpan::new(None, self.excerpt.span.start, self.excerpt.span.len());
        Some(Box::new(std::iter::once(label)))
    }
}
