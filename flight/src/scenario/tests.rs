use std::path::PathBuf;

use super::*;
use crate::testing::scratch;

pub(super) fn load_with(scenario: &str, sets: &[&str]) -> Result<Loaded, Mistakes> {
    let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
    load(Request { scenario: Some(scenario), sets: &sets, seed: None })
}

/// Loads a file of this text, with paths in messages shortened to its name.
fn mistakes_of(text: &str, sets: &[&str]) -> Vec<String> {
    let folder = scratch("scenario");
    let path = folder.join("my.toml");
    std::fs::write(&path, text).unwrap();
    let mistakes = load_with(&path.to_string_lossy(), sets).unwrap_err().mistakes;
    let prefix = format!("{}/", folder.display());
    mistakes.iter().map(|m| m.to_string().replace(&prefix, "")).collect()
}

/// The only mistake of `--set` arguments on the city.
pub(super) fn set_mistake(sets: &[&str]) -> String {
    let mistakes = load_with("city", sets).unwrap_err().mistakes;
    assert_eq!(mistakes.len(), 1, "{}", Mistakes::from(mistakes));
    mistakes[0].to_string()
}

/// The warnings of `--set` arguments on the city.
pub(super) fn warning(sets: &[&str]) -> String {
    let loaded = load_with("city", sets).unwrap_or_else(|mistakes| panic!("{mistakes}"));
    loaded.warnings.iter().map(|w| w.render("warning")).collect()
}

#[test]
fn shipped_scenarios_load_and_survive_being_written_down() {
    let folder = scratch("resolved");
    for name in shipped::scenario_names() {
        let sets = ["netem.radio.range_m=inf", "run.duration_s=90"].map(str::to_owned);
        let first = load(Request { scenario: Some(name), sets: &sets, seed: Some(77) }).unwrap();
        assert_eq!((first.name.as_str(), first.scenario.seed), (name, 77));
        assert_eq!(first.warnings, []);
        let path = folder.join(format!("{name}.toml"));
        std::fs::write(&path, first.scenario.to_toml()).unwrap();
        let second = load_with(&path.to_string_lossy(), &[]).unwrap();
        assert_eq!(second.scenario, first.scenario);
        assert_eq!(second.world.map(), first.world.map());
    }
}

/// `scenarios/city.toml` spells out the defaults that outside checks rely on.
#[test]
fn the_city_is_the_default_scenario() {
    let loaded = load(Request::default()).unwrap();
    assert_eq!(
        (loaded.name.as_str(), loaded.scenario),
        ("city", Scenario { name: "city".into(), ..Scenario::default() })
    );
}

#[test]
fn only_the_default_mission_is_set_beside_the_thesis() {
    let is =
        |scenario, sets: &[&str]| load_with(scenario, sets).unwrap().scenario.is_thesis_setting();
    assert!(is("city", &["seed=9", "run.duration_s=400", "netem.trace=none"]));
    for set in ["guidance.criterion=circles", "agents.count=5", "netem.radio.range_m=100"] {
        assert!(!is("city", &[set]), "{set}");
    }
    assert!(!is("helsinki-05", &[]));
}

#[test]
fn the_real_maps_are_inside_the_program() {
    let loaded = load_with("helsinki-05", &["map.file=helsinki-17.geojson"]).unwrap();
    let file = loaded.scenario.map.file.unwrap();
    assert_eq!(file, PathBuf::from("shipped:helsinki-17.geojson"));
    assert!(loaded.world.map().attribution.as_ref().unwrap().contains("OpenStreetMap"));
}

/// `csat run city --set map.file=...` just works; a contradiction does not.
#[test]
fn naming_a_map_means_it_unless_the_kind_says_otherwise() {
    let file = "map.file=helsinki-05.geojson";
    let loaded = load_with("city", &[file]).unwrap();
    assert_eq!(loaded.scenario.map.kind, csat_world::map::MapKind::GeoJson);
    assert!(loaded.world.map().attribution.is_some());
    for sets in [["map.kind=generated", file], [file, "map.kind=generated"]] {
        assert_eq!(
            set_mistake(&sets),
            "error: `map.file` cannot be `shipped:helsinki-05.geojson` with kind = \"generated\"\n \
             --> --set\n |\n | map.file=helsinki-05.geojson\n |          ^^^^^^^^^^^^^^^^^^^\n = \
             expected kind = \"geojson\" or no file\n"
        );
    }
    let one_file = "[map]\nkind = 'generated'\nfile = 'helsinki-05.geojson'\n";
    let mistakes = mistakes_of(one_file, &[]);
    assert_eq!(mistakes.len(), 1, "{mistakes:?}");
    let folder = scratch("kindless");
    let text = shipped::map("helsinki-05.geojson").unwrap();
    std::fs::write(folder.join("x.geojson"), text).unwrap();
    std::fs::write(folder.join("my.toml"), "[map]\nfile = 'x.geojson'\n").unwrap();
    assert!(load_with(&folder.join("my.toml").to_string_lossy(), &[]).is_ok());
}

#[test]
fn a_map_is_found_beside_its_scenario() {
    let folder = scratch("beside");
    std::fs::create_dir(folder.join("maps")).unwrap();
    let text = shipped::map("helsinki-05.geojson").unwrap();
    std::fs::write(folder.join("maps/mine.geojson"), text).unwrap();
    let path = folder.join("my.toml");
    std::fs::write(&path, "map = { kind = 'geojson', file = 'maps/mine.geojson' }").unwrap();
    let loaded = load_with(&path.to_string_lossy(), &[]).unwrap();
    let expected = folder.join("maps/mine.geojson").canonicalize().unwrap();
    assert_eq!((loaded.name.as_str(), loaded.scenario.map.file), ("my", Some(expected)));
}

#[test]
fn three_mistakes_are_three_messages_with_their_lines() {
    let text = "seed = 1\n\n[camera]\ncolums = 480\nrows = \"many\"\n\n[agents]\ncount = 0\n";
    assert_eq!(
        mistakes_of(text, &[]),
        [
            "error: unknown key `colums` in [camera]\n --> my.toml:4:1\n  |\n4 | colums = 480\n  \
             | ^^^^^^\n  = expected one of `columns`, `rows`, `aperture_deg`, `tilt_deg`, \
             `d_max_m`, `depth_noise`, `min_pixels`, `box_error_px`, `assumption`, \
             `misidentify`\n  = did you mean `columns`?\n"
                .replace(" --> ", "  --> "),
            "error: `camera.rows` cannot be \"many\"\n  --> my.toml:5:8\n  |\n5 | rows = \
             \"many\"\n  |        ^^^^^^\n  = expected a whole number from 1 to 65535\n"
                .to_owned(),
            "error: `agents.count` cannot be 0\n  --> my.toml:8:9\n  |\n8 | count = 0\n  |         \
             ^\n  = expected a whole number from 1 to 1024\n"
                .to_owned(),
        ]
    );
}

#[test]
fn every_kind_of_wrong_value_is_explained() {
    let lines = |text: &str, sets: &[&str]| -> Vec<String> {
        let all = mistakes_of(text, sets);
        all.iter().map(|m| m.lines().next().unwrap_or_default().to_owned()).collect()
    };
    let text = "map = 5\nagents.cuont = 1\n[camra]\na = 1\nb = 2\n[guidance]\ncriterion = 'str9'\n\
                n_mpc = -1\nlambda = [1]\nincrements_deg = 4\n[targets]\nbody_m = [1, 2]\n\
                [netem.radio]\nloss = { model = 'iid', p = true, q = 1 }\ndelay = { mean_s = 'x' }\n";
    assert_eq!(
        lines(text, &[]),
        [
            "error: unknown key `cuont` in [agents]",
            "error: unknown key `camra` in a scenario",
            "error: `guidance.criterion` cannot be `str9`",
            "error: `guidance.increments_deg` cannot be 4",
            "error: `guidance.lambda` cannot be a list",
            "error: `guidance.n_mpc` cannot be -1",
            "error: `map` cannot be 5",
            "error: `netem.radio.delay.mean_s` cannot be \"x\"",
            "error: `netem.radio.loss.p` cannot be true",
            "error: unknown key `q` in [netem.radio.loss]",
            "error: `targets.body_m` cannot be a list of 2",
        ]
    );
    let syntax = mistakes_of(
        "seed = = 1

[map]
file = @
",
        &[],
    )
    .concat();
    for part in ["error: not TOML: ", "my.toml:1:", "my.toml:4:"] {
        assert!(syntax.contains(part), "{part} in {syntax}");
    }
    let model = mistakes_of("[netem.radio]\nloss = { model = 'idd', p = 0.1 }\n", &[]).concat();
    let start = "error: `netem.radio.loss.model` cannot be `idd`\n  --> my.toml:2:18\n  |\n2 | loss = \
                 { model = 'idd', p = 0.1 }\n  |                  ^^^^^\n  = expected ";
    assert!(model.starts_with(start), "{model}");
}

/// An element of a list has an index, and a list that is too short or too long a length.
#[test]
fn values_in_lists_are_found() {
    let zone = |corner: &str| format!("pose.denied=[{{min_m=[0,0],max_m={corner}}}]");
    for (set, found, expected) in [
        ("pose.error=[1, x, 0, 0, 0, 0]", "pose.error[1]` cannot be \"x\"", "a number"),
        ("pose.error=[1, 2, [3], 0, 0, 0]", "pose.error[2]` cannot be a list", "a number"),
        ("pose.error=[1, 2]", "pose.error` cannot be a list of 2", "a list of 6 values"),
        ("pose.error=[1,2,3,4,5,6,7]", "pose.error` cannot be a list of 7", "a list of 6 values"),
        ("pose.error=x", "pose.error` cannot be \"x\"", "a list of 6 values"),
        (&zone("[1, true]"), "pose.denied[0].max_m[1]` cannot be true", "a number"),
        (&zone("[1, 2, 3]"), "pose.denied[0].max_m` cannot be a list of 3", "a list of 2 values"),
        ("guidance.increments_deg=[0, {a=1}]", "guidance.increments_deg[1]` cannot be a table", ""),
        ("agents.count=[1]", "agents.count` cannot be a list", "from 1 to 1024"),
        (
            "netem.partition=[{groups=[[0,1],[2,y]]}]",
            "netem.partition[0].groups[1][1]` cannot be \"y\"",
            "a whole number",
        ),
        ("stations=[{x_m=0,y_m=0,z_m=1}, 5]", "stations[1]` cannot be 5", "a table"),
    ] {
        let said = set_mistake(&[set]);
        let start = format!("error: `{found}\n");
        assert!(said.starts_with(&start) && said.contains(expected), "{set}: {said}");
    }
    let said = set_mistake(&["pose.error=[1, x, 0, 0, 0, 0]"]);
    assert!(said.contains(" | pose.error=[1, x, 0, 0, 0, 0]\n |                ^\n"), "{said}");
}

#[test]
fn a_key_of_another_mission_is_told_of_it() {
    for (scenario, set, help) in [
        (
            "tisdale",
            "pose.error=[1,1,0,0,0,0]",
            "`pose.error` belongs to the mission `set-membership`",
        ),
        (
            "tisdale",
            "guidance.str4.beam=9",
            "`guidance.str4` belongs to the mission `set-membership`",
        ),
        ("city", "pose.sigma=[1,1,1,1,1,1]", "`pose.sigma` belongs to the mission `bayes`"),
    ] {
        let mistakes = load_with(scenario, &[set]).unwrap_err().mistakes;
        let [only] = &mistakes[..] else { panic!("{mistakes:?}") };
        assert!(only.message.starts_with("unknown key"), "{only}");
        assert_eq!(only.help.as_deref(), Some(help), "{only}");
    }
}

#[test]
fn impossible_values_are_explained() {
    for (set, got, expected) in [
        ("run.period_s=0", "0", "a finite number above 0"),
        ("run.duration_s=0.1", "0.1", "at least one period, 0.5 s, and at most 1000000 s"),
        ("map.size_m=[5000, 500]", "[5000, 500]", "two lengths from 20 to 4000 m"),
        ("guidance.str4.n_mpc=0", "0", "a whole number from 1 to 32"),
        ("guidance.str4.n_mpc=33", "33", "a whole number from 1 to 32"),
        ("map.size_m=[10, 500]", "[10, 500]", "two lengths from 20 to 4000 m"),
        ("targets.v_max_m_s=1e9", "1000000000", "a speed from 0 to 100 m/s"),
        ("agents.speed_m_s=300.5", "300.5", "above 0 and up to 300 m/s"),
        ("camera.aperture_deg=1e-5", "0.00001", "an angle from 1 to below 180 degrees"),
        ("guidance.str4.beam=0", "0", "a whole number from 1 to 1024"),
        ("guidance.str4.first_look=1001", "1001", "a whole number from 0 to 1000"),
        ("guidance.str4.first_look=-1", "-1", "a whole number from 0 to 1000"),
        ("guidance.objective=fleet", "fleet", "\"own\", as guidance.criterion is not \"str4\""),
        ("guidance.str4.silent=1.1", "1.1", "a share from 0 to 1"),
        ("guidance.str4.silent=nan", "NaN", "a share from 0 to 1"),
        ("guidance.str4.beam=2000", "2000", "a whole number from 1 to 1024"),
        ("targets.v_max_m_s=-1", "-1", "a speed from 0 to 100 m/s"),
        ("targets.v_max_m_s=inf", "inf", "a speed from 0 to 100 m/s"),
        ("targets.target_distance_m=5", "5", "more than two radii, 5 m, so that cars never touch"),
        ("targets.radius_m=2", "2", "at least half the diagonal of targets.body_m, 2.470 m"),
        ("targets.cylinder_height_m=1", "1", "at least the height of targets.body_m, 1.5 m"),
        ("agents.count=1025", "1025", "a whole number from 1 to 1024"),
        ("agents.speed_m_s=0", "0", "above 0 and up to 300 m/s"),
        (
            "agents.altitude_step_m=0",
            "0",
            "a number other than 0: each UAV has an altitude of its own, except for multirotors",
        ),
        ("agents.altitude_band_m=0", "0", "a finite number above 0"),
        (
            "agents.altitude_m=45",
            "45 (the lowest UAV at 45 m)",
            "all UAVs above the highest building, map.max_height_m = 45 m, or agents.avoid_buildings = true",
        ),
        ("camera.aperture_deg=180", "180", "an angle from 1 to below 180 degrees"),
        (
            "camera.depth_noise=[0.01, 0.02]",
            "[0.01, 0.02]",
            "an interval around 0 that begins above -1",
        ),
        ("camera.depth_noise=[-1, 0]", "[-1, 0]", "an interval around 0 that begins above -1"),
        (
            "camera.tilt_deg=-60",
            "-60 (at 61 m altitude no ground within d_max is seen)",
            "a camera that sees ground nearer than camera.d_max_m",
        ),
        ("estimator.disc_vertices=7", "7", "an even number from 4 to 256"),
        ("guidance.n_mpc=7", "7", "a whole number from 1 to 6"),
        ("guidance.period_s=0.7", "0.7", "a multiple of run.period_s = 0.5 s"),
        ("guidance.plan_timeout_s=0.5", "0.5", "0 or more and below run.period_s = 0.5 s"),
        ("guidance.increments_deg=[]", "empty", "1 to 32 angles from -180 to 180 degrees"),
        (
            "exchange.snapshot_period_s=0.1",
            "0.1",
            "at least run.period_s = 0.5 s and at most 1000000 s",
        ),
        (
            "exchange.snapshot_period_s=1e12",
            "1000000000000",
            "at least run.period_s = 0.5 s and at most 1000000 s",
        ),
        ("exchange.max_age_s=2e6", "2000000", "a time above 0 and up to 1000000 s"),
        ("exchange.clock_skew_s=2e6", "2000000", "a time from 0 to 1000000 s"),
        ("estimator.simplify_margin_m=-1", "-1", "a finite number from 0 on"),
        ("estimator.simplify_margin_m=nan", "NaN", "a finite number from 0 on"),
        ("exchange.max_vertices=3", "3", "a whole number, 4 or more"),
        ("exchange.repair_period_s=0", "0", "at least run.period_s = 0.5 s and at most 1000000 s"),
        ("exchange.repair_delay_s=-1", "-1", "a time from 0 to 1000000 s"),
        ("agents.count=-1", "-1", "a whole number from 1 to 1024"),
        ("agents.count=2.5", "2.5", "a whole number from 1 to 1024"),
        ("agents.count=70000", "70000", "a whole number from 1 to 1024"),
        ("exchange.budget_bytes_s=0", "0", "at least 50 bytes per second, or inf for no limit"),
        ("exchange.channels.plans=far", "`far`", "a radio of [netem]: `radio`"),
    ] {
        let key = set.split('=').next().unwrap();
        let message = set_mistake(&[set]);
        let value_at = " ".repeat(key.len() + 1);
        let carets = "^".repeat(set.len() - key.len() - 1);
        assert_eq!(
            message,
            format!(
                "error: `{key}` cannot be {got}\n --> --set\n |\n | {set}\n | {value_at}{carets}\n \
                 = expected {expected}\n"
            )
        );
    }
}

#[test]
fn links_are_judged_by_netem() {
    let message = set_mistake(&["netem.radio.loss.p=1.5"]);
    assert!(message.contains("netem.radio.loss"), "{message}");
    assert!(message.contains("a probability p between 0 and 1, got 1.5"), "{message}");
    assert!(message.contains(" | netem.radio.loss.p=1.5\n"), "{message}");
}

/// Elements of arrays, in both notations, and values inside inline tables have places of their own.
#[test]
fn mistakes_in_links_are_shown_where_they_are() {
    let text = "[netem]\npartition = [{ groups = [[0, 1], [2, 9]] }]\n[[netem.outage]]\nagent = \
                0\nfrom_s = 5\n[[netem.outage]]\nagent = 1\nfrom_s = 5\nuntil_s = 4\n\
                [netem.far]\nloss = { model = 'gilbert-elliott', p = 0.1, r = 7 }\n\
                [netem.far.rate]\nbytes_s = -1\n[exchange.channels]\nplans = 'far'\n";
    let mistakes = mistakes_of(text, &[]);
    let expected = [
        ("netem.far.rate.bytes_s`: expected a rate above 0", "my.toml:13:11", "-1"),
        ("netem.far.loss.r`: expected a probability r", "my.toml:11:50", "7"),
        ("netem.outage[1].until_s`: expected a time after", "my.toml:9:11", "4"),
        ("netem.partition[0].groups[1][1]`: expected an agent below", "my.toml:2:38", "9"),
    ];
    assert_eq!(mistakes.len(), expected.len(), "{mistakes:?}");
    for (mistake, (message, place, got)) in mistakes.iter().zip(expected) {
        for part in [message, place, &format!("got {got}")] {
            assert!(mistake.contains(part), "{part} in {mistake}");
        }
    }
    // A wrong type is reported alone: indexes of elements are not to be trusted then.
    let mistakes = mistakes_of(&text.replace("agent = 0", "agent = 'zero'"), &[]);
    let about_outages: Vec<&String> = mistakes.iter().filter(|m| m.contains("outage")).collect();
    assert_eq!(about_outages.len(), 1, "{mistakes:?}");
    assert!(about_outages[0].contains("my.toml:4:9"), "{}", about_outages[0]);
    let message = set_mistake(&["netem.outage=[{agent=1,from_s=inf}]"]);
    assert!(message.contains("`netem.outage[0].from_s`"), "{message}");
    // What is missing is missed by the table that lacks it.
    let message = set_mistake(&["netem.radio.loss={model='trace'}"]);
    assert!(message.contains(" | netem.radio.loss={model='trace'}\n"), "{message}");
    let message = set_mistake(&["netem.outages=[]"]);
    assert!(message.contains("unknown key `outages` in [netem]"), "{message}");
    assert!(message.contains("did you mean `outage`?"), "{message}");
}

#[test]
fn traces_are_read_beside_the_scenario_and_kept_in_it() {
    let folder = scratch("trace");
    std::fs::create_dir(folder.join("traces")).unwrap();
    let trace = folder.join("traces/yard.txt");
    let path = folder.join("my.toml");
    let text = "[netem.far]\nloss = { model = 'trace', file = 'traces/yard.txt' }\n\
                [exchange]\nchannels.plans = 'far'\n";
    std::fs::write(&path, text).unwrap();
    let load = || load_with(&path.to_string_lossy(), &[]);
    let refused = |text: &str| {
        std::fs::write(&trace, text).unwrap();
        let mistakes = load().unwrap_err().mistakes;
        assert_eq!(mistakes.len(), 1, "{mistakes:?}");
        mistakes[0].to_string().replace(&format!("{}/", folder.display()), "")
    };
    let missing = load().unwrap_err().mistakes;
    assert_eq!(missing.len(), 1, "{missing:?}");
    let missing = missing[0].to_string();
    assert!(missing.starts_with("error: cannot read the trace `"), "{missing}");
    assert!(missing.contains("my.toml:2:34"), "{missing}");
    assert_eq!(
        refused("0101\n01x1\n"),
        "error: a trace cannot have 'x'\n  --> traces/yard.txt:2:3\n  |\n2 | 01x1\n  |   ^\n  = \
         expected 0, 1, white space or a # comment\n"
    );
    assert!(refused("# nothing\n").contains("expected at least one 0 or 1"));
    std::fs::write(&trace, "0101 # measured\n").unwrap();
    let first = load().unwrap();
    let resolved = folder.join("elsewhere.toml");
    std::fs::remove_file(&trace).unwrap();
    std::fs::write(&resolved, first.scenario.to_toml()).unwrap();
    let second = load_with(&resolved.to_string_lossy(), &[]).unwrap();
    assert_eq!(second.scenario, first.scenario);
    assert!(first.scenario.to_toml().contains("0101 # measured"));
}

#[test]
fn later_values_win_and_are_blamed() {
    let loaded = load_with("city", &["agents.count=2", "agents.count=3"]).unwrap();
    assert_eq!(loaded.scenario.agents.count, 3);
    assert!(load_with("city", &["agents.count=0", "agents.count=3"]).is_ok());
    let message = set_mistake(&["agents.count=3", "agents.count=0"]);
    assert!(message.contains("--> --set\n |\n | agents.count=0\n"), "{message}");
    let whole = load_with("city", &["netem.radio.loss={model='iid',p=0.25}"]).unwrap();
    let part = load_with("city", &["netem.radio.loss.p=0.25"]).unwrap();
    assert_eq!(whole.scenario, part.scenario);
}

#[test]
fn what_cannot_be_found_is_named() {
    let message = load_with("hellsinki-05", &[]).unwrap_err().mistakes[0].to_string();
    assert_eq!(
        message,
        "error: there is no scenario `hellsinki-05`\n  = expected a TOML file or one of `city`, \
         `city-range100`, `city-bursty`, `city-slow`, `city-storm`, `helsinki-05`, \
         `helsinki-17`, `clearing`, `tisdale`\n  = did you mean `helsinki-05`?\n"
    );
    let folder = scratch("folder");
    let message = load_with(&folder.to_string_lossy(), &[]).unwrap_err().mistakes[0].to_string();
    assert!(message.starts_with("error: cannot read the scenario `"), "{message}");
    let message = set_mistake(&["map.kind=geojson", "map.file=no.geojson"]);
    assert!(message.starts_with("error: there is no map `no.geojson`\n --> --set\n"), "{message}");
    assert!(message.contains("`helsinki-05.geojson`"), "{message}");
    assert!(set_mistake(&["map.kind=geojson"]).contains("`map.file` cannot be"));
}

#[test]
fn a_broken_map_is_the_mistake_of_whoever_named_it() {
    let folder = scratch("broken");
    std::fs::write(folder.join("broken.geojson"), "{ \"type\": ").unwrap();
    let path = folder.join("my.toml");
    std::fs::write(&path, "[map]\nkind = 'geojson'\nfile = 'broken.geojson'\n").unwrap();
    let mistakes = load_with(&path.to_string_lossy(), &["agents.count=0"]).unwrap_err().mistakes;
    let text: Vec<String> = mistakes.iter().map(ToString::to_string).collect();
    assert_eq!(text.len(), 2, "{text:?}");
    // The place is that in the map; the scenario that named it is said, too.
    assert!(text[1].starts_with("error: the map broken.geojson is not JSON: EOF"), "{}", text[1]);
    assert!(text[1].contains(" --> broken.geojson:1:"), "{}", text[1]);
    assert!(
        text[1].contains(" = `map.file` is set in ") && text[1].contains("my.toml:3:8"),
        "{}",
        text[1]
    );
}

#[test]
fn a_map_without_room_for_the_cars_is_a_mistake() {
    let message = set_mistake(&["map.size_m=[120, 120]", "targets.count=900"]);
    assert!(message.starts_with("error: targets.count: "), "{message}");
    assert!(message.contains("of 900 cars found room"), "{message}");
    assert!(message.contains(" | targets.count=900\n"), "{message}");
}

#[test]
fn a_coarse_camera_is_a_warning_and_a_useless_one_a_mistake() {
    let loaded = load_with("city", &["camera.columns=240", "camera.rows=180"]).unwrap();
    let warning = loaded.warnings[0].render("warning");
    assert!(
        warning.starts_with(
            "warning: 240 x 180 pixels are coarse for Assumptions 4 and 7: at 61 m altitude a car "
        ),
        "{warning}"
    );
    assert!(warning.contains("expected camera.min_pixels = 8 in the whole footprint"), "{warning}");
    let message = set_mistake(&["camera.columns=48", "camera.rows=36"]);
    assert!(
        message.starts_with(
            "error: 48 x 36 pixels are too coarse: at 61 m altitude a car never has more than "
        ),
        "{message}"
    );
}

/// A name mistyped is a radio of its own, which nobody uses.
#[test]
fn a_radio_that_carries_nothing_is_a_mistake() {
    assert_eq!(
        set_mistake(&["netem.radoi.range_m=10"]),
        "error: radio `radoi` carries nothing: nothing in exchange.channels names it\n --> --set\n \
         |\n | netem.radoi.range_m=10\n |       ^^^^^\n = expected `radio`, or \
         exchange.channels.facts, snapshots or plans = \"radoi\"\n = did you mean `radio`?\n"
    );
    let used = ["netem.far.range_m=10", "exchange.channels.snapshots=far"];
    assert!(load_with("city", &used).is_ok());
}

/// A value that was right until another one was set is told with that other one.
#[test]
fn the_key_that_was_set_is_blamed() {
    let message = set_mistake(&["camera.d_max_m=30"]);
    let start = "error: with this `camera.d_max_m`, `camera.tilt_deg` cannot be 30 (";
    assert!(message.starts_with(start), "{message}");
    assert!(message.contains(" | camera.d_max_m=30\n"), "{message}");
    let message = set_mistake(&["run.period_s=0.3"]);
    let start = "error: with this `run.period_s`, `guidance.plan_timeout_s` cannot be 0.4\n";
    assert!(message.starts_with(start), "{message}");
}

/// A mistake in a list in the file is not that of another key of the table.
#[test]
fn the_list_in_the_file_is_blamed() {
    let folder = scratch("zone");
    let file = folder.join("zone.toml");
    let text =
        "[pose]\nerror = [1, 1, 0, 0, 0, 0]\n[[pose.denied]]\nmin_m = [1, 1]\nmax_m = [0, 0]\n";
    std::fs::write(&file, text).unwrap();
    let mistakes = load_with(&file.to_string_lossy(), &["pose.drift=0.01"]).unwrap_err().mistakes;
    let said = mistakes[0].to_string();
    assert!(said.starts_with("error: `pose.denied[0].max_m` cannot be [0, 0]\n"), "{said}");
    assert!(said.contains("zone.toml:5:9"), "{said}");
}

#[test]
fn all_keys_that_a_model_lacks_are_named_at_once() {
    let message = set_mistake(&["netem.radio.loss={model='markov4',p14=0.5}"]);
    let start = "error: `netem.radio.loss` lacks the keys `p13`, `p31`\n";
    assert!(message.starts_with(start), "{message}");
    let message = set_mistake(&["netem.radio.delay={model='table'}"]);
    assert!(message.starts_with("error: `netem.radio.delay` lacks the key `quantiles_s`\n"));
    let message = set_mistake(&["netem.partition=[{one_way=true}]"]);
    assert!(message.contains("lacks the key"), "{message}");
}

#[test]
fn a_duration_that_is_cut_is_a_warning() {
    let loaded = load_with("city", &["run.duration_s=10.3"]).unwrap();
    assert_eq!(
        loaded.warnings[0].render("warning"),
        "warning: `run.duration_s` = 10.3 s is no multiple of run.period_s = 0.5 s\n --> --set\n \
         |\n | run.duration_s=10.3\n |                ^^^^\n = the mission ends with its last \
         frame, at 10 s\n"
    );
    assert!(
        load_with("city", &["run.duration_s=0.3", "run.period_s=0.1", "guidance.plan_timeout_s=0"])
            .unwrap()
            .warnings
            .is_empty()
    );
}

/// A map that lost its buildings or roads may be why there is no room.
#[test]
fn warnings_of_the_map_are_told_with_its_mistakes() {
    let folder = scratch("point");
    let feature = "{ \"type\": \"Feature\", \"properties\": { \"building\": \"yes\" }, \
                   \"geometry\": { \"type\": \"Point\", \"coordinates\": [24.9, 60.2] } }";
    let map = format!("{{ \"type\": \"FeatureCollection\", \"features\": [{feature}] }}");
    std::fs::write(folder.join("point.geojson"), map).unwrap();
    let path = folder.join("my.toml");
    std::fs::write(&path, "[map]\nfile = 'point.geojson'\n").unwrap();
    let wrong = load_with(&path.to_string_lossy(), &[]).unwrap_err();
    assert_eq!(wrong.mistakes.len(), 1, "{wrong}");
    let text = wrong.to_string();
    assert!(text.contains("0 of 8 cars found room"), "{text}");
    assert!(text.contains("\nwarning: ") && text.contains("Point"), "{text}");
    assert!(text.ends_with("\n1 mistake: nothing was run"), "{text}");
}

/// A file of footprints without tags is flown over when the scenario says what they are.
#[test]
fn untagged_polygons_are_what_the_scenario_says() {
    let folder = scratch("untagged");
    let ring = "[[[24.94, 60.17], [24.9405, 60.17], [24.9405, 60.1702], [24.94, 60.17]]]";
    let feature = |properties: &str, kind: &str, coordinates: &str| {
        format!(
            "{{ \"type\": \"Feature\", \"properties\": {properties}, \
             \"geometry\": {{ \"type\": \"{kind}\", \"coordinates\": {coordinates} }} }}\n"
        )
    };
    let road = "[[24.936, 60.1698], [24.944, 60.1698]]";
    let map = feature("{ \"height\": 12.3 }", "Polygon", ring)
        + &feature("{ \"highway\": \"residential\" }", "LineString", road);
    std::fs::write(folder.join("plain.geojson"), map).unwrap();
    let path = folder.join("my.toml");
    std::fs::write(&path, "[map]\nfile = 'plain.geojson'\n").unwrap();
    let load = |sets: &[&str]| load_with(&path.to_string_lossy(), sets);
    let wrong = load(&[]).unwrap_err().to_string();
    assert!(wrong.contains("map.untagged = \"buildings\" makes them buildings"), "{wrong}");
    let flown = load(&["map.untagged=buildings", "targets.count=2"]).unwrap();
    assert_eq!(flown.world.obstacles()[0].height_m, 12.3);
    let flown = load(&["map.untagged=ignore", "targets.count=2"]).unwrap();
    assert_eq!(flown.world.obstacles().len(), 0);
}

/// The name is a part of a folder's name, and stays when a run is flown again.
#[test]
fn a_scenario_keeps_its_name() {
    let folder = scratch("name");
    let path = folder.join("scenario.resolved.toml");
    let first = load_with("city-slow", &[]).unwrap();
    std::fs::write(&path, first.scenario.to_toml()).unwrap();
    assert_eq!(load_with(&path.to_string_lossy(), &[]).unwrap().name, "city-slow");
    assert!(set_mistake(&["name=../up"]).starts_with("error: `name` cannot be `../up`\n"));
}

#[test]
fn a_number_for_loss_or_delay_is_the_simplest_model() {
    use csat_netem::config::{DelayConfig, LossConfig};
    let radio =
        |scenario: &str, sets: &[&str]| load_with(scenario, sets).unwrap().scenario.netem.radio;
    let simple = radio("city", &["netem.radio.loss=0.3", "netem.radio.delay=2"]);
    assert_eq!(simple.loss, LossConfig::Iid { p: 0.3 });
    assert_eq!(simple.delay, DelayConfig::Constant { mean_s: 2.0 });
    let same =
        ["netem.radio.loss={model=iid,p=0.3}", "netem.radio.delay={model=constant,mean_s=2}"];
    assert_eq!(radio("city", &same), simple);
    // In place of the model of a file, in a file, and under a further value.
    assert_eq!(radio("city-bursty", &["netem.radio.loss=1"]).loss, LossConfig::Iid { p: 1.0 });
    let folder = scratch("shorthand");
    let path = folder.join("my.toml");
    std::fs::write(&path, "[netem.radio]\nloss = 0.2\n").unwrap();
    let path = path.to_string_lossy();
    assert_eq!(radio(&path, &[]).loss, LossConfig::Iid { p: 0.2 });
    assert_eq!(radio(&path, &["netem.radio.loss.p=0.5"]).loss, LossConfig::Iid { p: 0.5 });
}

#[test]
fn a_wrong_number_for_loss_is_underlined() {
    let said = set_mistake(&["netem.radio.loss=1.3"]);
    let place = "--> --set\n |\n | netem.radio.loss=1.3\n |                  ^^^\n";
    assert!(said.contains("netem.radio.loss") && said.contains(place), "{said}");
    for (set, expected) in [
        ("netem.radio.loss=iid", "a number, the probability that a message is lost"),
        ("netem.radio.delay=true", "a number, seconds"),
    ] {
        let said = set_mistake(&[set]);
        assert!(
            said.contains("expected a table such as `{ model = ") && said.contains(expected),
            "{said}"
        );
    }
}

/// Buildings as high as the flights are a mistake, unless UAVs fly around them; then they need a turn for
/// which there is room.
#[test]
fn buildings_may_be_higher_than_flights_that_go_around_them() {
    let load = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        load(Request { sets: &sets, ..Request::default() })
    };
    let high = ["map.min_height_m=20", "map.max_height_m=120"];
    assert!(load(&high).unwrap_err().to_string().contains("all UAVs above the highest building"));
    let around = [&high[..], &["agents.avoid_buildings=true"]].concat();
    let loaded = load(&around).unwrap();
    assert!(loaded.world.obstacles().iter().any(|o| o.height_m > 100.0));
    let gentle = [&around[..], &["guidance.increments_deg=[-20, 0, 20]"]].concat();
    let error = load(&gentle).unwrap_err().to_string();
    assert!(error.contains("a turn in which a UAV needs at most 50 m"), "{error}");
}

/// What is surely slower than real time is told with the value that makes it so, before it flies.
#[test]
fn what_is_slower_than_real_time_is_a_warning() {
    let images = warning(&["camera.columns=4000", "camera.rows=3000", "agents.count=8"]);
    let start = "warning: images of 4000 x 3000 pixels take 8 agents about 0.240 s each every 0.5 s: \
                 slower than real time\n";
    assert!(images.starts_with(start), "{images}");
    assert!(images.contains("so about 0.52 times real time on 2 cores"), "{images}");
    let looks = warning(&["guidance.n_mpc=6"]);
    let start =
        "warning: 39060 looks ahead on 62500 cells take 4 agents about 1.562 s each every 3 s";
    assert!(looks.starts_with(start), "{looks}");
    assert_eq!(warning(&[]), "");
}

/// What makes a promise or a set worse than somebody may think.
#[test]
fn what_is_allowed_but_costs_is_a_warning() {
    let warned = |sets: &[&str], expected: &str| {
        let warnings = load_with("city", sets).unwrap().warnings;
        let said: String = warnings.iter().map(|w| w.render("warning")).collect();
        assert!(said.contains(expected), "{sets:?}: {said}");
    };
    warned(
        &["camera.d_max_m=1e5"],
        "depths are told in steps of 1.53 m, a 65535th of `camera.d_max_m`",
    );
    let crash = "netem.outage=[{agent=0,from_s=5,until_s=15,kind=\"crash\"}]";
    let around = ["agents.avoid_buildings=true", crash];
    warned(&around, "a UAV whose agent has crashed flies straight on, into buildings as well");
}

/// Rays take memory with the square of the cells they go through.
#[test]
fn a_raster_too_fine_for_how_far_guidance_looks_is_a_mistake() {
    let message = set_mistake(&["estimator.raster_cell_m=0.125"]);
    let start = "error: `estimator.raster_cell_m` cannot be 0.125\n";
    assert!(message.starts_with(start), "{message}");
    assert!(message.contains("at least 0.146 m: guidance looks 300 m far, at most 2048 cells"));
    // It looks no farther than there is ground, however far cameras do.
    assert!(load_with("city", &["camera.d_max_m=1e6"]).is_ok());
}
