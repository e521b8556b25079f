//! What intersects, as Python sees it.

use taut::contact::{Fault, Intersections, Other};
use taut::model::Model;
use taut::state::State;

/// Cloth, what it intersects, "cloth" or "body", "crosses" or "inside", vertex, place [m], depth [m].
type Place = (String, String, &'static str, &'static str, usize, [f64; 3], Option<f64>);

/// How many places there are, and the first of them.
pub type Found = (usize, Vec<Place>);

/// What intersects in a state.
pub fn find(model: &Model, state: &State) -> Found {
    let found = Intersections::find(model, &state.origins, &state.positions, &state.bodies);
    let place = |place: &taut::contact::Intersection| {
        let cloth = &model.cloths[place.cloth];
        let (other, kind) = match place.other {
            Other::Cloth(other) => (&model.cloths[other].name, "cloth"),
            Other::Body(body) => (&model.bodies.list[body].name, "body"),
        };
        let fault = match place.fault {
            Fault::Crosses => "crosses",
            Fault::Inside => "inside",
        };
        let vertex = cloth.first + place.vertex;
        (cloth.name.clone(), other.clone(), kind, fault, vertex, place.place.to_array(), place.depth)
    };
    (found.count, found.places.iter().map(place).collect())
}
