//! Writes a record: `results.json`, the charts and the report.

use std::path::Path;

use super::present::chart::charts;
use super::present::report::{report_html, report_markdown};
use super::record::folder::make_folder;
use super::record::{Record, one_row_per_line};
use crate::files::{write_new_folder, write_together};
use crate::tracer::Error;

/// Writes `results.json`, `report.md` and the charts that it shows, and the same as one page, `report.html`, into a folder,
/// which is made if it is not there. Nothing is removed, and nothing is replaced before all is written.
///
/// # Errors
/// If something cannot be written.
pub fn write(record: &Record, folder: &Path) -> Result<(), Error> {
    let files = files(record);
    make_folder(folder)?;
    write_together(folder, &files)
}

/// The same into a new folder, which is there with all files or not at all.
///
/// # Errors
/// If something of that name exists, or if something cannot be written.
pub fn write_new(record: &Record, folder: &Path) -> Result<(), Error> {
    write_new_folder(folder, &files(record))
}

/// What a study is written as: names of files, and what they hold.
fn files(record: &Record) -> Vec<(String, Vec<u8>)> {
    let mut files = vec![("results.json".to_owned(), one_row_per_line(record).expect("a record is plain data"))];
    let (report, charts) = (report_markdown(record), charts(record));
    let page = report_html(&report, &charts);
    files.extend(charts.into_iter().map(|chart| (chart.file, chart.svg.into_bytes())));
    // Last, so that what they show is there.
    files.extend([("report.md".to_owned(), report.into_bytes()), ("report.html".to_owned(), page.into_bytes())]);
    files
}
