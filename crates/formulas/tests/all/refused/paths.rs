//! Files that cannot be read: catches bad input that is called a failure of input or output, and the other way round.

use std::path::Path;

use motes_formulas::{FileError, read};

use super::FILE;

/// A folder with a file of these bytes in it.
fn written(bytes: &[u8]) -> (tempfile::TempDir, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("walk.toml");
    std::fs::write(&path, bytes).unwrap();
    (folder, path)
}

fn refused(path: &Path) -> FileError {
    read(path, &[]).unwrap_err()
}

/// The line of an error, in which the temporary folder has a name.
fn line(error: &FileError, folder: &Path) -> String {
    error.to_string().replace(&folder.display().to_string(), "models")
}

#[test]
fn what_is_not_there() {
    let error = refused(Path::new("no/such.toml"));
    assert!(error.is_io());
    insta::assert_snapshot!(error, @"no/such.toml: there is no such file");
}

#[test]
fn a_folder() {
    let (folder, _path) = written(b"");
    let error = refused(folder.path());
    assert!(error.is_io());
    insta::assert_snapshot!(line(&error, folder.path()), @"models: this is a folder; a model is a file");
}

#[test]
fn bytes_that_are_no_text() {
    let (folder, path) = written(b"name = \"m\"\nb\xff\n");
    let error = refused(&path);
    assert!(!error.is_io());
    insta::assert_snapshot!(line(&error, folder.path()), @"models/walk.toml, line 2, column 2: this is no UTF-8 text; a model file must be");
}

/// Marks at the start and line ends of another system are no errors, and move no column.
#[test]
fn a_mistake_in_a_file_of_another_system() {
    let text = FILE.replace("name = \"m\"\n", "").replace('\n', "\r\n");
    let (_folder, path) = written(format!("\u{feff}{text}").as_bytes());
    let file = read(&path, &[]).unwrap();
    assert_eq!((file.name.as_str(), file.states), ("walk", vec!["x".to_string()]));
    let (folder, path) = written(format!("\u{feff}{}", text.replace("(x, q)", "(x, s)")).as_bytes());
    insta::assert_snapshot!(line(&refused(&path), folder.path()), @"models/walk.toml, line 6, column 16, [transition] x: `s` is not known here; known are q, x, t, pi");
}
