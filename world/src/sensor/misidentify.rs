//! Targets that a camera takes for others.

use csat_proto::frame::Detection;
use csat_proto::ids::TargetId;
use rand::RngExt;

use crate::camera::noise::{NoisePurpose, Stream};

/// Takes each identified target with probability `p` for another one of `count`: for one that the
/// frame does not show, if there is one, drawn uniformly. Tells whether it did.
///
/// Each target has a block of the stream, so that the visibility of one does not affect another.
pub(super) fn misidentify(
    p: f64,
    detections: &mut [Detection],
    count: u16,
    stream: Stream,
) -> bool {
    if p == 0.0 {
        return false;
    }
    let mut rng = stream.rng(NoisePurpose::Misidentification);
    let mut is_any = false;
    for index in 0..detections.len() {
        let shown = |j: &TargetId| detections.iter().any(|detection| detection.target == *j);
        let others: Vec<TargetId> = (0..count).map(TargetId).filter(|j| !shown(j)).collect();
        rng.set_word_pos(u128::from(detections[index].target.0) * 16);
        let is_mistaken = rng.random::<f64>() < p;
        let place: f64 = rng.random();
        if let Some(other) = others.get((place * others.len() as f64) as usize)
            && is_mistaken
        {
            detections[index].target = *other;
            is_any = true;
        }
    }
    detections.sort_by_key(|detection| detection.target);
    is_any
}

#[cfg(test)]
mod tests {
    use super::*;
    use csat_proto::frame::PixelBox;
    use csat_proto::ids::AgentId;
    use csat_proto::time::Step;

    /// The indexes in a frame that shows the targets 1 and 3 of `count`, in this order.
    fn named(p: f64, count: u16, step: u32) -> (Vec<u16>, bool) {
        let at = |id: u16| Detection {
            target: TargetId(id),
            pixels: PixelBox { columns: [id, id], rows: [0, 0] },
        };
        let mut detections = vec![at(1), at(3)];
        let stream = Stream { seed: 5, agent: AgentId(2), step: Step(step) };
        let is_any = misidentify(p, &mut detections, count, stream);
        assert!(detections.is_sorted_by(|a, b| a.target < b.target), "{detections:?}");
        detections.sort_by_key(|detection| detection.pixels.columns);
        (detections.iter().map(|detection| detection.target.0).collect(), is_any)
    }

    #[test]
    fn mistakes_come_at_their_rate_and_never_name_a_target_twice() {
        const FRAMES: u32 = 10_000;
        let all: Vec<(Vec<u16>, bool)> = (0..FRAMES).map(|step| named(0.1, 6, step)).collect();
        let wrong = |index: usize, right: u16| {
            all.iter().filter(|(named, _)| named[index] != right).count() as f64
        };
        let sd = (0.1 * 0.9 * f64::from(FRAMES)).sqrt();
        for (index, right) in [(0, 1), (1, 3)] {
            let off = (wrong(index, right) - 0.1 * f64::from(FRAMES)).abs();
            assert!(off < 4.0 * sd, "{off}");
        }
        assert!(all.iter().all(|(named, is_any)| *is_any == (*named != [1, 3])));
        let others: Vec<u16> = all.iter().map(|(named, _)| named[0]).filter(|j| *j != 1).collect();
        for j in [0, 2, 4, 5] {
            assert!(others.iter().filter(|other| **other == j).count() > others.len() / 6, "{j}");
        }
    }

    #[test]
    fn without_another_target_or_with_probability_0_there_is_no_mistake() {
        assert_eq!(named(0.0, 6, 1), (vec![1, 3], false));
        let (both, is_any) = named(1.0, 4, 1);
        assert!(is_any && both.iter().all(|j| *j != 1 || both[0] != 1), "{both:?}");
    }
}
