use super::*;

/// The names in a directory. A temporary file that was left behind would be among them.
fn names(directory: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_file_is_created_or_replaced() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("out");
    for content in ["long content", "short"] {
        write_atomically(&path, |out| out.write_all(content.as_bytes())).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), content);
    }
    assert_eq!(names(directory.path()), ["out"]);
}

#[test]
fn a_failed_write_changes_nothing() {
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
fn errors_name_the_path() {
    let directory = tempfile::tempdir().unwrap();
    let message = |path: &Path| write_atomically(path, |_| Ok(())).unwrap_err().to_string();
    let missing = directory.path().join("no/out");
    assert_eq!(
        message(&missing),
        format!("cannot write {}: there is no directory {}", missing.display(), directory.path().join("no").display())
    );
    assert!(message(directory.path()).starts_with(&format!("cannot write {}: ", directory.path().display())));
    assert!(message(Path::new("")).starts_with("cannot write : "));
}

#[test]
fn no_temporary_file_exists_while_writes_are_held() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("out");
    let held = hold_writes();
    assert!(!held.contains(&path));
    let writer = std::thread::spawn({
        let path = path.clone();
        move || write_atomically(&path, |out| out.write_all(b"content"))
    });
    std::thread::sleep(std::time::Duration::from_millis(50));
    assert!(names(directory.path()).is_empty());
    drop(held);
    writer.join().unwrap().unwrap();
    assert!(hold_writes().contains(&path));
}

#[cfg(feature = "study")]
fn files(names: &[&str]) -> Vec<(String, Vec<u8>)> {
    names.iter().map(|name| ((*name).to_owned(), name.as_bytes().to_vec())).collect()
}

#[test]
fn write_together_writes_all_files_or_none() {
    let directory = tempfile::tempdir().unwrap();
    let folder = directory.path();
    let write = |names: &[&'static str]| {
        let content = |name: &'static str| move |out: &mut dyn Write| out.write_all(name.as_bytes());
        write_together(folder, names.iter().map(|name| (folder.join(name), content(name))))
    };
    fs::write(folder.join("b"), "old").unwrap();
    fs::write(folder.join("other"), "kept").unwrap();
    let error = write(&["a", "b", "no/c"]).unwrap_err().to_string();
    assert!(error.contains("no/c: there is no directory"), "{error}");
    assert_eq!(
        (names(folder), fs::read_to_string(folder.join("b")).unwrap()),
        (vec!["b".into(), "other".into()], "old".into())
    );
    write(&["a", "b"]).unwrap();
    assert_eq!(names(folder), ["a", "b", "other"]);
    assert_eq!(fs::read_to_string(folder.join("b")).unwrap(), "b");
    assert!(hold_writes().contains(&folder.to_owned()));
}

#[cfg(feature = "study")]
#[test]
fn a_new_folder_appears_with_all_files_or_not_at_all() {
    let directory = tempfile::tempdir().unwrap();
    let parent = directory.path().join("reports");
    let folder = parent.join("new");
    let error = write_new_folder(&folder, &files(&["a", "no/b"])).unwrap_err().to_string();
    assert!(error.starts_with(&format!("cannot write {}: ", folder.join("no/b").display())), "{error}");
    assert!(names(directory.path()).is_empty(), "the parent folder is removed too");
    write_new_folder(&folder, &files(&["a", "b"])).unwrap();
    assert_eq!((names(&parent), names(&folder)), (vec!["new".to_owned()], vec!["a".into(), "b".into()]));
    let error = write_new_folder(&folder, &files(&["c"])).unwrap_err().to_string();
    assert_eq!(names(&folder), ["a", "b"], "an existing folder is not changed");
    let kept = names(&parent).remove(0);
    assert!(
        kept.starts_with(TEMPORARY_PREFIX)
            && error.contains(&format!("it exists by now; the new files are in {}", parent.join(&kept).display())),
        "{error}"
    );
    assert_eq!(names(&parent.join(kept)), ["c"]);
}

#[test]
fn an_output_can_be_checked_before_it_is_written() {
    let directory = tempfile::tempdir().unwrap();
    let [new, old, input] = ["new", "old", "input"].map(|name| directory.path().join(name));
    fs::write(&old, "kept").unwrap();
    fs::write(&input, "").unwrap();
    Input::open(&input, 0).unwrap();
    check_output(&new).unwrap();
    check_output(&old).unwrap();
    assert_eq!((fs::read_to_string(&old).unwrap(), names(directory.path()).len()), ("kept".into(), 2));
    for (path, reason) in [
        (input.clone(), "it is also an input"),
        (directory.path().join("no/out"), "there is no directory"),
        (directory.path().to_owned(), "directory"),
        (input.join("below"), ""),
    ] {
        let error = check_output(&path).unwrap_err().to_string();
        assert!(error.starts_with(&format!("cannot write {}: ", path.display())), "{error}");
        assert!(error.contains(reason), "{error}");
    }
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};

    use super::*;

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o777
    }

    #[test]
    fn new_files_get_ordinary_permissions_and_old_ones_keep_theirs() {
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
    fn a_symbolic_link_stays_a_link() {
        let directory = tempfile::tempdir().unwrap();
        let [link, target] = ["link", "target"].map(|name| directory.path().join(name));
        symlink("target", &link).unwrap();
        // The first time, the target does not exist yet.
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

    /// Uses its own pipe: as root, a broken `write_atomically` would replace `/dev/null` for the whole machine.
    #[test]
    fn a_pipe_is_written_and_not_replaced() {
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
    fn a_pipe_that_is_not_read_does_not_block_other_writes() {
        let directory = tempfile::tempdir().unwrap();
        let pipe = directory.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let writer = std::thread::spawn({
            let pipe = pipe.clone();
            move || write_atomically(&pipe, |out| out.write_all(&[0; 1 << 20]))
        });
        let mut reader = File::open(&pipe).unwrap();
        io::Read::read_exact(&mut reader, &mut [0]).unwrap();
        // The writer now waits, since the rest does not fit into the pipe. Other tests write at the same time
        // and may hold the lock, so try more than once.
        let mut tries = (0..1000).map(|_| {
            std::thread::sleep(std::time::Duration::from_millis(10));
            WRITTEN.try_lock().is_ok_and(|written| written.contains(&pipe))
        });
        assert!(tries.any(|free| free));
        drop(reader);
        writer.join().unwrap().unwrap_err();
    }

    #[cfg(feature = "study")]
    #[test]
    fn new_folders_get_ordinary_permissions() {
        let directory = tempfile::tempdir().unwrap();
        let [ordinary, new] = ["ordinary", "new"].map(|name| directory.path().join(name));
        fs::create_dir(&ordinary).unwrap();
        write_new_folder(&new, &files(&["a"])).unwrap();
        assert_eq!(mode(&new), mode(&ordinary));
    }

    #[test]
    fn a_full_disk_is_an_error_even_at_the_last_flush() {
        let Ok(full) = OpenOptions::new().append(true).open("/dev/full") else { return };
        let few_bytes = write_buffered(full, |out| out.write_all(b"few"));
        assert_eq!(few_bytes.unwrap_err().kind(), ErrorKind::StorageFull);
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn an_open_file_is_appended_to() {
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
