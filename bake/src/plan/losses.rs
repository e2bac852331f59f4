//! Materials behind and around the facets: losses, bodies of glass, plane mirrors.

use crate::error::Error;
use crate::optics::Backing;
use crate::plan::effort::{number, positive};
use crate::plan::request::Request;
use tables::options::{Back, Element, Front, Losses, Record, SceneOptions};

/// Reads what is behind the facets, or returns `None` if losses are not counted.
pub(crate) fn surface(request: &Request) -> Result<Option<Backing>, Error> {
    let named = [
        ("--reflectance", request.reflectance.is_some()),
        ("--metal", request.metal.is_some()),
    ];
    let named = named.into_iter().filter(|(_, given)| *given);
    let named: Vec<&str> = named.map(|(option, _)| option).collect();
    match (request.losses, request.back, &named[..]) {
        (Losses::None, _, []) => Ok(None),
        (Losses::None, _, [option, ..]) => Err(Error::Usage(format!(
            "{option} needs --losses fresnel, because without it no losses are counted; give both \
            options or neither"
        ))),
        (_, _, [first, second]) => Err(Error::both(first, second)),
        (_, Back::Tir, [option, ..]) => Err(Error::both(option, "--back tir")),
        (_, Back::Tir, []) => Ok(Some(Backing::Bare)),
        (_, Back::Mirror, _) => {
            let reflectance = request.reflectance.unwrap_or(1.0);
            positive("--reflectance", reflectance, 1.0, "above 0 and at most 1")?;
            let mirror = Backing::Mirror { reflectance };
            Ok(Some(request.metal.map_or(mirror, Backing::Metal)))
        }
    }
}

/// Checks `--glass-index` where it is given, and the options that exclude it.
pub(crate) fn glass(request: &Request) -> Result<(), Error> {
    let Some(index) = request.scene.glass_index else {
        return Ok(());
    };
    number(
        "--glass-index",
        index,
        (1.0..=10.0).contains(&index),
        "from 1 to 10",
    )?;
    let others = [
        ("--losses fresnel", request.losses == Losses::Fresnel),
        ("--back tir", request.back == Back::Tir),
        ("--roughness", request.scene.roughness.is_some()),
        ("--front trapped", request.scene.front == Front::Trapped),
    ];
    match others.into_iter().find(|(_, given)| *given) {
        Some((other, _)) => Err(Error::both("--glass-index", other)),
        None => Ok(()),
    }
}

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
