//! Which channel, bank and row hold an address.
//!
//! The blocks of `channel_bytes` go round the channels, whose number need not be a power of two. The
//! addresses within a channel, closed up, are cut from the top into
//!
//! ```text
//! row | bank in group | column | bank group | byte of the group's share
//! ```
//!
//! so that a stream of lines alternates bank groups, stays in one row per group for the length of a row, and
//! then goes on to the next bank.

use super::standard::DramStandard;

/// Cuts addresses.
#[derive(Clone, Debug)]
pub(super) struct AddressMap {
    burst: Radix,
    block: Radix,
    channels: Radix,
    share: Radix,
    groups: Radix,
    shares_per_row: Radix,
    banks_per_group: Radix,
}

/// Bursts of one row, one after another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Segment {
    pub(super) channel: u32,
    pub(super) bank: u32,
    pub(super) row: u64,
    pub(super) bursts: u32,
}

impl AddressMap {
    pub(super) fn new(standard: &DramStandard, channels: u32) -> Self {
        let DramStandard { organisation, controller, .. } = standard;
        Self {
            burst: Radix::new(organisation.burst_bytes()),
            block: Radix::new(controller.channel_bytes),
            channels: Radix::new(u64::from(channels)),
            share: Radix::new(controller.group_bytes),
            groups: Radix::new(u64::from(organisation.bank_groups)),
            shares_per_row: Radix::new(organisation.row_bytes / controller.group_bytes),
            banks_per_group: Radix::new(u64::from(organisation.banks / organisation.bank_groups)),
        }
    }

    /// The segments of the bursts that `bytes` from `address` touch, in order. Nothing lies beyond the last
    /// address; 0 bytes touch as 1 does.
    pub(super) fn segments(&self, address: u64, bytes: u32) -> impl Iterator<Item = Segment> + '_ {
        let mut at = self.burst.split(address).0;
        let last = self.burst.split(address.saturating_add(u64::from(bytes.max(1)) - 1)).0;
        std::iter::from_fn(move || {
            (at <= last).then(|| {
                let (segment, room) = self.locate(at * self.burst.of);
                let bursts = room.min(last - at + 1);
                at += bursts;
                Segment { bursts: bursts as u32, ..segment }
            })
        })
    }

    /// The place of a burst, and how many bursts from it on lie in the same row without a break.
    #[inline]
    fn locate(&self, address: u64) -> (Segment, u64) {
        let (block, in_block) = self.block.split(address);
        let (local_block, channel) = self.channels.split(block);
        let local = local_block * self.block.of + in_block;
        let (share, in_share) = self.share.split(local);
        let (above, group) = self.groups.split(share);
        let (above, _column) = self.shares_per_row.split(above);
        let (row, bank_in_group) = self.banks_per_group.split(above);
        let room = (self.block.of - in_block).min(self.share.of - in_share);
        let segment = Segment {
            channel: channel as u32,
            bank: (bank_in_group * self.groups.of + group) as u32,
            row,
            bursts: 0,
        };
        (segment, self.burst.split(room).0)
    }
}

/// A divisor, by shift where it is a power of two.
#[derive(Clone, Copy, Debug)]
struct Radix {
    of: u64,
    shift: Option<u32>,
}

impl Radix {
    fn new(of: u64) -> Self {
        Self { of, shift: of.is_power_of_two().then_some(of.trailing_zeros()) }
    }

    /// Quotient and remainder.
    #[inline]
    fn split(self, value: u64) -> (u64, u64) {
        match self.shift {
            Some(shift) => (value >> shift, value & (self.of - 1)),
            None => (value / self.of, value % self.of),
        }
    }
}
