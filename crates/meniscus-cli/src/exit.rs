//! How a command ends.

use crate::report::Message;

/// Why a command did not succeed.
#[derive(Debug)]
pub(crate) enum Failure {
    /// The command line or the scene is wrong.
    Wrong(Box<Message>),
    /// The work failed: files, devices.
    Work(Box<Message>),
    /// Somebody pressed Ctrl-C.
    Interrupted,
}

/// What commands return.
pub(crate) type Outcome<T = ()> = Result<T, Failure>;

impl Failure {
    /// The command line or the scene is wrong.
    pub(crate) fn wrong(text: impl Into<String>) -> Self {
        Self::Wrong(Box::new(Message::new(text)))
    }

    /// The work failed.
    pub(crate) fn work(text: impl Into<String>) -> Self {
        Self::Work(Box::new(Message::new(text)))
    }

    /// A known word for something that this version cannot do.
    pub(crate) fn not_yet(what: &str, available: &str) -> Self {
        Self::wrong(format!("not available yet: {what}"))
            .with_help(format!("available: {available}"))
    }

    /// The same with advice.
    #[must_use]
    pub(crate) fn with_help(self, help: impl Into<String>) -> Self {
        let add = |mut message: Box<Message>| {
            message.help = Some(help.into());
            message
        };
        match self {
            Self::Wrong(message) => Self::Wrong(add(message)),
            Self::Work(message) => Self::Work(add(message)),
            Self::Interrupted => Self::Interrupted,
        }
    }

    /// The process's exit code.
    pub(crate) fn code(&self) -> u8 {
        match self {
            Self::Work(_) => 1,
            Self::Wrong(_) => 2,
            Self::Interrupted => 130,
        }
    }

    /// What to print.
    pub(crate) fn message(&self) -> Option<&Message> {
        match self {
            Self::Wrong(message) | Self::Work(message) => Some(message),
            Self::Interrupted => None,
        }
    }
}
