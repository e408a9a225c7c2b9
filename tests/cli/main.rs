//! Does the command line do what it says: results, files, exit codes, refusals?

mod accuracy;
mod alpha;
mod bad_input;
mod bring_your_own;
mod cache;
mod compare;
mod determinism;
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
mod timed;
mod timeline;
mod two_level;
mod vendor;
mod verify;
mod whatif;
