//! Tests the README's blocks from dated records: the verdict of a study, and an answer of `advise`.

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

/// Makes a block of the README anew from the file or folder that its first line names. Such a block begins with
/// `<!-- KIND of FILE -->` and ends with `<!-- end of KIND -->`.
fn renewed(readme: &str, kind: &str, make: impl Fn(&str) -> String) -> String {
    let (before, rest) = readme.split_once(&format!("<!-- {kind} of ")).unwrap_or_else(|| panic!("no block {kind}"));
    let (file, rest) = rest.split_once(" -->\n").unwrap();
    let (_, after) = rest.split_once(&format!("<!-- end of {kind} -->")).unwrap();
    format!("{before}<!-- {kind} of {file} -->\n\n{}\n<!-- end of {kind} -->{after}", make(file))
}

/// To update the README, run `RAYLANES_BLESS=1 cargo test --lib readme`.
#[test]
fn the_readme_matches_its_records() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |file: &str| fs::read_to_string(root.join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
    let readme = read("README.md");
    let expected = renewed(&readme, "verdict", |folder| {
        assert!(
            readme.contains(&format!("]({folder}/{SPEED_ACCURACY})")),
            "the README's chart must be that of the same record"
        );
        let record: Record = serde_json::from_str(&read(&format!("{folder}/results.json")))
            .expect("the README's record has the current layout");
        readme_block(&record, folder)
    });
    let expected = renewed(&expected, "answer", |file| format!("```text\n{}```\n", read(file)));
    if std::env::var_os("RAYLANES_BLESS").is_some() {
        fs::write(root.join("README.md"), expected).unwrap();
    } else {
        assert!(readme == expected, "to accept the change, run RAYLANES_BLESS=1 cargo test --lib readme");
    }
}
