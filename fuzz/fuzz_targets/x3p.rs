#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| diffract_fuzz::read("x3p", bytes));
