//! Agents that hear each other badly, or hear what they should not believe.

mod exchange {
    pub mod letters;
    pub mod links;
    pub mod rejections;
}
