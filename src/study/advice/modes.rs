//! The modes of the tracer, timed with the chosen kernels. All of them find the same hits.

use std::time::Instant;

use super::ModeRow;
use super::race::{Clock, Prepared, Rounds, Runner};
use crate::study::figures::choice::TIE;
use crate::study::measure::ray_sets::RaySet;
use crate::study::measure::stats::{ratio, typical};
use crate::study::record::Samples;
use crate::tracer::{Error, Mode};

/// The modes, and which one to use.
pub(super) struct Modes {
    /// The fastest mode. [`Mode::Auto`] if it ties with that.
    pub(super) fastest: Mode,
    pub(super) rows: Vec<ModeRow>,
}

/// Times all modes in turns.
///
/// # Errors
/// If two modes disagree about a hit.
pub(super) fn fastest_mode(
    clock: &Clock,
    prepared: &dyn Prepared,
    sets: &[RaySet],
    deadline: Instant,
    reach: &dyn Fn(f64),
) -> Result<Modes, Error> {
    let runners = Mode::ALL.map(|mode| Runner { prepared, mode, sets });
    let turns = clock.time(&runners, &Rounds { least: 5, most: 12, deadline }, reach)?;
    if let Some(other) = (1..turns.len()).find(|&other| turns[other].checksum != turns[0].checksum) {
        let [first, other] = [0, other].map(|number| Mode::ALL[number].name());
        return Err(Error::Disagreement(format!("mode {first} and mode {other}")));
    }
    let samples: Vec<_> = turns.iter().map(|turns| Samples::new(&[turns.total(sets)])).collect();
    let auto = Mode::ALL.iter().position(|&mode| mode == Mode::Auto).expect("it is one of the modes");
    let rows: Vec<_> = Mode::ALL
        .iter()
        .zip(&samples)
        .filter_map(|(mode, ns)| {
            let gain = ratio(&samples[auto], ns)?;
            Some(ModeRow {
                mode: mode.name(),
                mrays_per_second: 1e3 / typical(ns)?.value,
                gain: gain.value,
                gain_low: gain.low,
                gain_high: gain.high,
            })
        })
        .collect();
    let faster = rows.iter().zip(Mode::ALL).filter(|(row, _)| row.gain_low > 1.0 + TIE);
    let fastest = faster.max_by(|(a, _), (b, _)| a.gain.total_cmp(&b.gain)).map_or(Mode::Auto, |(_, mode)| mode);
    Ok(Modes { fastest, rows })
}
