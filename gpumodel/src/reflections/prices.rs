//! What lanes issue for each part of a frame, addresses of its loads, stores and atomics included.

use super::lists::{HIT_BYTES, ID_BYTES, LOAD_BYTES, MATERIAL_BYTES, POSITION_BYTES, RAY_BYTES};
use crate::config::{Cost, ReflectionCosts, ScreenSpace, SecondaryCosts, ShaderCosts, SharedCosts};
use crate::ordering::{AtomicStrategy, Binning};

/// The cost table, as passes of reflections use it.
#[derive(Clone, Copy)]
pub(super) struct Prices<'a> {
    pub(super) shared: &'a SharedCosts,
    pub(super) secondary: &'a SecondaryCosts,
    pub(super) costs: &'a ReflectionCosts,
}

impl<'a> Prices<'a> {
    /// None where the table knows nothing of reflections.
    pub(super) fn of(table: &'a ShaderCosts) -> Option<Self> {
        let (secondary, costs) = (table.secondary_rays()?, table.reflections()?);
        Some(Self { shared: &table.shared, secondary, costs })
    }

    pub(super) fn with_loads(&self, parts: &[Cost], loads: u32) -> Cost {
        let mut sum = self.shared.address.times(loads);
        parts.iter().for_each(|&part| sum += part);
        sum
    }

    /// What a pixel shows, from its depth and normal.
    pub(super) fn surface(&self) -> Cost {
        self.with_loads(&[self.shared.unproject, self.shared.decode_normal], 0)
    }

    /// Making its reflection ray.
    pub(super) fn direction(&self) -> Cost {
        self.with_loads(&[self.secondary.sample, self.secondary.reflection_ray], 0)
    }

    /// What a march costs before its first step, and each step; `None` without one.
    pub(super) fn march(&self, screen_space: ScreenSpace) -> Option<[Cost; 2]> {
        let ReflectionCosts { march_setup, march_step, hierarchical_setup, hierarchical_step, .. } =
            *self.costs;
        let priced = |setup: Cost, step: Cost| Some([setup, step]);
        match screen_space {
            ScreenSpace::None => None,
            ScreenSpace::Linear => priced(march_setup, march_step),
            ScreenSpace::Hierarchical => priced(hierarchical_setup, hierarchical_step),
        }
    }

    /// A hit's normal, which judges it, and its colour. Texels take no address arithmetic.
    pub(super) fn screen_hit(&self) -> Cost {
        self.costs.march_judge
    }

    /// Writing a colour.
    pub(super) fn store_colour(&self) -> Cost {
        self.with_loads(&[], 1)
    }

    /// Appending a ray without bins: an add, and a maximum for the size of the dispatch.
    pub(super) fn append(&self) -> Cost {
        self.with_loads(&[self.costs.append], 2)
    }

    /// The bin of a ray, and its place there.
    pub(super) fn bin(&self, binning: Binning) -> Cost {
        let ReflectionCosts { bin_sign, bin_octahedral, bin_position, rank, place, .. } = *self.costs;
        let none = Cost::default();
        let [direction, position] = match binning {
            Binning::None => return none,
            Binning::Sign => [bin_sign, none],
            Binning::Octahedral { .. } => [bin_octahedral, none],
            Binning::Position { .. } => [none, bin_position],
            Binning::PositionAndSign { .. } => [bin_sign, bin_position],
        };
        self.with_loads(&[direction, position, rank, place], 0)
    }

    /// A lower bin in a ray's place.
    pub(super) fn lower_bin(&self) -> Cost {
        self.costs.lower_bin
    }

    /// A lane's part of setting the counters of bins to zero.
    pub(super) fn zero_bins(&self, bins: u32, group: u32) -> Cost {
        self.costs.zero_bin.times(bins.div_ceil(group))
    }

    /// What one lane of a workgroup does for all: the sum over bins, an add, and a maximum.
    pub(super) fn group(&self, bins: u32) -> Cost {
        self.with_loads(&[self.costs.sum_bin.times(bins), self.costs.start], 2)
    }

    pub(super) fn write_ray(&self) -> Cost {
        self.with_loads(&[self.costs.write_missed], loads(RAY_BYTES))
    }

    pub(super) fn read_ray(&self) -> Cost {
        self.with_loads(&[self.costs.read_missed], loads(RAY_BYTES))
    }

    pub(super) fn write_hit(&self) -> Cost {
        self.with_loads(&[self.costs.write_hit], hit_loads())
    }

    /// And finding it through the sorted list.
    pub(super) fn read_hit(&self) -> Cost {
        self.with_loads(&[self.costs.read_hit], 1 + hit_loads())
    }

    /// For an element, in the pass that counts: its bucket, and an atomic.
    pub(super) fn bucket_count(&self) -> Cost {
        self.with_loads(&[self.costs.bucket, self.costs.sort_count], 3)
    }

    /// For a bucket: its size, an atomic, its offset.
    pub(super) fn bucket_offset(&self) -> Cost {
        self.with_loads(&[self.costs.sort_offset], 3)
    }

    /// For an element, in the pass that copies: its bucket, an atomic, and a store.
    pub(super) fn bucket_copy(&self) -> Cost {
        self.with_loads(&[self.costs.bucket, self.costs.sort_copy], 4)
    }

    /// A trip of the loop around an atomic.
    pub(super) fn atomic_trip(&self, strategy: AtomicStrategy) -> Cost {
        match strategy {
            AtomicStrategy::BruteForce => Cost::default(),
            AtomicStrategy::Loop => self.costs.loop_trip,
            AtomicStrategy::Subgroup => self.costs.subgroup_trip,
            AtomicStrategy::Ballot => self.costs.ballot_trip,
        }
    }

    /// The part of shading that belongs to a material. Every second one has a specular part.
    pub(super) fn material(&self, shader: u32) -> Cost {
        let own = if shader.is_multiple_of(2) { self.costs.diffuse } else { self.costs.glossy };
        self.with_loads(&[own], loads(MATERIAL_BYTES))
    }

    pub(super) fn sky(&self) -> Cost {
        self.costs.sky
    }
}

/// Loads or stores of a lane for so many bytes.
fn loads(bytes: u64) -> u32 {
    bytes.div_ceil(LOAD_BYTES) as u32
}

fn hit_loads() -> u32 {
    loads(HIT_BYTES) + loads(ID_BYTES) + loads(POSITION_BYTES)
}
