//! Scenes for ray-tracing cost models: meshes, cameras, lights, loading, seeded generators.
