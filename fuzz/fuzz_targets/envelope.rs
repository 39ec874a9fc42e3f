#![no_main]

libfuzzer_sys::fuzz_target!(init: { csat_tests::fuzz::Moment::shared(); }, |bytes: &[u8]| csat_tests::fuzz::envelope(bytes));
