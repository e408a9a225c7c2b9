//! Are errors judged on both sides of their limits, and told alike in every form?

use reports::accuracy::{Accuracy, Figures, LIMITS, Point, charts, csv_text, json_text, text};
use reports::text::Style;
use serde_json::{Value, json};

fn figures(frame_time_ms: f64, dram_read_bytes: f64) -> Figures {
    Figures { frame_time_ms, dram_read_bytes, dram_write_bytes: 0.0, run_s: 0.5 }
}

fn point(scene: &str, gpu: &str, time: f64, bytes: f64) -> Point {
    Point {
        scene: scene.to_owned(),
        traversal: "kd-backtrack".to_owned(),
        gpu: gpu.to_owned(),
        ours: figures(time, bytes),
        reference: Figures { run_s: 2.0, ..figures(1.0, 1000.0) },
        deciding_bound: "L2 bandwidth".to_owned(),
    }
}

fn accuracy(points: Vec<Point>) -> Accuracy {
    Accuracy { ours: "quick".to_owned(), reference: "slow".to_owned(), points, limits: LIMITS }
}

#[test]
fn an_error_at_its_limit_is_within_it_and_one_beyond_is_not() {
    let misses = |time: f64, bytes: f64| point("s", "g", time, bytes).misses(&LIMITS).len();
    assert_eq!(misses(1.25, 1000.0), 0);
    assert_eq!(misses(1.2501, 1000.0), 1);
    assert_eq!(misses(0.75, 1000.0), 0);
    assert_eq!(misses(0.7499, 1000.0), 1);
    assert_eq!(misses(1.0, 1029.0) + misses(1.0, 971.0), 0);
    assert_eq!(misses(1.0, 1031.0) + misses(1.0, 969.0), 2);
    assert_eq!(misses(2.0, 2000.0), 2);
    assert_eq!(misses(f64::NAN, 1000.0), 1, "no number is within no limit");
}

#[test]
fn errors_of_both_signs_do_not_cancel_in_a_mean() {
    let accuracy = accuracy(vec![
        point("a", "g", 1.2, 1000.0),
        point("a", "h", 0.9, 1000.0),
        point("b", "g", 0.94, 1010.0),
        point("b", "h", 1.0, 1000.0),
    ]);
    let [mean, worst, dram] = accuracy.statements();
    assert!((mean.found - 0.09).abs() < 1e-12 && mean.holds());
    assert_eq!((worst.at.as_deref(), worst.holds()), (Some("a/kd-backtrack/g"), true));
    assert_eq!((dram.at.as_deref(), dram.holds()), (Some("b/kd-backtrack/g"), true));
    let by_gpu = accuracy.errors_by(|point| &point.gpu);
    let found: Vec<(&str, usize)> =
        by_gpu.iter().map(|errors| (errors.name.as_str(), errors.frames)).collect();
    assert_eq!(found, [("g", 2), ("h", 2)]);
    assert!((by_gpu[0].mean - 0.13).abs() < 1e-12 && (by_gpu[0].worst - 0.2).abs() < 1e-12);
    assert_eq!(accuracy.run_s(), [2.0, 8.0]);
}

#[test]
fn every_form_names_every_frame_and_every_miss() {
    let accuracy = accuracy(vec![point("a", "g", 1.5, 1000.0), point("b", "g", 1.0, 900.0)]);
    let json: Value = serde_json::from_str(&json_text(&accuracy, &json!({"tool": "t"}))).expect("JSON");
    assert_eq!(json["rows"][0]["why"], "frame time +50.0 %, limit 25 %");
    assert_eq!(json["rows"][1]["why"], "DRAM bytes -10.0 %, limit 3 %");
    let outcomes = json["summary"]["rows"].as_array().expect("rows").iter().map(|row| &row["outcome"]);
    assert_eq!(outcomes.collect::<Vec<_>>(), ["fail"; 3]);
    assert_eq!(json["run"]["tool"], "t");
    let csv = csv_text(&accuracy);
    assert!(csv.contains("a/kd-backtrack/g,a,kd-backtrack,g,fail,1.5,1,0.5,"), "{csv}");
    let text = text(&accuracy, Style::Plain);
    assert_eq!(text.matches("  fail\n").count(), 2, "{text}");
    assert!(text.contains("quick 1.000 s, slow 4.000 s, 4.000 times as long"), "{text}");
    let (matrix, bars) = charts(&accuracy, "frames");
    assert_eq!(matrix.values, [[Some(50.0)], [Some(0.0)]]);
    let bars = bars.expect("one GPU");
    assert_eq!(bars.series[0].values, [Some(50.0), Some(0.0)]);
    assert!(matrix.svg().is_ok() && bars.svg().is_ok());
}

#[test]
fn more_gpus_than_colours_leave_out_the_bars_and_keep_the_matrix() {
    let points = |gpus: u32| (0..gpus).map(|gpu| point("a", &format!("g{gpu}"), 1.0, 1000.0)).collect();
    assert!(charts(&accuracy(points(16)), "").1.is_some_and(|bars| bars.svg().is_ok()));
    assert!(charts(&accuracy(points(17)), "").1.is_none());
}
