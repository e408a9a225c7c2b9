//! Synthetic address streams: made by integer arithmetic alone, the same on every machine, to measure and
//! to check simulators with. They resemble no particular program.
//!
//! [`lines`] gives the touched 64-byte lines, the same as the published counts of other simulators use.

use crate::address::{Address, LineId, LineSize};
use crate::splitmix::SplitMix64;

/// The streams.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// Segments walking a regular binary tree over a square world, with incoherent second segments: reads
    /// of 32-byte nodes and 48-byte leaf primitives.
    Bvh,
    /// Uniform over 16 MiB: 262,144 lines in random order.
    Rnd,
    /// 16-byte reads in order over 16 MiB, again and again.
    Seq,
}

/// The first `count` touches of 64-byte lines of a stream, one per line that a read overlaps.
#[must_use]
pub fn lines(stream: Stream, count: usize) -> Vec<LineId> {
    let mut touched = Touched { lines: Vec::with_capacity(count), count };
    match stream {
        Stream::Bvh => TreeWalk::new().run(&mut touched),
        Stream::Rnd => {
            let mut random = SplitMix64::new(2);
            while !touched.full() {
                touched.lines.push(LineId::new(random.draw() >> 46));
            }
        }
        Stream::Seq => {
            let mut address = 0;
            while !touched.full() {
                touched.read(address, 16);
                address = (address + 16) & 0xFF_FFFF;
            }
        }
    }
    touched.lines
}

/// Collects lines until there are enough.
struct Touched {
    lines: Vec<LineId>,
    count: usize,
}

impl Touched {
    const LINE: LineSize = LineSize::new(64).unwrap();

    fn full(&self) -> bool {
        self.lines.len() >= self.count
    }

    fn read(&mut self, address: u64, bytes: u64) {
        let first = Self::LINE.line_of(Address(address)).get();
        let last = Self::LINE.line_of(Address(address + bytes - 1)).get();
        let room = self.count - self.lines.len();
        self.lines.extend((first..=last).take(room).map(LineId::new));
    }
}

/// The world is 65536 units square, its leaves 256 x 256 cells; nodes are numbered as in a heap, the root
/// 1, and halve the box by x at even and by y at odd depth.
struct TreeWalk {
    random: SplitMix64,
    stack: Vec<Visit>,
}

#[derive(Clone, Copy)]
struct Visit {
    node: u64,
    depth: u32,
    low: [i64; 2],
    high: [i64; 2],
}

impl TreeWalk {
    const NODES: u64 = 0x1000_0000;
    const PRIMITIVES: u64 = 0x2000_0000;
    const LEAF_DEPTH: u32 = 16;
    const FIRST_LEAF: u64 = 1 << Self::LEAF_DEPTH;

    fn new() -> Self {
        Self { random: SplitMix64::new(1), stack: Vec::new() }
    }

    /// Frames of 512 x 512 pixels in Morton order until `touched` is full.
    fn run(mut self, touched: &mut Touched) {
        while !touched.full() {
            for morton in 0..1_u64 << 18 {
                let x = even_bits(morton) as i64 * 128 + (self.random.draw() & 127) as i64;
                let y = even_bits(morton >> 1) as i64 * 128 + (self.random.draw() & 127) as i64;
                if self.segment([x - 6144, y - 2560], [x, y], touched) {
                    let x2 = x + (self.random.draw() & 8191) as i64 - 4096;
                    let y2 = y + (self.random.draw() & 8191) as i64 - 4096;
                    self.segment([x, y], [x2, y2], touched);
                }
                if touched.full() {
                    return;
                }
            }
        }
    }

    fn segment(&mut self, a: [i64; 2], b: [i64; 2], touched: &mut Touched) -> bool {
        self.stack.clear();
        self.stack.push(Visit { node: 1, depth: 0, low: [0; 2], high: [65536; 2] });
        while let Some(Visit { node, depth, low, high }) = self.stack.pop() {
            if touched.full() {
                return false;
            }
            touched.read(Self::NODES + 32 * node, 32);
            if !overlaps(a, b, low, high) {
                continue;
            }
            if depth == Self::LEAF_DEPTH {
                for k in 0..2 {
                    touched.read(Self::PRIMITIVES + 48 * (2 * (node - Self::FIRST_LEAF) + k), 48);
                }
                if self.random.draw() & 7 == 0 {
                    return true;
                }
                continue;
            }
            let axis = (depth & 1) as usize;
            let middle = (low[axis] + high[axis]) / 2;
            let mut children = [
                Visit { node: 2 * node, depth: depth + 1, low, high },
                Visit { node: 2 * node + 1, depth: depth + 1, low, high },
            ];
            children[0].high[axis] = middle;
            children[1].low[axis] = middle;
            if b[axis] < a[axis] {
                children.swap(0, 1);
            }
            self.stack.extend([children[1], children[0]]);
        }
        false
    }
}

/// Whether the segment meets the box: bounds against the box, corners against the line.
fn overlaps(a: [i64; 2], b: [i64; 2], low: [i64; 2], high: [i64; 2]) -> bool {
    if (0..2).any(|axis| a[axis].max(b[axis]) < low[axis] || a[axis].min(b[axis]) > high[axis]) {
        return false;
    }
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let side = |x: i64, y: i64| dx * (y - a[1]) - dy * (x - a[0]);
    let sides = [side(low[0], low[1]), side(high[0], low[1]), side(low[0], high[1]), side(high[0], high[1])];
    !(sides.iter().all(|&s| s > 0) || sides.iter().all(|&s| s < 0))
}

fn even_bits(morton: u64) -> u64 {
    (0..9).map(|bit| (morton >> (2 * bit) & 1) << bit).sum()
}
