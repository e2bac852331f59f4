//! Reading of the options about losses.

use crate::optics::Backing;
use crate::plan::error::PlanError;
use crate::plan::number::positive;
use crate::plan::request::Request;
use tables::options::{Back, Losses};

/// Reads what is behind the facets, or returns `None` if losses are not counted.
pub(crate) fn surface(request: &Request) -> Result<Option<Backing>, PlanError> {
    let named = [
        ("--reflectance", request.reflectance.is_some()),
        ("--metal", request.metal.is_some()),
    ];
    let named: Vec<&'static str> = named
        .into_iter()
        .filter_map(|(option, given)| given.then_some(option))
        .collect();
    let both = |first, second| Err(PlanError::Both { first, second });
    match (request.losses, request.back, &named[..]) {
        (Losses::None, _, []) => Ok(None),
        (Losses::None, _, [option, ..]) => Err(PlanError::NeedsLosses { option }),
        (_, _, &[first, second]) => both(first, second),
        (_, Back::Tir, &[option, ..]) => both(option, "--back tir"),
        (_, Back::Tir, []) => Ok(Some(Backing::Bare)),
        (_, Back::Mirror, _) => {
            let reflectance = request.reflectance.unwrap_or(1.0);
            positive("--reflectance", reflectance, 1.0, "above 0 and at most 1")?;
            let mirror = Backing::Mirror { reflectance };
            Ok(Some(request.metal.map_or(mirror, Backing::Metal)))
        }
    }
}
