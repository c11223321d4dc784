//! Readers and writers that hash what passes.

use std::io::{self, BufRead, Read, Write};

use blake3::{Hash, Hasher};

/// A reader or a writer, and the hash of what has passed.
pub(super) struct Hashed<T> {
    inner: T,
    hasher: Hasher,
}

impl<T> Hashed<T> {
    pub(super) fn new(inner: T) -> Self {
        let hasher = Hasher::new();
        Self { inner, hasher }
    }

    pub(super) fn into_parts(self) -> (T, Hash) {
        (self.inner, self.hasher.finalize())
    }
}

impl<W: Write> Write for Hashed<W> {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        let length = self.inner.write(buffer)?;
        self.hasher.update(&buffer[..length]);
        Ok(length)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}

impl<R: BufRead> Read for Hashed<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let length = self.inner.read(buffer)?;
        self.hasher.update(&buffer[..length]);
        Ok(length)
    }
}

impl<R: BufRead> BufRead for Hashed<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        self.inner.fill_buf()
    }

    fn consume(&mut self, length: usize) {
        // What is consumed is in the buffer: no error comes of looking once more.
        if let Ok(buffer) = self.inner.fill_buf() {
            self.hasher.update(&buffer[..length]);
        }
        self.inner.consume(length);
    }
}
