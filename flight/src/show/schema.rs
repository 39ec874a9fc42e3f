//! JSON Schemas of the documents, so that viewers know which fields there are to plot.
//!
//! Every document is valid by its schema, and what a schema requires is always there. Viewers of the
//! Foxglove family refuse a schema with anything but booleans, strings, numbers, objects and arrays of
//! those: arrays of arrays are left out, and what is not defined is absent from a document, not null.

use csat_mission::documents::Encoding;
use csat_mission::measures::{Column, Of};
use csat_mission::mission::Kind;
use serde_json::{Value, json};

/// The schema of the documents of a topic, all of one encoding: its name and its text.
pub fn of_topic(kind: &Kind, topic: &str, encoding: Encoding) -> (String, String) {
    let name = topic.rsplit('/').next().unwrap_or(topic);
    let is_view = topic.starts_with("view/");
    let mut title = name.to_owned();
    if let Some(first) = title.get_mut(..1) {
        first.make_ascii_uppercase();
    }
    let title = format!("csat.{}{title}", if is_view { "View" } else { "Truth" });
    let head = match name {
        _ if is_view => "agent:n incarnation:n step:n time_s:n",
        // They do not change.
        "town" | "layers" | "columns" => "",
        _ => "step:n time_s:n",
    };
    let own = if is_view { of_view(name, encoding) } else { of_truth(name) };
    let numbers = match name {
        "stats" => numbers(kind.columns.iter().filter(|column| column.of == Of::Agent)),
        "metrics" => numbers(kind.columns.iter()),
        _ => String::new(),
    };
    let mut schema = object(&format!("{head} {numbers} {own}"));
    let nested = match name {
        "plan" => Some(("poses", "p_world:[n] yaw_rad:n pitch_rad:n? roll_rad:n?")),
        "links" => Some(("heard", "src:n channel:n outcome:s count:n delay_s:n?")),
        "town" => Some(("stations", "x_m:n y_m:n z_m:n")),
        "columns" if !is_view => Some(("columns", "key:s name:s unit:s of:s meaning:s")),
        "layers" if !is_view => Some(("layers", "key:s title:s kind:s ground:b scene:b")),
        "targets" if !is_view => Some(("targets", "target:n location:[n]")),
        _ => None,
    };
    if let Some((key, of_items)) = nested {
        schema["properties"][key] = json!({ "type": "array", "items": object(of_items) });
        if let Some(required) = schema["required"].as_array_mut() {
            required.push(key.into());
        }
    }
    schema["title"] = title.clone().into();
    (title, schema.to_string())
}

/// The mission's numbers: what is not defined is absent.
fn numbers<'a>(columns: impl Iterator<Item = &'a Column>) -> String {
    columns.map(|column| format!("{}:n? ", column.key)).collect()
}

fn of_view(name: &str, encoding: Encoding) -> &'static str {
    match name {
        "pose" => "p_world:[n] yaw_rad:n pitch_rad:n? roll_rad:n?",
        "stats" => "bytes_sent:n withheld:n",
        "plan" | "links" => "",
        // A layer.
        _ if encoding == Encoding::GeoJson => "type:s",
        _ => "cell_m:n origin_m:[n] columns:n? maximum:n?",
    }
}

fn of_truth(name: &str) -> &'static str {
    match name {
        "town" => {
            "type:s size_m:[n] center:[n]? scenario:s seed:n agents:n targets:n duration_s:n \
             period_s:n attribution:s?"
        }
        "columns" => "mission:s headline:[s]",
        "metrics" => "violations:n bytes_sent:n alive:[b] late:[b]",
        "lives" => "agent:n event:s incarnation:n",
        _ => "",
    }
}

/// An object with the members `name:type`, where `n` is a number, `s` a string, `b` a boolean, `[…]` an
/// array of them, and `?` says that a member may be absent.
fn object(members: &str) -> Value {
    let (mut properties, mut required) = (serde_json::Map::new(), Vec::new());
    for member in members.split_whitespace() {
        let Some((name, kind)) = member.split_once(':') else { continue };
        let plain = kind.trim_matches(['[', ']', '?']);
        let plain =
            json!({ "type": match plain { "n" => "number", "b" => "boolean", _ => "string" } });
        let is_array = kind.starts_with('[');
        let of = if is_array { json!({ "type": "array", "items": plain }) } else { plain };
        properties.insert(name.to_owned(), of);
        if !kind.ends_with('?') {
            required.push(name);
        }
    }
    json!({ "type": "object", "properties": properties, "required": required })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::set_membership::SetMembership;
    use csat_mission::mission::Whole;

    #[test]
    fn schemas_name_what_can_be_plotted() {
        let kind = Whole::<SetMembership>::KIND;
        let (name, text) = of_topic(&kind, "view/3/stats", Encoding::Json);
        assert_eq!(name, "csat.ViewStats");
        let schema: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(schema["properties"]["unexplored_pct"]["type"], "number");
        let required = schema["required"].as_array().unwrap();
        assert!(required.contains(&"bytes_sent".into()));
        assert!(!required.contains(&"oem_iou_pct".into()));
        let (name, text) = of_topic(&kind, "view/0/beliefs", Encoding::Json);
        assert_eq!(name, "csat.ViewBeliefs");
        assert!(text.contains("\"cell_m\""));
        let (name, text) = of_topic(&kind, "truth/targets", Encoding::Json);
        assert_eq!(name, "csat.TruthTargets");
        let schema: Value = serde_json::from_str(&text).unwrap();
        let items = &schema["properties"]["targets"]["items"]["properties"];
        assert_eq!(items["location"]["items"]["type"], "number");
    }
}
