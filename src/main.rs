//! The `raylanes` program. Its code is in [`program`]: the arguments, and one file for each command.

#![forbid(unsafe_code)]

mod program;

fn main() -> std::process::ExitCode {
    program::main()
}
