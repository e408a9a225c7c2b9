//! Which pages does a TLB behind the caches know?

use cachesim::{Access, Hierarchy, Levels, LineId, PathId, TlbConfig};

const PAGE: u64 = 4096;

/// One line of cache, so that nearly everything reaches memory, and a TLB of so many pages.
fn hierarchy(entries: u32) -> (Hierarchy, PathId) {
    let text = "[[level]]\nname = \"L1\"\nsize = 64\nline = 64\nways = 1\npolicy = \"lru\"\n";
    let levels = Levels::parse(text, "one-line.toml").expect("valid");
    let (hierarchy, path) = Hierarchy::chain(&levels).expect("one level");
    (hierarchy.with_tlb(TlbConfig { page_bytes: PAGE, entries }), path)
}

fn walks(entries: u32, pages: &[u64]) -> u64 {
    let (mut hierarchy, path) = hierarchy(entries);
    // Another line of the page each time, so that the cache never has it.
    let lines = pages.iter().enumerate().map(|(turn, page)| LineId::new(page * PAGE / 64 + turn as u64 % 64));
    let lines: Vec<LineId> = lines.collect();
    hierarchy.read(path, 0, &lines);
    assert_eq!(hierarchy.memory().reads, pages.len() as u64);
    hierarchy.page_walks()
}

#[test]
fn as_many_pages_as_entries_are_walked_for_once_and_one_more_each_time() {
    let around = |pages: u64| (0..10 * pages).map(|turn| turn % pages).collect::<Vec<_>>();
    assert_eq!(walks(8, &around(8)), 8);
    assert_eq!(walks(8, &around(9)), 90);
}

#[test]
fn the_page_used_last_is_replaced_last() {
    assert_eq!(walks(2, &[0, 1, 0, 2, 0, 1]), 4);
    assert_eq!(walks(1, &[0, 0, 1, 0]), 3);
}

#[test]
fn a_line_that_a_cache_has_needs_no_translation_and_without_a_tlb_none_does() {
    let (mut hierarchy, path) = hierarchy(1);
    let line = |line| [LineId::new(line)];
    hierarchy.read(path, 0, &line(0));
    hierarchy.read(path, 0, &line(0));
    assert_eq!((hierarchy.page_walks(), hierarchy.memory().reads), (1, 1));

    let mut requests = Vec::new();
    hierarchy.follow(path, 0, Access::read(LineId::new(64)), &mut requests);
    hierarchy.follow(path, 0, Access::read(LineId::new(65)), &mut requests);
    assert_eq!(requests.iter().map(|request| request.walks).collect::<Vec<_>>(), [true, false]);
    hierarchy.reset();
    assert_eq!(hierarchy.page_walks(), 0);

    let (plain, path) = Hierarchy::chain(hierarchy.levels()).expect("one level");
    let mut plain = plain;
    plain.read(path, 0, &line(0));
    assert_eq!(plain.page_walks(), 0);
}
