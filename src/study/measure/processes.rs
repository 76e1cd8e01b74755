//! Times kernels in several processes, one after the other. Where the system puts code, stack and heap moves the median
//! of a process by more than its samples differ, and a single process has only one layout (Mytkowicz, Diwan, Hauswirth,
//! Sweeney, "Producing Wrong Data Without Doing Anything Obviously Wrong!", 2009). As in that paper, each process has
//! another size of environment, which moves its stack.
//!
//! The program starts itself with a hidden command. Such a process writes a line of JSON after each round, and the
//! samples of all jobs at its end. It ends soon after the program that started it: then nobody reads its lines.

use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::operation_rates;
use super::rounds::{self, JobTimes};
use super::scene_speed::SceneSpeed;
use super::speed::Speed;
use crate::error::{quoted, reason};
use crate::tracer::{Error, SceneSource};

/// The hidden command of the program that times kernels. Its options are the fields of [`Timed`].
pub const TIME_KERNELS: &str = "time-kernels";

/// What a process times.
#[derive(Clone, Debug)]
pub struct Timed {
    /// The seed of all random inputs.
    pub seed: u64,
    /// How many samples of each kernel.
    pub rounds: usize,
    /// Scenes to trace with each kernel.
    pub scenes: Vec<SceneSource>,
    /// Width and height of the scenes' pictures in pixels.
    pub picture: u32,
    /// How many samples of each kernel in each scene.
    pub scene_rounds: usize,
}

/// A variable that only makes the environment larger.
const PADDING: &str = "RAYLANES_PADDING";
/// By how many bytes the environment of each process is larger than that of the one before. Five of these steps reach
/// across a page of memory, and none is a multiple of a cache line.
const PADDING_BYTES: usize = 816;

/// What a process writes: one of these on each line.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Message {
    /// The share of the rounds that is done.
    Done(f64),
    /// All samples. The last line.
    Times(Vec<JobTimes>),
}

/// Times all kernels, operations and scenes in this process. After each round, calls `after_round` with the share that
/// is done.
///
/// # Errors
/// If a scene cannot be loaded, if a kernel does not give the same hits in every round, or if `after_round` fails.
pub(crate) fn time_here(
    timed: &Timed,
    after_round: &mut dyn FnMut(f64) -> Result<(), Error>,
) -> Result<Vec<JobTimes>, Error> {
    let speed = Speed::new(timed.seed);
    let mut jobs = speed.timed_jobs();
    jobs.extend(operation_rates::timed_jobs());
    let mut times = rounds::take(&jobs, timed.rounds, &mut |share| after_round(0.5 * share))?;
    let scenes = SceneSpeed::new(&timed.scenes, (timed.picture, timed.seed))?;
    times.extend(rounds::take(&scenes.timed_jobs()?, timed.scene_rounds, &mut |share| after_round(0.5 + 0.5 * share))?);
    Ok(times)
}

/// What the hidden command does: times all that it is told, and writes what it measures to `out`.
///
/// # Errors
/// If a scene cannot be loaded, if a kernel does not give the same hits in every round, or if nobody reads.
pub fn time_kernels(timed: &Timed, out: &mut dyn Write) -> Result<(), Error> {
    let mut send = |message: &Message| {
        let line = serde_json::to_string(message).expect("times are plain data");
        writeln!(out, "{line}").and_then(|()| out.flush()).map_err(Error::writing(Path::new("standard output")))
    };
    let times = time_here(timed, &mut |share| send(&Message::Done(share)))?;
    send(&Message::Times(times))
}

/// Times all that it is told in `count` processes of each program, one after the other. The programs take turns, so all
/// of them suffer equally if the machine is slow for a while. Returns for each program what its processes measured.
///
/// # Errors
/// If a process cannot be started, fails, or writes something else.
pub(crate) fn time_in_processes(
    programs: &[&Path],
    count: usize,
    timed: &Timed,
    after_round: &mut dyn FnMut(f64),
) -> Result<Vec<Vec<Vec<JobTimes>>>, Error> {
    let mut of_programs = vec![Vec::with_capacity(count); programs.len()];
    let (mut ended, all) = (0, count * programs.len());
    for number in 0..count {
        for (program, times) in programs.iter().zip(&mut of_programs) {
            let mut done = |share| after_round((f64::from(ended) + share) / all as f64);
            times.push(time_in_process(program, [number, count], timed, &mut done)?);
            ended += 1;
        }
    }
    Ok(of_programs)
}

/// Times all that it is told in process `number` of `count` of a program.
fn time_in_process(
    program: &Path,
    [number, count]: [usize; 2],
    timed: &Timed,
    done: &mut dyn FnMut(f64),
) -> Result<Vec<JobTimes>, Error> {
    let mut command = Command::new(program);
    command.args([TIME_KERNELS, "--seed", &timed.seed.to_string(), "--rounds", &timed.rounds.to_string()]);
    command.args(["--picture", &timed.picture.to_string(), "--scene-rounds", &timed.scene_rounds.to_string()]);
    command.arg("--").args(timed.scenes.iter().map(SceneSource::argument));
    command.env(PADDING, "x".repeat(number * PADDING_BYTES));
    times_of(command, done).map_err(|failure| {
        let message = format!("process {} of {count} that times kernels: {failure}", number + 1);
        Error::Argument { argument: program.to_string_lossy().into_owned(), message }
    })
}

/// Runs a process until it ends, and reads what it measured. The error is a line that says what went wrong.
fn times_of(mut command: Command, done: &mut dyn FnMut(f64)) -> Result<Vec<JobTimes>, String> {
    // Ctrl-C reaches all processes of a terminal's group. This one shall end only when its parent says so: the parent
    // could not tell why it ended.
    #[cfg(unix)]
    std::os::unix::process::CommandExt::process_group(&mut command, 0);
    let (process, stdout, mut stderr) = Process::start(command).map_err(|error| reason(&error))?;
    let mut times = None;
    for line in BufReader::new(stdout).lines() {
        let line = line.map_err(|error| reason(&error))?;
        match serde_json::from_str(&line) {
            Ok(Message::Done(share)) => done(share),
            Ok(Message::Times(all)) => times = Some(all),
            Err(_) => return Err(format!("unexpected output {}", quoted(line.as_bytes()))),
        }
    }
    let mut said = String::new();
    // A failure to read the reason is no other reason.
    let _ = stderr.read_to_string(&mut said);
    let status = process.wait().map_err(|error| reason(&error))?;
    match (times, status.success()) {
        (Some(times), true) => Ok(times),
        (None, true) => Err("it ended without a result".into()),
        (_, false) => {
            let line = said.lines().last().map(|line| line.trim_start_matches("raylanes: "));
            Err(line.map_or_else(|| format!("it ended with {status}"), str::to_owned))
        }
    }
}

/// The process that runs now, if any. Locked while it is started and stopped, but never while it is waited for.
static RUNNING: Mutex<Option<Child>> = Mutex::new(None);

fn running() -> MutexGuard<'static, Option<Child>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Ends the process that times kernels, if one runs, and prevents new ones while the returned guard lives. For a
/// program that is about to exit.
pub fn stop_processes() -> MutexGuard<'static, Option<Child>> {
    let mut running = running();
    stop(&mut running);
    running
}

fn stop(running: &mut Option<Child>) {
    if let Some(mut child) = running.take() {
        // It may have ended already. Either way, the system must be asked how, or it keeps an entry for it.
        let _ = child.kill();
        let _ = child.wait();
    }
}

/// A process that runs. When dropped, it is stopped.
struct Process;

impl Process {
    /// Starts a process. Returns its standard output and standard error too.
    fn start(mut command: Command) -> io::Result<(Self, impl Read, impl Read)> {
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut running = running();
        let mut child = command.spawn()?;
        let (stdout, stderr) = child.stdout.take().zip(child.stderr.take()).expect("both are piped");
        *running = Some(child);
        Ok((Self, stdout, stderr))
    }

    /// Waits until it ends.
    fn wait(self) -> io::Result<ExitStatus> {
        loop {
            // Unlocked between two looks, so that an interrupt can stop it.
            match running().as_mut().map(Child::try_wait) {
                None => return Err(io::Error::other("it was stopped")),
                Some(Err(error)) => return Err(error),
                Some(Ok(Some(status))) => return Ok(status),
                Some(Ok(None)) => {}
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        stop(&mut running());
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::path::PathBuf;
    use std::time::Instant;

    use super::*;

    fn run(script: &str) -> Result<Vec<JobTimes>, String> {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        times_of(command, &mut |_| ())
    }

    /// One test, because only one process can run at a time.
    #[test]
    fn a_process_gives_its_times_or_one_line_that_says_what_went_wrong() {
        let message = Message::Times(vec![JobTimes { name: "a".into(), checksum: u64::MAX, ns: vec![1.5, 2.0] }]);
        let line = serde_json::to_string(&message).unwrap();
        let mut shares = Vec::new();
        let mut command = Command::new("sh");
        command.args(["-c", &format!("echo '{{\"done\":0.5}}'; echo '{line}'")]);
        let times = times_of(command, &mut |share| shares.push(share)).unwrap();
        assert_eq!((times[0].checksum, &times[0].ns[..], &shares[..]), (u64::MAX, &[1.5, 2.0][..], &[0.5][..]));

        let begin = Instant::now();
        for (script, expected) in [
            ("true", "it ended without a result"),
            ("echo nonsense; exec sleep 60", "unexpected output \"nonsense\""),
            ("echo first >&2; echo 'raylanes: hits differ: a' >&2; exit 2", "hits differ: a"),
            (&format!("echo '{line}'; exit 3"), "it ended with exit status: 3"),
            ("kill -KILL $$", "it ended with signal: 9 (SIGKILL)"),
        ] {
            assert_eq!(run(script).unwrap_err(), expected, "{script}");
            assert!(running().is_none(), "{script}");
        }
        let nowhere = times_of(Command::new("/nowhere/program"), &mut |_| ()).unwrap_err();
        assert_eq!(nowhere, "No such file or directory");
        let timed = Timed { seed: 1, rounds: 1, scenes: Vec::new(), picture: 1, scene_rounds: 1 };
        let error =
            time_in_processes(&[Path::new("/nowhere/program")], 5, &timed, &mut |_| ()).unwrap_err().to_string();
        let expected = "/nowhere/program: process 1 of 5 that times kernels: No such file or directory";
        assert_eq!(error, expected);

        // Two programs take turns.
        let folder = std::env::temp_dir().join(format!("raylanes-turns-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let programs = ["a", "b"].map(|name| {
            let program = folder.join(name);
            let script = format!("#!/bin/sh\necho {name} >>'{}'\necho '{line}'\n", folder.join("turns").display());
            std::fs::write(&program, script).unwrap();
            let executable = std::os::unix::fs::PermissionsExt::from_mode(0o755);
            std::fs::set_permissions(&program, executable).unwrap();
            program
        });
        let both = time_in_processes(&programs.each_ref().map(PathBuf::as_path), 3, &timed, &mut |_| ());
        assert_eq!(both.unwrap().iter().map(Vec::len).collect::<Vec<_>>(), [3, 3]);
        assert_eq!(std::fs::read_to_string(folder.join("turns")).unwrap(), "a\nb\na\nb\na\nb\n");
        std::fs::remove_dir_all(&folder).unwrap();

        // An interrupt ends the process before it ends by itself.
        let stopped = std::thread::scope(|scope| {
            let waiting = scope.spawn(|| run("exec sleep 60"));
            while running().is_none() {
                std::thread::yield_now();
            }
            drop(stop_processes());
            waiting.join().unwrap()
        });
        assert_eq!(stopped.unwrap_err(), "it was stopped");
        assert!(begin.elapsed() < Duration::from_secs(50), "a process was not ended but waited for");
    }
}
