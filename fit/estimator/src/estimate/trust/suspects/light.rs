//! Suspects that the brightness of the photographs tells: mistakes that change mu.

use std::collections::BTreeMap;
use std::sync::atomic::Ordering;

use rayon::prelude::*;

use crate::estimate::progress::Cancelled;
use crate::estimate::scene::perturbed::Conditions;
use crate::estimate::scene::{Aerial, Scene};
use crate::estimate::search::covariance::{Scatter, contrasts_at, scatter_of};
use crate::estimate::search::fitted::estimate;
use crate::estimate::search::layout::Layout;
use crate::estimate::search::loss::Loss;
use crate::estimate::search::optimum::{optimum, refined};
use crate::estimate::trust::goodness::Verdict;
use crate::estimate::trust::suspects::{
    Alternative, EXPLAINED, Explains, Named, Otherwise, SURE, Search, Suspect, Tally,
};
use edges::numerics::chance;

/// Probability above which the mu of several incidences agree.
const AGREE: f64 = 1e-3;

impl Search<'_> {
    /// Returns the mistakes that would explain why the photographs disagree on mu, where the blur
    /// does not tell them.
    ///
    /// Those are fitted that leave least if the blur stays as it is: mu is inversely proportional
    /// to the retroreflected share of the table.
    ///
    /// # Errors
    /// Returns [`Cancelled`] if the flag of the progress is set.
    pub(super) fn of_light(&self, tally: &Tally) -> Result<Vec<Named>, Cancelled> {
        let Some(now) = self
            .fit
            .scatter
            .as_ref()
            .filter(|_| self.goodness.is_light_off())
        else {
            return Ok(Vec::new());
        };
        let (choice, at) = (self.fit.choice, &self.fit.solution.parameters);
        let layout = |scene: &Scene| Layout::of(choice, scene);
        let contrasts = contrasts_at(self.scene, &layout(self.scene), at);
        let of = |own: &Scatter| own.squares() - own.freedom as f64;
        let told = |own: &Otherwise| {
            let scene = self.made(own).filter(Scene::is_lit)?;
            Some(of(&scatter_of(&scene, &layout(&scene), &contrasts)))
        };
        let stated = self.stated();
        tally.of.fetch_add(stated.len(), Ordering::Relaxed);
        let mut all = self.first(&stated, tally, told)?;
        let fitted = all.len();
        if !self.is_over(tally) {
            self.decoded_otherwise(&mut all);
            self.alone(&mut all);
        }
        tally.of.fetch_add(all.len() - fitted, Ordering::Relaxed);
        // The light of suspects is measured by the MTFs, which may not show what the pixels do.
        let plain = scatter_of(self.scene, &layout(self.scene), &contrasts);
        let excess = of(now).min(of(&plain));
        let left = |(order, own): (usize, &Alternative)| {
            if self.is_over(tally) {
                return Ok(None);
            }
            let named = self.at_least(&own.scene, &own.choices).and_then(|found| {
                let (choice, at) = (found.fit.choice, &found.fit.solution.parameters);
                let layout = Layout::of(choice, &own.scene);
                let contrasts = contrasts_at(&own.scene, &layout, at);
                let scatter = scatter_of(&own.scene, &layout, &contrasts);
                let left = of(&scatter) + own.cost;
                (excess - left > SURE.max(EXPLAINED * excess)).then(|| Named {
                    suspect: self.of_scatter(own.what.clone(), own.captures.clone(), &scatter),
                    left,
                    order,
                })
            });
            self.done(tally, 1)?;
            Ok(named)
        };
        let named: Vec<Option<Named>> = all
            .par_iter()
            .enumerate()
            .map(left)
            .collect::<Result<_, _>>()?;
        Ok(named.into_iter().flatten().collect())
    }

    /// Returns the mistakes without which one mu would do for all incidences, where the photographs
    /// asked for one each. A mu that falls with the incidence is no mistake. So a suspect is named
    /// only if it makes the mu of all incidences agree within their errors, and if they are apart
    /// by more than chance allows without it.
    ///
    /// Nothing is fitted: mu is inversely proportional to the retroreflected share of the table,
    /// and the rest of the fit hardly depends on it. Baselines lose light at the front too, so
    /// there are no suspects for them.
    pub(super) fn of_differing_mu(&self) -> Vec<Suspect> {
        let is_rough = self.fit.choice.kernel.is_baseline();
        let mu = self.fit.mu.as_ref();
        let Some(mu) = mu.filter(|mu| mu.len() > 1 && !is_rough) else {
            return Vec::new();
        };
        let mut all = Vec::new();
        self.exchanged(&mut all);
        // Of two incidences one number tells, which one of many mistakes may explain by chance.
        if mu.len() > 2 {
            self.turned(&mut all);
            self.of_another_sheet(&mut all);
        }
        let own: Vec<(f64, f64)> = mu
            .iter()
            .map(|mu| (mu.value.ln(), mu.standard_error / mu.value))
            .collect();
        let now = scatter_about_mean(&own);
        let mut shares = Shares::default();
        let agrees = |own: &Otherwise| {
            let is_own = std::ptr::eq(own.table, self.table);
            let mut groups = Vec::new();
            for (shot, conditions) in self.scene.shots.iter().zip(&own.conditions) {
                let other = shares
                    .of(own, is_own, conditions)
                    .filter(|&share| share > 0.0)?;
                let value = mu[shot.place.group];
                let share = shot.direction.returned.retroreflected;
                let ln = (value.value * share / other).ln();
                groups.push((ln, value.standard_error / value.value));
            }
            // Photographs of one incidence share its mu, so they count once.
            groups.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
            groups.dedup_by(|a, b| (a.0 - b.0).abs() < 1e-12);
            let squares = scatter_about_mean(&groups);
            let freedom = groups.len().saturating_sub(1);
            let chance = chance::of_squares(squares, freedom);
            let explains = now - squares > SURE && chance > AGREE;
            (groups.len() > 1 && explains).then(|| Suspect {
                what: own.what.clone(),
                captures: own.captures.clone(),
                chi2_if_so: squares,
                degrees_of_freedom_if_so: freedom,
                verdict_if_so: Some(Verdict::Good),
                explains: Explains::DifferingMu,
            })
        };
        let mut found: Vec<Suspect> = all.iter().filter_map(agrees).collect();
        found.sort_by(|a, b| a.chi2_if_so.total_cmp(&b.chi2_if_so));
        found
    }

    /// Names the exposure that explains why the photographs disagree on mu. Of two photographs
    /// alone it cannot tell which.
    ///
    /// It is one exposure only if the others agree. Other causes, such as a tone curve or a blur
    /// that the model lacks, move the light of all photographs. A blur that does not fit moves it by
    /// more than the noise, which is then raised as the errors of the blur are.
    pub(super) fn exposure(&self) -> Option<Named> {
        let scatter = self.fit.scatter.as_ref();
        let scatter = scatter.filter(|_| self.goodness.is_light_off())?;
        let all = scatter.squares();
        let i = self.unlike()?;
        let shots = &self.scene.shots;
        let own = self.fit.choice.per_angle_mu;
        let beside = |shot: &&Aerial| !own || shot.place.group == shots[i].place.group;
        let beside: Vec<String> = shots
            .iter()
            .filter(beside)
            .map(|s| s.image.clone())
            .collect();
        let others = self.scene.without(i);
        let near = optimum(&others, self.fit.choice);
        let loss = Loss::new(self.kind, &others, (near.choice, &near.solution.parameters));
        let without = estimate(&others, &loss, refined(&others, &loss, near)).scatter?;
        let misfit = self.goodness.scale.powi(2);
        let left = without.squares() / misfit;
        let excess = all / misfit - scatter.freedom as f64;
        let others_agree = chance::of_squares(left, without.freedom) > AGREE;
        // Where the blur does not fit, two photographs that agree may do so by chance.
        let can_tell = misfit <= 1.0 || without.freedom > 1;
        if all / misfit - left <= SURE.max(EXPLAINED * excess) || !others_agree || !can_tell {
            return None;
        }
        let image = shots[i].image.clone();
        let side = if scatter.each[i] > 0.0 {
            "small"
        } else {
            "large"
        };
        let (what, captures) = if let [a, b] = &beside[..] {
            (
                format!("the exposure of {a} or that of {b} is wrong"),
                beside,
            )
        } else {
            let what =
                format!("the exposure of {image} is stated too {side}, or its light changed");
            (what, vec![image])
        };
        Some(Named {
            left: left - without.freedom as f64,
            order: 0,
            suspect: self.of_scatter(what, captures, &without),
        })
    }

    /// Makes a suspect of the light. `scatter` is what it leaves.
    fn of_scatter(&self, what: String, captures: Vec<String>, scatter: &Scatter) -> Suspect {
        let (squares, freedom) = (scatter.squares(), scatter.freedom);
        let verdict = if self.goodness.scale > 1.0 {
            // No suspect of the light mends the blur.
            self.goodness.verdict
        } else if chance::of_squares(squares, freedom) > AGREE {
            Verdict::Good
        } else {
            Verdict::Strained
        };
        Suspect {
            what,
            captures,
            chi2_if_so: squares,
            degrees_of_freedom_if_so: freedom,
            verdict_if_so: Some(verdict),
            explains: Explains::Misfit,
        }
    }
}

/// Retroreflected shares of the table, each looked up once: by incidence and azimuth.
#[derive(Default)]
struct Shares(BTreeMap<[u64; 2], Option<f64>>);

impl Shares {
    /// Returns the share for a photograph, or `None` if the table lacks its direction. `is_own`
    /// says whether the table is that of the estimate.
    fn of(&mut self, own: &Otherwise, is_own: bool, conditions: &Conditions) -> Option<f64> {
        let deg = conditions.incidence_deg;
        let held_deg = own.index.map_or(deg, |index| index.held_at_deg(deg));
        let look_up = || {
            let found = own.table.direction(held_deg, conditions.azimuth_deg);
            found.ok().map(|direction| direction.retroreflected)
        };
        if !is_own {
            return look_up();
        }
        let azimuth = conditions.azimuth_deg.map_or(u64::MAX, f64::to_bits);
        *self
            .0
            .entry([held_deg.to_bits(), azimuth])
            .or_insert_with(look_up)
    }
}

/// Returns the sum of squares of numbers about their weighted mean, each in units of its error.
fn scatter_about_mean(numbers: &[(f64, f64)]) -> f64 {
    let weight = |error: f64| error.max(1e-9).powi(-2);
    let sum: f64 = numbers.iter().map(|&(_, error)| weight(error)).sum();
    let mean = numbers
        .iter()
        .map(|&(v, error)| v * weight(error))
        .sum::<f64>()
        / sum;
    let squares = numbers
        .iter()
        .map(|&(v, error)| (v - mean).powi(2) * weight(error));
    squares.sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks the weighted mean by hand: 1 and 2 with errors of 0.1 and 0.2 have the weights 100
    /// and 25 and the mean 1.2, from which they lie 2 and 4 errors away. Ten roundings stay below
    /// 1e-13.
    #[test]
    fn numbers_scatter_about_their_weighted_mean() {
        let found = scatter_about_mean(&[(1.0, 0.1), (2.0, 0.2)]);
        assert!((found - 20.0).abs() < 1e-13, "{found}");
    }
}
