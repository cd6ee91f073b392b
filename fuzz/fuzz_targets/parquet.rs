#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| pylon_fuzz::parquet(bytes));
