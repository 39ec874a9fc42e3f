//! Agents with bad links, or with messages that they must not believe.

mod exchange {
    pub mod answers;
    pub mod budget;
    pub mod hops;
    pub mod liars;
    pub mod links;
    pub mod packets;
    pub mod rejections;
    pub mod repair;
    pub mod spoiling;
}
