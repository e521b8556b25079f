//! JSON to [`Scene`], with errors that say where, what and which word was probably meant.

use serde_json::Value;

use super::error::shorten;
use super::{Scene, SceneError};

/// Names further apart than this many edits, or with no letter in common, are not suggested.
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
    if let Some((name, allowed)) = unknown(message, "unknown field `") {
        let parent = field.strip_suffix(name).map_or(field, |parent| parent.trim_end_matches('.'));
        let shown = as_key(name);
        let at = if parent.is_empty() { shown } else { format!("{parent}.{shown}") };
        return SceneError::at(at, format!("no such field; {}", suggest(name, &allowed)));
    }
    if let Some((name, allowed)) = unknown(message, "unknown variant `") {
        return SceneError::with_value(field, Value::from(name), format!("unknown; {}", suggest(name, &allowed)));
    }
    let value = value_at(document, field).map(Value::to_string).unwrap_or_default();
    SceneError::with_value(field, value, without_quotation(message))
}

/// The word that a message of serde calls unknown, and those that it allows: they hold no quotation marks, the word may.
fn unknown<'a>(message: &'a str, beginning: &str) -> Option<(&'a str, Vec<&'a str>)> {
    let rest = message.strip_prefix(beginning)?;
    let (name, allowed) = rest.rsplit_once("`, expected").unwrap_or((rest, ""));
    Some((name, allowed.split('`').skip(1).step_by(2).collect()))
}

/// A field name as in TOML: bare where it can be.
fn as_key(name: &str) -> String {
    let bare = !name.is_empty() && name.chars().all(|letter| letter.is_ascii_alphanumeric() || letter == '_' || letter == '-');
    shorten(&if bare { name.to_owned() } else { Value::from(name).to_string() })
}

/// A message of serde without what it quotes at length; the value is shown already.
fn without_quotation(message: &str) -> String {
    match (message.find('"'), message.rfind("\", expected")) {
        (Some(from), Some(to)) if from < to => {
            let quoted = Value::from(message[from + 1..to].to_owned()).to_string();
            format!("{}{}{}", &message[..from], shorten(&quoted), &message[to + 1..])
        }
        _ => message.to_owned(),
    }
}

/// `did you mean "x"? allowed: a, b, c`
fn suggest(name: &str, allowed: &[&str]) -> String {
    let list = format!("allowed: {}", allowed.join(", "));
    let nearest = allowed.iter().min_by_key(|candidate| strsim::damerau_levenshtein(name, candidate));
    match nearest {
        Some(word) if strsim::damerau_levenshtein(name, word) <= FURTHEST_SUGGESTION.min(name.len().saturating_sub(1)) => {
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
