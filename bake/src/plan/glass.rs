//! Options that may stand beside bodies of glass.

use crate::plan::error::PlanError;
use crate::plan::request::Request;
use tables::options::{Back, Front, Losses};

/// Checks `--glass-index` where it is given, and the options that exclude it.
pub(crate) fn check(request: &Request) -> Result<(), PlanError> {
    let Some(value) = request.scene.glass_index else {
        return Ok(());
    };
    let option = "--glass-index";
    if !(1.0..=10.0).contains(&value) {
        return Err(PlanError::Number {
            option,
            value,
            range: "from 1 to 10",
        });
    }
    let others = [
        ("--losses fresnel", request.losses == Losses::Fresnel),
        ("--back tir", request.back == Back::Tir),
        ("--roughness", request.scene.roughness.is_some()),
        ("--front trapped", request.scene.front == Front::Trapped),
    ];
    match others.into_iter().find(|(_, given)| *given) {
        Some((second, _)) => Err(PlanError::Both {
            first: option,
            second,
        }),
        None => Ok(()),
    }
}
