//! The JSON schema of a configuration type, and what it says about each key.

use std::any::TypeId;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::layer::BASE;

/// What is known about one key.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct KeyDoc {
    /// Dotted path: `vru.cores`; `[]` marks a list, `*` any name.
    pub path: String,
    /// Unit or kind of the value: `cycles`, `a size (B, ...)`, `one of obb, aabb`.
    pub unit: String,
    /// Meaning.
    pub definition: String,
    /// Whether the key must be there.
    pub required: bool,
    /// Whether it is a table, not a value.
    pub table: bool,
}

/// The JSON schema of `T`, all references inlined.
pub fn schema_of<T: JsonSchema>() -> Value {
    let settings = SchemaSettings::draft2020_12().with(|s| s.inline_subschemas = true);
    settings.into_generator().into_root_schema_for::<T>().to_value()
}

/// The same, made once: what is registered later is not in it.
pub(super) fn schema_once<T: JsonSchema + 'static>() -> Arc<Value> {
    static ALL: Mutex<BTreeMap<TypeId, Arc<Value>>> = Mutex::new(BTreeMap::new());
    let lock = || ALL.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = lock().get(&TypeId::of::<T>()) {
        return known.clone();
    }
    // Without the lock: a schema may ask for others.
    let made = Arc::new(schema_of::<T>());
    lock().entry(TypeId::of::<T>()).or_insert(made).clone()
}

/// The JSON schema of `T` for editors, where `T` may have a base: `base` is a key, and no key has
/// to be there, since a base may have it.
pub fn schema_with_base<T: JsonSchema>() -> Value {
    fn relax(schema: &mut Value) {
        if let Some(object) = schema.as_object_mut() {
            object.remove("required");
            object.values_mut().for_each(relax);
        }
    }
    let mut schema = schema_of::<T>();
    relax(&mut schema);
    if let Some(keys) = schema.get_mut("properties").and_then(Value::as_object_mut) {
        let meaning = "The file that this one differs from: a name, or a path. What is not here is \
                       as there; `name` and `description` are each file's own, a table that is \
                       \"none\" is absent.";
        keys.insert(BASE.to_owned(), json!({ "type": "string", "description": meaning }));
    }
    schema
}

/// Every key of `T` in the order of its declaration, tables before their keys.
pub fn key_docs<T: JsonSchema>() -> Vec<KeyDoc> {
    key_docs_of(&schema_of::<T>())
}

/// Every key of a schema in the order of its declaration, tables before their keys.
pub fn key_docs_of(schema: &Value) -> Vec<KeyDoc> {
    let mut docs = Vec::new();
    collect(schema, "", &mut docs);
    docs
}

impl KeyDoc {
    /// The names that it may have; none where its values are no names.
    pub fn choices(&self) -> Vec<String> {
        super::knob::choices(&self.unit)
    }
}

fn collect(schema: &Value, prefix: &str, docs: &mut Vec<KeyDoc>) {
    for (name, sub) in properties(schema) {
        describe(sub, &join(prefix, name), is_required(schema, name), docs);
    }
    if let Some(any) = schema.get("additionalProperties").filter(|v| v.is_object()) {
        describe(any, &join(prefix, "*"), false, docs);
    }
}

fn describe(sub: &Value, path: &str, required: bool, docs: &mut Vec<KeyDoc>) {
    let (inner, path) = match list_item(sub) {
        Some(item) => (item, format!("{path}[]")),
        None => (non_null(sub), path.to_owned()),
    };
    docs.push(KeyDoc {
        path: path.clone(),
        unit: unit(inner),
        definition: definition(sub),
        required,
        table: is_table(inner),
    });
    collect(inner, &path, docs);
}

/// Every key of a schema that is no table, with its own schema; lists of plain values are keys, and
/// `[]` stands behind a list of tables.
pub fn leaves(root: &Value) -> Vec<(String, Value)> {
    let mut found = Vec::new();
    collect_leaves(root, "", &mut found);
    found
}

fn collect_leaves(schema: &Value, prefix: &str, found: &mut Vec<(String, Value)>) {
    for (name, sub) in properties(schema) {
        let path = join(prefix, name);
        let inner = non_null(sub);
        match list_item(sub).map(non_null) {
            Some(item) if is_table(item) => collect_leaves(item, &format!("{path}[]"), found),
            None if is_table(inner) => collect_leaves(inner, &path, found),
            _ => found.push((path, inner.clone())),
        }
    }
}

/// The paths of all tables that may be absent, those in lists left out.
pub fn optional_tables(root: &Value) -> Vec<String> {
    let mut found = Vec::new();
    collect_optional(root, "", &mut found);
    found
}

fn collect_optional(schema: &Value, prefix: &str, found: &mut Vec<String>) {
    for (name, sub) in properties(schema) {
        let (path, inner) = (join(prefix, name), non_null(sub));
        if list_item(sub).is_some() || !is_table(inner) {
            continue;
        }
        if !is_required(schema, name) {
            found.push(path.clone());
        }
        collect_optional(inner, &path, found);
    }
}

/// The properties of an object schema.
pub(super) fn properties(schema: &Value) -> impl Iterator<Item = (&String, &Value)> {
    schema.get("properties").and_then(Value::as_object).into_iter().flatten()
}

/// The schema of `key` in an object schema.
pub(super) fn property<'a>(schema: &'a Value, key: &str) -> Option<&'a Value> {
    let named = schema.get("properties").and_then(|p| p.get(key));
    named.or_else(|| schema.get("additionalProperties").filter(|v| v.is_object())).map(non_null)
}

/// The keys that an object schema wants.
pub(super) fn required(schema: &Value) -> impl Iterator<Item = &str> {
    schema.get("required").and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str)
}

fn is_required(schema: &Value, key: &str) -> bool {
    required(schema).any(|k| k == key)
}

/// Whether it describes a table.
pub(super) fn is_table(schema: &Value) -> bool {
    schema.get("properties").is_some()
        || schema.get("additionalProperties").is_some_and(Value::is_object)
}

/// The schema of a list's items.
pub(super) fn list_item(schema: &Value) -> Option<&Value> {
    non_null(schema).get("items")
}

/// The schema of `T` for one of `Option<T>`.
pub(super) fn non_null(schema: &Value) -> &Value {
    let null = |v: &&Value| v.get("type").and_then(Value::as_str) != Some("null");
    let options = schema.get("anyOf").and_then(Value::as_array);
    options.and_then(|a| a.iter().find(null)).unwrap_or(schema)
}

/// The names that an enum schema allows.
pub fn choices(schema: &Value) -> Vec<&str> {
    let list = |key: &str| schema.get(key).and_then(Value::as_array).into_iter().flatten();
    let constants = list("oneOf").filter_map(|v| v.get("const")?.as_str());
    let plain = list("enum").chain(
        list("oneOf").flat_map(|v| v.get("enum").and_then(Value::as_array).into_iter().flatten()),
    );
    constants.chain(plain.filter_map(Value::as_str)).collect()
}

/// The documentation of a key, on one line.
pub(super) fn definition(schema: &Value) -> String {
    let own = text(schema, "description").or_else(|| text(non_null(schema), "description"));
    let mut line = own.unwrap_or_default().split_whitespace().collect::<Vec<_>>().join(" ");
    for variant in non_null(schema).get("oneOf").and_then(Value::as_array).into_iter().flatten() {
        if let (Some(name), Some(means)) = (text(variant, "const"), text(variant, "description")) {
            let means = means.split_whitespace().collect::<Vec<_>>().join(" ");
            line.push_str(&format!(" `{name}`: {}", means));
        }
    }
    line
}

fn text<'a>(schema: &'a Value, key: &str) -> Option<&'a str> {
    schema.get(key)?.as_str()
}

fn unit(schema: &Value) -> String {
    if let Some(unit) = text(schema, "x-unit") {
        return unit.to_owned();
    }
    let choices = choices(schema);
    if !choices.is_empty() {
        return format!("one of {}", choices.join(", "));
    }
    let kind = match schema.get("type") {
        Some(Value::Array(kinds)) => kinds.first().and_then(Value::as_str).unwrap_or(""),
        Some(kind) => kind.as_str().unwrap_or(""),
        None => "",
    };
    match kind {
        "integer" => "count",
        "number" => "number",
        "boolean" => "true or false",
        "string" => "text",
        "object" => "table",
        _ => "value",
    }
    .to_owned()
}

/// `a.b`, or `b` at the top.
pub(super) fn join(prefix: &str, key: &str) -> String {
    if prefix.is_empty() { key.to_owned() } else { format!("{prefix}.{key}") }
}

/// The dotted paths of all keys.
pub(super) fn all_keys(root: &Value) -> Vec<String> {
    let mut docs = Vec::new();
    collect(root, "", &mut docs);
    docs.into_iter().map(|d| d.path).collect()
}
