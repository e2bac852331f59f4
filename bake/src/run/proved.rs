//! Proof that a table keeps its tolerance in all directions between its own.

use std::collections::BTreeMap;

use rayon::prelude::*;
use tables::options::Element;
use tables::{Axes, Family, Table};

use crate::cell::ExactCell;
use crate::optics::Rules;
use crate::proof::{Pit, Proof, bound, pits, valleys};
use crate::run::watch::Watch;

/// Number of times that a gap is halved along both angles before it counts as not proved. Parts of
/// a gap of 30 degrees are then 0.03 degrees wide.
const HALVINGS: usize = 10;

/// Largest number of parts of a gap that are looked at before it counts as not proved. With 400, a
/// hollow pair would need 15 directions for a tolerance of 0.001, where 8 are enough. With 1000,
/// full cubes are not proved.
const MOST_PARTS: usize = 4000;

/// Largest number of pits whose tolerance is proved. A pair has two.
const MOST_PITS: usize = 8;

/// Largest number of mirrors of such a pit. With more mirrors, as a flat apex has, light of one map
/// comes from several polygons, and 40 s of search proved nothing where trials end after 3 s.
const MIRRORS: usize = 3;

/// Part of the directions between those of a table, and a bound of the error in all of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    /// Incidences from and to, degrees; both are one along an incidence of the table.
    pub incidence_deg: [f64; 2],
    /// Azimuths from and to, degrees; both are one along an azimuth of the table.
    pub azimuth_deg: [f64; 2],
    /// Bound of the error; infinite if there is none.
    pub bound: f64,
}

/// Bounds for all directions between those of a table.
pub(crate) struct Bounds {
    pub parts: Vec<Part>,
    /// Number of parts looked at; those that were halved are among them.
    pub looked: usize,
}

/// Gaps that were proved, each with what the table knew there. Between the same families the bounds
/// are the same, so a gap far from a new direction is not looked at again.
#[derive(Debug, Clone, Default)]
pub(crate) struct Known(BTreeMap<[u64; 4], (Vec<Family>, Vec<Part>)>);

impl Known {
    /// Returns the parts of `gap` if it was proved between these families.
    fn parts(&self, gap: [[f64; 2]; 2], families: &[Family]) -> Option<&Vec<Part>> {
        let (known, parts) = self.0.get(&Known::key(gap))?;
        (known == families).then_some(parts)
    }

    fn key([[a, b], [c, d]]: [[f64; 2]; 2]) -> [u64; 4] {
        [a, b, c, d].map(f64::to_bits)
    }
}

/// Returns what is needed for proofs, or `None` if the class of the cell has none.
///
/// The class has convex pits of three facets, alone or in a lattice ([`valleys`]), with losses or
/// without, whether the front traps light or not. The facets need not be at right angles: their six
/// orders are then six paths with nearly one map, whose polygons are bounded together ([`bound`]).
/// What the interpolation mistakes for a neighbour's light goes to nearly the same place. With
/// errors of milliradians even that may be too much, and the search falls back to trials.
///
/// Cells of many pits are kept out: each family is compared with each pit, so the time grows with
/// the square of their number.
pub(crate) fn provable(exact: &ExactCell, rules: &Rules, astray_rad: f64) -> Option<Proof> {
    let simple = rules.roughness.is_none()
        && rules.glass_index.is_none()
        && rules.element == Element::Retroreflector;
    let lattice = match exact.bodies.as_slice() {
        [body] => body.lattice,
        _ => None,
    };
    let all = exact.bodies.iter().map(|body| match lattice {
        Some(lattice) => valleys(body, lattice),
        None => pits(body),
    });
    let all: Option<Vec<_>> = all.collect();
    let pits: Vec<Pit> = all?.into_iter().flatten().collect();
    let few = pits.len() <= MOST_PITS && pits.iter().all(|pit| pit.mirrors().count() <= MIRRORS);
    (simple && few).then_some(Proof {
        pits,
        entrance_area: exact.entrance_area,
        rules: *rules,
        astray_rad,
    })
}

/// Bounds the error of `table` between its directions, part by part, or returns `None` if `watch`
/// stopped it.
///
/// `azimuth_ends` are its azimuths, and the end of the last gap where they go all around. Parts
/// whose bound is above `tolerance` are halved. A gap that is not proved ends with a part whose
/// bound is above it, and the rest of the gap is left out. Gaps that are `known` are taken from
/// there, and those that are proved are added.
pub(crate) fn parts(
    proof: &Proof,
    table: &Table,
    azimuth_ends: &[f64],
    tolerance: f64,
    known: &mut Known,
    watch: Watch<'_>,
) -> Option<Bounds> {
    let Axes {
        incidence_deg,
        azimuth_deg,
        ..
    } = &table.axes;
    let gaps = |ends: &[f64], own: &[f64]| -> Vec<[f64; 2]> {
        let between = ends.windows(2).map(|pair| [pair[0], pair[1]]);
        own.iter().map(|&x| [x, x]).chain(between).collect()
    };
    let along = gaps(incidence_deg, incidence_deg);
    let across = gaps(azimuth_ends, azimuth_deg);
    let all: Vec<[[f64; 2]; 2]> = along
        .iter()
        .flat_map(|&a| across.iter().map(move |&b| [a, b]))
        // The table's own directions are not interpolated.
        .filter(|[a, b]| a[0] < a[1] || b[0] < b[1])
        .collect();
    let of = |&gap: &[[f64; 2]; 2]| {
        if watch.is_stopped() {
            return None;
        }
        let [a, b] = gap.map(|[from, to]| 0.5 * (from + to));
        let Some(families) = table.families(a, b) else {
            let unknown = Part {
                incidence_deg: gap[0],
                azimuth_deg: gap[1],
                bound: f64::INFINITY,
            };
            return Some((gap, Vec::new(), vec![unknown], 1));
        };
        if let Some(parts) = known.parts(gap, &families) {
            return Some((gap, families, parts.clone(), 0));
        }
        let mut search = Gap {
            proof,
            families: &families,
            ends: gap,
            tolerance,
            watch,
            found: Vec::new(),
            looked: 0,
        };
        search.divide(gap, [HALVINGS; 2]);
        if watch.is_stopped() {
            return None;
        }
        let Gap { found, looked, .. } = search;
        Some((gap, families, found, looked))
    };
    let found: Option<Vec<_>> = all.par_iter().map(of).collect();
    let mut bounds = Bounds {
        parts: Vec::new(),
        looked: 0,
    };
    for (gap, families, parts, looked) in found? {
        bounds.parts.extend(&parts);
        bounds.looked += looked;
        if parts.iter().all(|part| part.bound <= tolerance) {
            known.0.insert(Known::key(gap), (families, parts));
        }
    }
    Some(bounds)
}

/// Gap between directions of a table.
struct Gap<'a> {
    proof: &'a Proof,
    families: &'a [Family],
    /// Incidences and azimuths, degrees.
    ends: [[f64; 2]; 2],
    tolerance: f64,
    /// Asked before each part: a gap of a lattice may take ten seconds.
    watch: Watch<'a>,
    /// Parts with a bound.
    found: Vec<Part>,
    /// Number of parts looked at.
    looked: usize,
}

impl Gap<'_> {
    /// Bounds the error in `part`, in halves or quarters where the bound is above the tolerance,
    /// `left` times along each angle at most. Returns whether all of the part is proved; it is not
    /// if the watch stopped.
    fn divide(&mut self, part: [[f64; 2]; 2], left: [usize; 2]) -> bool {
        if self.watch.is_stopped() {
            return false;
        }
        let bound = bound(self.proof, self.families, self.ends, part);
        self.looked += 1;
        let proved = bound <= self.tolerance;
        let halved = halved(part);
        let ends = [0, 1].iter().any(|&axis| halved[axis] && left[axis] == 0);
        if proved || ends || halved == [false; 2] || self.looked >= MOST_PARTS {
            let [incidence_deg, azimuth_deg] = part;
            self.found.push(Part {
                incidence_deg,
                azimuth_deg,
                bound,
            });
            return proved;
        }
        let pieces = |axis: usize| {
            let [from, to] = part[axis];
            let middle = 0.5 * (from + to);
            match halved[axis] {
                true => vec![[from, middle], [middle, to]],
                false => vec![[from, to]],
            }
        };
        let across = pieces(1);
        let along = pieces(0).into_iter();
        let mut pieces = along.flat_map(|along| across.iter().map(move |&across| [along, across]));
        let left = [0, 1].map(|axis| left[axis] - usize::from(halved[axis]));
        pieces.all(|piece| self.divide(piece, left))
    }
}

/// Returns along which angles a part is halved: both, or only the one that turns the light more
/// than twice as far.
fn halved([incidence, azimuth]: [[f64; 2]; 2]) -> [bool; 2] {
    let wide = |[from, to]: [f64; 2]| {
        let middle = 0.5 * (from + to);
        from < middle && middle < to
    };
    let along = incidence[1] - incidence[0];
    let across = (azimuth[1] - azimuth[0]) * incidence[1].to_radians().sin();
    [
        wide(incidence) && (2.0 * along >= across || !wide(azimuth)),
        wide(azimuth) && (2.0 * across >= along || !wide(incidence)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::Prepared;
    use crate::geometry::polygon;
    use crate::plan::{Plan, Request};
    use crate::proof::{Patch, Returned, leaves};
    use crate::run::bake::Bake;
    use crate::run::trial;
    use meshes::Cell;
    use meshes::design::{Design, Shape};
    use num_complex::Complex64;
    use tables::options::{Back, Front, Losses};

    fn design(name: &str, change: impl FnOnce(&mut Design)) -> Cell {
        let mut design = Design::new(Shape::from_name(name).expect("a design"));
        change(&mut design);
        let mesh = design.mesh().expect("a mesh");
        meshes::normalise(&mesh, "cell.obj".as_ref(), &meshes::CellOptions::default())
            .expect("a cell")
    }

    /// Returns cells of convex pits: four alone, and two lattices. The fourth and the last have
    /// dihedral errors.
    fn cells() -> [Cell; 6] {
        let uneven = |design: &mut Design| design.dihedral_error_rad = [5e-4, 0.0, -3e-4];
        [
            design("triangular-pair", |_| ()),
            design("triangular", |_| ()),
            design("canted", |design| design.cant_rad = 0.2),
            design("triangular-pair", uneven),
            design("full-cube", |_| ()),
            design("full-cube", uneven),
        ]
    }

    fn request(incidence: &str, azimuth: &str, index: f64) -> Request {
        Request {
            incidence: incidence.into(),
            azimuth: azimuth.into(),
            refractive_index: Some(index),
            back: Back::Mirror,
            ..Request::default()
        }
    }

    /// Spoils a table: not at all, by a polygon that is too small, or by a path that is missing.
    fn spoiled(mut table: Table, how: usize) -> Table {
        let exact = table.exact.as_mut().expect("an exact table");
        let count = exact.paths.len();
        let paths = &mut exact.paths[count / 2];
        match (how, paths.first_mut()) {
            (1, Some(path)) => {
                let middle = path.polygon[0];
                for corner in &mut path.polygon {
                    *corner = [0, 1].map(|k| middle[k] + 0.97 * (corner[k] - middle[k]));
                }
            }
            (2, Some(_)) => {
                paths.remove(0);
            }
            _ => {}
        }
        table
    }

    /// Parts of a gap along each angle.
    const SIDE: u32 = 8;

    /// Leaves the facets as they are: they lose no light.
    fn ideal(request: Request) -> Request {
        request
    }

    /// Gives facets of aluminium, and Fresnel's losses at the front.
    fn aluminium(request: Request) -> Request {
        Request {
            losses: Losses::Fresnel,
            metal: Some(Complex64::new(0.96, 6.69)),
            wavelength_nm: Some(550.0),
            ..request
        }
    }

    /// Gives facets that reflect 91 % of the light, and Fresnel's losses at the front.
    fn silvered(request: Request) -> Request {
        Request {
            losses: Losses::Fresnel,
            reflectance: Some(0.91),
            ..request
        }
    }

    /// Lets the front trap light of such facets.
    fn trapped_silvered(request: Request) -> Request {
        trapped(silvered(request))
    }

    /// Makes the facets bare, with Fresnel's losses there and at the front.
    fn bare(request: Request) -> Request {
        Request {
            losses: Losses::Fresnel,
            back: Back::Tir,
            ..request
        }
    }

    /// Lets the front reflect totally.
    fn trapped(mut request: Request) -> Request {
        request.scene.front = Front::Trapped;
        request
    }

    /// Makes facets reflect totally, or not at all.
    fn total(request: Request) -> Request {
        Request {
            back: Back::Tir,
            ..request
        }
    }

    /// Returns a bound and the error of one direction in each of 8 x 8 parts of each gap of a table
    /// that is [`spoiled`].
    fn trials(cell: &Cell, request: &Request, how: usize) -> Vec<(f64, f64)> {
        let plan = Plan::new(request).expect("a valid request");
        let prepared = Prepared::new(cell.clone());
        let exact = prepared.exact().expect("planar");
        let bake = Bake::new(&prepared, &plan).expect("a bake");
        let proof = provable(exact, &bake.rules, trial::ASTRAY_RAD).expect("of the class");
        let table = spoiled(bake.beams(exact, Watch::none()).expect("a table"), how);
        let axes = &table.axes;
        let gaps = axes.incidence_deg.windows(2).flat_map(|i| {
            let azimuths = axes.azimuth_deg.windows(2);
            azimuths.map(move |a| [[i[0], i[1]], [a[0], a[1]]])
        });
        let of = |gap: [[f64; 2]; 2]| {
            let [a, b] = gap.map(|[from, to]| 0.5 * (from + to));
            let families = table.families(a, b).expect("families");
            let found = (0..SIDE * SIDE).into_par_iter().map(|k| {
                let place = [k / SIDE, k % SIDE].map(f64::from);
                let at = |axis: usize, part: f64| {
                    let [from, to] = gap[axis];
                    from + (place[axis] + part) / f64::from(SIDE) * (to - from)
                };
                let part = [0, 1].map(|axis| [at(axis, 0.0), at(axis, 1.0)]);
                let bound = bound(&proof, &families, gap, part);
                // Anywhere in the part, elsewhere in each.
                let inside = |k: u32| (0.37 + 0.618 * f64::from(k)).fract();
                let [i, a] = [at(0, inside(k)), at(1, inside(3 * k + 1))];
                (bound, trial::error(exact, &bake.rules, &table, i, a))
            });
            found.collect::<Vec<(f64, f64)>>()
        };
        gaps.flat_map(of).collect()
    }

    /// Bounds against trials, in coarse tables and in spoiled ones, so that the errors are large,
    /// and in finer ones, so that the bounds are small.
    #[test]
    fn no_trial_exceeds_its_bound() {
        type Kind = fn(Request) -> Request;
        let all = cells();
        let plain = (0..4).flat_map(|which| {
            let cases = [
                (1.0, "0,25,50", "full:60"),
                (1.49, "0,30,60", "full:60"),
                (1.0, "20,26", "full:20"),
            ];
            cases.map(|case| (which, case, ideal as Kind))
        });
        let lossy: [(usize, (f64, &str, &str), Kind); 6] = [
            (0, (1.49, "0,20", "full:30"), aluminium),
            (0, (1.0, "20,26", "full:20"), aluminium),
            (3, (1.49, "10,14", "full:20"), aluminium),
            (0, (1.49, "0,8", "full:30"), bare),
            (0, (1.7, "0,30", "full:60"), total),
            // Total reflection ends between 20 and 30 degrees.
            (0, (1.49, "10,20,30", "full:30"), total),
        ];
        let lattices: [(usize, (f64, &str, &str), Kind); 12] = [
            (4, (1.49, "10,14", "full:20"), ideal),
            // Light runs along the sheet between 29 and 30 degrees, and along facets at 35.26.
            (4, (1.49, "29,30", "0,15,60"), ideal),
            (4, (1.0, "33,36", "full:30"), ideal),
            (4, (1.49, "6,10", "full:30"), aluminium),
            (5, (1.49, "0,4", "full:60"), ideal),
            (5, (1.0, "24,26", "full:60"), ideal),
            (0, (1.49, "18,22", "full:20"), trapped),
            (4, (1.49, "18,20", "full:20"), trapped),
            (0, (1.49, "10,14", "full:20"), |request| {
                trapped(aluminium(request))
            }),
            (0, (1.49, "30,32", "0,2"), trapped_silvered),
            (3, (1.49, "4,6", "full:30"), trapped_silvered),
            (4, (1.49, "18,20", "full:60"), trapped_silvered),
        ];
        let (mut tried, mut ratios, mut worst) = (0, Vec::new(), 0.0_f64);
        let (mut uneven, mut losses, mut across) = (0, 0, 0);
        let cases = plain.chain(lossy).chain(lattices);
        for (number, (which, (index, incidence, azimuth), kind)) in cases.enumerate() {
            let request = kind(request(incidence, azimuth, index));
            for how in 0..3 {
                for (bound, error) in trials(&all[which], &request, how) {
                    assert!(error <= bound, "case {number}, {how}: {error} {bound}");
                    tried += 1;
                    worst = worst.max(error);
                    if error > 1e-3 && bound.is_finite() {
                        ratios.push(bound / error);
                        uneven += u32::from(which == 3);
                        losses += u32::from((12..18).contains(&number));
                        across += u32::from(number >= 18);
                    }
                }
            }
        }
        ratios.sort_by(f64::total_cmp);
        let [least, middle] = [ratios[0], ratios[ratios.len() / 2]];
        println!(
            "{tried} directions, errors up to {worst:.3}; bound by error, of {} above 0.001 \
             ({uneven} with dihedral errors, {losses} of lossy facets, {across} of lattices and \
             trapping fronts): at least {least:.2}, median {middle:.1}",
            ratios.len()
        );
        assert!(tried > 5000 && worst > 0.05 && ratios.len() > 500 && uneven > 200);
        assert!(losses > 100 && across > 300, "{losses} {across}");
    }

    /// The sequences of a single direction share the entrance, at each pass of the front with those
    /// that ended before. Those that return have the light that the exact method finds by following
    /// beams. Sequences that are left open may lack.
    #[test]
    fn sequences_of_one_direction_are_those_of_beams() {
        let cells = cells();
        let (mut tried, mut shared) = (0, 0);
        // Light that runs along a lattice is left open, and much of what a front traps there.
        for (which, index, kind, limit) in [
            (0, 1.49, trapped as fn(Request) -> Request, 0.01),
            (2, 1.59, trapped, 0.2),
            (3, 1.0, ideal, 1e-9),
            (4, 1.0, ideal, 0.003),
            (4, 1.49, trapped, 1.0),
            (0, 1.49, trapped_silvered, 0.01),
            (4, 1.49, trapped_silvered, 0.3),
            (5, 1.0, ideal, 0.003),
            (5, 1.49, total, 0.003),
        ] {
            let mut open_most = 0.0_f64;
            let request = kind(request("0", "0", index));
            let plan = Plan::new(&request).expect("a valid request");
            let prepared = Prepared::new(cells[which].clone());
            let exact = prepared.exact().expect("planar");
            let rules = plan.rules(prepared.cell());
            let proof = provable(exact, &rules, trial::ASTRAY_RAD).expect("of the class");
            for k in 0..60 {
                let place = (0.37 + 0.618 * f64::from(k)).fract();
                let [i, a] = [60.0 * place, 6.1 * f64::from(k)];
                let truth = exact.direction(i, a, 1, 2.0, &rules);
                let patch = Patch::around([i, i], [a, a], index);
                let (mut back, mut open, mut left_out) = (0.0, 0.0, 0.0);
                // Areas of sequences by their passes, and of those that end for good there.
                let (mut all, mut ended) = (BTreeMap::new(), BTreeMap::new());
                for (number, pit) in proof.pits.iter().enumerate() {
                    let (found, dropped) = leaves(&proof.pits, number, &patch, &rules);
                    left_out += dropped;
                    for leaf in found {
                        let area = polygon::area(&leaf.ever);
                        *all.entry(leaf.passes).or_insert(0.0) += area;
                        if !leaf.goes_on {
                            *ended.entry(leaf.passes).or_insert(0.0) += area;
                        }
                        if leaf.returns {
                            let found = Returned::of(&leaf, pit, &patch, &rules);
                            back += area * found.expect("a fixed point").weight.0[0];
                        }
                        open += f64::from(u8::from(leaf.open)) * area * leaf.power;
                    }
                }
                let whole = exact.entrance_area();
                // Slivers that are left out, and the rounding of corners.
                let slack = left_out + 1e-9;
                for (&passes, area) in &all {
                    let before: f64 = ended.range(..passes).map(|(_, area)| area).sum();
                    let off = area + before - whole;
                    assert!(off.abs() < slack, "{which} {i} {a} {passes}: {off}");
                    shared += 1;
                }
                let eta = truth.retroreflected * whole;
                let given_up = rules.power_given_up() * whole;
                let within = back - slack - given_up < eta && eta < back + open + slack + given_up;
                assert!(within, "{which} {i} {a}: {eta} {back} {open}");
                open_most = open_most.max(open);
                tried += 1;
            }
            println!("{which} {index}: at most {open_most:.1e} left open");
            assert!(open_most < limit, "{which} {index}");
        }
        println!("{tried} directions, {shared} passes");
        assert!(tried == 540 && shared > 5 * tried, "{tried} {shared}");
    }

    /// Tables whose directions were chosen are proved part by part: those of ideal cubes in no more
    /// directions than trials alone ask for.
    #[test]
    fn chosen_directions_are_proved() {
        type Kind = fn(Request) -> Request;
        let mut proved = 0;
        let cases: [(usize, f64, f64, f64, Kind, usize); 14] = [
            (0, 1.49, 45.0, 0.005, ideal, 6),
            (0, 1.0, 60.0, 0.005, ideal, 8),
            (0, 1.0, 60.0, 0.001, ideal, 8),
            (1, 1.49, 45.0, 0.005, ideal, 4),
            (2, 1.49, 45.0, 0.005, ideal, 9),
            (3, 1.0, 30.0, 0.005, ideal, 114),
            (3, 1.49, 38.0, 0.005, ideal, 15),
            (0, 1.49, 38.0, 0.005, aluminium, 6),
            (0, 1.0, 30.0, 0.005, aluminium, 30),
            (0, 1.49, 10.0, 0.005, bare, 4),
            (0, 1.49, 10.0, 0.005, total, 4),
            (4, 1.49, 38.0, 0.02, ideal, 20),
            (5, 1.49, 8.0, 0.02, ideal, 30),
            (0, 1.49, 38.0, 0.02, trapped, 12),
        ];
        for (which, index, steepest, tolerance, kind, most) in cases {
            let cell = &cells()[which];
            let request = kind(Request {
                direction_tolerance: Some(tolerance),
                ..request(&format!("0,{steepest}"), "full", index)
            });
            let plan = Plan::new(&request).expect("a valid request");
            let prepared = Prepared::new(cell.clone());
            let start = std::time::Instant::now();
            let bake = Bake::new(&prepared, &plan).expect("a bake");
            let seconds = start.elapsed().as_secs_f64();
            assert!(bake.is_proved(), "{}", cell.design);
            let exact = prepared.exact().expect("planar");
            let proof = provable(exact, &bake.rules, trial::ASTRAY_RAD).expect("of the class");
            let table = bake.beams(exact, Watch::none()).expect("a table");
            let ends = &table.axes.azimuth_deg;
            let (_, width) = bake.symmetry.sector_deg();
            let ends: Vec<f64> = match bake.symmetry.mirror_deg {
                Some(_) => ends.clone(),
                None => ends.iter().copied().chain([ends[0] + width]).collect(),
            };
            let bounds = parts(
                &proof,
                &table,
                &ends,
                tolerance,
                &mut Known::default(),
                Watch::none(),
            )
            .expect("bounds");
            for part in &bounds.parts {
                assert!(part.bound <= tolerance, "{}: {part:?}", cell.design);
                proved += 1;
            }
            let (incidences, azimuths) = table.axes.shape();
            println!(
                "{} {index}: {incidences} x {azimuths} directions in {seconds:.1} s, {tolerance} \
                 in {} parts",
                cell.design,
                bounds.parts.len()
            );
            assert!(incidences * azimuths <= most, "{}", cell.design);
        }
        println!("{proved} parts");
        assert!(proved > 500);
    }

    /// A table interpolates from its last azimuth on to its first if that gap is no wider than its
    /// widest one, so the tolerance holds there too. Looked at without this gap, the table of these
    /// angles erred by 0.04 at 29 and 15 degrees.
    #[test]
    fn the_gap_from_the_last_azimuth_to_the_first_is_bounded() {
        let request = aluminium(Request {
            direction_tolerance: Some(0.005),
            ..request("20,38", "18,342", 1.49)
        });
        let plan = Plan::new(&request).expect("a valid request");
        let prepared = Prepared::new(cells()[0].clone());
        let bake = Bake::new(&prepared, &plan).expect("a bake");
        assert!(bake.is_proved());
        let exact = prepared.exact().expect("planar");
        let table = bake.beams(exact, Watch::none()).expect("a table");
        let mut tried = 0;
        for azimuth in (0..20).chain(340..360) {
            let error = trial::error(exact, &bake.rules, &table, 29.0, f64::from(azimuth));
            assert!(error <= 0.005, "{azimuth}: {error}");
            tried += 1;
        }
        println!("{tried} directions");
        assert_eq!(tried, 40);
    }

    /// Cells and rules that the bound does not cover are not said to be proved.
    #[test]
    fn the_class_is_what_the_proof_covers() {
        let class = |cell: &Cell, change: &dyn Fn(&mut Request)| {
            let mut request = request("0,30", "full", 1.49);
            change(&mut request);
            let plan = Plan::new(&request).expect("a valid request");
            let prepared = Prepared::new(cell.clone());
            let rules = plan.rules(prepared.cell());
            let exact = prepared.exact().expect("planar");
            provable(exact, &rules, trial::ASTRAY_RAD).map(|proof| proof.pits.len())
        };
        let [pair, single, canted, uneven, full, uneven_full] = cells();
        let plain = &|_: &mut Request| ();
        assert_eq!(class(&pair, plain), Some(2));
        assert_eq!(class(&single, plain), Some(1));
        assert!(class(&canted, plain).is_some());
        assert_eq!(class(&uneven, plain), Some(2));
        assert_eq!(class(&full, plain), Some(1));
        assert_eq!(class(&uneven_full, plain), Some(1));
        assert_eq!(class(&pair, &|request| request.back = Back::Tir), Some(2));
        let lossy = |request: &mut Request| request.losses = Losses::Fresnel;
        assert_eq!(class(&pair, &lossy), Some(2));
        let trapped = |request: &mut Request| request.scene.front = Front::Trapped;
        assert_eq!(class(&pair, &trapped), Some(2));
        assert_eq!(class(&full, &trapped), Some(1));
        let both = |request: &mut Request| {
            trapped(request);
            lossy(request);
        };
        assert_eq!(class(&pair, &both), Some(2));
        let plate = |request: &mut Request| request.scene.element = Element::Plate;
        assert_eq!(class(&pair, &plate), None);
    }
}
