//! No bytes make the reader of `ply` meshes panic.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| nephroid_fuzz::load_mesh("ply", bytes));
