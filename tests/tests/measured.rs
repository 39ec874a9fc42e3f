//! Each measured set against a second formulation of its definition, which shares no code with the
//! first: per pixel instead of per outline, by samples instead of polygons.

mod measured {
    pub mod clear;
    pub mod discs;
    pub mod rasters;
    pub mod targets;
}
