//! Tests of pictures seen straight and in the mirror, against the tracer of
//! [`lab::tracer`].

use nalgebra::Vector3;

use crate::images::render;
use crate::images::{SILENT, Scale, Sheet, Spot, Viewpoint};
use crate::tests::render::result;
use crate::tests::render::views::load;
use edges::photographs::photo::picture::Picture;
use edges::photographs::photo::transfer::Transfer;
use estimator::Error;
use estimator::predict::Fitted;
use estimator::result::Number;
use lab::planted::{Stream, table};
use lab::tracer::{AXIS_DEG, AZIMUTH_DEG, C_MM, INCIDENCE_DEG, Traced, World, rms, sheet, traced};

const SIZE: [usize; 2] = [52, 44];
const PITCH_MM: f64 = 0.08;
const R_MM: f64 = 200.0;

/// A picture of the letter F, which no turn and no mirror maps to itself.
fn letter() -> Picture {
    let lit = |x: usize, y: usize| {
        let stem = (20..24).contains(&x) && (14..30).contains(&y);
        let bars = (20..32).contains(&x) && (14..17).contains(&y);
        stem || bars || ((20..28).contains(&x) && (20..23).contains(&y))
    };
    let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| (x, y)));
    Picture {
        width: SIZE[0],
        height: SIZE[1],
        planes: vec![
            pixels
                .map(|(x, y)| f32::from(u8::from(lit(x, y))))
                .collect(),
        ],
        transfer: Transfer::Linear,
        warnings: Vec::new(),
    }
}

/// The picture that the rays make: each pixel gathers the squares of the source that its rays come
/// from.
fn by_rays(source: &Picture, rays: &Traced) -> Vec<f64> {
    let mut stream = Stream(9);
    let pixels = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]));
    let mut pixel = |at: [usize; 2]| {
        let lit = rays.offsets.iter().filter(|offset| {
            let mut from = |k: usize| at[k] as f64 + stream.between(-0.5, 0.5) - offset[k];
            let [x, y] = [from(0), from(1)].map(|v| v.round());
            let inside = x >= 0.0 && y >= 0.0 && x < SIZE[0] as f64 && y < SIZE[1] as f64;
            inside && source.planes[0][y as usize * SIZE[0] + x as usize] > 0.5
        });
        lit.count() as f64 / rays.offsets.len() as f64
    };
    pixels.map(&mut pixel).collect()
}

/// The view file of a camera that is so far away that all its rays are parallel.
fn view_file(seen_in_mirror: bool) -> String {
    let world = World::new(seen_in_mirror);
    let at = |v: Vector3<f64>| {
        let seen = world.mirror * v;
        format!("[{:?}, {:?}, {:?}]", seen.x, seen.y, seen.z)
    };
    let [right, down] = world
        .columns_and_rows()
        .map(|v| format!("[{:?}, {:?}, {:?}]", v.x, v.y, v.z));
    format!(
        "[camera]\nposition_mm = {}\n[image]\ncentre_mm = {}\nright = {right}\ndown = {down}\n\
         pixel_pitch_mm = {PITCH_MM}\n[sheet]\nposition_mm = [0, 0, 0]\nnormal = {}\n\
         first_edge = {}\nseen_in_mirror = {seen_in_mirror}\n",
        at(world.arriving * -1e7),
        at(world.arriving * -R_MM),
        at(Vector3::z()),
        at(Vector3::x()),
    )
}

/// A sheet whose table holds one direction, which all pixels see but for the rounding of a camera
/// 1e7 mm away.
struct OneDirection<'a>(Fitted<'a>);

impl Sheet for OneDirection<'_> {
    fn spot(&self, place: &Viewpoint, finest_per_mm: f64) -> Result<Box<dyn Spot + '_>, Error> {
        assert!(
            (place.incidence_deg - INCIDENCE_DEG).abs() < 1e-3,
            "{place:?}"
        );
        assert!(
            (place.azimuth_deg.unwrap() - AZIMUTH_DEG).abs() < 1e-3,
            "{place:?}"
        );
        let place = Viewpoint {
            incidence_deg: INCIDENCE_DEG,
            azimuth_deg: Some(AZIMUTH_DEG),
            ..*place
        };
        self.0.spot(&place, finest_per_mm)
    }
}

/// Plain renders and those of a view show the letter as the rays do. Of n rays the share on one
/// pixel errs by sqrt(1/4n) at most. With the key turned round, the picture differs by more than
/// ten times that.
#[test]
fn pictures_are_those_of_the_tracer() {
    let table = table(&sheet(), &[INCIDENCE_DEG], AZIMUTH_DEG);
    let mut fitted = result("shift", None, &table);
    fitted.c_mm = Some(Number {
        value: Some(C_MM),
        standard_error: None,
    });
    let sheet = OneDirection(Fitted::new(&fitted, &table).unwrap());
    let source = letter();
    let place = Viewpoint {
        incidence_deg: INCIDENCE_DEG,
        azimuth_deg: Some(AZIMUTH_DEG),
        r_mm: R_MM,
    };
    let plain = |seen_in_mirror| {
        let scale = Scale {
            pitch_mm: PITCH_MM,
            tangential_axis_deg: AXIS_DEG,
            seen_in_mirror,
        };
        let psf = render::uniform_psf(&sheet, &place, &scale, None, SILENT).unwrap();
        render::uniform(&source, &psf, SILENT)
    };
    let viewed = |seen_in_mirror| {
        let view = load(&view_file(seen_in_mirror)).unwrap();
        render::viewed(&source, &sheet, &view, 0.25, 0.01, SILENT)
            .unwrap()
            .0
    };
    let mut cases = 0;
    for seen_in_mirror in [false, true] {
        let rays = traced(seen_in_mirror, 300, PITCH_MM);
        let expected = by_rays(&source, &rays);
        let energy = 0.25 * 0.25 * rays.returned;
        let off = |image: Picture| {
            let image: Vec<f64> = image.planes[0]
                .iter()
                .map(|&v| f64::from(v) / energy)
                .collect();
            rms(&image, &expected)
        };
        let own = [off(plain(seen_in_mirror)), off(viewed(seen_in_mirror))];
        let other = off(plain(!seen_in_mirror));
        let error = 0.5 / (rays.offsets.len() as f64).sqrt();
        println!("{seen_in_mirror}: {own:?} of {error:.2e}, turned {other:.2e}");
        assert!(own.into_iter().all(|own| own < error), "{own:?}");
        assert!(other > 10.0 * error, "{other}");
        cases += own.len();
    }
    assert_eq!(cases, 4);
}
