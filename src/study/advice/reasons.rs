//! The answer in sentences: what to use, what else there is, and what each costs.

use super::{Advice, ModeRow, ModelRow, Score, ShapeAdvice};
use crate::study::figures::choice::{Candidate, Choice, Standing};
use crate::study::figures::{Rate, count, number, severity, si, times};
use crate::study::measure::stats::Estimate;
use crate::tracer::Mode;

/// One sentence or two for each thing that speaks for the answer.
pub(super) fn of(advice: &Advice) -> Vec<String> {
    let mut reasons: Vec<String> = advice.shapes.iter().flat_map(|shape| of_shape(advice, shape)).collect();
    reasons.extend(hard(advice));
    reasons.extend(mode(advice));
    reasons.extend(advice.scored.as_ref().map(|score| scored(advice, score)));
    reasons.extend(advice.models.iter().filter(|model| model.is_worth_it).map(|row| model("Simpler", row)));
    let worth_it = advice.models.iter().filter(|model| model.is_worth_it).count();
    reasons.extend(advice.simpler.as_ref().filter(|_| worth_it > 1).map(|row| model("All of these", row)));
    reasons
}

/// A rate, and in brackets its interval.
pub(super) fn rate(rate: Rate) -> String {
    let [low, high] = rate.interval();
    if rate.events == 0 {
        format!("0 of {} (95 %: fewer than {} per million)", si(rate.of as f64, 3), number(high, 2))
    } else {
        format!(
            "{} of {} ({} per million; 95 %: {} to {})",
            count(rate.events),
            si(rate.of as f64, 3),
            number(rate.per_million(), 2),
            number(low, 2),
            number(high, 2)
        )
    }
}

/// A ratio of times, and its interval.
fn gain(gain: Option<Estimate>) -> String {
    let interval = gain.map_or(String::new(), |gain| format!(" ({:.2} to {:.2})", gain.low, gain.high));
    times(gain.map(|gain| gain.value)) + &interval
}

/// The need in words.
fn need(advice: &Advice) -> String {
    if advice.max_wrong_per_million == 0.0 {
        "claims to be always right, and is, also at edges".into()
    } else {
        format!("gets at most {} rays per million wrong", severity(advice.max_wrong_per_million))
    }
}

fn of_shape(advice: &Advice, shape: &ShapeAdvice) -> Vec<String> {
    let choice = &shape.choice;
    let family = shape.family;
    let all = choice.candidates.len();
    let mut lines = Vec::new();
    let Some(chosen) = choice.chosen() else {
        let least = choice.least_wrong();
        let open = choice.standings.contains(&Standing::Open);
        let why = if open { "These rays cannot show that any of the" } else { "None of the" };
        lines.push(format!(
            "{why} {all} {family} kernels {}. Wrong least often is {}: {}.{}",
            need(advice),
            least.name(),
            rate(least.answers.wrong),
            if open { " A larger --budget gives more rays." } else { "" }
        ));
        return lines;
    };
    let ties: Vec<_> = choice.ties.iter().map(|&number| choice.candidates[number].name()).collect();
    let tie = match &ties[..] {
        [] => String::new(),
        [first, second, third, others @ ..] if others.len() > 1 => {
            format!(" A tie with {first}, {second}, {third} and {} more: it is the most careful.", others.len())
        }
        names => format!(" A tie with {}: it is the most careful.", names.join(", ")),
    };
    lines.push(format!(
        "Of {all} {family} kernels, {} is the fastest one that {}: {}.{tie}",
        chosen.name(),
        need(advice),
        rate(chosen.answers.wrong)
    ));
    let other = |number: Option<usize>| number.map(|number| &choice.candidates[number]);
    if let Some(runner_up) = other(choice.runner_up).filter(|_| choice.ties.is_empty()) {
        lines.push(format!("Runner-up: {} is {} as fast.", runner_up.name(), gain(runner_up.gain_over(chosen))));
    }
    lines.push(match other(choice.cheaper) {
        Some(cheaper) => loss(choice, cheaper, chosen),
        None => "No kernel is faster by more than the noise.".into(),
    });
    lines.extend(other(choice.careful).map(|careful| price(careful, chosen)));
    lines
}

/// What a faster kernel gives, and what it loses.
fn loss(choice: &Choice, cheaper: &Candidate, chosen: &Candidate) -> String {
    let number = choice.candidates.iter().position(|other| other.id == cheaper.id);
    let open = number.is_some_and(|number| choice.standings[number] == Standing::Open);
    let doubt = if open { " That may be enough, but these rays cannot tell." } else { "" };
    format!(
        "Cheaper: {} is {} as fast, and gets {} wrong.{doubt}",
        cheaper.name(),
        gain(cheaper.gain_over(chosen)),
        rate(cheaper.answers.wrong)
    )
}

/// What a more careful kernel costs, and what it gives.
fn price(careful: &Candidate, chosen: &Candidate) -> String {
    let edges = |candidate: &Candidate| candidate.answers.at_edges.map_or("none".into(), rate);
    let ties_at_edges =
        careful.answers.at_edges.zip(chosen.answers.at_edges).is_none_or(|(own, other)| own.ties_with(other));
    let gives = if careful.answers.wrong.ties_with(chosen.answers.wrong) && ties_at_edges {
        "These rays show no difference, but it claims to be always right.".to_owned()
    } else if careful.answers.wrong.ties_with(chosen.answers.wrong) {
        format!("Aimed at edges, it gets {} wrong, and {} {}.", edges(careful), chosen.name(), edges(chosen))
    } else {
        format!("It gets {} wrong.", rate(careful.answers.wrong))
    };
    format!("More careful: {} takes {} the time. {gives}", careful.name(), gain(chosen.gain_over(careful)))
}

fn mode(advice: &Advice) -> Option<String> {
    let row = |name: &str| advice.modes.iter().find(|row| row.mode == name);
    let auto = row(Mode::Auto.name())?;
    let next = |row: &&ModeRow| row.mode != advice.mode;
    let second = advice.modes.iter().filter(next).max_by(|a, b| a.gain.total_cmp(&b.gain))?;
    let own = row(advice.mode).unwrap_or(auto);
    let why = if own.gain >= second.gain { "is the fastest" } else { "ties with the fastest" };
    Some(format!(
        "Mode {} {why}: {} Mrays/s in one thread; {} {}. A mode never changes a hit; another kernel may.",
        advice.mode,
        number(own.mrays_per_second, 3),
        second.mode,
        number(second.mrays_per_second, 3)
    ))
}

/// The score, and whether it confirms the choice.
fn scored(advice: &Advice, score: &Score) -> String {
    let wrong = Rate { events: score.wrong, of: score.rays };
    let [low, high] = wrong.interval();
    let is_chosen = advice.shapes.iter().all(|shape| shape.choice.chosen.is_some());
    let verdict = match advice.max_wrong_per_million {
        most if !is_chosen || most == 0.0 => "",
        most if high <= most => " This confirms the choice.",
        most if low > most => " This refutes the choice.",
        _ => " This neither confirms nor refutes the choice.",
    };
    let edges = Rate::of_events(score.edge_wrong, score.edge_rays)
        .map_or(String::new(), |edges| format!(" Of others aimed at edges: {}.", rate(edges)));
    format!("On rays that had no part in it: {} wrong.{verdict}{edges}", rate(wrong))
}

/// What is hard about the scene.
fn hard(advice: &Advice) -> Vec<String> {
    let deciding: Vec<_> = advice.traits.iter().filter(|property| property.decides).collect();
    if deciding.is_empty() {
        return vec!["Nothing about the scene is hard for kernels: every property is within its limits.".into()];
    }
    deciding.iter().map(|property| format!("Hard: {}. {}.", property.text, capitalised(property.why))).collect()
}

fn capitalised(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// What a simpler model gains, and which hits it changes.
fn model(title: &str, row: &ModelRow) -> String {
    let [before, after] = row.bytes.map(|bytes| number(bytes as f64 / 1e6, 3));
    let kernel = row.kernel.as_ref().map_or(String::new(), |id| format!(" with {id}, which then suffices"));
    let gain = gain(Some(Estimate { value: row.gain, low: row.gain_low, high: row.gain_high }));
    let deviation = match row.deviation {
        0.0 => "the surface is the same".to_owned(),
        deviation => format!("the surface moves by up to {}", number(deviation, 2)),
    };
    format!(
        "{title}: {}. That is {gain} as fast{kernel}, and takes {after} MB instead of {before} MB; {deviation}, and {} \
         of {} rays hit elsewhere.",
        row.about,
        count(row.changed),
        count(row.rays)
    )
}
