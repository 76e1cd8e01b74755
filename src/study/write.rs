//! Writes a record to a folder: `results.json`, the charts and the report.

use std::io::Write;
use std::path::Path;

use super::present::chart::charts;
use super::present::report::{answer_markdown, appendix_markdown, report_html};
use super::record::folder::make_folder;
use super::record::{Record, one_row_per_line};
use crate::files::{write_new_folder, write_together};
use crate::tracer::Error;

/// Extensions of the files of a record.
pub const RESULT_EXTENSIONS: [&str; 4] = ["json", "md", "html", "svg"];

/// Writes a record into a folder: `results.json`, the charts, `report.md` and `appendix.md`, and the same two as pages
/// that need no other file, `report.html` and `appendix.html`. Makes the folder if it does not exist. Removes nothing,
/// and replaces no file before all are written.
///
/// # Errors
/// If the folder or a file cannot be written.
pub fn write(record: &Record, folder: &Path) -> Result<(), Error> {
    let files = files(record);
    make_folder(folder)?;
    let files = files.iter().map(|(name, content)| (folder.join(name), |out: &mut dyn Write| out.write_all(content)));
    write_together(folder, files)
}

/// Writes a record into a new folder. The folder appears with all of its files, or not at all.
///
/// # Errors
/// If a file or folder of that name exists, or if something cannot be written.
pub fn write_new(record: &Record, folder: &Path) -> Result<(), Error> {
    write_new_folder(folder, &files(record))
}

/// The names and contents of the files of a record.
fn files(record: &Record) -> Vec<(String, Vec<u8>)> {
    let mut files = vec![("results.json".to_owned(), one_row_per_line(record).expect("a record is plain data"))];
    let charts = charts(record);
    let appendix = appendix_markdown(record);
    let texts = [("report", answer_markdown(record, &appendix)), ("appendix", appendix)];
    let pages = texts.map(|(name, text)| {
        let page = report_html(&text, &charts);
        [(format!("{name}.md"), text.into_bytes()), (format!("{name}.html"), page.into_bytes())]
    });
    files.extend(charts.into_iter().map(|chart| {
        let content = chart.file_content();
        (chart.file, content.into_bytes())
    }));
    // The reports come last: they refer to the charts.
    files.extend(pages.into_iter().flatten());
    files
}
