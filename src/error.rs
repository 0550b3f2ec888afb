//! The one error type of the library.
//!
//! Every error says what is wrong, where, the value found and the legal range. The program turns any of
//! them into exit code 2.

use std::path::{Path, PathBuf};

/// Result of every fallible function of the library.
pub type Result<T> = std::result::Result<T, Error>;

/// What can go wrong.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused to read or write a file.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder concerned.
        path: PathBuf,
        /// The cause.
        source: std::io::Error,
    },
    /// The input contradicts itself or the format it claims to be.
    #[error("{0}")]
    Invalid(Fault),
    /// The input is legal, but this version does not handle it.
    #[error("{0} (not supported)")]
    Unsupported(Fault),
    /// A numerical method ended without an answer of the promised accuracy.
    #[error("{0} (did not converge)")]
    NotConverged(Fault),
    /// No GPU, one that can't do what is needed, or one whose driver complains.
    #[error("{0} (GPU)")]
    Gpu(Fault),
}

/// Place and nature of a fault.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Where: file, part, pixel, key, argument; outermost first, joined by `: `.
    pub place: String,
    /// What is wrong, in a few words.
    pub what: String,
    /// The value found.
    pub found: String,
    /// The legal values.
    pub legal: String,
}

impl std::fmt::Display for Fault {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if !self.place.is_empty() {
            write!(f, "{}: ", self.place)?;
        }
        write!(f, "{}: found {}, expected {}", self.what, self.found, self.legal)
    }
}

impl Fault {
    fn new(
        place: impl Into<String>,
        what: impl Into<String>,
        found: impl ToString,
        legal: impl Into<String>,
    ) -> Self {
        Self { place: place.into(), what: what.into(), found: found.to_string(), legal: legal.into() }
    }
}

impl Error {
    /// Input that contradicts itself or its format.
    pub fn invalid(
        place: impl Into<String>,
        what: impl Into<String>,
        found: impl ToString,
        legal: impl Into<String>,
    ) -> Self {
        Self::Invalid(Fault::new(place, what, found, legal))
    }

    /// Legal input that this version does not handle.
    pub fn unsupported(
        place: impl Into<String>,
        what: impl Into<String>,
        found: impl ToString,
        legal: impl Into<String>,
    ) -> Self {
        Self::Unsupported(Fault::new(place, what, found, legal))
    }

    /// A method that ended short of its promised accuracy.
    pub fn not_converged(
        place: impl Into<String>,
        what: impl Into<String>,
        found: impl ToString,
        legal: impl Into<String>,
    ) -> Self {
        Self::NotConverged(Fault::new(place, what, found, legal))
    }

    /// A GPU that is missing, short of something, or at fault.
    pub fn gpu(
        place: impl Into<String>,
        what: impl Into<String>,
        found: impl ToString,
        legal: impl Into<String>,
    ) -> Self {
        Self::Gpu(Fault::new(place, what, found, legal))
    }

    /// A refusal of the operating system concerning `path`.
    pub fn io(path: impl AsRef<Path>, source: std::io::Error) -> Self {
        Self::Io { path: path.as_ref().to_owned(), source }
    }

    /// The same error, with an outer place (usually the file) put in front.
    #[must_use]
    pub fn within(mut self, outer: impl std::fmt::Display) -> Self {
        match &mut self {
            Self::Io { .. } => (),
            Self::Invalid(fault)
            | Self::Unsupported(fault)
            | Self::NotConverged(fault)
            | Self::Gpu(fault) => {
                fault.place = if fault.place.is_empty() {
                    outer.to_string()
                } else {
                    format!("{outer}: {}", fault.place)
                };
            }
        }
        self
    }

    /// [`Error::within`] for the path of a file.
    #[must_use]
    pub fn in_file(self, path: &Path) -> Self {
        self.within(path.display())
    }
}
