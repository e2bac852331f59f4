//! Tests of coloured photographs: each channel is fitted as a photograph of its own light.

use crate::planted::{camera, params, table, truth};
use edges::names::Kernel;
use edges::names::LobeShape;
use edges::photographs::manifest::captures;
use edges::photographs::photo;
use edges::photographs::photo::channel::{Channel, Decode};
use estimator::estimate::Scene;

/// Red, green and blue come from three sheets with different a and mu. The scene of every channel
/// equals the scene of its own sheet, to the last bit.
#[test]
fn every_channel_is_measured_as_its_own_photograph() {
    let incidence = [10.0];
    let sheets = [(4.0, 0.5), (3.0, 0.6), (5.0, 0.4)];
    let folders = sheets.map(|(a, mu)| {
        let folder = tempfile::tempdir().unwrap();
        let truth = truth(Kernel::Eq1, LobeShape::Radial, a, 0.2, mu);
        let params = params(3, truth, &incidence, &[200.0, 300.0], camera(20_000.0));
        crate::simulate::run(&params, folder.path(), true).unwrap();
        folder
    });
    let mixed = tempfile::tempdir().unwrap();
    let manifest = std::fs::read_to_string(folders[0].path().join("captures.toml")).unwrap();
    std::fs::write(mixed.path().join("captures.toml"), manifest).unwrap();
    let campaign = captures::load(&folders[0].path().join("captures.toml")).unwrap();
    let shots = campaign.captures.iter().map(|capture| &capture.shot);
    for shot in campaign.references.iter().chain(shots) {
        let name = shot.image.file_name().unwrap();
        let planes = folders
            .each_ref()
            .map(|folder| photo::load(&folder.path().join(name), &Decode::default()).unwrap());
        let (width, height) = (planes[0].width, planes[0].height);
        exr::prelude::write_rgb_file(mixed.path().join(name), width, height, |x, y| {
            let [red, green, blue] = planes.each_ref().map(|plane| plane.at(x, y).unwrap());
            (red, green, blue)
        })
        .unwrap();
    }
    let coloured = captures::load(&mixed.path().join("captures.toml")).unwrap();
    let mut cases = 0;
    for (channel, (folder, (a, mu))) in Channel::PRIMARIES.iter().zip(folders.iter().zip(sheets)) {
        let table = table(
            &truth(Kernel::Eq1, LobeShape::Radial, a, 0.2, mu),
            &incidence,
            20.0,
        );
        let alone = captures::load(&folder.path().join("captures.toml")).unwrap();
        let alone = Scene::load(&alone, &table).unwrap();
        let mixed = Scene::load(&coloured.in_channel(channel), &table).unwrap();
        for (a, b) in alone.shots.iter().zip(&mixed.shots) {
            assert_eq!(
                a.view.mtf.modulus, b.view.mtf.modulus,
                "{channel} of {}",
                a.image
            );
            cases += 1;
        }
    }
    assert_eq!(cases, 6);
}
