//! Runs in parts, through the bytes of their files.

use nephroid::internals::reference::parts::{Divided, Gathered, Next, Part, ShardError};
use nephroid::internals::reference::shard::{Round, Shard};
use nephroid::internals::run::Budget;

/// Shards by the contents of their files, put together.
///
/// # Errors
///
/// If they are damaged, doubled or of several runs.
pub fn read<'a>(files: impl IntoIterator<Item = &'a [u8]>) -> Result<Gathered, ShardError> {
    let mut shards = Gathered::default();
    for file in files {
        shards.add_shard(Part::read_all(file)?)?;
    }
    Ok(shards)
}

/// What a run finds that is made in so many shards, the last first.
pub fn merged<S: Divided>(setup: &S, sensor: &str, budget: &Budget, count: u32) -> S::Found {
    let files = (0..count).rev().map(|index| {
        let shard = Shard { index, count };
        setup.run_shard(sensor, budget, shard).unwrap().unwrap()
    });
    let files: Vec<Vec<u8>> = files.collect();
    let shards = read(files.iter().map(Vec::as_slice)).unwrap();
    setup
        .merge(sensor, &shards)
        .unwrap_or_else(|error| panic!("{error}"))
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
            Next::Round(wanted) => {
                assert!(!keys.contains(&wanted.key), "{wanted:?}");
                assert!(wanted.work > 0 && wanted.most_parts > 0, "{wanted:?}");
                for index in (0..count).rev() {
                    let shard = Shard { index, count };
                    let part = setup.run_part(sensor, wanted.round, shard);
                    let mut bytes = Vec::new();
                    part.unwrap().unwrap().write_to(&mut bytes).unwrap();
                    let part = Part::read_from(&bytes[..]).unwrap();
                    gathered.add(&wanted, shard, part).unwrap();
                }
                rounds.push(wanted.round);
                keys.push(wanted.key);
            }
        }
    }
}
