//! Byte offsets as lines and columns.

use super::Position;

/// The beginnings of a text's lines.
///
/// They give a position in logarithmic time. A library that counts line ends from the top takes quadratic
/// time over all elements of a file.
pub struct LineIndex {
    starts: Vec<usize>,
}

impl LineIndex {
    /// The index of a text.
    pub fn new(text: &str) -> Self {
        let ends = text
            .bytes()
            .enumerate()
            .filter(|(_, byte)| *byte == b'\n')
            .map(|(at, _)| at + 1);
        Self {
            starts: std::iter::once(0).chain(ends).collect(),
        }
    }

    /// The line and column of a byte.
    pub fn position(&self, file: u32, byte: usize) -> Position {
        let line = self.starts.partition_point(|start| *start <= byte);
        // Bytes, not characters, between the line's start and here: a line of many megabytes would otherwise
        // make this quadratic. Both are the same for ASCII.
        let column = byte - self.starts[line - 1] + 1;
        Position {
            file,
            line: line as u32,
            column: column as u32,
        }
    }
}
