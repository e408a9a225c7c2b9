//! Replays ray traces through a described mobile GPU: layouts, warps, caches, ALU, time.
