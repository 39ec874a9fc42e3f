use std::sync::Arc;

use csat_proto::camera::{CameraModel, Pose};
use csat_proto::ids::RunId;
use csat_proto::model::FleetModel;
use csat_proto::time::SimTime;

use super::*;
use crate::config::{ClearingConfig, OdometryBounds};
use crate::exchange::message::{Beat, Mask, Request};

pub(crate) fn config() -> AgentConfig {
    AgentConfig {
        run: RunId(1),
        seed: 1,
        id: AgentId(0),
        incarnation: Incarnation(0),
        period_s: 0.125,
        fleet: FleetModel { count: 4, altitude_m: 70.0, ..FleetModel::default() },
        stations: 1,
        camera: CameraModel {
            columns: 256,
            rows: 256,
            aperture_deg: 80.0,
            ..CameraModel::default()
        },
        cell_m: 0.5,
        gap_px: 1,
        motion_error_m: 0.05,
        odometry: OdometryBounds::default(),
        hbsr: ChannelId(0),
        offset_error_m: 0.5,
        lblr: ChannelId(1),
        bearing_error_deg: 5.0,
        start_line_m: [[0.0, -3.0], [0.0, 3.0]],
        clearing: ClearingConfig::default(),
    }
}

fn message() -> Message {
    let beat = Beat {
        duty: Duty::Cleaner,
        leader: None,
        followers: 2,
        has_frontier: true,
        is_waiting: false,
        has_lost: false,
    };
    let request = Request { to: AgentId(0), rows: [3, 9], columns: [250, 255] };
    let formation = Formation {
        heading: [1, -1],
        wings: [None, Some(AgentId(0))],
        tails: vec![AgentId(3)],
        parent: Some(AgentId(2)),
        requests: vec![request],
    };
    Message { beat, formation: Some(formation), safe: Some(Mask::Runs(vec![100, 256 * 256 - 100])) }
}

fn envelope() -> Envelope {
    Envelope {
        run: RunId(1),
        src: AgentId(1),
        incarnation: Incarnation(0),
        channel: ChannelId(0),
        sequence: 0,
        step: Step(100),
        time: SimTime(0),
        pose: Pose::default().into(),
        body: Vec::new(),
    }
}

fn verdict(
    change: impl Fn(&mut Message, &mut Envelope, &mut Reception),
) -> Result<(), &'static str> {
    let (mut message, mut envelope) = (message(), envelope());
    let mut reception = Reception {
        channel: ChannelId(0),
        at: SimTime(0),
        bearing_rad: 0.0,
        offset_m: Some([10.0, -20.0]),
        bytes: Arc::from([]),
    };
    change(&mut message, &mut envelope, &mut reception);
    if envelope.body.is_empty() {
        envelope.body = postcard::to_stdvec(&message).unwrap();
    }
    reception.bytes = envelope.encode().into();
    check(&config(), Step(100), &reception).map(drop).map_err(|rejection| rejection.name())
}

/// A change of a formation.
fn formed(change: impl Fn(&mut Formation)) -> Result<(), &'static str> {
    verdict(|message, _, _| change(message.formation.as_mut().unwrap()))
}

#[test]
fn a_valid_message_is_believed() {
    assert_eq!(verdict(|_, _, _| ()), Ok(()));
}

#[test]
fn headers_are_checked() {
    assert_eq!(verdict(|_, e, _| e.run = RunId(2)), Err("run"));
    assert_eq!(verdict(|_, e, _| e.src = AgentId(0)), Err("sender"));
    assert_eq!(verdict(|_, e, _| e.src = AgentId(5)), Err("sender"));
    assert_eq!(verdict(|_, e, _| e.channel = ChannelId(1)), Err("channel"));
    let unused = |_: &mut Message, e: &mut Envelope, r: &mut Reception| {
        (e.channel, r.channel) = (ChannelId(2), ChannelId(2));
    };
    assert_eq!(verdict(unused), Err("channel"));
    assert_eq!(verdict(|_, e, _| e.step = Step(102)), Err("future"));
    assert_eq!(verdict(|_, e, _| e.body = vec![255; 3]), Err("malformed"));
    assert_eq!(verdict(|_, _, r| r.offset_m = None), Err("offset"));
    assert_eq!(verdict(|_, _, r| r.offset_m = Some([f64::NAN, 0.0])), Err("offset"));
    let reception = Reception {
        channel: ChannelId(0),
        at: SimTime(0),
        bearing_rad: 0.0,
        offset_m: None,
        bytes: Arc::from([1, 2, 3]),
    };
    assert_eq!(check(&config(), Step(0), &reception).unwrap_err().name(), "envelope");
    let late = Step(100 + 8 * 60 + 1);
    let mut envelope = envelope();
    envelope.body = postcard::to_stdvec(&message()).unwrap();
    let reception = Reception { bytes: envelope.encode().into(), ..reception };
    assert_eq!(check(&config(), late, &reception).unwrap_err().name(), "too-old");
}

#[test]
fn only_cleaners_have_formations_and_only_uavs_have_duties() {
    assert_eq!(verdict(|m, _, _| m.beat.duty = Duty::Helper), Err("duty"));
    assert_eq!(verdict(|_, e, _| e.src = AgentId(4)), Err("duty"));
    assert_eq!(verdict(|m, _, _| m.beat.leader = Some(AgentId(1))), Err("duty"));
    let far = |m: &mut Message, e: &mut Envelope, r: &mut Reception| {
        (e.channel, r.channel, r.offset_m) = (ChannelId(1), ChannelId(1), None);
        m.safe = None;
    };
    assert_eq!(verdict(far), Err("duty"));
    let beat = |m: &mut Message, e: &mut Envelope, r: &mut Reception| {
        far(m, e, r);
        m.formation = None;
    };
    assert_eq!(verdict(beat), Ok(()));
}

#[test]
fn formations_requests_and_masks_are_checked() {
    assert_eq!(formed(|f| f.tails = vec![AgentId(3); 2]), Err("formation"));
    assert_eq!(formed(|f| f.tails = vec![AgentId(1)]), Err("formation"));
    assert_eq!(formed(|f| f.tails = vec![AgentId(4)]), Err("formation"));
    assert_eq!(formed(|f| f.parent = Some(AgentId(9))), Err("formation"));
    assert_eq!(formed(|f| f.heading = [2, 0]), Err("formation"));
    assert_eq!(formed(|f| f.heading = [i8::MIN, 0]), Err("formation"));
    assert_eq!(formed(|f| f.requests[0].to = AgentId(2)), Err("formation"));
    assert_eq!(formed(|f| f.requests = vec![f.requests[0]; 5]), Err("formation"));
    assert_eq!(formed(|f| f.requests[0].rows = [9, 3]), Err("request"));
    assert_eq!(formed(|f| f.requests[0].columns = [3, 256]), Err("request"));
    let masked = |mask: &Mask| verdict(|message, _, _| message.safe = Some(mask.clone()));
    assert_eq!(masked(&Mask::Runs(vec![u32::MAX, 2])), Err("mask"));
    assert_eq!(masked(&Mask::Bitmap(vec![0; 12])), Err("mask"));
    assert_eq!(masked(&Mask::Bitmap(vec![7; 256 * 32])), Ok(()));
}
