//! Cache hierarchy simulation over address streams: exact, deterministic, fast.
