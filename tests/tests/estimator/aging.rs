//! Late facts: with their age they keep the guarantee, without it they would break it.

use csat_agent::agent::SetMembershipAgent;
use csat_agent::config::AgentConfig;
use csat_proto::agent::Agent;
use csat_proto::camera::Pose;
use csat_proto::envelope::Envelope;
use csat_proto::ids::{AgentId, ChannelId, Incarnation, TargetId};
use csat_proto::message::{Digest, Fact, Known, Message, Snapshot, TargetFact};
use csat_proto::oem::OemPatch;
use csat_proto::raster::Raster;
use csat_proto::region::{Region, grid_point};
use csat_proto::time::{SimTime, Step};
use csat_tests::geometry::Point;
use csat_tests::hears::Hears;
use csat_tests::scenes::{Case, blind};

const V_MAX_M_S: f64 = 1.0;
const NOW: Step = Step(20);
const EMPTY: Region = Region::EMPTY;

fn config() -> AgentConfig {
    let mut config = Case::random(1).config;
    config.ground.size_m = [100.0; 2];
    config.targets.v_max_m_s = V_MAX_M_S;
    config
}

fn square(centre: Point, half_m: f64) -> Region {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let at = |[x, y]: Point| grid_point([centre[0] + x * half_m, centre[1] + y * half_m]);
    Region::from_shapes(vec![vec![corners.map(at).to_vec()]])
}

fn fact(config: &AgentConfig, clear_ground: Region, targets: Vec<TargetFact>) -> Fact {
    let nothing = Raster::empty(config.raster_grid());
    Fact {
        step: Step(0),
        number: 0,
        held: Digest::default(),
        clear_ground,
        obstacle_margin: EMPTY,
        targets,
        hidden: nothing.clone(),
        seen: nothing,
        oem: OemPatch::default(),
    }
}

fn packet(config: &AgentConfig, step: Step, message: &Message) -> Vec<u8> {
    Envelope {
        run: config.run,
        src: AgentId(1),
        incarnation: Incarnation(0),
        channel: ChannelId(0),
        sequence: 0,
        step,
        time: SimTime(0),
        pose: Pose::level([0.0, 0.0, 50.0], 0.0).into(),
        body: postcard::to_stdvec(message).unwrap(),
    }
    .encode()
}

/// UAV 0 without a view at step 20, after a packet.
fn told(config: &AgentConfig, bytes: &[u8]) -> SetMembershipAgent {
    let mut agent = SetMembershipAgent::new(config);
    let now = SimTime::from_seconds(f64::from(NOW.0) * config.period_s);
    agent.handle_frame(now, &blind(&config.camera, NOW, Pose::level([0.0, 0.0, 50.0], 0.0)));
    agent.hear(now, bytes);
    agent.handle_timeout(now);
    assert!(agent.rejected().is_empty(), "{:?}", agent.rejected());
    agent
}

fn admits(agent: &SetMembershipAgent, target: TargetId, p: Point) -> bool {
    agent.knowledge().set_of(target).region().distance_m(p) <= 1e-3
}

/// A target at the border of the clear ground of UAV 1 at step 0 drives into it for 10 s.
#[test]
fn clear_ground_seen_long_ago_may_be_occupied_now() {
    let config = config();
    let (seen_clear, j) = (square([0.0, 0.0], 30.0), TargetId(5));
    let now_at = [-30.01 + V_MAX_M_S * 10.0, 0.0];
    let old = fact(&config, seen_clear.clone(), Vec::new());
    let honest = told(&config, &packet(&config, Step(0), &Message::Fact(old.clone())));
    assert!(admits(&honest, j, now_at));
    // Ground that no target can have reached is still excluded: the fact is useful.
    assert!(!admits(&honest, j, [-30.01 + V_MAX_M_S * 10.0 + 0.5, 0.0]));
    assert!(!admits(&honest, j, [0.0, 0.0]));
    // The same fact without its age excludes the target: this test can fail.
    let ageless = Fact { step: NOW, ..old };
    let fooled = told(&config, &packet(&config, NOW, &Message::Fact(ageless)));
    assert!(!admits(&fooled, j, now_at));
}

/// A target seen at step 0 drives on; another one comes within r_s^tt of its old location.
#[test]
fn a_detection_of_long_ago_confines_nobody_now() {
    let config = config();
    let (seen, other) = (TargetId(1), TargetId(2));
    let targets = vec![TargetFact {
        target: seen,
        location: square([0.0, 0.0], 3.0),
        exclusion: square([0.0, 0.0], 12.0),
    }];
    let old = fact(&config, EMPTY, targets);
    let honest = told(&config, &packet(&config, Step(0), &Message::Fact(old.clone())));
    let (seen_at, other_at) = ([2.9 + 10.0, 0.0], [12.1 - 10.0, 0.0]);
    assert!(admits(&honest, seen, seen_at) && admits(&honest, other, other_at));
    assert!(!admits(&honest, seen, [3.0 + 10.8, 0.0]), "the set grew by what a target can drive");
    assert!(!admits(&honest, other, [0.0, 0.0]), "the middle of the exclusion is still excluded");
    let fooled = told(&config, &packet(&config, NOW, &Message::Fact(Fact { step: NOW, ..old })));
    assert!(!admits(&fooled, seen, seen_at) && !admits(&fooled, other, other_at));
}

/// The same for a snapshot, and for a target that only the sender has identified. The age of its
/// knowledge is that of its own step, not that of the frame in the same message.
#[test]
fn a_snapshot_of_long_ago_is_grown() {
    let config = config();
    let snapshot = |frame: Step, known: Step| {
        let known = Known {
            step: known,
            targets: vec![(TargetId(1), square([20.0, 20.0], 3.0))],
            unexplored: square([-20.0, -20.0], 10.0),
            obstacle_margin: EMPTY,
        };
        let fact = Fact { step: frame, ..fact(&config, EMPTY, Vec::new()) };
        let message = Message::Snapshot(Box::new(Snapshot { fact, known }));
        told(&config, &packet(&config, frame, &message))
    };
    let (known_at, unknown_at) = ([23.0 + 9.9, 20.0], [-10.0 + 9.9, -20.0]);
    for honest in [snapshot(Step(0), Step(0)), snapshot(NOW, Step(0))] {
        assert!(admits(&honest, TargetId(1), known_at) && admits(&honest, TargetId(9), unknown_at));
        let swapped = [(TargetId(1), unknown_at), (TargetId(9), known_at)];
        assert!(swapped.iter().all(|&(j, p)| !admits(&honest, j, p)));
        // The set grew by no more than a target can drive.
        assert!(!admits(&honest, TargetId(1), [23.0 + 10.8, 20.0]));
    }
    // The same without its age excludes the targets: this test can fail.
    let fooled = snapshot(NOW, Step(NOW.0 - 1));
    assert!(!admits(&fooled, TargetId(1), known_at) && !admits(&fooled, TargetId(9), unknown_at));
}
