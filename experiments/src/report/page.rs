//! The page around plots and tables.

use super::shapes::escaped;

const STYLE: &str =
    concat!(include_str!("style.css"), include_str!("plot.css"), include_str!("plot_dark.css"));

/// A page of this title (plain text) and body (markup); well-formed XML, too.
pub fn document(title: &str, body: &str) -> String {
    let title = escaped(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n\
         {body}</body>\n</html>\n"
    )
}

/// Names with what there is to say of them (markup).
pub fn definitions(rows: &[(&str, String)]) -> String {
    let rows = rows.iter().map(|(name, value)| format!("<dt>{name}</dt><dd>{value}</dd>\n"));
    format!("<dl>\n{}</dl>\n", rows.collect::<String>())
}

/// A plot (SVG) and the words under it (plain text).
pub fn figure(svg: &str, note: &str) -> String {
    format!("<figure>\n{svg}<figcaption>{}</figcaption>\n</figure>\n", escaped(note))
}

/// Plots side by side where there is room.
pub fn figures(figures: impl Iterator<Item = String>) -> String {
    format!("<div class=\"figures\">\n{}</div>\n", figures.collect::<String>())
}
