//! Generates `reports/FIELDS.md`, which lists every field of `results.json` and `peers.json`, from the comments in
//! [`record`](crate::study::record). The tests fail if the page is out of date, or if a written record has other
//! fields.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

use schemars::{JsonSchema, SchemaGenerator};
use serde_json::{Map, Value};

use super::fixture::{all_ids, record_of};
use crate::study::record::{PeersRecord, Record, SCHEMA};

const HOW_TO_BLESS: &str = "to accept the change, run RAYLANES_BLESS=1 cargo test --lib fields";

/// The text before the tables.
fn introduction() -> String {
    format!(
        "\
# Fields of `results.json` and `peers.json`

Other programs may read these files. They can rely on this:

- `schema` is the version of the layout, now {SCHEMA}. It rises when a field is removed or changes its meaning. New
  fields may appear without a new version, so ignore fields that you do not know. Records are never edited: an old
  record keeps its old layout.
- A list holds one object for each row. Rows refer to each other by text. `id` is always the ID of a kernel, as in
  `methods`.
- A missing figure is `null`, if its type allows that. A rate is also zero if its base is zero, so check the base first.
- Names give the units: seconds or nanoseconds, bytes, per second, per million, million rays per second (`mrays`).
  `_mad` is a median absolute deviation, `_p50` and `_p99` are percentiles. `_low` and `_high` are the ends of a 95 %
  interval: a bootstrap draws processes, and then rounds within them.
- A checksum is a text of 16 hexadecimal digits. Other whole numbers, such as `seed`, have up to 64 bits.

Both files are UTF-8, with one line for each row. This page is generated from the comments in
[`src/study/record`](../src/study/record).
"
    )
}

/// The types of the objects in a file.
struct File {
    /// Name of the file.
    name: &'static str,
    /// The name of a field, and the type of the objects in it. The file itself comes first.
    objects: Vec<(String, String)>,
    types: Map<String, Value>,
}

impl File {
    fn of<T: JsonSchema>(name: &'static str) -> Self {
        let root: Value = SchemaGenerator::default().into_root_schema_for::<T>().into();
        let mut types = root["$defs"].as_object().expect("the schema has types for the rows").clone();
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

    /// Headings and tables of all types that are not in `documented` yet. Adds these types to it.
    fn markdown(&self, documented: &mut BTreeSet<String>) -> String {
        let mut text = String::new();
        for (field, of_object) in &self.objects {
            if !documented.insert(of_object.clone()) {
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

    /// A type in plain words, in the singular or, with `many`, in the plural.
    fn type_of(&self, value: &Value, many: bool) -> String {
        let plural = |one: &str| if many { format!("{one}s") } else { one.to_owned() };
        if let Some(of_object) = referred(value) {
            let field = self.holder(&of_object).expect("every type has a field that holds it");
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
                format!("{} of {count}{}", plural("list"), self.type_of(&value["items"], true))
            }
            other => panic!("no words for the type {other}"),
        };
        match &value["type"] {
            Value::String(name) => one(name),
            Value::Array(names) => names
                .iter()
                .map(|name| one(name.as_str().expect("type names are strings")))
                .collect::<Vec<_>>()
                .join(" or "),
            _ => panic!("no type in {value}"),
        }
    }

    /// The comment of a field or type, on one line. Links to code become the names that the file uses.
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
            let name_in_file = match name.split_once("::").map(|(of_object, field)| (self.holder(of_object), field)) {
                Some((Some(holder), field)) => format!("`{field}` of `{holder}`"),
                Some((None, _)) => panic!("{name} is not in {}", self.name),
                None => format!("`{name}`"),
            };
            comment = format!("{before}{name_in_file}{after}");
        }
        comment.replace('|', "\\|")
    }

    /// Where a value does not match its documentation: unknown fields, missing fields, other types.
    fn mismatches(&self, value: &Value, documented: &Value, path: &str) -> Vec<String> {
        let documented = match referred(documented) {
            Some(of_object) => &self.types[&of_object],
            None => documented,
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
        let names = match &documented["type"] {
            Value::Array(names) => names.clone(),
            name => vec![name.clone()],
        };
        if !names.iter().any(|documented| documented == name) {
            return vec![format!("{path} is {name}")];
        }
        match value {
            Value::Array(items) => {
                items.iter().flat_map(|item| self.mismatches(item, &documented["items"], path)).collect()
            }
            Value::Object(fields) => {
                let properties = properties(documented);
                let of_field = |(field, value): (&String, &Value)| match properties.get(field) {
                    Some(documented) => self.mismatches(value, documented, &format!("{path}.{field}")),
                    None => vec![format!("{path}.{field} is not documented")],
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
    of_object["properties"].as_object().expect("an object has fields")
}

/// The name of the type that a schema refers to.
fn referred(value: &Value) -> Option<String> {
    Some(value["$ref"].as_str()?.trim_start_matches("#/$defs/").to_owned())
}

fn files() -> [File; 2] {
    [File::of::<Record>("results.json"), File::of::<PeersRecord>("peers.json")]
}

#[test]
fn the_page_of_fields_is_up_to_date() {
    let mut documented = BTreeSet::new();
    let tables = files().map(|file| file.markdown(&mut documented)).concat();
    let expected = introduction() + &tables;
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("reports/FIELDS.md");
    if std::env::var_os("RAYLANES_BLESS").is_some_and(|value| value == "1") {
        std::fs::write(path, expected).unwrap();
        return;
    }
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let differs =
        expected.lines().zip(text.lines().chain(std::iter::repeat(""))).find(|(expected, line)| expected != line);
    assert!(text == expected, "reports/FIELDS.md is out of date: {differs:?}; {HOW_TO_BLESS}");
}

#[test]
fn a_written_record_has_the_documented_fields() {
    let [file, _] = files();
    let mut record = serde_json::to_value(record_of(&all_ids())).unwrap();
    let mismatches = |record: &Value| file.mismatches(record, &file.types["Record"], "");
    assert_eq!(mismatches(&record), [""; 0]);
    for list in ["kernels", "speed", "accuracy", "tracer", "coherence", "scaling", "peers"] {
        assert!(record[list][0].is_object(), "{list} is empty, so its fields are not checked");
    }
    record["tracer"][0]["new"] = 1.into();
    record["machine"]["cpu"] = Value::Null;
    record["peers"][0]["disagreements"].as_object_mut().unwrap().remove("ties");
    let expected = [".machine.cpu is null", ".tracer.new is not documented", ".peers.disagreements.ties is missing"];
    assert_eq!(mismatches(&record), expected);
}
