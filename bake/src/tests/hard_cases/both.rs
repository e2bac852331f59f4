//! One cell baked by both methods, and the difference between them.

use crate::cli::comparison_text;
use crate::plan::{Plan, Request};
use crate::run::Comparison;
use crate::tests::bakes::asked;
use crate::tests::{bakes, cells};
use meshes::design::{Design, Shape};
use meshes::{Cell, CellOptions, Mesh};
use std::path::Path;
use tables::Table;
use tables::options::{Back, Method};

/// Number of random rays per direction of a comparison.
pub(crate) const RAYS: u64 = 200_000;

/// Tables of equal directions, one by rays and one by the exact method.
pub(crate) struct Both {
    pub rays: Table,
    pub exact: Table,
}

/// The directions and options of a bake.
#[derive(Clone)]
pub(crate) struct BothOptions {
    pub incidence: String,
    pub azimuth: String,
    pub index: f64,
    pub back: Back,
    /// Number of random rays per direction.
    pub rays: u64,
}

impl BothOptions {
    pub(crate) fn new(incidence: impl Into<String>, azimuth: &str) -> Self {
        BothOptions {
            incidence: incidence.into(),
            azimuth: azimuth.into(),
            index: 1.0,
            back: Back::Mirror,
            rays: RAYS,
        }
    }

    pub(crate) fn inside(self, index: f64) -> Self {
        BothOptions { index, ..self }
    }

    pub(crate) fn without_mirrors(self) -> Self {
        BothOptions {
            back: Back::Tir,
            ..self
        }
    }

    pub(crate) fn request(&self, method: Method) -> Request {
        Request {
            incidence: self.incidence.clone(),
            azimuth: self.azimuth.clone(),
            refractive_index: Some(self.index),
            back: self.back,
            method,
            rays: Some(self.rays),
            ..asked("--sampler random --bins 64")
        }
    }

    pub(crate) fn bake(&self, cell: &Cell, method: Method) -> Table {
        bake(cell, &self.request(method))
    }

    /// Bakes `cell` by both methods and checks that the tables agree.
    pub(crate) fn on(&self, name: &str, cell: &Cell) -> Both {
        let both = Both {
            rays: self.bake(cell, Method::Rays),
            exact: self.bake(cell, Method::Exact),
        };
        both.check(name);
        assert!(
            both.rays.rays.iter().all(|&rays| rays == self.rays),
            "{name}: each ray once"
        );
        both
    }
}

impl Both {
    /// Returns the worst difference of a fate's share, in standard errors of the rays.
    ///
    /// A share f of N rays is binomial: its standard error is sqrt(f (1 - f) / N), and at least one
    /// ray's 1/N.
    pub(crate) fn sigmas(&self) -> f64 {
        let mut worst = 0.0_f64;
        for ((i, a, fate), &exact) in self.exact.fate.indexed_iter() {
            let n = self.rays.rays[[i, a]] as f64;
            let error = ((exact * (1.0 - exact)).max(1.0 / n) / n).sqrt();
            worst = worst.max((self.rays.fate[[i, a, fate]] - exact).abs() / error);
        }
        worst
    }

    /// Checks that both tables are sound and agree.
    ///
    /// Every fate must be within 5 standard errors: by chance a fate is wrong with 5e-7, and the
    /// whole suite has a few hundred fates with any light. Every histogram must be within 1.5 times
    /// its counting noise.
    fn check(&self, name: &str) {
        sound(&self.rays, name);
        sound(&self.exact, name);
        let sigmas = self.sigmas();
        assert!(sigmas < 5.0, "{name}: a fate differs by {sigmas:.1} sigma");
        let comparison = Comparison::new(&self.rays, &self.exact).expect("the same axes");
        assert!(
            comparison.agrees(),
            "{name}:\n{}",
            comparison_text(&comparison)
        );
    }
}

/// Checks that nothing is NaN or negative, that fates sum to 1, and that histograms sum to 1, or to
/// 0 if nothing returns.
pub(crate) fn sound(table: &Table, name: &str) {
    let (method, axes) = (table.provenance.method.text(), &table.axes);
    for ((i, a), eta) in table.retroreflected.indexed_iter() {
        let place = format!(
            "{name}, {method}, {} deg, azimuth {}",
            axes.incidence_deg[i], axes.azimuth_deg[a]
        );
        let fates = || (0..table.fate.dim().2).map(|fate| table.fate[[i, a, fate]]);
        assert!(
            fates().all(|share| (-1e-12..=1.0 + 1e-12).contains(&share)),
            "{place}"
        );
        let sum: f64 = fates().sum();
        assert!((sum - 1.0).abs() < 1e-11, "{place}: fates sum to {sum}");
        assert!((0.0..=1.0 + 1e-12).contains(eta), "{place}: eta {eta}");
        let histogram = table.histogram.slice(ndarray::s![i, a, .., ..]);
        assert!(
            histogram.iter().all(|p| (0.0..=1.0).contains(p)),
            "{place}: a bin"
        );
        let sum = histogram.sum();
        assert!(
            sum == 0.0 || (sum - 1.0).abs() < 1e-9,
            "{place}: bins sum to {sum}"
        );
    }
}

pub(crate) fn bake(cell: &Cell, request: &Request) -> Table {
    let plan = Plan::new(request).expect("a valid request");
    bakes::bake(cell, &plan).expect("bakes")
}

pub(crate) fn normalised(mesh: &Mesh) -> Result<Cell, meshes::Error> {
    meshes::normalise(mesh, Path::new("mesh.obj"), &CellOptions::default())
}

pub(crate) fn cell(shape: Shape) -> Cell {
    cells::designed(&Design::new(shape))
}
