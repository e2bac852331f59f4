//! Designs that are no corner cubes, and faces of glass in files.

use std::path::Path;

use glam::DVec3;
use meshes::design::{Bead, Plate};
use meshes::{Cell, CellOptions, Fault, Mesh, gltf, normalise, obj, write};

fn cell(mesh: &Mesh, glass: bool) -> Result<Cell, meshes::Error> {
    let options = CellOptions {
        file_normals: glass,
        glass,
        ..CellOptions::default()
    };
    normalise(mesh, Path::new("element"), &options)
}

/// Twice the area, as a vector along the normal.
fn doubled([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Mirrors of both layers and sides, with upper edges that face the light; coordinates to an ulp of
/// the plate's height.
#[test]
fn a_plate_has_its_dimensions() {
    let plate = Plate {
        pitch: 0.5,
        depth: 3.0,
        thickness: 0.02,
    };
    let mesh = plate.mesh().expect("a legal design");
    let cell = cell(&mesh, false).expect("a cell");
    assert_eq!((cell.edge_length, cell.facets.len()), (0.5, 12));
    assert!((cell.entrance.height - 6.0).abs() < 1e-14);
    assert!(cell.azimuth_zero.distance(DVec3::X) < 1e-15);
    assert!(cell.warnings.is_empty(), "{:?}", cell.warnings);
    let mut by_axis = [0.0; 3];
    for facet in &cell.facets {
        let area = doubled(*facet) / 2.0;
        assert!(area.z >= 0.0, "no face looks down");
        for axis in 0..3 {
            by_axis[axis] += area[axis].abs();
        }
    }
    // Each layer has two sides of 1 x 3, and there are two upper edges of 1 x 0.02.
    let expected = [6.0, 6.0, 0.04];
    assert!(
        (0..3).all(|k| (by_axis[k] - expected[k]).abs() < 1e-13),
        "{by_axis:?}"
    );
    for (depth, thickness) in [(0.0, 0.02), (3.0, 0.0), (3.0, 0.95), (f64::NAN, 0.02)] {
        let wrong = Plate {
            depth,
            thickness,
            ..plate
        };
        assert!(matches!(wrong.mesh(), Err(Fault::DesignOption { .. })));
    }
}

/// Vertices on the sphere, facets outward and closed, glass above the equator. The inscribed
/// surface is smaller than the sphere's by about (pi / 2n)^2.
#[test]
fn a_bead_is_a_sphere() {
    let mut cases = 0;
    for segments in [1, 7, 40] {
        let bead = Bead {
            pitch: 0.06,
            diameter: 0.9,
            segments,
        };
        let mesh = bead.mesh().expect("a legal design");
        assert_eq!(mesh.triangles.len(), 8 * (segments * segments) as usize);
        let cell = cell(&mesh, true).expect("a cell");
        assert_eq!(
            cell.glass.iter().filter(|glass| **glass).count(),
            cell.facets.len() / 2
        );
        let centre = DVec3::new(0.0, 0.0, 0.45);
        let (mut area, mut sum) = (0.0, DVec3::ZERO);
        for (facet, &glass) in cell.facets.iter().zip(&cell.glass) {
            for corner in facet {
                assert!((corner.distance(centre) - 0.45).abs() < 1e-14);
                assert!(if glass {
                    corner.z > 0.45 - 1e-14
                } else {
                    corner.z < 0.45 + 1e-14
                });
            }
            assert!(doubled(*facet).dot(facet[0] - centre) > 0.0, "outward");
            area += doubled(*facet).length() / 2.0;
            sum += doubled(*facet);
        }
        assert!(sum.length() < 1e-13, "closed");
        let sphere = std::f64::consts::PI * 0.81;
        let lacks = 1.0 - area / sphere;
        let n = f64::from(segments);
        assert!(
            lacks > 0.0 && lacks < (std::f64::consts::FRAC_PI_2 / n).powi(2),
            "{lacks}"
        );
        let read = obj::parse(write::obj(&mesh).as_bytes()).expect("reads");
        assert_eq!(
            (&read.glass, &read.triangles),
            (&mesh.glass, &mesh.triangles)
        );
        cases += 1;
    }
    assert_eq!(cases, 3);
}

/// Glass by the name of the material, in either format, and only if it is asked for.
#[test]
fn glass_is_told_by_its_name() {
    let two = "usemtl glass\nf 1 2 3\nusemtl paint\nf 1 3 4\nf 1 4 2\n";
    let text = format!("v 0 0 0\nv 3 0 0\nv 0 3 0\nv 0 0 3\n{two}");
    let mesh = obj::parse(text.as_bytes()).expect("reads");
    assert_eq!(mesh.glass, [true, false, false]);
    assert!(cell(&mesh, false).expect("mirrors").glass.is_empty());
    let plain = obj::parse(text.replace("glass", "glassy").as_bytes()).expect("reads");
    assert!(plain.glass.is_empty());
    let said = cell(&plain, true).expect_err("no glass").to_string();
    assert!(said.contains("no face of the material \"glass\""), "{said}");

    // One triangle twice; the second primitive is of glass.
    let corners = "AAAAAAAAAAAAAAAAAABAQAAAAAAAAAAAAAAAAAAAQEAAAAAA";
    let json = format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}}},
        {{"attributes":{{"POSITION":0}},"material":0}}]}}],
        "materials":[{{"name":"glass"}}],
        "buffers":[{{"byteLength":36,"uri":"data:application/octet-stream;base64,{corners}"}}],
        "bufferViews":[{{"buffer":0,"byteLength":36}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"type":"VEC3","count":3,
        "min":[0,0,0],"max":[3,3,0]}}]}}"#
    );
    match gltf::parse(json.as_bytes(), None) {
        Ok(mesh) => assert_eq!(mesh.glass, [false, true]),
        Err(fault) => panic!("{fault}"),
    }
}
