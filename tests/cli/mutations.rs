//! Random command lines, with damaged files: exit code 0 or 2, and then one line; nothing temporary is left behind.
//!
//! `RAYLANES_ROUNDS` sets how many are tried. After a change to what the program reads, 100,000 take half an hour.

use std::os::unix::process::ExitStatusExt;

use crate::*;
use raylanes::conformance::Random;

/// Arguments, right and wrong ones. No study is among them: it takes too long.
const WORDS: [&str; 44] = [
    "trace",
    "render",
    "list",
    "--help",
    "--kernel",
    "cramer",
    "woo",
    "--quadric-kernel",
    "naive",
    "--mode",
    "packet",
    "--threads",
    "1",
    "0",
    "--size",
    "8x8",
    "0x8",
    "--eye",
    "1,2,3",
    "--look-at",
    "nan,0,0",
    "1e38,-1e38,1e38",
    "--rays",
    "x.rays",
    "--any-hit",
    "--repeat",
    "--hits",
    "out",
    "x.obj",
    "x.toml",
    ".",
    "",
    "no/such",
    "--json",
    "-o",
    "out.png",
    "--shade",
    "depth",
    "--compare",
    "--",
    "-",
    "\u{202e}\n\n",
    "--size=8x8",
    "\u{1b}[2J",
];

const OBJ: &str = "mtllib x.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\nf -1 -2 -3\n";
const TOML: &str = "[[mesh]]\nname = 'x'\nfile = 'x.obj'\n[[instance]]\nof = 'x'\ntransform = [{ scale = [1, 2, 3] }]\n\
    [[scatter]]\nof = 'x'\ncount = 9\narea = { lo = [0, 0], hi = [1, 1] }\n";

/// Overwrites a few bytes, or cuts the end off.
fn damaged(content: &[u8], random: &mut Random) -> Vec<u8> {
    let mut content = content.to_vec();
    for _ in 0..random.below(4) {
        let place = random.below(content.len());
        content[place] = random.below(256) as u8;
    }
    if random.below(4) == 0 {
        content.truncate(random.below(content.len()));
    }
    content
}

#[test]
fn random_command_lines_and_damaged_files_give_one_line() {
    let folder = Folder::new("mutations");
    let random = &mut Random::from_seed(2026);
    let mut outcomes = [0; 2];
    let rounds = std::env::var("RAYLANES_ROUNDS").map_or(150, |rounds| rounds.parse().unwrap());
    for round in 0..rounds {
        let rays: Vec<u8> = (0..32 * 9).map(|_| random.below(256) as u8).collect();
        for (name, content) in [("x.obj", OBJ.as_bytes()), ("x.toml", TOML.as_bytes()), ("x.rays", &rays)] {
            folder.file(name, damaged(content, random));
        }
        let mut arguments = match random.below(4) {
            0 => vec!["trace", "x.toml", "--rays", "x.rays", "--hits", "out", "--repeat", "1"],
            1 => vec!["trace", "x.obj", "--size", "8x8", "--repeat", "1"],
            2 => vec!["render", "x.toml", "--size", "8x8", "-o", "out.png"],
            _ => vec!["list"],
        };
        for _ in 0..random.below(3) {
            let place = 1 + random.below(arguments.len());
            arguments.insert(place, WORDS[random.below(WORDS.len())]);
        }
        let begin = Instant::now();
        let output = program().args(&arguments).current_dir(&folder.0).stdin(Stdio::null()).output().unwrap();
        let (error, status) = (String::from_utf8(output.stderr).unwrap(), output.status);
        let lines: Vec<_> = error.lines().filter(|line| !line.starts_with("note: ")).collect();
        let context = format!("round {round}, {arguments:?}, {status}: {error}");
        match status.code() {
            Some(0) => assert!(lines.is_empty(), "{context}"),
            Some(2) => assert!(lines.len() == 1 && lines[0].starts_with("raylanes: "), "{context}"),
            _ => panic!("{context} {:?}", status.signal()),
        }
        assert!(error.chars().all(|c| c == '\n' || !c.is_control() && c != '\u{202e}'), "{context}");
        assert!(begin.elapsed() < Duration::from_secs(30), "{context}");
        for name in folder.names() {
            assert!(!name.starts_with(".raylanes"), "{context}: {name}");
            if !name.starts_with("x.") {
                fs::remove_file(folder.0.join(name)).unwrap();
            }
        }
        outcomes[usize::from(status.code() == Some(0))] += 1;
    }
    assert!(outcomes.iter().all(|&count| count > 20), "{outcomes:?}");
}
