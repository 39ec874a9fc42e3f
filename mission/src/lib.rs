//! What a mission is, and the engine that flies one in one process: no Zenoh, no files.
//!
//! | module | what it holds |
//! |---|---|
//! | [`mission`] | the trait that a kind of mission implements |
//! | [`engine`] | a mission step by step: the world, its fleet and the monitor |
//! | [`fleet`] | the agents of a mission, wherever they are |
//! | [`local`] | the fleet of one process, in virtual time |
//! | [`node`] | one agent and the links to it |
//! | [`measures`], [`row`] | what is measured: columns, and one agent at one step |
//! | [`contact`] | what is measured of every mission: how well its UAVs are in touch |
//! | [`judge`] | what a mission promises, and its checks |
//! | [`picture`], [`shape`] | what there is to draw of an agent's knowledge |
//! | [`style`] | how it is drawn |
//! | [`documents`] | an agent's step as JSON documents |
//! | [`timing`], [`stages`] | the only clock |
//! | [`words`] | words for people |

pub mod contact;
pub mod documents;
pub mod engine;
pub mod fleet;
pub mod judge;
pub mod local;
pub mod measures;
pub mod mission;
pub mod node;
pub mod picture;
pub mod row;
pub mod shape;
pub mod stages;
pub mod style;
pub mod timing;
pub mod words;
