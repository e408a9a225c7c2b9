//! Does the page of a report work in a browser: does it fit, sort, filter and tell the figures of its pixels?
//!
//! The tests need Chromium and its driver and say so when they skip.

mod webdriver;

use gpumodel::{
    EnergyTable, Fidelity, Gpu, HeatMaps, Maps, NodeOrder, NodeRecords, PrimitiveLayout, ReplayConfig,
    ShaderCosts, Technique,
};
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;
use tempfile::TempDir;
use tracer::{Op, Step, Tile, TileSource, TraceFile};
use webdriver::{Browser, Window};

const DESK: Window = Window { width: 1280, scheme: "light" };
/// Of a frame with partly filled tiles at two edges.
const SIZE: [u32; 2] = [75, 45];
const ARROW_RIGHT: char = '\u{e014}';
const ARROW_DOWN: char = '\u{e015}';
const ENTER: char = '\u{e007}';
const ESCAPE: char = '\u{e00c}';

fn raybudget(args: &[&str]) {
    let output =
        Command::new(env!("CARGO_BIN_EXE_raybudget")).args(args).output().expect("the program starts");
    assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
}

/// A trace of a small frame, and the folder of its report.
struct Small {
    folder: TempDir,
}

impl Small {
    /// Made once for all tests.
    fn get() -> &'static Self {
        static MADE: OnceLock<Small> = OnceLock::new();
        MADE.get_or_init(|| {
            let folder = tempfile::tempdir().expect("a temporary folder");
            let small = Self { folder };
            let (trace, out) = (small.trace(), small.folder.path().join("out"));
            let [trace, out] = [&trace, &out].map(|path| path.to_str().expect("UTF-8"));
            raybudget(&["trace", "atrium", "--size", &format!("{}x{}", SIZE[0], SIZE[1]), "-o", trace]);
            raybudget(&["replay", trace, "-o", out]);
            let compared = small.folder.path().join("compared");
            let compared = compared.to_str().expect("UTF-8");
            raybudget(&[
                "compare",
                "cornell",
                "--size",
                "16x16",
                "--vary",
                "traversal,layout",
                "-o",
                compared,
            ]);
            small
        })
    }

    fn trace(&self) -> PathBuf {
        self.folder.path().join("frame.rbt")
    }

    fn page(&self) -> PathBuf {
        self.folder.path().join("out/report.html")
    }

    /// Of a comparison of many variants.
    fn comparison(&self) -> PathBuf {
        self.folder.path().join("compared/comparison.html")
    }

    /// What the model counts for each pixel, without the page.
    fn maps(&self) -> HeatMaps {
        let trace = TraceFile::open(&self.trace()).expect("a trace");
        let config = ReplayConfig {
            gpu: Gpu::builtin("adreno-540").expect("built in").expect("sound"),
            costs: ShaderCosts::builtin().expect("sound"),
            energy: EnergyTable::builtin().expect("sound"),
            technique: Technique::builtin("fragment").expect("built in").expect("sound"),
            primitive_layout: PrimitiveLayout::default(),
            primitive_order: None,
            node_records: NodeRecords::default(),
            node_order: NodeOrder::default(),
            fidelity: Fidelity::Replay,
            keeps_misses: false,
        };
        let replayed = gpumodel::replay(&trace, &config, Maps::Kept, &|_, _| {}).expect("a sound trace");
        replayed.maps.expect("kept")
    }
}

/// The figures of the read-out, map by map.
fn read_out(browser: &Browser) -> Vec<u64> {
    let figures = browser.script(
        "return [...document.querySelectorAll('#readout td')].map((cell) => Number(cell.dataset.value))",
    );
    figures
        .as_array()
        .expect("a list")
        .iter()
        .map(|figure| figure.as_u64().expect("a whole number"))
        .collect()
}

fn figures_at(maps: &HeatMaps, [x, y]: [u32; 2]) -> Vec<u64> {
    let HeatMaps { node_fetches, loaded_bytes, warp_misses, wasted_slots } = maps;
    let place = (y * SIZE[0] + x) as usize;
    let wasted_slots = wasted_slots.as_ref().expect("shaders walk in lockstep");
    [node_fetches, loaded_bytes, warp_misses, wasted_slots].map(|map| u64::from(map.values[place])).into()
}

#[test]
fn pages_fit_every_window_ask_the_network_for_nothing_and_log_no_error() {
    let Some(browser) = Browser::or_skip("pages in four windows") else { return };
    for page in [Small::get().page(), Small::get().comparison()] {
        let mut backgrounds = Vec::new();
        for (width, scheme) in [(1280, "light"), (1280, "dark"), (400, "light"), (400, "dark")] {
            let window = Window { width, scheme };
            browser.show(&page, window);
            let root = browser.script("const { scrollWidth, clientWidth } = document.documentElement; return [scrollWidth, clientWidth, innerWidth]");
            assert!(root[0].as_u64() <= root[1].as_u64(), "{page:?} {window:?}: {root}");
            assert_eq!(root[2], width, "{page:?} {window:?}");
            assert_eq!(browser.console(), Vec::<String>::new(), "{page:?} {window:?}");
            let asked =
                browser.script("return performance.getEntriesByType('resource').map((entry) => entry.name)");
            assert_eq!(asked, Value::Array(Vec::new()), "{page:?} {window:?}");
            backgrounds.push(browser.text("return getComputedStyle(document.body).backgroundColor"));
        }
        assert_eq!(backgrounds[..2], backgrounds[2..]);
        assert_ne!(backgrounds[0], backgrounds[1], "light and dark");
    }
}

/// Shown figures of a column of the table of bytes, as the rows stand.
const BYTES_READ: &str = "return [...document.querySelectorAll('#traffic tbody tr')].map((row) => Number(row.cells[row.cells.length - 2].dataset.v ?? -1))";
const SORT_BYTES_READ: &str = "const heads = [...document.querySelectorAll('#traffic thead th')]; const head = heads[heads.length - 2];";

fn numbers(list: &Value) -> Vec<f64> {
    list.as_array().expect("a list").iter().map(|number| number.as_f64().expect("a number")).collect()
}

#[test]
fn a_column_is_sorted_by_keyboard_down_up_and_back() {
    let Some(browser) = Browser::or_skip("sorting") else { return };
    browser.show(&Small::get().page(), DESK);
    let order = || numbers(&browser.script(BYTES_READ));
    let state = || browser.text(&format!("{SORT_BYTES_READ} return head.getAttribute('aria-sort')"));
    let before = order();
    let mut up: Vec<f64> = before.iter().copied().filter(|bytes| *bytes >= 0.0).collect();
    up.sort_by(f64::total_cmp);
    let (mut down, absent) = (up.clone(), vec![-1.0; before.len() - up.len()]);
    down.reverse();
    assert!(up.len() > 3 && before != [down.clone(), absent.clone()].concat(), "{before:?}");
    browser.script(&format!("{SORT_BYTES_READ} head.querySelector('button').focus()"));
    browser.press(ENTER);
    assert_eq!((order(), state().as_str()), ([down, absent.clone()].concat(), "descending"));
    browser.press(ENTER);
    assert_eq!((order(), state().as_str()), ([up, absent].concat(), "ascending"));
    browser.press(ENTER);
    assert_eq!((order(), state().as_str()), (before, "none"));
}

#[test]
fn a_filter_leaves_the_rows_that_hold_all_of_its_words() {
    let Some(browser) = Browser::or_skip("filtering") else { return };
    browser.show(&Small::get().page(), DESK);
    let filtered = |words: &str| {
        browser.script(&format!(
            "const field = document.querySelector('#counters .filter input'); field.value = '{words}'; field.dispatchEvent(new Event('input'));"
        ));
        let names = browser.script(
            "return [...document.querySelector('#counters table').querySelectorAll('tbody tr:not(.group)')].filter((row) => row.checkVisibility())\
             .map((row) => row.querySelector('.def').firstChild.textContent)",
        );
        names
            .as_array()
            .expect("a list")
            .iter()
            .map(|name| name.as_str().expect("a name").to_owned())
            .collect::<Vec<_>>()
    };
    let all = filtered("").len();
    assert!(all > 40, "{all} counters");
    let fetches = filtered("NODE fetches");
    assert!(fetches.contains(&"Node Fetches / Ray".to_owned()) && fetches.len() < 8, "{fetches:?}");
    assert_eq!(filtered("no such counter"), Vec::<String>::new());
    assert_eq!(filtered("").len(), all);
    assert_eq!(browser.console(), Vec::<String>::new());
}

#[test]
fn what_a_counter_means_is_shown_while_it_has_the_focus_or_is_pointed_at() {
    let Some(browser) = Browser::or_skip("tips") else { return };
    browser.show(&Small::get().page(), DESK);
    let tip =
        || browser.text("const tip = document.getElementById('tip'); return tip.hidden ? '' : tip.innerText");
    assert_eq!(tip(), "");
    browser.script("document.querySelector('#counters .def').focus()");
    let shown = tip();
    assert!(
        shown.contains("Formula sum over the phases of the frame") && shown.contains("Unit ms"),
        "{shown}"
    );
    browser.press(ESCAPE);
    assert_eq!(tip(), "");
    let place = browser.script(
        "const name = document.querySelectorAll('#counters .def')[1]; name.scrollIntoView({ block: 'center' });\
         const box = name.getBoundingClientRect(); return [box.x + 5, box.y + 5]",
    );
    let place = numbers(&place);
    browser.point(place[0] as i64, place[1] as i64);
    assert!(tip().contains("1 / frame time"), "{}", tip());
}

#[test]
fn the_read_out_tells_what_the_replay_counted_by_field_by_pointer_and_by_arrow_key() {
    let Some(browser) = Browser::or_skip("the read-out") else { return };
    let small = Small::get();
    let maps = small.maps();
    browser.show(&small.page(), DESK);
    let [right, bottom] = SIZE.map(|side| side - 1);
    for pixel in [[0, 0], [right, 0], [0, bottom], [right, bottom], [31, 17], [32, 32], [50, 40]] {
        let set = |axis: &str, value: u32| {
            browser.script(&format!(
                "const field = document.getElementById('at-{axis}'); field.value = {value}; field.dispatchEvent(new Event('input'));"
            ));
        };
        set("x", pixel[0]);
        set("y", pixel[1]);
        assert_eq!(read_out(&browser), figures_at(&maps, pixel), "{pixel:?} by its fields");
    }
    browser.script("document.getElementById('map').focus()");
    let at =
        || {
            numbers(&browser.script(
                "return ['x', 'y'].map((axis) => Number(document.getElementById(`at-${axis}`).value))",
            ))
        };
    let before = at();
    browser.press(ARROW_RIGHT);
    browser.press(ARROW_DOWN);
    let pixel = [before[0] as u32 + 1, before[1] as u32 + 1];
    assert_eq!(at(), pixel.map(f64::from));
    assert_eq!(read_out(&browser), figures_at(&maps, pixel), "{pixel:?} by arrow keys");

    // What the keys hold, a press of the button lets go.
    browser.script("document.getElementById('pin').click()");
    let pixel = [60, 20];
    let place = browser.script(&format!(
        "const map = document.getElementById('map'); map.scrollIntoView({{ block: 'center' }}); const box = map.getBoundingClientRect();\
         return [box.x + box.width * ({} + 0.5) / {}, box.y + box.height * ({} + 0.5) / {}]",
        pixel[0], SIZE[0], pixel[1], SIZE[1]
    ));
    let place = numbers(&place);
    browser.point(place[0].round() as i64, place[1].round() as i64);
    assert_eq!(read_out(&browser), figures_at(&maps, pixel), "{pixel:?} by the pointer");
    assert_eq!(browser.console(), Vec::<String>::new());
}

#[test]
fn the_rays_of_a_pixel_take_the_steps_that_the_trace_has() {
    let Some(browser) = Browser::or_skip("the ray inspector") else { return };
    let small = Small::get();
    let trace = TraceFile::open(&small.trace()).expect("a trace");
    browser.show(&small.page(), DESK);
    let mut tile = Tile::default();
    for [x, y] in [[0, 0], [31, 17], [SIZE[0] - 1, SIZE[1] - 1]] {
        let mut expected: Vec<Vec<String>> = Vec::new();
        for index in 0..trace.header().frame.tiles() {
            let rect = trace.header().frame.tile(index);
            if !(rect.x..rect.x + rect.width).contains(&x) || !(rect.y..rect.y + rect.height).contains(&y) {
                continue;
            }
            trace.tile(index, &mut tile).expect("a sound trace");
            let ray = ((y - rect.y) * rect.width + x - rect.x) as usize;
            let rays = tile.ray_sets.iter().map(|set| &set.steps[set.range(ray)]);
            expected
                .extend(rays.filter(|steps| !steps.is_empty()).map(|steps| steps.iter().map(told).collect()));
        }
        for (axis, value) in [("x", x), ("y", y)] {
            browser.script(&format!(
                "const field = document.getElementById('at-{axis}'); field.value = {value}; field.dispatchEvent(new Event('input'));"
            ));
        }
        let shown = browser.script(
            "return [...document.querySelectorAll('#rays .steps')].map((list) => [...list.children].map((step) => step.textContent))",
        );
        assert_eq!(shown, serde_json::json!(expected), "{x} {y}");
        assert!(!expected.is_empty());
    }
}

/// A step as the page tells it.
fn told(step: &Step) -> String {
    let name = match step.op() {
        Op::Node => "node",
        Op::Push => "push",
        Op::Pop => "pop",
        Op::Primitive => "triangle",
        other => panic!("a stack takes no step {other:?}"),
    };
    format!("{name} {}", step.id())
}

#[test]
fn a_name_that_is_html_is_shown_and_does_nothing() {
    let Some(browser) = Browser::or_skip("names that are HTML") else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("<img src=x onerror=document.title=1>.obj");
    fs::write(&scene, "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nf 1 2 3\n").expect("a file in a temporary folder");
    let out = folder.path().join("out");
    let [scene, out] = [&scene, &out].map(|path: &PathBuf| path.to_str().expect("UTF-8"));
    raybudget(&["profile", scene, "--size", "40x24", "-o", out]);
    browser.show(&Path::new(out).join("report.html"), DESK);
    assert_eq!(browser.console(), Vec::<String>::new());
    assert!(browser.text("return document.title").contains("<img src=x onerror=document.title=1>"));
    assert_eq!(browser.script("return document.images.length"), 0);
}

#[test]
fn a_page_of_a_megapixel_has_at_most_5_mb_and_still_tells_its_pixels() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    raybudget(&["profile", "atrium", "--size", "1024x1024", "-o", folder.path().to_str().expect("UTF-8")]);
    let page = folder.path().join("report.html");
    let bytes = fs::metadata(&page).expect("a page").len();
    assert!(bytes <= 5_000_000, "{bytes} bytes");
    let Some(browser) = Browser::or_skip("a page of a megapixel in a browser") else { return };
    browser.show(&page, DESK);
    assert_eq!(browser.console(), Vec::<String>::new());
    assert!(read_out(&browser)[0] > 0, "every primary ray reads the root");
}
