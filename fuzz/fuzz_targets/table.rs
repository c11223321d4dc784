//! No bytes make the reader of `table` panic: see `entries.rs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| nephroid_fuzz::enter("table", bytes));
