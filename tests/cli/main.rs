//! Does the command line do what it says: results, files, exit codes, refusals?

mod accuracy;
mod alpha;
mod bad_input;
mod cache;
mod compare;
mod determinism;
mod frame_budgets;
mod machine;
mod miss_trace;
mod needs;
mod outputs;
mod ray_sets;
mod reflections;
mod render;
mod results;
mod samples;
mod stability;
mod stereo;
mod support;
mod sustained;
mod sweep;
mod timed;
mod two_level;
mod vendor;
mod verify;
mod whatif;
