//! Systematic resampling.

/// Bits behind the point of a place among the chosen.
const FRACTION: u32 = 40;

/// Chooses as many points as there are weights, in order, each as often as its weight says. The greatest weight is 1.
/// `shift`, out of all numbers of 32 bits, is the chance in it.
pub fn systematic(weights: &[f32], shift: u32, coordinates: [&mut Vec<f32>; 2]) {
    let count = weights.len();
    // Whole numbers of 2⁻²³, so that sums are exact and quick: the last bits of 1 to 2.
    let parts = |weight: &f32| u64::from((1.0 + weight).to_bits() - 1.0f32.to_bits());
    let total: u64 = weights.iter().map(parts).sum();
    let per_part = ((count as u64) << FRACTION) / total;
    // Each index where its places begin. Where none is its own, the next index takes it.
    let mut begins = vec![0; count + 1];
    let mut place = u64::from(shift) << (FRACTION - 32);
    for (index, weight) in (0..).zip(weights) {
        begins[(place >> FRACTION) as usize] = index;
        place += parts(weight) * per_part;
    }
    let [x, y] = coordinates.map(|axis| (std::mem::replace(axis, vec![0.0; count]), axis));
    let mut chosen = 0u32;
    for ((x_now, y_now), begin) in x.1.iter_mut().zip(y.1).zip(begins) {
        chosen = chosen.max(begin);
        (*x_now, *y_now) = (x.0[chosen as usize], y.0[chosen as usize]);
    }
}
