//! The README's block about a dated record: its verdict, and which kernel to use of each family.

use std::fs;
use std::path::Path;

use crate::study::figures::{Group, groups};
use crate::study::present::chart::SPEED_ACCURACY;
use crate::study::present::report::advice_table;
use crate::study::present::verdict::verdict_list;
use crate::study::record::{Record, date};

/// What the project's README says of a record: its verdict, and what to use of each family.
fn of_readme(record: &Record, folder: &str) -> String {
    let mut groups = groups(record);
    groups.retain(Group::is_base);
    let verdict = verdict_list(&groups).unwrap_or_default();
    format!(
        "{verdict}\n\n{}\nTests of one ray against one primitive, in packets of eight (8x1), one thread; lost rays per million that \
         exactly hit, where that is\nworst (`< b`: the 95 % bound where none was); ulp: 99th percentile of the error of `t`. Kernels \
         tie where they differ by no more than\nthe noise. Measured on {}, {}: [the whole record]({folder}/report.md), \
         and as a page `report.html` beside it.\n",
        advice_table(&groups),
        date(record.started_unix),
        record.machine.cpu
    )
}

/// To bring the README up to date: `RAYLANES_BLESS=1 cargo test --lib readme`.
#[test]
fn the_readme_says_what_its_record_says() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let readme = fs::read_to_string(root.join("README.md")).unwrap();
    let (before, rest) = readme.split_once("<!-- verdict of ").expect("the README has a verdict");
    let (folder, rest) = rest.split_once(" -->\n").unwrap();
    let (said, after) = rest.split_once("<!-- end of verdict -->").unwrap();
    assert!(before.contains(&format!("]({folder}/{SPEED_ACCURACY})")), "the chart is that of the same record");
    let json = fs::read_to_string(root.join(folder).join("results.json")).unwrap();
    let record: Record = serde_json::from_str(&json).expect("the README's record has the present layout");
    let expected = format!("\n{}\n", of_readme(&record, folder));
    if std::env::var_os("RAYLANES_BLESS").is_some() {
        let blessed = format!("{before}<!-- verdict of {folder} -->\n{expected}<!-- end of verdict -->{after}");
        fs::write(root.join("README.md"), blessed).unwrap();
    } else {
        assert_eq!(said, expected, "if this is meant: RAYLANES_BLESS=1 cargo test --lib readme");
    }
}
