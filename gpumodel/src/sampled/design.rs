//! Which blocks of tiles are replayed, and what each stands for.
//!
//! A block is a row of tiles that follow each other. The first and the last block of a frame are always taken: there the caches
//! are cold, and the cores run dry. The others are taken systematically in order, with a random start and with probabilities in
//! proportion to a size (Madow 1949; Särndal et al. 1992, section 3.6); those whose size makes that certain are taken for sure.
//! Half of the size comes from the bytes of all steps, with which issue and time go, and half from the squares of the compressed
//! bytes, with which misses go, as rays that have little in common compress badly. Both are those of the block's stretch of time, in
//! which the cores also run tiles that came before.

use super::calibration::Auxiliary;
use crate::random::fraction;
use std::ops::Range;
use tracer::{Frame, TileOutline};

/// Strata of the replicates by which the variance is found, at most; their number is that of the degrees of freedom.
pub(super) const STRATA: usize = 16;

/// Blocks that are left to chance, at least, unless all are certain: from fewer no variance is known.
const FEWEST_DRAWN: f64 = 4.0;

/// Parts of a block's size: of its shares in the rays, in the bytes of all steps and in the squares of compressed bytes. The first keeps
/// blocks that have next to nothing of the others from standing for very many.
const SIZE: [f64; 3] = [0.1, 0.45, 0.45];

/// A block that is replayed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Pick {
    pub(super) block: u32,
    /// The probability with which it was taken; 1 where that was certain.
    pub(super) probability: f64,
}

/// All blocks of a frame.
pub(super) struct Blocks {
    tiles: u32,
    /// Tiles of a block but for the last.
    tiles_per_block: u32,
    /// By block, the shares of its tiles in the rays and in the bytes of all steps.
    of_tiles: Vec<Auxiliary>,
    /// By block, the shares of its stretch of time in these and in the squares of compressed bytes.
    of_stretches: Vec<Auxiliary>,
}

/// A tile is run by warps that come one after the other and stay for as long as it takes `resident` warps to come. By how many
/// tiles came since, the part of it that is run then; `warps` are those of a tile.
fn lags(resident: f64, warps: f64) -> Vec<f64> {
    // Of a warp that came at 0, the part that has been run at `time`, and its integral.
    let run = |time: f64| if time < 1.0 { time.max(0.0).powi(2) / 2.0 } else { time - 0.5 };
    let until = |time: f64| resident / warps * (run(time / resident) - run((time - warps) / resident));
    let tiles = (resident / warps).ceil() as u32 + 1;
    (0..tiles).map(|tile| until(f64::from(tile + 1) * warps) - until(f64::from(tile) * warps)).collect()
}

impl Blocks {
    /// `outlines` are those of all tiles of `frame`, or none; so many warps are `resident` on all cores, and so many `warps` make a
    /// tile.
    pub(super) fn new(
        frame: Frame,
        outlines: Option<&[TileOutline]>,
        tiles_per_block: u32,
        [resident, warps]: [u32; 2],
    ) -> Self {
        let tiles = frame.tiles();
        let of_tile = |tile: u32| {
            let rect = frame.tile(tile);
            let rays = f64::from(rect.width * rect.height);
            match outlines {
                Some(outlines) => {
                    let TileOutline { bytes, compressed_bytes } = outlines[tile as usize];
                    [rays, bytes as f64, (compressed_bytes as f64).powi(2)]
                }
                None => [rays; 3],
            }
        };
        let by_tile: Vec<[f64; 3]> = (0..tiles).map(of_tile).collect();
        let all = |number: usize| by_tile.iter().map(|tile| tile[number]).sum::<f64>();
        let all = [0, 1, 2].map(|number| all(number).max(f64::MIN_POSITIVE));
        let lags = lags(f64::from(resident), f64::from(warps));
        let blocks = tiles.div_ceil(tiles_per_block) as usize;
        let mut of_tiles = vec![Auxiliary::default(); blocks];
        let mut of_stretches = of_tiles.clone();
        for (tile, numbers) in by_tile.iter().enumerate() {
            let [rays, bytes, unlike] = std::array::from_fn(|number| numbers[number] / all[number]);
            let block = |tile: usize| (tile / tiles_per_block as usize).min(blocks - 1);
            of_tiles[block(tile)].add([rays, bytes, 0.0], 1.0);
            for (lag, &part) in lags.iter().enumerate() {
                of_stretches[block(tile + lag)].add([rays, bytes, unlike], part);
            }
        }
        Self { tiles, tiles_per_block, of_tiles, of_stretches }
    }

    /// By block, what is known of its tiles.
    pub(super) fn of_tiles(&self) -> &[Auxiliary] {
        &self.of_tiles
    }

    /// By block, what is known of its stretch of time.
    pub(super) fn of_stretches(&self) -> &[Auxiliary] {
        &self.of_stretches
    }

    /// By which a block is taken.
    pub(super) fn size(&self, block: u32) -> f64 {
        let Auxiliary(shares) = self.of_stretches[block as usize];
        shares.into_iter().zip(SIZE).map(|(share, part)| share * part).sum()
    }

    pub(super) fn tiles(&self, block: u32) -> Range<u32> {
        let start = block * self.tiles_per_block;
        start..(start + self.tiles_per_block).min(self.tiles)
    }

    /// Takes about `wanted` blocks beside the first and the last, in order.
    pub(super) fn pick(&self, wanted: u32, seed: u64) -> Vec<Pick> {
        let mut certain = vec![false; self.of_tiles.len()];
        if let Some(first) = certain.first_mut() {
            *first = true;
        }
        if let Some(last) = certain.last_mut() {
            *last = true;
        }
        let mut left = f64::from(wanted);
        // Whoever is certain changes the probabilities of the others.
        let rest = loop {
            let open = || (0..certain.len()).filter(|&block| !certain[block]);
            let rest: f64 = open().map(|block| self.size(block as u32)).sum();
            let large: Vec<usize> = open().filter(|&block| left * self.size(block as u32) >= rest).collect();
            if large.is_empty() || rest <= 0.0 {
                break rest;
            }
            left = (left - large.len() as f64).max(FEWEST_DRAWN);
            large.into_iter().for_each(|block| certain[block] = true);
        };
        let mut next = fraction(seed);
        let mut passed = 0.0;
        let mut picks = Vec::new();
        for (block, &certain) in certain.iter().enumerate() {
            let mut pick = |probability| picks.push(Pick { block: block as u32, probability });
            if certain {
                pick(1.0);
                continue;
            }
            let probability = if rest > 0.0 { left * self.size(block as u32) / rest } else { 0.0 };
            passed += probability;
            if passed > next {
                next += 1.0;
                pick(probability);
            }
        }
        picks
    }
}

/// Weights of picks: how many blocks each stands for. Those that were certain stand for themselves.
pub(super) fn weights(picks: &[Pick]) -> Vec<f64> {
    picks.iter().map(|pick| pick.probability.recip()).collect()
}

/// Weights of the replicates of a sample (the stratified jackknife with two halves, JKn; Wolter 2007, section 4.5): neighbours in the
/// order of the frame make a stratum; of each stratum, a replicate drops every second pick and lets the others stand for them, and its
/// twin drops those others.
pub(super) fn replicates(picks: &[Pick]) -> Vec<[Vec<f64>; 2]> {
    let weights = weights(picks);
    let drawn: Vec<usize> = (0..picks.len()).filter(|&pick| picks[pick].probability < 1.0).collect();
    let strata = (drawn.len() / 2).min(STRATA);
    let replicate = |stratum: usize, dropped: usize| {
        let of_stratum = &drawn[stratum * drawn.len() / strata..(stratum + 1) * drawn.len() / strata];
        let all = of_stratum.iter().map(|&pick| weights[pick]).sum::<f64>();
        let kept = || of_stratum.iter().enumerate().filter(|(place, _)| place % 2 != dropped);
        let of_kept = kept().map(|(_, &pick)| weights[pick]).sum::<f64>();
        let mut replicate = weights.clone();
        of_stratum.iter().for_each(|&pick| replicate[pick] = 0.0);
        kept().for_each(|(_, &pick)| replicate[pick] = weights[pick] * all / of_kept);
        replicate
    };
    (0..strata).map(|stratum| [replicate(stratum, 0), replicate(stratum, 1)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn blocks(bytes: &[u64]) -> Blocks {
        let outline = |&bytes| TileOutline { bytes, compressed_bytes: bytes / 7 };
        let outlines: Vec<_> = bytes.iter().map(outline).collect();
        let frame = Frame::Image { width: 32 * bytes.len() as u32, height: 32 };
        Blocks::new(frame, Some(&outlines), 1, [1, 1000])
    }

    #[test]
    fn over_many_starts_every_block_is_taken_as_often_as_its_probability_says() {
        let blocks = blocks(&[5, 900, 30, 40, 50, 2000, 60, 10, 0, 20, 35, 45]);
        let starts = 20_000;
        let mut found = [0.0; 12];
        let mut expected = [0.0; 12];
        for seed in 0..starts {
            let picks = blocks.pick(4, seed);
            assert!(picks.is_sorted_by_key(|pick| pick.block));
            for Pick { block, probability } in picks {
                found[block as usize] += 1.0 / starts as f64;
                expected[block as usize] = probability;
            }
        }
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 0.02, "{found} {expected}");
        }
        assert_eq!((expected[0], expected[11], expected[5]), (1.0, 1.0, 1.0));
    }

    #[test]
    fn without_outlines_all_tiles_are_alike() {
        let blocks = Blocks::new(Frame::Image { width: 320, height: 320 }, None, 2, [1, 1000]);
        assert_eq!(blocks.of_tiles().len(), 50);
        assert_eq!(blocks.tiles(49), 98..100);
        let picks = blocks.pick(12, 3);
        assert_eq!(picks.len(), 14);
        assert!(picks[1..13].iter().all(|pick| (pick.probability - 0.25).abs() < 1e-2));
    }

    #[test]
    fn tiles_are_run_while_their_warps_are_resident() {
        // A tile of 32 warps of which 40 are resident: the first leaves when 40 have come, the last when 72 have.
        let parts = lags(40.0, 32.0);
        for (part, expected) in parts.iter().zip([0.4, 0.575, 0.025]) {
            assert!((part - expected).abs() < 1e-12, "{parts:?}");
        }
        assert!((parts.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        // Of few warps, all is run at once; of many, evenly.
        assert!(lags(1.0, 1000.0)[0] > 0.999);
        let even = lags(1000.0, 10.0);
        assert!((even.iter().sum::<f64>() - 1.0).abs() < 1e-12 && (even[50] - 0.01).abs() < 1e-12);
    }

    proptest! {
        #[test]
        fn any_sizes_and_numbers_give_picks_in_order_that_stand_for_about_all(
            bytes in prop::collection::vec(0_u64..1_000_000, 1..200),
            wanted in 0_u32..300,
            seed in 0_u64..1000,
        ) {
            let blocks = blocks(&bytes);
            let picks = blocks.pick(wanted, seed);
            prop_assert!(picks.windows(2).all(|pair| pair[0].block < pair[1].block));
            prop_assert!(picks.iter().all(|pick| pick.probability > 0.0 && pick.probability <= 1.0));
            let drawn = picks.iter().filter(|pick| pick.probability < 1.0).count();
            prop_assert!(wanted < 4 || drawn == 0 || drawn >= 3, "{drawn}");
            prop_assert_eq!((picks[0].block, picks[picks.len() - 1].block), (0, bytes.len() as u32 - 1));
            for replicate in replicates(&picks).into_iter().flatten() {
                let (all, of_replicate) =
                    (weights(&picks).iter().sum::<f64>(), replicate.iter().sum::<f64>());
                prop_assert!((of_replicate / all - 1.0).abs() < 1e-9);
            }
        }
    }
}
