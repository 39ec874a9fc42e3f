//! What is true: the town, the cars, the UAVs, the frames of their cameras, and the monitor that
//! checks the guarantee from outside the agents.
//!
//! | module | what it holds |
//! |---|---|
//! | [`world`] | the state of the world, which advances by one period at a time |
//! | [`map`] | the town: generated from a seed, or from a GeoJSON file |
//! | [`obstacle`] | buildings, and exact distances to them |
//! | [`road`] | where cars can drive |
//! | [`road_area`] | the ground that roads cover, as a raster |
//! | [`start_line`] | from where roads are cleared |
//! | [`search_number`] | how many searchers a network of roads needs that see a point each |
//! | [`contamination`] | where on the roads somebody may be whom nobody has seen |
//! | [`target`] | the cars, on roads and off them |
//! | [`track`] | tracks that cars follow instead of driving on their own |
//! | `uav` | how UAVs move; a new kind of vehicle implements its trait |
//! | [`navigation`] | the errors of reported poses |
//! | [`lie`] | UAVs that lie |
//! | [`observer`] | boxes that contain true poses |
//! | [`odometry`] | reported poses in a frame of the agent's own |
//! | [`scene`] | the solids that cameras see |
//! | [`camera`] | frames with exact labels, and the oracle that checks them |
//! | [`sensor`] | what a UAV carries: a camera with labels, with a detector, or one that segments roads |
//! | [`radio`] | buildings as obstructions of radio |
//! | [`truth`] | the monitor |
//!
//! Lengths are metres in the frame `world` of [`csat_proto`] (East-North-Up, origin in the middle of
//! the region), angles radians counter-clockwise from east, times seconds.
//!
//! ```
//! use csat_proto::ids::AgentId;
//! use csat_world::camera::Renderer;
//! use csat_world::world::{World, WorldConfig};
//!
//! let mut world = World::new(&WorldConfig::default(), 1)?;
//! world.advance();
//! let mut renderer = Renderer::new(world.config().camera);
//! let pose = world.poses()[0];
//! let frame = renderer.frame(&world.scene(), &pose, world.step(), 1, AgentId(0));
//! assert_eq!(frame.labels.len(), renderer.model().pixels());
//! # Ok::<(), csat_world::world::WorldErrors>(())
//! ```

mod bits;
pub mod camera;
pub mod contamination;
pub mod lie;
pub mod map;
pub mod navigation;
pub mod observer;
pub mod obstacle;
pub mod odometry;
mod plane;
pub mod radio;
mod random;
pub mod road;
pub mod road_area;
pub mod scene;
pub mod search_number;
pub mod sensor;
pub mod start_line;
pub mod target;
pub mod track;
pub mod truth;
mod uav;
pub mod world;
