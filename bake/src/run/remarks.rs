//! Remarks for the user of a bake: before it about its options and its cell, after it about its
//! table.

use crate::cell::Prepared;
use crate::plan::{Plan, Request};
use glam::DVec3;
use meshes::Cell;
use tables::options::{Element, Front, Method, Record};
use tables::{Fate, Table};

/// Share of a direction's light in the outermost bins of deviations above which a warning is given.
const OUTERMOST: f64 = 1e-4;

/// Share of a direction's light that three or more facets send back too far from straight back,
/// from which on a warning is given. No ideal cube has any.
const DEVIATED: f64 = 0.01;

/// Error of an angle that counts as none, rad: coordinates of six digits are no more accurate.
const UPRIGHT: f64 = 5e-6;

/// Greatest sine of the error of an angle that was meant to be a right one (5.7 degrees).
const MEANT: f64 = 0.1;

/// Largest number of planes of a solid in which walls are looked for.
const MOST_PLANES: usize = 256;

/// Bins of deviations, in the rms spread of the light, below which a warning calls them coarse.
///
/// A bin of width w takes 1 - sinc(f R w) of an MTF. Of a Gaussian lobe with the rms s along each
/// axis that is at most 0.031 (w / s)^2, at any distance: 1 % where the rms of both axes together
/// is 2.5 w.
const FEW_BINS: f64 = 2.5;

/// Width of a bin of deviations, mrad, that is fine enough for any cell: 10 um at 1 m.
const FINE_MRAD: f64 = 0.01;

/// Returns remarks about the cell and about the plans that were made of `request` for it.
pub(crate) fn of_plans(request: &Request, prepared: &Prepared, plans: &[&Plan]) -> Vec<String> {
    let of_options = plans.iter().flat_map(|plan| plan.warnings(prepared));
    let mut of_options: Vec<String> = of_options.collect();
    of_options.dedup();
    let of_method = plans.first().map(|plan| of_method(request, prepared, plan));
    let of_cell = prepared.cell().warnings.iter().cloned();
    let all = of_cell.chain(of_options);
    all.chain(of_method.unwrap_or_default()).collect()
}

/// Returns a remark if the method that was chosen ignores other options, or is not the exact one.
///
/// The report names the method in any case.
fn of_method(request: &Request, prepared: &Prepared, plan: &Plan) -> Vec<String> {
    let refusal = plan.exact_cell(prepared).err();
    let asks_for_rays = request.rays.is_some() || request.tolerance.is_some();
    match (request.method, refusal) {
        (Method::Auto, Some(reason)) => vec![format!("--method auto traces rays: {reason}")],
        (Method::Auto | Method::Exact, None)
            if plan.scene.deviations != Record::Auto && !plan.is_azimuth_mean() =>
        {
            vec![
                "the exact method records where each path goes, so --deviations has no effect; \
                give --method rays to use it"
                    .into(),
            ]
        }
        (Method::Auto | Method::Exact, None) if asks_for_rays => vec![
            "the exact method traces no rays: --rays and --tolerance have no effect; give \
            --method rays to use them"
                .into(),
        ],
        _ => Vec::new(),
    }
}

/// Returns remarks about a table of a cell: no light comes back, or its deviations are badly binned.
pub(crate) fn of_table(table: &Table, cell: &Cell) -> Vec<String> {
    let mut warnings = Vec::new();
    if table.retroreflected.iter().all(|&eta| eta == 0.0) {
        let other = [Fate::AntiparallelOther, Fate::Deviated];
        warnings.push(match most(table, &other) {
            0.0 => "no light comes back in any direction: the fates say where it goes (give \
                --element plate for a plate that light passes, --glass-index for bodies of \
                glass)"
                .into(),
            share => format!(
                "no light comes straight back, but up to {:.1} % of a direction's light \
                leaves farther from straight back than --angular-tolerance ({} deg); give a \
                larger one if this light is part of the mid-air image",
                100.0 * share,
                table.provenance.angular_tolerance_deg
            ),
        });
    } else {
        warnings.extend(deviated(table, cell));
    }
    let Some(found) = &table.deviations else {
        return warnings;
    };
    let spreads = (0..found.entries.len()).map(|k| found.spread(k));
    let (mut outermost, mut rms) = (0.0_f64, 0.0_f64);
    for spread in spreads {
        (outermost, rms) = (outermost.max(spread.outermost), rms.max(spread.rms_rad));
    }
    let (width, range) = (1e3 * found.grid.bin_width(), 1e3 * found.grid.range);
    if outermost > OUTERMOST {
        warnings.push(format!(
            "up to {:.2} % of the light of a direction goes to the outermost bins of \
            deviations, or beyond them; give --deviations above {range:.4} mrad",
            100.0 * outermost
        ));
    }
    let returns = found.entries.iter().any(|entries| !entries.is_empty());
    if returns && 1e3 * rms < FEW_BINS * width && width > FINE_MRAD {
        warnings.push(format!(
            "exit directions are counted in bins of {width:.4} mrad, which is coarse for their \
            spread (rms {:.4} mrad); give --deviations {:.4}",
            1e3 * rms,
            found.advised_mrad()
        ));
    }
    warnings
}

/// Returns a warning about light of three or more facets that is too far from straight back.
/// Light in a plate, through glass, or that a front face has sent back takes any direction, and
/// is none of it.
fn deviated(table: &Table, cell: &Cell) -> Option<String> {
    let from = &table.provenance;
    let cubes = from.element() == Element::Retroreflector && !from.has_glass();
    let once = from.options.front() == Front::Once;
    let share = most(table, &[Fate::Deviated]);
    let reason = match has_walls(cell) {
        true => {
            "the side walls of the solid reflect it; where the sheet goes on beside the cell, leave \
            them out of the mesh"
        }
        false => {
            "facets are not at right angles; if they should be, write the mesh with more digits, \
            and if not, give a larger tolerance where this light is part of the mid-air image"
        }
    };
    (cubes && once && share > DEVIATED).then(|| {
        format!(
            "up to {:.1} % of a direction's light leaves after three or more reflections, but \
            farther from straight back than --angular-tolerance ({} deg): {reason}",
            100.0 * share,
            table.provenance.angular_tolerance_deg
        )
    })
}

/// Returns whether the cell is a solid with side walls at right angles to its front, whose other
/// facets miss no right angle.
///
/// Light of a corner that also meets a wall leaves in any direction, whatever the angles of the
/// corner.
fn has_walls(cell: &Cell) -> bool {
    let normal = |[a, b, c]: &[DVec3; 3]| (b - a).cross(c - a).normalize_or_zero();
    let mut facets: Vec<DVec3> = Vec::new();
    let mut walls = false;
    for normal in cell.facets.iter().map(normal) {
        if normal.z.abs() < UPRIGHT {
            walls = true;
        } else if !facets.iter().any(|own| own.distance(normal) < UPRIGHT) {
            facets.push(normal);
        }
        if facets.len() > MOST_PLANES {
            return false;
        }
    }
    let pairs = (0..facets.len()).flat_map(|i| (0..i).map(move |j| (i, j)));
    let sines = pairs.map(|(i, j)| facets[i].dot(facets[j]).abs());
    let mut missed = sines.filter(|sine| (UPRIGHT..MEANT).contains(sine));
    cell.closed && walls && missed.next().is_none()
}

/// Returns the largest share of the light of a direction that has one of these fates.
fn most(table: &Table, fates: &[Fate]) -> f64 {
    let (incidences, azimuths) = table.axes.shape();
    let all = (0..incidences).flat_map(|i| (0..azimuths).map(move |a| (i, a)));
    let of = |i, a, fate| table.fate[[i, a, fate as usize]];
    all.map(|(i, a)| fates.iter().map(|&fate| of(i, a, fate)).sum())
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::{Progress, trace};
    use meshes::design::{Design, Shape};

    /// A pair loses half of its light without a word if one of its apexes is 2 % off. That is said
    /// from 1 % of the light on, and not of the pair itself.
    #[test]
    fn light_that_facets_send_astray_is_said() {
        let remarks = |off: f64| {
            let mut mesh = Design::new(Shape::TriangularPair).mesh().expect("a mesh");
            // The apex of the second cube.
            mesh.positions[4].x += off;
            let options = meshes::CellOptions::default();
            let cell = meshes::normalise(&mesh, "cell.obj".as_ref(), &options).expect("a cell");
            let prepared = Prepared::new(cell);
            let plan = Plan::new(&Request {
                incidence: "0,20".into(),
                refractive_index: Some(1.0),
                ..Request::default()
            });
            let plan = plan.expect("a plan");
            let table = trace(&prepared, &plan, Progress::none()).expect("a table");
            of_table(&table, prepared.cell())
        };
        assert_eq!(remarks(0.0), Vec::<String>::new());
        let [said] = &remarks(0.02)[..] else {
            panic!("one remark");
        };
        assert!(
            said.contains("32.8 %") && said.contains("more digits"),
            "{said}"
        );
    }

    /// Side walls of a solid send light astray too, and then facets are not blamed, unless one of
    /// them is wrong as well.
    #[test]
    fn side_walls_of_a_solid_are_told_from_bent_facets() {
        let remark = |off: f64| {
            let up = |p: DVec3| p + DVec3::splat(0.3);
            let ends = [DVec3::X, DVec3::Y, DVec3::new(0.0, off, 1.0)].map(|p| p * 3.0);
            let mut mesh = meshes::Mesh {
                positions: [&[DVec3::ZERO][..], &ends, &ends.map(up)].concat(),
                triangles: vec![[0, 2, 1], [0, 3, 2], [0, 1, 3], [4, 5, 6]],
                ..meshes::Mesh::default()
            };
            for [p, q] in [[1, 2], [2, 3], [3, 1]] {
                mesh.triangles.extend([[p, q, q + 3], [p, q + 3, p + 3]]);
            }
            let options = meshes::CellOptions::default();
            let cell = meshes::normalise(&mesh, "solid.obj".as_ref(), &options).expect("a cell");
            assert!(cell.closed);
            let prepared = Prepared::new(cell);
            let request = Request {
                incidence: "20".into(),
                refractive_index: Some(1.49),
                ..Request::default()
            };
            let plan = Plan::new(&request).expect("a plan");
            let table = trace(&prepared, &plan, Progress::none()).expect("a table");
            of_table(&table, prepared.cell()).join(" ")
        };
        let (walls, both) = (remark(0.0), remark(0.002));
        assert!(
            walls.contains("side walls") && !walls.contains("right angles"),
            "{walls}"
        );
        assert!(both.contains("not at right angles"), "{both}");
    }
}
