use super::*;
use crate::picture::Mark;
use crate::picture::tests::{Edges, edges, labels, meet};

fn chart(scale: Scale, values: &[&[Option<f64>]]) -> BarChart {
    let names =
        ["push-down", "kd restart with a short stack of four entries in registers", "stack", "<&\"'>"];
    let series = values.iter().enumerate().map(|(index, values)| Series {
        name: format!("{} {index}", names[index % 4]),
        values: values.to_vec(),
    });
    BarChart {
        title: "Frame time".into(),
        subtitle: "all scenes on adreno-540, 1024x1024".into(),
        value_label: "frame time (ms)".into(),
        groups: (0..values[0].len()).map(|index| format!("scene {index} & crytek_sponza")).collect(),
        series: series.collect(),
        scale,
    }
}

/// Every label is legible, and none lies on a bar, not even those of the legend.
fn assert_legible(sheet: &Sheet) {
    crate::picture::tests::assert_legible(sheet);
    let colours: Vec<Rgb> = (0..palette::MOST).map(|series| palette::colour(series).0).collect();
    let bars = sheet.marks.iter().filter_map(|mark| match *mark {
        Mark::Fill { at: (x, y), size: (width, height), colour } if colours.contains(&colour) => {
            Some([x, y, x + width, y + height])
        }
        _ => None,
    });
    let bars: Vec<Edges> = bars.collect();
    for label in labels(sheet) {
        assert!(!bars.iter().any(|&bar| meet(edges(label), bar)), "{label:?} lies on a bar");
    }
}

fn refused(chart: &BarChart) -> String {
    let error = chart.svg().expect_err("no chart");
    assert_eq!(chart.png(), Err(error.clone()));
    error.to_string()
}

#[test]
fn no_label_is_clipped_or_meets_another_whatever_the_size_of_the_chart() {
    for groups in [1, 2, 3, 8, 30] {
        for count in [1, 2, 5, 8, 16] {
            for scale in [Scale::Linear, Scale::Log] {
                let values: Vec<Vec<Option<f64>>> = (0..count)
                    .map(|series| {
                        let value =
                            |group| ((group * 7 + series) % 5 > 0).then_some(1.3 * (group + 1) as f64);
                        (0..groups).map(value).collect()
                    })
                    .collect();
                let values: Vec<&[Option<f64>]> = values.iter().map(Vec::as_slice).collect();
                let mut chart = chart(scale, &values);
                if chart.series.iter().all(|series| series.values.iter().all(Option::is_none)) {
                    chart.series[0].values[0] = Some(1.0);
                }
                assert_legible(&chart.sheet().expect("a chart"));
            }
        }
    }
}

#[test]
fn tiny_huge_equal_and_zero_values_have_legible_axes() {
    let some = |values: &[f64]| values.iter().copied().map(Some).collect::<Vec<_>>();
    for values in [
        &[1e-9, 2e-9][..],
        &[1e12, 3.3e12],
        &[1e-9, 1e12],
        &[123_456.789, 999_999.9],
        &[4.0, 4.0, 4.0],
        &[1e-300, 1e300],
    ] {
        for scale in [Scale::Linear, Scale::Log] {
            assert_legible(&chart(scale, &[&some(values)]).sheet().expect("a chart"));
        }
    }
    let zeros = chart(Scale::Linear, &[&[Some(0.0), Some(0.0)]]).sheet().expect("a chart of zeros");
    assert_legible(&zeros);
}

#[test]
fn every_bar_has_its_figure_and_what_is_absent_is_labelled() {
    let sheet = chart(Scale::Linear, &[&[Some(12.25), None], &[Some(1_234_567.0), Some(0.0)]]);
    let sheet = sheet.sheet().expect("a chart");
    let texts: Vec<&str> = labels(&sheet).iter().map(|label| label.text.as_str()).collect();
    for text in
        ["12.25", "1.235M", "0", "n/a", "n/a: there is no such figure.", "frame time (ms)", "Frame time"]
    {
        assert!(texts.contains(&text), "{text} is not among {texts:?}");
    }
    let whole = chart(Scale::Linear, &[&[Some(1.0)]]).sheet().expect("a chart");
    assert!(labels(&whole).iter().all(|label| !label.text.contains("n/a")));
}

#[test]
fn the_height_of_a_bar_is_its_value() {
    let sheet = chart(Scale::Linear, &[&[Some(1.0), Some(2.0), Some(4.0)]]).sheet().expect("a chart");
    let height = |mark: &Mark| match mark {
        Mark::Fill { size: (_, height), colour, .. } if *colour == palette::colour(0).0 => Some(*height),
        _ => None,
    };
    let heights: Vec<i32> = sheet.marks.iter().filter_map(height).collect();
    assert_eq!(heights, [LEAST_PLOT / 4, LEAST_PLOT / 2, LEAST_PLOT, SWATCH]);
}

#[test]
fn text_is_escaped_and_a_control_character_is_a_space() {
    let mut chart = chart(Scale::Linear, &[&[Some(1.0)]]);
    chart.groups = vec!["a <b> & \"c\"\u{1}d".into()];
    let svg = chart.svg().expect("a chart");
    assert!(svg.contains("a &lt;b&gt; &amp; &quot;c&quot; d"), "{svg}");
    assert!(svg.chars().all(|character| character == '\n' || !character.is_control()));
}

#[test]
fn the_same_chart_gives_the_same_bytes() {
    let chart = chart(Scale::Log, &[&[Some(1.0), Some(300.0)], &[None, Some(2.0)]]);
    assert_eq!(chart.svg(), chart.svg());
    assert_eq!(chart.png(), chart.png());
}

#[test]
fn values_that_no_bar_can_show_are_refused() {
    for (value, what) in [(-1.0, "negative"), (f64::NAN, "finite"), (f64::INFINITY, "finite")] {
        let message = refused(&chart(Scale::Linear, &[&[Some(1.0), Some(value)]]));
        assert!(message.contains(what) && message.contains("Frame time"), "{message}");
    }
    assert!(refused(&chart(Scale::Log, &[&[Some(0.0)]])).contains("logarithmic"));
    assert!(chart(Scale::Linear, &[&[Some(0.0)]]).svg().is_ok());
}

#[test]
fn charts_without_a_figure_or_of_another_shape_are_refused() {
    assert!(refused(&chart(Scale::Linear, &[&[None, None]])).contains("no figure"));
    let mut odd = chart(Scale::Linear, &[&[Some(1.0)]]);
    odd.groups.push("one more".into());
    assert!(refused(&odd).contains("1 values for 2 groups"));
    let many = |count| vec![&[Some(1.0)][..]; count];
    assert!(refused(&chart(Scale::Linear, &many(palette::MOST + 1))).contains("17 series"));
    assert!(chart(Scale::Linear, &many(palette::MOST)).svg().is_ok());
}
