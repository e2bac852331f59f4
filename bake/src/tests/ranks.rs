//! A bake that is shared by ranks equals the bake of one process, byte for byte. Here threads act
//! as processes; `mpi.rs` starts real processes.

use crate::error::Error;
use crate::tests::bakes::asked;
use crate::tests::cells;

use crate::plan::{Plan, Request};
use crate::run::{Alone, Bake, Progress, Ranks, Saves};
use crate::tests::bakes;
use crate::tests::bakes::rays;
use meshes::Cell;
use std::sync::{Barrier, Mutex};
use std::time::Duration;
use tables::Table;
use tables::options::Sampler;

/// State that the ranks share: the numbers under way, and the sum that each rank has given so far.
struct Team {
    meeting: Barrier,
    numbers: Mutex<Vec<u64>>,
    given: Vec<Mutex<u64>>,
}

struct Member<'a> {
    number: usize,
    team: &'a Team,
}

impl Ranks for Member<'_> {
    fn number(&self) -> usize {
        self.number
    }

    fn count(&self) -> usize {
        self.team.given.len()
    }

    fn gather(&self, numbers: &mut [u64]) {
        *self.team.given[self.number].lock().unwrap() += numbers.iter().sum::<u64>();
        if self.leads() {
            *self.team.numbers.lock().unwrap() = vec![0; numbers.len()];
        }
        self.team.meeting.wait();
        let mut sums = self.team.numbers.lock().unwrap();
        assert_eq!(sums.len(), numbers.len(), "ranks gather the same");
        sums.iter_mut()
            .zip(&*numbers)
            .for_each(|(sum, n)| *sum += n);
        drop(sums);
        self.team.meeting.wait();
        if self.leads() {
            numbers.copy_from_slice(&self.team.numbers.lock().unwrap());
        } else {
            numbers.fill(0);
        }
        self.team.meeting.wait();
    }

    fn follow(&self, numbers: &mut [u64]) {
        if self.leads() {
            *self.team.numbers.lock().unwrap() = numbers.to_vec();
        }
        self.team.meeting.wait();
        numbers.copy_from_slice(&self.team.numbers.lock().unwrap());
        self.team.meeting.wait();
    }

    fn abort(&self, code: u8) {
        panic!("rank {} ends all with {code}", self.number)
    }
}

fn bake_from(
    cell: &Cell,
    plan: &Plan,
    saves: Option<Saves<'_>>,
    ranks: &dyn Ranks,
) -> Result<Option<Table>, Error> {
    let prepared = bakes::prepared(cell);
    let progress = Progress::none();
    let baked = Bake::new(&prepared, plan, progress)?.run(progress, saves, ranks)?;
    Ok(baked.map(|baked| baked.table))
}

/// Makes a plan with one thread a rank.
fn plan(request: &Request) -> Plan {
    Plan::new(&Request {
        bins: 32,
        threads: Some(1),
        ..request.clone()
    })
    .expect("a valid request")
}

/// Returns the table that `count` ranks bake, going on from the saved table `start`, and the first
/// table that was saved on the way.
fn shared(count: usize, cell: &Cell, plan: &Plan, start: Option<Table>) -> (Table, Option<Table>) {
    let team = Team {
        meeting: Barrier::new(count),
        numbers: Mutex::default(),
        given: (0..count).map(|_| Mutex::default()).collect(),
    };
    let (first, start) = (Mutex::new(None), Mutex::new(start));
    let bake = |number| {
        let mut save = |table: &Table| {
            first.lock().unwrap().get_or_insert_with(|| table.clone());
        };
        // Only rank 0 knows the saved table.
        let start = (number == 0)
            .then(|| start.lock().unwrap().take())
            .flatten();
        let saves = Saves::new(start, Duration::ZERO, &mut save);
        let member = Member {
            number,
            team: &team,
        };
        bake_from(cell, plan, Some(saves), &member).expect("bakes")
    };
    let mut tables: Vec<Option<Table>> = std::thread::scope(|scope| {
        let ranks: Vec<_> = (0..count)
            .map(|number| scope.spawn(move || bake(number)))
            .collect();
        ranks.into_iter().map(|rank| rank.join().unwrap()).collect()
    });
    for (number, given) in team.given.iter().enumerate() {
        assert!(*given.lock().unwrap() > 0, "rank {number} traced nothing");
    }
    let table = tables.swap_remove(0).expect("rank 0 has the table");
    assert!(tables.iter().all(Option::is_none), "and no other");
    (table, first.into_inner().unwrap())
}

#[test]
fn any_number_of_ranks_bakes_the_same_bytes() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let bytes = |table: &Table| {
        let file = folder.path().join("table.h5");
        tables::write(table, &file).expect("writes");
        std::fs::read(&file).expect("reads")
    };
    let request = |incidence: &str, azimuth: &str| Request {
        incidence: incidence.into(),
        azimuth: azimuth.into(),
        ..asked("--rays 200001 --method rays")
    };
    let cases = [
        (cells::pair(), request("0:40:20", "10,70")),
        (
            cells::uneven_pair([5e-4, 0.0, -3e-4]),
            request("0:40:20", "10,70"),
        ),
        (
            cells::triangular(),
            Request {
                sampler: Sampler::Random,
                shard: Some("2/3".into()),
                ..request("0:45:15", "mean")
            },
        ),
        (
            cells::full_cube(),
            Request {
                rays: None,
                tolerance: Some(0.02),
                ..request("0,20,50", "0")
            },
        ),
    ];
    let mut compared = 0;
    for (cell, request) in cases {
        let plan = plan(&request);
        let whole = bytes(&rays(&cell, &plan).expect("bakes"));
        let mut saved = None;
        for count in [1, 2, 3, 4] {
            // Each bake goes on from a table saved by another number of ranks. The first begins
            // with nothing.
            let (table, first) = shared(count, &cell, &plan, saved.take());
            assert!(bytes(&table) == whole, "{count} ranks");
            saved = first;
            compared += 1;
        }
    }
    assert_eq!(compared, 16);
}

#[test]
fn the_exact_method_is_the_leaders_alone() {
    let plan = plan(&Request::default());
    let cell = cells::pair();
    let alone = bake_from(&cell, &plan, None, &Alone).expect("bakes");
    let team = Team {
        meeting: Barrier::new(1),
        numbers: Mutex::default(),
        given: vec![Mutex::default(), Mutex::default()],
    };
    let of = |number| {
        let member = Member {
            number,
            team: &team,
        };
        bake_from(&cell, &plan, None, &member).expect("bakes")
    };
    assert_eq!(of(0), alone);
    assert_eq!(of(1), None);
}
