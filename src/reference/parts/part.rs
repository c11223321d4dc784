//! A part of a round, and its file.
//!
//! A file has the line `nephroid shard 4`, one line of JSON (`Header`), then the sums of the film, and the
//! BLAKE3 hash of all that. A shard of a run of several rounds has their parts one after the other.

use std::io::{self, BufRead, Read, Write};

use serde::{Deserialize, Serialize};

use super::hashed::Hashed;
use super::identity::{RunIdentity, ShardError};
use super::sums::{SmallSums, Sums};
use crate::film::Image;
use crate::reference::shard::Shard;

/// The first line of a shard file, version included.
const MAGIC: &str = "nephroid shard 4";

/// The first line of shards of any version, up to its number.
const ANY_MAGIC: &str = "nephroid shard ";

/// Longest header line that is read, in bytes. A thousand layers need a tenth of it.
const MAX_HEADER: u64 = 1 << 22;

/// Identity of the part, and its small sums.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Header {
    run: RunIdentity,
    shard: Shard,
    whole: Option<u64>,
    sums: SmallSums,
}

/// One shard's sums of a round.
#[derive(Debug)]
pub struct Part {
    pub(super) run: RunIdentity,
    pub(super) shard: Shard,
    /// Work of each replicate in all rounds of the run; `None` of a round that is asked for by itself.
    pub(super) whole: Option<u64>,
    pub(super) sums: Sums,
}

/// Refuses a header that no part can have.
fn check(header: &Header) -> Result<(), ShardError> {
    let Header { run, shard, .. } = header;
    if shard.index >= shard.count {
        return Err(ShardError::Malformed(format!(
            "it is part {} of {}: allowed are 0 to {}",
            shard.index,
            shard.count,
            i64::from(shard.count) - 1
        )));
    }
    if run
        .size
        .iter()
        .any(|size| *size == 0 || *size > Image::MAX_SIZE)
    {
        return Err(ShardError::Malformed(format!(
            "its film has {:?} texels: allowed are up to {} each way, and one at least",
            run.size,
            Image::MAX_SIZE
        )));
    }
    Ok(())
}

/// Refuses contents that have not the hash behind them, and leaves what follows.
fn check_hash<R: BufRead>(reader: Hashed<R>) -> Result<R, ShardError> {
    let (mut reader, hash) = reader.into_parts();
    let mut said = [0; blake3::OUT_LEN];
    reader.read_exact(&mut said)?;
    // All of the file is hashed: the header says nothing of its own damage.
    if hash != said {
        return Err(damaged());
    }
    Ok(reader)
}

fn damaged() -> ShardError {
    let message = "its contents have not the hash at its end: it is damaged";
    ShardError::Malformed(message.to_owned())
}

impl Part {
    /// Writes the part.
    ///
    /// # Errors
    ///
    /// As the writer's.
    pub fn write_to(&self, writer: impl Write) -> Result<(), ShardError> {
        let mut writer = Hashed::new(writer);
        let header = Header {
            run: self.run.clone(),
            shard: self.shard,
            whole: self.whole,
            sums: self.sums.small(),
        };
        let header = serde_json::to_string(&header)
            .map_err(|error| ShardError::Malformed(error.to_string()))?;
        writeln!(writer, "{MAGIC}\n{header}")?;
        self.sums.write_film(&mut writer)?;
        let (mut writer, hash) = writer.into_parts();
        Ok(writer.write_all(hash.as_bytes())?)
    }

    /// Reads a part, which is all of the file.
    ///
    /// # Errors
    ///
    /// If the file is no part, is damaged, or cannot be read.
    pub fn read_from(reader: impl BufRead) -> Result<Self, ShardError> {
        let (part, mut reader) = Begun::read(reader)?.end()?;
        if !reader.fill_buf()?.is_empty() {
            return Err(damaged());
        }
        Ok(part)
    }
}

/// A part whose first lines are read.
pub(super) struct Begun<R> {
    header: Header,
    reader: Hashed<R>,
}

impl<R: BufRead> Begun<R> {
    /// Reads the first lines.
    pub(super) fn read(reader: R) -> Result<Self, ShardError> {
        let mut reader = Hashed::new(reader);
        let header = read_header(&mut reader)?;
        Ok(Self { header, reader })
    }

    /// The name of the method that made it.
    pub(super) fn method(&self) -> &str {
        &self.header.run.method
    }

    /// Work of all replicates in all rounds of the run; `None` of a round that was asked for by itself.
    pub(super) fn work(&self) -> Option<u64> {
        let replicates = self.header.run.round.replicates.into();
        let whole = self.header.whole?;
        Some(whole.saturating_mul(replicates))
    }

    /// Reads the rest, and leaves what follows.
    pub(super) fn end(mut self) -> Result<(Part, R), ShardError> {
        let Header {
            run,
            shard,
            whole,
            sums,
        } = self.header;
        let sums = Sums::read_film(&run, shard, sums, &mut self.reader)?;
        let reader = check_hash(self.reader)?;
        let part = Part {
            run,
            shard,
            whole,
            sums,
        };
        Ok((part, reader))
    }
}

/// Reads the first two lines, and checks them.
fn read_header(mut reader: impl BufRead) -> Result<Header, ShardError> {
    let mut lines = reader.by_ref().take(MAX_HEADER);
    let mut line = String::new();
    let mut next = || -> Result<String, ShardError> {
        line.clear();
        lines
            .read_line(&mut line)
            .map_err(|error| match error.kind() {
                io::ErrorKind::InvalidData => ShardError::Malformed("no text".to_owned()),
                _ => error.into(),
            })?;
        Ok(line.trim_end().to_owned())
    };
    let magic = next()?;
    if magic != MAGIC {
        return Err(ShardError::Malformed(match magic.strip_prefix(ANY_MAGIC) {
            Some(_) => {
                format!("it is a \"{magic}\", and this version has \"{MAGIC}\": make it again")
            }
            None => format!("its first line is not \"{MAGIC}\""),
        }));
    }
    let header: Header =
        serde_json::from_str(&next()?).map_err(|error| ShardError::Malformed(error.to_string()))?;
    check(&header)?;
    Ok(header)
}
