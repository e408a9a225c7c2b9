use super::*;
use crate::layout::{NodeRecords, PrimitiveLayout};
use crate::mock::{Recorded, config, gpu};
use std::collections::BTreeSet;
use tracer::Accel;

/// Mean number of lines that `runs` of records touch, each record with its loads.
fn mean_lines(reads: Reads, shift: u32, runs: impl Iterator<Item = Vec<u32>>) -> f64 {
    let lines_of = |run: Vec<u32>| {
        let loads = run.into_iter().flat_map(|record| (0..reads.loads).map(move |load| record + load));
        loads.map(|vec4| vec4 >> shift).collect::<BTreeSet<_>>().len()
    };
    let counts: Vec<usize> = runs.map(lines_of).collect();
    counts.iter().sum::<usize>() as f64 / counts.len() as f64
}

fn buffers(accel: Accel, traversal: &str, primitive: PrimitiveLayout, line: u64) -> Buffers {
    let source = Recorded::list(accel, traversal, 1024, &[]);
    let config = ReplayConfig { primitive_layout: primitive, ..config(gpu(&[])) };
    let line = LineSize::new(line).expect("a power of two");
    Buffers::new(&source, &config, 1, line, line).expect("the mock is valid")
}

#[test]
fn an_isolated_node_takes_as_many_lines_as_its_size_says() {
    for (accel, traversal, line, expected) in [
        (Accel::Kd, "push-down", 64, 1.0),
        (Accel::Grid, "dda", 32, 1.0),
        (Accel::Bvh, "stack", 32, 1.0),
        (Accel::Bvh, "stack", 64, 1.0),
        (Accel::Bvh, "stack", 128, 1.0),
        (Accel::Kd, "backtrack", 32, 2.0),
        (Accel::Kd, "backtrack", 64, 1.5),
        (Accel::Bvh, "parent-link", 64, 1.5),
        (Accel::Bvh, "parent-link", 128, 1.25),
    ] {
        let buffers = buffers(accel, traversal, PrimitiveLayout::Padded, line);
        // 1920 of 2047 nodes: a whole number of the 8 offsets that a record can have in a line.
        let nodes = (0..1920).map(|node| vec![buffers.tree.node(node).unwrap()]);
        let mean = mean_lines(buffers.tree.reads, buffers.tree.line_shift, nodes);
        assert_eq!(mean, expected, "{traversal}, lines of {line} bytes");
    }
}

#[test]
fn padded_nodes_never_straddle_a_line() {
    for line in [64, 128] {
        let source = Recorded::list(Accel::Kd, "backtrack", 1024, &[]);
        let padded = ReplayConfig { node_records: NodeRecords::Padded, ..config(gpu(&[])) };
        let line = LineSize::new(line).expect("a power of two");
        let buffers = Buffers::new(&source, &padded, 1, line, line).expect("the mock is valid");
        let nodes = (0..1920).map(|node| vec![buffers.tree.node(node).unwrap()]);
        assert_eq!(mean_lines(buffers.tree.reads, buffers.tree.line_shift, nodes), 1.0);
        assert!(buffers.tree.reads.one_line && buffers.tree.reads.loads == 3);
    }
}

#[test]
fn a_leaf_of_k_triangles_takes_the_lines_of_its_layout() {
    let expected = [
        (PrimitiveLayout::Padded, 64, [1.5, 3.0, 6.0, 12.0]),
        (PrimitiveLayout::Compact, 64, [1.5, 2.75, 5.25, 10.25]),
        (PrimitiveLayout::Split, 64, [1.5, 2.25, 3.75, 6.75]),
        (PrimitiveLayout::Padded, 128, [1.25, 2.0, 3.5, 6.5]),
        (PrimitiveLayout::Compact, 128, [1.25, 1.875, 3.125, 5.625]),
        (PrimitiveLayout::Split, 128, [1.25, 1.625, 2.375, 3.875]),
    ];
    for (layout, line, means) in expected {
        let buffers = buffers(Accel::Bvh, "stack", layout, line);
        for (k, expected) in [1_u32, 2, 4, 8].into_iter().zip(means) {
            let leaf = |first: u32| (first..first + k).map(|p| buffers.intersection(p).unwrap()).collect();
            let mean = mean_lines(buffers.intersection_reads, buffers.tree.line_shift, (0..512).map(leaf));
            assert_eq!(mean, expected, "{layout:?}, {k} triangles, lines of {line} bytes");
        }
    }
}

#[test]
fn shading_takes_the_lines_of_its_layout() {
    for (layout, expected) in
        [(PrimitiveLayout::Padded, 1.5), (PrimitiveLayout::Compact, 2.0), (PrimitiveLayout::Split, 1.5)]
    {
        let buffers = buffers(Accel::Bvh, "stack", layout, 64);
        let triangles = (0..512).map(|triangle| vec![buffers.shading(triangle).unwrap()]);
        let mean = mean_lines(buffers.shading_reads, buffers.tree.line_shift, triangles);
        assert_eq!(mean, expected, "{layout:?}");
    }
}

#[test]
fn without_normals_all_layouts_are_the_vertices_that_intersections_read() {
    for layout in PrimitiveLayout::ALL {
        let mut source = Recorded::list(Accel::Bvh, "stack", 1024, &[]);
        source.header.normals = false;
        let config = ReplayConfig { primitive_layout: layout, ..config(gpu(&[])) };
        let line = LineSize::new(64).expect("a power of two");
        let buffers = Buffers::new(&source, &config, 1, line, line).expect("the mock is valid");
        let BufferBytes { primitive, normal, .. } = buffers.sizes;
        assert_eq!((primitive, normal), (1024 * 48, 0), "{layout:?}");
        let in_normals = normal_bytes(&source.header, &source.topology, &config);
        assert_eq!(in_normals, 1024 * u64::from(layout.records().bytes() - 48), "{layout:?}");
        assert_eq!(buffers.shading_kind, BufferKind::Primitive);
        assert_eq!(buffers.shading_reads, buffers.intersection_reads);
        // The mock's leaves hold the triangles in file order.
        assert!((0..1024).all(|triangle| buffers.shading(triangle) == buffers.intersection(triangle)));
    }
}

#[test]
fn one_line_reads_are_exactly_those_that_never_straddle() {
    for (accel, traversal) in
        [(Accel::Kd, "stack"), (Accel::Grid, "dda"), (Accel::Bvh, "stack"), (Accel::Bvh, "parent-link")]
    {
        let buffers = buffers(accel, traversal, PrimitiveLayout::Split, 64);
        let straddles = (0..2047).any(|node| {
            let first = buffers.tree.node(node).unwrap();
            let last = first + buffers.tree.reads.loads - 1;
            first >> buffers.tree.line_shift != last >> buffers.tree.line_shift
        });
        assert_eq!(buffers.tree.reads.one_line, !straddles, "{traversal}");
    }
}

#[test]
fn buffers_do_not_overlap() {
    let source = Recorded::list(Accel::Kd, "stack", 1024, &[]);
    let split = ReplayConfig { primitive_layout: PrimitiveLayout::Split, ..config(gpu(&[])) };
    let line = LineSize::new(64).unwrap();
    let mut header = source.clone();
    header.header.stack_entries = 11;
    let buffers = Buffers::new(&header, &split, 64, line, line).unwrap();
    let mut lines = BTreeSet::new();
    let mut take = |what: &str, of_buffer: BTreeSet<u32>| {
        for line in of_buffer {
            assert!(lines.insert(line), "{what} shares line {line}");
        }
    };
    let of_records = |records: &mut dyn Iterator<Item = u32>, reads: Reads| -> BTreeSet<u32> {
        records.flat_map(|record| (0..reads.loads).map(move |load| (record + load) >> 2)).collect()
    };
    take("node", of_records(&mut (0..2047).map(|n| buffers.tree.node(n).unwrap()), buffers.tree.reads));
    let tests = &mut (0..1024).map(|p| buffers.intersection(p).unwrap());
    take("primitive", of_records(tests, buffers.intersection_reads));
    take("normal", of_records(&mut (0..1024).map(|t| buffers.shading(t).unwrap()), buffers.shading_reads));
    take("index", (0..1024).map(|position| buffers.index_line(position)).collect());
    let base = |warp: u32| buffers.stack_base_line + warp * buffers.stack_stride_lines;
    for warp in 0..64 {
        let entries = (0..11).flat_map(|entry| (0..32).map(move |lane| (entry, lane)));
        let stack = entries.map(|(entry, lane)| base(warp) + buffers.tree.stack_line(entry, lane, 32));
        take("stack", stack.collect());
    }
}

#[test]
fn addresses_outside_the_buffers_are_refused_at_their_limit() {
    let buffers = buffers(Accel::Bvh, "stack", PrimitiveLayout::Padded, 64);
    assert!(buffers.tree.node(2046).is_some() && buffers.tree.node(2047).is_none());
    assert!(buffers.intersection(1023).is_some() && buffers.intersection(1024).is_none());
    assert!(buffers.shading(1023).is_some() && buffers.shading(1024).is_none());
}
