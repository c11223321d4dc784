//! Runs in parts, through the bytes of their files.

use std::io::Cursor;

use nephroid::internals::reference::parts::{
    Divided, Gathered, Next, Part, ShardError, Shards, Step, Wanted,
};
use nephroid::internals::reference::shard::{Round, Shard};
use nephroid::internals::run::Budget;

/// Shards by the contents of their files.
///
/// # Errors
///
/// If their first lines are damaged, or of several runs.
pub fn opened<'a>(files: impl IntoIterator<Item = &'a [u8]>) -> Result<Shards, ShardError> {
    let mut shards = Shards::default();
    for file in files {
        shards.open("a file".to_owned(), Box::new(Cursor::new(file.to_vec())))?;
    }
    Ok(shards)
}

/// The parts of a shard's file, one for each round.
pub fn parts_of(file: &[u8]) -> Vec<&[u8]> {
    const FIRST: &[u8] = b"nephroid shard ";
    let starts = file.windows(FIRST.len()).enumerate();
    let mut ends: Vec<usize> = starts
        .filter(|(_, there)| *there == FIRST)
        .map(|(at, _)| at)
        .collect();
    ends.push(file.len());
    ends.windows(2)
        .map(|ends| &file[ends[0]..ends[1]])
        .collect()
}

/// What a run finds that is made in so many shards, the last first.
pub fn merged<S: Divided>(setup: &S, sensor: &str, budget: &Budget, count: u32) -> S::Found {
    let files = (0..count).rev().map(|index| {
        let shard = Shard { index, count };
        setup.run_shard(sensor, budget, shard).unwrap().unwrap()
    });
    let files: Vec<Vec<u8>> = files.collect();
    let mut shards = opened(files.iter().map(Vec::as_slice)).unwrap();
    setup
        .merge(sensor, &mut shards)
        .unwrap_or_else(|error| panic!("{error}"))
}

/// The round that is wanted.
pub fn round_of(wanted: &Wanted) -> Round {
    match wanted.step {
        Step::Round(round) => round,
        Step::Piece(_) => panic!("a piece of beams: {wanted:?}"),
    }
}

/// What a run finds whose rounds are traced in so many parts, the last first; and the rounds that it had.
pub fn gathered<S: Divided>(
    setup: &S,
    sensor: &str,
    budget: &Budget,
    count: u32,
) -> (S::Found, Vec<Round>) {
    let mut gathered = Gathered::default();
    let (mut rounds, mut keys) = (Vec::new(), Vec::new());
    loop {
        match setup.next(sensor, budget, &gathered).unwrap() {
            Next::Done(found) => return (*found, rounds),
            Next::Step(wanted) => {
                assert!(!keys.contains(&wanted.key), "{wanted:?}");
                assert!(wanted.work > 0 && wanted.most_parts > 0, "{wanted:?}");
                for index in (0..count).rev() {
                    let shard = Shard { index, count };
                    let part = setup.run_part(sensor, round_of(&wanted), shard);
                    let mut bytes = Vec::new();
                    part.unwrap().unwrap().write_to(&mut bytes).unwrap();
                    let part = Part::read_from(&bytes[..]).unwrap();
                    gathered.add(&wanted, shard, part).unwrap();
                }
                rounds.push(round_of(&wanted));
                keys.push(wanted.key);
            }
        }
    }
}
