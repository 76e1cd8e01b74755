//! Files that are written completely or not at all.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, ErrorKind, Write};
use std::path::{Path, PathBuf};

use super::error::Error;

/// Names of files that are already open. Whoever opened them holds on to them, so they cannot be replaced, even where
/// they are regular files (`raylanes … -o /dev/stdout >> log`).
const OPEN_FILES: [&str; 4] = ["/dev/stdout", "/dev/stderr", "/dev/fd", "/proc"];

/// Writes a file by way of a temporary one beside it, which takes its place only when everything is written: a failure
/// leaves behind neither half a file nor a damaged old one. Permissions are those of an ordinary new file, or those of
/// the file that is replaced; through a symbolic link, the file it points to is replaced.
///
/// Devices, pipes and standard output cannot be replaced, so these are written directly.
///
/// This guards against errors, not against a power failure: nothing waits for the disk.
///
/// # Errors
/// If the file cannot be made or written, also at the last flush, or if `write` fails.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Error> {
    // Appending alters nothing yet, and lets the system judge whether this file may be written.
    let written = match OpenOptions::new().append(true).open(path) {
        Ok(file) => replace_or_append(path, file, write),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            destination(path).and_then(|destination| write_beside(&destination, None, write))
        }
        Err(error) => Err(error),
    };
    written.map_err(Error::writing(path))
}

fn replace_or_append(
    path: &Path,
    existing: File,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let metadata = existing.metadata()?;
    if metadata.is_file() && !OPEN_FILES.iter().any(|open| path.starts_with(open)) {
        write_beside(&destination(path)?, Some(metadata.permissions()), write)
    } else {
        write_buffered(existing, write)
    }
}

/// Where links lead, also when no file is there yet.
fn destination(path: &Path) -> io::Result<PathBuf> {
    match fs::canonicalize(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => match fs::read_link(path) {
            // A circle of links is a different error, so this ends.
            Ok(target) => destination(&path.parent().unwrap_or(Path::new("")).join(target)),
            Err(_) => Ok(path.to_owned()),
        },
        resolved => resolved,
    }
}

fn write_beside(
    destination: &Path,
    permissions: Option<fs::Permissions>,
    write: impl FnOnce(&mut dyn Write) -> io::Result<()>,
) -> io::Result<()> {
    let directory = match destination.parent() {
        Some(parent) if parent != "" => parent,
        _ => Path::new("."),
    };
    if !directory.is_dir() {
        return Err(io::Error::new(ErrorKind::NotFound, format!("there is no directory {}", directory.display())));
    }
    // Opened by us, since tempfile would make it readable by its owner alone, and would put its name into messages.
    let mut temporary = tempfile::Builder::new()
        .prefix(".raylanes-")
        .make_in(directory, |name| OpenOptions::new().write(true).create_new(true).open(name))?;
    if let Some(permissions) = permissions {
        temporary.as_file().set_permissions(permissions)?;
    }
    write_buffered(temporary.as_file_mut(), write)?;
    temporary.persist(destination).map_err(|error| error.error)?;
    Ok(())
}

fn write_buffered(file: impl Write, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    let mut buffered = BufWriter::new(file);
    write(&mut buffered)?;
    buffered.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names in a directory: a left-over temporary file would be among them.
    fn names(directory: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_made_or_replaced() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("out");
        for content in ["long content", "short"] {
            write_atomically(&path, |out| out.write_all(content.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), content);
        }
        assert_eq!(names(directory.path()), ["out"]);
    }

    #[test]
    fn a_failed_write_leaves_everything_as_it_was() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("out");
        let fail = || {
            write_atomically(&path, |out| {
                out.write_all(&[b'x'; 100_000])?;
                Err(io::Error::other("the writer failed"))
            })
        };
        assert_eq!(fail().unwrap_err().to_string(), format!("cannot write {}: the writer failed", path.display()));
        assert!(names(directory.path()).is_empty());
        fs::write(&path, "old").unwrap();
        fail().unwrap_err();
        assert_eq!(fs::read_to_string(&path).unwrap(), "old");
        assert_eq!(names(directory.path()), ["out"]);
    }

    #[test]
    fn impossible_targets_are_named() {
        let directory = tempfile::tempdir().unwrap();
        let message = |path: &Path| write_atomically(path, |_| Ok(())).unwrap_err().to_string();
        let missing = directory.path().join("no/out");
        assert_eq!(
            message(&missing),
            format!(
                "cannot write {}: there is no directory {}",
                missing.display(),
                directory.path().join("no").display()
            )
        );
        assert!(message(directory.path()).starts_with(&format!("cannot write {}: ", directory.path().display())));
        assert!(message(Path::new("")).starts_with("cannot write : "));
    }

    #[cfg(unix)]
    mod unix {
        use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};

        use super::*;

        fn mode(path: &Path) -> u32 {
            fs::metadata(path).unwrap().permissions().mode() & 0o777
        }

        #[test]
        fn permissions_are_ordinary_or_kept() {
            let directory = tempfile::tempdir().unwrap();
            let [ordinary, new] = ["ordinary", "new"].map(|name| directory.path().join(name));
            File::create(&ordinary).unwrap();
            write_atomically(&new, |_| Ok(())).unwrap();
            assert_eq!(mode(&new), mode(&ordinary));
            fs::set_permissions(&new, fs::Permissions::from_mode(0o640)).unwrap();
            write_atomically(&new, |_| Ok(())).unwrap();
            assert_eq!(mode(&new), 0o640);
        }

        #[test]
        fn links_stay_links() {
            let directory = tempfile::tempdir().unwrap();
            let [link, target] = ["link", "target"].map(|name| directory.path().join(name));
            symlink("target", &link).unwrap();
            // At first the link dangles.
            for content in ["first", "second"] {
                write_atomically(&link, |out| out.write_all(content.as_bytes())).unwrap();
                assert_eq!(fs::read_to_string(&target).unwrap(), content);
                assert_eq!(fs::read_link(&link).unwrap(), Path::new("target"));
            }
            let circle = directory.path().join("circle");
            symlink("circle", &circle).unwrap();
            write_atomically(&circle, |_| Ok(())).unwrap_err();
            assert_eq!(names(directory.path()), ["circle", "link", "target"]);
        }

        /// With a pipe of its own: as root, a broken `write_atomically` would replace `/dev/null` for the whole machine.
        #[test]
        fn pipes_are_written_not_replaced() {
            let directory = tempfile::tempdir().unwrap();
            let pipe = directory.path().join("pipe");
            assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
            let reader = std::thread::spawn({
                let pipe = pipe.clone();
                move || fs::read_to_string(pipe).unwrap()
            });
            write_atomically(&pipe, |out| out.write_all(b"content")).unwrap();
            assert_eq!(reader.join().unwrap(), "content");
            assert!(fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo());
        }

        #[test]
        fn a_full_disk_is_an_error_even_at_the_last_flush() {
            let Ok(full) = OpenOptions::new().append(true).open("/dev/full") else { return };
            let few_bytes = write_buffered(full, |out| out.write_all(b"few"));
            assert_eq!(few_bytes.unwrap_err().kind(), ErrorKind::StorageFull);
        }

        #[cfg(target_os = "linux")]
        #[test]
        fn open_files_are_appended_to() {
            use std::os::fd::AsRawFd;

            let directory = tempfile::tempdir().unwrap();
            let path = directory.path().join("log");
            fs::write(&path, "before ").unwrap();
            let log = OpenOptions::new().append(true).open(&path).unwrap();
            let open = format!("/dev/fd/{}", log.as_raw_fd());
            write_atomically(Path::new(&open), |out| out.write_all(b"ours ")).unwrap();
            (&log).write_all(b"after").unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), "before ours after");
        }
    }
}
