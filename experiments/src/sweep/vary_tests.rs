use super::*;

fn shown_of(argument: &str) -> Vec<String> {
    Axis::parse(argument).unwrap().values.iter().map(Choice::shown).collect()
}

#[test]
fn values_are_split_at_outer_commas_only() {
    let axis = Axis::parse("netem.radio.range_m=25,50, inf").unwrap();
    assert_eq!(axis.keys, ["netem.radio.range_m"]);
    let numbers: Vec<_> = axis.values.iter().map(Choice::number).collect();
    assert_eq!(numbers, [Some(25.0), Some(50.0), Some(f64::INFINITY)]);
    let tables = r#"netem.radio.loss={model="iid",p=0.1},{model="gilbert-elliott",p=0.05,r=0.2}"#;
    assert_eq!(shown_of(tables), ["iid p=0.1", "gilbert-elliott p=0.05 r=0.2"]);
    assert_eq!(shown_of("a.b=[1, 2],[3,4]"), ["[1, 2]", "[3,4]"]);
    assert_eq!(shown_of(r#"a="x,\",y",'\',facts+repair"#), ["x,\",y", "\\", "facts+repair"]);
}

#[test]
fn tables_may_have_labels_and_words_keep_their_colons() {
    assert_eq!(shown_of("a=none:{p=0},bad:{p=1}"), ["none", "bad"]);
    assert_eq!(shown_of("map.file=shipped:x.geojson,C:/y"), ["shipped:x.geojson", "C:/y"]);
}

#[test]
fn keys_may_vary_together() {
    let axis = Axis::parse("a.x, b=(1,2),both:(3,{y=[4,5]})").unwrap();
    assert_eq!(axis.keys, ["a.x", "b"]);
    assert_eq!(axis.values[0].texts, ["1", "2"]);
    assert_eq!(axis.values[1].texts, ["3", "{y=[4,5]}"]);
    assert_eq!(axis.values[0].shown(), "1, 2");
    assert_eq!(axis.values[1].shown(), "both");
}

#[test]
fn what_is_wrong_is_pointed_at() {
    for (argument, message) in [
        ("agents.count", "this varies nothing"),
        ("a b=1", "is no key"),
        ("seed=1,2", "`seed` does not vary like this"),
        ("a=1,,2", "a value is missing"),
        ("a=", "a value is missing"),
        ("a=1,2,1.0", "the value `1.0` is there twice"),
        ("a='x',x", "is there twice"),
        ("a=(1,2", "a bracket is not closed"),
        ("a=1)", "a bracket is closed that was not opened"),
        ("a='1", "a quote is not closed"),
        ("a,b=(1,2),3", "`3` is not 2 values in parentheses"),
        ("a,b=(1,2,3)", "has 3 values for 2 keys"),
    ] {
        let text = Axis::parse(argument).map(|a| a.title()).unwrap_err().to_string();
        assert!(text.contains(message), "{argument}: {text}");
    }
    let text = Axis::parse("a=10,2,10").unwrap_err().to_string();
    assert!(text.contains(" | a=10,2,10\n |        ^^\n"), "{text}");
}

#[test]
fn only_links_are_links() {
    assert!(Axis::parse("netem.radio.range_m=1,2").unwrap().is_netem());
    assert!(!Axis::parse("netem.radio.range_m,agents.count=(1,2)").unwrap().is_netem());
    assert!(!Axis::parse("networks=1").unwrap().is_netem());
}
