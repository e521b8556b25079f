//! Where vertices are, frame by frame.

use glam::DVec3;

use crate::inputs::Followed;
use crate::scene::{FrameFiles, Scene, SceneError};

/// Places of vertices, frame by frame [m], and frames per second [1/s].
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Motion {
    frames: Vec<Vec<[f64; 3]>>,
    rate: f64,
}

impl Motion {
    pub fn new<T: Copy + Into<f64>>(frames: &[impl AsRef<[[T; 3]]>], rate: f64) -> Self {
        let frames = frames.iter().map(|frame| frame.as_ref().iter().map(|place| place.map(Into::into)).collect()).collect();
        Self { frames, rate }
    }

    /// As an array, for the field `at` of a scene.
    ///
    /// # Errors
    /// A frame has more or fewer places than the first one.
    pub fn array(self, at: &str) -> Result<Followed, SceneError> {
        let Self { frames, rate } = self;
        let vertices = frames.first().map_or(0, Vec::len);
        if let Some(frame) = frames.iter().position(|frame| frame.len() != vertices) {
            let problem = format!("must have {vertices} places as the first frame has, one for each vertex");
            let value = format!("a list of {}", frames[frame].len());
            return Err(SceneError::with_value(format!("{at}[{frame}]"), value, problem));
        }
        Ok(Followed { vertices, places: frames.into_iter().flatten().map(DVec3::from_array).collect(), rate: Some(rate) })
    }
}

/// The fields of a scene that follow arrays, each with the name of its array.
pub(super) fn followers(scene: &Scene) -> impl Iterator<Item = (String, String)> {
    let name = |files: &Option<FrameFiles>| files.as_ref().map(FrameFiles::name);
    let pins = scene.cloth.iter().enumerate().flat_map(move |(cloth, asked)| {
        let pins = asked.pins.iter().enumerate();
        pins.filter_map(move |(pin, asked)| Some((format!("cloth[{cloth}].pins[{pin}].follow"), name(&asked.follow)?)))
    });
    let bodies = scene.body.iter().enumerate();
    pins.chain(bodies.filter_map(move |(body, asked)| Some((format!("body[{body}].motion"), name(&asked.motion)?))))
}
