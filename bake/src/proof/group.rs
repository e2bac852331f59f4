//! Paths of one pit that go nearly the same way, all in one frame.

use glam::DVec2;

use crate::geometry::{Polygon, polygon};
use crate::proof::crossing::{Shared, crossing};
use crate::proof::guess::Guess;
use crate::proof::leaves::{NO_AREA, seen_from};
use crate::proof::moving::{Facing, Moving, Patch, always, ever, overlap, overlap_facing};
use crate::proof::pairs::{Kin, Seen};
use crate::proof::pits::Pit;
use crate::proof::returned::Returned;

/// Number of families that are asked one after the other for what one of them does not cover.
const DEEP: usize = 2;

/// Area from which on a path is surely in an exact table, square edge lengths.
const THERE: f64 = 1e-8;

/// Area that is small enough for any tolerance, square edge lengths.
const SMALL: f64 = 1e-7;

/// Distance by which the middle of a part may lie outside of a family that is asked for it, edge
/// lengths.
const BESIDE: f64 = 0.02;

/// Paths of a [`Kin`], seen from the fixed point of its first sequence.
pub(crate) struct Group<'a> {
    truths: Vec<Truth<'a>>,
    guesses: Vec<Placed<'a>>,
    fronts: Vec<Front>,
    /// Half-planes of the sequences of the pit, and of all copies in a lattice, that are not among
    /// the truths.
    others: Vec<Vec<Moving>>,
    /// Half-planes of the entrance.
    rim: Vec<Moving>,
    patch: &'a Patch,
}

/// Returning sequence.
struct Truth<'a> {
    returned: &'a Returned,
    /// Number of the first sequence with its map.
    first: usize,
    /// Place of its family among the guesses.
    family: usize,
    lines: Vec<Moving>,
    ever: Polygon,
}

/// Interpolated path, placed at the fixed point of the sequence that it stands for.
struct Placed<'a> {
    guess: &'a Guess<'a>,
    /// Number of the first sequence with the map that it stands for.
    first: usize,
    returned: &'a Returned,
    place: [DVec2; 3],
    error: f64,
    lines: Vec<Moving>,
    sides: Vec<Moving>,
    ever: Polygon,
}

/// Line between two families: for each, its place among the guesses and the number of its line.
struct Front {
    between: [(usize, usize); 2],
    /// The line as the first family has it.
    facing: Facing,
}

/// Family with a map that it should have, and bounds of its light as areas.
pub(crate) struct Light<'a> {
    pub guess: &'a Guess<'a>,
    pub returned: &'a Returned,
    /// All of its light.
    pub area: f64,
    /// Light that it may have while no light has that map; 0 if there always is some.
    pub alone: f64,
}

/// Returns `a` - `b`, both affine.
fn less(a: [DVec2; 3], b: [DVec2; 3]) -> [DVec2; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

/// Returns a box that holds all of `polygon`, moved by `place`, within `error`.
fn box_around(polygon: &[DVec2], place: [DVec2; 3], error: f64) -> [DVec2; 4] {
    let (low, high) = polygon::bounds(polygon);
    let moved = place[1].abs() + place[2].abs() + error;
    let (from, to) = (low + place[0] - moved, high + place[0] + moved);
    [from, DVec2::new(to.x, from.y), to, DVec2::new(from.x, to.y)]
}

/// Returns the vectors of `lattice` that may bring points in a box onto one of `polygons`.
fn steps<'a>(
    around: &[DVec2; 4],
    polygons: impl Iterator<Item = &'a Polygon>,
    [a, b]: [DVec2; 2],
) -> Vec<DVec2> {
    let area = a.perp_dot(b);
    let [low, _, high, _] = *around;
    let mut found: Vec<DVec2> = Vec::new();
    for polygon in polygons.filter(|polygon| !polygon.is_empty()) {
        let (from, to) = polygon::bounds(polygon);
        let (least, most) = (from - high, to - low);
        let corners = [
            least,
            DVec2::new(most.x, least.y),
            most,
            DVec2::new(least.x, most.y),
        ];
        let range = |of: &dyn Fn(DVec2) -> f64| {
            let ends = corners.map(|corner| of(corner) / area);
            let least = ends.into_iter().fold(f64::INFINITY, f64::min);
            let most = ends.into_iter().fold(f64::NEG_INFINITY, f64::max);
            least.ceil() as i64..=most.floor() as i64
        };
        for i in range(&|x| x.perp_dot(b)) {
            for j in range(&|x| a.perp_dot(x)) {
                let step = i as f64 * a + j as f64 * b;
                let near = step.cmpge(least).all() && step.cmple(most).all();
                if near && !found.contains(&step) {
                    found.push(step);
                }
            }
        }
    }
    found
}

/// Returns the lines between the families.
///
/// Let both be seen from the first fixed point. Then the function of the second changes by its
/// normal times the way from the second fixed point to the first, a product of two affine numbers.
fn fronts(guesses: &[Placed<'_>], patch: &Patch) -> Vec<Front> {
    let mut found = Vec::new();
    for (other, second) in guesses.iter().enumerate() {
        for (number, first) in guesses[..other].iter().enumerate() {
            for (ours, theirs, sum) in first.guess.facing(second.guess, patch) {
                let way = less(first.place, second.place);
                let (line, loose) = (&second.guess.lines[theirs], second.guess.loose[theirs]);
                let normal = Moving {
                    offset: [0.0; 3],
                    normal: line.normal,
                    error: 0.0,
                };
                let moved = seen_from(&[normal], way, first.error + second.error)[0];
                let far = way.iter().map(|x| x.length()).sum::<f64>() + first.error + second.error;
                let back = first.place.map(|x| -x);
                let mut sum = seen_from(&[sum], back, first.error)[0];
                sum.offset = [0, 1, 2].map(|k| sum.offset[k] + moved.offset[k]);
                sum.error += moved.error + loose * far;
                found.push(Front {
                    between: [(number, ours), (other, theirs)],
                    facing: Facing {
                        line: first.lines[ours],
                        loose: first.guess.loose[ours],
                        sum,
                    },
                });
            }
        }
    }
    found
}

impl<'a> Group<'a> {
    /// Places the paths of `kin`, or returns `None` if no family is among them.
    pub(crate) fn new(
        kin: &Kin,
        seen: &'a [Seen],
        guesses: &'a [Guess<'a>],
        pit: &Pit,
        patch: &'a Patch,
    ) -> Option<Group<'a>> {
        let start = kin.sequences[0];
        let origin = seen[start].returned.as_ref()?;
        let frame = |number: usize| seen_from(&seen[number].leaf.lines, origin.fixed, origin.error);
        let back = origin.fixed.map(|x| -x);
        let truth = |&number: &usize| {
            let lines = frame(number);
            let begin = box_around(&seen[number].leaf.ever, back, origin.error);
            let family = seen[number].family?;
            Some(Truth {
                returned: seen[number].returned.as_ref()?,
                first: seen[number].first,
                family: kin.families.iter().position(|&(own, _)| own == family)?,
                ever: ever(&ever(&begin, &lines), &lines),
                lines,
            })
        };
        let truths: Option<Vec<Truth<'_>>> = kin.sequences.iter().map(truth).collect();
        let placed = |&(family, first): &(usize, usize)| {
            let (guess, returned) = (&guesses[family], seen[first].returned.as_ref()?);
            let place = less(returned.fixed, origin.fixed);
            let error = if first == start {
                0.0
            } else {
                returned.error + origin.error
            };
            let back = place.map(|x| -x);
            let lines = seen_from(&guess.lines, back, error);
            let begin = box_around(&guess.ever, place, error);
            Some(Placed {
                guess,
                first,
                returned,
                place,
                error,
                sides: seen_from(&guess.sides, back, error),
                ever: ever(&ever(&begin, &lines), &lines),
                lines,
            })
        };
        let guesses: Option<Vec<Placed<'_>>> = kin.families.iter().map(placed).collect();
        let guesses = guesses?;
        let own = |number: usize| kin.sequences.contains(&number);
        let mut others = Vec::new();
        for number in (0..seen.len()).filter(|&number| seen[number].shares(&seen[start])) {
            let around = || box_around(&seen[number].leaf.ever, back, origin.error);
            let steps = match pit.lattice {
                Some(lattice) => steps(&around(), guesses.iter().map(|guess| &guess.ever), lattice),
                None => vec![DVec2::ZERO],
            };
            // A copy of a truth has another map, so light that a family has there is misplaced.
            let elsewhere = |step: &DVec2| !own(number) || *step != DVec2::ZERO;
            let mut steps = steps.into_iter().filter(elsewhere).peekable();
            if steps.peek().is_some() {
                let lines = frame(number);
                others
                    .extend(steps.map(|step| lines.iter().map(|line| line.moved(step)).collect()));
            }
        }
        Some(Group {
            truths: truths?,
            fronts: fronts(&guesses, patch),
            guesses,
            others,
            // The first lines of every sequence are those of the entrance. A lattice has no rim.
            rim: match pit.lattice {
                Some(_) => Vec::new(),
                None => frame(start)[..pit.door().len()].to_vec(),
            },
            patch,
        })
    }

    /// Returns a bound of twice the total variation in the part of the gap given, as an area.
    ///
    /// `most` is the greatest weight of all light. What light has lost between a sequence and a
    /// family counts by the area that they share.
    pub(crate) fn twice(&self, most: f64, gap: [[f64; 2]; 2], part: [[f64; 2]; 2]) -> f64 {
        let (mut twice, mut lost) = (0.0, 0.0);
        for truth in &self.truths {
            twice += self.uncovered(&truth.ever, &truth.lines, truth.family, &[]);
        }
        for (number, guess) in self.guesses.iter().enumerate() {
            let area = polygon::area(&guess.ever);
            // Weight lost by the areas of the sequences, and the greatest one.
            let (mut sum, mut greatest) = (0.0, 0.0_f64);
            for truth in &self.truths {
                let (points, shared) = self.shared(truth, guess, number == truth.family);
                twice += 2.0 * self.crossing(truth, guess, &points, shared);
                if shared > 0.0 {
                    let off = guess.guess.lost(truth.returned.weight, gap, part);
                    if !off.is_finite() {
                        return f64::INFINITY;
                    }
                    sum += off * shared;
                    greatest = greatest.max(off);
                }
            }
            // A point has one sequence.
            lost += sum.min(greatest * area);
            twice += self.extra(guess).min(area);
            for (other, second) in self.guesses[..number].iter().enumerate() {
                let fronts = self.fronts.iter();
                let own = fronts.filter(|front| {
                    let [(a, _), (b, _)] = front.between;
                    (a, b) == (other, number)
                });
                let facing: Vec<Facing> = own.map(|front| front.facing).collect();
                twice += overlap_facing(&guess.ever, &guess.lines, &second.lines, &facing);
            }
        }
        most * twice + lost
    }

    /// Returns a bound of the weight of all sequences, `limit` at most.
    pub(crate) fn most_weight(&self, limit: f64) -> f64 {
        let weights = self.truths.iter();
        let weights = weights.map(|truth| truth.returned.most_weight(limit));
        weights.fold(0.0, f64::max)
    }

    /// Returns the families with what they may send astray.
    pub(crate) fn light(&self) -> impl Iterator<Item = Light<'_>> {
        self.guesses.iter().map(|guess| Light {
            guess: guess.guess,
            returned: guess.returned,
            area: polygon::area(&guess.ever),
            alone: self.alone(guess),
        })
    }

    /// Returns a bound of the light of a family that no light of its map accompanies.
    fn alone(&self, guess: &Placed<'_>) -> f64 {
        let own = |truth: &&Truth<'_>| truth.first == guess.first;
        let mut there = self.truths.iter().filter(own);
        if there.any(|truth| polygon::area(&always(&truth.ever, &truth.lines)) > THERE) {
            return 0.0;
        }
        let others = self.truths.iter().filter(|truth| !own(truth));
        let others = others.map(|truth| overlap(&guess.ever, &truth.lines, &guess.lines));
        (self.extra(guess) + others.sum::<f64>()).min(polygon::area(&guess.ever))
    }

    /// Returns a bound of the area in `lines` that is in the polygon of no family; `within` holds
    /// all of it.
    ///
    /// What the family `first` does not cover lies beyond one of its lines. Another family may
    /// cover it, but what lies beyond one of that family's lines too. `asked` are the families and
    /// lines beyond which the light lies already.
    fn uncovered(
        &self,
        within: &[DVec2],
        lines: &[Moving],
        first: usize,
        asked: &[(usize, usize)],
    ) -> f64 {
        let guess = &self.guesses[first];
        let mut sum = 0.0;
        for (number, line) in guess.lines.iter().chain(&guess.sides).enumerate() {
            let here = (first, number);
            let beyond = line.beyond();
            let facing = self.facing(asked, here);
            let mut part = overlap_facing(within, lines, &[beyond], &facing);
            if part > SMALL && asked.len() + 1 < DEEP.min(self.guesses.len()) {
                let inside: Vec<Moving> = lines.iter().copied().chain([beyond]).collect();
                let points = ever(&ever(within, &inside), &[beyond]);
                let asked: Vec<(usize, usize)> = asked.iter().copied().chain([here]).collect();
                for other in self.beside(&points, &asked) {
                    part = part.min(self.uncovered(&points, &inside, other, &asked));
                }
            }
            sum += part;
        }
        sum.min(polygon::area(within))
    }

    /// Returns the other sides of the line `here` of a family and of those of `asked` that face it.
    fn facing(&self, asked: &[(usize, usize)], here: (usize, usize)) -> Vec<Facing> {
        let fronts = self.fronts.iter().filter(|front| {
            let [a, b] = front.between;
            (a == here && asked.contains(&b)) || (b == here && asked.contains(&a))
        });
        fronts.map(|front| front.facing.beyond()).collect()
    }

    /// Returns the families that may cover `points`, but for those asked before.
    fn beside(&self, points: &[DVec2], asked: &[(usize, usize)]) -> Vec<usize> {
        let middle = points.iter().sum::<DVec2>() / points.len().max(1) as f64;
        let outside = |guess: &Placed<'_>| {
            let beyond = guess
                .lines
                .iter()
                .map(|line| line.offset[0] + line.normal[0].dot(middle));
            beyond.fold(f64::NEG_INFINITY, f64::max)
        };
        let rest =
            (0..self.guesses.len()).filter(|number| asked.iter().all(|own| own.0 != *number));
        rest.filter(|&number| outside(&self.guesses[number]) < BESIDE)
            .collect()
    }

    /// Returns a bound of the area of a family that is in none of the sequences.
    fn extra(&self, guess: &Placed<'_>) -> f64 {
        let taken = self.others.iter();
        let taken = taken.map(|lines| overlap(&guess.ever, lines, &guess.lines));
        let outside = self.rim.iter();
        let outside = outside.map(|line| overlap(&guess.ever, &[line.beyond()], &guess.lines));
        taken.chain(outside).sum()
    }

    /// Returns points that hold all that a sequence and a family share, and a bound of their area.
    fn shared(&self, truth: &Truth<'_>, guess: &Placed<'_>, own: bool) -> (Polygon, f64) {
        let points = ever(&guess.ever, &truth.lines);
        let mut area = polygon::area(&points).max(0.0);
        if area > NO_AREA && !own {
            area = area.min(overlap(&points, &truth.lines, &guess.lines));
        }
        (points, area)
    }

    /// Returns a bound of the area of `points` whose light a sequence and a family send to
    /// different bins; `area` bounds that of all.
    fn crossing(&self, truth: &Truth<'_>, guess: &Placed<'_>, points: &[DVec2], area: f64) -> f64 {
        if area <= NO_AREA {
            return area;
        }
        let same = truth.first == guess.first;
        let apart = less(guess.returned.fixed, truth.returned.fixed);
        let error = guess.returned.error + truth.returned.error;
        let shared = Shared {
            points,
            area,
            from: (guess.place, guess.error),
            apart: (apart, if same { 0.0 } else { error }),
        };
        crossing(truth.returned, &guess.guess.values, &shared, self.patch)
    }
}
