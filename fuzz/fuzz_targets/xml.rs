//! No bytes make the reader of scene files panic.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| nephroid_fuzz::load("scene.xml", bytes, None));
