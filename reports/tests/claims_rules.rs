//! Does every rule hold at its limit and fail just beyond it, over how many cases, and with what words?

use reports::claims::{
    ClaimSet, EMBEDDED, Measurements, Outcome, Rule, Verdict, csv_text, json_text, markdown, text,
};
use reports::text::Style;

const HEAD: &str = r#"
[paper]
letter = "Z"
citation = "Anon. 2000"
doi = "10.1/1"
image = [8, 8]
[[scene]]
name = "one"
title = "One"
files = ["one.obj"]
stand_in = "box"
why = "alike"
[[scene]]
name = "two"
title = "Two"
files = []
stand_in = "ball"
why = "alike"
[[scene]]
name = "three"
title = "Three"
files = []
stand_in = "cone"
why = "alike"
[thresholds]
strict = 0.02
[axes]
way = ["a", "b", "c", "d"]
place = ["x", "y"]
[defaults]
way = "a"
place = "x"
[variants]
a = { way = "a" }
b = { way = "b" }
c = { way = "c" }
d = { way = "d" }
x = { place = "x" }
y = { place = "y" }
[sets]
ways = ["a", "b", "c", "d"]
low = ["a", "b"]
high = ["c", "d"]
places = ["x", "y"]
[metrics]
work = { unit = "ops", definition = "operations" }
heat = { unit = "K", definition = "heat" }
"#;

/// What is measured: by scene, way, place and metric.
type Figures<'a> = &'a dyn Fn(&str, &str, &str, &str) -> f64;

fn claims(tests: &str) -> ClaimSet {
    let head = "[[claim]]\nid = \"Z1\"\nstatement = \"It works\"\nwhere = \"1\"\nkind = \"order\"\n";
    let text = format!("{HEAD}\n{head}{tests}");
    ClaimSet::parse(&text, "z.toml").expect("a claim file")
}

fn measured(set: &ClaimSet, figures: Figures<'_>) -> Measurements {
    let mut measurements = Measurements::new();
    for (setup, metrics) in set.needs() {
        for metric in metrics {
            let [way, place] = ["way", "place"].map(|axis| setup.get(axis).expect("an axis"));
            measurements.figure(&setup, &metric, figures(&setup.scene, way, place, &metric));
        }
    }
    measurements
}

fn verdict(tests: &str, figures: Figures<'_>) -> Verdict {
    let set = claims(tests);
    set.evaluate(&measured(&set, figures)).remove(0)
}

/// Whether one test with these keys is reproduced.
fn holds(keys: &str, figures: Figures<'_>) -> bool {
    match verdict(&format!("[[claim.test]]\n{keys}\n"), figures).outcome {
        Outcome::Reproduced => true,
        Outcome::NotReproduced => false,
        Outcome::Untestable => panic!("untestable: {keys}"),
    }
}

fn by_way(way: &str, figures: [f64; 4]) -> f64 {
    figures["abcd".find(way).expect("a way")]
}

#[test]
fn a_number_holds_at_its_tolerance_on_either_side_and_not_beyond() {
    let keys = "rule = \"number\"\nmetric = \"work\"\nof = \"a\"\nfigures = { one = 2, two = 4 }\nscale = 100\nwithin = 0.15";
    let at = |one: f64, two: f64| holds(keys, &move |scene, _, _, _| if scene == "one" { one } else { two });
    assert!(at(200.0, 400.0) && at(230.0, 340.0) && at(170.0, 460.0));
    assert!(!at(230.1, 400.0) && !at(169.9, 400.0) && !at(200.0, 460.1));
}

#[test]
fn an_exact_number_allows_no_error() {
    let keys = "rule = \"number\"\nmetric = \"work\"\nof = \"a\"\nfigures = { one = 48 }\nwithin = 0";
    assert!(holds(keys, &|_, _, _, _| 48.0));
    assert!(!holds(keys, &|_, _, _, _| 48.000_001));
}

#[test]
fn a_number_reports_its_largest_error_and_never_counts_a_stand_in() {
    let test = "[[claim.test]]\nrule = \"number\"\nmetric = \"work\"\nof = \"a\"\nfigures = { one = 100, two = 100 }\nwithin = 0.1\n";
    let set = claims(test);
    let mut measurements = measured(&set, &|scene, _, _, _| if scene == "one" { 95.0 } else { 500.0 });
    let before = set.evaluate(&measurements).remove(0);
    assert_eq!((before.outcome, before.error), (Outcome::NotReproduced, Some(4.0)));
    measurements.stand_in("two", "ball");
    let after = set.evaluate(&measurements).remove(0);
    assert_eq!(after.outcome, Outcome::Reproduced);
    assert!((after.error.expect("an error") + 0.05).abs() < 1e-12);
    assert!(after.why.ends_with("not counted: two: ball"), "{}", after.why);
    measurements.stand_in("one", "box");
    let none = set.evaluate(&measurements).remove(0);
    assert_eq!(none.outcome, Outcome::Untestable);
    assert!(none.why.contains("one: box, two: ball"), "{}", none.why);
}

#[test]
fn a_number_may_be_the_ratio_of_two_variants() {
    let keys =
        "rule = \"number\"\nmetric = \"work\"\nof = \"a\"\nto = \"b\"\nfigures = { one = 1.5 }\nwithin = 0.1";
    let at = |a: f64| holds(keys, &move |_, way, _, _| by_way(way, [a, 2.0, 0.0, 0.0]));
    assert!(at(3.0) && at(3.3) && at(2.7));
    assert!(!at(3.31) && !at(2.69));
    let why = verdict(&format!("[[claim.test]]\n{keys}\n"), &|_, _, _, _| 1.0).why;
    assert!(why.starts_with("work of a / b on one: 1.000 against 1.500 published"), "{why}");
}

#[test]
fn a_contrast_compares_the_smallest_ratio_of_the_one_list_with_the_largest_of_the_other() {
    let keys = |lower: &str, higher: &str, effect: f64| {
        format!(
            "rule = \"contrast\"\nmetric = \"work\"\nof = \"x\"\nto = \"y\"\nlower = {lower}\nhigher = {higher}\n\
             effect = {effect:?}\nscenes = [\"one\"]"
        )
    };
    // Of x over y: 1, 2, 3 and 4.
    let figures = |_: &str, way: &str, place: &str, _: &str| match place {
        "x" => by_way(way, [7.0, 4.0, 9.0, 2.0]),
        _ => by_way(way, [7.0, 2.0, 3.0, 0.5]),
    };
    assert!(holds(&keys("\"low\"", "\"high\"", 0.5), &figures), "3 against 2");
    assert!(!holds(&keys("\"low\"", "\"high\"", 0.51), &figures));
    assert!(!holds(&keys("[\"a\", \"d\"]", "[\"b\", \"c\"]", 0.0), &figures), "2 against 4");
    let set = claims(&format!("[[claim.test]]\n{}\n", keys("\"low\"", "\"high\"", 0.5)));
    assert_eq!(set.needs().len(), 8, "four ways in two places");
    let why = set.evaluate(&measured(&set, &figures)).remove(0).why;
    assert!(why.contains("a 1.000, b 2.000 against c 3.000, d 4.000 (+50 %)"), "{why}");
    assert!(why.contains("{a, b} < {c, d}"), "{why}");
    let nothing = |_: &str, _: &str, place: &str, _: &str| if place == "x" { 1.0 } else { 0.0 };
    let none = verdict(&format!("[[claim.test]]\n{}\n", keys("\"a\"", "\"b\"", 0.0)), &nothing);
    assert_eq!(none.outcome, Outcome::Untestable);
    assert!(none.why.contains("work of y with a on one is 0"), "{}", none.why);
}

#[test]
fn a_swap_needs_two_bests_each_better_at_home() {
    let keys = "rule = \"swap\"\nmetric = \"work\"\namong = \"low\"\nacross = \"places\"\neffect = \"strict\"\nscenes = [\"one\"]";
    let at = |x: [f64; 2], y: [f64; 2]| {
        let figures = move |_: &str, way: &str, place: &str, _: &str| {
            let row = if place == "x" { x } else { y };
            by_way(way, [row[0], row[1], 0.0, 0.0])
        };
        holds(keys, &figures)
    };
    assert!(at([100.0, 102.0], [51.0, 50.0]));
    assert!(!at([100.0, 101.9], [60.0, 50.0]), "the other is as good on one");
    assert!(!at([100.0, 110.0], [50.0, 60.0]), "one best for both");
    let why = verdict(&format!("[[claim.test]]\n{keys}\n"), &|_, _, _, _| 1.0).why;
    assert!(why.contains("least work on one: a with x 1.000, a with y 1.000"), "{why}");
}

#[test]
fn variants_that_are_measured_together_set_different_axes() {
    let head =
        "[[claim]]\nid = \"Z1\"\nstatement = \"It works\"\nwhere = \"1\"\nkind = \"order\"\n[[claim.test]]\n";
    for (keys, expected) in [
        (
            "rule = \"contrast\"\nmetric = \"work\"\nof = \"a\"\nto = \"b\"\nlower = \"c\"\nhigher = \"y\"\neffect = 0",
            "both set axis way",
        ),
        (
            "rule = \"swap\"\nmetric = \"work\"\namong = \"ways\"\nacross = \"x\"\neffect = 0",
            "expected at least 2",
        ),
        (
            "rule = \"swap\"\nmetric = \"work\"\namong = \"a\"\nacross = \"places\"\neffect = 0",
            "expected at least 2",
        ),
    ] {
        let error = ClaimSet::parse(&format!("{HEAD}\n{head}{keys}\n"), "z.toml").expect_err("it is wrong");
        assert!(error.to_string().contains(expected), "{error}");
    }
}

#[test]
fn every_paper_lists_its_statements_in_order_and_says_why_where_nothing_can_be_tested() {
    let counts = [50, 19, 34];
    assert_eq!(EMBEDDED.len(), counts.len());
    for (embedded, count) in EMBEDDED.iter().zip(counts) {
        let set = embedded.parse().expect("a claim file");
        assert_eq!(set.paper.letter, embedded.letter);
        let ids: Vec<&str> = set.claims.iter().map(|claim| claim.id.as_str()).collect();
        let expected: Vec<String> =
            (1..=count).map(|number| format!("{}{number}", embedded.letter)).collect();
        assert_eq!(ids, expected);
        for claim in &set.claims {
            for test in &claim.tests {
                if let Rule::Untestable { reason } = &test.rule {
                    assert!(!reason.trim().is_empty(), "{}", claim.id);
                }
            }
        }
    }
}

#[test]
fn an_order_holds_at_its_effect_and_not_just_below() {
    let keys = "rule = \"order\"\nmetric = \"fps\"\nascending = [\"a\", \"b\", \"c\"]\neffect = \"strict\"";
    let at = |figures: [f64; 3]| {
        holds(keys, &move |_, way, _, _| by_way(way, [figures[0], figures[1], figures[2], 0.0]))
    };
    assert!(at([100.0, 102.0, 104.04]));
    assert!(!at([100.0, 101.99, 110.0]));
    assert!(!at([100.0, 110.0, 112.0]));
    assert!(!at([104.0, 102.0, 100.0]));
}

#[test]
fn every_member_of_a_group_exceeds_every_one_of_the_group_before() {
    let keys = "rule = \"order\"\nmetric = \"fps\"\nascending = [\"low\", \"high\"]\neffect = 0.5";
    assert!(holds(keys, &|_, way, _, _| by_way(way, [1.0, 2.0, 3.0, 9.0])));
    assert!(!holds(keys, &|_, way, _, _| by_way(way, [1.0, 2.0, 9.0, 2.9])));
}

#[test]
fn an_effect_of_zero_holds_for_equals_and_a_negative_one_for_a_small_shortfall() {
    let at_least = "rule = \"order\"\nmetric = \"fps\"\nascending = [\"a\", \"b\"]\neffect = 0";
    assert!(holds(at_least, &|_, _, _, _| 7.0));
    assert!(!holds(at_least, &|_, way, _, _| by_way(way, [7.0, 6.99, 0.0, 0.0])));
    let nearly = "rule = \"order\"\nmetric = \"fps\"\nascending = [\"a\", \"b\"]\neffect = -0.03";
    assert!(holds(nearly, &|_, way, _, _| by_way(way, [100.0, 97.0, 0.0, 0.0])));
    assert!(!holds(nearly, &|_, way, _, _| by_way(way, [100.0, 96.9, 0.0, 0.0])));
}

#[test]
fn growth_from_nothing_exceeds_every_effect_and_nothing_equals_nothing() {
    let keys = "rule = \"order\"\nmetric = \"restarts\"\nascending = [\"a\", \"b\"]\neffect = 0.02";
    assert!(holds(keys, &|_, way, _, _| by_way(way, [0.0, 1.0, 0.0, 0.0])));
    assert!(!holds(keys, &|_, _, _, _| 0.0));
}

#[test]
fn least_and_most_are_judged_against_the_nearest_other() {
    let rule = |rule: &str, effect: f64| {
        format!("rule = \"{rule}\"\nmetric = \"work\"\nof = \"b\"\namong = \"ways\"\neffect = {effect:?}")
    };
    let at = |keys: &str, figures: [f64; 4]| holds(keys, &move |_, way, _, _| by_way(way, figures));
    assert!(at(&rule("least", 0.02), [102.0, 100.0, 500.0, 500.0]));
    assert!(!at(&rule("least", 0.02), [101.9, 100.0, 500.0, 500.0]));
    assert!(at(&rule("most", 0.02), [100.0, 102.0, 1.0, 1.0]));
    assert!(!at(&rule("most", 0.02), [100.0, 101.9, 1.0, 1.0]));
    assert!(at(&rule("most", -0.05), [100.0, 95.0, 1.0, 1.0]));
    assert!(!at(&rule("most", -0.05), [100.0, 94.9, 1.0, 1.0]));
}

#[test]
fn similar_includes_both_ends_of_its_band() {
    let keys = "rule = \"similar\"\nmetric = \"work\"\nof = \"a\"\nto = \"b\"\nratio = [0.5, 1.25]";
    let at = |a: f64| holds(keys, &move |_, way, _, _| by_way(way, [a, 4.0, 0.0, 0.0]));
    assert!(at(2.0) && at(4.0) && at(5.0));
    assert!(!at(1.99) && !at(5.01));
}

#[test]
fn a_correlation_needs_its_sign_and_its_size() {
    let keys = |sign: &str, least: f64| {
        format!(
            "rule = \"correlation\"\nx = \"work\"\ny = \"heat\"\nover = \"ways\"\nsign = \"{sign}\"\nleast = {least:?}"
        )
    };
    let opposite = |_: &str, way: &str, _: &str, metric: &str| match metric {
        "work" => by_way(way, [1.0, 2.0, 3.0, 4.0]),
        _ => by_way(way, [9.0, 8.0, 6.0, 7.0]),
    };
    assert!(holds(&keys("negative", 0.8), &opposite));
    assert!(!holds(&keys("negative", 0.81), &opposite));
    assert!(!holds(&keys("positive", 0.0), &opposite));
    assert!(!holds(&keys("negative", 0.1), &|_, _, _, _| 1.0));
}

#[test]
fn the_strongest_correlation_exceeds_the_others_and_nothing_at_all() {
    let keys = "rule = \"strongest\"\nx = \"work\"\nthan = [\"heat\"]\ny = \"fps\"\nover = \"ways\"\nsign = \"negative\"\neffect = 0.2";
    let with = |work: [f64; 4], heat: [f64; 4]| {
        holds(keys, &move |_, way, _, metric| match metric {
            "work" => by_way(way, work),
            "heat" => by_way(way, heat),
            _ => by_way(way, [4.0, 3.0, 2.0, 1.0]),
        })
    };
    let (full, most, none) = ([1.0, 2.0, 3.0, 4.0], [1.0, 3.0, 2.0, 4.0], [1.0; 4]);
    assert!(with(full, most), "1 against 0.8");
    assert!(!with(most, most), "0.8 against 0.8");
    assert!(!with(most, full), "0.8 against 1");
    assert!(!with(none, [4.0, 3.0, 2.0, 1.0]), "0 against a correlation of the wrong sign");
}

#[test]
fn a_trend_allows_plateaus_but_no_step_back_and_needs_its_effect_in_all() {
    let keys =
        "rule = \"trend\"\nmetric = \"work\"\nalong = \"ways\"\ndirection = \"falling\"\neffect = 0.02";
    let at = |figures: [f64; 4]| holds(keys, &move |_, way, _, _| by_way(way, figures));
    assert!(at([102.0, 102.0, 100.0, 100.0]));
    assert!(!at([101.9, 101.0, 100.0, 100.0]), "too little in all");
    assert!(!at([200.0, 100.0, 101.0, 50.0]), "a step back");
    let rising = keys.replace("falling", "rising");
    assert!(holds(&rising, &|_, way, _, _| by_way(way, [1.0, 2.0, 2.0, 3.0])));
    assert!(!holds(&rising, &|_, way, _, _| by_way(way, [3.0, 2.0, 2.0, 1.0])));
}

#[test]
fn a_shift_compares_ratios_between_scenes() {
    let keys = "rule = \"shift\"\nmetric = \"work\"\nof = \"a\"\nto = \"b\"\nfrom = \"one\"\nscenes = [\"two\"]\ndirection = \"falling\"\neffect = 0.25";
    let at = |there: f64| {
        holds(keys, &move |scene, way, _, _| match (scene, way) {
            ("one", "a") => 10.0,
            ("one", _) => 10.0,
            (_, "a") => there,
            _ => 100.0,
        })
    };
    assert!(at(80.0) && at(79.0), "from 1 to 0.8: 1 exceeds it by a quarter");
    assert!(!at(80.1) && !at(100.0) && !at(120.0));
}

#[test]
fn a_property_keeps_its_bound_on_it_and_not_beyond() {
    let at = |bound: &str, value: f64| {
        let keys = format!("rule = \"property\"\nmetric = \"work\"\nof = \"a\"\n{bound}");
        holds(&keys, &move |_, _, _, _| value)
    };
    assert!(at("equals = 48", 48.0) && !at("equals = 48", 47.0) && !at("equals = 48", 49.0));
    assert!(at("at_least = 0.5", 0.5) && !at("at_least = 0.5", 0.499));
    assert!(at("at_most = 0.05", 0.05) && !at("at_most = 0.05", 0.0501));
}

#[test]
fn a_metric_over_another_is_their_quotient() {
    let keys = "rule = \"property\"\nmetric = \"work / heat\"\nof = \"a\"\nequals = 4";
    assert!(holds(keys, &|_, _, _, metric| if metric == "work" { 8.0 } else { 2.0 }));
    assert!(!holds(keys, &|_, _, _, metric| if metric == "work" { 2.0 } else { 8.0 }));
    let zero = verdict(&format!("[[claim.test]]\n{keys}\n"), &|_, _, _, metric| {
        if metric == "work" { 1.0 } else { 0.0 }
    });
    assert_eq!(zero.outcome, Outcome::Untestable);
    assert!(zero.why.contains("heat is 0"), "{}", zero.why);
}

#[test]
fn quantifiers_count_cases() {
    let order = |holds: &str| {
        format!(
            "rule = \"order\"\nmetric = \"fps\"\nascending = [\"a\", \"b\"]\neffect = 0.02\nholds = \"{holds}\""
        )
    };
    // In as many of the three scenes as `wins` says, b is ahead.
    let with = |quantifier: &str, wins: usize| {
        holds(&order(quantifier), &move |scene, way, _, _| {
            let index = ["one", "two", "three"].iter().position(|name| *name == scene).expect("a scene");
            if (way == "b") == (index < wins) { 2.0 } else { 1.0 }
        })
    };
    assert!(with("all", 3) && !with("all", 2));
    assert!(with("majority", 2) && !with("majority", 1));
    assert!(with("some", 1) && !with("some", 0));
}

#[test]
fn half_is_no_majority() {
    let keys = "rule = \"order\"\nmetric = \"fps\"\nascending = [\"a\", \"b\"]\neffect = 0.02\nholds = \"majority\"\nscenes = [\"one\", \"two\"]";
    assert!(!holds(keys, &|scene, way, _, _| if (way == "b") == (scene == "one") { 2.0 } else { 1.0 }));
}

#[test]
fn a_mean_is_geometric_and_judged_once() {
    let keys = "rule = \"order\"\nmetric = \"fps\"\nascending = [\"a\", \"b\"]\neffect = 0\nholds = \"mean\"\nscenes = [\"one\", \"two\"]";
    // b: 4 x and 1/4 x of a, so equal on the geometric mean; the arithmetic one would be far above.
    let with = |second: f64| {
        holds(keys, &move |scene, way, _, _| match (scene, way) {
            (_, "a") => 1.0,
            ("one", _) => 4.0,
            _ => second,
        })
    };
    assert!(with(0.25));
    assert!(!with(0.2499));
}

#[test]
fn correlations_are_averaged_as_they_are() {
    let keys = "rule = \"correlation\"\nx = \"work\"\ny = \"heat\"\nover = \"ways\"\nsign = \"negative\"\nleast = 0.9\nholds = \"mean\"\nscenes = [\"one\", \"two\"]";
    let with = |second: [f64; 4]| {
        holds(keys, &move |scene, way, _, metric| match (scene, metric) {
            (_, "work") => by_way(way, [1.0, 2.0, 3.0, 4.0]),
            ("one", _) => by_way(way, [4.0, 3.0, 2.0, 1.0]),
            _ => by_way(way, second),
        })
    };
    assert!(with([4.0, 2.0, 3.0, 1.0]), "-1 and -0.8");
    assert!(!with([3.0, 4.0, 1.0, 2.0]), "-1 and -0.6");
}

#[test]
fn each_makes_a_case_of_every_variant_in_every_scene() {
    let test = "[[claim.test]]\nrule = \"order\"\nmetric = \"fps\"\nascending = [\"x\", \"y\"]\neffect = 0.02\neach = \"ways\"\n";
    let set = claims(test);
    assert_eq!(set.claims[0].tests[0].cases.len(), 12);
    assert_eq!(set.setups().len(), 24);
    let verdict = verdict(test, &|scene, way, place, _| match (scene, way, place) {
        ("two", "c", "y") => 0.5,
        (_, _, "y") => 2.0,
        _ => 1.0,
    });
    assert_eq!(verdict.outcome, Outcome::NotReproduced);
    assert_eq!(
        verdict.why,
        "fps on two, c: y 0.5000 < x 1.000 (-50 %); wanted x < y by at least +2 %; holds in 11 of 12 cases"
    );
}

#[test]
fn one_failing_test_fails_the_claim_and_an_undecided_one_leaves_it_open() {
    let property = |metric: &str| {
        format!("[[claim.test]]\nrule = \"property\"\nmetric = \"{metric}\"\nof = \"a\"\nequals = 1\n")
    };
    let open = "[[claim.test]]\nrule = \"untestable\"\nreason = \"it is an opinion\"\n";
    let one = |_: &str, _: &str, _: &str, metric: &str| if metric == "work" { 1.0 } else { 2.0 };
    let both = verdict(&(property("work") + &property("heat")), &one);
    assert_eq!(both.outcome, Outcome::NotReproduced);
    assert!(both.why.starts_with("heat of a on one: 2.000; wanted exactly 1"), "{}", both.why);
    assert!(both.why.ends_with("1 of 2 tests hold"), "{}", both.why);
    let undecided = verdict(&(property("work") + open), &one);
    assert_eq!(undecided.outcome, Outcome::Untestable);
    assert_eq!(undecided.why, "it is an opinion; 1 of 2 tests hold");
    assert_eq!(verdict(&(property("heat") + open), &one).outcome, Outcome::NotReproduced);
}

#[test]
fn what_was_not_measured_makes_a_claim_untestable_and_says_why() {
    let set = claims("[[claim.test]]\nrule = \"property\"\nmetric = \"work\"\nof = \"b\"\nequals = 1\n");
    let why = |measurements: &Measurements| {
        let verdict = set.evaluate(measurements).remove(0);
        assert_eq!(verdict.outcome, Outcome::Untestable);
        verdict.why
    };
    let mut measurements = Measurements::new();
    assert_eq!(why(&measurements), "no work of b on one: it was not measured (and 2 more of 3 cases)");
    for setup in set.setups() {
        measurements.figure(&setup, "work", 1.0);
    }
    assert_eq!(set.evaluate(&measurements)[0].outcome, Outcome::Reproduced);

    let setup = set.setups().into_iter().find(|setup| setup.scene == "two").expect("a setup");
    let mut absent = Measurements::new();
    set.setups().iter().filter(|other| **other != setup).for_each(|other| absent.figure(other, "work", 1.0));
    absent.absent(&setup, "work", "this GPU has none");
    assert_eq!(why(&absent), "no work of b on two: this GPU has none");
    absent.failed(&setup, "the file is missing");
    assert_eq!(why(&absent), "no work of b on two: this GPU has none", "the nearer reason");
    absent.figure(&setup, "work", f64::NAN);
    assert_eq!(why(&absent), "no work of b on two: its figure is NaN");
}

#[test]
fn stand_ins_are_named_and_the_claim_is_also_judged_without_them() {
    let set = claims("[[claim.test]]\nrule = \"property\"\nmetric = \"work\"\nof = \"a\"\nequals = 1\n");
    let mut measurements = measured(&set, &|scene, _, _, _| if scene == "two" { 2.0 } else { 1.0 });
    measurements.stand_in("two", "ball");
    let verdict = set.evaluate(&measurements).remove(0);
    assert_eq!(verdict.outcome, Outcome::NotReproduced);
    assert_eq!(verdict.stand_ins, ["two: ball"]);
    let [reading] = verdict.readings.as_slice() else { panic!("one reading") };
    assert_eq!((reading.name.as_str(), reading.outcome), ("without stand-ins", Outcome::Reproduced));
}

#[test]
fn a_shift_from_a_stand_in_counts_as_one() {
    let keys = "rule = \"shift\"\nmetric = \"work\"\nof = \"a\"\nto = \"b\"\nfrom = \"one\"\nscenes = [\"two\"]\ndirection = \"falling\"\neffect = 0";
    let set = claims(&format!("[[claim.test]]\n{keys}\n"));
    let mut measurements = measured(&set, &|_, _, _, _| 1.0);
    measurements.stand_in("one", "box");
    let verdict = set.evaluate(&measurements).remove(0);
    assert_eq!(verdict.stand_ins, ["one: box"]);
    assert_eq!(verdict.readings[0].outcome, Outcome::Untestable);
}

#[test]
fn readings_replace_axes_variants_metrics_or_tests_and_leave_the_outcome_alone() {
    let test = "[[claim.test]]\nrule = \"property\"\nmetric = \"work\"\nof = \"a\"\nequals = 1\n";
    let reading =
        |name: &str, change: &str| format!("[[claim.reading]]\nname = \"{name}\"\nwhy = \"w\"\n{change}\n");
    let own = "[[claim.reading.test]]\nrule = \"property\"\nmetric = \"work\"\nof = \"a\"\nequals = 2\n";
    let text = test.to_owned()
        + &reading("place", "set = { place = \"y\" }")
        + &reading("way", "variants = { a = \"d\" }")
        + &reading("metric", "metrics = { work = \"heat\" }")
        + &reading("test", own);
    let verdict = verdict(&text, &|_, way, place, metric| match (way, place, metric) {
        ("a", "y", "work") => 10.0,
        ("d", "x", "work") => 20.0,
        ("a", "x", "heat") => 30.0,
        ("a", "x", "work") => 1.0,
        other => panic!("not needed: {other:?}"),
    });
    assert_eq!(verdict.outcome, Outcome::Reproduced);
    let ours: Vec<&str> =
        verdict.readings.iter().map(|reading| reading.ours.as_deref().expect("figures")).collect();
    assert_eq!(
        ours,
        [
            "work of a on one: 10.00",
            "work of d on one: 20.00",
            "heat of a on one: 30.00",
            "work of a on one: 1.000"
        ]
    );
    assert!(verdict.readings.iter().all(|reading| reading.outcome == Outcome::NotReproduced));
}

#[test]
fn the_writers_agree_and_the_json_has_the_agreed_keys() {
    let set = claims(
        "[[claim.test]]\nrule = \"number\"\nmetric = \"work\"\nof = \"a\"\nfigures = { one = 100 }\nwithin = 0.1\n",
    );
    let verdicts = set.evaluate(&measured(&set, &|_, _, _, _| 105.0));
    let json: serde_json::Value =
        serde_json::from_str(&json_text(&set.paper, &verdicts, &serde_json::json!({"wall_s": 1.5})))
            .expect("JSON");
    let row = &json["rows"][0];
    for key in ["id", "statement", "outcome", "ours", "published", "error", "why", "readings", "stand_ins"] {
        assert!(row.get(key).is_some(), "{key}");
    }
    assert_eq!(row["outcome"], "reproduced");
    assert_eq!(row["ours"], "one 105.0");
    assert!((row["error"].as_f64().expect("a number") - 0.05).abs() < 1e-12);
    assert_eq!(json["run"]["wall_s"], 1.5);

    let why = verdicts[0].why.as_str();
    assert_eq!(why, "work of a on one: 105.0 against 100.0 published (+5 %); wanted at most 10 % off");
    assert!(markdown(&set.paper, &verdicts).contains(why));
    assert!(
        text(&set.paper, &verdicts, Style::Plain)
            .contains("1 statements: 1 reproduced, 0 not reproduced, 0 untestable")
    );
    let csv = csv_text(&verdicts);
    let mut table = csv::Reader::from_reader(csv.as_bytes());
    let record = table.records().next().expect("a row").expect("CSV");
    assert_eq!((&record[0], &record[3], &record[7]), ("Z1", "reproduced", why));
}

#[test]
fn no_line_of_the_text_is_longer_than_a_hundred_characters() {
    let set = claims(
        "[[claim.test]]\nrule = \"order\"\nmetric = \"sp_memory_read_bytes_per_second\"\nascending = [\"a\", \"b\", \"c\", \"d\"]\neffect = 0.02\n",
    );
    let verdicts = set.evaluate(&measured(&set, &|_, _, _, _| 123_456_789.0));
    let text = text(&set.paper, &verdicts, Style::Plain);
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
}
