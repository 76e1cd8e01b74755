//! Tests the README's block about a dated record: its verdict, and which kernel of each family to use.

use std::fs;
use std::path::Path;

use crate::study::figures::{Group, groups, number};
use crate::study::present::chart::SPEED_ACCURACY;
use crate::study::present::report::advice_table;
use crate::study::present::verdict::{spread, verdict_list};
use crate::study::record::{Record, date};

/// The README's block about a record: its verdict, and which kernel of each family to use. Lines have at most 120
/// columns, except those of the table.
fn readme_block(record: &Record, folder: &str) -> String {
    let mut groups = groups(record);
    groups.retain(Group::is_base);
    let verdict = verdict_list(&groups).unwrap_or_default();
    let verdict: Vec<_> = verdict.lines().map(|line| wrapped(line, "  ")).collect();
    let legend = format!(
        "Speeds are tests of one ray against one primitive in packets of eight (8x1), one thread. Lost rays are per \
         million that exactly hit, in the worst workload; `0 (< b)`: none was lost, and b is the 95 % bound. ulp: 99th \
         percentile of the error of `t`. Kernels tie if the interval of their ratio contains 1; the median \
         interval reaches {} % to either side. Measured on {}, on this processor: {}.",
        number(100.0 * spread(record).expect("the record has timings"), 2),
        date(record.started_unix),
        record.machine.cpu
    );
    format!(
        "{}\n\n{}\n{}\n[The whole record]({folder}/report.md) is also one page, `report.html`, in the same folder.\n",
        verdict.join("\n"),
        advice_table(&groups),
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
