//! `reports/FIELDS.md`: every field of the files that others may read, from the comments of [`record`](crate::study::record).

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value};

use super::fixture::{all_ids, record_of};
use crate::study::record::{PeersRecord, Record, SCHEMA};

const HOW_TO_BLESS: &str = "if this is meant: RAYLANES_BLESS=1 cargo test --lib fields";

/// What comes before the tables.
fn introduction() -> String {
    format!(
        "\
# Fields of `results.json` and `peers.json`

Other programs may read these files, and rely on this:

- `schema` is the version of the layout, now {SCHEMA}. It rises when a field changes its meaning or goes away. Fields may be added at
  any time without that, so ignore those that you do not know. Records are never edited: an old one keeps its old layout.
- A list holds one object for each row. Rows refer to each other by text: `id` is always a kernel's, as in `methods`.
- A figure that does not exist is `null`, where its type says so. A rate is zero where the count that is its base is, so look at
  that first.
- Times are in seconds or nanoseconds, sizes in bytes, as the names say; rates are per second, per million, or in million rays per
  second (`mrays`). `_mad` is a median absolute deviation, `_p50` and `_p99` are percentiles.
- Checksums are texts of 16 hexadecimal digits. Other whole numbers, `seed` for one, have up to 64 bits.

Both files have one line for each row, in UTF-8. This page is made of the comments in
[`src/study/record`](../src/study/record).
"
    )
}

/// The objects of a file, the file itself first, each with the field that holds it.
struct File {
    /// Name of the file.
    name: &'static str,
    /// Name of a field, and the type of what it holds.
    objects: Vec<(String, String)>,
    types: Map<String, Value>,
}

impl File {
    fn of<T: JsonSchema>(name: &'static str) -> Self {
        let root: Value = SchemaGenerator::default().into_root_schema_for::<T>().into();
        let mut types = root["$defs"].as_object().expect("there are rows").clone();
        let of_file = T::schema_name().into_owned();
        types.insert(of_file.clone(), root);
        let mut objects = vec![(name.to_owned(), of_file)];
        let mut next = 0;
        while let Some((_, of_object)) = objects.get(next) {
            let held: Vec<_> = properties(&types[of_object])
                .iter()
                .filter_map(|(field, value)| {
                    Some((field.clone(), referred(value).or_else(|| referred(&value["items"]))?))
                })
                .collect();
            objects.extend(held);
            next += 1;
        }
        Self { name, objects, types }
    }

    /// The field that holds objects of this type, or the file itself.
    fn holder(&self, of_object: &str) -> Option<&str> {
        self.objects.iter().find(|(_, other)| other == of_object).map(|(field, _)| field.as_str())
    }

    /// Headings and tables, but for types that `told` has already; adds the others to it.
    fn markdown(&self, told: &mut BTreeSet<String>) -> String {
        let mut text = String::new();
        for (field, of_object) in &self.objects {
            if !told.insert(of_object.clone()) {
                continue;
            }
            let about = self.words(&self.types[of_object]);
            write!(text, "\n## `{field}`\n\n{about}\n\n| field | type | meaning |\n| --- | --- | --- |\n").unwrap();
            for (field, value) in properties(&self.types[of_object]) {
                let about = self.words(value);
                assert!(!about.is_empty(), "{of_object}::{field} has no comment");
                writeln!(text, "| `{field}` | {} | {about} |", self.type_of(value, false)).unwrap();
            }
        }
        text
    }

    /// A type in plain words, of one or of many.
    fn type_of(&self, value: &Value, many: bool) -> String {
        let plural = |one: &str| if many { format!("{one}s") } else { one.to_owned() };
        if let Some(of_object) = referred(value) {
            let field = self.holder(&of_object).expect("objects are held");
            return format!("[{}](#{field})", plural("object"));
        }
        let one = |name: &str| match name {
            "integer" => plural("whole number"),
            "number" => plural("number"),
            "string" => plural("text"),
            "boolean" => "`true` or `false`".to_owned(),
            "null" => "`null`".to_owned(),
            "array" => {
                let count = value["minItems"].as_u64().map_or(String::new(), |count| format!("{count} "));
                format!("list of {count}{}", self.type_of(&value["items"], true))
            }
            other => panic!("how is {other} told?"),
        };
        match &value["type"] {
            Value::String(name) => one(name),
            Value::Array(names) => {
                names.iter().map(|name| one(name.as_str().expect("a name"))).collect::<Vec<_>>().join(" or ")
            }
            _ => panic!("what is {value}?"),
        }
    }

    /// The comment on one line. Links, which lead to code, become what they are called in the file.
    fn words(&self, value: &Value) -> String {
        let comment = value["description"].as_str().unwrap_or_default();
        let mut comment = comment.split_whitespace().collect::<Vec<_>>().join(" ");
        while let Some((before, (name, after))) =
            comment.split_once("[`").and_then(|(before, rest)| Some((before, rest.split_once("`]")?)))
        {
            let after = match after.strip_prefix('(').and_then(|address| address.split_once(')')) {
                Some((_, after)) => after,
                None => after,
            };
            let told = match name.split_once("::").map(|(of_object, field)| (self.holder(of_object), field)) {
                Some((Some(holder), field)) => format!("`{field}` of `{holder}`"),
                Some((None, _)) => panic!("{name} is not in {}", self.name),
                None => format!("`{name}`"),
            };
            comment = format!("{before}{told}{after}");
        }
        comment.replace('|', "\\|")
    }

    /// Where a value is not as told: fields without a comment, fields that are missing, other types.
    fn faults(&self, value: &Value, told: &Value, path: &str) -> Vec<String> {
        let told = match referred(told) {
            Some(of_object) => &self.types[&of_object],
            None => told,
        };
        let name = match value {
            Value::Null => "null",
            Value::Bool(_) => "boolean",
            Value::Number(number) if number.is_f64() => "number",
            Value::Number(_) => "integer",
            Value::String(_) => "string",
            Value::Array(_) => "array",
            Value::Object(_) => "object",
        };
        let names = match &told["type"] {
            Value::Array(names) => names.clone(),
            name => vec![name.clone()],
        };
        if !names.iter().any(|told| told == name) {
            return vec![format!("{path} is {name}")];
        }
        match value {
            Value::Array(items) => items.iter().flat_map(|item| self.faults(item, &told["items"], path)).collect(),
            Value::Object(fields) => {
                let properties = properties(told);
                let of_field = |(field, value): (&String, &Value)| match properties.get(field) {
                    Some(told) => self.faults(value, told, &format!("{path}.{field}")),
                    None => vec![format!("{path}.{field} is not told")],
                };
                let missing = properties.keys().filter(|field| !fields.contains_key(*field));
                let missing = missing.map(|field| format!("{path}.{field} is missing"));
                fields.iter().flat_map(of_field).chain(missing).collect()
            }
            _ => Vec::new(),
        }
    }
}

fn properties(of_object: &Value) -> &Map<String, Value> {
    of_object["properties"].as_object().expect("objects have fields")
}

/// The type that a field refers to.
fn referred(value: &Value) -> Option<String> {
    Some(value["$ref"].as_str()?.trim_start_matches("#/$defs/").to_owned())
}

fn files() -> [File; 2] {
    [File::of::<Record>("results.json"), File::of::<PeersRecord>("peers.json")]
}

#[test]
fn fields_are_told_as_they_are() {
    let mut told = BTreeSet::new();
    let tables = files().map(|file| file.markdown(&mut told)).concat();
    let expected = introduction() + &tables;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/FIELDS.md");
    if std::env::var_os("RAYLANES_BLESS").is_some_and(|value| value == "1") {
        std::fs::write(path, expected).unwrap();
        return;
    }
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let differs =
        expected.lines().zip(text.lines().chain(std::iter::repeat(""))).find(|(expected, line)| expected != line);
    assert!(text == expected, "reports/FIELDS.md is old: {differs:?}; {HOW_TO_BLESS}");
}

#[test]
fn what_is_written_is_told() {
    let [file, _] = files();
    let mut record = serde_json::to_value(record_of(&all_ids())).unwrap();
    let faults = |record: &Value| file.faults(record, &file.types["Record"], "");
    assert_eq!(faults(&record), [""; 0]);
    for list in ["kernels", "speed", "accuracy", "tracer", "coherence", "scaling", "peers"] {
        assert!(record[list][0].is_object(), "{list} is empty, and so not seen");
    }
    record["tracer"][0]["new"] = 1.into();
    record["machine"]["cpu"] = Value::Null;
    record["peers"][0]["disagreements"].as_object_mut().unwrap().remove("ties");
    let expected = [".machine.cpu is null", ".tracer.new is not told", ".peers.disagreements.ties is missing"];
    assert_eq!(faults(&record), expected);
}
