//! Where links lead.

use crate::page::{Kind, Page};
use std::path::{Component, Path, PathBuf};

/// Panics where a relative link of the page leads nowhere.
pub(crate) fn check(page: &Page) {
    for item in &page.items {
        let Kind::Link(target) = &item.kind else { continue };
        if target.contains("://") || target.starts_with("mailto:") {
            continue;
        }
        let place = page.place(item);
        let (file, anchor) = target.split_once('#').unwrap_or((target, ""));
        let folder = Path::new(&page.name).parent().expect("a file has a folder");
        let path = if file.is_empty() { PathBuf::from(&page.name) } else { normal(&folder.join(file)) };
        assert!(crate::root().join(&path).exists(), "{place}: there is no {}", path.display());
        assert!(
            !page.name.starts_with("docs/") || path.starts_with("docs"),
            "{place}: {target} leaves the folder of the book, so the book would lack it; name it instead"
        );
        if anchor.is_empty() {
            continue;
        }
        let other = Page::read(path.to_str().expect("UTF-8"));
        let anchors = anchors(&other);
        assert!(anchors.iter().any(|found| found == anchor), "{place}: no #{anchor} among {anchors:?}");
    }
}

/// Links of a page in its order, without anchors.
pub(crate) fn targets(page: &Page) -> Vec<&str> {
    let links = page.items.iter().filter_map(|item| match &item.kind {
        Kind::Link(target) => Some(target.as_str()),
        _ => None,
    });
    links.map(|target| target.split_once('#').map_or(target, |(file, _)| file)).collect()
}

/// Names of a page's headings in links, as mdBook and GitHub make them.
fn anchors(page: &Page) -> Vec<String> {
    let of = |heading: &str| -> String {
        let kept = heading.chars().filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.collect::<String>().to_lowercase().replace(' ', "-")
    };
    let heading = |item: &_| match item {
        Kind::Heading(heading) => Some(of(heading)),
        _ => None,
    };
    page.items.iter().filter_map(|item| heading(&item.kind)).collect()
}

/// Without `.` and `..`.
fn normal(path: &Path) -> PathBuf {
    let mut normal = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => {
                normal.pop();
            }
            Component::CurDir => {}
            part => normal.push(part),
        }
    }
    normal
}
