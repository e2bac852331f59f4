//! Cell as its rays see it: one scene, or one scene for each kind of body that the cell consists
//! of.

use crate::cell::Prepared;
use crate::rays::scene::{Index, Scene};
use crate::samples::Launch;
use std::sync::Arc;

/// Scenes that rays are launched into, and the shares of the rays among them.
pub(crate) struct Sheet {
    /// All scenes; a ray meets facets of one scene only.
    pub scenes: Vec<Arc<Scene>>,
    /// Map from samples to entry points and the scenes that they belong to.
    pub launch: Launch,
}

impl Sheet {
    /// Makes the sheet of a cell, with a scene for each kind of body if there are kinds.
    ///
    /// [`Prepared::kinds`] says whether the cell is taken apart into bodies.
    pub(crate) fn new(prepared: &Prepared, index: Index) -> Self {
        let cell = prepared.cell();
        let Ok(kinds) = prepared.kinds() else {
            return Sheet {
                scenes: vec![Arc::new(Scene::new(cell, index))],
                launch: Launch::new(&cell.entrance),
            };
        };
        let shares: Vec<_> = kinds
            .iter()
            .map(|kind| (&kind.entrance, kind.places.len()))
            .collect();
        Sheet {
            launch: Launch::among(&shares),
            scenes: kinds
                .iter()
                .map(|kind| Arc::new(Scene::of(&kind.facets, &kind.entrance, index)))
                .collect(),
        }
    }
}
