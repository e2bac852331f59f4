//! Proof that a table keeps its tolerance in all directions between its own.

use rayon::prelude::*;
use tables::options::{Element, Front};
use tables::{Axes, Family, Table};

use crate::cell::ExactCell;
use crate::optics::Rules;
use crate::proof::{Pit, Proof, bound, pits};
use crate::run::watch::Watch;

/// Number of times that a gap is halved along both angles before it counts as not proved. Parts of
/// a gap of 30 degrees are then 0.03 degrees wide.
const HALVINGS: usize = 10;

/// Largest number of parts of a gap that are looked at before it counts as not proved. With 400, a
/// hollow pair would need 15 directions for a tolerance of 0.001, where 8 are enough.
const MOST_PARTS: usize = 1000;

/// Largest number of pits whose tolerance is proved. A pair has two.
const MOST_PITS: usize = 8;

/// Number of faces of such a pit: three mirrors and the opening. With more mirrors, as a flat apex
/// has, light of one map comes from several polygons, and 40 s of search proved nothing where
/// trials end after 3 s.
const FACES: usize = 4;

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

/// Returns what is needed for proofs, or `None` if the class of the cell has none.
///
/// The class has convex pits of three mirrors, ideal mirrors and a front that sends nothing back.
/// The mirrors need not be at right angles: the six orders of the facets are then six paths with
/// nearly one map, whose polygons are bounded together ([`bound`]). What the interpolation mistakes
/// for a neighbour's light goes to nearly the same place. With errors of milliradians even that may
/// be too much, and the search falls back to trials. Others are kept out:
///
/// - In a lattice light meets facets of many copies, some behind others, and losses depend on the
///   direction otherwise than by lines. Neither is enclosed here.
/// - Each family is compared with each pit, so the time grows with the square of their number.
pub(crate) fn provable(exact: &ExactCell, rules: &Rules, astray_rad: f64) -> Option<Proof> {
    let simple = rules.losses.is_none()
        && rules.mirror_back
        && rules.roughness.is_none()
        && rules.glass_index.is_none()
        && rules.front == Front::Once
        && rules.element == Element::Retroreflector;
    let all = exact.bodies.iter().map(pits);
    let all: Option<Vec<_>> = all.collect();
    let pits: Vec<Pit> = all?.into_iter().flatten().collect();
    let few = pits.len() <= MOST_PITS && pits.iter().all(|pit| pit.faces.len() == FACES);
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
/// bound is above it, and the rest of the gap is left out.
pub(crate) fn parts(
    proof: &Proof,
    table: &Table,
    azimuth_ends: &[f64],
    tolerance: f64,
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
            return Some((vec![unknown], 1));
        };
        let mut search = Gap {
            proof,
            families: &families,
            ends: gap,
            tolerance,
            found: Vec::new(),
            looked: 0,
        };
        search.divide(gap, HALVINGS);
        Some((search.found, search.looked))
    };
    let found: Option<Vec<(Vec<Part>, usize)>> = all.par_iter().map(of).collect();
    let (parts, looked): (Vec<Vec<Part>>, Vec<usize>) = found?.into_iter().unzip();
    Some(Bounds {
        parts: parts.concat(),
        looked: looked.iter().sum(),
    })
}

/// Gap between directions of a table.
struct Gap<'a> {
    proof: &'a Proof,
    families: &'a [Family],
    /// Incidences and azimuths, degrees.
    ends: [[f64; 2]; 2],
    tolerance: f64,
    /// Parts with a bound.
    found: Vec<Part>,
    /// Number of parts looked at.
    looked: usize,
}

impl Gap<'_> {
    /// Bounds the error in `part`, in quarters where the bound is above the tolerance, `left` times
    /// at most. Returns whether all of the part is proved.
    fn divide(&mut self, part: [[f64; 2]; 2], left: usize) -> bool {
        let bound = bound(self.proof, self.families, self.ends, part);
        self.looked += 1;
        if bound <= self.tolerance || left == 0 || self.looked >= MOST_PARTS {
            let [incidence_deg, azimuth_deg] = part;
            self.found.push(Part {
                incidence_deg,
                azimuth_deg,
                bound,
            });
            return bound <= self.tolerance;
        }
        let halves = |[from, to]: [f64; 2]| match 0.5 * (from + to) {
            middle if from < middle && middle < to => vec![[from, middle], [middle, to]],
            _ => vec![[from, to]],
        };
        let across = halves(part[1]);
        let mut quarters = halves(part[0])
            .into_iter()
            .flat_map(|along| across.iter().map(move |&across| [along, across]));
        quarters.all(|quarter| self.divide(quarter, left - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::Prepared;
    use crate::plan::{Plan, Request};
    use crate::run::bake::Bake;
    use crate::run::trial;
    use meshes::Cell;
    use meshes::design::{Design, Shape};
    use tables::options::{Back, Losses};

    fn design(name: &str, change: impl FnOnce(&mut Design)) -> Cell {
        let mut design = Design::new(Shape::from_name(name).expect("a design"));
        change(&mut design);
        let mesh = design.mesh().expect("a mesh");
        meshes::normalise(&mesh, "cell.obj".as_ref(), &meshes::CellOptions::default())
            .expect("a cell")
    }

    /// Returns cells of convex pits. The last one has dihedral errors.
    fn cells() -> [Cell; 4] {
        [
            design("triangular-pair", |_| ()),
            design("triangular", |_| ()),
            design("canted", |design| design.cant_rad = 0.2),
            design("triangular-pair", |design| {
                design.dihedral_error_rad = [5e-4, 0.0, -3e-4];
            }),
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

    /// Bounds against trials, in coarse tables and in spoiled ones, so that the errors are large,
    /// and in finer ones, so that the bounds are small. Every gap is cut into 8 x 8 parts, and one
    /// direction is tried in each.
    #[test]
    fn no_trial_exceeds_its_bound() {
        let (mut tried, mut ratios, mut worst) = (0, Vec::new(), 0.0_f64);
        let mut uneven = 0;
        for (which, cell) in cells().iter().enumerate() {
            for (index, incidence, azimuth) in [
                (1.0, "0,25,50", "full:60"),
                (1.49, "0,30,60", "full:60"),
                (1.0, "20,26", "full:20"),
            ] {
                let request = request(incidence, azimuth, index);
                let plan = Plan::new(&request).expect("a valid request");
                let prepared = Prepared::new(cell.clone());
                let exact = prepared.exact().expect("planar");
                let bake = Bake::new(&prepared, &plan).expect("a bake");
                let pits = exact.bodies.iter().map(pits).collect::<Option<Vec<_>>>();
                let proof = Proof {
                    pits: pits.expect("pits").concat(),
                    entrance_area: exact.entrance_area(),
                    rules: bake.rules,
                    astray_rad: trial::ASTRAY_RAD,
                };
                for how in 0..3 {
                    let table = bake.beams(exact, Watch::none()).expect("a table");
                    let table = spoiled(table, how);
                    let axes = &table.axes;
                    let gaps = axes.incidence_deg.windows(2).flat_map(|i| {
                        let azimuths = axes.azimuth_deg.windows(2);
                        azimuths.map(move |a| [[i[0], i[1]], [a[0], a[1]]])
                    });
                    for gap in gaps {
                        let [a, b] = gap.map(|[from, to]| 0.5 * (from + to));
                        let families = table.families(a, b).expect("families");
                        let found: Vec<(f64, f64)> = (0..SIDE * SIDE)
                            .into_par_iter()
                            .map(|k| {
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
                            })
                            .collect();
                        for (bound, error) in found {
                            assert!(error <= bound, "{} {index} {how}: {gap:?}", cell.design);
                            tried += 1;
                            worst = worst.max(error);
                            if error > 1e-3 && bound.is_finite() {
                                ratios.push(bound / error);
                                uneven += u32::from(which == 3);
                            }
                        }
                    }
                }
            }
        }
        ratios.sort_by(f64::total_cmp);
        let [least, middle] = [ratios[0], ratios[ratios.len() / 2]];
        println!(
            "{tried} directions, errors up to {worst:.3}; bound by error, of {} above 0.001 \
             ({uneven} with dihedral errors): at least {least:.2}, median {middle:.1}",
            ratios.len()
        );
        assert!(tried > 5000 && worst > 0.05 && ratios.len() > 500 && uneven > 200);
    }

    /// Tables whose directions were chosen are proved part by part: those of ideal cubes in no more
    /// directions than trials alone ask for.
    #[test]
    fn chosen_directions_are_proved() {
        let mut proved = 0;
        for (cell, index, steepest, tolerance, most) in [
            (&cells()[0], 1.49, 45.0, 0.005, 6),
            (&cells()[0], 1.0, 60.0, 0.005, 8),
            (&cells()[0], 1.0, 60.0, 0.001, 8),
            (&cells()[1], 1.49, 45.0, 0.005, 4),
            (&cells()[2], 1.49, 45.0, 0.005, 9),
            (&cells()[3], 1.0, 30.0, 0.005, 114),
            (&cells()[3], 1.49, 38.0, 0.005, 15),
        ] {
            let request = Request {
                direction_tolerance: Some(tolerance),
                ..request(&format!("0,{steepest}"), "full", index)
            };
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
            let bounds = parts(&proof, &table, &ends, tolerance, Watch::none()).expect("bounds");
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
        let [pair, single, canted, uneven] = cells();
        let plain = &|_: &mut Request| ();
        assert_eq!(class(&pair, plain), Some(2));
        assert_eq!(class(&single, plain), Some(1));
        assert!(class(&canted, plain).is_some());
        assert_eq!(class(&uneven, plain), Some(2));
        assert_eq!(class(&design("full-cube", |_| ()), plain), None);
        assert_eq!(class(&pair, &|request| request.back = Back::Tir), None);
        let lossy = |request: &mut Request| request.losses = Losses::Fresnel;
        assert_eq!(class(&pair, &lossy), None);
    }
}
