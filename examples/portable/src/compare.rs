//! Runs builds of this program in turn, and prints as Markdown what each makes of the same rays.

use std::fs;
use std::process::Command;

/// One kernel in one run: the checksum of its hits, and the times of a scalar and of a packet test in nanoseconds.
struct Row {
    id: String,
    checksum: String,
    times: [f64; 2],
}

/// The program's output for one kernel, made by `Rows` in `main.rs`.
fn row(line: &str) -> Option<Row> {
    let mut fields = line.split('\t');
    let (id, checksum) = (fields.next()?.into(), fields.next()?.into());
    Some(Row { id, checksum, times: [fields.next()?.parse().ok()?, fields.next()?.parse().ok()?] })
}

fn output(command: &str) -> Result<String, String> {
    let mut words = command.split_whitespace();
    let output = Command::new(words.next().unwrap_or_default()).args(words).output();
    let output = output.map_err(|error| format!("{command}: {error}"))?;
    if !output.status.success() {
        return Err(format!("{command}: {}: {}", output.status, String::from_utf8_lossy(&output.stderr).trim()));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn run(command: &str) -> Result<Vec<Row>, String> {
    let output = output(command)?;
    let rows = output.lines().filter(|line| !line.starts_with('#'));
    let rows: Result<Vec<_>, _> =
        rows.map(|line| row(line).ok_or_else(|| format!("{command}: expected a kernel, found '{line}'"))).collect();
    rows.and_then(|rows| if rows.is_empty() { Err(format!("{command}: no kernel found")) } else { Ok(rows) })
}

/// The middle number; 0 if there is none.
fn median(mut numbers: Vec<f64>) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers.get(numbers.len() / 2).copied().unwrap_or(0.0)
}

/// Compares builds, each given as `NAME=COMMAND`, with the first of them, which must have every kernel.
///
/// # Errors
/// One line, if a build does not run, or if its hits differ from those of the first.
pub(crate) fn compare(rounds: usize, builds: &[String]) -> Result<(), String> {
    let split = |build: &String| {
        let (name, command) = build.split_once('=').ok_or_else(|| format!("expected NAME=COMMAND, found '{build}'"))?;
        Ok((name.to_owned(), command.to_owned()))
    };
    let builds = builds.iter().map(split).collect::<Result<Vec<_>, String>>()?;
    // By round, build and kernel.
    let one_round = |_| builds.iter().map(|(_, command)| run(command)).collect::<Result<Vec<_>, String>>();
    let runs = (0..rounds).map(one_round).collect::<Result<Vec<_>, String>>()?;

    let find = |round: usize, build: usize, id: &str| runs[round][build].iter().find(|row| row.id == id);
    // The times relative to the first build, one for each round. `None` if the build lacks the kernel.
    let ratios = |build: usize, id: &str, width: usize| -> Option<Vec<f64>> {
        let ratio = |round| Some(find(round, build, id)?.times[width] / find(round, 0, id)?.times[width]);
        (0..rounds).map(ratio).collect()
    };
    let relative = |build: usize, id: &str, width: usize| ratios(build, id, width).map(median);
    let differs = |build: usize, row: &Row| {
        (0..rounds).any(|round| find(round, build, &row.id).is_some_and(|other| other.checksum != row.checksum))
    };
    let kernels = &runs[0][0];
    let spread = |build: usize, id: &str| {
        let ratios = ratios(build, id, 1)?;
        let middle = median(ratios.clone());
        Some(median(ratios.iter().map(|ratio| (ratio / middle - 1.0).abs() * 100.0).collect()))
    };
    let spreads = (1..builds.len()).flat_map(|build| kernels.iter().filter_map(move |row| spread(build, &row.id)));
    let cpu = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let cpu = cpu.lines().find_map(|line| line.strip_prefix("model name")).unwrap_or(": an unknown processor");
    println!("# The kernels on several targets\n");
    println!(
        "{rounds} rounds; in each, every build had one turn. Times are relative to {}: medians of the",
        builds[0].0
    );
    println!(
        "rounds' ratios. The median ratio of packets was {:.1} % away from its median.",
        median(spreads.collect())
    );
    println!(
        "Compiled by {}. Measured on{}.\n",
        output("rustc --version")?.trim(),
        cpu.trim_start_matches(['\t', ':'])
    );

    println!("| build | kernels | with the same hits | scalar time: median kernel (least to greatest) | packet time |");
    println!("| --- | --- | --- | --- | --- |");
    for (build, (name, _)) in builds.iter().enumerate() {
        let has = |row: &&Row| find(0, build, &row.id).is_some();
        let equal = kernels.iter().filter(has).filter(|row| !differs(build, row)).count();
        let [scalar, packet] = [0, 1].map(|width| {
            let mut ratios: Vec<_> = kernels.iter().filter_map(|row| relative(build, &row.id, width)).collect();
            ratios.sort_by(f64::total_cmp);
            let [least, greatest] = [ratios.first(), ratios.last()].map(|ratio| ratio.copied().unwrap_or(0.0));
            format!("{:.2} ({least:.2} to {greatest:.2})", median(ratios))
        });
        println!("| {name} | {} | {equal} | {scalar} | {packet} |", runs[0][build].len());
    }

    let names: Vec<_> = builds.iter().skip(1).map(|(name, _)| name.as_str()).collect();
    println!(
        "\n| kernel | checksum of its hits | {}, ns per packet test and ray | {} |",
        builds[0].0,
        names.join(" | ")
    );
    println!("| --- | --- | --- |{}", " --- |".repeat(names.len()));
    for Row { id, checksum, .. } in kernels {
        let own = median((0..rounds).filter_map(|round| Some(find(round, 0, id)?.times[1])).collect());
        let others: Vec<_> = (1..builds.len())
            .map(|build| relative(build, id, 1).map_or_else(|| "absent".into(), |ratio| format!("{ratio:.2}")))
            .collect();
        println!("| `{id}` | `{checksum}` | {own:.2} | {} |", others.join(" | "));
    }

    for (build, (name, _)) in builds.iter().enumerate() {
        if let Some(row) = kernels.iter().find(|row| differs(build, row)) {
            return Err(format!("{name}: hits of {} differ from those of {}", row.id, builds[0].0));
        }
    }
    Ok(())
}
