//! Options that leave no plane mirrors.

use tables::options::{Element, Front, Record, SceneOptions};

/// Returns the option, as typed, that leaves no plane mirrors for the exact method.
pub(crate) fn no_planes(options: &SceneOptions) -> Option<String> {
    let of_rays = SceneOptions {
        deviations: Record::Auto,
        element: Element::default(),
        front: Front::default(),
        ..*options
    };
    Some(of_rays.to_string()).filter(|option| !option.is_empty())
}
