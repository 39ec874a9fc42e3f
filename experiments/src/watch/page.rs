//! The page: one document that requests nothing from other servers.

use std::hash::{BuildHasher, RandomState};

use crate::set_membership::layers::LAYERS;

const STYLE: &str = concat!(include_str!("page/base.css"), include_str!("page/parts.css"));
const SCRIPT: &str = concat!(
    "'use strict';\n",
    include_str!("page/colours.js"),
    include_str!("page/state.js"),
    include_str!("page/camera.js"),
    include_str!("page/shapes.js"),
    include_str!("page/layers.js"),
    include_str!("page/ground.js"),
    include_str!("page/fleet.js"),
    include_str!("page/links.js"),
    include_str!("page/curves.js"),
    include_str!("page/controls.js"),
    include_str!("page/details.js"),
    include_str!("page/recorded.js"),
    include_str!("page/live.js"),
    include_str!("page/main.js"),
);
const BODY: &str = include_str!("page/page.html");

/// What a page shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// A fleet that flies.
    Live,
    /// A run that flew.
    Recorded,
}

/// A page and what a browser may do with it.
#[derive(Debug, Clone)]
pub struct Page {
    /// The document.
    pub html: String,
    /// Its Content-Security-Policy.
    pub policy: String,
}

/// The page.
pub fn html(mode: Mode) -> Page {
    let mode = match mode {
        Mode::Live => "live",
        Mode::Recorded => "recorded",
    };
    // Only the style and the script that bear this number are obeyed.
    let nonce = format!("{:016x}", RandomState::new().hash_one(mode));
    // Recordings that do not say their layers are of this mission.
    let layers = serde_json::to_string(LAYERS).expect("names and numbers are JSON");
    let html = BODY
        .replace("{{mode}}", mode)
        .replace("{{nonce}}", &nonce)
        .replace("{{style}}", STYLE)
        .replace("{{script}}", SCRIPT)
        .replace("{{layers}}", &layers);
    let policy = format!(
        "default-src 'none'; script-src 'nonce-{nonce}'; style-src 'nonce-{nonce}'; connect-src \
         'self'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    );
    Page { html, policy }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_whole_and_each_has_its_own_nonce() {
        let (a, b) = (html(Mode::Live), html(Mode::Recorded));
        assert!(!a.html.contains("{{") && a.html.contains("data-mode=\"live\""));
        assert!(b.html.contains("data-mode=\"recorded\""));
        assert_ne!(a.policy, b.policy);
        assert_eq!(a.html.matches("<script").count(), 1);
        assert!(!SCRIPT.contains("innerHTML"), "what fleets say is never HTML");
    }
}
