//! Normals at the corners of facets: equal from every kind of file, and refused if they make no
//! sense.

use glam::DVec3;
use meshes::design::{Design, Shape};
use meshes::{Cell, CellOptions, Mesh, gltf, obj, write};

use crate::cells::with as cell;

const NORMALS: CellOptions = CellOptions {
    lattice: None,
    azimuth_zero: None,
    edge_length: None,
    file_normals: true,
    glass: false,
    periodic: false,
};

fn curved(shape: Shape) -> Mesh {
    let design = Design {
        sag: 0.01,
        segments: 6,
        ..Design::new(shape)
    };
    design.mesh().expect("a design")
}

/// Corners of all facets with the normals there.
fn corners(cell: &Cell) -> Vec<(DVec3, DVec3)> {
    let normals = cell.normals.as_ref().expect("normals were asked for");
    let facets = cell.facets.iter().zip(&normals.corners);
    facets
        .flat_map(|(facet, numbers)| {
            (0..3).map(|k| (facet[k], normals.vectors[numbers[k] as usize]))
        })
        .collect()
}

fn assert_alike(one: &Cell, other: &Cell, tolerance: f64, name: &str) {
    let (one, other) = (corners(one), corners(other));
    assert_eq!(one.len(), other.len(), "{name}");
    for ((p, n), (q, m)) in one.into_iter().zip(other) {
        assert!(
            p.distance(q) < tolerance && n.distance(m) < tolerance,
            "{name}: {p} {n}, {q} {m}"
        );
    }
}

/// Rounding in each format. Text gives every digit back. f32 keeps 6e-8 of a coordinate of up to 3
/// units, in three axes, over edges of 3 units, and as much of the apex and the axes.
#[test]
fn every_file_gives_the_same_normals() {
    let mut cases = 0;
    for shape in [Shape::Triangular, Shape::TriangularPair, Shape::Canted] {
        let mesh = curved(shape);
        let plain = cell(&mesh, &NORMALS).expect("a cell");
        assert_eq!(plain.warnings, [""; 0]);
        let text = write::obj(&mesh);
        let read = obj::parse(text.as_bytes()).expect("its own file");
        assert_eq!(read.hash, mesh.hash);
        assert_alike(
            &plain,
            &cell(&read, &NORMALS).expect("a cell"),
            0.0_f64.next_up(),
            "obj",
        );
        let read = gltf::parse(&write::glb(&mesh), None).expect("its own file");
        assert_alike(&plain, &cell(&read, &NORMALS).expect("a cell"), 1e-6, "glb");
        // Texture coordinates between, indices from the end, and lengths other than 1.
        let (v, n) = (
            mesh.positions.len() as i64 + 1,
            mesh.normals.len() as i64 + 1,
        );
        let back: Vec<String> = text
            .lines()
            .map(|line| match line.split_once(' ') {
                Some(("f", corners)) => {
                    let corner = |word: &str| {
                        let (a, b) = word.split_once("//").expect("a normal");
                        let (a, b): (i64, i64) = (a.parse().unwrap(), b.parse().unwrap());
                        format!("{}/7/{}", a - v, b - n)
                    };
                    let words: Vec<String> = corners.split(' ').map(corner).collect();
                    format!("f {}", words.join(" "))
                }
                Some(("vn", vector)) => {
                    let words = vector.split(' ').map(|x| x.parse::<f64>().unwrap() * 8.0);
                    let words: Vec<String> = words.map(|x| x.to_string()).collect();
                    format!("vn {}", words.join(" "))
                }
                _ => line.to_owned(),
            })
            .collect();
        let read = obj::parse(back.join("\n").as_bytes()).expect("the same");
        // A power of two keeps all digits.
        assert_alike(
            &plain,
            &cell(&read, &NORMALS).expect("a cell"),
            0.0_f64.next_up(),
            "negative",
        );
        // The mesh is turned over: the light reaches the same faces.
        let mut over = mesh.clone();
        over.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        over.corner_normals.iter_mut().for_each(|t| t.swap(1, 2));
        let turned = cell(&over, &NORMALS).expect("a cell");
        assert_alike(&plain, &turned, 0.0_f64.next_up(), "wound clockwise");
        // Normals that all point away give the same result.
        let mut away = mesh.clone();
        away.normals.iter_mut().for_each(|n| *n = -*n);
        assert_alike(
            &plain,
            &cell(&away, &NORMALS).expect("a cell"),
            0.0_f64.next_up(),
            "away",
        );
        cases += 5;
    }
    assert_eq!(cases, 15);
}

/// A node that mirrors and stretches: positions follow the map, normals its inverse transpose.
///
/// The design, stretched by the same map, has facets with normals of their own. The carried normals
/// stay within the half facet by which these turn.
#[test]
fn nodes_turn_normals() {
    let mesh = curved(Shape::Triangular);
    let glb = write::glb(&mesh);
    let json = |bytes: &[u8]| {
        let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
        let text = String::from_utf8(bytes[20..20 + length].to_vec()).unwrap();
        (text, bytes[20 + length..].to_vec())
    };
    let (text, rest) = json(&glb);
    let mut cases = 0;
    for scale in ["[2,2,2]", "[1,1,-1]", "[-3,3,3]"] {
        let mut text = text.replace(r#"{"mesh":0}"#, &format!(r#"{{"mesh":0,"scale":{scale}}}"#));
        assert!(text.contains(scale));
        while text.len() % 4 != 0 {
            text.push(' ');
        }
        let mut bytes = b"glTF\x02\0\0\0".to_vec();
        bytes.extend((20 + text.len() as u32 + rest.len() as u32).to_le_bytes());
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(b"JSON");
        bytes.extend(text.as_bytes());
        bytes.extend(&rest);
        let read = gltf::parse(&bytes, None).expect("a file");
        let cell = cell(&read, &NORMALS).expect("a cell");
        let normals = cell.normals.as_ref().expect("normals");
        for (facet, numbers) in cell.facets.iter().zip(&normals.corners) {
            let own = (facet[1] - facet[0]).cross(facet[2] - facet[0]).normalize();
            for &number in numbers {
                // The steepest change along a face is 27 sag sqrt 2 / edge, over one facet of a
                // sixth.
                let off = normals.vectors[number as usize].angle_between(own);
                assert!(
                    off < 27.0 * 0.01 * 2_f64.sqrt() * 2.0 / 6.0,
                    "{scale}: {off}"
                );
            }
        }
        cases += 1;
    }
    assert_eq!(cases, 3);
}

#[test]
fn normals_that_make_no_sense_are_refused() {
    let good = curved(Shape::Triangular);
    let with = |change: &dyn Fn(&mut Mesh)| {
        let mut mesh = good.clone();
        change(&mut mesh);
        // Without the option, normals have no effect.
        cell(&mesh, &CellOptions::default()).expect("planes");
        cell(&mesh, &NORMALS).expect_err("refused").to_string()
    };
    let number = std::num::NonZeroU32::new;
    // Corner 1 of the 15th facet, among others, has the normal in the middle of the first face.
    let middle = good.corner_normals[14][1].expect("a normal").get() as usize - 1;
    type Change<'a> = &'a dyn Fn(&mut Mesh);
    let cases: [(&str, Change<'_>); 8] = [
        ("has no normals", &|mesh| mesh.corner_normals.clear()),
        ("has no normals", &|mesh| {
            mesh.corner_normals.fill([None; 3]);
        }),
        ("face 5 has normals at some", &|mesh| {
            mesh.corner_normals[4][2] = None;
        }),
        ("face 5 refers to a normal", &|mesh| {
            mesh.corner_normals[4][2] = number(4096);
        }),
        ("that is zero or not finite", &|mesh| {
            mesh.normals[middle] = DVec3::ZERO;
        }),
        ("that is zero or not finite", &|mesh| {
            mesh.normals[middle] = DVec3::NAN;
        }),
        ("that is zero or not finite", &|mesh| {
            mesh.normals[middle] = DVec3::new(f64::INFINITY, 0.0, 0.0);
        }),
        ("degrees off its front", &|mesh| {
            mesh.normals[middle] *= -1.0;
        }),
    ];
    let mut tried = 0;
    for (part, change) in cases {
        let message = with(change);
        println!("{message}");
        assert!(
            message.contains(part) && message.starts_with("mesh.obj: "),
            "{message}"
        );
        tried += 1;
    }
    assert_eq!(tried, 8);
    // A file with the same fault.
    let text = write::obj(&good);
    let last = text
        .lines()
        .rfind(|line| line.starts_with("vn"))
        .expect("normals");
    for (bad, part) in [
        ("vn 0 0".to_owned(), "zero or not finite"),
        ("vn a b c".to_owned(), "zero or not finite"),
        (String::new(), "refers to a normal"),
    ] {
        let mesh = obj::parse(text.replacen(last, &bad, 1).as_bytes()).expect("a mesh");
        let message = cell(&mesh, &NORMALS).expect_err("refused").to_string();
        assert!(message.contains(part), "{bad}: {message}");
    }
}

#[test]
fn what_is_said_of_normals() {
    let mesh = curved(Shape::TriangularPair);
    let said = |mesh: &Mesh, options: &CellOptions| cell(mesh, options).expect("a cell").warnings;
    // Normals that were not asked for.
    let warnings = said(&mesh, &CellOptions::default());
    assert!(
        warnings.len() == 1 && warnings[0].contains("give --normals file"),
        "{warnings:?}"
    );
    // A facet without normals.
    let mut partly = mesh.clone();
    partly.corner_normals[7] = [None; 3];
    let warnings = said(&partly, &NORMALS);
    assert!(
        warnings.len() == 1
            && warnings[0].contains("1 of 216 facets")
            && warnings[0].contains("face 8"),
        "{warnings:?}"
    );
    // Normals equal to those of the facets.
    let mut flat = mesh.clone();
    flat.normals.clear();
    for triangle in 0..flat.triangles.len() {
        let [a, b, c] = flat.corners(triangle);
        flat.normals.push((b - a).cross(c - a));
        flat.corner_normals[triangle] = [std::num::NonZeroU32::new(triangle as u32 + 1); 3];
    }
    let warnings = said(&flat, &NORMALS);
    assert!(
        warnings.len() == 1 && warnings[0].contains("changes nothing"),
        "{warnings:?}"
    );
    assert_eq!(said(&flat, &CellOptions::default()), [""; 0]);
    // Normals of four digits, as some programs write them, for facets that are planes.
    let mut rounded = Design {
        segments: 3,
        ..Design::new(Shape::TriangularPair)
    }
    .mesh()
    .expect("a design");
    rounded.corner_normals = flat.corner_normals[..rounded.triangles.len()].to_vec();
    for triangle in 0..rounded.triangles.len() {
        let [a, b, c] = rounded.corners(triangle);
        let own = (b - a).cross(c - a).normalize();
        rounded.normals.push((own * 1e4).round() / 1e4);
    }
    assert_eq!(said(&rounded, &CellOptions::default()), [""; 0]);
    assert!(said(&rounded, &NORMALS)[0].contains("changes nothing"));
}

/// Closed prisms have outward normals, and their front face is taken off.
#[test]
fn prisms_keep_the_normals_of_their_facets() {
    let hollow = curved(Shape::Triangular);
    let plain = cell(&hollow, &NORMALS).expect("a cell");
    let mut solid = hollow.clone();
    solid.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    solid.corner_normals.iter_mut().for_each(|t| t.swap(1, 2));
    solid.normals.iter_mut().for_each(|n| *n = -*n);
    // The front is a fan from corner 1 over the points of the rim, in the order around it.
    let plane = |v: u32| hollow.positions[v as usize].element_sum() > 3.0 - 1e-9;
    let mut rim: Vec<u32> = (1..hollow.positions.len() as u32)
        .filter(|&v| plane(v))
        .collect();
    let middle = DVec3::ONE;
    let x = (hollow.positions[1] - middle).normalize();
    let y = DVec3::ONE.normalize().cross(x);
    let angle = |v: u32| {
        let p = hollow.positions[v as usize] - middle;
        p.dot(y).atan2(p.dot(x)).rem_euclid(std::f64::consts::TAU)
    };
    rim.sort_by(|&a, &b| angle(a).total_cmp(&angle(b)));
    assert_eq!(rim.len(), 18);
    let centre = solid.positions.len() as u32;
    solid.positions.push(middle);
    for (k, &from) in rim.iter().enumerate() {
        solid
            .triangles
            .insert(0, [centre, from, rim[(k + 1) % rim.len()]]);
        solid.corner_normals.insert(0, [None; 3]);
    }
    let opened = cell(&solid, &NORMALS).expect("a prism");
    assert!(opened.closed);
    assert_eq!(opened.warnings, [""; 0]);
    assert_alike(&plain, &opened, 0.0_f64.next_up(), "prism");
}

/// Normals of few digits are said, with a bound of the angle by which they turn light: six times
/// the largest error of a normal stays below it, and comes near.
#[test]
fn normals_of_few_digits_are_said() {
    let mesh = curved(Shape::TriangularPair);
    let full = write::obj(&mesh);
    let mut cases = 0;
    for decimals in [4, 5, 6, 9] {
        let line = |line: &str| match line.strip_prefix("vn ") {
            Some(words) => {
                let numbers = words
                    .split(' ')
                    .map(|word| word.parse::<f64>().expect("a number"));
                let words: Vec<String> = numbers.map(|x| format!("{x:.decimals$}")).collect();
                format!("vn {}\n", words.join(" "))
            }
            None => format!("{line}\n"),
        };
        let text: String = full.lines().map(line).collect();
        let rounded = obj::parse(text.as_bytes()).expect("a mesh");
        let pairs = mesh.normals.iter().zip(&rounded.normals);
        let errors = pairs.map(|(n, m)| n.normalize().cross(m.normalize()).length());
        let turned_mrad = 6e3 * errors.fold(0.0, f64::max);
        let warnings = cell(&rounded, &NORMALS).expect("a cell").warnings;
        assert_eq!(
            warnings.len(),
            usize::from(decimals < 6),
            "{decimals}: {warnings:?}"
        );
        if let [one] = &warnings[..] {
            let (_, stated) = one.split_once("by up to ").expect("a bound");
            let stated: f64 = stated
                .split(' ')
                .next()
                .expect("a word")
                .parse()
                .expect("mrad");
            // The bound has two decimals.
            let near = 0.3 * stated - 0.01..stated + 0.01;
            assert!(
                near.contains(&turned_mrad),
                "{decimals}: {turned_mrad} for {stated}"
            );
        }
        cases += 1;
    }
    assert_eq!(cases, 4);
}
