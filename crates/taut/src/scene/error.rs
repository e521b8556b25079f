//! The one error of reading, checking and building a scene.

use std::fmt;

/// Longer quotations [characters] of what a user wrote are cut.
const LONGEST: usize = 60;
/// No path of fields is longer than this [characters], and no problem than ten such lines.
const LINE: usize = 120;

/// A scene that cannot be simulated: which field, what it holds, what is allowed and a remedy.
///
/// Prints as `scene.cloth[0].strain_limit = 1.5: must be in [1e-9, 1]; try 0.05`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneError {
    /// Path of the field below the scene, such as `cloth[0].strain_limit`; empty for the scene itself.
    pub field: String,
    /// The value found there, as JSON; empty where there is none to show.
    pub value: String,
    /// What is wrong, what is allowed and what to do.
    pub problem: String,
}

impl SceneError {
    /// An error at `field`, without a value to show.
    pub fn at(field: impl Into<String>, problem: impl Into<String>) -> Self {
        Self { field: field.into(), value: String::new(), problem: problem.into() }
    }

    /// An error at `field`, which holds `value`; what is long of the value is cut.
    pub fn with_value(field: impl Into<String>, value: impl fmt::Display, problem: impl Into<String>) -> Self {
        Self { field: field.into(), value: shorten(&value.to_string()), problem: problem.into() }
    }
}

impl fmt::Display for SceneError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("scene")?;
        if !self.field.is_empty() {
            write!(f, ".{}", shown(&self.field, LINE))?;
        }
        if !self.value.is_empty() {
            write!(f, " = {}", shown(&self.value, LINE))?;
        }
        write!(f, ": {}", shown(&self.problem, 10 * LINE))
    }
}

/// Text from a file as a terminal may show it: codes for what it would obey, and an end.
fn shown(text: &str, most: usize) -> String {
    let visible = |letter: char| match letter {
        '"' | '\'' | '\\' => letter.to_string(),
        _ => letter.escape_debug().to_string(),
    };
    let end = if text.chars().nth(most).is_some() { "..." } else { "" };
    text.chars().take(most).map(visible).collect::<String>() + end
}

impl std::error::Error for SceneError {}

/// What a user wrote, cut where it would fill the screen.
pub(crate) fn shorten(text: &str) -> String {
    match text.char_indices().nth(LONGEST) {
        Some(_) => text.chars().take(LONGEST).chain("...".chars()).collect(),
        None => text.to_owned(),
    }
}

/// A number as it was written, or with few digits if it is very large or small.
pub(crate) fn brief(number: f64) -> String {
    if number == 0.0 || (1e-4..1e10).contains(&number.abs()) || !number.is_finite() {
        return number.to_string();
    }
    let rounded = format!("{number:.6e}");
    let (digits, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    format!("{}e{exponent}", digits.trim_end_matches('0').trim_end_matches('.'))
}
