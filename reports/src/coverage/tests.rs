use super::*;
use crate::picture::tests::{assert_legible, labels};

fn maps<'a>(width: u32, panels: &[&'a [Coverage]]) -> CoverageMaps<'a> {
    let panel =
        |&coverage| CoveragePanel { label: "hierarchical march, from the last position".into(), coverage };
    CoverageMaps {
        title: "Where reflections come from".into(),
        subtitle: "a scene, 512x512, wide-bvh stack, reflections-hybrid-sign with binning octahedral-4x4"
            .into(),
        width,
        panels: panels.iter().map(panel).collect(),
        columns: 4,
    }
}

/// Width, height and pixels of each class.
fn decoded(bytes: Vec<u8>) -> (u32, u32, [usize; ALL.len()]) {
    let mut reader = png::Decoder::new(std::io::Cursor::new(bytes)).read_info().expect("a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("a small picture")];
    let info = reader.next_frame(&mut pixels).expect("a whole PNG");
    let of = |class: Coverage| pixels.chunks_exact(3).filter(|pixel| *pixel == colour(class)).count();
    (info.width, info.height, ALL.map(of))
}

#[test]
fn every_class_has_its_colour_and_its_pixels() {
    let coverage: Vec<Coverage> =
        (0..16 * 16).map(|pixel| ALL[pixel % 16 / 4 + usize::from(pixel >= 128)]).collect();
    let (width, height, found) = decoded(write_png(&maps(16, &[&coverage])).expect("a picture"));
    assert!(width >= 512 + 2 * MARGIN as u32 && height > 512);
    let counts = counts(coverage.iter().copied());
    assert_eq!(counts.iter().sum::<usize>(), coverage.len());
    for ((found, expected), class) in found.into_iter().zip(counts).zip(ALL) {
        // The swatch of the legend is beside them, and the edges of letters are grey.
        let expected = expected * 32 * 32 + (text_height(1) as usize - 2).pow(2);
        assert!(found == expected || class == Coverage::NoSurface && found > expected, "{class:?}");
    }
}

#[test]
fn classes_are_counted_in_their_order() {
    for (place, &class) in ALL.iter().enumerate() {
        assert_eq!(counts(std::iter::once(class))[place], 1);
    }
}

#[test]
fn the_legend_says_the_share_of_each_class() {
    let coverage = [Coverage::Screen, Coverage::QueryHit, Coverage::QueryHit, Coverage::NoSurface];
    let one = maps(2, &[&coverage]);
    let zoom = Zoom::of_single([2, 2]);
    let (sheet, _) = sheet(&one, zoom, [2, 2]);
    let texts: Vec<&str> = labels(&sheet).iter().map(|label| label.text.as_str()).collect();
    for text in ["screen: 25.0 %", "ray query, hit: 50.0 %", "ray query, sky: 0.0 %", "no surface: 25.0 %"] {
        assert!(texts.contains(&text), "{text}: {texts:?}");
    }
}

#[test]
fn no_label_is_clipped_or_meets_another() {
    for side in [3, 40, 600] {
        let coverage = vec![Coverage::QueryMiss; side * side];
        let size = [side as u32; 2];
        for count in 1..=6 {
            let maps = maps(side as u32, &vec![coverage.as_slice(); count]);
            let zoom = if count == 1 { Zoom::of_single(size) } else { Zoom::of_several(size) };
            assert_legible(&sheet(&maps, zoom, size).0);
        }
    }
}

#[test]
fn a_reduced_map_shows_what_most_pixels_are() {
    // Of each 2 x 2 pixels three are of one class.
    let side = 1024_usize;
    let coverage: Vec<Coverage> = (0..side * side)
        .map(|pixel| {
            if pixel % 2 == 0 && (pixel / side).is_multiple_of(2) {
                Coverage::Screen
            } else {
                Coverage::QueryHit
            }
        })
        .collect();
    let (_, _, found) = decoded(write_png(&maps(side as u32, &[&coverage, &coverage])).expect("a picture"));
    assert!(found[1] >= 2 * 512 * 512 && found[0] < 1000, "{found:?}");
}

#[test]
fn what_makes_no_page_is_refused() {
    let three = [Coverage::Screen; 3];
    assert!(write_png(&maps(3, &[])).is_err());
    assert!(write_png(&maps(2, &[&three])).is_err());
    assert!(write_png(&maps(1, &[&three, &three[..2]])).is_err());
    assert!(write_png(&CoverageMaps { columns: 0, ..maps(1, &[&three]) }).is_err());
}

/// How far colours are apart in CIE L*a*b* (1976), D65.
fn distance(a: Rgb, b: Rgb) -> f64 {
    let linear = |channel: u8| {
        let s = f64::from(channel) / 255.0;
        if s <= 0.040_45 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) }
    };
    let lab = |[r, g, b]: [f64; 3]| {
        let x = (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505;
        let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let z = (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089;
        let [x, y, z] = [x, y, z].map(|v| if v > 0.008_856 { v.cbrt() } else { 7.787 * v + 16.0 / 116.0 });
        [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
    };
    let full = |colour: Rgb| colour.map(linear);
    // Protanopia and deuteranopia by Vienot, Brettel and Mollon 1999, on linear sRGB; rows add up to 1, so that greys stay.
    let views: [[[f64; 3]; 3]; 3] = [
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [[0.11238, 0.88762, 0.0], [0.11238, 0.88762, 0.0], [0.00401, -0.00401, 1.0]],
        [[0.29275, 0.70725, 0.0], [0.29275, 0.70725, 0.0], [-0.02234, 0.02234, 1.0]],
    ];
    let of_view = |view: [[f64; 3]; 3]| {
        let seen = |colour: Rgb| {
            let rgb = full(colour);
            let row = |row: [f64; 3]| {
                row.iter().zip(rgb).map(|(weight, channel)| weight * channel).sum::<f64>().max(0.0)
            };
            lab(view.map(row))
        };
        let (a, b) = (seen(a), seen(b));
        a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
    };
    views.map(of_view).into_iter().fold(f64::INFINITY, f64::min)
}

#[test]
fn the_colour_blind_can_tell_the_classes_apart() {
    for (index, &class) in ALL.iter().enumerate() {
        for &other in &ALL[..index] {
            let distance = distance(colour(class), colour(other));
            assert!(distance > 20.0, "{class:?} and {other:?} are {distance} apart");
        }
    }
    // The red and the green of a traffic light are told apart by none of them this well.
    assert!(distance([200, 60, 40], [110, 110, 30]) < 20.0);
}
