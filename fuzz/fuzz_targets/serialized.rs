//! No bytes make the reader of `serialized` meshes panic.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| nephroid_fuzz::load_mesh("serialized", bytes));
