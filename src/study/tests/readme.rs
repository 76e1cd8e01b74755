//! Tests the README's block about a dated record: its verdict.

use std::fs;
use std::path::Path;

use crate::study::figures::{Group, groups};
use crate::study::present::chart::SPEED_ACCURACY;
use crate::study::present::verdict::{noise, verdict_list};
use crate::study::record::{Record, date};

/// The README's block about a record: its verdict, how sure it is, and on what machine. Lines have at most 120 columns.
fn readme_block(record: &Record, folder: &str) -> String {
    let mut groups = groups(record);
    groups.retain(Group::is_base);
    let verdict = verdict_list(record, &groups).unwrap_or_default();
    let verdict: Vec<_> = verdict.lines().map(|line| wrapped(line, "  ")).collect();
    let legend = format!(
        "{} Measured on {}, on this processor: {}.",
        noise(record, &groups).expect("the record has timings"),
        date(record.started_unix),
        record.machine.cpu
    );
    format!(
        "{}\n\n{}\n\n[The whole answer]({folder}/report.md); [everything that was measured]({folder}/appendix.md).\n",
        verdict.join("\n"),
        wrapped(&legend, "")
    )
}

/// Breaks text between words into lines of at most 120 columns. All lines but the first start with `indent`.
fn wrapped(text: &str, indent: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last_mut().expect("there is always a line");
        if line.is_empty() {
            *line = word.to_owned();
        } else if line.chars().count() + 1 + word.chars().count() <= 120 {
            *line = format!("{line} {word}");
        } else {
            lines.push(format!("{indent}{word}"));
        }
    }
    lines.join("\n")
}

/// To update the README, run `RAYLANES_BLESS=1 cargo test --lib readme`.
#[test]
fn the_readme_matches_its_record() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = fs::read_to_string(root.join("README.md")).unwrap();
    let (before, rest) =
        readme.split_once("<!-- verdict of ").expect("the README has a block `<!-- verdict of ... -->`");
    let (folder, rest) = rest.split_once(" -->\n").unwrap();
    let (said, after) = rest.split_once("<!-- end of verdict -->").unwrap();
    assert!(
        before.contains(&format!("]({folder}/{SPEED_ACCURACY})")),
        "the README's chart must be that of the same record"
    );
    let json = fs::read_to_string(root.join(folder).join("results.json")).unwrap();
    let record: Record = serde_json::from_str(&json).expect("the README's record has the current layout");
    let expected = format!("\n{}\n", readme_block(&record, folder));
    if std::env::var_os("RAYLANES_BLESS").is_some() {
        let blessed = format!("{before}<!-- verdict of {folder} -->\n{expected}<!-- end of verdict -->{after}");
        fs::write(root.join("README.md"), blessed).unwrap();
    } else {
        assert_eq!(said, expected, "to accept the change, run RAYLANES_BLESS=1 cargo test --lib readme");
    }
}
