//! Does the page say what the report says, alike each time, and is text text?

mod common;

use common::report;
use gpumodel::reflections::Coverage;
use reports::heat_map::{HeatMap, ScaleEnd};
use reports::html::{Chart, Pictures, PixelMap, write};
use reports::{Report, Run};

fn page(report: &Report) -> String {
    write(report, &Pictures::default()).expect("a report without maps")
}

/// Tags of elements that have an end.
const PAIRED: [&str; 25] = [
    "html", "head", "body", "header", "nav", "main", "section", "div", "table", "thead", "tbody", "tr", "th",
    "td", "ul", "ol", "li", "dl", "dt", "dd", "span", "details", "script", "small", "h3",
];

fn assert_balanced(page: &str) {
    // Scripts hold no markup of the page.
    let markup: String = page
        .split("<script")
        .enumerate()
        .map(|(index, part)| match index {
            0 => part,
            _ => part.split_once("</script>").expect("a script ends").1,
        })
        .collect();
    for tag in PAIRED {
        let opened =
            markup.matches(&format!("<{tag}>")).count() + markup.matches(&format!("<{tag} ")).count();
        assert_eq!(opened, markup.matches(&format!("</{tag}>")).count(), "{tag}");
    }
}

#[test]
fn everything_but_the_maps_can_be_read_without_a_script() {
    let page = page(&report());
    assert_balanced(&page);
    for said in [
        "12.50 <span>ms</span>",
        "ALU issue",
        "9,007,199,254,740,993",
        "formula",
        "no texture, &quot;none&quot;",
        "DRAM: reads and writes",
        "the worst of 3 other frames",
        "0123456789abcdef",
        "textures: not read",
        "Resources overlap perfectly.",
        "448<span class=\"u\">B</span>",
    ] {
        assert!(page.to_lowercase().contains(&said.to_lowercase()), "{said}");
    }
}

#[test]
fn the_network_is_asked_for_nothing() {
    let page = page(&report());
    assert!(page.contains("default-src 'none'"));
    for address in ["http:", "https:", "src=", "@import", "url("] {
        assert!(!page.contains(address), "{address}");
    }
}

#[test]
fn text_of_a_report_is_shown_and_never_run() {
    let evil = "</script><script>alert('&')</script>";
    let mut report = report();
    report.inputs.scene = evil.into();
    report.passes[0].name = evil.into();
    report.stack[0].name = evil.into();
    report.deciding_bound = Some(evil.into());
    report.traffic[0].pass = evil.into();
    report.traffic[0].levels[0].name = evil.into();
    report.assumptions = vec![evil.into()];
    let maps = [PixelMap::Heat(HeatMap { title: evil.into(), unit: evil.into(), ..heat(&[1, 2, 3, 4]) })];
    let charts = vec![Chart { title: evil.into(), svg: "<svg></svg>".into() }];
    let page =
        write(&report, &Pictures { maps: maps.iter().collect(), rays: None, charts }).expect("a small map");
    assert!(!page.contains(evil) && !page.contains("<script>alert"));
    assert!(page.contains("&lt;/script&gt;&lt;script&gt;alert(&#39;&amp;&#39;)"));
    assert_balanced(&page);
}

#[test]
fn pages_of_two_runs_differ_in_what_the_runs_cost_alone() {
    let first = report();
    let mut second = report();
    second.run = Run {
        wall_s: 77.7,
        threads: 31,
        peak_rss_bytes: Some(1 << 30),
        load_s: 7.0,
        replay_s: 70.0,
        ..second.run
    };
    let [first, second] = [first, second].map(|report| page(&report));
    assert_ne!(first, second);
    let cut = |page: &str| {
        let (before, rest) = page.split_once("<section id=\"run\">").expect("a section of the run");
        (before.to_owned(), rest.split_once("</section>").expect("its end").1.to_owned())
    };
    assert_eq!(cut(&first), cut(&second));
}

fn heat(values: &[u32]) -> HeatMap<'_> {
    HeatMap {
        title: "Node fetches per pixel".into(),
        subtitle: String::new(),
        unit: "fetches".into(),
        width: 2,
        values,
        end: ScaleEnd::Percentile(100.0),
    }
}

#[test]
fn what_a_report_does_not_have_is_no_empty_section() {
    let bare = Report {
        energy: None,
        traffic: Vec::new(),
        buffers: Vec::new(),
        stack: Vec::new(),
        bounds: Vec::new(),
        ..report()
    };
    let page = page(&bare);
    for id in ["energy", "traffic", "buffers", "time", "pixels", "charts", "sustained"] {
        assert!(!page.contains(&format!("#{id}\"")) && !page.contains(&format!("id=\"{id}\"")), "{id}");
    }
    assert!(page.contains("id=\"counters\""));
}

fn of<'a>(maps: &'a [PixelMap<'a>]) -> Pictures<'a> {
    Pictures { maps: maps.iter().collect(), ..Pictures::default() }
}

#[test]
fn maps_and_classes_stand_on_the_page_with_their_distribution() {
    let coverage = [Coverage::Screen, Coverage::QueryHit, Coverage::QueryHit, Coverage::NoSurface];
    let maps = [
        PixelMap::Heat(heat(&[10, 20, 30, 40])),
        PixelMap::Coverage { title: "Where from".into(), width: 2, coverage: &coverage },
    ];
    let page = write(&report(), &of(&maps)).expect("small maps");
    assert_balanced(&page);
    assert!(page.contains("\"divisor\":10") && page.contains("\"ray query, hit\""));
    assert!(page.contains(">25.00</td>"), "the mean");
    let odd = [PixelMap::Heat(heat(&[1, 2, 3]))];
    assert!(write(&report(), &of(&odd)).is_err());
}
