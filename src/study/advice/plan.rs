//! A plan: a small TOML file that fixes kernels and mode, so that a tracer can follow advice.

use std::io::Read;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use super::Advice;
use crate::error::quoted;
use crate::files::{Input, write_atomically};
use crate::geom::{Quadric, Triangle};
use crate::registry;
use crate::tracer::{Error, Mode};

/// Kernels and mode for a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// ID of a triangle kernel.
    pub kernel: &'static str,
    /// ID of a quadric kernel.
    pub quadric_kernel: &'static str,
    /// The mode.
    pub mode: Mode,
}

/// The file. Each value has its place, for messages.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanFile {
    kernel: Spanned<String>,
    quadric_kernel: Spanned<String>,
    mode: Spanned<String>,
}

/// Largest size in bytes of a plan.
const MAX_BYTES: u64 = 1 << 20;

impl Plan {
    /// Writes what advice says, and its reasons as comments, which are not read again.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(advice: &Advice, path: &Path) -> Result<(), Error> {
        write_atomically(path, |file| {
            writeln!(file, "# What {} needs, as measured by `raylanes advise`.", advice.scene)?;
            for reason in &advice.reasons {
                writeln!(file, "# - {reason}")?;
            }
            writeln!(file, "\n# Another kernel may change hits.")?;
            writeln!(file, "kernel = \"{}\"\nquadric_kernel = \"{}\"", advice.kernel, advice.quadric_kernel)?;
            writeln!(file, "# Another mode never changes a hit.\nmode = \"{}\"", advice.mode)
        })
    }

    /// Reads a plan. Kernels may be named without their family.
    ///
    /// # Errors
    /// If the file cannot be read, if it has too few or too many keys, or if it names a kernel or a mode that does not
    /// exist in this build.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let mut bytes = Vec::new();
        Input::open(path, MAX_BYTES)?.read_to_end(&mut bytes).map_err(Error::reading(path))?;
        let text = str::from_utf8(&bytes).map_err(|_| Error::in_file(path, "not UTF-8"))?;
        let in_line = |at: usize, message: String| {
            let before = &bytes[..at.min(bytes.len())];
            Error::in_line(path, before.iter().filter(|&&byte| byte == b'\n').count() + 1, message)
        };
        let file: PlanFile = toml::from_str(text)
            .map_err(|error| in_line(error.span().map_or(0, |span| span.start), error.message().to_owned()))?;
        let unknown = |value: &Spanned<String>, what: &str| {
            let message = format!("{}: no such {what}; `raylanes list` shows all", quoted(value.get_ref().as_bytes()));
            in_line(value.span().start, message)
        };
        let [kernel, quadric_kernel] = [&file.kernel, &file.quadric_kernel];
        let mode = Mode::ALL.into_iter().find(|mode| mode.name() == file.mode.get_ref());
        Ok(Self {
            kernel: registry::id_of::<Triangle>(kernel.get_ref()).ok_or_else(|| unknown(kernel, "triangle kernel"))?,
            quadric_kernel: registry::id_of::<Quadric>(quadric_kernel.get_ref())
                .ok_or_else(|| unknown(quadric_kernel, "quadric kernel"))?,
            mode: mode.ok_or_else(|| {
                let names = Mode::ALL.map(Mode::name).join(", ");
                let given = quoted(file.mode.get_ref().as_bytes());
                in_line(file.mode.span().start, format!("{given}: no such mode: expected one of {names}"))
            })?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Plan, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plan.toml");
        std::fs::write(&path, text).unwrap();
        Plan::read(&path).map_err(|error| error.to_string().replace(&format!("{}/", folder.path().display()), ""))
    }

    #[test]
    fn a_plan_names_kernels_and_a_mode() {
        let plan = read("kernel = \"woop\"\nquadric_kernel = 'quadric/stable'\nmode = \"packet\" # fast\n");
        let expected = Plan { kernel: "triangle/woop", quadric_kernel: "quadric/stable", mode: Mode::Packet };
        assert_eq!(plan, Ok(expected));
    }

    #[test]
    fn errors_name_the_line_and_the_value() {
        let rest = "quadric_kernel = 'f64'\nmode = 'auto'\n";
        for (text, expected) in [
            (format!("kernel = 'f64'\n{rest}"), "plan.toml:1: \"f64\": no such triangle kernel"),
            ("\nkernel='woop'\nquadric_kernel='woop'\nmode='auto'".into(), "plan.toml:3: \"woop\": no such quadric"),
            ("kernel='woop'\nquadric_kernel='f64'\nmode='warp'".into(), "plan.toml:3: \"warp\": no such mode"),
            (format!("kernel = 'woop'\nspeed = 3\n{rest}"), "plan.toml:2: unknown field `speed`"),
            ("kernel = 'woop'\nmode = 'auto'\n".into(), "plan.toml:1: missing field `quadric_kernel`"),
            (format!("kernel = 7\n{rest}"), "plan.toml:1: invalid type: integer `7`"),
            (format!("kernel = \n{rest}"), "plan.toml:1: "),
        ] {
            let error = read(&text).unwrap_err();
            assert!(error.starts_with(expected), "{error}");
            assert!(!error.contains('\n'), "{error}");
        }
    }
}
