//! The bound of the error of an interpolated table over a patch of directions.

use glam::{DMat2, DVec2, DVec3};
use tables::Family;

use crate::geometry::polygon;
use crate::optics::{Backing, Rules};
use crate::proof::group::{Group, Light};
use crate::proof::guess::Guess;
use crate::proof::leaves::{Leaf, leaves};
use crate::proof::moving::{Patch, most};
use crate::proof::pairs::{NEAR, Seen, apart, pair};
use crate::proof::pits::Pit;
use crate::proof::returned::Returned;
use crate::proof::valleys::on_lattice;

/// Added to each bound, as a share of the light. Some thousand operations round numbers below 100
/// by 1e-14 each. Corners that count as one are up to 1e-9 apart, so at each of some tens of faces
/// that light passes, up to 1e-9 of it could pass beside.
const ROUNDING: f64 = 1e-7;

/// Cell that a proof is about, and the rules of its light.
#[derive(Debug, Clone)]
pub(crate) struct Proof {
    pub pits: Vec<Pit>,
    /// Area of all entrances, each times its weight.
    pub entrance_area: f64,
    pub rules: Rules,
    /// Largest error of an exit direction that counts as none, rad.
    pub astray_rad: f64,
}

impl Proof {
    /// Returns whether bounds are far above the errors: because a cube has one path for each order
    /// of its facets, and not one for all (facets are not at right angles, or polarise light), or
    /// because light crosses the walls of a lattice.
    pub(crate) fn is_loose(&self) -> bool {
        let polarises = matches!(self.rules.losses, Some(Backing::Metal(_) | Backing::Bare));
        let tight = |pit: &Pit| pit.is_right() && pit.lattice.is_none();
        polarises || !self.pits.iter().all(tight)
    }
}

/// Returns an upper bound of the error of the interpolation by `families`, in every direction of
/// the incidences and azimuths given, degrees, or infinity if the patch is too large for one.
///
/// `gap` is the whole gap: incidences, and azimuths.
///
/// The error is the one of `--direction-tolerance`: half the L1 distance of the bins, or the share
/// of light astray. **Proof.** In each direction the sequences of a pit share its entrance (see
/// [`leaves`]). Returning sequences s of a pit whose maps differ by little, and the families f that
/// stand for them, are compared together (see [`pair`]). Each family is placed so that its fixed
/// point is that of a sequence whose map it has: a shift depends on what a point has to that fixed
/// point, and not on where light enters. Let P be the polygon of s, Q that of f. Take the light of
/// a point p of the entrance, true and interpolated, weights aside:
///
/// - In no P: it counts once for each Q with p in it. It lies in another sequence of the pit, in a
///   copy of a sequence of the lattice, or outside of the entrance ([`Group::extra`]).
/// - In one P, and in no Q: it counts once ([`Group::uncovered`]).
/// - In one P, and in some Q: let one of these Q send it where it belongs, or twice its light
///   counts, out of one bin and into another. It is the family that stands for s if p is in its Q,
///   or else another one, whose map differs by little: only light close to a border of bins goes to
///   another one ([`crossing`](crate::proof::crossing)). Each further Q counts once; it lies in two
///   Q together.
///
/// Each of these areas is that of an intersection of half-planes, and [`overlap`] bounds it. They
/// count with the greatest weight of all. Where P and Q share light, their weights differ by what
/// losses and jumps make of them ([`Group::twice`]). All together bound the L1 distance. Light goes
/// astray where a family is not near its map, or where no light has this map: then all of its light
/// is in other sequences or outside of the entrance. Which sequence and which family belong
/// together changes the bound, not its truth.
///
/// **In a lattice** the copies of all sequences of all pits tile the plane of the entrance in each
/// direction. Each sequence counts once, at any one of its places, for a shift does not depend on
/// the period. The places chosen are disjoint, as sequences are disjoint in a period. So the choice
/// changes the bound, not its truth. Sequences that are left open count with all of their light,
/// and what was left out as hardly any light counts as if a family had it too.
///
/// **A front that sends light back** ends a sequence at each meeting and begins a longer one. So a
/// point has one sequence for each number of passes, until its light ends for good. Sequences of
/// one number of passes and those that end before share the entrance, and families have a number of
/// passes too. All of the above holds pass by pass, and the L1 distances add up. A sequence that is
/// left open may still send out its power inside, at most.
///
/// For ideal pits all maps of a group are one, and one family has all of its light.
///
/// [`overlap`]: crate::proof::moving::overlap
pub(crate) fn bound(
    proof: &Proof,
    families: &[Family],
    gap: [[f64; 2]; 2],
    [incidence, azimuth]: [[f64; 2]; 2],
) -> f64 {
    // A patch covers less than half a turn.
    if azimuth[1] - azimuth[0] >= 180.0 {
        return f64::INFINITY;
    }
    let patch = Patch::around(incidence, azimuth, proof.rules.refractive_index);
    let guesses: Vec<Guess<'_>> = families.iter().map(|f| Guess::new(f, &patch)).collect();
    if guesses.iter().any(|guess| !guess.is_finite()) {
        return f64::INFINITY;
    }
    let Some((mut seen, dropped)) = sequences(proof, &patch) else {
        return f64::INFINITY;
    };
    let kin = pair(&mut seen, &guesses, proof.astray_rad);
    // Families of each number of passes may have light that was left out, or that the exact method
    // gives up.
    let most_passes = guesses.iter().map(|guess| guess.passes).max();
    let layers = 1.0 + most_passes.unwrap_or_default() as f64;
    let left_out = dropped + proof.rules.power_given_up() * proof.entrance_area;
    // Twice the total variation, and the light astray, as areas. First comes what has no partner.
    let (mut twice, mut astray) = ((1.0 + layers) * left_out, layers * left_out);
    let light = seen.iter().filter(|one| one.leaf.returns || one.leaf.open);
    for one in light.filter(|one| one.family.is_none()) {
        let weight = proof.pits[one.pit].weight;
        let weight = match &one.returned {
            Some(returned) => returned.most_weight(weight),
            None => weight * one.leaf.power,
        };
        twice += weight * polygon::area(&one.leaf.ever);
    }
    let stands = |family: usize| {
        let mut all = kin.iter().flat_map(|kin| &kin.families);
        all.any(|&(own, _)| own == family)
    };
    let alone = guesses.iter().enumerate();
    for (_, guess) in alone.filter(|(number, _)| !stands(*number)) {
        let light = guess.weight(gap, [incidence, azimuth]) * polygon::area(&guess.ever);
        twice += light;
        astray += light;
    }
    for kin in kin.iter().filter(|kin| !kin.families.is_empty()) {
        let pit = &proof.pits[seen[kin.sequences[0]].pit];
        let Some(group) = Group::new(kin, &seen, &guesses, pit, &patch) else {
            return f64::INFINITY;
        };
        let part = [incidence, azimuth];
        // Nothing that counts as light here has a greater weight.
        let weights = group.light().map(|light| light.guess.weight(gap, part));
        let most = weights.fold(group.most_weight(pit.weight), f64::max);
        twice += group.twice(most, gap, part);
        for light in group.light() {
            astray += most
                * if turned(&light, incidence[1], &proof.rules) < proof.astray_rad {
                    light.alone
                } else {
                    light.area
                };
        }
    }
    if !(twice + astray).is_finite() {
        return f64::INFINITY;
    }
    (0.5 * twice).max(astray) / proof.entrance_area + ROUNDING
}

/// Returns a bound of the difference of the exit directions of a family and of its map, rad, up to
/// `incidence_deg`; infinite where the directions are too far from straight back for one.
///
/// Let up be the cosine of the incidence outside. The tangents outside are the way along the sheet,
/// which the tangents astray inside change by e, the index times those at most, over the upward
/// part z. If e <= up^2 / 10, z^2 is at least 0.78 up^2, and the derivative of the tangents by the
/// way is below 2 / up.
fn turned(light: &Light<'_>, incidence_deg: f64, rules: &Rules) -> f64 {
    let up = incidence_deg.to_radians().cos().max(0.0);
    let index = rules.refractive_index;
    let off = light.guess.turned(light.returned);
    let astray = [4, 5].map(|k| most(light.returned.map[k].0) + light.returned.map[k].1);
    if index * (astray[0].hypot(astray[1]) + off) > 0.1 * up * up {
        return f64::INFINITY;
    }
    2.0 * index / up * off
}

/// Returns all sequences of all pits, and a bound of the area of the light that they leave out, or
/// `None` if the way back of one cannot be enclosed.
///
/// A sequence of a lattice stands for all its copies. Those that return have nearly the map of
/// some first one, moved by a vector of the lattice. They are moved back, so that copies of one
/// cube are one cube, whatever period light enters by.
fn sequences(proof: &Proof, patch: &Patch) -> Option<(Vec<Seen>, f64)> {
    let (mut seen, mut dropped): (Vec<Seen>, f64) = (Vec::new(), 0.0);
    for (number, pit) in proof.pits.iter().enumerate() {
        let (all, rest) = leaves(&proof.pits, number, patch, &proof.rules);
        // Weights of bodies are 1 at most.
        dropped += rest;
        for leaf in all {
            let passes = leaf.passes;
            let same = |one: &&Seen| one.leaf.returns && one.leaf.passes == passes;
            let homes = seen.iter().filter(same);
            let leaf = match pit.lattice {
                Some(lattice) if leaf.returns => home(leaf, homes.map(|one| &one.leaf), lattice),
                _ => leaf,
            };
            let returned = match leaf.returns {
                true => Some(Returned::of(&leaf, pit, patch, &proof.rules)?),
                false => None,
            };
            seen.push(Seen {
                // All pits of a lattice share one plane of entry points. A cell with a lattice has
                // one body.
                pit: if pit.lattice.is_some() { 0 } else { number },
                leaf,
                returned,
                family: None,
                first: seen.len(),
            });
        }
    }
    Some((seen, dropped))
}

/// Moves `leaf` by the vector of the lattice that gives it nearly the map of one of `homes`, or
/// leaves it where it is if there is none.
///
/// A sequence that enters r further has the map y -> L y + shift + r - L r.
fn home<'a>(leaf: Leaf, homes: impl Iterator<Item = &'a Leaf>, lattice: [DVec2; 2]) -> Leaf {
    let across = |x: DVec3| x.truncate();
    let [x, y] = [leaf.linear.x_axis, leaf.linear.y_axis].map(across);
    let way = DMat2::from_cols(DVec2::X - x, DVec2::Y - y).inverse();
    let mut moved = homes.filter_map(|one| {
        let step = on_lattice(way * across(one.shift - leaf.shift), lattice)?;
        let moved = leaf.moved(step);
        (apart(&moved, one) < NEAR).then_some(moved)
    });
    let found = moved.next();
    found.unwrap_or(leaf)
}
