//! No bytes make the reader of films panic: whatever channels, metadata and compression an OpenEXR file has.
#![no_main]

use nephroid::internals::film::exr;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| drop(exr::read(&nephroid_fuzz::file(
    "film.exr", bytes
))));
