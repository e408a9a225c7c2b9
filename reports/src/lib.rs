//! Reports of ray-tracing cost estimates: text, JSON, CSV, charts, heat maps, budgets.
