//! What the columns and fields of a run folder's files mean: the source of the tables of
//! docs/outputs.md, and of the header of `links.csv`.

use csat_mission::measures::{Column, Milestone, Of};
use csat_mission::mission::Kind;

/// A column of a table or a field of a JSON document.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Field {
    /// Its name; fields within fields behind a dot, `[]` for each element of an array, `*` for each
    /// key of a map.
    pub key: String,
    /// Its unit; `%` are per cent of the area of the ground, φ(X_g), where nothing else is said.
    pub unit: &'static str,
    /// Whose it is, and what it is a mean over.
    pub of: &'static str,
    /// What it is.
    pub title: &'static str,
    /// Equation, table or figure that defines it; empty for what is ours.
    pub source: &'static str,
}

/// A file of the run folder.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Its name.
    pub name: &'static str,
    /// Its columns or fields, in order.
    pub fields: Vec<Field>,
}

type Row = (&'static str, &'static str, &'static str, &'static str, &'static str);

/// `metrics.csv`, before an agent's values.
const HEAD: &[Row] = &[
    ("step", "", "step", "k, from 0", ""),
    ("time_s", "s", "step", "simulated time, k·T", ""),
    ("agent", "", "agent", "i, its index", ""),
    ("x_m", "m", "agent", "true position of its UAV, east", ""),
    ("y_m", "m", "agent", "true position of its UAV, north", ""),
    ("z_m", "m", "agent", "true position of its UAV, above the ground", ""),
    ("yaw_rad", "rad", "agent", "true heading of its UAV, counter-clockwise from east", ""),
];

/// Between an agent's values and the fleet's.
const MIDDLE: &[Row] = &[
    (
        "bytes_sent",
        "B",
        "agent, as sender",
        "sent in this step, each message once however many hear it",
        "",
    ),
    (
        "violations",
        "",
        "agent",
        "failures of the guarantee found in it at this step",
        "[guarantee](concepts/guarantee.md)",
    ),
];

/// The last column.
const ROLE: &[Row] = &[("role", "", "agent", "`uav`, or `station` for a ground station", "")];

/// `links.csv`.
const LINKS: &[Row] = &[
    ("src", "", "link", "the sender", ""),
    ("dst", "", "link", "the receiver", ""),
    ("channel", "", "link", "the radio, by index: 0 is `[netem.radio]`", ""),
    ("sent", "messages", "link", "handed over", ""),
    ("delivered", "messages", "link", "arrived, copies and damaged ones included", ""),
    ("duplicated", "messages", "link", "further copies that the link made", ""),
    ("corrupted", "messages", "link", "of what arrived, damaged", ""),
    ("in_flight", "messages", "link", "still on their way at the end", ""),
    ("bytes_sent", "B", "link", "handed over", ""),
    ("bytes_delivered", "B", "link", "of what arrived, copies and damaged ones included", ""),
    ("mean_delay_s", "s", "link, mean over what arrived", "from sending to arrival", ""),
    (
        "mean_distance_m",
        "m",
        "link, mean over what was sent",
        "between sender and receiver at the time of sending",
        "",
    ),
    ("dropped_no_channel", "messages", "link", "lost: the scenario has no such radio", ""),
    ("dropped_outage", "messages", "link", "lost: the sender was out, or the receiver", ""),
    ("dropped_partition", "messages", "link", "lost: the ends were kept apart", ""),
    ("dropped_range", "messages", "link", "lost: too far", ""),
    ("dropped_propagation", "messages", "link", "lost: too weak", ""),
    ("dropped_jamming", "messages", "link", "lost: the receiver was jammed", ""),
    ("dropped_loss", "messages", "link", "lost at random", ""),
    ("dropped_queue", "messages", "link", "lost: the sender's queue was full", ""),
];

/// Lines of `events.jsonl`, by the value of `event`.
const EVENTS: &[Row] = &[
    ("*.event", "", "line", "what happened: the first word of the rows below", ""),
    ("*.step", "", "line", "k, in which it happened, or of which the knowledge is", ""),
    (
        "*.time_s",
        "s",
        "line",
        "simulated time: of a message when it was sent, of all else that of the step that took note",
        "",
    ),
    ("identified.agent", "", "agent", "that knows of a target for the first time", ""),
    ("identified.target", "", "agent", "j", ""),
    (
        "identified.by_others",
        "",
        "agent",
        "whether another agent's camera saw it, true or false",
        "",
    ),
    ("inconsistent.agent", "", "agent", "whose set became empty and was begun again", ""),
    ("inconsistent.target", "", "agent", "j", ""),
    (
        "liar.agent",
        "",
        "agent",
        "that has proven another one, or itself, to have said something false, and ignores it from now on \
         ([liars](liars.md))",
        "",
    ),
    ("liar.liar", "", "agent", "who said it", ""),
    (
        "rejected.agent",
        "",
        "agent, as receiver",
        "that did not believe a message, or a frame of its own: once for each sender and reason",
        "",
    ),
    (
        "rejected.from",
        "",
        "sender",
        "null for a frame, and where a message is too damaged to tell",
        "",
    ),
    ("rejected.reason", "", "agent, as receiver", "a short name", ""),
    ("rejected.detail", "", "agent, as receiver", "what was wrong, with values", ""),
    ("crashed.agent", "", "agent", "whose life ended", ""),
    ("crashed.incarnation", "", "agent", "that life, from 0", ""),
    ("restarted.agent", "", "agent", "whose life began", ""),
    ("restarted.incarnation", "", "agent", "that life", ""),
    ("drop.src", "", "sender", "of a message that was lost", ""),
    ("drop.dst", "", "receivers", "that lost it for the same reason, a list", ""),
    ("drop.channel", "", "sender", "the radio, by index", ""),
    ("drop.sequence", "", "sender", "its number among the sender's messages on that radio", ""),
    ("drop.reason", "", "receivers", "why ([links](links.md))", ""),
    ("delivery.src", "", "sender", "of a message that arrives (with `netem.trace = \"all\"`)", ""),
    ("delivery.dst", "", "receivers", "that get it after the same time, a list", ""),
    ("delivery.channel", "", "sender", "the radio, by index", ""),
    ("delivery.sequence", "", "sender", "its number among the sender's messages on that radio", ""),
    ("delivery.delay_s", "s", "receivers", "from sending to arrival", ""),
    ("delivery.corrupted", "", "receivers", "whether it is damaged, true or false", ""),
    (
        "delivery.duplicate",
        "",
        "receivers",
        "whether it is a copy that the link made, true or false",
        "",
    ),
    (
        "violation.kind",
        "",
        "monitor",
        "the promise that was broken, as below `checked` of the summary, with hyphens",
        "",
    ),
    ("violation.agent", "", "agent", "that ruled out where a target is", ""),
    ("violation.named", "", "agent", "an honest one that it has named as a liar", ""),
    ("violation.target", "", "target", "j, the target that it is about", ""),
    ("violation.location", "m", "target", "[east, north], where it is", ""),
    ("violation.obstacle", "", "target", "index of the obstacle that it is too near to", ""),
    ("violation.a", "", "target", "the one of two that are too near to each other", ""),
    ("violation.b", "", "target", "the other", ""),
    ("violation.distance_m", "m", "target", "to the obstacle, or between the two", ""),
    ("violation.limit_m", "m", "target", "what the distance has to exceed, or the way may not", ""),
    ("violation.moved_m", "m", "target", "the way it went since the check before", ""),
    ("violation.counts.*", "messages", "fleet", "the counts that do not add up", ""),
];

/// `summary.json`, without means.
const SUMMARY: &[Row] = &[
    ("mission", "", "run", "the kind of mission", ""),
    ("scenario", "", "run", "name of the scenario", ""),
    ("seed", "", "run", "its seed", ""),
    ("agents", "", "fleet", "N^u, how many there are", ""),
    ("targets", "", "run", "N^t, how many there are", ""),
    (
        "thesis_setting",
        "",
        "run",
        "whether the setting is that of the thesis's missions under (5.32), so that its numbers may be \
         set beside the published ones, true or false",
        "thesis §5.4",
    ),
    ("steps", "", "run", "steps flown after step 0", ""),
    ("interrupted", "", "run", "whether the user ended it early, true or false", ""),
    ("violations", "", "monitor", "failures of what is promised", ""),
    ("checks", "", "monitor", "of how many checks", ""),
    ("unchecked", "reports", "fleet", "that came too late to be checked (only in real time)", ""),
    (
        "checked.*.checks",
        "",
        "monitor",
        "checks of one promise: `guarantee` (each target lies in the set of each honest agent), `accusation` (honest \
         agents name liars only; only where some are named), \
         `obstacle_distance`, `target_distance`, `outside_region`, `speed`, `building_distance`, `message_conservation`",
        "thesis (3.8), (3.11)",
    ),
    ("checked.*.violations", "", "monitor", "of those, how many found it broken", ""),
    (
        "inconsistencies",
        "",
        "fleet",
        "sets of honest agents that became empty: an assumption failed or an agent lied",
        "",
    ),
    (
        "liars[].agent",
        "",
        "agent",
        "that an honest one named as a liar; no `liars` if none was",
        "",
    ),
    ("liars[].first_s", "s", "agent", "when it was named first", ""),
    ("liars[].named_by", "", "agents", "by which honest ones, the first ones first", ""),
    ("stations[].agent", "", "station", "its number among the agents: after the UAVs", ""),
    ("stations[].x_m", "m", "station", "its place, east", ""),
    ("stations[].y_m", "m", "station", "its place, north", ""),
    ("stations[].z_m", "m", "station", "its place, above the ground", ""),
    ("stations[].sent_to", "messages", "station, as receiver", "on their way to it", ""),
    ("stations[].delivered_to", "messages", "station, as receiver", "of those, arrived", ""),
    (
        "frames[].shown",
        "frames",
        "agent, by index",
        "that its camera took, but for those while the scenario had it down",
        "",
    ),
    (
        "frames[].missed",
        "frames",
        "agent, by index",
        "of those, not looked at (only in real time)",
        "",
    ),
    (
        "frames[].silent_s",
        "s",
        "agent, by index",
        "[from, to] of each time in which nothing was heard of its process (only in real time)",
        "",
    ),
    (
        "refused.*",
        "samples",
        "processes of the fleet",
        "said to them by strangers or against the rules and not believed, by kind",
        "",
    ),
    ("messages.sent", "messages", "fleet, by receiver", "one to three others counts three", ""),
    ("messages.delivered", "messages", "fleet, by receiver", "arrived", ""),
    (
        "messages.dropped.*",
        "messages",
        "fleet, by receiver",
        "lost, by reason ([links](links.md))",
        "",
    ),
    ("messages.duplicated", "messages", "fleet, by receiver", "further copies that links made", ""),
    ("messages.corrupted", "messages", "fleet, by receiver", "of what arrived, damaged", ""),
    (
        "messages.in_flight",
        "messages",
        "fleet, by receiver",
        "on their way at the end: sent + duplicated = delivered + dropped + in_flight",
        "",
    ),
    (
        "messages.rejected.*",
        "messages",
        "fleet, by receiver",
        "of what arrived, not believed, by reason",
        "",
    ),
    (
        "messages.withheld",
        "agent-steps",
        "fleet, as senders",
        "not told of: nothing fitted the budget or was worth its bytes",
        "",
    ),
    ("bytes_sent", "B", "fleet, as senders", "each message once, however many hear it", ""),
    (
        "timing_ms.*.median",
        "ms",
        "agent-step, median",
        "what a stage took: `render` (the world's), `sense`, `estimate`, `fuse`, `guidance` (per decision)",
        "thesis figure 5.15",
    ),
    ("timing_ms.*.p95", "ms", "agent-step, 95th percentile", "the same", ""),
    ("timing_ms.*.max", "ms", "agent-step, maximum", "the same", ""),
    ("wall_s", "s", "run", "what it took", ""),
    ("sim_s", "s", "run", "what it simulated", ""),
    ("realtime_factor", "", "run", "sim_s / wall_s", ""),
    (
        "digest",
        "",
        "run",
        "hash of the state of every agent at every step: equal digests, equal runs",
        "",
    ),
];

/// All files of a kind of mission, with their columns and fields.
pub fn files(kind: &Kind) -> Vec<File> {
    let file = |name, rows: &[Row]| File { name, fields: rows.iter().map(field).collect() };
    let mut summary = file("summary.json", SUMMARY);
    summary.fields.extend(of_summary(kind));
    let metrics = File { name: "metrics.csv", fields: of_metrics(kind) };
    vec![metrics, file("links.csv", LINKS), file("events.jsonl", EVENTS), summary]
}

/// What a kind of mission has in its files that `usual` has not, or has otherwise.
pub fn own_files(kind: &Kind, usual: &Kind) -> Vec<File> {
    let own = |(mut file, usual): (File, File)| {
        file.fields.retain(|field| !usual.fields.contains(field));
        file
    };
    let pairs = files(kind).into_iter().zip(files(usual)).map(own);
    pairs.filter(|file| !file.fields.is_empty()).collect()
}

fn of_metrics(kind: &Kind) -> Vec<Field> {
    let of = |of: Of| kind.columns.iter().filter(move |c| c.of == of).map(of_column);
    let common = |rows: &'static [Row]| rows.iter().map(field);
    let all = common(HEAD).chain(of(Of::Agent)).chain(common(MIDDLE)).chain(of(Of::Fleet));
    all.chain(common(ROLE)).collect()
}

fn of_column(column: &Column) -> Field {
    let &Column { key, unit, over, meaning, source, of, .. } = column;
    let of = match (over, of) {
        ("", Of::Agent) => "agent",
        ("", Of::Fleet) => "fleet",
        (over, _) => over,
    };
    Field { key: key.to_owned(), unit, of, title: meaning, source }
}

/// The mission's own numbers in the summary.
fn of_summary(kind: &Kind) -> Vec<Field> {
    let mut fields = Vec::new();
    let last = kind.columns.iter().filter_map(|column| Some((column.last_as?, column)));
    fields.extend(last.map(|(key, column)| Field {
        key: key.to_owned(),
        title: column.meaning,
        of: "fleet, at the end",
        ..of_column(column)
    }));
    let milestone = |prefix: &str, of, m: &Milestone| Field {
        key: format!("{prefix}{}", m.key),
        unit: "s",
        of,
        title: m.meaning,
        source: m.source,
    };
    fields.extend(kind.milestones.iter().map(|m| milestone("", "fleet", m)));
    let of_stations = kind.milestones.iter().filter(|m| m.station.is_some());
    fields.extend(of_stations.map(|m| milestone("stations[].", "station", m)));
    let half =
        "mean over the steps of the second half (t ≥ half of the time flown) and over the agents";
    type Means = (&'static str, &'static str, fn(&Column) -> bool);
    let means: [Means; 4] = [
        ("", half, |column| column.in_summary),
        ("final.", "mean over the agents, at the last step", |column| column.in_summary),
        ("stations[].", "station, mean over the steps of the second half", |c| c.of_stations),
        ("stations[].final.", "station, at the last step", |column| column.of_stations),
    ];
    for (prefix, of, is_there) in means {
        fields.extend(kind.columns.iter().filter(|column| is_there(column)).map(|column| Field {
            key: format!("{prefix}{}", column.key),
            of,
            ..of_column(column)
        }));
    }
    fields
}

/// The columns of `links.csv`.
pub fn link_columns() -> impl Iterator<Item = &'static str> {
    LINKS.iter().map(|row| row.0)
}

fn field(&(key, unit, of, title, source): &Row) -> Field {
    Field { key: key.to_owned(), unit, of, title, source }
}

impl File {
    /// Its fields as a table in Markdown.
    pub fn markdown(&self) -> String {
        let name = if self.name.ends_with(".csv") { "column" } else { "field" };
        let mut text = format!("| {name} | unit | of | what | source |\n|---|---|---|---|---|\n");
        for Field { key, unit, of, title, source } in &self.fields {
            text += &format!("| `{key}` | {unit} | {of} | {title} | {source} |\n");
        }
        text
    }

    /// The field that a key belongs to, with numbers of elements as `[]`.
    pub fn describes(&self, key: &str) -> Option<&Field> {
        let is_same = |field: &&Field| {
            let (wanted, found) = (field.key.split('.'), key.split('.'));
            wanted.clone().count() == found.clone().count()
                && wanted.zip(found).all(|(w, f)| w == "*" || w == f)
        };
        self.fields.iter().find(is_same)
    }
}
