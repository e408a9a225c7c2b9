//! Lanes of a warp whose step lists begin alike, as a tree.
//!
//! Neighbouring rays mostly visit the same nodes in the same order, so lanes march as one *group* until their lists part. The
//! lowest lane leads a group; a lane whose list parts from its leader's leads a group of its own from there on. Lanes are in one
//! group exactly as long as they have taken the same steps, so what a warp's replay costs follows from the distinct beginnings
//! of its lists, not from its lanes.

use tracer::Step;

/// No group.
const NONE: u8 = u8::MAX;

/// Groups that march through lists of steps. Positions are those in the slice of all steps.
pub(crate) struct Prefixes {
    /// By leader, the position of the next step.
    next: [u32; 64],
    /// By leader, where a group parts from this one, or `end`.
    stop: [u32; 64],
    /// By leader, the end of its list.
    end: [u32; 64],
    /// By leader, the lanes of the group.
    lanes: [u64; 64],
    /// By leader, the group that parts first from this one, or [`NONE`].
    first_branch: [u8; 64],
    /// By leader, the group that parts next from the same group, or [`NONE`].
    next_branch: [u8; 64],
    /// By leader, the position in the list of the group that it parts from.
    parting: [u32; 64],
}

impl Prefixes {
    pub(crate) fn new() -> Self {
        Self {
            next: [0; 64],
            stop: [0; 64],
            end: [0; 64],
            lanes: [0; 64],
            first_branch: [NONE; 64],
            next_branch: [NONE; 64],
            parting: [0; 64],
        }
    }

    /// Sorts lanes into groups by `ranges` of `steps`, given as `(lane, start, end)` with rising lanes. Returns the leader of
    /// the first group, of which all others are branches.
    pub(crate) fn gather(
        &mut self,
        steps: &[Step],
        ranges: impl Iterator<Item = (usize, u32, u32)>,
    ) -> Option<usize> {
        let mut root = None;
        for (lane, start, end) in ranges {
            self.next[lane] = start;
            self.stop[lane] = end;
            self.end[lane] = end;
            self.lanes[lane] = 1 << lane;
            self.first_branch[lane] = NONE;
            match root {
                None => root = Some(lane),
                Some(root) => self.join(steps, root, lane),
            }
        }
        root
    }

    /// Lets a lane join the group at `leader`, or one of those that part from it, or part from one of these.
    fn join(&mut self, steps: &[Step], mut leader: usize, lane: usize) {
        let rest = |next: u32, end: u32| &steps[next as usize..end as usize];
        let own_end = self.end[lane];
        loop {
            self.lanes[leader] |= 1 << lane;
            let (own, end) = (self.next[lane], self.end[leader]);
            let shared = shared_steps(rest(self.next[leader], end), rest(own, own_end));
            let (at, own) = (self.next[leader] + shared, own + shared);
            self.next[lane] = own;
            if at == end && own == own_end {
                return;
            }
            let step = rest(own, own_end).first();
            let (mut before, mut branch) = (None, self.first_branch[leader]);
            while branch != NONE && self.parting[branch as usize] <= at {
                let other = branch as usize;
                if self.parting[other] == at && rest(self.next[other], self.end[other]).first() == step {
                    break;
                }
                (before, branch) = (Some(other), self.next_branch[other]);
            }
            if branch != NONE && self.parting[branch as usize] == at {
                leader = branch as usize;
                continue;
            }
            self.parting[lane] = at;
            self.next_branch[lane] = branch;
            match before {
                Some(before) => self.next_branch[before] = lane as u8,
                None => {
                    self.first_branch[leader] = lane as u8;
                    self.stop[leader] = at;
                }
            }
            return;
        }
    }

    /// The lanes that march with `leader`.
    #[inline(always)]
    pub(crate) fn lanes(&self, leader: usize) -> u64 {
        self.lanes[leader]
    }

    /// The next step of a group; `None` at the end of its list.
    #[inline(always)]
    pub(crate) fn peek<'a>(&self, steps: &'a [Step], leader: usize) -> Option<&'a Step> {
        let next = self.next[leader];
        if next == self.end[leader] { None } else { Some(&steps[next as usize]) }
    }

    /// Takes the next step of a group and returns it. Afterwards [`Self::part`] is due.
    #[inline(always)]
    pub(crate) fn advance(&mut self, steps: &[Step], leader: usize) -> Step {
        let next = self.next[leader];
        self.next[leader] = next + 1;
        steps[next as usize]
    }

    /// The leader of a group that parts from this one here, if there is any left.
    #[inline(always)]
    pub(crate) fn part(&mut self, leader: usize) -> Option<usize> {
        let branch = self.first_branch[leader];
        if self.next[leader] != self.stop[leader] || branch == NONE {
            return None;
        }
        let branch = usize::from(branch);
        self.lanes[leader] &= !self.lanes[branch];
        let after = self.next_branch[branch];
        self.first_branch[leader] = after;
        self.stop[leader] = if after == NONE { self.end[leader] } else { self.parting[usize::from(after)] };
        Some(branch)
    }
}

/// How many steps at the beginning of two lists are the same.
fn shared_steps(left: &[Step], right: &[Step]) -> u32 {
    const CHUNK: usize = 16;
    let same =
        |left: &[Step], right: &[Step]| left.iter().zip(right).fold(true, |same, (l, r)| same & (l == r));
    let chunks = left.chunks_exact(CHUNK).zip(right.chunks_exact(CHUNK));
    let whole = chunks.take_while(|&(left, right)| same(left, right)).count() * CHUNK;
    let rest = left[whole..].iter().zip(&right[whole..]).take_while(|(left, right)| left == right).count();
    (whole + rest) as u32
}
