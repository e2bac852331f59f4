//! Nodes along one axis of the grid, and the weights by which a place between them mixes them.

use serde::Serialize;

/// Most nodes that a place mixes along one axis, if no other number is asked for.
pub(crate) const POINTS: usize = 4;

/// Continuation of the nodes of an axis beyond its ends.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Ends {
    /// Nothing is known beyond the ends.
    Open,
    /// The node after the last one is the first one.
    Turn,
    /// Both ends are mirrors: beyond an end the nodes come back, seen in a mirror.
    Mirrors,
}

/// Evenly spaced nodes along one axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Nodes {
    /// Place of the first node.
    pub first: f64,
    /// Distance between neighbours; 1 if there is one node.
    pub step: f64,
    /// Count of nodes.
    pub count: usize,
    /// Continuation beyond the ends.
    pub ends: Ends,
    /// Most nodes that a place mixes.
    pub points: usize,
}

/// Share of one node in a mixture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Share {
    /// Number of the node.
    pub node: usize,
    /// True if the node is seen in a mirror.
    pub mirrored: bool,
    /// Weight of the node; all weights of a place sum to 1.
    pub weight: f64,
}

impl Share {
    /// The only node of an axis.
    pub(crate) const ALL: Share = Share {
        node: 0,
        mirrored: false,
        weight: 1.0,
    };
}

impl Nodes {
    /// Returns a single node.
    pub(crate) fn one(at: f64) -> Nodes {
        Nodes {
            first: at,
            step: 1.0,
            count: 1,
            ends: Ends::Open,
            points: POINTS,
        }
    }

    /// Returns nodes from `low` to `high`, both included, in at least `steps` steps. Where `high`
    /// is `low`, it is one node.
    pub(crate) fn between([low, high]: [f64; 2], steps: usize, ends: Ends) -> Nodes {
        if high <= low {
            return Nodes::one(low);
        }
        let steps = steps.max(1);
        Nodes {
            first: low,
            step: (high - low) / steps as f64,
            count: if ends == Ends::Turn { steps } else { steps + 1 },
            ends,
            points: POINTS,
        }
    }

    /// Returns the same nodes, of which a place mixes at most `points`.
    pub(crate) fn mixing(self, points: usize) -> Nodes {
        Nodes { points, ..self }
    }

    /// Returns the place of a node.
    pub(crate) fn place(&self, node: usize) -> f64 {
        self.first + self.step * node as f64
    }

    /// Returns the width of the axis: to its last node, or to the node that is the first again.
    pub(crate) fn width(&self) -> f64 {
        self.step * self.middles().count() as f64
    }

    /// Returns the places in the middle between neighbours.
    pub(crate) fn middles(&self) -> impl Iterator<Item = f64> + use<> {
        let nodes = *self;
        let gaps = if self.ends == Ends::Turn {
            self.count
        } else {
            self.count - 1
        };
        (0..gaps).map(move |k| nodes.first + nodes.step * (k as f64 + 0.5))
    }

    /// Returns the mixture at a place: Lagrange's polynomial through the nearest nodes.
    pub(crate) fn mixture(&self, place: f64) -> Vec<Share> {
        let points = match self.ends {
            Ends::Open => self.points.min(self.count),
            Ends::Turn | Ends::Mirrors => self.points,
        };
        let x = (place - self.first) / self.step;
        let mut start = x.floor() as i64 - (points as i64 - 1) / 2;
        if self.ends == Ends::Open {
            start = start.clamp(0, (self.count - points) as i64);
        }
        let t = x - start as f64;
        (0..points)
            .map(|own| {
                let others = (0..points).filter(|&other| other != own);
                let weight = others
                    .map(|other| (t - other as f64) / (own as f64 - other as f64))
                    .product();
                let (node, mirrored) = self.folded(start + own as i64);
                Share {
                    node,
                    mirrored,
                    weight,
                }
            })
            .collect()
    }

    /// Returns the place from the first node to the last that stands for any place of a turn, and
    /// whether it is mirrored. An open axis is not continued.
    pub(crate) fn fold(&self, place: f64) -> (f64, bool) {
        let width = self.width();
        match self.ends {
            Ends::Open => (place, false),
            Ends::Turn => (self.first + (place - self.first).rem_euclid(width), false),
            Ends::Mirrors => {
                let within = (place - self.first).rem_euclid(2.0 * width);
                match within <= width {
                    true => (self.first + within, false),
                    false => (self.first + 2.0 * width - within, true),
                }
            }
        }
    }

    /// Returns the node that stands for a number beyond the ends, and whether it is mirrored.
    fn folded(&self, number: i64) -> (usize, bool) {
        let count = self.count as i64;
        match self.ends {
            Ends::Open => (number as usize, false),
            Ends::Turn => (number.rem_euclid(count) as usize, false),
            Ends::Mirrors => {
                let period = 2 * (count - 1).max(1);
                let within = number.rem_euclid(period);
                match within < count {
                    true => (within as usize, false),
                    false => ((period - within) as usize, true),
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cubic is mixed exactly, at the ends of an open axis too. The products of three numbers
    /// below 20 round by less than 1e-11.
    #[test]
    fn a_mixture_of_four_nodes_is_exact_for_cubics() {
        let nodes = Nodes::between([2.0, 12.0], 5, Ends::Open);
        let cubic = |x: f64| 0.5 * x.powi(3) - 3.0 * x * x + x - 7.0;
        for k in 0..=100 {
            let x = 2.0 + 0.1 * f64::from(k);
            let mixed: f64 = nodes
                .mixture(x)
                .iter()
                .map(|share| share.weight * cubic(nodes.place(share.node)))
                .sum();
            assert!((mixed - cubic(x)).abs() < 1e-11, "{x}: {mixed}");
        }
        assert_eq!(Nodes::one(3.0).mixture(3.0).len(), 1);
    }

    /// Six nodes are exact for the fifth power, by the same rounding: the numbers are below 1.
    #[test]
    fn a_mixture_of_six_nodes_is_exact_for_fifth_powers() {
        let nodes = Nodes::between([0.0, 1.0], 7, Ends::Open).mixing(6);
        for k in 0..=100 {
            let x = 0.01 * f64::from(k);
            let shares = nodes.mixture(x);
            assert_eq!(shares.len(), 6);
            let mixed: f64 = (shares.iter())
                .map(|share| share.weight * nodes.place(share.node).powi(5))
                .sum();
            assert!((mixed - x.powi(5)).abs() < 1e-11, "{x}: {mixed}");
        }
    }

    /// An even function with mirrors has the same value at the place that stands for another. An
    /// odd one changes its sign if that place is mirrored. Angles of 600 degrees round by 1e-12.
    #[test]
    fn places_beyond_the_ends_are_folded_back() {
        let mirrors = Nodes::between([10.0, 40.0], 12, Ends::Mirrors);
        let turn = Nodes::between([10.0, 70.0], 12, Ends::Turn);
        let angle = |x: f64| (6.0 * (x - 10.0)).to_radians();
        let mut cases = 0;
        for k in -200..400 {
            let x = f64::from(k) * 0.7;
            for (nodes, end) in [(mirrors, 40.0), (turn, 70.0)] {
                let (own, mirrored) = nodes.fold(x);
                assert!((10.0..=end).contains(&own), "{x}: {own}");
                assert!(!mirrored || nodes.ends == Ends::Mirrors);
                let sign = if mirrored { -1.0 } else { 1.0 };
                assert!((angle(own).cos() - angle(x).cos()).abs() < 1e-11);
                assert!((sign * angle(own).sin() - angle(x).sin()).abs() < 1e-11);
                cases += 1;
            }
        }
        assert_eq!(cases, 1200);
        let open = Nodes::between([10.0, 40.0], 12, Ends::Open);
        assert_eq!(open.fold(55.0), (55.0, false));
    }

    /// Nodes of an even function of the azimuth, with mirrors at 10 and 40: cos(6 (x - 10)) has
    /// them. Odd functions change their sign in the mirror.
    #[test]
    fn mirrors_and_turns_go_on_beyond_the_ends() {
        let nodes = Nodes::between([10.0, 40.0], 12, Ends::Mirrors);
        let angle = |x: f64| (6.0 * (x - 10.0)).to_radians();
        let mut cases = 0;
        for k in -200..400 {
            let x = f64::from(k) * 0.7;
            let [even, odd] = nodes
                .mixture(x)
                .iter()
                .fold([0.0; 2], |[even, odd], share| {
                    let own = angle(nodes.place(share.node));
                    let sign = if share.mirrored { -1.0 } else { 1.0 };
                    [
                        even + share.weight * own.cos(),
                        odd + share.weight * sign * own.sin(),
                    ]
                });
            // The error of four points is 9/16 step^4 / 24, with steps of 15 degrees = 0.262.
            let most = 9.0 / 16.0 * 0.262_f64.powi(4) / 24.0;
            assert!((even - angle(x).cos()).abs() < most, "{x}: {even}");
            assert!((odd - angle(x).sin()).abs() < most, "{x}: {odd}");
            cases += 1;
        }
        assert_eq!(cases, 600);
        let turn = Nodes::between([0.0, 120.0], 24, Ends::Turn);
        assert_eq!((turn.count, turn.step), (24, 5.0));
        assert_eq!(turn.mixture(119.0)[2].node, 0);
    }
}
