//! Where results go: standard output, or a file that is there whole or not at all.

use std::fs::OpenOptions;
use std::io::{ErrorKind, Result, Write};
use std::path::{Path, PathBuf};

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
        match is_replaced(path) {
            true => tempfile::tempfile_in(folder_of(path)).map(drop),
            false => Ok(()),
        }
    }

    /// Writes all of `text`. A file is replaced when the text is whole; what is no regular file is written directly. A reader who has left is
    /// no failure.
    ///
    /// # Errors
    /// What the operating system says.
    pub fn write(&self, text: &str) -> Result<()> {
        match self {
            Output::Standard => {
                let mut standard = std::io::stdout().lock();
                let written = standard.write_all(text.as_bytes()).and_then(|()| standard.flush());
                match written {
                    Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
                    written => written,
                }
            }
            Output::File(path) if is_replaced(path) => {
                let mut builder = tempfile::Builder::new();
                // Readable for all whom the user's mask lets read, as any file that a program creates.
                #[cfg(unix)]
                builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
                let mut file = builder.suffix(".partial").tempfile_in(folder_of(path))?;
                file.write_all(text.as_bytes())?;
                file.as_file().sync_all()?;
                file.persist(path).map(drop).map_err(|error| error.error)
            }
            Output::File(path) => {
                let written = OpenOptions::new()
                    .write(true)
                    .open(path)
                    .and_then(|mut file| file.write_all(text.as_bytes()));
                match written {
                    Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
                    written => written,
                }
            }
        }
    }
}

/// Whether it is a regular file, or none yet.
fn is_replaced(path: &Path) -> bool {
    path.metadata().map_or(true, |metadata| metadata.is_file())
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}
