//! No bytes make the reader of images panic: OpenEXR first, and the other formats by their first bytes.
#![no_main]

use nephroid::internals::film::bitmap::{Bitmap, BitmapEncoding};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| drop(Bitmap::read(bytes, BitmapEncoding::Color)));
