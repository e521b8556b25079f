//! Files that tell where vertices are, frame by frame.

use std::fmt;

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The path of a file with all frames, or of .obj files with one frame each; paths start at the scene file.
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged, expecting = "a path or a list of paths")]
pub enum FrameFiles {
    /// An .npy or .pc2 file with all frames; or .obj files, numbered without a gap, with one `*` in place of the number: "walk_*.obj".
    All(String),
    /// An .obj file for each frame, in their order: ["walk_000.obj", "walk_001.obj"].
    Each(Vec<String>),
}

impl FrameFiles {
    /// Whether a file has no name, or there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        match self {
            Self::All(path) => path.is_empty(),
            Self::Each(paths) => paths.is_empty() || paths.iter().any(String::is_empty),
        }
    }

    /// The name under which whoever builds a simulation gives the places: the path, or the list as JSON without spaces.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::All(path) => path.clone(),
            Self::Each(_) => self.to_string(),
        }
    }
}

impl fmt::Display for FrameFiles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::All(path) => write!(f, "{path:?}"),
            #[cfg(feature = "json")]
            Self::Each(paths) => f.write_str(&serde_json::to_string(paths).map_err(|_| fmt::Error)?),
            // It comes from scene files alone.
            #[cfg(not(feature = "json"))]
            Self::Each(paths) => write!(f, "{paths:?}"),
        }
    }
}
