//! Coordinates beside a map: metres east and north of the middle of the region.

use svg::node::element::{Group, Path};

use super::canvas::{Panel, group, round, text};
use crate::ticks::{short, step};

/// Room for the labels left of a panel and below it, pixels.
pub const LEFT_PX: f64 = 44.0;
/// Room for the labels below a panel, pixels.
pub const BELOW_PX: f64 = 34.0;
/// The least distance of labelled lines, pixels.
const APART_PX: f64 = 90.0;
const TICK_PX: f64 = 6.0;

/// Round coordinates from one border of a region to the other, metres.
fn ticks(size_m: f64, scale: f64) -> Vec<f64> {
    let step_m = step(APART_PX / scale);
    let last = (size_m / 2.0 / step_m + 1e-9).floor() as i64;
    (-last..=last).map(|k| k as f64 * step_m).collect()
}

/// Thin lines over the region at the labelled coordinates.
pub fn grid(panel: &Panel, size_m: [f64; 2]) -> Path {
    let half = size_m.map(|s| s / 2.0);
    let mut data = String::new();
    for x in ticks(size_m[0], panel.scale) {
        data += &panel.line(&[[x, -half[1]], [x, half[1]]]);
    }
    for y in ticks(size_m[1], panel.scale) {
        data += &panel.line(&[[-half[0], y], [half[0], y]]);
    }
    Path::new()
        .set("class", "grid")
        .set("d", data)
        .set("fill", "none")
        .set("stroke", "#000000")
        .set("stroke-opacity", 0.16)
        .set("stroke-width", 0.7)
}

/// Ticks with labels along the left and the lower edge of a panel, and what they count.
pub fn axes(panel: &Panel, size_m: [f64; 2]) -> Group {
    let (left, bottom) = (panel.x, panel.y + panel.height);
    let [middle_x, middle_y] = panel.pixel([0.0, 0.0]);
    let mut data = format!("M{left:.1} {:.1}V{bottom:.1}H{:.1}", panel.y, left + panel.width);
    let mut labels = group("axes");
    for x_m in ticks(size_m[0], panel.scale) {
        let [x, _] = panel.pixel([x_m, 0.0]);
        data += &format!("M{x:.1} {bottom:.1}v{TICK_PX}");
        let label = text(x, bottom + TICK_PX + 11.0, 11.0, signed(x_m));
        labels = labels.add(label.set("text-anchor", "middle"));
    }
    for y_m in ticks(size_m[1], panel.scale) {
        let [_, y] = panel.pixel([0.0, y_m]);
        data += &format!("M{left:.1} {y:.1}h-{TICK_PX}");
        let label = text(left - TICK_PX - 3.0, y + 4.0, 11.0, signed(y_m));
        labels = labels.add(label.set("text-anchor", "end"));
    }
    let lines = Path::new().set("d", data).set("fill", "none").set("stroke", "#666666");
    let east = text(middle_x, bottom + BELOW_PX - 4.0, 12.0, "x: metres east of the middle");
    let (x, y) = (round(left - LEFT_PX + 9.0), round(middle_y));
    let north = text(x, y, 12.0, "y: metres north of the middle")
        .set("transform", format!("rotate(-90 {x} {y})"));
    labels
        .add(lines.set("stroke-width", 0.8))
        .add(east.set("text-anchor", "middle"))
        .add(north.set("text-anchor", "middle"))
}

/// A coordinate with a true minus sign.
fn signed(metres: f64) -> String {
    short(metres).replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_lie_in_the_region() {
        assert_eq!(ticks(500.0, 1.7), [-200.0, -100.0, 0.0, 100.0, 200.0]);
        assert_eq!(
            ticks(400.0, 2.0),
            [-200.0, -150.0, -100.0, -50.0, 0.0, 50.0, 100.0, 150.0, 200.0]
        );
        assert_eq!(ticks(20.0, 40.0), [-10.0, -5.0, 0.0, 5.0, 10.0]);
        // A thin region has at least its middle.
        assert_eq!(ticks(20.0, 0.2), [0.0]);
        assert_eq!(signed(-150.0), "−150");
    }

    /// What a label says is where it stands.
    #[test]
    fn labels_stand_at_their_coordinates() {
        let panel = Panel::new(44.0, 74.0, 880.0, [500.0, 500.0], 10.0);
        let svg = axes(&panel, [500.0, 500.0]).to_string();
        let [x, _] = panel.pixel([-200.0, 0.0]);
        let at = svg.find("−200").unwrap();
        let element = &svg[svg[..at].rfind("<text").unwrap()..at];
        assert!(element.contains(&format!("x=\"{}\"", round(x))), "{element}");
    }
}
