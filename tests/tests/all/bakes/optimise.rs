//! The best cell as a maker finds it: the worked goal, its files, and what is refused.

use serde_json::Value;
use std::fs;
use tests::files::argument;
use tests::program::bake;

/// The worked goal, with fewer cells, gives a front, a mesh whose table has the stated eta, and a
/// picture without texts over each other. The same words give the same bytes.
#[test]
fn the_worked_goal_gives_a_front_and_a_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let goal = fs::read_to_string(argument("bake/doc/goal.toml")).unwrap();
    fs::write(here.join("goal.toml"), format!("cells = 2000\n{goal}")).unwrap();
    let words = "optimise goal.toml -o best.obj --plot front.svg";
    let text = bake(here, words).done();
    assert!(
        text.contains("traced again by rays") && !text.contains("differs"),
        "{text}"
    );
    let mesh = fs::read(here.join("best.obj")).unwrap();
    let picture = fs::read_to_string(here.join("front.svg")).unwrap();
    let found: Value =
        serde_json::from_str(&bake(here, &format!("{words} --json")).done()).unwrap();
    assert!(fs::read(here.join("best.obj")).unwrap() == mesh);
    assert!(fs::read_to_string(here.join("front.svg")).unwrap() == picture);
    assert_eq!(charts::check::faults(&picture), Vec::<String>::new());
    assert!(found["front"].as_array().unwrap().len() > 10);
    let designs = found["designs"].as_array().unwrap();
    for (own, name) in designs.iter().zip(["canted", "full-cube"]) {
        let own_front = |cell: &&Value| cell["cell"]["design"] == name;
        let count = found["front"]
            .as_array()
            .unwrap()
            .iter()
            .filter(own_front)
            .count();
        assert!(own["design"] == name && own["on_front"] == count, "{own}");
        let line = match count {
            0 => format!("{name}: not on the front"),
            _ => format!("{name}: {count} cells on the front"),
        };
        assert!(text.contains(&line), "{line}\n{text}");
    }
    assert_eq!(designs.len(), 2);
    assert!(found["best"]["lowest_mtf"].as_f64().unwrap() >= 0.05);
    assert_eq!(found["cells"], 2000);

    bake(
        here,
        "trace best.obj -o best.h5 --incidence 0,20,40 --azimuth 0 --refractive-index 1.49 \
         --losses fresnel --metal aluminium --wavelength-nm 550",
    )
    .done();
    let table = tables::read(&here.join("best.h5")).unwrap();
    let eta = &table.retroreflected;
    let mean = 0.5 * eta[[0, 0]] + 0.25 * (eta[[1, 0]] + eta[[2, 0]]);
    let stated = found["best"]["luminance"].as_f64().unwrap();
    assert!((mean - stated).abs() < 1e-12, "{mean} {stated}");
    let c = found["best"]["cell"]["edge_length_mm"].as_f64().unwrap();
    assert!((table.provenance.edge_length / c - 1.0).abs() < 1e-12);
    let checks = found["by_rays"].as_array().unwrap();
    assert_eq!(checks.len(), 3);
    for (k, own) in checks.iter().enumerate() {
        assert!((own["eta"].as_f64().unwrap() - eta[[k, 0]]).abs() < 1e-12);
    }
    // Edge length, cant or truncation, index, three errors and all errors.
    assert!(found["sensitivity"].as_array().unwrap().len() >= 6);
}

/// Wrong goals are refused with file, line and remedy, and the files that were there stay.
#[test]
fn wrong_goals_leave_files_alone() {
    let folder = tempfile::tempdir().unwrap();
    let here = folder.path();
    let goal = fs::read_to_string(argument("bake/doc/goal.toml")).unwrap();
    fs::write(here.join("old.obj"), "old").unwrap();
    let changes = [
        (
            "best = \"both\"",
            "best = \"all\"",
            "goal.toml:3: `best` is \"all\"",
        ),
        ("best = \"both\"", "better = 1", "unknown key `better`"),
        ("best = \"both\"", "", "`best` is missing"),
        ("[0.5, 1]", "[]", "`frequency_per_mm`"),
        ("[0.5, 1]", "[0.5, -1]", "from 0.001 to 1000 /mm"),
        (
            "incidence_deg = [0]",
            "incidence_deg = [90]",
            "below 90 degrees",
        ),
        (
            "incidence_deg = [0]",
            "incidence_deg = []",
            "goal.toml:7: `incidence_deg` is empty",
        ),
        ("[20, 40]", "[20, 20]", "names a value twice"),
        (
            "{ from = 0.05, to = 1 }",
            "{ from = 1, to = 0.05 }",
            "smaller number under `from`",
        ),
        (
            "{ from = 0.05, to = 1 }",
            "[0.05, 1]",
            "`edge_length_mm` must be",
        ),
        ("\"canted\", ", "", "`cant_deg` has no effect"),
        (", \"full-cube\"", "", "`truncation` has no effect"),
        ("\"canted\"", "\"cubes\"", "\"cubes\", which means nothing"),
        ("\"canted\"", "\"full-cube\"", "names a design twice"),
        ("550", "550\nmetal = \"gold\"", "gold"),
        (
            "550",
            "550\ndihedral_error_mrad = [0, 1]",
            "give three, one for each edge",
        ),
        (
            "least_mtf = 0.05",
            "least_mtf = 0.9\ncells = 200",
            "no cell keeps every frequency",
        ),
    ];
    let mut refused = 0;
    for (right, wrong, message) in changes {
        assert!(goal.contains(right), "{right}");
        fs::write(here.join("goal.toml"), goal.replacen(right, wrong, 1)).unwrap();
        let run = bake(here, "optimise goal.toml -o old.obj");
        assert_eq!(run.code, Some(1), "{wrong}: {}", run.err);
        assert!(run.err.contains(message), "{wrong}: {}", run.err);
        assert_eq!(run.err.lines().count(), 1, "{}", run.err);
        refused += 1;
    }
    let sharp = goal.replace("\"both\"", "\"mtf\"");
    fs::write(here.join("sharp.toml"), sharp).unwrap();
    for (words, code, message) in [
        ("optimise none.toml -o old.obj", 1, "none.toml"),
        ("optimise goal.toml -o old.stl", 2, ".obj or .glb"),
        ("optimise goal.toml -o goal.obj/x.obj", 1, "goal.obj"),
        ("optimise goal.toml -o old.obj --plot old.png", 2, ".svg"),
        ("optimise goal.toml", 2, "--output"),
        (
            "optimise sharp.toml -o old.obj --plot f.svg",
            2,
            "best = \"both\"",
        ),
    ] {
        let run = bake(here, words);
        assert_eq!(run.code, Some(code), "{words}: {}", run.err);
        assert!(run.err.contains(message), "{words}: {}", run.err);
        refused += 1;
    }
    assert_eq!(refused, 17 + 6);
    assert_eq!(fs::read_to_string(here.join("old.obj")).unwrap(), "old");
}
