//! Half of the changes that a fuzzer tries are lies with a shape, the rest of bytes.

use libfuzzer_sys::fuzzer_mutate;

/// What a fuzzer's mutator does: `lie` makes a changed input of one and a seed, if it can.
pub fn mutate(
    data: &mut [u8],
    size: usize,
    max_size: usize,
    seed: u32,
    lie: fn(&[u8], u64) -> Option<Vec<u8>>,
) -> usize {
    let lie = (seed % 2 == 0).then(|| lie(&data[..size], u64::from(seed))).flatten();
    match lie.filter(|lie| lie.len() <= max_size) {
        Some(lie) => {
            data[..lie.len()].copy_from_slice(&lie);
            lie.len()
        }
        None => fuzzer_mutate(data, size, max_size),
    }
}
