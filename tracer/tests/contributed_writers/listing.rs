//! A trace as a list of words that small programs in other languages can read.

use std::fmt::Write;
use tracer::{
    Frame, LoopStructure, NOT_CAST, NodeFetch, Query, SceneRemarks, Step, Tile, TileSource, Topology,
    TopologyNode, TraceHeader,
};

/// What a writer can be told of a trace: all but drawn triangles, lines of reflection rays, and what else its tiles need no more.
#[derive(Debug, PartialEq)]
pub(crate) struct Recorded {
    pub(crate) header: TraceHeader,
    pub(crate) topology: Topology,
    pub(crate) tiles: Vec<Tile>,
    pub(crate) stalls: u64,
}

impl Recorded {
    pub(crate) fn of(source: &impl TileSource) -> Self {
        let tile = |index| {
            let mut tile = Tile::default();
            source.tile(index, &mut tile).expect("a tile");
            Tile { draws: Vec::new(), reflections: Vec::new(), ..tile }
        };
        let mut header = source.header().clone();
        header.remarks.left_out.clear();
        let header =
            TraceHeader { raster: false, reflections: None, forced: Vec::new(), alpha: None, ..header };
        Self {
            tiles: (0..header.frame.tiles()).map(tile).collect(),
            header,
            topology: source.topology().clone(),
            stalls: source.stalls(),
        }
    }

    pub(crate) fn all_steps(&self) -> impl Iterator<Item = Step> {
        self.tiles.iter().flat_map(|tile| &tile.ray_sets).flat_map(|set| &set.steps).copied()
    }

    pub(crate) fn steps(&self) -> usize {
        self.all_steps().count()
    }
}

/// A listing of two pixels: one hits triangle 1 and sends a shadow ray, the other misses.
pub(crate) fn small() -> String {
    let header = "small\nsmall\n\n0 2 1 0\n2 primary 0 0 shadow 0 0\nbvh stack - pair while-while\n4 0 0\n3 1.5 1 0 0\n";
    let tree = "3\n0 1 2 0\n1 0 1 0\n1 1 1 0\n2 0 1\n0\n2\n0\n0\n";
    format!("{header}{tree}\n1\n0 3\n0 1 -1 1 3 0\n0 0 1 3 3 0 3 1 6 1\n1 0 -1 1 3 0\n0\n")
}

/// Texts line by line, then numbers and names.
pub(crate) fn listing(Recorded { header, topology, tiles, stalls }: &Recorded) -> String {
    let mut text = String::new();
    let put = &mut text;
    put_header(put, header);
    let trees = topology.trees();
    put_tree(put, &trees[0].1);
    let meshes = topology.levels.as_ref().map_or(&[][..], |levels| &levels.meshes);
    put_all(put, [meshes.len()]);
    put_all(put, meshes);
    put_all(put, [trees.len() - 1]);
    trees[1..].iter().for_each(|(_, blas)| put_tree(put, blas));
    put_all(put, [tiles.len()]);
    for (index, tile) in tiles.iter().enumerate() {
        put_tile(put, index, tile, header);
    }
    put_all(put, [stalls]);
    text
}

fn put_all<T: std::fmt::Display>(text: &mut String, words: impl IntoIterator<Item = T>) {
    words.into_iter().for_each(|word| write!(text, "{word} ").expect("a string grows"));
    text.push('\n');
}

fn put_header(text: &mut String, header: &TraceHeader) {
    let more = match &header.remarks {
        SceneRemarks { notes, .. } if notes.is_empty() => String::new(),
        SceneRemarks { notes, .. } => format!("\"remarks\":{{\"left_out\":[],\"notes\":{notes:?}}}"),
    };
    writeln!(text, "{}\n{}\n{more}", header.generator, header.scene).expect("a string grows");
    let (width, height, rays) = match header.frame {
        Frame::Image { width, height } => (width, height, 0),
        Frame::List { rays } => (0, 0, rays),
    };
    let hash = u64::from_str_radix(&header.scene_hash, 16).expect("hex digits");
    put_all(text, [hash as i64, width.into(), height.into(), rays.into(), header.ray_sets.len() as i64]);
    for set in &header.ray_sets {
        put_all(text, [set.kind.name().to_owned(), set.sample.to_string(), set.light.to_string()]);
    }
    let fetch = match header.node_fetch {
        NodeFetch::Single => "single",
        NodeFetch::Pair => "pair",
    };
    let loops = match header.loop_structure {
        LoopStructure::WhileWhile => "while-while",
        LoopStructure::IfIf => "if-if",
        LoopStructure::SingleLoop => "single-loop",
    };
    let format = header.node_format.map_or("-", |format| format.name());
    put_all(text, [header.accel.name(), &header.traversal, format, fetch, loops]);
    put_all(text, [header.stack_entries, header.short_stack, header.trail_bits.unwrap_or(0)]);
    put_all(text, header.sah_costs);
    let closest = header.shadow_query == Query::Closest;
    put_all(text, [header.depth, closest.into(), (!header.normals).into()]);
}

fn put_tree(text: &mut String, tree: &Topology) {
    put_all(text, [tree.nodes.len()]);
    for node in &tree.nodes {
        put_all(
            text,
            match *node {
                TopologyNode::Inner { left } => [0, left, 2, 0],
                TopologyNode::Leaf { first, count } => [1, first, count, 0],
                TopologyNode::Wide { first, count, leaves } => [2, first, count, leaves],
            },
        );
    }
    put_all(text, [tree.references.len()]);
    put_all(text, &tree.references);
    put_all(text, [tree.seconds.len()]);
    put_all(text, &tree.seconds);
    put_all(text, [tree.triangles]);
}

/// The rays that were cast, the last pixel first and all sets of a pixel together, as a renderer may come to them.
fn put_tile(text: &mut String, index: usize, tile: &Tile, header: &TraceHeader) {
    let sets = &tile.ray_sets;
    let is_cast = |set: usize, ray: usize| {
        let source = header.ray_sets[set].source(&header.ray_sets);
        let due = source.is_none_or(|source| sets[source].hits[ray] < NOT_CAST);
        let was = due && sets[set].hits[ray] != NOT_CAST;
        assert!(was || sets[set].range(ray).is_empty(), "a ray that was not cast has no steps");
        was
    };
    let rays = (0..sets[0].ends.len()).rev().flat_map(|ray| (0..sets.len()).map(move |set| (set, ray)));
    let cast: Vec<_> = rays.filter(|&(set, ray)| is_cast(set, ray)).collect();
    put_all(text, [index, cast.len()]);
    for (set, ray) in cast {
        let steps = &sets[set].steps[sets[set].range(ray)];
        let hit = if sets[set].hits[ray] < NOT_CAST { i64::from(sets[set].hits[ray]) } else { -1 };
        put_all(text, [set as i64, ray as i64, hit, steps.len() as i64]);
        put_all(text, steps.iter().flat_map(|step| [step.op() as u32, step.id()]));
    }
}
