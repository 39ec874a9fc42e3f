//! The coordinate reference system that a file names.
//!
//! RFC 7946 allows longitude and latitude of WGS 84 only. Older files, and those of GDAL, name WGS 84
//! in a member `crs` in several spellings; files that name another system have projected coordinates.

use serde_json::Value;

/// The name of the `crs` of a collection or feature, unless it is WGS 84 with the longitude first.
/// `None` also if there is no `crs` or it is `null`.
pub(super) fn foreign(object: &Value) -> Option<String> {
    let crs = object.get("crs").filter(|crs| !crs.is_null())?;
    let property = |key| crs.get("properties").and_then(|p| p.get(key));
    let name = property("name").or_else(|| property("href")).or(Some(crs)).and_then(Value::as_str);
    // {"type": "EPSG", "properties": {"code": 4326}}, of GeoJSON before 2008.
    let code = property("code").map(|code| match code.as_str() {
        Some(text) => format!("EPSG:{text}"),
        None => format!("EPSG:{code}"),
    });
    let Some(name) = name.map(str::to_owned).or(code) else { return Some(crs.to_string()) };
    (!is_wgs84(&name)).then_some(name)
}

/// `urn:ogc:def:crs:OGC:1.3:CRS84`, `EPSG:4326`, `http://www.opengis.net/def/crs/EPSG/0/4326`, …
///
/// EPSG defines 4326 with the latitude first; in GeoJSON the longitude is first under every name.
fn is_wgs84(name: &str) -> bool {
    let name = name.to_ascii_uppercase();
    let tokens: Vec<&str> = name
        .split(|c: char| !c.is_ascii_alphanumeric())
        .filter(|token| !token.is_empty())
        .collect();
    match tokens[..] {
        [.., "CRS84" | "CRS84H" | "WGS84"] | [.., "WGS", "84"] => true,
        // 4979 is 4326 with heights.
        [ref before @ .., "4326" | "4979"] => before.contains(&"EPSG"),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn wgs84_is_known_in_every_usual_spelling() {
        for name in [
            "urn:ogc:def:crs:OGC:1.3:CRS84",
            "urn:ogc:def:crs:OGC::CRS84",
            "urn:ogc:def:crs:OGC::CRS84h",
            "OGC:CRS84",
            "CRS84",
            "EPSG:4326",
            "epsg:4326",
            "urn:ogc:def:crs:EPSG::4326",
            "urn:ogc:def:crs:EPSG:8.9:4326",
            "urn:x-ogc:def:crs:EPSG:4326",
            "http://www.opengis.net/def/crs/OGC/1.3/CRS84",
            "http://www.opengis.net/def/crs/EPSG/0/4326",
            "http://www.opengis.net/gml/srs/epsg.xml#4326",
            "EPSG:4979",
            "WGS 84",
            "WGS84",
        ] {
            let object = json!({ "crs": { "type": "name", "properties": { "name": name } } });
            assert_eq!(foreign(&object), None, "{name}");
        }
        for crs in [
            json!(null),
            json!("EPSG:4326"),
            json!({ "type": "EPSG", "properties": { "code": 4326 } }),
            json!({ "type": "EPSG", "properties": { "code": "4326" } }),
            json!({ "type": "link", "properties":
                { "href": "http://www.opengis.net/def/crs/OGC/1.3/CRS84", "type": "ogcwkt" } }),
        ] {
            assert_eq!(foreign(&json!({ "crs": crs })), None, "{crs}");
        }
        assert_eq!(foreign(&json!({})), None);
    }

    #[test]
    fn all_else_is_named() {
        for name in
            ["EPSG:3857", "urn:ogc:def:crs:EPSG::25832", "4326", "urn:ogc:def:crs:OGC::CRS83", ""]
        {
            let object = json!({ "crs": { "type": "name", "properties": { "name": name } } });
            assert_eq!(foreign(&object).as_deref(), Some(name));
        }
        let code = json!({ "crs": { "type": "EPSG", "properties": { "code": 2154 } } });
        assert_eq!(foreign(&code).as_deref(), Some("EPSG:2154"));
        assert_eq!(foreign(&json!({ "crs": 5 })).as_deref(), Some("5"));
    }
}
