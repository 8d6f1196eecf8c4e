//! Where results go: standard output, or a file that is there whole or not at all.

use std::fs::{File, OpenOptions, Permissions};
use std::io::{ErrorKind, Result, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

/// A place for a result.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Output {
    /// Standard output.
    Standard,
    /// A file.
    File(PathBuf),
}

impl Output {
    /// Its name in errors.
    pub fn name(&self) -> String {
        match self {
            Output::Standard => "standard output".into(),
            Output::File(path) => path.display().to_string(),
        }
    }

    /// Whether something can be written there, before the work is done.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn check(&self) -> Result<()> {
        let Output::File(path) = self else { return Ok(()) };
        if path.is_dir() {
            return Err(ErrorKind::IsADirectory.into());
        }
        match replaced(path) {
            Some(path) => tempfile::tempfile_in(folder_of(&path)).map(drop),
            None => Ok(()),
        }
    }

    /// Opens it for a result that comes in parts.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn open(&self) -> Result<Sink> {
        let Output::File(path) = self else { return Ok(Sink::Standard) };
        let Some(path) = replaced(path) else {
            return Ok(Sink::Direct(OpenOptions::new().write(true).open(path)?));
        };
        let mut builder = tempfile::Builder::new();
        // Readable for all whom the user's mask lets read, as any file that a program creates.
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        let part = builder.suffix(".partial").tempfile_in(folder_of(&path))?;
        let kept = path.metadata().ok().map(|metadata| metadata.permissions());
        Ok(Sink::Replaced { part, path, kept })
    }

    /// Writes all of `text`. A file is replaced when the text is whole; what is no regular file is written directly. A reader who has left is
    /// no failure.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn write(&self, text: &str) -> Result<()> {
        let mut sink = self.open()?;
        sink.write(text)?;
        sink.finish()
    }
}

/// A result on its way. What is dropped before [`Sink::finish`] leaves a file as it was.
#[derive(Debug)]
pub enum Sink {
    /// To standard output.
    Standard,
    /// To what is no regular file: a device or a pipe.
    Direct(File),
    /// To a file that takes the place of another in the end.
    Replaced {
        /// What is there so far.
        part: NamedTempFile,
        /// Its place.
        path: PathBuf,
        /// The permissions of the file that is there now, which stay.
        kept: Option<Permissions>,
    },
}

impl Sink {
    /// Writes `text` at once. Says whether anybody still reads.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn write(&mut self, text: &str) -> Result<bool> {
        let written = match self {
            Sink::Standard => {
                let mut standard = std::io::stdout().lock();
                standard.write_all(text.as_bytes()).and_then(|()| standard.flush())
            }
            Sink::Direct(file) => file.write_all(text.as_bytes()),
            Sink::Replaced { part, .. } => part.as_file_mut().write_all(text.as_bytes()),
        };
        match written {
            Ok(()) => Ok(true),
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(false),
            Err(error) => Err(error),
        }
    }

    /// Puts the whole result in its place.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn finish(self) -> Result<()> {
        let Sink::Replaced { part, path, kept } = self else { return Ok(()) };
        if let Some(permissions) = kept {
            part.as_file().set_permissions(permissions)?;
        }
        part.as_file().sync_all()?;
        part.persist(path).map(drop).map_err(|refused| refused.error)
    }
}

/// Names of what a process has open.
const OPEN_ALREADY: [&str; 4] = ["/dev/stdout", "/dev/stderr", "/dev/fd", "/proc"];

/// The file that a path leads to if it is a regular one, or none yet; links are followed, so that they stay links.
fn replaced(path: &Path) -> Option<PathBuf> {
    match path.metadata() {
        // What the process has open already, as its standard output, is written to whatever lies behind it.
        _ if OPEN_ALREADY.iter().any(|folder| path.starts_with(folder)) => None,
        Ok(metadata) if metadata.is_file() => path.canonicalize().ok(),
        Ok(_) => None,
        // A link to a file that is not there yet.
        Err(_) => Some(path.read_link().map_or(path.into(), |target| folder_of(path).join(target))),
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
