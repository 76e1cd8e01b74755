//! Too few threads, too little memory, files that are too large: one line and exit code 2.

use crate::*;

/// A limit on file sizes stands for a disk that fills up. Writing to `/dev/full` would be dangerous: a bug that
/// replaces the target would delete the device.
#[test]
fn a_full_disk_is_an_error_and_leaves_nothing_behind() {
    let folder = Folder::new("full");
    let out = folder.0.join("out");
    for arguments in [&["render", "room:small", "-o"][..], &["trace", "room:small", "--repeat", "1", "--hits"]] {
        let output = Command::new("sh")
            .args(["-c", "ulimit -f 1; exec \"$@\"", "sh", env!("CARGO_BIN_EXE_raylanes")])
            .args(arguments)
            .args([text(&out), "--size", "256x256"])
            .output()
            .unwrap();
        let error = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains("cannot write") && error.contains("File too large"), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
        assert_eq!(fs::read_dir(&folder.0).unwrap().count(), 0, "something was left behind");
    }
}

/// Runs the program in a shell after `limit`, which limits a resource. Returns the line of its error.
fn fails_under(limit: &str, arguments: &[&str]) -> String {
    let output = Command::new("sh")
        .args(["-c", &format!("{limit}; exec \"$@\""), "sh", env!("CARGO_BIN_EXE_raylanes")])
        .args(arguments)
        .output()
        .unwrap();
    let error = error_lines(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{limit} {arguments:?}: {error:?}");
    let [line] = &error[..] else { panic!("{limit} {arguments:?}: {error:?}") };
    line.clone()
}

#[test]
fn an_impossible_number_of_threads_is_refused_at_once() {
    let begin = Instant::now();
    for (value, arguments) in [
        ("60000", &["trace", "room:small", "--size", "8x8"][..]),
        ("-1", &["render", "room:small", "--size", "8x8", "-o", "never.png"]),
        ("many", &["study", "--quick"]),
    ] {
        let folder = Folder::new("threads");
        let output = program().args(arguments).env("RAYON_NUM_THREADS", value).current_dir(&folder.0).output().unwrap();
        let expected = format!("raylanes: RAYON_NUM_THREADS={value}: expected at most 1024 threads");
        assert_eq!((output.status.code(), error_lines(&output.stderr)), (Some(2), vec![expected]));
        assert!(folder.names().is_empty());
    }
    assert!(begin.elapsed() < Duration::from_secs(10));
}

/// Memory for the stacks stands for threads: a limit on the number of threads does not bind `root`. The stacks are
/// large, so the threads that were started find memory for what they need when the next one does not.
#[cfg(target_os = "linux")]
#[test]
fn threads_that_the_system_does_not_grant_are_an_error() {
    let line = fails_under(
        "ulimit -v 600000; export RUST_MIN_STACK=150000000",
        &["trace", "room:small", "--size", "8x8", "--threads", "1024"],
    );
    assert_eq!(line, "raylanes: 1024 threads: cannot be started: Resource temporarily unavailable");
}

#[cfg(target_os = "linux")]
#[test]
fn a_picture_that_does_not_fit_into_memory_is_an_error() {
    for command in [&["trace", "room:small"][..], &["render", "room:small", "-o", "never.png"]] {
        let arguments = [command, &["--size", "8192x8192", "--threads", "1"]].concat();
        let line = fails_under("ulimit -v 1500000", &arguments);
        assert!(line.contains("room:small: not enough memory") && line.contains("67108864 rays"), "{line}");
    }
    let line = fails_under("ulimit -v 300000", &["trace", "sphere:1e7", "--size", "8x8", "--threads", "1"]);
    assert!(line.contains("sphere.toml") && line.contains("not enough memory"), "{line}");
    let folder = Folder::new("memory");
    let scene = folder.file(
        "many.toml",
        "[[quadric]]\nname = 'q'\nsphere = { radius = 1 }\n\
        [[scatter]]\nof = 'q'\ncount = 10000000\narea = { lo = [0, 0], hi = [1, 1] }\n",
    );
    let line = fails_under("ulimit -v 300000", &["trace", text(&scene), "--size", "8x8", "--threads", "1"]);
    assert!(line.contains("many.toml:4: ") && line.contains("10000000 instances"), "{line}");
}

/// Whatever is not foreseen still ends with exit code 2 and without a dump.
#[cfg(target_os = "linux")]
#[test]
fn running_out_of_memory_anywhere_is_exit_code_2() {
    let folder = Folder::new("little-memory");
    for kilobytes in (60_000..400_000).step_by(40_000) {
        let output = Command::new("sh")
            .args(["-c", &format!("ulimit -v {kilobytes}; exec \"$@\""), "sh", env!("CARGO_BIN_EXE_raylanes")])
            .args(["render", "terrain:3e5", "--size", "64x64", "--threads", "1", "-o", text(&folder.0.join("out.png"))])
            .output()
            .unwrap();
        let lines = error_lines(&output.stderr);
        // A build with debug information may be too large for the system to start it at all.
        if output.status.code() == Some(0) {
            break;
        }
        assert!(output.status.code() == Some(2) && !lines.is_empty(), "{kilobytes}: {:?} {lines:?}", output.status);
        assert!(folder.names().is_empty(), "{kilobytes}");
    }
}

#[test]
fn a_file_that_is_too_large_is_refused_before_it_is_read() {
    let folder = Folder::new("too-large");
    let begin = Instant::now();
    for (name, bytes) in
        [("x.obj", 1u64 << 33), ("x.ply", 1 << 33), ("x.stl", 1 << 33), ("x.toml", 1 << 25), ("x.rays", 1 << 32)]
    {
        let file = folder.0.join(name);
        // A hole takes no space.
        fs::File::create(&file).unwrap().set_len(bytes + 32).unwrap();
        let arguments = if name == "x.rays" { vec!["trace", "room:small", "--rays"] } else { vec!["trace"] };
        let longer = format!("{name}: longer than {bytes} bytes");
        fails(&[&arguments[..], &[text(&file)]].concat(), &["cannot read ", &longer]);
    }
    assert!(begin.elapsed() < Duration::from_secs(10));
}
