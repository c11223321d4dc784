//! No bytes make the reader of `obj` panic: see `entries.rs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| nephroid_fuzz::enter("obj", bytes));
