//! Are limits kept at their value and broken just beyond it, and are wrong budgets refused with their place?

use reports::Error;
use reports::budget::{Baseline, Budget, Checked, Outcome, Severity, csv_text, json_text, text};
use reports::{Report, json, text::Style};

/// The text of a report of three counters with figures and one without, in the frame and in one pass.
fn report_text(frame_time: f64, fetches: u64) -> String {
    let counters = format!(
        r#"{{"frame_time_ms": {{"value": {frame_time:?}, "unit": "ms", "ci95": null, "from": "replay"}},
            "node_fetches": {{"value": {fetches}, "unit": "fetches", "ci95": null, "from": "replay"}},
            "energy_mj": {{"value": 2.5, "unit": "mJ", "ci95": null, "from": "replay"}},
            "restarts": {{"value": null, "unit": "restarts", "ci95": null, "from": "replay", "reason": "No trail."}}}}"#
    );
    format!(
        r#"{{"schema": 1, "tool": "raybudget 0.1.0", "left_out": [],
            "inputs": {{"scene": "s", "gpu": "g", "accel": "bvh", "traversal": "stack", "layout": "padded",
                "technique": "fragment", "width": 1, "height": 1, "seed": null,
                "hashes": {{"scene": "0", "gpu": "0", "costs": "0"}}, "triangles": 1, "ray_sets": ["primary"],
                "sah_costs": [3.0, 1.5], "short_stack": 0, "trail_bits": null}},
            "run": {{"wall_s": 0.0, "peak_rss_bytes": null, "fidelity": "replay", "sampled_fraction": 1.0, "threads": 1}},
            "counters": {counters}, "passes": [{{"name": "primary rays", "counters": {counters}}}]}}"#
    )
}

fn report(frame_time: f64, fetches: u64) -> Report {
    json::read(&report_text(frame_time, fetches), "made").expect("a report")
}

fn limit(rules: &str) -> Budget {
    Budget::parse(&format!("[[limit]]\ncounter = \"node_fetches\"\nhard = {{ {rules} }}\n"), "b.toml")
        .expect("a budget")
}

fn whole(report: Report) -> Baseline {
    Baseline::Report(Box::new(report))
}

/// The budget held against one frame.
fn check(budget: &Budget, report: &Report, baseline: Option<&Baseline>) -> Result<Checked, Error> {
    budget.checked(vec![budget.check("s", report, baseline)?], vec![])
}

fn outcome(rules: &str, fetches: u64, baseline: Option<u64>) -> Outcome {
    let baseline = baseline.map(|fetches| whole(report(1.0, fetches)));
    let checked = check(&limit(rules), &report(1.0, fetches), baseline.as_ref()).expect("a check");
    checked.frames[0].rows[0].outcome
}

/// A limit on the node fetches of a sample, held against 100 with this interval.
fn sampled(rules: &str, ci95: &str, baseline: Option<u64>) -> Checked {
    let text = report_text(1.0, 100).replace("\"replay\"", "\"sampled\"");
    let mut raw: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    raw["counters"]["node_fetches"]["ci95"] = serde_json::from_str(ci95).expect("an interval");
    let report = json::read(&raw.to_string(), "sampled").expect("a report");
    let baseline = baseline.map(|fetches| whole(self::report(1.0, fetches)));
    check(&limit(rules), &report, baseline.as_ref()).expect("a check")
}

#[test]
fn a_sample_leaves_open_what_its_interval_does() {
    for (rules, ci95, baseline, open) in [
        ("max = 110", "[90, 110]", None, false),
        ("max = 109", "[90, 110]", None, true),
        ("max = 89", "[90, 110]", None, false),
        ("max = 90", "[90, 110]", None, true),
        ("min = 90", "[90, 110]", None, false),
        ("min = 91", "[90, 110]", None, true),
        ("max = 100", "[100, 100]", None, false),
        // No interval is known, however far the limit is.
        ("max = 1000000", "null", None, true),
        ("max_increase = \"10 %\"", "[90, 110]", Some(100), false),
        ("max_increase = \"9 %\"", "[90, 110]", Some(100), true),
        ("min_decrease = 50", "[90, 110]", Some(160), false),
        // Nothing is compared, so nothing is open.
        ("max_increase = 0", "[90, 110]", None, false),
    ] {
        let checked = sampled(rules, ci95, baseline);
        assert_eq!(checked.open().count(), usize::from(open), "{rules} {ci95}");
        assert_eq!(checked.frames[0].is_decided(), !open, "{rules} {ci95}");
    }
}

#[test]
fn figures_of_a_sample_are_told_with_how_far_they_may_be_off() {
    let checked = sampled("max = 105", "[90, 110]", None);
    let told = text(&checked, Style::Plain);
    assert!(told.contains(" 100 ± 10.0 % "), "{told}");
    let of_json: serde_json::Value = serde_json::from_str(&json_text(&checked)).expect("JSON");
    let row = &of_json["frames"][0]["rows"][0];
    assert_eq!((&row["ci95"], &row["decided"]), (&serde_json::json!([90.0, 110.0]), &false.into()));
    assert!(csv_text(&checked).lines().nth(1).is_some_and(|row| row.ends_with(",90,110")));

    let unknown = sampled("max = 105", "null", None);
    assert!(text(&unknown, Style::Plain).contains(" 100 ± unknown "));
    assert!(json_text(&unknown).contains("\"ci95\": null"));
    let exact = check(&limit("max = 105"), &report(1.0, 100), None).expect("a check");
    assert!(!text(&exact, Style::Plain).contains('±'));
    assert!(csv_text(&exact).lines().nth(1).is_some_and(|row| row.ends_with(",,,,,")));
}

#[test]
fn the_seed_of_a_sample_makes_no_baseline_stale_and_a_sampled_one_is() {
    let mut drawn = report(1.0, 100);
    drawn.inputs.seed = Some(7);
    let limit = limit("max_increase = 0");
    let checked = check(&limit, &drawn, Some(&whole(report(1.0, 100)))).expect("a check");
    assert_eq!(checked.stale(), [""; 0]);
    drawn.run.fidelity = reports::Fidelity::Sampled;
    let checked = check(&limit, &report(1.0, 100), Some(&whole(drawn))).expect("a check");
    assert_eq!(checked.stale(), ["the baseline's figures are of a sample"]);
}

#[test]
fn a_limit_is_kept_at_its_value_and_broken_one_beyond() {
    assert_eq!(outcome("max = 100", 100, None), Outcome::Pass);
    assert_eq!(outcome("max = 100", 101, None), Outcome::Fail);
    assert_eq!(outcome("min = 100", 100, None), Outcome::Pass);
    assert_eq!(outcome("min = 100", 99, None), Outcome::Fail);
}

#[test]
fn an_absolute_change_is_kept_at_its_value_and_broken_one_beyond() {
    assert_eq!(outcome("max_increase = 5", 105, Some(100)), Outcome::Pass);
    assert_eq!(outcome("max_increase = 5", 106, Some(100)), Outcome::Fail);
    assert_eq!(outcome("max_increase = 5", 1, Some(100)), Outcome::Pass);
    assert_eq!(outcome("max_decrease = 5", 95, Some(100)), Outcome::Pass);
    assert_eq!(outcome("max_decrease = 5", 94, Some(100)), Outcome::Fail);
}

#[test]
fn a_change_in_percent_is_kept_at_its_value_and_broken_one_beyond() {
    assert_eq!(outcome("max_increase = \"10 %\"", 110, Some(100)), Outcome::Pass);
    assert_eq!(outcome("max_increase = \"10%\"", 111, Some(100)), Outcome::Fail);
    assert_eq!(outcome("max_increase = \"0 %\"", 100, Some(100)), Outcome::Pass);
    assert_eq!(outcome("max_decrease = \"10 %\"", 89, Some(100)), Outcome::Fail);
}

#[test]
fn any_growth_from_nothing_breaks_a_limit_in_percent() {
    assert_eq!(outcome("max_increase = \"10 %\"", 0, Some(0)), Outcome::Pass);
    assert_eq!(outcome("max_increase = \"10 %\"", 1, Some(0)), Outcome::Fail);
}

#[test]
fn a_change_without_a_baseline_is_not_compared_and_does_not_fail() {
    assert_eq!(outcome("max_increase = 0", 100, None), Outcome::NotCompared);
    let checked = check(&limit("max_increase = 0"), &report(1.0, 1), None).expect("a check");
    assert_eq!(checked.failures(Severity::Hard), 0);
    assert!(text(&checked, Style::Plain).contains("1 not compared"));
}

#[test]
fn soft_and_hard_failures_are_counted_apart() {
    let budget = "[[limit]]\ncounter = \"frame_time_ms\"\nsoft = { max = 14.0 }\nhard = { max = 16.6 }\n";
    let budget = Budget::parse(budget, "b.toml").expect("a budget");
    let failures = |frame_time| {
        let checked = check(&budget, &report(frame_time, 1), None).expect("a check");
        [checked.failures(Severity::Soft), checked.failures(Severity::Hard)]
    };
    assert_eq!(failures(14.0), [0, 0]);
    assert_eq!(failures(14.1), [1, 0]);
    assert_eq!(failures(16.7), [1, 1]);
}

#[test]
fn a_limit_can_be_set_for_a_pass() {
    let budget = |pass: &str| {
        let text =
            format!("[[limit]]\ncounter = \"node_fetches\"\npass = \"{pass}\"\nhard = {{ max = 1 }}\n");
        check(&Budget::parse(&text, "b.toml").expect("a budget"), &report(1.0, 2), None)
    };
    assert_eq!(budget("primary rays").expect("a check").failures(Severity::Hard), 1);
    let error = budget("secondary").expect_err("no such pass").to_string();
    assert!(error.starts_with("b.toml:4: ") && error.contains("primary rays"), "{error}");
}

#[test]
fn energy_is_limited_as_any_counter_is() {
    for (max, broken) in [("2.5", 0), ("2.49", 1)] {
        let text = format!("[[limit]]\ncounter = \"energy_mj\"\nhard = {{ max = {max} }}\n");
        let budget = Budget::parse(&text, "b.toml").expect("a budget");
        let checked = check(&budget, &report(1.0, 1), None).expect("a check");
        assert_eq!(checked.failures(Severity::Hard), broken, "{max}");
    }
}

#[test]
fn a_limit_on_an_absent_counter_is_an_error_with_the_reason() {
    let budget =
        Budget::parse("[[limit]]\ncounter = \"restarts\"\nhard = { max = 1 }\n", "b.toml").expect("a budget");
    let error = check(&budget, &report(1.0, 1), None).expect_err("no figure").to_string();
    assert!(error.starts_with("b.toml:3: ") && error.contains("No trail"), "{error}");
}

#[test]
fn a_baseline_of_other_inputs_is_called_stale() {
    let mut other = report(1.0, 1);
    let stale = |other: Report| {
        check(&limit("max = 1"), &report(1.0, 1), Some(&whole(other))).expect("a check").stale()
    };
    assert_eq!(stale(other.clone()), Vec::<String>::new());
    other.inputs.gpu = "another".into();
    other.tool = "raybudget 0.0.9".into();
    let stale = stale(other);
    assert_eq!(stale.len(), 2, "{stale:?}");
    assert!(stale[1].contains("inputs.gpu"), "{stale:?}");
}

#[test]
fn wrong_budgets_are_refused_with_file_line_and_remedy() {
    let cases = [
        ("", "b.toml: no limits"),
        ("[[limit]]\ncounter = \"frame_tme_ms\"\nhard = { max = 1 }\n", "b.toml:2: no counter is called"),
        ("\n[[limits]]\ncounter = \"fps\"\n", "b.toml:2: unknown field `limits`"),
        ("[[limit]]\ncounter = \"fps\"\nharsh = { max = 1 }\n", "b.toml:3: unknown field `harsh`"),
        ("[[limit]]\ncounter = \"fps\"\nhard = { maximum = 1 }\n", "b.toml:3: unknown field `maximum`"),
        ("[[limit]]\ncounter = \"fps\"\n", "b.toml:1: the limit on fps has no rule"),
        ("[[limit]]\ncounter = \"fps\"\nhard = {}\n", "b.toml:1: the limit on fps has no rule"),
        ("[[limit]]\ncounter = \"fps\"\nhard = { max = nan }\n", "b.toml:3: a limit of NaN"),
        ("[[limit]]\ncounter = \"fps\"\nhard = { max = inf }\n", "b.toml:3: a limit of inf"),
        ("[[limit]]\ncounter = \"fps\"\nhard = { max_increase = -1 }\n", "b.toml:3: a change of -1"),
        ("[[limit]]\ncounter = \"fps\"\nhard = { max_increase = \"5\" }\n", "b.toml:3: a change of '5'"),
        ("[[limit]]\ncounter = \"fps\"\nhard = { max_increase = true }\n", "b.toml:3: expected a number"),
        ("[[limit]]\nhard = { max = 1 }\n", "b.toml:1: missing field `counter`"),
        ("[[limit]\n", "b.toml:1: "),
        (
            "[[limit]]\ncounter = \"fps\"\nframe = \"x\"\nhard = { max = 1 }\n",
            "b.toml:3: no frame is called 'x'",
        ),
        (
            "[base]\nsize = \"8x8\"\n[[limit]]\ncounter = \"fps\"\nhard = { max = 1 }\n",
            "b.toml:1: [base] without",
        ),
        (
            "[[limit]]\ncounter = \"fps\"\nhard = { max = 1 }\n[[frame]]\nscene = \"x\"\n",
            "b.toml:4: a frame without a name",
        ),
        (
            "[[frame]]\nname = \"a\"\n[[frame]]\nname = \"a\"\n[[limit]]\ncounter = \"fps\"\nhard = { max = 1 }\n",
            "b.toml:3: a second frame called 'a'",
        ),
    ];
    for (text, expected) in cases {
        let error = Budget::parse(text, "b.toml").expect_err(text).to_string();
        assert!(error.starts_with(expected), "{text:?}: {error}");
        assert!(error.contains("; "), "no remedy: {error}");
    }
}

#[test]
fn a_limit_is_for_the_frames_that_have_all_it_names() {
    let selected = |keys: &str| {
        let text = format!(
            "[[limit]]\ncounter = \"fps\"\nhard = {{ min = 0 }}\n[[limit]]\ncounter = \"node_fetches\"\n{keys}\nhard = {{ max = 1 }}\n"
        );
        let text = text.replace("\"fps\"", "\"frame_time_ms\"");
        let budget = Budget::parse(&text, "b.toml").expect("a budget");
        check(&budget, &report(1.0, 2), None).expect("a check").frames[0].rows.len() == 2
    };
    assert!(
        selected("")
            && selected("scene = \"s\"")
            && selected("scene = \"s\"\ngpu = \"g\"\ntechnique = \"fragment\"")
    );
    assert!(
        !selected("scene = \"other\"")
            && !selected("scene = \"s\"\ngpu = \"other\"")
            && !selected("technique = \"f\"")
    );
}

#[test]
fn a_limit_that_is_for_no_frame_is_refused_where_all_are_or_the_budget_names_its_frames() {
    let others = "[[limit]]\ncounter = \"node_fetches\"\nscene = \"other\"\nhard = { max = 1 }\n";
    let refused = |text: &str, name: &str| {
        let budget = Budget::parse(text, "b.toml").expect("a budget");
        let frames = vec![budget.check(name, &report(1.0, 2), None).expect("a check")];
        budget.checked(frames, vec![]).map(drop).map_err(|error| error.to_string())
    };
    let error = refused(others, "s").expect_err("all are for others");
    assert!(
        error.starts_with(
            "b.toml:4: the limit on node_fetches is for none of these frames: s (s on g, fragment)"
        ),
        "{error}"
    );
    let one = format!("{others}[[limit]]\ncounter = \"node_fetches\"\nhard = {{ max = 1 }}\n");
    assert_eq!(refused(&one, "s"), Ok(()));
    let checked =
        check(&Budget::parse(&one, "b.toml").expect("a budget"), &report(1.0, 2), None).expect("a check");
    assert!(
        text(&checked, Style::Plain)
            .contains("1 limits: 1 hard broken, 0 soft broken, 1 more for other frames")
    );
    assert!(refused(&format!("[[frame]]\nname = \"first\"\n{one}"), "first").is_err());
}

#[test]
fn the_nearest_counter_is_suggested() {
    let error = Budget::parse("[[limit]]\ncounter = \"frame_time\"\nhard = { max = 1 }\n", "b.toml")
        .expect_err("unknown");
    assert!(error.to_string().contains("'frame_time_ms'"), "{error}");
}

#[test]
fn the_results_say_the_same_in_every_form() {
    let budget = limit("max = 100, max_increase = \"10 %\"");
    let checked = check(&budget, &report(1.0, 120), Some(&whole(report(1.0, 100)))).expect("a check");
    let table = text(&checked, Style::Plain);
    assert!(table.contains("FAIL") && table.contains("+20.00 (+20.00 %)"), "{table}");
    let json: serde_json::Value = serde_json::from_str(&json_text(&checked)).expect("JSON");
    assert_eq!(json["passed"], false);
    assert_eq!(json["hard_failures"], 2);
    assert_eq!(json["frames"][0]["rows"][1]["change_percent"], 20.0);
    assert!(csv_text(&checked).contains("s,,fail,hard,node_fetches,,max 100,120,fetches,100,20,20"));
}

#[test]
fn the_published_budgets_are_budgets() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../configs/budgets");
    let mut count = 0;
    for entry in std::fs::read_dir(folder).expect("the folder of budgets") {
        let path = entry.expect("an entry").path();
        let text = std::fs::read_to_string(&path).expect("a text");
        Budget::parse(&text, &path.display().to_string()).expect("a budget");
        count += 1;
    }
    assert!(count > 0);
}
