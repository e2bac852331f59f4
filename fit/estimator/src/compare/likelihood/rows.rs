//! The rows of a photograph's least squares, and what is taken from them.

use std::f64::consts::FRAC_1_SQRT_2;

use nalgebra::DMatrix;

use crate::compare::light::UNIT_PX;
use crate::compare::likelihood::nuisances::{BEND_PX, FIRST_LIGHT, Nuisances, anywhere};
use crate::compare::likelihood::{Curves, FittedPhotograph, Photograph};
use crate::compare::place::Place;
use crate::compare::remainder::{Remainder, Sums};
use edges::numerics::factor;
use edges::numerics::factor::Products;

impl Photograph<'_> {
    /// Passes the weighted rows of all bins to `take`: first the row of a bin's mean, then that of
    /// its slope along the edge.
    ///
    /// The columns of a row are the derivatives by the nuisances, those by the curves' parameters,
    /// and the residual (model - data).
    pub fn rows(&self, curves: &Curves, at: &Nuisances, mut take: impl FnMut(&[f64])) {
        let step = self.step_column();
        let size = step + 1 + curves.by.len() + 1;
        let [mut mean, mut slope] = [(); 2].map(|()| vec![0.0; size]);
        let many = self.terms.are_many();
        let moments = many.then(|| curves.moments(self.pixels.reach()));
        let moment = |i: usize, place: &Place| {
            let curves = moments.as_ref();
            curves.map_or([0.0; 4], |moments| place.of(&moments[i]))
        };
        let bends = self.bends();
        let slope_across = at.light[0] / UNIT_PX;
        let of_lamp = at.lamp * slope_across;
        for (bin, weight) in self.bins.iter().zip(&self.weights) {
            let tangents = &self.tangents(bin)[..bends];
            let place = at.place(bin, tangents);
            let lights = self.lights(bin, &at.light);
            // A curve in this light: its mean, and its slope along the edge.
            let lit = |curve: [f64; 4], moment: [f64; 4]| {
                let light = lights.all;
                [
                    light.mean(curve) + of_lamp * moment[0],
                    light.slope(curve) + of_lamp * moment[1],
                ]
            };
            let (unit, bump) = (place.of(&curves.value), moment(0, &place));
            let unlit = [lights.all.value - 1.0, lights.all.by_t];
            let edge = lit(unit, bump);
            let expected = at.dark + at.lit * unlit[0] + at.step * edge[0];
            let (expected, passed, _) = self.pixels.cut.clipped(expected, weight.sigma);
            let weights = weight.root.map(|root| root * passed);
            let mut columns = mean.iter_mut().zip(&mut slope);
            let mut push = |by: [f64; 2], factor: f64| {
                if let Some((mean, slope)) = columns.next() {
                    *mean = by[0] * factor * weights[0];
                    *slope = by[1] * factor * weights[1];
                }
            };
            let by_place = lit(place.by_place(unit), place.by_place(bump));
            let by_turn = lit(place.by_turn(unit), place.by_turn(bump));
            push(by_place, at.step);
            push(by_turn, at.step);
            push([1.0, 0.0], 1.0);
            for (i, by) in lights.by.iter().enumerate().take(self.terms.light()) {
                let lamp = if i == 0 { at.lamp / UNIT_PX } else { 0.0 };
                let of_edge = [
                    by.mean(unit) + lamp * bump[0],
                    by.slope(unit) + lamp * bump[1],
                ];
                let of_dark = [by.value, by.by_t];
                let both = |k: usize| at.step * of_edge[k] + at.lit * of_dark[k];
                push([0, 1].map(both), 1.0);
            }
            for [height, slope] in tangents {
                let both = |k: usize| height * by_place[k] - slope * by_turn[k];
                push([0, 1].map(both), at.step);
            }
            if many {
                push(unlit, 1.0);
                push([bump[0], bump[1]], at.step * slope_across);
            }
            push(edge, at.step);
            for (i, curve) in (1..).zip(&curves.by) {
                push(lit(place.of(curve), moment(i, &place)), at.step);
            }
            let along = passed * (at.step * edge[1] + at.lit * unlit[1]);
            mean[size - 1] = weight.root[0] * (expected - bin.mean);
            slope[size - 1] = weight.root[1] * (along - bin.slope);
            take(&mean);
            if weight.root[1] > 0.0 {
                take(&slope);
            }
        }
        let mut row = vec![0.0; size];
        for (column, value, [middle, deviation]) in self.priors(at) {
            row[column] = 1.0 / deviation;
            row[size - 1] = (value - middle) / deviation;
            take(&row);
            row[column] = 0.0;
        }
    }

    /// Returns what is known of the orders of the curve, of the lit part of the dark plateau and of
    /// the share of the lamp, if they are estimated: their column, their value, and the mean and
    /// the standard deviation that they have before the pixels are seen.
    fn priors(&self, at: &Nuisances) -> impl Iterator<Item = (usize, f64, [f64; 2])> {
        let bends = (self.bend_column()..).zip(at.bend_px).take(self.bends());
        let bends = bends.map(|(column, value)| (column, value, [0.0, BEND_PX]));
        let step = self.step_column();
        let shares = self.terms.are_many().then(|| {
            [
                (step - 2, at.lit, self.lit_prior()),
                (step - 1, at.lamp, anywhere(1.0)),
            ]
        });
        bends.chain(shares.into_iter().flatten())
    }

    /// Returns the column of the first order of the curve.
    pub(super) fn bend_column(&self) -> usize {
        FIRST_LIGHT + self.terms.light()
    }

    /// Returns what a fitted model leaves of the photograph, in units of the noise.
    pub(crate) fn remainder(&self, curves: &Curves, fitted: &FittedPhotograph) -> Remainder {
        let mut rows = Vec::new();
        self.rows(curves, &fitted.nuisances, |row| {
            rows.push(row[row.len() - 1]);
        });
        let (mut rows, mut sums) = (rows.into_iter(), Sums::default());
        for (bin, weight) in self.bins.iter().zip(&self.weights) {
            let mean = rows.next().unwrap_or(0.0);
            let slope = (weight.root[1] > 0.0).then(|| rows.next().unwrap_or(0.0));
            // A strip tells by its mean how the light changes along the edge.
            let along = if self.terms.are_many() {
                Some(mean * bin.along.signum())
            } else {
                slope
            };
            sums.add(bin.number, mean, along);
        }
        let [across, along] = sums.finished();
        let left = fitted.factor.nrows() - fitted.columns;
        let last = fitted.factor.column(fitted.factor.ncols() - 1);
        Remainder {
            squares: last.rows(fitted.columns, left).norm_squared(),
            freedom: self.observations().saturating_sub(self.nuisances()),
            across,
            along,
        }
    }

    /// Returns the two halves of a fitted photograph, along the edge: what each would give alone,
    /// to first order. Priors count half in each.
    pub(crate) fn halves(
        &self,
        curves: &Curves,
        fitted: &FittedPhotograph,
    ) -> [FittedPhotograph; 2] {
        let mut fine = Photograph {
            bins: &self.pixels.strips,
            weights: Vec::new(),
            grid: self.grid.clone(),
            ..*self
        };
        let light = fine.light(curves);
        fine.set_weights(&light);
        let size = fine.step_column() + 1 + curves.by.len() + 1;
        let mut halves = [(); 2].map(|()| Products::new(size));
        let of_bins = fine
            .bins
            .iter()
            .zip(&fine.weights)
            .flat_map(|(bin, weight)| {
                let rows = if weight.root[1] > 0.0 { 2 } else { 1 };
                std::iter::repeat_n(usize::from(bin.along > 0.0), rows)
            });
        let mut half = of_bins.collect::<Vec<usize>>().into_iter();
        fine.rows(curves, &fitted.nuisances, |row| match half.next() {
            Some(half) => halves[half].add(row),
            None => {
                let row: Vec<f64> = row.iter().map(|v| v * FRAC_1_SQRT_2).collect();
                halves.iter_mut().for_each(|half| half.add(&row));
            }
        });
        halves.map(|half| FittedPhotograph {
            factor: factor::of(half.sum()),
            ..*fitted
        })
    }

    /// Returns the factor of a fitted photograph with the full information of pixels that were cut
    /// off. The estimate uses the mean of such pixels alone, which has a little less
    /// information.
    pub(crate) fn information(&self, curves: &Curves, at: &Nuisances) -> DMatrix<f64> {
        let size = self.step_column() + 1 + curves.by.len() + 1;
        let mut normal = Products::new(size);
        let gains: Vec<f64> = self
            .light(curves)
            .iter()
            .zip(self.bins)
            .zip(&self.weights)
            .flat_map(|((&[light, _], bin), weight)| {
                let (_, passed, left) = self.pixels.cut.clipped(light, weight.sigma);
                let used = passed * passed / left;
                let all = self.pixels.cut.information(light, weight.sigma) / weight.sigma.powi(2);
                let gain = (all / used.max(f64::MIN_POSITIVE)).sqrt();
                let rows = if bin.spread > 0.0 { 2 } else { 1 };
                std::iter::repeat_n(gain, rows)
            })
            .collect();
        let mut gain = gains.into_iter();
        self.rows(curves, at, |row| {
            let gain = gain.next().unwrap_or(1.0);
            let row: Vec<f64> = row.iter().map(|v| v * gain).collect();
            normal.add(&row);
        });
        factor::of(normal.sum())
    }
}
