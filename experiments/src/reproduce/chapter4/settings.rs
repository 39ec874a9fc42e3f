//! What differs between the figures.

use std::f64::consts::FRAC_PI_2;

use csat_agent::config::AgentConfig;
use csat_proto::camera::{Assumption, PoseError};

/// How one look is taken.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// What is particular about it.
    pub name: String,
    /// The camera, what is known of the cars, and the estimator.
    pub config: AgentConfig,
    /// Where the cars point; the line of sight is 0, radians.
    pub heading_rad: f64,
    /// How well the pose is known.
    pub pose_error: PoseError,
}

/// The settings of one figure.
#[derive(Debug, Clone)]
pub struct Family {
    /// What differs.
    pub title: &'static str,
    /// Where it is published.
    pub figure: &'static str,
    /// The settings.
    pub settings: Vec<Setting>,
}

/// The headings. The thesis does not tell its own; crosswise, its numbers come out (docs/reproduction.md),
/// so that is how cars stand in all other figures.
pub fn headings(plain: &AgentConfig) -> Family {
    let heading = |(name, heading_rad): (&str, f64)| Setting {
        name: name.to_owned(),
        config: plain.clone(),
        heading_rad,
        pose_error: PoseError::NONE,
    };
    Family {
        title: "Heading of the cars",
        figure: "not published",
        settings: [("crosswise", FRAC_PI_2), ("lengthwise", 0.0)].map(heading).to_vec(),
    }
}

/// The figures, from the setting that they have in common.
pub fn families(plain: &AgentConfig) -> Vec<Family> {
    let with = |name: String, change: &dyn Fn(&mut AgentConfig)| {
        let mut config = plain.clone();
        change(&mut config);
        Setting { name, config, heading_rad: FRAC_PI_2, pose_error: PoseError::NONE }
    };
    let radius = |r: f64| with(format!("r^t = {r} m"), &|c| c.targets.radius_m = r);
    let noise = |w: f64| with(format!("noise ± {w}"), &|c| c.camera.depth_noise = [-w, w]);
    let resolution = |factor: u16| {
        let [columns, rows] = [factor * plain.camera.columns, factor * plain.camera.rows];
        with(format!("{columns} x {rows} pixels"), &|c| {
            (c.camera.columns, c.camera.rows) = (columns, rows);
        })
    };
    let assumption = |number: u8, assumption: Assumption| {
        with(format!("Assumption {number}"), &|c| c.camera.assumption = assumption)
    };
    vec![
        headings(plain),
        Family {
            title: "Radius of the cylinder round a car",
            figure: "thesis figure 4.13",
            settings: [2.5, 3.0, 4.0].map(radius).to_vec(),
        },
        Family {
            title: "Depth noise",
            figure: "thesis figure 4.14",
            settings: [0.01, 0.05, 0.1].map(noise).to_vec(),
        },
        Family {
            title: "Resolution",
            figure: "thesis figure 4.17",
            settings: [1, 2].map(resolution).to_vec(),
        },
        Family {
            title: "Assumptions on the labels",
            figure: "thesis figure A.3",
            settings: vec![
                assumption(4, Assumption::EveryRay),
                assumption(5, Assumption::SomeRay),
                assumption(6, Assumption::CentreRay),
            ],
        },
    ]
}
