//! A scene as it would be if its photographs had been taken otherwise than the manifest says.
//!
//! Distances, angles, exposures, the refractive index and the pixel pitch enter the model after the
//! photographs are measured. So other values of them need no second measurement.

use std::sync::Arc;

use rayon::prelude::*;
use tables::options::{Back, Element, Front, Losses};
use tables::{Path, Table};

use crate::estimate::scene::direction::{Along, ProjectedDirection};
use crate::estimate::scene::{Aerial, Scene};

/// Conditions under which a photograph was taken, as the manifest states them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Conditions {
    /// Incidence outside the sheet, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees; `None` if the table is a mean over azimuths and needs none.
    pub azimuth_deg: Option<f64>,
    /// Floating distance (optical path R), mm.
    pub r_mm: f64,
    /// Exposure relative to that of the reference.
    pub exposure: f64,
    /// Angle that is added to the manifest's tangential axis, from +x towards +y, radians.
    pub axis_turn_rad: f64,
    /// True if the camera saw the sheet in the half mirror.
    pub seen_in_mirror: bool,
}

/// Refractive index for which a table was not baked, but which its shifts allow.
///
/// Behind a flat front face the light of the incidence theta goes at asin(sin theta / m), and the
/// shifts on the face depend on this angle alone. So a table of the index m holds the shifts of
/// another index m' at theta in its direction theta', where sin theta' / m = sin theta / m'. This
/// is true only if no light is lost (losses depend on the index), all facets are mirrors (total
/// reflection depends on it) and the light leaves straight back (the front widens a deviation).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OtherIndex {
    /// Refractive index of the table.
    own: f64,
    /// Refractive index that stands in its place.
    other: f64,
}

impl OtherIndex {
    /// Returns the index `other` for use with `table`, or `None` if the table holds only its own.
    pub fn of(table: &Table, other: f64) -> Option<OtherIndex> {
        let from = &table.provenance;
        let allowed = from.losses.is(Losses::None)
            && from.back.is(Back::Mirror)
            && from.element() == Element::Retroreflector
            && !from.has_glass()
            && from
                .options
                .known()
                .is_some_and(|options| options.roughness.is_none() && options.front == Front::Once)
            && sends_straight_back(table);
        (allowed && other >= 1.0).then_some(OtherIndex {
            own: from.refractive_index,
            other,
        })
    }

    /// Returns the bits of both indices, which tell equal ones.
    pub(crate) fn bits(self) -> [u64; 2] {
        [self.own, self.other].map(f64::to_bits)
    }

    /// Returns the incidence at which the table holds the light of `incidence_deg`, degrees.
    pub(crate) fn held_at_deg(self, incidence_deg: f64) -> f64 {
        if self.own == self.other {
            return incidence_deg;
        }
        // With a lower index the angle inside may be steeper than any of the table: NaN, which the
        // table refuses.
        (incidence_deg.to_radians().sin() * self.own / self.other)
            .asin()
            .to_degrees()
    }
}

/// Returns whether every returned ray of a table is antiparallel to the arriving ray.
pub(crate) fn sends_straight_back(table: &Table) -> bool {
    let straight = |path: &Path| path.deviation == [0.0; 2];
    let mut paths = table.exact.iter().flat_map(|exact| &exact.paths).flatten();
    table.deviations.is_none() && paths.all(straight)
}

impl Aerial {
    /// Returns the conditions under which the photograph was taken.
    pub fn conditions(&self) -> Conditions {
        Conditions {
            incidence_deg: self.incidence_deg,
            azimuth_deg: self.direction.azimuth_deg,
            r_mm: self.r_mm,
            exposure: self.exposure,
            axis_turn_rad: self.axis_turn_rad,
            seen_in_mirror: self.seen_in_mirror,
        }
    }
}

impl Scene {
    /// Returns the scene as it would be if its photographs had been taken otherwise, one entry of
    /// `conditions` for each photograph, in closed form. Nothing is measured again.
    ///
    /// `index` stands in place of the refractive index of the table. At an angle at which no light
    /// returns, the lines of the photograph stay as they were (see [`Scene::is_lit`]).
    ///
    /// # Errors
    /// Fails if the table neither holds nor brackets one of the directions.
    pub fn perturbed(
        &self,
        table: &Table,
        index: Option<OtherIndex>,
        conditions: &[Conditions],
    ) -> Result<Scene, tables::Error> {
        let one =
            |(shot, conditions): (&Aerial, &Conditions)| self.moved(shot, table, index, conditions);
        let shots = self.shots.par_iter().zip(conditions);
        let shots = shots.map(one).collect::<Result<_, tables::Error>>()?;
        Ok(self.with(shots))
    }

    /// Returns one photograph as it would be if it had been taken otherwise.
    ///
    /// # Errors
    /// Fails if the table neither holds nor brackets the direction.
    pub(crate) fn moved(
        &self,
        shot: &Aerial,
        table: &Table,
        index: Option<OtherIndex>,
        conditions: &Conditions,
    ) -> Result<Aerial, tables::Error> {
        let held_deg = index.map_or(conditions.incidence_deg, |index| {
            index.held_at_deg(conditions.incidence_deg)
        });
        let direction = table.direction(held_deg, conditions.azimuth_deg)?;
        let moved = Aerial {
            incidence_deg: conditions.incidence_deg,
            r_mm: conditions.r_mm,
            exposure: conditions.exposure,
            axis_turn_rad: conditions.axis_turn_rad,
            seen_in_mirror: conditions.seen_in_mirror,
            ghost: shot.ghost,
            sampled: None,
            rounding: shot.rounding,
            reduced_noise: shot.reduced_noise,
            image: shot.image.clone(),
            floating_distance_mm: shot.floating_distance_mm,
            place: shot.place,
            transfer: shot.transfer.clone(),
            view: Arc::clone(&shot.view),
            pixels: Arc::clone(&shot.pixels),
            warnings: shot.warnings.clone(),
            direction: shot.direction.dark(&direction, conditions.azimuth_deg),
        };
        if direction.retroreflected <= 0.0 {
            return Ok(moved);
        }
        let refractive_index = index.map_or(table.provenance.refractive_index, |index| index.other);
        let along = Along {
            incidence_rad: conditions.incidence_deg.to_radians(),
            normal: moved.normal(),
            spectrum: self.spectrum.as_ref(),
        };
        Ok(Aerial {
            direction: ProjectedDirection::new(
                &direction,
                conditions.azimuth_deg,
                refractive_index,
                along,
            ),
            ..moved
        })
    }

    /// Returns the scene with its photographs at other azimuths, degrees.
    ///
    /// # Errors
    /// Fails if the table neither holds nor brackets one of the directions.
    pub fn turned(&self, table: &Table, azimuths_deg: &[f64]) -> Result<Scene, tables::Error> {
        let turned = |(shot, &azimuth_deg): (&Aerial, &f64)| Conditions {
            azimuth_deg: Some(azimuth_deg),
            ..shot.conditions()
        };
        let conditions: Vec<Conditions> = self.shots.iter().zip(azimuths_deg).map(turned).collect();
        self.perturbed(table, None, &conditions)
    }

    /// Returns the scene as it would be if its camera had seen the sheet the other way: straight
    /// instead of in the mirror, or the reverse. Azimuths stay.
    ///
    /// # Errors
    /// Fails if the table neither holds nor brackets one of the directions.
    pub fn mirrored(&self, table: &Table) -> Result<Scene, tables::Error> {
        let other = |shot: &Aerial| Conditions {
            seen_in_mirror: !shot.seen_in_mirror,
            ..shot.conditions()
        };
        let conditions: Vec<Conditions> = self.shots.iter().map(other).collect();
        self.perturbed(table, None, &conditions)
    }
}
