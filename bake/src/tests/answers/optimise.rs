//! The search for the best cell: against closed forms of edge length and cant, against a grid of all
//! cells, and the same with any number of threads.

use crate::optimise::{Answer, Candidate, Goal, Merit, evolve, optimise};
use crate::run::Progress;
use std::f64::consts::TAU;
use std::io::Write;

/// Reads a goal: its text, and a table [sheet] with this one.
fn goal(head: &str, view: [&str; 3], sheet: &str) -> Goal {
    let mut file = tempfile::NamedTempFile::new().expect("a file");
    let [distance, incidence, azimuth] = view;
    writeln!(
        file,
        "{head}\n[[view]]\ndistance_mm = {distance}\nincidence_deg = {incidence}\n\
         azimuth_deg = {azimuth}\n[sheet]\n{sheet}\nwavelength_nm = 550"
    )
    .expect("a file");
    Goal::load(file.path()).unwrap_or_else(|error| panic!("{error}"))
}

fn found(goal: &Goal) -> Answer {
    optimise(goal, Progress::none()).unwrap_or_else(|error| panic!("{error}"))
}

/// Returns the mean of the tangential and the sagittal OTF of ideal mirrors at normal incidence,
/// azimuth 0, for p = 2 pi nu c a and b = 2 pi lambda R nu^2.
///
/// The effective aperture is a hexagon of side a = sqrt(2)/3 edge lengths. A chord of length L along
/// the edge normal contributes sin(2 pi nu (c L - lambda R nu)) / (2 pi nu) to the integral of the
/// kernel. From corner to corner (sagittal) chords are evenly spread from a to 2 a. Across
/// (tangential), half of the width has chords of sqrt(3) a, and the rest is spread from there to 0.
fn closed(p: f64, b: f64) -> f64 {
    let sagittal = 2.0 / (3.0 * p * p) * ((p - b).cos() - (2.0 * p - b).cos());
    let q = 3_f64.sqrt() * p;
    let tangential = 2.0 / (3.0 * q) * ((q - b).sin() + (1.0 - (q - b).cos()) / q);
    0.5 * (sagittal + tangential)
}

/// Returns p of the best edge length by golden sections about the first maximum.
fn best_p(b: f64) -> f64 {
    let [mut low, mut high] = [b, 1.6];
    let golden = 0.5 * (5_f64.sqrt() - 1.0);
    while high - low > 1e-9 {
        let [left, right] = [high - golden * (high - low), low + golden * (high - low)];
        match closed(left, b) > closed(right, b) {
            true => high = right,
            false => low = left,
        }
    }
    0.5 * (low + high)
}

/// The best edge length at normal incidence is that of the closed form, for four pairs of distance
/// and frequency, and what 1 % of it costs is too. For low frequencies it is
/// c = (6 k b/5)^(1/3) / (2 pi nu a) with k = 1/3 + 2/(3 sqrt 3): the OTF is 1 - k b/p - 5 p^2/12 up
/// to terms that are p^2 times smaller.
///
/// The search ends with all cells within 1e-6 of the range of 1.95 mm. Golden sections end at 1e-8
/// of p, where rounding hides the rest of the maximum.
#[test]
fn the_best_edge_length_is_that_of_the_closed_form() {
    let side = 2_f64.sqrt() / 3.0;
    let mut cases = 0;
    for (distance, frequency) in [(300.0, 1.0), (300.0, 0.05), (1000.0, 0.3), (150.0, 1.0)] {
        let head = format!("best = \"mtf\"\nleast_mtf = 0\nfrequency_per_mm = [{frequency}]");
        let sheet = "design = [\"triangular-pair\"]\nedge_length_mm = { from = 0.05, to = 2 }\n\
                     refractive_index = 1.49\nsurface = \"mirrors\"";
        let answer = found(&goal(
            &head,
            [&format!("[{distance}]"), "[0]", "[0]"],
            sheet,
        ));
        let b = TAU * 5.5e-4 * distance * frequency * frequency;
        let p = best_p(b);
        let best = p / (TAU * frequency * side);
        // No chord is shorter than the lag.
        assert!(p > b && p < 1.59);
        let own = &answer.front[answer.best];
        let [c, ..] = own.cell.values;
        assert!(
            (c - best).abs() < 4e-6,
            "{distance}, {frequency}: {c} {best}"
        );
        assert!((own.quality.mtf - closed(p, b)).abs() < 1e-9);
        assert!((own.quality.luminance - 2.0 / 3.0).abs() < 1e-12);
        let low = (1.2 * (1.0 / 3.0 + 2.0 / (3.0 * 3_f64.sqrt())) * b).cbrt();
        assert!((p / low - 1.0).abs() < p * p, "{p} {low}");
        let loss = &answer.losses[0];
        let worse = closed(0.99 * p, b).min(closed(1.01 * p, b)) - closed(p, b);
        assert!((loss.mtf - worse).abs() < 1e-8, "{} {worse}", loss.mtf);
        assert!(answer.tried < 5000, "{} cells", answer.tried);
        cases += 1;
    }
    assert_eq!(cases, 4);
}

/// The cant that is best at 40 degrees, azimuth 0, index 1.49: 7.9 degrees with eta 0.3870, by the
/// closed form of the area of cube corners. No cell of a grid in steps of 0.01 degrees is brighter,
/// and rays agree.
#[test]
fn the_best_cant_is_that_of_the_closed_form() {
    let sheet = "design = [\"canted\"]\nedge_length_mm = 0.2\ncant_deg = { from = -10, to = 20 }\n\
                 refractive_index = 1.49\nsurface = \"mirrors\"";
    let head = "best = \"luminance\"\nleast_mtf = 0\nfrequency_per_mm = [1]";
    let goal = goal(head, ["[300]", "[40]", "[0]"], sheet);
    let answer = found(&goal);
    let own = &answer.front[answer.best];
    assert!((own.cell.values[1] - 7.9).abs() < 0.05, "{:?}", own.cell);
    assert!(
        (own.quality.luminance - 0.38701).abs() < 1e-5,
        "{:?}",
        own.quality
    );
    for step in -100..=100 {
        let mut other = own.cell;
        other.values[1] += 0.01 * f64::from(step);
        let quality = other.quality(&goal).expect("a cell");
        assert!(quality.luminance <= own.quality.luminance + 1e-12, "{step}");
    }
    let [check] = &answer.checks[..] else {
        panic!("{:?}", answer.checks);
    };
    assert!(check.agrees && check.standard_error > 0.0);
    assert!((check.eta - own.quality.luminance).abs() < 1e-12);
    assert!((check.by_rays - check.eta).abs() < 8.0 * check.standard_error);
}

/// On the front nothing dominates anything, every cell keeps the frequency visible, and no cell of a
/// grid of both parameters is better than all of the front by more than the distance of its
/// neighbours, a 39th of its extent. Any number of threads finds the same.
#[test]
fn the_front_holds_the_best_cells_of_a_grid() {
    let sheet = "design = [\"canted\", \"triangular-pair\"]\ncant_deg = { from = -5, to = 12 }\n\
                 edge_length_mm = { from = 0.05, to = 0.8 }\nrefractive_index = 1.49\n\
                 surface = \"mirrors\"";
    let head = "best = \"both\"\nfrequency_per_mm = [0.5, 1]\nleast_mtf = 0.02\ncells = 6000";
    let goal = goal(head, ["[300]", "[0, 30]", "[0]"], sheet);
    let within = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.expect("threads").install(|| found(&goal))
    };
    let answer = within(1);
    assert!(within(3) == answer, "threads change the answer");
    let front: Vec<[f64; 2]> = answer
        .front
        .iter()
        .map(|own| [own.quality.luminance, own.quality.mtf])
        .collect();
    assert!(front.len() > 10, "{} cells", front.len());
    assert!(
        front
            .windows(2)
            .all(|pair| pair[0][0] > pair[1][0] && pair[0][1] < pair[1][1])
    );
    assert!(answer.front.iter().all(|own| own.quality.least >= 0.02));
    // A pair is a cell without cant, so each cell of its front is one of the wider search.
    let [canted, pair] = &answer.fates[..] else {
        panic!("two designs: {:?}", answer.fates);
    };
    assert_eq!(canted.on_front + pair.on_front, front.len());
    let of_both = [canted, pair].map(|own| own.best.as_ref().expect("a cell"));
    let merit = |own: [f64; 2]| [own[1], own[0]];
    for (k, end) in [(0, front.len() - 1), (1, 0)] {
        let best = of_both[0][k].max(of_both[1][k]);
        assert_eq!(best, merit(front[end])[k], "an end of the front");
    }
    let last = front.len() - 1;
    let room = [0, 1].map(|k| (front[0][k] - front[last][k]).abs() / 39.0);
    let mut cells = 0;
    for i in 0..=30 {
        for j in 0..=30 {
            let shares = [f64::from(i) / 30.0, f64::from(j) / 30.0];
            let cell = Candidate::at(goal.shapes[0], &goal.ranges, &shares);
            let own = cell.quality(&goal).expect("a cell");
            let beats = |other: &[f64; 2]| {
                own.luminance > other[0] + room[0] && own.mtf > other[1] + room[1]
            };
            assert!(
                own.least < 0.02 || !front.iter().any(beats),
                "{cell:?} {own:?}"
            );
            cells += 1;
        }
    }
    assert_eq!(cells, 31 * 31);
    // The front varies by far more than a hundredth in both, until its ends are brought together.
    assert_eq!(answer.advice(), None);
    for (k, said) in [(0, "take the brightest"), (1, "take the sharpest")] {
        let mut flat = answer.clone();
        for (place, own) in flat.front.iter_mut().enumerate() {
            let near = 1.0 + 0.004 * place as f64 / last as f64;
            match k {
                0 => own.quality.mtf = 0.3 * near,
                _ => own.quality.luminance = 0.3 * near,
            }
        }
        let advice = flat.advice().expect("one quantity hardly varies");
        assert!(
            advice.contains("varies by 0.4 %") && advice.contains(said),
            "{advice}"
        );
    }
}

/// Functions with known optima: Rosenbrock's valley, which bends, to 1e-6 of its range; a cone whose
/// top lies outside, so that a condition decides; and a front of two parabolas, which is the line
/// between their tops. Budgets are kept.
#[test]
fn the_search_finds_known_optima() {
    let counted = |dimensions: usize, budget: u64, merit: &(dyn Fn(&[f64]) -> Merit + Sync)| {
        let called = std::sync::atomic::AtomicU64::new(0);
        let order = std::sync::atomic::Ordering::Relaxed;
        let merit = |shares: &[f64]| {
            called.fetch_add(1, order);
            merit(shares)
        };
        let found = evolve(dimensions, budget, 1, &merit, &|_| ());
        assert!(called.load(order) <= budget, "{} calls", called.load(order));
        found
    };
    let free = |values: Vec<f64>| Merit { values, lack: 0.0 };
    let valley = |at: &[f64]| {
        let [x, y] = [4.0 * at[0] - 2.0, 4.0 * at[1] - 2.0];
        free(vec![-(1.0 - x).powi(2) - 100.0 * (y - x * x).powi(2)])
    };
    let [(best, _)] = &counted(2, 10_000, &valley)[..] else {
        panic!("one optimum");
    };
    assert!(
        best.iter().all(|share| (share - 0.75).abs() < 1e-5),
        "{best:?}"
    );
    let cone = |at: &[f64]| Merit {
        values: vec![-(at[0] - 0.8).hypot(at[1] - 0.5)],
        lack: (at[0] - 0.4).max(0.0),
    };
    let [(best, _)] = &counted(2, 10_000, &cone)[..] else {
        panic!("one optimum");
    };
    assert!((best[0] - 0.4).hypot(best[1] - 0.5) < 1e-5, "{best:?}");
    let tops = |at: &[f64]| {
        let to = |x: f64| -(at[0] - x).powi(2) - (at[1] - 0.5).powi(2) - (at[2] - 0.5).powi(2);
        free(vec![to(0.2), to(0.7)])
    };
    let front = counted(3, 10_000, &tops);
    assert!(front.len() >= 35, "{} cells", front.len());
    // A cell that is off the line by d loses d^2 of both. Its neighbour on the line, 0.5/39 on,
    // dominates it if that is more than 0.5 x 0.5/39, so from d = 0.08 on.
    for (at, _) in &front {
        assert!(
            (at[1] - 0.5).hypot(at[2] - 0.5) < 0.08 && (0.19..0.71).contains(&at[0]),
            "{at:?}"
        );
    }
    let mut along: Vec<f64> = front.iter().map(|(at, _)| at[0]).collect();
    along.sort_by(f64::total_cmp);
    // Even spacing is 0.5/39.
    assert!(
        along
            .windows(2)
            .all(|pair| pair[1] - pair[0] < 4.0 * 0.5 / 39.0),
        "{along:?}"
    );
    assert!(along[0] < 0.22 && along[along.len() - 1] > 0.68);
}
