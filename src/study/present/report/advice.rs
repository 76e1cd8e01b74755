//! The section that says what each scene needs: the cheapest kernel that it can live with, and what others offer.

use super::cells::code;
use crate::study::figures::choice::{Candidate, Choice, Need, Standing};
use crate::study::figures::{MISSING, Rate, number, times};
use crate::study::present::grid::{Cell, Grid};
use crate::study::record::Record;

/// The need of the table: that of `raylanes advise` without options.
const NEED: Need = Need { max_wrong: 10.0 };

/// A row for each kind of shape in each scene; `None` if no scene was judged.
pub(super) fn section(record: &Record) -> Option<String> {
    let mut scenes: Vec<&str> = record.on_scenes.iter().map(|row| row.scene.as_str()).collect();
    scenes.dedup();
    let header = [
        "scene",
        "kernel to use",
        "wrong",
        "at edges",
        "more careful",
        "takes",
        "at edges",
        "cheaper",
        "speed",
        "wrong",
    ];
    let mut grid = Grid::new(2, header);
    for scene in scenes {
        for family in ["triangle", "quadric"] {
            grid.rows.extend(choice(record, scene, family).map(|choice| row(scene, &choice)));
        }
    }
    (!grid.rows.is_empty()).then(|| {
        format!(
            "## What each scene needs\n\n`raylanes advise SCENE` measures a scene of yours in this way. *Kernel to \
             use*: the fastest one that gets at most {} rays per million of pictures wrong, with 95 % confidence; of \
             kernels that tie in speed, the most careful one. *More careful*: the fastest one that is much more \
             right; *takes* is its time, relative to the kernel to use. *Cheaper*: the fastest of all, if it gets too \
             many rays wrong. *Wrong* and *at edges*: wrong rays per million, of pictures and of rays aimed at edges; \
             displaced hits count.\n\n{}",
            number(NEED.max_wrong, 2),
            grid.markdown()
        )
    })
}

/// The choice among the kernels of a family in one scene.
fn choice(record: &Record, scene: &str, family: &str) -> Option<Choice> {
    let judged: Vec<_> = record.on_scenes.iter().filter(|row| row.scene == scene).collect();
    let timed: Vec<_> = record.scene_speed.iter().filter(|row| row.scene == scene).collect();
    let claims = |id: &str| {
        record.methods.iter().find(|method| method.id == id).map_or(Vec::new(), |method| method.claims.clone())
    };
    Choice::new(Candidate::all(family, &judged, &timed, &claims), NEED)
}

fn row(scene: &str, choice: &Choice) -> Vec<Cell> {
    let missing = || Cell::from(MISSING);
    let edges =
        |candidate: &Candidate| Cell::from(candidate.answers.at_edges.map_or(MISSING.into(), |rate| rate.to_string()));
    let Some(chosen) = choice.chosen() else {
        let least = choice.least_wrong();
        let open = choice.standings.contains(&Standing::Open);
        let text = if open { "cannot be told from these rays" } else { "none" };
        let wrong = format!("{} ({}: {})", text, least.name(), interval(least.answers.wrong));
        let mut row = vec![scene.into(), text.into(), wrong.into()];
        row.resize_with(10, missing);
        return row;
    };
    let mut row = vec![Cell::from(scene), code(&chosen.id), interval(chosen.answers.wrong).into(), edges(chosen)];
    match choice.careful.map(|number| &choice.candidates[number]) {
        Some(careful) => {
            let takes = times(chosen.gain_over(careful).map(|gain| gain.value));
            row.extend([code(careful.name()), takes.into(), edges(careful)]);
        }
        None => row.extend([missing(), missing(), missing()]),
    }
    match choice.cheaper.map(|number| &choice.candidates[number]) {
        Some(cheaper) => {
            let speed = times(cheaper.gain_over(chosen).map(|gain| gain.value));
            row.extend([code(cheaper.name()), speed.into(), interval(cheaper.answers.wrong).into()]);
        }
        None => row.extend([missing(), missing(), missing()]),
    }
    row
}

/// A rate with its interval.
fn interval(rate: Rate) -> String {
    let [low, high] = rate.interval();
    match rate.events {
        0 => rate.to_string(),
        _ => format!("{} ({} to {})", number(rate.per_million(), 2), number(low, 2), number(high, 2)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tests::fixture::{all_ids, record_of};

    #[test]
    fn every_judged_scene_has_a_row_with_a_registered_kernel() {
        let record = record_of(&all_ids());
        let text = section(&record).unwrap();
        for (scene, family) in [("room", "triangle"), ("gallery", "quadric")] {
            let choice = choice(&record, scene, family).unwrap();
            let chosen = choice.chosen().unwrap();
            assert!(record.methods.iter().any(|method| method.id == chosen.id));
            let row = text.lines().find(|line| line.starts_with(&format!("| {scene} |"))).unwrap();
            assert!(row.contains(&format!("`{}`", chosen.id)), "{row}");
            assert_eq!(row.matches(" | ").count(), 9, "{row}");
            let cells: Vec<_> = row.split(" | ").collect();
            for (cell, number) in [(4, choice.careful), (7, choice.cheaper)] {
                let expected =
                    number.map_or(MISSING.into(), |number| format!("`{}`", choice.candidates[number].name()));
                assert_eq!(cells[cell], expected, "{row}");
            }
        }
        let mut all_wrong = record;
        all_wrong.on_scenes.iter_mut().for_each(|row| row.lost = row.ray_count / 2);
        assert!(section(&all_wrong).unwrap().contains("| room | none | none ("));
        all_wrong.on_scenes.clear();
        assert_eq!(section(&all_wrong), None);
    }
}
