//! Which interpolated path stands for which facet sequences.

use crate::geometry::polygon;
use crate::proof::guess::Guess;
use crate::proof::leaves::{Leaf, seen_from};
use crate::proof::moving::middle;
use crate::proof::pits::STRAIGHT;
use crate::proof::returned::Returned;

/// Greatest difference of the maps of two sequences that are compared together. Light of such
/// sequences goes nearly the same way, whichever of them it takes.
const NEAR: f64 = 0.1;

/// Sequence of facets, of one of the pits, whose light returns or not.
pub(crate) struct Seen {
    pub pit: usize,
    pub leaf: Leaf,
    pub returned: Option<Returned>,
    /// Number of the family that stands for it.
    pub family: Option<usize>,
    /// Number of the first sequence of the pit with its map.
    pub first: usize,
}

/// Returning sequences of one pit whose maps differ by little, and the families that stand for
/// them.
pub(crate) struct Kin {
    /// Numbers of the sequences.
    pub sequences: Vec<usize>,
    /// Numbers of the families, each with the number of the sequence whose map it has.
    pub families: Vec<(usize, usize)>,
}

/// Returns the difference of the maps of two sequences of one pit.
fn apart(a: &Leaf, b: &Leaf) -> f64 {
    let turn: f64 = (a.linear - b.linear)
        .to_cols_array()
        .iter()
        .map(|x| x.abs())
        .sum();
    turn + a.shift.distance(b.shift)
}

/// Puts those of the sequences `numbers` of one pit together whose maps differ by less than `most`.
fn together(seen: &[Seen], numbers: impl Iterator<Item = usize>, most: f64) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for number in numbers {
        let one = &seen[number];
        let alike = |other: &Seen| other.pit == one.pit && apart(&other.leaf, &one.leaf) < most;
        match groups.iter_mut().find(|group| alike(&seen[group[0]])) {
            Some(group) => group.push(number),
            None => groups.push(vec![number]),
        }
    }
    groups
}

/// Pairs families with the sequences that they cover best in the middle of the patch.
pub(crate) fn pair(seen: &mut [Seen], guesses: &[Guess<'_>], astray_rad: f64) -> Vec<Kin> {
    let returned = (0..seen.len()).filter(|&number| seen[number].returned.is_some());
    let groups = together(seen, returned, STRAIGHT);
    let shared = |guess: &Guess<'_>, one: &Seen| match &one.returned {
        Some(returned) => {
            let lines = seen_from(&one.leaf.lines, returned.fixed, 0.0);
            polygon::area(&middle(&guess.ever, guess.lines.iter().chain(&lines)))
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
            let preferred = if guess.turned(returned) < astray_rad {
                1.0
            } else {
                0.01
            };
            scores.push((preferred * area, which, group));
        }
    }
    scores.sort_by(|a, b| b.0.total_cmp(&a.0));
    let alike = |which: usize, group: usize| {
        let returned = &seen[groups[group][0]].returned;
        returned
            .as_ref()
            .is_some_and(|returned| guesses[which].turned(returned) < astray_rad)
    };
    let mut stands = vec![None; guesses.len()];
    let mut taken = vec![Vec::new(); groups.len()];
    for again in [false, true] {
        for &(score, which, group) in &scores {
            // Another path that only lies there is better counted by itself.
            let first = taken[group].is_empty() || again && alike(which, group);
            if score > 0.0 && stands[which].is_none() && first {
                stands[which] = Some(groups[group][0]);
                taken[group].push(which);
            }
        }
    }
    let best = |number: usize, families: &[usize]| {
        let areas = families
            .iter()
            .map(|&f| (shared(&guesses[f], &seen[number]), f));
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
