//! Writes a comparison: `peers.json` and `peers.md`.

use std::path::Path;

use crate::study::present::peers::markdown;
use crate::study::record::folder::make_folder;
use crate::study::record::{PeersRecord, one_row_per_line};
use crate::tracer::{Error, write_atomically};

/// Writes `peers.json` and `peers.md` into a folder. Makes the folder if it does not exist.
///
/// # Errors
/// If the folder or a file cannot be written.
pub fn write(record: &PeersRecord, folder: &Path) -> Result<(), Error> {
    make_folder(folder)?;
    let json = one_row_per_line(record).expect("a record is plain data");
    for (name, content) in [("peers.json", json), ("peers.md", markdown(record).into_bytes())] {
        write_atomically(&folder.join(name), |file| file.write_all(&content))?;
    }
    Ok(())
}
