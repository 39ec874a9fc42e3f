//! The random numbers of frames, and depth noise and quantisation.

use csat_proto::camera::CameraModel;
use csat_proto::frame::Label;
use csat_proto::ids::AgentId;
use csat_proto::time::Step;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

use super::render::Classified;

/// The random numbers of one frame; they do not depend on the draws for other frames.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stream {
    pub seed: u64,
    pub agent: AgentId,
    pub step: Step,
}

/// The purpose of random numbers.
#[derive(Debug, Clone, Copy)]
pub(crate) enum NoisePurpose {
    Depth = 0,
    Boxes = 1,
    Sighting = 2,
    Segmentation = 3,
    Misidentification = 4,
}

impl Stream {
    /// The generator for one purpose.
    pub fn rng(self, purpose: NoisePurpose) -> ChaCha8Rng {
        let mut key = [0; 32];
        key[0..8].copy_from_slice(&self.seed.to_le_bytes());
        key[8..12].copy_from_slice(&self.step.0.to_le_bytes());
        key[12..14].copy_from_slice(&self.agent.0.to_le_bytes());
        key[14..22].copy_from_slice(b"camera/1");
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream(purpose as u64);
        rng
    }
}

/// The depths D = ρ(1+w) of a frame (3.33), quantised, with w uniform in `depth_noise`. A depth
/// beyond d_max makes its pixel Unknown. Pixel n takes the n-th number of the stream, so it does not
/// depend on other pixels; Unknown pixels get depth 0.
pub(super) fn measure(
    model: &CameraModel,
    seen: &Classified,
    stream: Stream,
    labels: &mut [Label],
) -> Vec<u16> {
    let [low, high] = model.depth_noise;
    // 31 bits each, w at the middle of one of 2³¹ equal parts of the interval.
    let scale = (high - low) / f64::from(1u32 << 31);
    let offset = 1.0 + low + 0.5 * scale;
    let step_m = model.depth_step_m();
    let columns = usize::from(model.columns);
    let mut rng = stream.rng(NoisePurpose::Depth);
    let mut words = vec![0u8; 4 * columns];
    let mut steps = vec![0i32; columns];
    let mut depth = vec![0u16; labels.len()];
    for (row, line) in labels.chunks_exact_mut(columns.max(1)).enumerate() {
        rng.fill_bytes(&mut words);
        let start = row * columns;
        for ((steps, word), rho_m) in
            steps.iter_mut().zip(words.as_chunks::<4>().0).zip(seen.rho_from(start))
        {
            let draw = f64::from((u32::from_le_bytes(*word) >> 1) as i32);
            *steps = quantised(rho_m * (offset + scale * draw), step_m);
        }
        for ((label, depth), steps) in line.iter_mut().zip(&mut depth[start..]).zip(&steps) {
            let is_measured = (*steps <= i32::from(u16::MAX)) & (*label != Label::Unknown);
            *depth = if is_measured { *steps as u16 } else { 0 };
            *label = if is_measured { *label } else { Label::Unknown };
        }
    }
    depth
}

/// [`CameraModel::quantise_depth`] in a form that compiles to vector instructions; 65536 beyond d_max.
fn quantised(depth_m: f64, step_m: f64) -> i32 {
    // Numbers near this one have a spacing of 1, so that their last bits are the offset from it.
    const HERE: f64 = 1.5 * (1u64 << 52) as f64;
    let steps = (depth_m / step_m + 0.5).min(65536.0);
    let nearest = steps + HERE - HERE;
    let whole = if nearest > steps { nearest - 1.0 } else { nearest };
    (whole + HERE).to_bits() as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantisation_is_the_models() {
        let model = CameraModel::default();
        let step_m = model.depth_step_m();
        let anywhere = (0..200_000).map(|i| f64::from(i) * 0.0015 + 0.000_123);
        let halfway = (0..131_080).map(|i| f64::from(i) * 0.5 * step_m);
        for depth_m in anywhere.chain(halfway) {
            let expected = model.quantise_depth(depth_m);
            assert_eq!(u16::try_from(quantised(depth_m, step_m)).ok(), expected, "{depth_m} m");
        }
        assert_eq!(quantised(f64::INFINITY, step_m), 65536);
    }

    #[test]
    fn streams_differ_in_seed_agent_step_and_purpose() {
        let stream = Stream { seed: 1, agent: AgentId(2), step: Step(3) };
        let all = [
            stream.rng(NoisePurpose::Depth),
            stream.rng(NoisePurpose::Boxes),
            stream.rng(NoisePurpose::Sighting),
            stream.rng(NoisePurpose::Segmentation),
            stream.rng(NoisePurpose::Misidentification),
            Stream { seed: 2, ..stream }.rng(NoisePurpose::Depth),
            Stream { agent: AgentId(3), ..stream }.rng(NoisePurpose::Depth),
            Stream { step: Step(4), ..stream }.rng(NoisePurpose::Depth),
        ];
        let mut first: Vec<u64> = all.into_iter().map(|mut rng| rng.next_u64()).collect();
        first.sort_unstable();
        first.dedup();
        assert_eq!(first.len(), 8);
    }
}
