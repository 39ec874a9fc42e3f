//! Agents that hear each other badly, or hear what they should not believe.

mod exchange {
    pub mod answers;
    pub mod budget;
    pub mod hops;
    pub mod letters;
    pub mod liars;
    pub mod links;
    pub mod rejections;
    pub mod repair;
    pub mod spoiling;
}
