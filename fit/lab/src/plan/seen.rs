//! Photographs as the camera of a plan would take them, and what each would tell.

use nalgebra::DVector;
use tables::Table;

use crate::plan::Error;
use crate::plan::information::{Candidate, Information, Unknowns};
use crate::plan::request::{Edge, Plan};
use crate::plan::rival::Blurred;
use crate::simulate::{ByIncidence, Params, PlantedEdge, PlantedSheet, PlantedShot, cell};
use crate::study::{choice, trial};
use edges::names::Kernel;
use edges::photographs::edge::fault::Accepted;
use estimator::compare::Photograph as Pixels;
use estimator::estimate::{Aerial, Conditions, Layout, Place, Scene, model};
use estimator::model::Camera;

/// Bright side of a mid-air photograph, full scale 1.
pub(crate) const BRIGHT: f64 = 0.8;

/// Direction of the edge against the axis that it lies across, degrees.
const TILT_DEG: f64 = 5.0;

/// Photographs as the camera of a plan would take them.
pub(crate) struct Seen<'a> {
    pub plan: &'a Plan,
    pub table: &'a Table,
    /// Photographs of both edges, whose pixels lie as those of all candidates.
    pub pattern: Scene,
    pub camera: Camera,
    pub layout: Layout,
    pub unknowns: Unknowns,
    /// Different incidences, degrees, ascending.
    pub angles: Vec<f64>,
    /// Points of the beliefs: logarithms of c and spread.
    pub points: Vec<Vec<f64>>,
    /// The other kernel, and at each point of the beliefs the parameters with which it resembles the
    /// believed one.
    pub rival: Option<(Layout, Vec<DVector<f64>>)>,
}

/// Place and direction of a photograph.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Setup {
    /// Floating distance, mm.
    pub floating_distance_mm: f64,
    /// Incidence, degrees.
    pub incidence_deg: f64,
    /// Azimuth, degrees.
    pub azimuth_deg: f64,
}

impl Seen<'_> {
    /// Returns the photographs of one setup, one for each edge.
    ///
    /// # Errors
    /// Fails if the table neither holds nor brackets the direction, or has no waves.
    pub(crate) fn shots(&self, setup: Setup) -> Result<Vec<Aerial>, Error> {
        let conditions = self.pattern.shots.iter().map(|shot| Conditions {
            incidence_deg: setup.incidence_deg,
            azimuth_deg: shot.direction.azimuth_deg.map(|_| setup.azimuth_deg),
            r_mm: setup.floating_distance_mm,
            ..shot.conditions()
        });
        let conditions: Vec<Conditions> = conditions.collect();
        let scene = self.pattern.perturbed(self.table, None, &conditions);
        let scene = scene.map_err(estimator::Error::from)?;
        if self.layout.choice.kernel.has_waves() {
            let file = "the plan".into();
            let fault = |fault| estimator::Error::Wave(file, fault);
            scene.waves().map_err(fault)?;
        }
        Ok(scene.shots)
    }

    /// Returns the photograph of a candidate.
    ///
    /// # Errors
    /// Returns the errors of [`Seen::shots`].
    pub(crate) fn shot(&self, own: &Candidate) -> Result<Aerial, Error> {
        let edges = &self.plan.choices.edge;
        let edge = edges.iter().position(|&edge| edge == own.edge).unwrap_or(0);
        Ok(self.shots(own.setup)?.swap_remove(edge))
    }

    /// Returns the candidates of one setup, one for each edge.
    ///
    /// # Errors
    /// Returns the errors of [`Seen::shots`].
    pub(crate) fn candidates(
        &self,
        setup: Setup,
        retroreflected: f64,
    ) -> Result<Vec<Candidate>, Error> {
        let shots = self.shots(setup)?.into_iter();
        let shots = shots.zip(&self.plan.choices.edge);
        Ok(shots
            .map(|(shot, &edge)| Candidate {
                setup,
                edge,
                retroreflected,
                tells: (0..self.points.len())
                    .map(|point| self.tells(&shot, point))
                    .collect(),
            })
            .collect())
    }

    /// Returns the parameters of the believed kernel at a point of the beliefs.
    pub(crate) fn at(&self, point: &[f64]) -> DVector<f64> {
        let layout = &self.layout;
        // The spread is believed to be the same at every incidence.
        let c = layout.c().map(|_| point[0]).into_iter();
        let spread = (0..layout.spreads).map(|_| point[point.len() - 1]);
        DVector::from_iterator(layout.parameters(), c.chain(spread))
    }

    /// Returns the place of a photograph. A plan has no blur of its own at a distance.
    pub(crate) fn place(&self, shot: &Aerial) -> Place {
        let angle = |&own: &f64| own == shot.incidence_deg;
        Place {
            group: self.angles.iter().position(angle).unwrap_or(0),
            distance: 0,
        }
    }

    /// Returns the columns of the parameters on which a photograph at a place depends, those of the
    /// lens last.
    pub(crate) fn columns(&self, place: Place) -> Vec<usize> {
        let first = self.layout.parameters();
        let lens = first..first + self.pattern.optics.free.len();
        self.layout.columns(place).into_iter().chain(lens).collect()
    }

    /// Returns what a photograph tells at a point of the beliefs.
    fn tells(&self, shot: &Aerial, point: usize) -> Information {
        let (layout, place) = (&self.layout, self.place(shot));
        let at = self.at(&self.points[point]);
        let blur = layout.blur(&at, place);
        let model = model(shot, layout.choice);
        let pixels = Pixels::new(&shot.pixels, self.camera.pitch_mm);
        let lens = &self.pattern.optics.free;
        let curves = pixels.curves(Some((&model, blur)), &self.camera, lens);
        let rows = pixels.foreseen(&curves, self.levels(), trial::noise(&self.plan.camera));
        let (columns, mu) = (self.columns(place), layout.mu_group(place.group));
        let mut told = Information::of(&rows, &columns, self.unknowns, Some(mu));
        if let Some((other, resembling)) = &self.rival {
            let right = Blurred { layout, at: &at };
            let wrong = Blurred {
                layout: other,
                at: &resembling[point],
            };
            told.rival = self.against(shot, right, wrong);
        }
        told
    }

    /// Returns what the source edge tells.
    pub(crate) fn source(&self) -> Information {
        let first = self.layout.parameters();
        let lens = &self.pattern.optics.free;
        let mut all = Information::none(self.unknowns);
        for own in self
            .pattern
            .reference
            .iter()
            .flat_map(|own| &own.photographs)
        {
            let pixels = Pixels::new(&own.pixels, self.camera.pitch_mm);
            let curves = pixels.curves(None, &self.camera, lens);
            let camera = &self.plan.camera;
            let levels = levels(camera.source_level, camera.dark_ratio, camera.veil);
            let rows = pixels.foreseen(&curves, levels, trial::noise(camera));
            let columns: Vec<usize> = (first..first + lens.len()).collect();
            all.add(&Information::of(&rows, &columns, self.unknowns, None));
        }
        all
    }

    /// Returns dark plateau and step of a mid-air photograph.
    pub(crate) fn levels(&self) -> [f64; 2] {
        let camera = &self.plan.camera;
        levels(BRIGHT, camera.dark_ratio, camera.veil)
    }
}

/// Returns dark plateau and step of an edge whose bright side adds `bright` to the veil.
fn levels(bright: f64, dark_ratio: f64, veil: f64) -> [f64; 2] {
    [bright * dark_ratio + veil, bright * (1.0 - dark_ratio)]
}

/// Returns the camera of the pattern with the lens as it is planted.
pub(crate) fn planted_camera(pattern: &Scene, plan: &Plan) -> Camera {
    let blur_mm = plan.camera.lens_blur_mm();
    let mut seen = pattern.optics.camera.clone();
    for lens in &mut seen.lenses {
        (lens.blur_mm, lens.exponent, lens.departure) = (blur_mm, 2.0, None);
    }
    seen
}

/// Measures photographs without noise of each edge and of the source: the places of their pixels
/// are those of every photograph that the camera takes. The sheet hardly blurs them, so no edge is
/// too wide for its window.
pub(crate) fn pattern(
    plan: &Plan,
    table: &Table,
    [incidence_deg, azimuth_deg]: [f64; 2],
) -> Result<Scene, Error> {
    let camera = &plan.camera;
    let eta: f64 = cell::shifts(0.0, 0.0, 1.0, true)
        .iter()
        .map(|cube| cube.retroreflected)
        .sum::<f64>()
        / 2.0;
    let half_mirror = camera.half_mirror_transmittance * camera.half_mirror_reflectance;
    let shot = |edge: &Edge| PlantedShot {
        edge: PlantedEdge {
            normal_deg: TILT_DEG + if *edge == Edge::Tangential { 0.0 } else { 90.0 },
            exposure: BRIGHT / (camera.source_level * half_mirror * eta),
            ..PlantedEdge::AERIAL
        },
        floating_distance_mm: 100.0,
        path_mm: None,
        incidence_deg: 0.0,
        azimuth_deg: 0.0,
        tangential_axis_deg: 0.0,
        shifts: None,
    };
    let sharp = Params {
        seed: 0,
        camera: camera.clone(),
        truth: PlantedSheet {
            kernel: Kernel::Eq1,
            lobe: plan.beliefs.lobe,
            spectrum: plan.beliefs.spectrum.clone(),
            refractive_index: 1.0,
            pair: true,
            a: ByIncidence::Shared(1.0 / camera.pixel_pitch_mm),
            c_mm: camera.pixel_pitch_mm,
            angular_spread_mrad: 0.0,
            mu: ByIncidence::Shared(1.0),
        },
        reference: Some(PlantedEdge::SOURCE),
        captures: plan.choices.edge.iter().map(shot).collect(),
    };
    let mut campaign = trial::campaign(&sharp, &[Accepted::Doubled]);
    for capture in &mut campaign.captures {
        capture.incidence_deg = incidence_deg;
        capture.azimuth_deg = Some(azimuth_deg);
    }
    let photographs = trial::source(&sharp, choice::without_noise);
    Ok(Scene::of(&campaign, table, &photographs)?)
}
