//! Sharp cases: single rays chosen to show differences between methods, and the outcome of every kernel for each of
//! them.
//!
//! `tests/cases/triangles.toml`, `boxes.toml`, `quadrics.toml` and `transforms.toml` contain the cases: their numbers,
//! source, purpose and truth. The oracle must confirm the truth, and so must its filter where it is sure. The
//! `.expected` files pin the outcome of every kernel to the bit, right or wrong. So a change for the better shows too.
//!
//! # To add a case
//!
//! 1. Append a `[[case]]` to the TOML file, in `transforms.toml` a `[[triangle]]`, `[[box]]` or `[[quadric]]`. The
//!    comment at the top of the file explains the fields.
//! 2. Run `RAYLANES_BLESS=1 cargo test --test cases`, which rewrites the `.expected` files.
//! 3. Read the difference. A wrong outcome is marked `<-`; it is pinned like any other.
//!
//! A new kernel has no pinned lines. Its test fails until they are written, as in step 2, and read.
//!
//! # To read an `.expected` file
//!
//! A case starts with its name. Then come `exact`, the correctly rounded answer, and one line for each kernel. A hit
//! prints `t`, `u` and `v` (of a box: entry, exit, 0; of a quadric: u = v = 0) in decimal and in bits. In a mesh, `#n`
//! is its n-th triangle, and the end of the line counts the triangles that are hit. `<-` marks a false miss, a false
//! hit, a leak, a double hit, and a `t` whose error is more than rounding. A miss on a `boundary` is not a false miss.
//!
//! Some kernels exist only in builds with FMA. A build without them keeps their lines and does not test them.

mod harness;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use glam::{Affine3, Mat3, Vec3};
use libtest_mimic::Trial;
use raylanes::geom::{Aabb, Hit, Placed, Quadric, Ray, Shape, Triangle};
use raylanes::kernels::{Intersect, Kernel};
use raylanes::oracle::{Exact, Truth};
use raylanes::registry::{self, Registered, Visitor};
use serde::Deserialize;
use serde::de::{DeserializeOwned, Error, Visitor as Fields};
use toml::Spanned;
use wide::f32x8;

const HOW_TO_BLESS: &str = "if this is intended: RAYLANES_BLESS=1 cargo test --test cases, then read the difference";

/// The name of the line with the correctly rounded answer. Kernels have IDs in its place.
const EXACT: &str = "exact";

/// Errors of `t` up to this many ulp are printed but not marked.
const ROUNDING: u32 = 64;

fn main() -> ExitCode {
    let groups = vec![
        vec![
            harness::test("numbers_are_read_to_the_bit", numbers_are_read_to_the_bit),
            harness::test("blessing_keeps_the_lines_of_absent_kernels", blessing_keeps_the_lines_of_absent_kernels),
        ],
        tests("triangles", |text, results| results.add(text, &parse::<FileData<TriangleData>>(text)?.case)),
        tests("boxes", |text, results| results.add(text, &parse::<FileData<BoxData>>(text)?.case)),
        tests("quadrics", |text, results| results.add(text, &parse::<FileData<QuadricData>>(text)?.case)),
        tests("transforms", |text, results| {
            let file: PlacedFileData = parse(text)?;
            results.add(text, &file.triangle)?;
            results.add(text, &file.cuboid)?;
            results.add(text, &file.quadric)
        }),
    ];
    harness::run(groups, registry::all)
}

/// The tests of one file: the truth that it states, and the pinned outcomes of each kernel.
///
/// # Panics
///
/// If the file cannot be read or has an error.
fn tests(name: &'static str, add: impl Fn(&str, &mut Results) -> Result<(), String>) -> Vec<Trial> {
    // Relative paths give readable messages: cargo runs tests in the folder of the package.
    let folder = Path::new("tests/cases");
    let path = folder.join(name).with_extension("toml");
    let text = fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut results = Results::default();
    add(&text, &mut results).unwrap_or_else(|error| panic!("{}: {error}", path.display()));

    let expected = folder.join(name).with_extension("expected");
    let is_right = results.wrong_truths.is_empty() && results.different_twins.values().all(Vec::is_empty);
    if std::env::var_os("RAYLANES_BLESS").is_some_and(|value| value == "1") && is_right {
        fs::write(&expected, Pinned::read(&expected).blessed(name, &results.outcomes)).unwrap();
    }
    let (pinned, results) = (Arc::new(Pinned::read(&expected)), Arc::new(results));
    let fail = move |failures: &[String]| {
        if failures.is_empty() {
            return Ok(String::new());
        }
        Err(format!("{}:\n{}\n{HOW_TO_BLESS}", expected.display(), failures.join("\n")))
    };
    let mut trials: Vec<_> = present(&results.outcomes)
        .into_iter()
        .filter(|kernel| *kernel != EXACT)
        .map(|kernel| {
            let (kernel, pinned, results, fail) = (kernel.to_owned(), pinned.clone(), results.clone(), fail.clone());
            harness::of_kernel("cases", kernel.clone(), move || match results.different_twins.get(&kernel) {
                Some(differences) if !differences.is_empty() => Err(differences.join("\n")),
                _ => fail(&pinned.compare(&kernel, &results.outcomes)),
            })
        })
        .collect();
    trials.push(harness::test(&format!("the_stated_truth_of_{name}_is_that_of_the_oracle"), move || {
        assert!(results.wrong_truths.is_empty(), "{}:\n{}", path.display(), results.wrong_truths.join("\n"));
        let mut failures = pinned.compare(EXACT, &results.outcomes);
        failures.extend(pinned.gone(&results.outcomes));
        if let Err(message) = fail(&failures) {
            panic!("{message}");
        }
    }));
    trials
}

/// The results of the cases of a file.
#[derive(Default)]
struct Results {
    names: BTreeSet<String>,
    /// Messages about wrong truths in the file.
    wrong_truths: Vec<String>,
    /// For each kernel, messages about differing twins.
    different_twins: BTreeMap<String, Vec<String>>,
    outcomes: Vec<Outcome>,
}

impl Results {
    /// Adds the cases of one shape. `text` is the text of the file.
    fn add<D: Data>(&mut self, text: &str, data: &[CaseData<D>]) -> Result<(), String> {
        let cases = parse_cases(text, data, &mut self.names)?;
        self.wrong_truths.extend(check_truth(&cases));
        let mut outcomes = Outcomes { cases: &cases, kernels: Vec::new() };
        D::Shape::visit_kernels(&mut outcomes);
        for kernel in &mut outcomes.kernels {
            self.different_twins.insert(kernel.id.clone(), std::mem::take(&mut kernel.different_twins));
        }
        self.outcomes.extend(Outcome::of_all(&cases, &truths(&cases), outcomes.kernels));
        Ok(())
    }
}

// ---- The cases -----------------------------------------------------------------------------------------------------

/// A number as written. Decimals are rounded once, from their digits to `f32`. A string contains the bits.
#[derive(Clone, Copy)]
enum Written {
    Digits,
    Bits(u32),
}

impl<'de> Deserialize<'de> for Written {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Number;
        impl Fields<'_> for Number {
            type Value = Written;

            fn expecting(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
                f.write_str("a number, or the bits of one, such as \"0x3f800000\"")
            }
            fn visit_i64<E: Error>(self, _: i64) -> Result<Written, E> {
                Ok(Written::Digits)
            }
            fn visit_f64<E: Error>(self, _: f64) -> Result<Written, E> {
                Ok(Written::Digits)
            }
            fn visit_str<E: Error>(self, text: &str) -> Result<Written, E> {
                let bits = text.strip_prefix("0x").filter(|digits| digits.len() == 8);
                bits.and_then(|digits| u32::from_str_radix(digits, 16).ok())
                    .map(Written::Bits)
                    .ok_or_else(|| E::invalid_value(serde::de::Unexpected::Str(text), &self))
            }
        }
        deserializer.deserialize_any(Number)
    }
}

type Number = Spanned<Written>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FileData<D> {
    case: Vec<CaseData<D>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlacedFileData {
    triangle: Vec<CaseData<PlacedData<TriangleData>>>,
    #[serde(rename = "box")]
    cuboid: Vec<CaseData<PlacedData<BoxData>>>,
    quadric: Vec<CaseData<PlacedData<QuadricData>>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CaseData<D> {
    name: Spanned<String>,
    source: String,
    why: String,
    #[serde(alias = "triangles", alias = "boxes", alias = "quadrics", alias = "placed")]
    shapes: Vec<D>,
    ray: RayData,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RayData {
    origin: [Number; 3],
    dir: [Number; 3],
    t_min: Option<Number>,
    t_max: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct TriangleData {
    v0: [Number; 3],
    v1: [Number; 3],
    v2: [Number; 3],
    truth: Verdict,
    t: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BoxData {
    lo: [Number; 3],
    hi: [Number; 3],
    truth: Verdict,
    t: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct QuadricData {
    squares: [Number; 3],
    products: Option<[Number; 3]>,
    linear: Option<[Number; 3]>,
    constant: Option<Number>,
    lo: [Number; 3],
    hi: [Number; 3],
    truth: Verdict,
    t: Option<Number>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlacedData<D> {
    object: D,
    columns: [[Number; 3]; 3],
    translation: [Number; 3],
}

#[derive(Clone, Copy, Debug, Deserialize, PartialEq)]
#[serde(rename_all = "lowercase")]
enum Verdict {
    Hit,
    Miss,
}

/// A shape as written in the file.
trait Data: DeserializeOwned {
    type Shape: Registered + Exact;
    /// The type of its bounds.
    type Bounds: Exact;

    fn shape(&self, numbers: &Numbers) -> Result<Self::Shape, String>;
    fn truth(&self) -> (Verdict, Option<&Number>);
    /// The bounds of the shape; `None` for a box, which is its own.
    fn bounds(shape: &Self::Shape) -> Option<Self::Bounds>;
}

impl Data for TriangleData {
    type Shape = Triangle;
    type Bounds = Aabb;

    fn shape(&self, numbers: &Numbers) -> Result<Triangle, String> {
        Ok(Triangle { v0: numbers.vector(&self.v0)?, v1: numbers.vector(&self.v1)?, v2: numbers.vector(&self.v2)? })
    }

    fn truth(&self) -> (Verdict, Option<&Number>) {
        (self.truth, self.t.as_ref())
    }

    fn bounds(shape: &Triangle) -> Option<Aabb> {
        Some(shape.bounds())
    }
}

impl Data for BoxData {
    type Shape = Aabb;
    type Bounds = Aabb;

    fn shape(&self, numbers: &Numbers) -> Result<Aabb, String> {
        Ok(Aabb { lo: numbers.vector(&self.lo)?, hi: numbers.vector(&self.hi)? })
    }

    fn truth(&self) -> (Verdict, Option<&Number>) {
        (self.truth, self.t.as_ref())
    }

    fn bounds(_: &Aabb) -> Option<Aabb> {
        None
    }
}

impl Data for QuadricData {
    type Shape = Quadric;
    type Bounds = Aabb;

    fn shape(&self, numbers: &Numbers) -> Result<Quadric, String> {
        let vector = |written: &Option<[Number; 3]>| written.as_ref().map_or(Ok(Vec3::ZERO), |v| numbers.vector(v));
        Ok(Quadric {
            squares: numbers.vector(&self.squares)?,
            products: vector(&self.products)?,
            linear: vector(&self.linear)?,
            constant: self.constant.as_ref().map_or(Ok(0.0), |constant| numbers.scalar(constant))?,
            clip: Aabb { lo: numbers.vector(&self.lo)?, hi: numbers.vector(&self.hi)? },
        })
    }

    fn truth(&self) -> (Verdict, Option<&Number>) {
        (self.truth, self.t.as_ref())
    }

    fn bounds(shape: &Quadric) -> Option<Aabb> {
        Some(shape.bounds())
    }
}

impl<D: Data> Data for PlacedData<D>
where
    Placed<D::Shape>: Registered + Exact,
    Placed<D::Bounds>: Exact,
{
    type Shape = Placed<D::Shape>;
    type Bounds = Placed<D::Bounds>;

    fn shape(&self, numbers: &Numbers) -> Result<Self::Shape, String> {
        let [x, y, z] = &self.columns;
        let matrix3 = Mat3::from_cols(numbers.vector(x)?, numbers.vector(y)?, numbers.vector(z)?);
        let object_to_world = Affine3 { matrix3, translation: numbers.vector(&self.translation)? };
        Ok(Placed { shape: self.object.shape(numbers)?, object_to_world })
    }

    fn truth(&self) -> (Verdict, Option<&Number>) {
        self.object.truth()
    }

    fn bounds(shape: &Self::Shape) -> Option<Self::Bounds> {
        Some(Placed { shape: D::bounds(&shape.shape)?, object_to_world: shape.object_to_world })
    }
}

struct Case<S> {
    name: String,
    shapes: Vec<S>,
    stated: Vec<(Verdict, Option<f32>)>,
    ray: Ray<f32>,
    /// Entry and exit of the ray at the bounds of each shape, if it meets them. A hit far outside of the bounds is the
    /// worst kind of false hit.
    bounds: Vec<Option<(f32, f32)>>,
}

/// The text of a file. The spans of numbers are places in it.
struct Numbers<'a> {
    text: &'a str,
}

impl Numbers<'_> {
    fn line(&self, offset: usize) -> usize {
        1 + self.text[..offset].matches('\n').count()
    }

    fn scalar(&self, number: &Number) -> Result<f32, String> {
        match *number.get_ref() {
            Written::Bits(bits) => Ok(f32::from_bits(bits)),
            Written::Digits => {
                let digits = self.text[number.span()].replace('_', "");
                let line = self.line(number.span().start);
                let value: f32 =
                    digits.parse().map_err(|_| format!("line {line}: {digits} is not a decimal number"))?;
                if value.is_infinite() && !digits.contains("inf") {
                    return Err(format!("line {line}: {digits} is too large for f32"));
                }
                Ok(value)
            }
        }
    }

    fn vector(&self, numbers: &[Number; 3]) -> Result<Vec3, String> {
        let [x, y, z] = numbers;
        Ok(Vec3::new(self.scalar(x)?, self.scalar(y)?, self.scalar(z)?))
    }
}

fn parse<F: DeserializeOwned>(text: &str) -> Result<F, String> {
    toml::from_str(text).map_err(|error| error.to_string())
}

fn parse_cases<D: Data>(
    text: &str,
    data: &[CaseData<D>],
    names: &mut BTreeSet<String>,
) -> Result<Vec<Case<D::Shape>>, String> {
    data.iter().map(|data| parse_case(data, &Numbers { text }, names)).collect()
}

fn parse_case<D: Data>(
    data: &CaseData<D>,
    numbers: &Numbers,
    names: &mut BTreeSet<String>,
) -> Result<Case<D::Shape>, String> {
    let name = data.name.get_ref().as_str();
    let fail = |what: &str| Err(format!("line {}: case {name:?} {what}", numbers.line(data.name.span().start)));
    if name.is_empty() || !name.chars().all(|c| c.is_ascii_alphanumeric() || c == '-') {
        return fail("must be named with letters, digits and hyphens only");
    }
    if !names.insert(name.to_owned()) {
        return fail("exists twice");
    }
    if data.source.trim().is_empty() || data.why.trim().is_empty() || data.why.contains('\n') {
        return fail("must have a source, and a `why` of one line");
    }
    if data.shapes.is_empty() {
        return fail("has no shapes");
    }
    let interval = |number: &Option<Number>, default| number.as_ref().map_or(Ok(default), |n| numbers.scalar(n));
    let ray = Ray {
        origin: numbers.vector(&data.ray.origin)?,
        t_min: interval(&data.ray.t_min, 0.0)?,
        dir: numbers.vector(&data.ray.dir)?,
        t_max: interval(&data.ray.t_max, f32::INFINITY)?,
    };
    let shapes = data.shapes.iter().map(|shape| shape.shape(numbers)).collect::<Result<Vec<_>, _>>()?;
    let stated = data.shapes.iter().map(|shape| {
        let (verdict, t) = shape.truth();
        Ok((verdict, t.map(|t| numbers.scalar(t)).transpose()?))
    });
    let stated = stated.collect::<Result<_, String>>()?;
    let bounds = shapes.iter().map(|shape| {
        let Some(bounds) = D::bounds(shape) else {
            return Some((f32::NEG_INFINITY, f32::INFINITY));
        };
        let truth = bounds.truth(&ray);
        truth.hit.then_some((truth.t, truth.u))
    });
    let bounds = bounds.collect();
    Ok(Case { name: name.to_owned(), shapes, stated, ray, bounds })
}

// ---- The truth -----------------------------------------------------------------------------------------------------

fn truths<S: Exact>(cases: &[Case<S>]) -> Vec<Vec<Truth>> {
    cases.iter().map(|case| case.shapes.iter().map(|shape| shape.truth_exact(&case.ray)).collect()).collect()
}

/// Compares the truth in the file with the oracle, and the filter of the oracle with its exact arithmetic.
fn check_truth<S: Exact>(cases: &[Case<S>]) -> Vec<String> {
    let mut failures = Vec::new();
    for (case, truths) in cases.iter().zip(truths(cases)) {
        for (index, (truth, (verdict, t))) in truths.iter().zip(&case.stated).enumerate() {
            let exact = print_truth(truth);
            if let Some(filtered) = case.shapes[index].truth_filtered(&case.ray).filter(|filtered| filtered != truth) {
                let filtered = print_truth(&filtered);
                failures.push(format!("{} #{index}: the filter says {filtered}, the oracle: {exact}", case.name));
            }
            if truth.hit != (*verdict == Verdict::Hit) {
                failures.push(format!("{} #{index}: the file states {verdict:?}, the oracle: {exact}", case.name));
            } else if let Some(t) = t.filter(|t| *t != truth.t) {
                failures.push(format!("{} #{index}: the file states t = {t:?}, the oracle: {exact}", case.name));
            }
        }
    }
    failures
}

// ---- The outcomes of the kernels -----------------------------------------------------------------------------------

struct KernelHits {
    id: String,
    /// Messages about lanes in which the packet twin differs from the scalar one.
    different_twins: Vec<String>,
    /// For each case and each of its shapes.
    hits: Vec<Vec<Hit<f32>>>,
}

struct Outcomes<'a, S> {
    cases: &'a [Case<S>],
    kernels: Vec<KernelHits>,
}

impl<S: Shape> Visitor<S> for Outcomes<'_, S> {
    fn visit<K: Kernel<Shape = S>>(&mut self) {
        let (mut hits, mut different_twins) = (Vec::new(), Vec::new());
        for (index, case) in self.cases.iter().enumerate() {
            let of_shape = |shape| {
                let primitive = K::prepare(shape);
                let scalar = Intersect::<f32>::hit(&primitive, &case.ray);
                different_twins.extend(packet_differs(self.cases, index, &primitive, &scalar));
                scalar
            };
            hits.push(case.shapes.iter().map(of_shape).collect());
        }
        self.kernels.push(KernelHits { id: K::INFO.id.to_string(), different_twins, hits });
    }
}

/// Tests the ray in every lane of a packet; the other lanes hold the rays of the following cases.
fn packet_differs<K: Kernel>(
    cases: &[Case<K::Shape>],
    index: usize,
    primitive: &K,
    scalar: &Hit<f32>,
) -> Option<String> {
    (0..8).find_map(|lane| {
        let packet =
            Ray::from_lanes(&std::array::from_fn(|other| cases[(index + (other + 8 - lane) % 8) % cases.len()].ray));
        let got = Intersect::<f32x8>::hit(primitive, &packet).lane(lane);
        (got.to_bits() != scalar.to_bits()).then(|| {
            let (name, id) = (&cases[index].name, K::INFO.id);
            format!("{name} {id}: twins differ\n  scalar  {}\n  lane {lane}  {}", print_hit(scalar), print_hit(&got))
        })
    })
}

/// The lines of one case.
struct Outcome {
    case: String,
    /// `exact` and the kernels, in the order of the registry.
    lines: Vec<(String, String)>,
}

impl Outcome {
    fn of_all<S>(cases: &[Case<S>], truths: &[Vec<Truth>], kernels: Vec<KernelHits>) -> Vec<Self> {
        let mut outcomes: Vec<_> = cases
            .iter()
            .zip(truths)
            .map(|(case, truths)| Self { case: case.name.clone(), lines: vec![(EXACT.to_owned(), exact_line(truths))] })
            .collect();
        for KernelHits { id, hits, .. } in kernels {
            for (index, hits) in hits.iter().enumerate() {
                let line = kernel_line(&cases[index], &truths[index], hits);
                outcomes[index].lines.push((id.clone(), line));
            }
        }
        outcomes
    }
}

fn print_truth(truth: &Truth) -> String {
    if !truth.hit {
        return "miss".to_owned();
    }
    let boundary = if truth.boundary { ", boundary" } else { "" };
    format!("hit {}{boundary}", print_parameters(truth.t, truth.u, truth.v))
}

fn print_hit(hit: &Hit<f32>) -> String {
    if hit.mask { format!("hit {}", print_parameters(hit.t, hit.u, hit.v)) } else { "miss".to_owned() }
}

fn print_parameters(t: f32, u: f32, v: f32) -> String {
    [("t", t), ("u", u), ("v", v)].map(|(name, x)| format!("{name}={x:?}/{:08x}", x.to_bits())).join(" ")
}

/// Joins the parts of a line. Several parts are numbered.
fn join(parts: &[String]) -> String {
    if let [part] = parts {
        return part.clone();
    }
    let numbered = parts.iter().enumerate().map(|(index, part)| format!("#{index} {part}"));
    numbered.collect::<Vec<_>>().join("; ")
}

fn exact_line(truths: &[Truth]) -> String {
    let mut line = join(&truths.iter().map(print_truth).collect::<Vec<_>>());
    if truths.len() > 1 {
        write!(line, "; mesh: {} hit", truths.iter().filter(|truth| truth.hit).count()).unwrap();
    }
    line
}

fn kernel_line<S>(case: &Case<S>, truths: &[Truth], hits: &[Hit<f32>]) -> String {
    let parts = hits.iter().zip(truths).zip(&case.bounds);
    let parts: Vec<_> = parts.map(|((hit, truth), bounds)| print_hit(hit) + &judge(hit, truth, *bounds)).collect();
    let mut line = join(&parts);
    if hits.len() > 1 {
        let exact = truths.iter().filter(|truth| truth.hit).count();
        let inside = exact == 1 && !truths.iter().any(|truth| truth.boundary);
        let got = hits.iter().filter(|hit| hit.mask).count();
        let mark = match got {
            0 if exact > 0 => " <- leak",
            2.. if inside => " <- double",
            _ => "",
        };
        write!(line, "; mesh: {got} of {exact} hit{mark}").unwrap();
    }
    line
}

/// The error of an outcome; empty if it is right.
fn judge(hit: &Hit<f32>, truth: &Truth, bounds: Option<(f32, f32)>) -> String {
    match (truth.hit, hit.mask) {
        (false, false) => String::new(),
        (true, false) if truth.boundary => " (boundary)".to_owned(),
        (true, false) => " <- false miss".to_owned(),
        (false, true) => {
            // A triangle in an axis plane has flat bounds. The rounding of `t` alone may put a hit outside of them.
            let slack = 1e-3 * hit.t.abs();
            let near = bounds.is_some_and(|(entry, exit)| entry - slack <= hit.t && hit.t <= exit + slack);
            format!(" <- false hit{}", if near { "" } else { ", far outside its bounds" })
        }
        (true, true) => {
            let ulp = ulp_distance(hit.t, truth.t);
            match ulp {
                0 => String::new(),
                1..=ROUNDING => format!(" (t off by {ulp} ulp)"),
                _ => format!(" <- t off by {ulp} ulp"),
            }
        }
    }
}

/// The distance of two numbers in ulp. Both zeros are the same place.
fn ulp_distance(a: f32, b: f32) -> u32 {
    let place = |x: f32| {
        let magnitude = (x.to_bits() & 0x7fff_ffff).cast_signed();
        if x.is_sign_negative() { -magnitude } else { magnitude }
    };
    place(a).abs_diff(place(b))
}

// ---- The pinned outcomes -------------------------------------------------------------------------------------------

#[derive(Default)]
struct Pinned {
    /// By case and by kernel.
    lines: BTreeMap<String, BTreeMap<String, String>>,
    /// Kernels, in the order of their first lines.
    kernels: Vec<String>,
}

impl Pinned {
    /// A missing file pins nothing.
    fn read(path: &Path) -> Self {
        Self::parse(&fs::read_to_string(path).unwrap_or_default())
    }

    fn parse(text: &str) -> Self {
        let mut pinned = Self::default();
        let mut case = String::new();
        for line in text.lines().filter(|line| !line.starts_with('#') && !line.is_empty()) {
            let Some(outcome) = line.strip_prefix("  ") else {
                line.clone_into(&mut case);
                continue;
            };
            let (kernel, outcome) = outcome.split_once(' ').unwrap_or((outcome, ""));
            if !pinned.kernels.iter().any(|known| known == kernel) {
                pinned.kernels.push(kernel.to_owned());
            }
            pinned.lines.entry(case.clone()).or_default().insert(kernel.to_owned(), outcome.trim().to_owned());
        }
        pinned
    }

    /// Messages about outcomes of one kernel that differ from the pinned ones.
    fn compare(&self, kernel: &str, got: &[Outcome]) -> Vec<String> {
        if !self.kernels.iter().any(|known| known == kernel) {
            return vec![format!("{kernel}: a new kernel, without pinned outcomes")];
        }
        let mut failures = Vec::new();
        for Outcome { case, lines } in got {
            for (_, line) in lines.iter().filter(|(id, _)| id == kernel) {
                match self.lines.get(case).and_then(|kernels| kernels.get(kernel)) {
                    Some(pinned) if pinned == line => {}
                    Some(pinned) => failures.push(format!("{case} {kernel}:\n  pinned  {pinned}\n  got     {line}")),
                    None => failures.push(format!("{case} {kernel}: nothing is pinned\n  got     {line}")),
                }
            }
        }
        failures
    }

    /// Pinned cases and kernels that do not exist.
    fn gone(&self, got: &[Outcome]) -> Vec<String> {
        let cases = self.lines.keys().filter(|case| !got.iter().any(|outcome| outcome.case == **case));
        let cases = cases.map(|case| format!("{case}: pinned, but there is no such case"));
        let kernels = self.absent(got).filter(|kernel| !is_written(kernel));
        cases.chain(kernels.map(|kernel| format!("{kernel}: pinned, but there is no such kernel"))).collect()
    }

    /// Kernels with pinned lines that this build does not have.
    fn absent<'a>(&'a self, got: &'a [Outcome]) -> impl Iterator<Item = &'a str> {
        let present = present(got);
        self.kernels.iter().map(String::as_str).filter(move |kernel| !present.contains(kernel))
    }

    /// The text of the file with the outcomes of this build. Lines of kernels that it lacks stay at their place.
    fn blessed(&self, name: &str, got: &[Outcome]) -> String {
        let mut order = present(got);
        for kernel in self.absent(got).filter(|kernel| is_written(kernel)) {
            let position = self.kernels.iter().position(|pinned| pinned == kernel).unwrap();
            let before = self.kernels[..position].iter().rev();
            let place = before.filter_map(|pinned| order.iter().position(|kernel| kernel == pinned)).next();
            order.insert(place.map_or(0, |place| place + 1), kernel);
        }

        let width = order.iter().map(|kernel| kernel.len()).fold(28, usize::max);
        let mut text = format!(
            "# Written by `RAYLANES_BLESS=1 cargo test --test cases` from {name}.toml; tests/cases.rs explains it.\n"
        );
        for Outcome { case, lines } in got {
            writeln!(text, "\n{case}").unwrap();
            for kernel in &order {
                let line = lines.iter().find(|(id, _)| id == kernel).map(|(_, line)| line);
                let kept = || self.lines.get(case).and_then(|kernels| kernels.get(*kernel));
                if let Some(line) = line.or_else(kept) {
                    writeln!(text, "  {kernel:width$} {line}").unwrap();
                }
            }
        }
        text
    }
}

/// The kernels of this build, in the order of the registry.
fn present(got: &[Outcome]) -> Vec<&str> {
    let mut kernels: Vec<&str> = Vec::new();
    for (kernel, _) in got.iter().flat_map(|outcome| &outcome.lines) {
        if !kernels.contains(&kernel.as_str()) {
            kernels.push(kernel);
        }
    }
    kernels
}

/// Whether the sources of the kernels contain this ID. If so, the kernel exists, at least in other builds. All builds
/// have the same instances.
fn is_written(kernel: &str) -> bool {
    fn sources(folder: PathBuf) -> Vec<PathBuf> {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
        entries.flat_map(|path| if path.is_dir() { sources(path) } else { vec![path] }).collect()
    }
    let quoted = format!("\"{kernel}\"");
    sources(PathBuf::from("src/kernels")).iter().any(|file| fs::read_to_string(file).unwrap().contains(&quoted))
}

// ---- Tests of the code above ---------------------------------------------------------------------------------------

fn numbers_are_read_to_the_bit() {
    // Rounded through f64 the first would be 1.0: it is just above a tie, and f64 drops the digits that show it.
    let text = r#"
        [[case]]
        name = "numbers"
        source = "this test"
        why = "each kind of number"
        boxes = [{
            lo = [1.00000005960464477539062500000001, -0.0, 0], hi = [inf, "0x3f800001", 16_777_217], truth = "miss"
        }]
        ray = { origin = [0, -0, 1e-45], dir = ["0x7fc00000", 0, 0], t_min = -inf }
    "#;
    let file: FileData<BoxData> = parse(text).unwrap();
    let case = &parse_cases(text, &file.case, &mut BTreeSet::new()).unwrap()[0];
    let bits = |v: Vec3| v.to_array().map(f32::to_bits);
    assert_eq!(bits(case.shapes[0].lo), [0x3f80_0001, 0x8000_0000, 0]);
    assert_eq!(bits(case.shapes[0].hi), [0x7f80_0000, 0x3f80_0001, 0x4b80_0000]);
    assert_eq!(bits(case.ray.origin), [0, 0x8000_0000, 1]);
    assert_eq!(case.ray.dir.x.to_bits(), 0x7fc0_0000);
    assert_eq!((case.ray.t_min, case.ray.t_max), (f32::NEG_INFINITY, f32::INFINITY));
}

fn blessing_keeps_the_lines_of_absent_kernels() {
    let pinned =
        Pinned::parse("# comment\n\na\n  exact miss\n  aabb/division old\n  aabb/padded kept\n  aabb/gone lost\n");
    let line = |kernel: &str, line: &str| (kernel.to_owned(), line.to_owned());
    let lines = vec![line("exact", "miss"), line("aabb/division", "new"), line("aabb/reciprocal", "first")];
    let got = [Outcome { case: "a".to_owned(), lines }];
    let compare = |pinned: &Pinned| present(&got).into_iter().flat_map(|kernel| pinned.compare(kernel, &got)).collect();
    let differences: Vec<String> = compare(&pinned);
    assert_eq!(differences.len(), 2, "a difference and a new kernel: {differences:?}");
    assert_eq!(pinned.gone(&got), ["aabb/gone: pinned, but there is no such kernel"]);

    let blessed = Pinned::parse(&pinned.blessed("boxes", &got));
    assert_eq!(blessed.kernels, ["exact", "aabb/division", "aabb/padded", "aabb/reciprocal"]);
    assert_eq!(blessed.lines["a"]["aabb/padded"], "kept");
    assert_eq!(blessed.lines["a"]["aabb/division"], "new");
    assert_eq!(compare(&blessed), Vec::<String>::new());
    assert_eq!(blessed.gone(&got), Vec::<String>::new());
}
