//! Counters under the names of the makers' profilers: Snapdragon Profiler on Adreno, Streamline on Mali.
//!
//! Which counters a profiler has, and how each is made of ours, is data ([`Profiler`]). A counter that cannot be made is absent with its
//! reason, never zero.

mod expression;
mod figures;
mod profiler;
mod view;

pub use figures::{GPU_FIGURES, GpuFigure};
pub use profiler::{Formula, KnownFormula, Profiler, VendorInfo};
pub use view::{VendorCounter, VendorPass, VendorView};
