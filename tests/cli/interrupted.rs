//! Interrupts the program with real signals.

use std::io::Read;
use std::process::Child;

use crate::*;

const NOTHING: &str = "raylanes: interrupted, nothing was written";

/// Starts the program and waits until it handles signals. Signals have their default action, even if the tests run
/// under `nohup`.
fn start(folder: &Folder, arguments: &[&str]) -> Child {
    let mut program = Command::new("env");
    program.arg("--default-signal=HUP,INT,QUIT,TERM,USR1,XCPU");
    // SIGQUIT is the last that the program handles.
    started(program, folder, arguments, 3)
}

/// Starts the program with `env`, and waits until it handles the signal with this number.
fn started(mut program: Command, folder: &Folder, arguments: &[&str], signal: u32) -> Child {
    program.arg(env!("CARGO_BIN_EXE_raylanes")).args(arguments);
    let child = program.current_dir(&folder.0).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let ready = || {
        let status = fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap();
        let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:")).unwrap_or("0");
        u64::from_str_radix(caught.trim(), 16).unwrap() >> (signal - 1) & 1 == 1
    };
    wait_until("the program handles signals", ready);
    child
}

fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !is_so() {
        assert!(begin.elapsed() < Duration::from_secs(60), "{what}: not within a minute");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// Sends a signal; returns the exit code and the lines of standard error.
fn interrupt(mut child: Child, signal: &str) -> (Option<i32>, Vec<String>) {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
    wait_until("the program exits", || child.try_wait().unwrap().is_some());
    let mut stderr = Vec::new();
    child.stderr.take().unwrap().read_to_end(&mut stderr).unwrap();
    (child.wait().unwrap().code(), error_lines(&stderr))
}

#[test]
fn an_interrupted_study_leaves_nothing_behind() {
    let folder = Folder::new("interrupted-study");
    for (delay, signal) in
        [(0, "-INT"), (20, "-TERM"), (300, "-QUIT"), (300, "-XCPU"), (300, "-USR1"), (500, "-HUP"), (2000, "-INT")]
    {
        for target in [["--record", "x"], ["--out", "some/where"]] {
            let child = start(&folder, &[&["study", "--quick"][..], &target].concat());
            std::thread::sleep(Duration::from_millis(delay));
            assert_eq!(interrupt(child, signal), (Some(130), vec![NOTHING.to_owned()]), "{delay} {target:?}");
            assert!(folder.names().is_empty(), "{delay} {target:?}: {:?}", folder.names());
        }
    }
}

/// The processes that a process has started and that still exist.
fn children(process: u32) -> Vec<u32> {
    let is_child = |entry: std::io::Result<fs::DirEntry>| {
        let child: u32 = entry.ok()?.file_name().to_str()?.parse().ok()?;
        let status = fs::read_to_string(format!("/proc/{child}/status")).ok()?;
        let parent = status.lines().find_map(|line| line.strip_prefix("PPid:"))?.trim().parse::<u32>().ok()?;
        (parent == process).then_some(child)
    };
    fs::read_dir("/proc").unwrap().filter_map(is_child).collect()
}

fn exists(process: u32) -> bool {
    Path::new(&format!("/proc/{process}")).exists()
}

#[test]
fn an_interrupt_also_ends_the_process_that_times_kernels() {
    let folder = Folder::new("interrupted-process");
    for signal in ["-INT", "-TERM"] {
        let child = start(&folder, &["study", "--quick", "--out", "out"]);
        let mut timing = Vec::new();
        wait_until("a process times kernels", || {
            timing = children(child.id());
            !timing.is_empty()
        });
        assert_eq!(interrupt(child, signal), (Some(130), vec![NOTHING.to_owned()]));
        assert!(timing.iter().all(|&process| !exists(process)), "{timing:?}");
        assert!(folder.names().is_empty(), "{:?}", folder.names());
    }
}

/// Nobody can handle SIGKILL. The process that times kernels then ends because nobody reads its lines.
#[test]
fn a_process_that_times_kernels_does_not_outlive_a_killed_study_for_long() {
    let folder = Folder::new("killed-study");
    let child = start(&folder, &["study", "--quick", "--out", "out"]);
    let mut timing = Vec::new();
    wait_until("a process times kernels", || {
        timing = children(child.id());
        !timing.is_empty()
    });
    interrupt(child, "-KILL");
    // Without a parent, whoever adopted it may not ask how it ended. So it may still have an entry.
    let runs = |process: u32| {
        let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
        !status.is_empty() && !status.contains("State:\tZ")
    };
    wait_until("it ends", || !timing.iter().any(|&process| runs(process)));
}

/// A process that ends early makes the study fail, with one line.
#[test]
fn a_study_fails_if_a_process_that_times_kernels_dies() {
    let folder = Folder::new("dying-process");
    let mut child = start(&folder, &["study", "--quick", "--out", "out"]);
    let mut timing = Vec::new();
    wait_until("a process times kernels", || {
        timing = children(child.id());
        !timing.is_empty()
    });
    assert!(Command::new("kill").args(["-KILL", &timing[0].to_string()]).status().unwrap().success());
    wait_until("the study fails", || child.try_wait().unwrap().is_some());
    let mut stderr = Vec::new();
    child.stderr.take().unwrap().read_to_end(&mut stderr).unwrap();
    let lines = error_lines(&stderr);
    assert_eq!((child.wait().unwrap().code(), lines.len()), (Some(2), 1), "{lines:?}");
    assert!(lines[0].ends_with("process 1 of 2 that times kernels: it ended with signal: 9 (SIGKILL)"), "{lines:?}");
    assert!(folder.names().is_empty(), "{:?}", folder.names());
}

#[test]
fn an_interrupted_file_is_complete_or_absent_and_the_message_says_which() {
    let folder = Folder::new("interrupted-file");
    let arguments = ["trace", "room:small", "--size", "1024x1024", "--repeat", "1", "--hits", "out"];
    let mut outcomes = [0; 2];
    for step in 0..24 {
        let child = start(&folder, &arguments);
        // The delays reach from before the scene is built to after everything is written.
        std::thread::sleep(Duration::from_millis(25 * step));
        let (code, lines) = interrupt(child, "-INT");
        let written = folder.names();
        if written.is_empty() {
            assert_eq!((code, lines), (Some(130), vec![NOTHING.to_owned()]));
        } else {
            assert_eq!(written, ["out"]);
            assert_eq!(fs::metadata(folder.0.join("out")).unwrap().len(), 1024 * 1024 * 16);
            if code != Some(0) {
                assert_eq!((code, lines), (Some(130), vec!["raylanes: interrupted after writing to out".into()]));
            }
            fs::remove_file(folder.0.join("out")).unwrap();
        }
        outcomes[usize::from(!written.is_empty())] += 1;
    }
    assert!(outcomes[0] > 0, "{outcomes:?}: every interrupt came too late");
}

#[test]
fn waiting_for_a_reader_does_not_block_the_interrupt() {
    let folder = Folder::new("interrupted-output");
    let arguments = ["trace", "room:small", "--size", "256x256", "--repeat", "1", "--hits", "/dev/stdout"];
    let mut child = start(&folder, &arguments);
    let mut stdout = child.stdout.take().unwrap();
    stdout.read_exact(&mut [0]).unwrap();
    let line = "raylanes: interrupted after writing to /dev/stdout".to_owned();
    assert_eq!(interrupt(child, "-INT"), (Some(130), vec![line]));
}

/// A shell starts a program in the background with SIGINT and SIGQUIT ignored, `nohup` with SIGHUP ignored.
#[test]
fn an_ignored_signal_stays_ignored_and_the_others_leave_nothing_behind() {
    let folder = Folder::new("ignored-signal");
    for (ignored, signals) in [("INT,QUIT", ["INT", "QUIT", "TERM"]), ("HUP", ["HUP", "HUP", "QUIT"])] {
        let mut program = Command::new("env");
        program.args(["--default-signal=HUP,INT,QUIT,TERM", &format!("--ignore-signal={ignored}")]);
        let child = started(program, &folder, &["study", "--quick", "--out", "out"], 15);
        for signal in &signals[..2] {
            assert!(Command::new("kill").args(["-s", signal, &child.id().to_string()]).status().unwrap().success());
        }
        std::thread::sleep(Duration::from_millis(300));
        assert_eq!(folder.names(), ["out"], "{ignored}: the study goes on");
        assert_eq!(interrupt(child, &format!("-{}", signals[2])), (Some(130), vec![NOTHING.to_owned()]), "{ignored}");
        assert!(folder.names().is_empty(), "{ignored}: {:?}", folder.names());
    }
}

#[test]
fn two_studies_do_not_write_into_one_folder() {
    let folder = Folder::new("two-studies");
    for target in [["--out", "out"], ["--record", "x"]] {
        let arguments = [&["study", "--quick", "room:small"][..], &target].concat();
        let child = start(&folder, &arguments);
        wait_until("the folder is reserved", || !folder.names().is_empty());
        fails_in(&folder.0, &arguments, &["another study is writing to this folder"]);
        assert_eq!(interrupt(child, "-INT"), (Some(130), vec![NOTHING.to_owned()]));
        assert!(folder.names().is_empty(), "{target:?}: {:?}", folder.names());
    }
}
