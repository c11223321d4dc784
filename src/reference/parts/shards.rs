//! The files of a run's shards, read round by round.
//!
//! A shard has a part of each round, in their order. So only the sums of one round are in memory at a time.

use std::io::BufRead;

use super::gather::{Gathered, RoundsElsewhere};
use super::identity::{RunIdentity, ShardError};
use super::part::Begun;
use super::sums::Sums;

/// A file, or bytes in memory.
pub type File = Box<dyn BufRead + Send>;

/// The shards of a run.
#[derive(Default)]
pub struct Shards {
    files: Vec<ShardFile>,
    /// The method, and the work of all rounds.
    run: Option<(String, u64)>,
}

struct ShardFile {
    /// Its name, for errors.
    name: String,
    /// The part whose turn it is; `None` at the end.
    next: Option<Begun<File>>,
}

impl Shards {
    /// Adds a shard, of which the first lines are read.
    ///
    /// # Errors
    ///
    /// If it is none, or of another run than those before. Errors name it.
    pub fn open(&mut self, name: String, file: File) -> Result<(), ShardError> {
        let begun = self.begin(file).map_err(|error| error.of(&name))?;
        let next = Some(begun);
        self.files.push(ShardFile { name, next });
        Ok(())
    }

    fn begin(&mut self, file: File) -> Result<Begun<File>, ShardError> {
        let begun = Begun::read(file)?;
        let work = begun.work().ok_or(ShardError::OneRound)?;
        let (method, before) = (self.run).get_or_insert_with(|| (begun.method().to_owned(), work));
        if method != begun.method() {
            return Err(ShardError::differs("the method", method, &begun.method()));
        }
        if *before != work {
            let field = "the number of photons, maps or samples";
            return Err(ShardError::differs(field, before, &work));
        }
        Ok(begun)
    }

    /// The name of the method that made them; `None` if there are none.
    pub fn method(&self) -> Option<&str> {
        self.run.as_ref().map(|(method, _)| method.as_str())
    }

    /// Work of all replicates in all rounds, in the method's unit of a round.
    ///
    /// # Errors
    ///
    /// If there is no shard.
    pub(super) fn work(&self) -> Result<u64, ShardError> {
        let (count, given) = (1, Vec::new());
        let work = self.run.as_ref().map(|(_, work)| *work);
        work.ok_or(ShardError::Incomplete { count, given })
    }

    /// Refuses parts that no round of the run has asked for.
    ///
    /// # Errors
    ///
    /// If there are any.
    pub(super) fn check_end(&self) -> Result<(), ShardError> {
        match self.files.iter().find(|file| file.next.is_some()) {
            Some(file) => Err(ShardError::MoreRounds.of(&file.name)),
            None => Ok(()),
        }
    }
}

impl ShardFile {
    /// Adds the part whose turn it is.
    fn give(&mut self, round: &mut Gathered) -> Result<(), ShardError> {
        let Some(begun) = self.next.take() else {
            return Ok(());
        };
        let (part, mut file) = begun.end()?;
        round.put(part)?;
        if !file.fill_buf()?.is_empty() {
            self.next = Some(Begun::read(file)?);
        }
        Ok(())
    }
}

impl RoundsElsewhere for Shards {
    fn round(
        &mut self,
        run: &RunIdentity,
        add: &mut dyn FnMut(&Sums) -> bool,
    ) -> Result<Option<bool>, ShardError> {
        let mut round = Gathered::default();
        for file in &mut self.files {
            let given = file.give(&mut round);
            given.map_err(|error| error.of(&file.name))?;
        }
        round.round(run, add)
    }
}
