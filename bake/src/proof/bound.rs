//! The bound of the error of an interpolated table over a patch of directions.

use glam::DVec2;
use tables::Family;

use crate::geometry::{Polygon, polygon};
use crate::optics::{Leaving, Rules};
use crate::plan::default;
use crate::proof::leaves::{Leaf, leaves, seen_from};
use crate::proof::means::{Enclosed, enclose};
use crate::proof::moving::{Moving, Patch, ever, most, overlap};
use crate::proof::pits::{Pit, STRAIGHT};
use crate::proof::returned::Returned;

/// Added to each bound, as a share of the light: some thousand operations round numbers below 100
/// by 1e-14 each, and slivers below `NO_AREA` are left out.
const ROUNDING: f64 = 1e-8;

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

/// Sequence of facets, of one of the pits, whose light returns or not.
struct Seen {
    pit: usize,
    leaf: Leaf,
    returned: Option<Returned>,
    /// Number of the family that stands for it.
    family: Option<usize>,
}

/// Interpolated path, relative to its fixed point.
struct Guess<'a> {
    family: &'a Family,
    lines: Vec<Moving>,
    /// Sides of the box that it is cut to; they may lie too far inside.
    sides: Vec<Moving>,
    /// Holds all its points.
    ever: Polygon,
    values: Enclosed<7>,
    /// Number of a sequence that it stands for.
    leaf: Option<usize>,
}

/// Returns an upper bound of the error of the interpolation by `families`, in every direction of
/// the incidences and azimuths given, degrees, or infinity if the patch is too large for one.
///
/// `gap` is the whole gap: incidences, and azimuths.
///
/// The error is the one of `--direction-tolerance`: half the L1 distance of the bins, or the share
/// of light astray. **Proof.** In each direction the sequences of a pit share its entrance (see
/// [`leaves`]). Let each returning sequence s belong to one family f(s), and each family to one
/// map. Light of s that lies in the polygon of f(s), both seen from the fixed point of the map, is
/// in the right bin, but for what the error of the interpolated map moves over a border of bins.
/// What else there is, is light of s outside of the polygon of f(s), and points of the polygon of f
/// that lie in another sequence than its own, or outside of the entrance. Each of these areas is
/// that of an intersection of half-planes, and [`overlap`] bounds it. Half their sum, and the light
/// that crosses borders, bound half the L1 distance. Which sequence belongs to which family
/// changes the bound, not its truth.
pub(crate) fn bound(
    proof: &Proof,
    families: &[Family],
    gap: [[f64; 2]; 2],
    [incidence, azimuth]: [[f64; 2]; 2],
) -> f64 {
    let patch = Patch::around(incidence, azimuth, proof.rules.refractive_index);
    let Some(mut seen) = sequences(proof, &patch) else {
        return f64::INFINITY;
    };
    let mut guesses: Vec<Guess<'_>> = families.iter().map(|f| Guess::new(f, &patch)).collect();
    if guesses.iter().any(|guess| !guess.is_finite()) {
        return f64::INFINITY;
    }
    pair(&mut seen, &mut guesses, proof.astray_rad);
    // Twice the total variation, and the light astray, as areas.
    let (mut twice, mut astray) = (0.0, 0.0);
    for one in seen.iter().filter(|one| one.leaf.returns || one.leaf.open) {
        let weight = proof.pits[one.pit].weight;
        twice += weight
            * match (one.family, &one.returned) {
                (Some(family), Some(returned)) => guesses[family].misses(&one.leaf, returned),
                _ => polygon::area(&one.leaf.ever),
            };
    }
    let steepest = incidence[1].to_radians().cos();
    for (number, guess) in guesses.iter().enumerate() {
        let area = polygon::area(&guess.ever);
        let own = guess
            .leaf
            .and_then(|leaf| Some((&seen[leaf], seen[leaf].returned.as_ref()?)));
        let Some((one, returned)) = own else {
            let weight = guess.values[6].0[0].abs() + 0.01;
            twice += weight * area;
            astray += weight * area;
            continue;
        };
        let pit = &proof.pits[one.pit];
        let extra = guess.extra(number, returned, one.pit, &seen, pit).min(area);
        let crossing = guess.crossing(returned).min(area);
        let (weights, error) = guess.values[6];
        let light = most([weights[0] - pit.weight, weights[1], weights[2]]) + error;
        let lost = guess.lost(gap, [incidence, azimuth]) + light;
        twice += pit.weight * (extra + 2.0 * crossing) + lost * area;
        // The tangents outside are the ones inside times the index, over cosines. The derivative
        // is at most the index over that of the incidence outside, to first order in deviations of
        // less than a hundredth; the factor 2 covers the rest.
        let turned =
            2.0 * proof.rules.refractive_index / steepest.max(1e-3) * guess.turned(returned);
        astray += pit.weight
            * if turned < proof.astray_rad {
                extra
            } else {
                area
            };
    }
    if !(twice + astray).is_finite() {
        return f64::INFINITY;
    }
    (0.5 * twice).max(astray) / proof.entrance_area + ROUNDING
}

/// Returns all sequences of all pits, or `None` if the way back of one cannot be enclosed.
fn sequences(proof: &Proof, patch: &Patch) -> Option<Vec<Seen>> {
    let leaving = Leaving::new(&proof.rules);
    let mut seen = Vec::new();
    for (number, pit) in proof.pits.iter().enumerate() {
        for leaf in leaves(pit, patch, &leaving) {
            let returned = match leaf.returns {
                true => Some(Returned::of(&leaf, pit.height, patch)?),
                false => None,
            };
            seen.push(Seen {
                pit: number,
                leaf,
                returned,
                family: None,
            });
        }
    }
    Some(seen)
}

/// Pairs families with the sequences that they cover best in the middle of the patch.
fn pair(seen: &mut [Seen], guesses: &mut [Guess<'_>], astray_rad: f64) {
    // Sequences of one pit with one map belong together.
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for (number, one) in seen.iter().enumerate() {
        let alike = |other: &Seen| {
            let turn = other.leaf.linear - one.leaf.linear;
            let turn: f64 = turn.to_cols_array().iter().map(|x| x.abs()).sum();
            other.pit == one.pit && turn + other.leaf.shift.distance(one.leaf.shift) < STRAIGHT
        };
        if one.returned.is_some() {
            match groups.iter_mut().find(|group| alike(&seen[group[0]])) {
                Some(group) => group.push(number),
                None => groups.push(vec![number]),
            }
        }
    }
    let shared = |guess: &Guess<'_>, one: &Seen| match &one.returned {
        Some(returned) => {
            let lines = seen_from(&one.leaf.lines, returned.fixed, 0.0);
            let both = lines.iter().chain(&guess.lines).map(Moving::middle);
            polygon::area(&polygon::clip(&guess.ever, both))
        }
        None => 0.0,
    };
    let mut scores = Vec::new();
    for (which, guess) in guesses.iter().enumerate() {
        for (group, own) in groups.iter().enumerate() {
            let Some(returned) = &seen[own[0]].returned else {
                continue;
            };
            let area: f64 = own.iter().map(|&one| shared(guess, &seen[one])).sum();
            let alike = if guess.turned(returned) < astray_rad {
                1.0
            } else {
                0.01
            };
            scores.push((alike * area, which, group));
        }
    }
    scores.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut taken = vec![Vec::new(); groups.len()];
    for again in [false, true] {
        for &(score, which, group) in &scores {
            let first = taken[group].is_empty() || again;
            if score > 0.0 && guesses[which].leaf.is_none() && first {
                guesses[which].leaf = Some(groups[group][0]);
                taken[group].push(which);
            }
        }
    }
    for (group, families) in groups.iter().zip(&taken) {
        for &number in group {
            let areas = families
                .iter()
                .map(|&f| (shared(&guesses[f], &seen[number]), f));
            let best = areas.max_by(|a, b| a.0.total_cmp(&b.0));
            seen[number].family = best.map(|(_, family)| family);
        }
    }
}

impl<'a> Guess<'a> {
    fn new(family: &'a Family, patch: &Patch) -> Guess<'a> {
        let places = || {
            family
                .members
                .iter()
                .map(|(tau, _)| DVec2::from_array(*tau))
        };
        let least = |pick: fn((f64, f64)) -> f64| {
            let moved = places().map(|tau| pick(patch.distances(tau)));
            Family::FASTEST * moved.fold(f64::INFINITY, f64::min)
        };
        let [low, high] = family.bounds.map(DVec2::from_array);
        let (inner, outer) = (least(|(_, near)| near), least(|(far, _)| far) + 1e-6);
        let (from, to) = (low - outer, high + outer);
        let reach = from.abs().max(to.abs()).length();
        let lines: Vec<Moving> = family
            .lines
            .iter()
            .map(|line| mean(line, patch, reach))
            .collect();
        let side = |normal: DVec2, offset: f64| Moving {
            offset: [-offset - inner, 0.0, 0.0],
            normal: [normal, DVec2::ZERO, DVec2::ZERO],
            error: 0.0,
        };
        let start = [from, DVec2::new(to.x, from.y), to, DVec2::new(from.x, to.y)];
        Guess {
            family,
            // The second cut is tighter: changes are least in a small polygon.
            ever: ever(&ever(&start, &lines), &lines),
            lines,
            sides: vec![
                side(DVec2::X, high.x),
                side(DVec2::Y, high.y),
                side(DVec2::NEG_X, -low.x),
                side(DVec2::NEG_Y, -low.y),
            ],
            values: enclose(&family.members, patch),
            leaf: None,
        }
    }

    fn is_finite(&self) -> bool {
        let lines = self.lines.iter().map(|line| line.error);
        lines
            .chain(self.values.map(|(_, error)| error))
            .all(f64::is_finite)
    }

    /// Returns a bound of the light of `leaf` that is not in the polygon.
    fn misses(&self, leaf: &Leaf, returned: &Returned) -> f64 {
        let lines = seen_from(&leaf.lines, returned.fixed, returned.error);
        let place = returned.fixed;
        let (low, high) = polygon::bounds(&leaf.ever);
        let moved = place[1].abs() + place[2].abs() + returned.error;
        let (from, to) = (low - place[0] - moved, high - place[0] + moved);
        let start = [from, DVec2::new(to.x, from.y), to, DVec2::new(from.x, to.y)];
        let within = ever(&ever(&start, &lines), &lines);
        let beyond = self.lines.iter().chain(&self.sides);
        let parts = beyond.map(|line| overlap(&within, &lines, &[line.beyond()]));
        parts.sum::<f64>().min(polygon::area(&within))
    }

    /// Returns a bound of the area of the polygon that is not in the sequences of the family.
    fn extra(
        &self,
        number: usize,
        returned: &Returned,
        pit_number: usize,
        seen: &[Seen],
        pit: &Pit,
    ) -> f64 {
        let others = seen
            .iter()
            .filter(|one| one.pit == pit_number && one.family != Some(number));
        let taken = others.map(|one| {
            let lines = seen_from(&one.leaf.lines, returned.fixed, returned.error);
            overlap(&self.ever, &lines, &self.lines)
        });
        // The first lines of every sequence are those of the entrance.
        let own = seen.iter().find(|one| one.pit == pit_number);
        let rim = own
            .map(|one| &one.leaf.lines[..pit.door().len()])
            .unwrap_or_default();
        let outside = seen_from(rim, returned.fixed, returned.error);
        let outside = outside
            .iter()
            .map(|line| overlap(&self.ever, &[line.beyond()], &self.lines));
        taken.chain(outside).sum()
    }

    /// Returns a bound of the area whose light the error of the map moves to another bin.
    ///
    /// The shift is off by at most e. So only shifts within e of a border of bins can be moved: a
    /// strip of width 2 e along each border that runs through the shifts.
    fn crossing(&self, returned: &Returned) -> f64 {
        let (low, high) = polygon::bounds(&self.ever);
        let far = low.abs().max(high.abs());
        let off = |k: usize| {
            let ((a, e), (b, f)) = (returned.map[k], self.values[k]);
            most([a[0] - b[0], a[1] - b[1], a[2] - b[2]]) + e + f
        };
        let greatest = |k: usize| most(returned.map[k].0) + returned.map[k].1;
        let extent = |row: usize| 2.0 * (greatest(2 * row) * far.x + greatest(2 * row + 1) * far.y);
        // The determinant, less all that the elements may change it.
        let middle = |k: usize| returned.map[k].0[0];
        let change = |k: usize| greatest(k) - middle(k).abs();
        let changes: f64 = (0..4).map(change).sum();
        let sizes: f64 = (0..4).map(greatest).sum();
        let determinant = (middle(0) * middle(3) - middle(1) * middle(2)).abs() - sizes * changes;
        if determinant <= 0.0 {
            return f64::INFINITY;
        }
        let width = 2.0 * default::RANGE / default::BINS as f64;
        let strips = |row: usize| {
            let moved = off(2 * row) * far.x + off(2 * row + 1) * far.y;
            let borders = extent(row) / width + 1.0;
            borders * 2.0 * moved * extent(1 - row)
        };
        (strips(0) + strips(1)) / determinant
    }

    /// Returns a bound of the difference of the tangents astray.
    fn turned(&self, returned: &Returned) -> f64 {
        let off = |k: usize| {
            let ((a, e), (b, f)) = (returned.map[k], self.values[k]);
            most([a[0] - b[0], a[1] - b[1], a[2] - b[2]]) + e + f
        };
        off(4).hypot(off(5))
    }

    /// Returns the greatest share of corners that lack the path by a jump.
    fn lost(&self, gap: [[f64; 2]; 2], part: [[f64; 2]; 2]) -> f64 {
        let share = |corner: &[f64; 2]| -> f64 {
            let along = |axis: usize| {
                let [from, to] = gap[axis];
                let at = |x: f64| {
                    if to > from {
                        (x - from) / (to - from)
                    } else {
                        0.0
                    }
                };
                let near = |x: f64| {
                    if corner[axis] > 0.0 {
                        at(x)
                    } else {
                        1.0 - at(x)
                    }
                };
                if to > from {
                    near(part[axis][0]).max(near(part[axis][1]))
                } else {
                    1.0
                }
            };
            along(0) * along(1)
        };
        self.family.jumps.iter().map(share).sum()
    }
}

/// Encloses an interpolated line; its error is that at points within `reach` of the fixed point.
fn mean(line: &[([f64; 2], [f64; 3])], patch: &Patch, reach: f64) -> Moving {
    let [(x, ex), (y, ey), (offset, error)] = enclose(line, patch);
    Moving {
        offset: offset.map(|part| -part),
        normal: [0, 1, 2].map(|k| DVec2::new(x[k], y[k])),
        error: ex.hypot(ey) * reach + error,
    }
}
