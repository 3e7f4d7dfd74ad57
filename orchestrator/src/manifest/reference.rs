//! The reference page of the manifest, written from its schema: so that page, schema and parser
//! have one source, the tables in [`super::document`].

use serde_json::Value;
use std::collections::VecDeque;
use std::fmt::Write;

/// First lines of the page.
const HEAD: &str = "# Manifest reference

Every table and key of a manifest. [MANIFEST.md](MANIFEST.md) explains how they work together. This page is written by
`tremie schema --markdown`.

Quantities are text with a unit, `\"0.3 mm\"`. `[[name]]` is a list of tables: the table is written once for each entry.
";

/// The page, in Markdown.
pub(super) fn page(schema: &Value) -> String {
    let mut text = HEAD.to_string();
    for section in sections(schema) {
        let path = &section.path;
        let title = if path.is_empty() { "The manifest".into() } else { format!("`{path}`") };
        // Writing to a text cannot fail.
        let _ = write!(text, "\n## {title}\n\n{}\n", section.about);
        if section.keys.is_empty() {
            continue;
        }
        text.push_str("\n| key | value | meaning |\n| --- | --- | --- |\n");
        for key in &section.keys {
            let _ = writeln!(text, "| `{}` | {} | {} |", key.name, key.kind, key.meaning);
        }
    }
    text
}

/// A table of the manifest.
pub(super) struct Section {
    /// Path of the first key that holds such a table: `scene.parts[]`; nothing for the manifest.
    pub path: String,
    /// What it is.
    pub about: String,
    /// Its keys.
    pub keys: Vec<Key>,
}

/// A key of a table.
pub(super) struct Key {
    /// Its name.
    pub name: String,
    /// What its value is, in Markdown.
    pub kind: String,
    /// What it means, in Markdown.
    pub meaning: String,
    /// Paths of the sections of the tables that its value holds.
    pub tables: Vec<String>,
}

/// All tables, each once, in the order in which they are first named.
pub(super) fn sections(schema: &Value) -> Vec<Section> {
    let mut page = Page { schema, tables: VecDeque::new(), known: Vec::new(), named: Vec::new() };
    let mut all = vec![page.section("", schema)];
    while let Some((path, table)) = page.tables.pop_front() {
        all.push(page.section(&path, table));
    }
    all
}

/// Tables are written in the order in which the page first names them.
struct Page<'a> {
    schema: &'a Value,
    tables: VecDeque<(String, &'a Value)>,
    /// Definitions that have a section, and the path of that.
    known: Vec<(&'a str, String)>,
    /// Sections that the key at hand has named.
    named: Vec<String>,
}

impl<'a> Page<'a> {
    fn section(&mut self, path: &str, table: &'a Value) -> Section {
        let keys = table["properties"].as_object();
        let key = |(name, value): (&'a String, &'a Value)| {
            let at = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
            let kind = self.kind(value, &at);
            let meaning = self.meaning(value);
            Key { name: name.clone(), kind, meaning, tables: std::mem::take(&mut self.named) }
        };
        let keys = keys.into_iter().flatten().map(key).collect();
        Section { path: path.to_string(), about: prose(table), keys }
    }

    /// The kind of a value, in words; tables in it are put on the list.
    fn kind(&mut self, value: &'a Value, path: &str) -> String {
        if let Some(reference) = value["$ref"].as_str() {
            return self.named(reference.trim_start_matches("#/$defs/"), path);
        }
        if let Some(options) = value["anyOf"].as_array().or(value["oneOf"].as_array()) {
            let mut kinds: Vec<String> =
                options.iter().map(|option| self.kind(option, path)).collect();
            kinds.dedup();
            return kinds.join(", or ");
        }
        if let Some(word) = value["const"].as_str() {
            return format!("`\"{word}\"`");
        }
        if let Some(words) = value["enum"].as_array() {
            let words: Vec<_> = words.iter().map(|word| format!("`{word}`")).collect();
            return words.join(", or ");
        }
        match value["type"].as_str() {
            Some("array") => self.list(value, path),
            Some("object") if value["properties"].is_object() => {
                self.tables.push_back((path.to_string(), value));
                self.named.push(path.to_string());
                "table".into()
            }
            Some("object") if value["additionalProperties"].is_object() => {
                let of = self.kind(&value["additionalProperties"], &format!("{path}.NAME"));
                format!("for each name: {of}")
            }
            Some("object") => "table".into(),
            Some("string") => "text".into(),
            Some("boolean") => "`true` or `false`".into(),
            Some("integer") => "whole number".into(),
            Some(kind) => kind.into(),
            None => "any".into(),
        }
    }

    /// The description of a key, with its default, and with the meaning of each word that it takes.
    fn meaning(&self, value: &Value) -> String {
        let mut text = prose(value);
        // Only settings have defaults in the schema; the manifest's own stand in the descriptions.
        if let Some(default) = value.as_object().and_then(|map| map.get("default")) {
            let _ = write!(text, " (default: `{default}`)");
        }
        let name = value["$ref"].as_str().or(value["anyOf"][0]["$ref"].as_str());
        let words = name.map(|name| &self.schema["$defs"][name.trim_start_matches("#/$defs/")]);
        for word in words.and_then(|of| of["oneOf"].as_array()).into_iter().flatten() {
            if let (Some(word), meaning) = (word["const"].as_str(), prose(word))
                && !meaning.is_empty()
            {
                let _ = write!(text, " `\"{word}\"`: {meaning}");
            }
        }
        text.replace('|', "\\|").trim().to_string()
    }

    fn list(&mut self, list: &'a Value, path: &str) -> String {
        if let Some(items) = list["prefixItems"].as_array() {
            let kinds: Vec<_> = items.iter().map(|item| self.kind(item, path)).collect();
            return format!("[{}]", kinds.join(", "));
        }
        let of = self.kind(&list["items"], &format!("{path}[]"));
        match (list["minItems"].as_u64(), list["maxItems"].as_u64()) {
            (Some(least), Some(most)) if least == most => format!("{most} x {of}"),
            _ => format!("list of {of}"),
        }
    }

    /// A kind that has a definition: a quantity, a word, or a table with a section of its own.
    fn named(&mut self, name: &'a str, path: &str) -> String {
        let definition = &self.schema["$defs"][name];
        if !definition["properties"].is_object() {
            if definition["type"] == "string" && definition["description"].is_string() {
                let example = definition["examples"][0].as_str();
                let example = example.map_or(String::new(), |text| format!(", `\"{text}\"`"));
                let what = prose(definition);
                return format!("{}{example}", what.trim_end_matches(" with a unit"));
            }
            return self.kind(definition, path);
        }
        // A table that holds itself, or that several keys name, is told once.
        if let Some((_, section)) = self.known.iter().find(|(known, _)| *known == name) {
            self.named.push(section.clone());
            return format!("table as [`{section}`](#{})", anchor(section));
        }
        self.known.push((name, path.to_string()));
        self.named.push(path.to_string());
        self.tables.push_back((path.to_string(), definition));
        format!("table [`{path}`](#{})", anchor(path))
    }
}

/// The anchor of a heading, as pages of Markdown make it.
fn anchor(heading: &str) -> String {
    let kept = heading.to_lowercase();
    kept.chars().filter(|c| c.is_alphanumeric() || matches!(c, '_' | '-')).collect()
}

fn prose(value: &Value) -> String {
    value["description"].as_str().unwrap_or_default().replace('\n', " ")
}
