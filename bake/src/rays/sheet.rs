//! A cell as its rays see it: one scene, or one for each kind of body that it falls into.

use crate::cell::Prepared;
use crate::rays::scene::{Index, Scene};
use crate::samples::Launch;
use std::sync::Arc;

/// Scenes that rays are launched into, and how they are shared among them.
pub(crate) struct Sheet {
    /// The scenes; a ray meets facets of one only.
    pub scenes: Vec<Arc<Scene>>,
    /// From samples to entry points and the scenes that they belong to.
    pub launch: Launch,
}

impl Sheet {
    /// The sheet of a cell, taken apart where it can be ([`Prepared::kinds`]).
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
