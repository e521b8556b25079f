//! JSON to [`Scene`], with errors that say where, what and which word was probably meant.

use serde_json::Value;

use super::{Scene, SceneError};

/// Names further apart than this many edits are not suggested.
const FURTHEST_SUGGESTION: usize = 4;

/// Reads a scene; every field is present and of the right type afterwards, but not yet checked for its range.
pub(super) fn parse(text: &str) -> Result<Scene, SceneError> {
    let document: Value = serde_json::from_str(text).map_err(|error| SceneError::at("", format!("not valid JSON: {error}")))?;
    serde_path_to_error::deserialize(&document).map_err(|error| {
        let field = error.path().to_string();
        let field = if field == "." { String::new() } else { field };
        explain(&document, &field, &error.inner().to_string())
    })
}

/// Turns serde's message into ours: adds the value found and the nearest allowed word.
fn explain(document: &Value, field: &str, message: &str) -> SceneError {
    let names: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    if message.starts_with("unknown field") {
        let (name, allowed) = names.split_first().map_or(("", &[][..]), |(name, allowed)| (*name, allowed));
        let parent = field.strip_suffix(name).map_or(field, |parent| parent.trim_end_matches('.'));
        let at = if parent.is_empty() { name.to_owned() } else { format!("{parent}.{name}") };
        return SceneError::at(at, format!("no such field; {}", suggest(name, allowed)));
    }
    if message.starts_with("unknown variant") {
        let (name, allowed) = names.split_first().map_or(("", &[][..]), |(name, allowed)| (*name, allowed));
        return SceneError::with_value(field, Value::from(name), format!("unknown; {}", suggest(name, allowed)));
    }
    let value = value_at(document, field).map(shorten).unwrap_or_default();
    SceneError::with_value(field, value, message)
}

/// `did you mean "x"? allowed: a, b, c`
fn suggest(name: &str, allowed: &[&str]) -> String {
    let list = format!("allowed: {}", allowed.join(", "));
    let nearest = allowed.iter().min_by_key(|candidate| strsim::damerau_levenshtein(name, candidate));
    match nearest {
        Some(word) if strsim::damerau_levenshtein(name, word) <= FURTHEST_SUGGESTION.min(name.len()) => {
            format!("did you mean `{word}`? {list}")
        }
        _ => list,
    }
}

/// The value at a path such as `cloth[0].grid.size`.
fn value_at<'a>(document: &'a Value, path: &str) -> Option<&'a Value> {
    path.split(['.', '[', ']']).filter(|part| !part.is_empty()).try_fold(document, |value, part| match value {
        Value::Array(items) => items.get(part.parse::<usize>().ok()?),
        _ => value.get(part),
    })
}

/// The value as JSON, cut where it would fill the screen.
fn shorten(value: &Value) -> String {
    const LONGEST: usize = 60;
    let text = value.to_string();
    if text.chars().count() <= LONGEST {
        return text;
    }
    text.chars().take(LONGEST).chain("...".chars()).collect()
}
