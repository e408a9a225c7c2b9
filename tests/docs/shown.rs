//! Output as a page shows it, against what came out.

/// Whether `actual` is what is shown; a line `...` stands for any number of lines, ends of lines do not count.
pub(crate) fn matches(shown: &[&str], actual: &[&str]) -> bool {
    match shown.split_first() {
        None => actual.is_empty(),
        Some((&"...", rest)) => (0..=actual.len()).any(|from| matches(rest, &actual[from..])),
        Some((line, rest)) => actual
            .split_first()
            .is_some_and(|(first, others)| first.trim_end() == line.trim_end() && matches(rest, others)),
    }
}

#[test]
fn three_dots_stand_for_lines_and_for_nothing_else() {
    let actual = ["a", "b  ", "c", "d"];
    for shown in [
        &["a", "b", "c", "d"][..],
        &["..."],
        &["a", "...", "d"],
        &["...", "c", "d"],
        &["a", "...", "b", "c", "d"],
    ] {
        assert!(matches(shown, &actual), "{shown:?}");
    }
    for shown in [&[][..], &["a", "...", "c"], &["a", "b", "c"], &["...", "e"], &["a...", "b", "c", "d"]] {
        assert!(!matches(shown, &actual), "{shown:?}");
    }
}
