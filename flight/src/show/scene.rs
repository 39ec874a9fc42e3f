//! A mission in three dimensions, for the 3D panels of Foxglove and Lichtblick.
//!
//! Everything is in the frame [`FRAME`] (East-North-Up, metres). A step's update takes away all of
//! the one before, so that a viewer may begin anywhere; the town has a topic of its own because it
//! is said once.

use csat_proto::camera::Pose;
use csat_world::world::World;
use foxglove::messages::line_primitive::Type as LineType;
use foxglove::messages::scene_entity_deletion::Type as DeletionType;
use foxglove::messages::{
    ArrowPrimitive, Color, CubePrimitive, FrameTransform, FrameTransforms, LinePrimitive, Point3,
    Pose as FoxglovePose, Quaternion, SceneEntity, SceneEntityDeletion, SceneUpdate, TextPrimitive,
    Timestamp, TriangleListPrimitive, Vector3,
};

use super::drawn::Drawn;
use super::mesh;
use super::seen::Seen;
use crate::plot::uav_colour;
use csat_mission::picture::{Cells, Content, Mark, Oem, Ring};

/// The frame that everything is in.
pub const FRAME: &str = "world";

/// How far above the ground lines are, metres: on it they would flicker.
const LINE_M: f64 = 0.2;

/// An instant of simulated time.
pub fn timestamp(time_ns: u64) -> Timestamp {
    let (seconds, rest) = (time_ns / 1_000_000_000, time_ns % 1_000_000_000);
    Timestamp::new(u32::try_from(seconds).unwrap_or(u32::MAX), rest as u32)
}

/// The town: its buildings and its roads.
pub fn town(world: &World) -> SceneUpdate {
    let grey = Color { r: 0.62, g: 0.6, b: 0.56, a: 1.0 };
    let building = |(index, obstacle): (usize, &csat_world::obstacle::Obstacle)| {
        let rings: Vec<Ring> = obstacle.rings().collect();
        SceneEntity {
            triangles: vec![triangles_of(mesh::building(&rings, obstacle.height_m), grey)],
            ..entity(0, format!("building {index}"))
        }
    };
    let road = Color { r: 0.5, g: 0.5, b: 0.5, a: 0.8 };
    let roads = world.roads().edges().iter();
    let roads = SceneEntity {
        lines: roads.map(|edge| line(&edge.line, LineType::LineStrip, 1.0, road)).collect(),
        ..entity(0, "roads".to_owned())
    };
    let buildings = world.obstacles().iter().enumerate().map(building);
    SceneUpdate { deletions: Vec::new(), entities: buildings.chain([roads]).collect() }
}

/// What moves, at one step.
pub fn step(time_ns: u64, world: &World, seen: &[Seen]) -> SceneUpdate {
    let everything = SceneEntityDeletion {
        timestamp: Some(timestamp(time_ns)),
        r#type: DeletionType::All as i32,
        id: String::new(),
    };
    let mut entities = vec![cars(time_ns, world)];
    let (poses, uavs) = (world.poses(), world.config().fleet.count);
    entities.extend(seen.iter().filter_map(|seen| {
        let pose = poses.get(usize::from(seen.agent.0))?;
        let is_uav = seen.agent.0 < uavs;
        Some(if is_uav { uav(time_ns, seen, pose) } else { station(time_ns, seen, pose) })
    }));
    let known = seen.iter().filter(|seen| !seen.is_repeated);
    entities
        .extend(known.flat_map(|seen| seen.layers.iter().map(|drawn| layer(time_ns, drawn, seen))));
    SceneUpdate { deletions: vec![everything], entities }
}

/// Where the agents are, so that a viewer can follow one: frames `uav-0`, `uav-1`..., `station-4`...
pub fn frames(time_ns: u64, world: &World) -> FrameTransforms {
    let uavs = usize::from(world.config().fleet.count);
    let frame = |(index, pose): (usize, &Pose)| {
        let kind = if index < uavs { "uav" } else { "station" };
        let FoxglovePose { position, orientation } = at_pose(pose);
        FrameTransform {
            timestamp: Some(timestamp(time_ns)),
            parent_frame_id: FRAME.to_owned(),
            child_frame_id: format!("{kind}-{index}"),
            translation: position,
            rotation: orientation,
        }
    };
    FrameTransforms { transforms: world.poses().iter().enumerate().map(frame).collect() }
}

fn cars(time_ns: u64, world: &World) -> SceneEntity {
    let [x, y, z] = world.config().targets.body_m;
    let red = Color { r: 0.85, g: 0.1, b: 0.1, a: 1.0 };
    let cars = world.targets().iter().map(|target| {
        let [east, north] = target.location;
        CubePrimitive {
            pose: Some(at([east, north, z / 2.0], target.heading_rad)),
            size: Some(Vector3 { x, y, z }),
            color: Some(red),
        }
    });
    SceneEntity { cubes: cars.collect(), ..entity(time_ns, "cars".to_owned()) }
}

fn uav(time_ns: u64, seen: &Seen, pose: &Pose) -> SceneEntity {
    let colour = colour(seen, 1.0);
    let [x, y, z] = pose.p_world;
    let arrow = ArrowPrimitive {
        pose: Some(at_pose(pose)),
        shaft_length: 6.0,
        shaft_diameter: 2.0,
        head_length: 4.0,
        head_diameter: 4.0,
        color: Some(colour),
    };
    let name = name([x, y, z + 5.0], format!("UAV {}", seen.agent), colour);
    SceneEntity {
        arrows: vec![arrow],
        lines: vec![line(&seen.footprint, LineType::LineLoop, 1.5, colour)],
        texts: vec![name],
        ..entity(time_ns, format!("uav {}", seen.agent))
    }
}

/// A ground station: its mast, from the ground up to its antenna.
fn station(time_ns: u64, seen: &Seen, pose: &Pose) -> SceneEntity {
    let (colour, [x, y, z]) = (colour(seen, 1.0), pose.p_world);
    let height_m = z.max(1.0);
    SceneEntity {
        cubes: vec![cube([x, y], [2.0, 2.0, height_m], colour)],
        texts: vec![name([x, y, height_m + 5.0], format!("station {}", seen.agent), colour)],
        ..entity(time_ns, format!("station {}", seen.agent))
    }
}

fn name([x, y, z]: [f64; 3], text: String, colour: Color) -> TextPrimitive {
    TextPrimitive {
        pose: Some(at([x, y, z], 0.0)),
        billboard: true,
        font_size: 14.0,
        scale_invariant: true,
        color: Some(colour),
        text,
    }
}

/// A layer of what an agent knows; faint where buildings cover it.
fn layer(time_ns: u64, drawn: &Drawn, seen: &Seen) -> SceneEntity {
    let (thickness_px, opacity) = if drawn.style.is_ground { (1.0, 0.5) } else { (3.0, 1.0) };
    let outline_colour = colour(seen, opacity);
    let mut entity = entity(time_ns, format!("{} of {}", drawn.style.key, seen.agent));
    match &drawn.content {
        Content::Areas(areas) => {
            let rings = areas.iter().flat_map(|area| &area.shapes).flatten();
            let outline =
                |ring: &Ring| line(ring, LineType::LineLoop, thickness_px, outline_colour);
            entity.lines = rings.map(outline).collect();
        }
        Content::Points(marks) => {
            let cube = |mark: &Mark| cube(mark.point, [3.0; 3], outline_colour);
            entity.cubes = marks.iter().map(cube).collect();
        }
        Content::Heights(oem) => {
            entity.cubes = boxes(oem).map(|(at, size)| cube(at, size, outline_colour)).collect();
        }
        Content::Cells(_) | Content::Heat(_) => {
            let bands = drawn.bands();
            let flat = |(share, cells): &(f64, Cells)| {
                let triangles = cells.rings().flat_map(|ring| mesh::flat(&[ring], LINE_M));
                triangles_of(triangles, colour(seen, 0.6 * opacity * share))
            };
            entity.triangles = bands.iter().map(flat).collect();
        }
    }
    entity
}

/// The occupied cells of a map: their centres and sizes, metres.
fn boxes(oem: &Oem) -> impl Iterator<Item = ([f64; 2], [f64; 3])> {
    oem.occupied.iter().map(|&(column, row, height_dm)| {
        let centre = |cell: u32, origin: f64| origin + (f64::from(cell) + 0.5) * oem.cell_m;
        let at = [centre(column, oem.origin_m[0]), centre(row, oem.origin_m[1])];
        (at, [oem.cell_m, oem.cell_m, f64::from(height_dm) / 10.0])
    })
}

/// A box on the ground.
fn cube([east, north]: [f64; 2], [x, y, z]: [f64; 3], color: Color) -> CubePrimitive {
    CubePrimitive {
        pose: Some(at([east, north, z / 2.0], 0.0)),
        size: Some(Vector3 { x, y, z }),
        color: Some(color),
    }
}

fn triangles_of(
    corners: impl IntoIterator<Item = mesh::Corner>,
    color: Color,
) -> TriangleListPrimitive {
    let points = corners.into_iter().map(|p| p.map(coarse)).map(|[x, y, z]| Point3 { x, y, z });
    TriangleListPrimitive {
        pose: Some(at([0.0; 3], 0.0)),
        points: points.collect(),
        color: Some(color),
        ..TriangleListPrimitive::default()
    }
}

fn colour(seen: &Seen, a: f64) -> Color {
    let digits =
        u32::from_str_radix(uav_colour(usize::from(seen.agent.0)).trim_start_matches('#'), 16);
    let digits = digits.unwrap_or_default();
    let [r, g, b] = [16, 8, 0].map(|shift| f64::from((digits >> shift) & 0xff) / 255.0);
    Color { r, g, b, a }
}

fn entity(time_ns: u64, id: String) -> SceneEntity {
    SceneEntity {
        timestamp: Some(timestamp(time_ns)),
        frame_id: FRAME.to_owned(),
        id,
        ..SceneEntity::default()
    }
}

fn line(points: &[[f64; 2]], kind: LineType, thickness_px: f64, color: Color) -> LinePrimitive {
    LinePrimitive {
        r#type: kind as i32,
        pose: Some(at([0.0, 0.0, LINE_M], 0.0)),
        thickness: thickness_px,
        scale_invariant: true,
        points: points
            .iter()
            .map(|p| p.map(coarse))
            .map(|[x, y]| Point3 { x, y, z: 0.0 })
            .collect(),
        color: Some(color),
        ..LinePrimitive::default()
    }
}

/// A length to 1/16 m: such numbers end in zeros, which compress, and the difference is invisible.
fn coarse(metres: f64) -> f64 {
    (metres * 16.0).round() / 16.0
}

fn at(p_world: [f64; 3], yaw_rad: f64) -> FoxglovePose {
    at_pose(&Pose::level(p_world, yaw_rad))
}

/// A pose as a quaternion: the product of those of yaw, pitch and roll.
fn at_pose(&Pose { p_world: [x, y, z], yaw_rad, pitch_rad, roll_rad }: &Pose) -> FoxglovePose {
    let [(sy, cy), (sp, cp), (sr, cr)] =
        [yaw_rad, pitch_rad, roll_rad].map(|angle| (angle / 2.0).sin_cos());
    FoxglovePose {
        position: Some(Vector3 { x, y, z }),
        orientation: Some(Quaternion {
            x: cy * cp * sr - sy * sp * cr,
            y: cy * sp * cr + sy * cp * sr,
            z: sy * cp * cr - cy * sp * sr,
            w: cy * cp * cr + sy * sp * sr,
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::set_membership::layers::LAYERS;
    use csat_mission::picture::{Area, Heat};
    use csat_proto::ids::AgentId;

    fn entity_of(content: Content) -> SceneEntity {
        let drawn = Drawn { style: &LAYERS[0], content };
        let (agent, footprint) = (AgentId(2), Vec::new());
        let seen = Seen { agent, footprint, layers: vec![drawn.clone()], is_repeated: false };
        layer(0, &drawn, &seen)
    }

    #[test]
    fn orientations_are_the_rotations_of_poses() {
        let pose = Pose { p_world: [1.0, 2.0, 3.0], yaw_rad: 2.0, pitch_rad: -0.3, roll_rad: 0.5 };
        let Quaternion { x, y, z, w } = at_pose(&pose).orientation.unwrap();
        let rotation =
            nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, x, y, z));
        let difference = rotation.to_rotation_matrix().into_inner() - pose.world_from_body();
        assert!(difference.amax() < 1e-12, "{difference}");
    }

    #[test]
    fn every_kind_of_layer_is_drawn() {
        let ring = vec![[0.0, 0.0], [9.0, 0.0], [9.0, 9.0]];
        let area = Area { shapes: vec![vec![ring.clone(), ring]], ..Area::default() };
        let areas = entity_of(Content::Areas(vec![area]));
        assert_eq!((areas.id.as_str(), areas.lines.len()), ("unexplored of 2", 2));
        let cells = Cells { cell_m: 5.0, runs: vec![[0, 0, 2], [1, 3, 4]], ..Cells::default() };
        let cells = entity_of(Content::Cells(cells));
        // Two rectangles of two triangles.
        assert_eq!(cells.triangles[0].points.len(), 2 * 2 * 3);
        let heat = Heat {
            cell_m: 5.0,
            columns: 1,
            maximum: 1.0,
            values: vec![0.1, 1.0],
            ..Heat::default()
        };
        let heat = entity_of(Content::Heat(heat));
        let alpha = |band: usize| heat.triangles[band].color.as_ref().unwrap().a;
        assert!(alpha(0) < alpha(4) && heat.triangles[4].points.len() == 6);
        let oem = Oem { cell_m: 5.0, occupied: vec![(1, 0, 120)], ..Oem::default() };
        let heights = entity_of(Content::Heights(oem));
        let size = heights.cubes[0].size.unwrap();
        assert_eq!([size.x, size.y, size.z], [5.0, 5.0, 12.0]);
        assert_eq!(entity_of(Content::Points(vec![Mark::default()])).cubes.len(), 1);
    }
}
