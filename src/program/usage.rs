//! Reads the arguments, and makes one line of what is wrong with them.

use clap::Parser;
use clap::error::{ContextValue, ErrorKind};
use raylanes::tracer::printable;

use super::args::Arguments;
use super::terminal;

/// What the arguments ask for.
pub(super) enum Request {
    Run(Arguments),
    /// The help or the version, which has been printed.
    Done(Result<(), raylanes::tracer::Error>),
    /// The line that says what is wrong.
    Wrong(String),
}

/// Parses the arguments of the program.
pub(super) fn request() -> Request {
    match Arguments::try_parse() {
        Ok(arguments) => Request::Run(arguments),
        Err(error) if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            Request::Done(terminal::written(error.print()))
        }
        Err(error) => Request::Wrong(one_line(error)),
    }
}

/// The message of `clap` with its expected values and its suggestion, without the usage.
fn one_line(mut error: clap::Error) -> String {
    // What the user gave would be quoted in the message as it is.
    let given = error.context().filter_map(|(kind, value)| match value {
        ContextValue::String(given) => Some((kind, printable(given))),
        _ => None,
    });
    for (kind, given) in given.collect::<Vec<_>>() {
        error.insert(kind, ContextValue::String(given));
    }
    let text = error.render().to_string();
    let end = ["\n\nUsage:", "\n\nFor more information"].iter().filter_map(|end| text.find(end)).min();
    let message = text[..end.unwrap_or(text.len())].trim_start_matches("error: ");
    let parts: Vec<_> = message.lines().map(str::trim).filter(|part| !part.is_empty()).collect();
    parts.join("; ").replace(":; ", ": ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wrong(arguments: &[&str]) -> String {
        let arguments = ["raylanes"].iter().chain(arguments);
        one_line(Arguments::try_parse_from(arguments).err().expect("the arguments are wrong"))
    }

    #[test]
    fn an_error_is_one_line_with_the_expected_values_and_the_suggestion() {
        for (arguments, expected) in [
            (&["paint"][..], "unrecognized subcommand 'paint'"),
            (&["render", "room"], "the following required arguments were not provided: --out <OUT.png>"),
            (
                &["trace", "room", "--mode", "warp"],
                "invalid value 'warp' for '--mode <MODE>'; [possible values: scalar, single, packet, auto]",
            ),
            (
                &["trace", "room", "--mode", "singel"],
                "invalid value 'singel' for '--mode <MODE>'; [possible values: scalar, single, packet, auto]; \
                 tip: a similar value exists: 'single'",
            ),
            (
                &["trace", "room", "--thread", "3"],
                "unexpected argument '--thread' found; tip: a similar argument exists: '--threads'",
            ),
            (
                &["trace", "room", "--size", "a\n\nUsage: b\u{1b}[2J"],
                "invalid value 'a\\n\\nUsage: b\\u{1b}[2J' for '--size <WIDTHxHEIGHT>': \
                 expected WIDTHxHEIGHT with 1 to 67108864 pixels, such as 1024x768",
            ),
        ] {
            assert_eq!(wrong(arguments), expected, "{arguments:?}");
        }
        let long = wrong(&["trace", "room", "--size", &"9".repeat(100_000)]);
        assert!(long.chars().count() < 400 && long.contains("999…999"), "{long}");
    }

    /// Random command lines from a few words, some damaged. A wrong one is one short line.
    #[test]
    fn random_arguments_give_one_line() {
        const WORDS: [&str; 20] = [
            "trace",
            "render",
            "study",
            "list",
            "room",
            "--mode",
            "packet",
            "--size",
            "8x8",
            "--threads",
            "7",
            "--eye",
            "1,2,3",
            "-o",
            "--",
            "-",
            "",
            "\n\nUsage: ",
            "\u{202e}\u{1b}[2J",
            "--shade=lambert",
        ];
        let mut state = 2026u32;
        let mut below = |end: usize| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as usize % end
        };
        let mut wrong = 0;
        for _ in 0..2000 {
            let words: Vec<_> = (0..below(7))
                .map(|_| {
                    let mut word = WORDS[below(WORDS.len())].to_owned();
                    if below(4) == 0 {
                        word.insert(0, ['-', '=', '\n', '\u{2066}', '\0', 'x'][below(6)]);
                    }
                    word
                })
                .collect();
            let Err(error) = Arguments::try_parse_from(["raylanes".to_owned()].into_iter().chain(words.clone())) else {
                continue;
            };
            if error.use_stderr() {
                let line = one_line(error);
                let is_plain = |c: char| !c.is_control() && !('\u{202a}'..='\u{2069}').contains(&c);
                assert!(line.chars().all(is_plain) && !line.is_empty() && line.len() < 900, "{words:?}: {line:?}");
                assert!(!line.contains("For more information"), "{words:?}: {line:?}");
                wrong += 1;
            }
        }
        assert!(wrong > 500, "{wrong}");
    }
}
