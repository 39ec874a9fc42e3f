use std::path::Path;

use super::{figures, html};
use crate::report::axis::XAxis;
use crate::report::chart::Chart;
use crate::sweep::results::tests::made_up;

const PLOT_STYLE: &str = include_str!("../../report/plot.css");

/// The first complaint of a reader that wants every tag closed and every sign escaped.
fn complaint(xml: &str) -> Option<String> {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = xml;
    while let Some(start) = rest.find('<') {
        if rest[..start].contains('>') && open.last() != Some(&"style") {
            return Some(format!("a stray > in {:?}", &rest[..start]));
        }
        let end = rest[start..].find('>').map(|e| start + e)?;
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        if tag.matches('"').count() % 2 == 1 {
            return Some(format!("quotes in <{tag}>"));
        }
        let name = tag.trim_start_matches('/').split([' ', '/', '\n']).next().unwrap_or_default();
        if tag.starts_with('!') || tag.ends_with('/') {
            continue;
        }
        if !tag.starts_with('/') {
            open.push(name);
        } else if open.pop() != Some(name) {
            return Some(format!("</{name}> closes nothing"));
        }
    }
    open.pop().map(|name| format!("<{name}> is not closed"))
}

fn sound(page: &str) {
    assert_eq!(complaint(page), None);
    assert!(!page.contains("NaN") && !page.contains("=\"inf"), "numbers");
    let bare = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for fetch in ["http:", "https:", "url(", "@import", "<script", "<link", "<img", "src="] {
        assert!(!bare.contains(fetch), "{fetch}");
    }
}

#[test]
fn the_checker_itself_complains() {
    assert_eq!(complaint("<a><b/>x</a>"), None);
    assert!(complaint("<a><b></a>").is_some());
    assert!(complaint("<a>1 > 0</a>").is_some());
    assert!(complaint("<a>").is_some());
}

#[test]
fn pages_stand_alone_for_any_number_of_keys() {
    for vary in [
        &[][..],
        &["netem.radio.range_m=25,50,100,200,400,inf"],
        &["netem.radio.loss={model=\"iid\",p=0.1},bad:{model=\"iid\",p=0.5}"],
        &["netem.radio.range_m=25,50", "agents.count=2,4,8"],
        &["a=1,2", "b=x,y", "c=1,2", "d=1,2"],
        &["a=1,2", "b=x,y", "c=1,2,3,4,5,6,7,8,9,10,11,12,13"],
    ] {
        let page = html(&made_up(vary, "1..3"));
        sound(&page);
        assert!(page.contains("<h2>Points</h2>"));
        assert_eq!(page.contains("<h2>Differences within a seed</h2>"), !vary.is_empty());
    }
}

/// Seeds 1, 2 and 4 were flown at both values; by hand from what `made_up` makes up.
#[test]
fn differences_within_a_seed_are_told_with_their_interval_and_count() {
    let results = made_up(&["a=1,2"], "1..4");
    let page = html(&results);
    let start = page.find("Differences within a seed").unwrap();
    let section = &page[start..];
    assert!(section.contains("at a=1: what differs"), "{section}");
    let noise = |number: f64, seed: f64| 2.0 * (seed * 2.7 + number).sin();
    let differences = [(0.0, 1.0), (1.0, 2.0), (3.0, 4.0)]
        .map(|(number, seed)| noise(number + 4.0, seed) - noise(number, seed) - 4.0);
    let expected = crate::stats::stats(&differences).unwrap();
    let [mean, reach] =
        [expected.mean, expected.half_width.unwrap()].map(crate::report::axis::significant);
    assert!(section.contains(&format!("{mean} ± {reach}")), "{mean} ± {reach} in {section}");
    let lower = differences.iter().filter(|d| **d < 0.0).count();
    assert!(section.contains(&format!("{lower} better, {} worse", 3 - lower)), "{section}");
    // A line for each seed, and one in the legend.
    let first = &section[section.find("<svg").unwrap()..section.find("</svg>").unwrap()];
    assert_eq!(first.matches("class=\"seed\"").count(), 4, "{first}");
    assert!(first.contains("Unexplored ground") && first.contains("a=1 (dashed)"));
}

/// With two seeds Student's t is 12.7: a band would cover all else.
#[test]
fn intervals_too_wide_to_draw_are_not_drawn_and_that_is_said() {
    let drawn = |seeds| {
        let page = html(&made_up(&["a=1,2,3"], seeds));
        let has = |what: &str| page.contains(what);
        let shapes = has("class=\"whisker\"") || has("class=\"band\"");
        (
            shapes,
            has("Where n = 1 there is no interval."),
            has("Where n = 2 the interval is too wide"),
        )
    };
    assert_eq!(drawn("5"), (false, true, false));
    assert!(!drawn("5..6").0);
    assert!(drawn("5..6").2);
    assert_eq!(drawn("5..12"), (true, false, false));
}

#[test]
fn what_failed_or_is_missing_is_listed_with_its_command() {
    let page = html(&made_up(&["netem.radio.range_m=25,50"], "1..4"));
    assert!(page.contains("1 run(s) failed"), "{page}");
    assert!(page.contains("panicked at x.rs:1: &lt;wing&gt; &amp; &quot;tail&quot;"));
    assert!(page.contains("1 run(s) missing"));
    assert!(page.contains("1 run(s) violated"));
    assert!(page.contains(
        "<code>csat run city --seed 3 --set run.duration_s=9 --set netem.radio.range_m=25</code>"
    ));
    assert!(page.contains("csat sweep city --vary netem.radio.range_m=25,50 --seeds 1..4"));
    assert!(page.contains("perfect links (dashed)"));
    assert!(page.contains("<td>3 of 4</td>") && page.contains("≥ 270 ± 64.4 (2 of 3 found all)"));
}

fn picture(vary: &[&str], metric: usize) -> String {
    let results = made_up(vary, "1..5");
    let facets = figures::facets(&results).unwrap();
    let x: XAxis = figures::x_axis(&results);
    let chart: Chart<'_> = figures::chart(&results, &facets[0], &results.metrics()[metric], &x);
    let style = format!(
        "<style>{PLOT_STYLE}</style><rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n<title>"
    );
    chart.svg().replacen("<title>", &style, 1)
}

/// `CSAT_PICTURES=DIR cargo test` leaves pictures to look at.
#[test]
fn plots_are_drawn() {
    let range = "netem.radio.range_m=25,50,100,200,400,inf";
    let loss = "netem.radio.loss=none:{p=0},{model=\"iid\",p=0.1},{model=\"gilbert-elliott\",p=0.05,r=0.2}";
    let pictures = [
        ("one", picture(&[range], 0)),
        ("two", picture(&[range, "agents.count=2,4,8"], 0)),
        ("open", picture(&[range], 3)),
        ("few", picture(&["netem.radio.loss.p=0,0.01,0.02,0.1,0.5"], 5)),
        ("words", picture(&[loss, "exchange.mode=facts,snapshot"], 2)),
        ("none", picture(&[], 12)),
    ];
    if let Some(folder) = std::env::var_os("CSAT_PICTURES") {
        let folder = Path::new(&folder);
        for (name, vary, seeds) in [
            ("pairs", &["agents.count=2,4,8", "exchange.mode=facts,snapshot"][..], "1..9"),
            ("links", &[range][..], "1..12"),
            ("two-seeds", &[range][..], "5..6"),
        ] {
            std::fs::write(folder.join(format!("{name}.html")), html(&made_up(vary, seeds)))
                .unwrap();
        }
    }
    for (name, svg) in pictures {
        assert_eq!(complaint(&svg), None, "{name}");
        assert!(svg.contains("class=\"mark\""), "{name}");
        if let Some(folder) = std::env::var_os("CSAT_PICTURES") {
            std::fs::write(Path::new(&folder).join(format!("{name}.svg")), svg).unwrap();
        }
    }
}
