//! Which interpolated path stands for which facet sequences.

use crate::geometry::polygon;
use crate::proof::guess::Guess;
use crate::proof::leaves::{Leaf, seen_from};
use crate::proof::moving::{middle, most};
use crate::proof::pits::STRAIGHT;
use crate::proof::returned::Returned;

/// Greatest difference of the maps of two sequences that are compared together. Light of such
/// sequences goes nearly the same way, whichever of them it takes.
pub(crate) const NEAR: f64 = 0.1;

/// Sequence of facets, of one of the pits, whose light returns or not.
pub(crate) struct Seen {
    /// Number of the pit that its light enters; 0 for all pits of a lattice.
    pub pit: usize,
    pub leaf: Leaf,
    pub returned: Option<Returned>,
    /// Number of the family that stands for it.
    pub family: Option<usize>,
    /// Number of the first sequence of the pit, or of the lattice, with its map.
    pub first: usize,
}

impl Seen {
    /// Returns whether light that enters elsewhere than `other` does takes this sequence, at the
    /// same pass.
    ///
    /// Sequences of one number of passes share the entrance with those that end for good before.
    pub(crate) fn shares(&self, other: &Seen) -> bool {
        let [own, passes] = [self, other].map(|one| one.leaf.passes);
        self.pit == other.pit && (own == passes || (own < passes && !self.leaf.goes_on))
    }
}

/// Returning sequences of one pit, or of one lattice, of one number of passes, whose maps differ by
/// little, and the families that stand for them.
pub(crate) struct Kin {
    /// Numbers of the sequences.
    pub sequences: Vec<usize>,
    /// Numbers of the families, each with the number of the sequence whose map it has.
    pub families: Vec<(usize, usize)>,
}

/// Returns the difference of the maps of two sequences of one pit.
pub(crate) fn apart(a: &Leaf, b: &Leaf) -> f64 {
    let turn: f64 = (a.linear - b.linear)
        .to_cols_array()
        .iter()
        .map(|x| x.abs())
        .sum();
    turn + a.shift.distance(b.shift)
}

/// Puts those of the sequences `numbers` of one pit and one number of passes together whose maps
/// differ by less than `most`.
fn together(seen: &[Seen], numbers: impl Iterator<Item = usize>, most: f64) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for number in numbers {
        let one = &seen[number];
        let alike = |other: &Seen| {
            let places = [other, one].map(|one| (one.pit, one.leaf.passes));
            places[0] == places[1] && apart(&other.leaf, &one.leaf) < most
        };
        match groups.iter_mut().find(|group| alike(&seen[group[0]])) {
            Some(group) => group.push(number),
            None => groups.push(vec![number]),
        }
    }
    groups
}

/// Returns whether the weights of a family and a sequence may be within a factor of 2.
fn even(guess: &Guess<'_>, returned: &Returned) -> bool {
    let [ours, theirs] =
        [guess.values[6], returned.weight].map(|(w, error)| [most(w) + error, w[0] - error]);
    !(ours[1] > 2.0 * theirs[0] || theirs[1] > 2.0 * ours[0])
}

/// Returns the area that a family and a sequence share in the middle of the patch, once their fixed
/// points lie on each other.
fn shared(guess: &Guess<'_>, one: &Seen) -> f64 {
    let of = |returned: &Returned| {
        let lines = seen_from(&one.leaf.lines, returned.fixed, 0.0);
        polygon::area(&middle(&guess.ever, guess.lines.iter().chain(&lines)))
    };
    match &one.returned {
        Some(returned) if guess.passes == one.leaf.passes && even(guess, returned) => of(returned),
        _ => 0.0,
    }
}

/// Assignment of families to maps of sequences.
struct Standing {
    /// For each family the number of the first sequence with its map.
    first: Vec<Option<usize>>,
    /// For each map the families that stand for it.
    families: Vec<Vec<usize>>,
}

/// Returns the families that stand for the maps of `groups`, sequences of one map each.
///
/// Each map takes one family first. Then come the sequences that no family of their map covers: two
/// cubes may have families of equal polygons, one for each order of their facets. Whatever family
/// is left goes where most of it lies.
///
/// `shared` are the areas that each family shares with each sequence.
fn standing(
    seen: &[Seen],
    guesses: &[Guess<'_>],
    groups: &[Vec<usize>],
    shared: &[Vec<f64>],
    astray_rad: f64,
) -> Standing {
    let alike = |which: usize, group: usize| {
        let one = &seen[groups[group][0]];
        let turned = |returned| guesses[which].turned(returned) < astray_rad;
        let fits = |returned| even(&guesses[which], returned) && turned(returned);
        guesses[which].passes == one.leaf.passes && one.returned.as_ref().is_some_and(fits)
    };
    let mut scores = Vec::new();
    for (which, shared) in shared.iter().enumerate() {
        for (group, own) in groups.iter().enumerate() {
            let area: f64 = own.iter().map(|&one| shared[one]).sum();
            let preferred = if alike(which, group) { 1.0 } else { 0.01 };
            scores.push((preferred * area, which, group));
        }
    }
    scores.retain(|score| score.0 > 0.0);
    scores.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut found = Standing {
        first: vec![None; guesses.len()],
        families: vec![Vec::new(); groups.len()],
    };
    for &(_, which, group) in &scores {
        if found.first[which].is_none() && found.families[group].is_empty() {
            found.put(which, group, groups);
        }
    }
    for (group, own) in groups.iter().enumerate() {
        for &one in own {
            let half = 0.5 * polygon::area(&seen[one].leaf.ever);
            let covers = |which: &usize| shared[*which][one] > half;
            if found.families[group].iter().any(covers) {
                continue;
            }
            let rest = (0..guesses.len()).filter(|which| found.first[*which].is_none());
            let rest = rest.filter(|which| covers(which) && alike(*which, group));
            let best = rest.max_by(|&a, &b| shared[a][one].total_cmp(&shared[b][one]));
            if let Some(which) = best {
                found.put(which, group, groups);
            }
        }
    }
    for &(_, which, group) in &scores {
        // Another path that only lies there is better counted by itself.
        if found.first[which].is_none() && alike(which, group) {
            found.put(which, group, groups);
        }
    }
    found
}

impl Standing {
    /// Lets the family `which` stand for a group.
    fn put(&mut self, which: usize, group: usize, groups: &[Vec<usize>]) {
        self.first[which] = Some(groups[group][0]);
        self.families[group].push(which);
    }
}

/// Pairs families with the sequences that they cover best in the middle of the patch.
pub(crate) fn pair(seen: &mut [Seen], guesses: &[Guess<'_>], astray_rad: f64) -> Vec<Kin> {
    let returned = (0..seen.len()).filter(|&number| seen[number].returned.is_some());
    let groups = together(seen, returned, STRAIGHT);
    let shared: Vec<Vec<f64>> = guesses
        .iter()
        .map(|guess| seen.iter().map(|one| shared(guess, one)).collect())
        .collect();
    let Standing {
        first: stands,
        families: taken,
    } = standing(seen, guesses, &groups, &shared, astray_rad);
    let best = |number: usize, families: &[usize]| {
        let areas = families.iter().map(|&f| (shared[f][number], f));
        let best = areas.max_by(|a, b| a.0.total_cmp(&b.0));
        best.map(|(_, family)| family)
    };
    let firsts = groups.iter().map(|group| group[0]);
    let mut kin = Vec::new();
    let mut chosen = Vec::new();
    for near in together(seen, firsts, NEAR) {
        let families: Vec<(usize, usize)> = stands
            .iter()
            .enumerate()
            .filter_map(|(family, first)| Some((family, first.filter(|f| near.contains(f))?)))
            .collect();
        let all: Vec<usize> = families.iter().map(|(family, _)| *family).collect();
        let own = groups.iter().zip(&taken);
        let mut sequences = Vec::new();
        for (group, taken) in own.filter(|(group, _)| near.contains(&group[0])) {
            sequences.extend(group);
            for &number in group {
                // Others of the kin may cover what has no family of its own.
                let found = best(number, taken).or_else(|| best(number, &all));
                chosen.push((number, found, group[0]));
            }
        }
        kin.push(Kin {
            sequences,
            families,
        });
    }
    for (number, family, first) in chosen {
        seen[number].family = family;
        seen[number].first = first;
    }
    kin
}
