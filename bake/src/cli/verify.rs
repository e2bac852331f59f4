//! `bake verify`: checks a table on its own, and against its mesh: by rays, by the exact bake, and
//! by what the table states about its bake.

use crate::cell::Prepared;
use crate::cli::cell::CellArgs;
use crate::cli::report::comparison_text;
use crate::error::Error;
use crate::run::{
    Claims, Comparison, Progress, Unchecked, claims, consistent, error_between, rebake, retrace,
};
use clap::Args;
use meshes::Cell;
use std::hash::{BuildHasher, Hasher, RandomState};
use std::path::{Path, PathBuf};
use tables::Table;
use tables::cli::{print, warn, whole};
use tables::options::SceneOptions;
use tables::reader::Protection;

/// Largest difference of an edge length or a direction that is not said: a mesh of six digits.
const SAME: f64 = 1e-6;

/// Options of `bake verify`.
#[derive(Debug, Args)]
pub(crate) struct VerifyArgs {
    /// Table to check
    table: PathBuf,
    /// Mesh that is compared with the table
    ///
    /// Where the exact method takes the cell, it bakes all directions, and eta, fates, shifts and
    /// exit directions are compared, those of an exact table path by path. Rays are traced in some
    /// directions, or in all of them where only rays can. What the table states about its bake is
    /// held against the mesh. What could not be checked is listed.
    #[arg(long)]
    mesh: Option<PathBuf>,
    #[command(flatten)]
    cell: CellArgs,
    /// Rays per direction, with --mesh
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1_048_576,
        value_parser = whole::<u64>(1..1 << 40)
    )]
    rays: u64,
    /// Seed of the choice of directions and of their rays [default: another one each time]
    ///
    /// The seed is printed. Given again, it repeats a check. Nobody can make a table for a seed
    /// that is chosen after it.
    #[arg(long, value_parser = whole::<u64>(0..))]
    seed: Option<u64>,
    /// Prints the result as one JSON object
    #[arg(long)]
    json: bool,
}

/// Table held against its mesh.
struct Judged {
    /// Seed of the directions and rays.
    seed: u64,
    /// Comparison with rays.
    rays: Comparison,
    /// Comparison with the exact bake, if the exact method takes the cell.
    baked: Option<Comparison>,
    /// Greatest error between directions that was found, if the table states a tolerance.
    between: Option<f64>,
    /// Tolerance between directions that the table states.
    stated: Option<f64>,
    /// Statements of the table about its bake.
    claims: Claims,
}

/// Runs `bake verify`.
pub(crate) fn run(args: &VerifyArgs) -> Result<(), Error> {
    let tables::apart::Reading { table, lacking } = tables::apart::read(&args.table)?;
    let name = args.table.display();
    consistent(&table).map_err(|forged| {
        let remedy = "somebody changed the table after the bake, bake it again";
        Error::Failed(format!("{name}: {forged}; {remedy}"))
    })?;
    known(&table, &args.table)?;
    let sealed = tables::is_sealed(&args.table)?;
    let judged = args
        .mesh
        .as_deref()
        .map(|mesh| judged(&table, mesh, args))
        .transpose()?;
    print(&match args.json {
        true => json(&table, judged.as_ref(), sealed, &lacking),
        false => {
            let seal = match sealed {
                true => "",
                false => {
                    "; its seal is gone because another program wrote to the file, but its \
                    content hash is right"
                }
            };
            let head = format!(
                "{}: valid, {} directions, content {}{seal}\n",
                args.table.display(),
                table.retroreflected.len(),
                table.content_hash()
            );
            let compared = judged.as_ref().map(|judged| compared(judged, &table));
            let left = unchecked(judged.as_ref());
            let left = left.iter().map(|one| format!("unchecked: {one}\n"));
            head + &note(&lacking) + &compared.unwrap_or_default() + &left.collect::<String>()
        }
    })?;
    let Some(judged) = judged else {
        return Ok(());
    };
    let mesh = args.mesh.clone().unwrap_or_default();
    let mesh = mesh.display();
    let fault = match (judged.between, judged.stated) {
        _ if let Some(wrong) = judged.claims.wrong.first() => {
            format!("{name} does not agree with {mesh}: {wrong}")
        }
        _ if !judged.rays.agrees() => format!(
            "{name} does not agree with the rays through {mesh}: they differ by more than both \
            errors"
        ),
        _ if judged.baked.is_some_and(|baked| !baked.agrees()) => format!(
            "{name} does not agree with the exact bake of {mesh} made again: they differ by more \
            than counting and rounding explain"
        ),
        (Some(found), Some(stated)) if found > stated => format!(
            "{name}: its direction_tolerance is {stated}, but between its directions it is off by \
            {found:.2e}"
        ),
        _ => return Ok(()),
    };
    Err(Error::Failed(format!("{fault}; bake the table again")))
}

/// Returns what was not checked.
fn unchecked(judged: Option<&Judged>) -> Vec<Unchecked> {
    match judged {
        Some(judged) => judged.claims.unchecked.clone(),
        None => vec![Unchecked {
            attribute: "all",
            why: "only the mesh can tell whether the numbers and the options are right; give \
                --mesh"
                .into(),
        }],
    }
}

/// Returns the result as one line of JSON.
fn json(table: &Table, judged: Option<&Judged>, sealed: bool, lacking: &[Protection]) -> String {
    let baked = judged.and_then(|judged| judged.baked.as_ref());
    let exact = baked.map(Comparison::agrees);
    let left: Vec<_> = unchecked(judged)
        .iter()
        .map(|one| serde_json::json!({ "attribute": one.attribute, "why": one.why }))
        .collect();
    let value = serde_json::json!({
        "valid": true, "sealed": sealed, "content_hash": table.content_hash(),
        "directions": table.retroreflected.len(),
        "mesh_agrees": judged.map(|judged| judged.rays.agrees()),
        "polygons_agree": exact.filter(|_| table.exact.is_some()),
        "exact_bake_agrees": exact,
        "directions_traced": judged.map(|judged| judged.rays.rows.len()),
        "directions_baked": baked.map(|baked| baked.rows.len()),
        "error_between": judged.and_then(|judged| judged.between),
        "seed": judged.map(|judged| judged.seed),
        "contradictions": judged.map(|judged| contradictions(&judged.claims)),
        "unchecked": left,
        "reader_lacks": lacking.iter().map(|one| one.words()).collect::<Vec<_>>() });
    format!("{value}\n")
}

/// Checks that this version knows all words of a table.
///
/// # Errors
/// Returns an [`Error`] for the first word that a later version wrote, or nobody.
fn known(table: &Table, file: &Path) -> Result<(), Error> {
    let from = &table.provenance;
    let sampler = from.sampler.as_ref();
    let words = [
        ("method", from.method.text(), from.method.known().is_some()),
        (
            "sampler",
            from.sampler_text(),
            sampler.is_none_or(|word| word.known().is_some()),
        ),
        ("back", from.back.text(), from.back.known().is_some()),
        ("losses", from.losses.text(), from.losses.known().is_some()),
        (
            "options",
            from.options.text(),
            from.options.known().is_some(),
        ),
    ];
    match words.into_iter().find(|(_, _, known)| !known) {
        Some((attribute, word, _)) => Err(Error::Failed(format!(
            "{}: its {attribute} \"{word}\" is not known to this version of bake; update bake, or \
            bake the table again",
            file.display()
        ))),
        None => Ok(()),
    }
}

/// Returns what a table states wrongly, as JSON.
fn contradictions(claims: &Claims) -> Vec<serde_json::Value> {
    let wrong = claims.wrong.iter();
    wrong
        .map(|one| {
            serde_json::json!({
                "attribute": one.attribute, "stated": one.stated, "found": one.found
            })
        })
        .collect()
}

/// Returns the comparisons with the mesh as text.
fn compared(judged: &Judged, table: &Table) -> String {
    let all = table.retroreflected.len();
    let mut text = format!(
        "{} of {all} directions traced again, with the seed {}:\n",
        judged.rays.rows.len(),
        judged.seed
    );
    text.push_str(&comparison_text(&judged.rays));
    if let Some(baked) = &judged.baked {
        text.push_str(match table.exact {
            Some(_) => "the exact bake made again, path by path:\n",
            None => "the exact bake in all directions:\n",
        });
        text.push_str(&comparison_text(baked));
    }
    if let (Some(found), Some(stated)) = (judged.between, judged.stated) {
        let line = format!("error between directions: {found:.2e}, direction_tolerance {stated}\n");
        text.push_str(&line);
    }
    for wrong in &judged.claims.wrong {
        text.push_str(&format!("wrong: {wrong}\n"));
    }
    text
}

/// Returns what the reader of this table lacked, as a line; nothing if it lacked nothing.
fn note(lacking: &[Protection]) -> String {
    if lacking.is_empty() {
        return String::new();
    }
    let words: Vec<&str> = lacking.iter().map(|one| one.words()).collect();
    format!(
        "note: this system did not give the reader of tables {}; do not open tables of strangers \
        here\n",
        words.join(", ")
    )
}

/// Holds a table against its mesh.
///
/// Edge length and azimuth 0 are those of the table, unless the options give others.
///
/// # Errors
/// Returns an [`Error`] if no bake takes the options of the table, if the mesh lacks its symmetry,
/// or if the mesh cannot be loaded or traced.
fn judged(table: &Table, mesh: &Path, args: &VerifyArgs) -> Result<Judged, Error> {
    let from = &table.provenance;
    let scene = from.options.known().unwrap_or_default();
    let (cell, own) = loaded(table, mesh, &args.cell, &scene)?;
    warn(&cell.warnings);
    if cell.mesh_hash != from.mesh_hash {
        warn(&[format!(
            "{} is not the file that the table was baked from (its hash differs); its rays are \
            compared with the table nevertheless",
            mesh.display()
        )]);
    }
    let failed = |error| match error {
        Error::Stated(_) => Error::Failed(format!("{}: {error}", args.table.display())),
        error => error,
    };
    let prepared = Prepared::new(cell);
    let seed = args.seed.unwrap_or_else(drawn);
    let (rays, progress) = (args.rays, Progress::none());
    let mut claims = claims(table, &prepared, rays, seed, progress).map_err(failed)?;
    claims.unchecked.splice(0..0, own);
    Ok(Judged {
        seed,
        rays: retrace(table, &prepared, rays, seed, progress).map_err(failed)?,
        baked: rebake(table, &prepared, progress).map_err(failed)?,
        between: error_between(table, &prepared, seed).map_err(failed)?,
        stated: from.direction_tolerance,
        claims,
    })
}

/// Returns the cell of a mesh with the edge length and azimuth 0 of a table, and which of them are
/// not the mesh's own.
fn loaded(
    table: &Table,
    mesh: &Path,
    args: &CellArgs,
    scene: &SceneOptions,
) -> Result<(Cell, Vec<Unchecked>), Error> {
    let from = &table.provenance;
    let own = args.load(mesh, scene).ok();
    let own = match own {
        Some(own)
            if own.edge_length == from.edge_length
                && own.azimuth_zero.to_array() == from.azimuth_zero =>
        {
            return Ok((own, Vec::new()));
        }
        own => own,
    };
    let [x, y, z] = from.azimuth_zero;
    let cell = CellArgs {
        edge_length: args.edge_length.or(Some(from.edge_length)),
        azimuth_zero: (args.azimuth_zero.clone()).or(Some(format!("{x},{y},{z}"))),
        lattice: args.lattice.clone(),
        unit: args.unit.clone(),
    }
    .load(mesh, scene)?;
    let mut unchecked = Vec::new();
    if let Some(own) = own {
        if (own.edge_length / cell.edge_length - 1.0).abs() > SAME {
            unchecked.push(Unchecked {
                attribute: "edge_length",
                why: format!(
                    "the numbers are compared for {}, but the mesh's own is {}: shifts and c are \
                    in units of the first",
                    cell.edge_length, own.edge_length
                ),
            });
        }
        if own.azimuth_zero.distance(cell.azimuth_zero) > SAME {
            let [x, y, z] = own.azimuth_zero.to_array();
            unchecked.push(Unchecked {
                attribute: "azimuth_zero",
                why: format!(
                    "the numbers are compared for it, but the mesh's own is {x:.6},{y:.6},{z:.6}"
                ),
            });
        }
    }
    Ok((cell, unchecked))
}

/// Returns a seed that nobody can know before: from the keys that the system gives to hash maps.
///
/// It has 32 bits, so that it can be typed.
fn drawn() -> u64 {
    RandomState::new().build_hasher().finish() >> 32
}
