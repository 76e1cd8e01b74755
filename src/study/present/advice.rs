//! Advice as people read it: one screen for a terminal, and a page with all figures.

use std::time::SystemTime;

use super::grid::{Cell, Grid};
use crate::study::advice::{Advice, KernelRow, ShapeAdvice};
use crate::study::figures::{Rate, count, number, times};
use crate::study::record::{Machine, date, seconds_since_1970};

/// The advice as text: at most one screen. With `color`, ANSI colours mark the chosen kernels and modes (green), and
/// kernels that do not meet the need (red).
pub fn advice_text(advice: &Advice, color: bool) -> String {
    let mut text = format!("{}: {}\n\n", advice.scene, size(advice));
    for shape in &advice.shapes {
        text += &grid(shape, false).terminal(color);
        text += "\n";
    }
    text += &wrapped("", LEGEND);
    text += "\n";
    for reason in &advice.reasons {
        text += &wrapped("- ", reason);
    }
    text += &format!("\n{}\n", command(advice));
    text
}

const LEGEND: &str = "wrong, edges: wrong rays per million, of pictures (or of the file) and of rays aimed at edges. \
    error: 99 % of the hits are displaced by at most this. speed: that of the tracer's own kernel is 1. 95 %: the \
    interval of the figure before it.";

/// The advice as a page in Markdown: the screen, all kernels, modes, properties and models, and the machine.
pub fn advice_page(advice: &Advice, machine: &Machine) -> String {
    let list = |lines: &[String]| lines.iter().map(|line| format!("- {line}\n")).collect::<String>();
    let mut parts = vec![format!(
        "# What {} needs\n\n{}, {}, {}. {}; measured in {} s.",
        advice.scene,
        date(seconds_since_1970(SystemTime::now())),
        machine.cpu,
        machine.rustc,
        size(advice),
        number(advice.seconds, 2)
    )];
    parts.push(format!("**{}**", command(advice)));
    parts.push(list(&advice.reasons));
    parts.extend(
        advice
            .shapes
            .iter()
            .map(|shape| format!("## Every {} kernel\n\n{}", shape.family, grid(shape, true).markdown())),
    );
    parts.push(LEGEND.to_owned());
    let mut modes = Grid::new(1, ["mode", "M rays/s, one thread", "speed", "95 %"]);
    modes.rows.extend(advice.modes.iter().map(|row| {
        let interval = format!("{:.2}–{:.2}", row.gain_low, row.gain_high);
        vec![
            Cell::from(row.mode).best_if(row.mode == advice.mode),
            number(row.mrays_per_second, 3).into(),
            times(Some(row.gain)).into(),
            interval.into(),
        ]
    }));
    parts.push(format!("## Modes\n\nAll modes find the same hits.\n\n{}", modes.markdown()));
    let mut traits = Grid::new(3, ["property", "measured", "what it does", "decides"]);
    traits.rows.extend(advice.traits.iter().map(|row| {
        let decides = if row.decides { "yes" } else { "" };
        vec![Cell::from(row.name).best_if(row.decides), (&*row.text).into(), row.why.into(), decides.into()]
    }));
    parts.push(format!("## Properties of the scene and its rays\n\n{}", traits.markdown()));
    if !advice.models.is_empty() {
        let mut models =
            Grid::new(2, ["simpler model", "what was done", "speed", "95 %", "memory", "rays that hit elsewhere"]);
        models.rows.extend(advice.models.iter().map(|row| {
            vec![
                Cell::from(row.name).best_if(row.is_worth_it),
                (&*row.about).into(),
                times(Some(row.gain)).into(),
                format!("{:.2}–{:.2}", row.gain_low, row.gain_high).into(),
                times(Some(row.bytes[1] as f64 / row.bytes[0] as f64)).into(),
                format!("{} of {}", count(row.changed), count(row.rays)).into(),
            ]
        }));
        parts.push(format!("## Simpler models\n\nBold ones are worth it.\n\n{}", models.markdown()));
    }
    parts.push(format!(
        "## Machine and build\n\n- {} logical processors, {}, target `{}`\n- Target features: {}\n- {}",
        machine.processors,
        machine.os,
        machine.target,
        machine.target_features.join(", "),
        machine.versions.join(", ")
    ));
    parts.iter().map(|part| part.trim_end()).collect::<Vec<_>>().join("\n\n") + "\n"
}

/// How many triangles, quadrics and instances there are.
fn size(advice: &Advice) -> String {
    let size = [(advice.triangles, "triangle"), (advice.quadrics, "quadric"), (advice.instances, "instance")];
    size.into_iter().filter(|(count, _)| *count > 0).map(plural).collect::<Vec<_>>().join(", ")
}

/// `3 triangles`.
fn plural((number, name): (usize, &str)) -> String {
    format!("{} {name}{}", count(number as u64), if number == 1 { "" } else { "s" })
}

/// The line that tells what to use.
fn command(advice: &Advice) -> String {
    let mut line = String::from("Use:");
    for shape in &advice.shapes {
        line += &match shape.family {
            "triangle" => format!(" --kernel {}", advice.kernel),
            _ => format!(" --quadric-kernel {}", advice.quadric_kernel),
        };
    }
    line + &format!(" --mode {}", advice.mode)
}

/// The kernels, the fastest first: all of them, or those that an answer names and those at the frontier.
fn grid(shape: &ShapeAdvice, all: bool) -> Grid {
    let mut grid = Grid::new(1, [shape.family, "speed", "95 %", "wrong", "95 %", "edges", "error", ""]);
    let is_shown = |row: &&KernelRow| all || row.on_frontier || !row.roles.is_empty();
    let others = shape.kernels.iter().filter(|row| !is_shown(row)).count();
    grid.rows = shape.kernels.iter().filter(is_shown).map(row).collect();
    if others > 0 {
        grid.rows.push(vec![format!("and {others} more, slower and no more right").into()]);
    }
    grid
}

fn row(row: &KernelRow) -> Vec<Cell> {
    let [low, high] = row.score.wrong_per_million.map(|end| number(end, 2));
    let rate = |wrong, of| Rate::of_events(wrong, of).map_or(String::new(), |rate| number(rate.per_million(), 2));
    let is_chosen = row.roles.contains(&"chosen");
    let name = row.id.rsplit('/').next().unwrap_or(&row.id);
    vec![
        Cell::from(name).best_if(is_chosen),
        Cell::from(format!("{:.2}", row.gain)).best_if(is_chosen),
        format!("{:.2}–{:.2}", row.gain_low, row.gain_high).into(),
        Cell::from(rate(row.score.wrong, row.score.rays)).bad_if(row.standing == "fails"),
        format!("{low}–{high}").into(),
        rate(row.score.edge_wrong, row.score.edge_rays).into(),
        number(row.score.displacement_p99, 2).into(),
        row.roles.join(", ").into(),
    ]
}

/// Text in lines of at most 110 columns. The first one begins with `start`, and the others are as far to the right.
fn wrapped(start: &str, text: &str) -> String {
    const COLUMNS: usize = 108;
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let last = lines.last_mut().expect("there is a line");
        if !last.is_empty() && last.chars().count() + 1 + word.chars().count() > COLUMNS {
            // A unit stays with its number.
            let is_unit = ["k", "M", "G", "%"].contains(&word.trim_end_matches([',', ')', ':', '.']));
            let number = last.rfind(' ').filter(|_| is_unit).map(|at| last.split_off(at)[1..].to_owned() + " ");
            lines.push(number.unwrap_or_default() + word);
        } else {
            if !last.is_empty() {
                last.push(' ');
            }
            last.push_str(word);
        }
    }
    let indent = format!("\n{}", " ".repeat(start.len()));
    format!("{start}{}\n", lines.join(&indent))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::advice::{Question, advise};
    use crate::study::measure::machine;
    use crate::study::progress::Progress;
    use crate::tracer::SceneSource;
    use std::time::Duration;

    fn advice(scene: &str) -> Advice {
        let question =
            Question { max_wrong: 1000.0, rays: 20_000, budget: Duration::from_millis(300), ..Question::default() };
        advise(scene, SceneSource::parse(scene).unwrap().load().unwrap(), &question, &Progress::spinner()).unwrap()
    }

    #[test]
    fn the_screen_shows_the_choice_and_the_page_shows_everything() {
        let advice = advice("gallery");
        let (screen, page) = (advice_text(&advice, false), advice_page(&advice, &machine::describe()));
        assert!(!screen.contains('\u{1b}') && advice_text(&advice, true).contains('\u{1b}'));
        assert!(screen.lines().all(|line| line.chars().count() <= 112), "{screen}");
        assert!(page.contains(&format!("**{}**", command(&advice))) && screen.ends_with(&(command(&advice) + "\n")));
        for shape in &advice.shapes {
            for kernel in &shape.kernels {
                let name = kernel.id.rsplit('/').next().unwrap();
                let rows = page.lines().filter(|line| line.starts_with(&format!("| {name} |")));
                let best = page.lines().filter(|line| line.starts_with(&format!("| **{name}** |")));
                assert_eq!(rows.count() + best.count(), 1, "{name}");
                let is_chosen = kernel.roles.contains(&"chosen");
                assert_eq!(page.contains(&format!("| **{name}** |")), is_chosen, "{name}");
                assert!(!is_chosen || screen.contains(name), "{name}");
            }
        }
        for reason in &advice.reasons {
            let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(words(&screen).contains(&words(reason)) && page.contains(reason.as_str()), "{reason}");
        }
        assert_eq!(advice.modes.len(), 4);
        assert!(advice.traits.iter().all(|found| page.contains(&found.text.replace('|', "\\|"))));
        assert!(page.contains("9 instances"));
    }

    #[test]
    fn lines_break_between_words_and_units_stay_with_numbers() {
        let text = format!("{} 0 of 797 k, and more", "x".repeat(97));
        assert_eq!(wrapped("- ", &text), format!("- {} 0 of\n  797 k, and more\n", "x".repeat(97)));
        assert_eq!(wrapped("", "a b"), "a b\n");
    }
}
