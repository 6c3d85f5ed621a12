#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| inbye_fuzz::node::conversation(data));
