//! All that a frame proves is true: random scenes, poses, cameras and noise against the scene itself.

use csat_agent::sense::Sensor;
use csat_tests::replay::{for_seeds, is_replay};
use csat_tests::scenes::Case;
use csat_tests::truth::{Said, check_frame};

const FRAMES: u64 = 6000;

#[test]
fn whatever_a_frame_claims_is_true() {
    let mut said = Said::default();
    for_seeds(["containment", "whatever_a_frame_claims_is_true"], 0..FRAMES, |seed| {
        let case = Case::random(seed);
        let mut sensor = Sensor::new(&case.config);
        let measured = sensor.measure(&case.frame());
        said.add(&check_frame(&case, &measured));
    });
    println!("{FRAMES} frames said {said:?}");
    if is_replay() {
        return;
    }
    // The scenes are hard enough and the frames prove enough to detect a mistake.
    assert!(said.clear > 4000 && said.margins > 1000 && said.margin_points > 50_000, "{said:?}");
    assert!(said.detections > 3000 && said.exclusions > 1000, "{said:?}");
    assert!(said.close_calls > 200 && said.empty_cells > 50_000, "{said:?}");
}

#[test]
fn whatever_a_frame_of_an_uncertain_pose_claims_is_true() {
    let mut said = Said::default();
    let name = ["containment", "whatever_a_frame_of_an_uncertain_pose_claims_is_true"];
    for_seeds(name, 0..FRAMES, |seed| {
        let case = Case::random(seed);
        let mut sensor = Sensor::new(&case.config);
        said.add(&check_frame(&case, &sensor.measure(&case.uncertain_frame())));
    });
    println!("{FRAMES} frames said {said:?}");
    if is_replay() {
        return;
    }
    assert!(said.clear > 3500 && said.margins > 400 && said.margin_points > 20_000, "{said:?}");
    assert!(said.detections > 3000 && said.exclusions > 200, "{said:?}");
    assert!(said.close_calls > 40 && said.empty_cells > 20_000, "{said:?}");
}
