//! What was asked, what the figures do not contain, and what the run cost.

use super::markup::{sentences, terms};
use crate::report::{Forced, Hashes, Inputs, Report, Run};
use crate::units;

pub(super) fn inputs(report: &Report) -> String {
    let Inputs {
        scene,
        gpu,
        accel,
        traversal,
        layout,
        technique,
        primitive_order,
        node_records,
        node_order,
        ray_unit,
        width,
        height,
        seed,
        hashes,
        triangles,
        ray_sets,
        samples_per_pixel,
        shadow_query,
        sah_costs,
        short_stack,
        trail_bits,
        node_format,
    } = &report.inputs;
    let Hashes { scene: scene_hash, gpu: gpu_hash, costs: costs_hash, energy: energy_hash } = hashes;
    let size = match (width, height) {
        (Some(width), Some(height)) => format!("{width} \u{d7} {height} pixels"),
        _ => "a list of rays".to_owned(),
    };
    let always = [
        ("scene", scene.clone()),
        ("triangles", units::grouped(u64::from(*triangles))),
        ("size", size),
        ("ray sets", ray_sets.join(" + ")),
        ("GPU", gpu.clone()),
        ("structure", accel.clone()),
        ("traversal", traversal.clone()),
        ("technique", technique.clone()),
        ("primitive layout", layout.clone()),
        ("primitive order", primitive_order.clone()),
        ("node records", node_records.clone()),
        ("node order", node_order.clone()),
        ("SAH costs Ct, Ci", format!("{}, {}", sah_costs[0], sah_costs[1])),
    ];
    let sometimes = [
        ("samples per pixel", samples_per_pixel.map(|samples| samples.to_string())),
        ("shadow query", shadow_query.clone()),
        ("node format", node_format.clone()),
        ("ray unit", ray_unit.as_ref().map(|by| format!("schedules by {by}"))),
        ("short stack", (*short_stack > 0).then(|| format!("{short_stack} entries"))),
        ("restart trail", trail_bits.map(|bits| format!("{bits} bits"))),
        ("seed", seed.map(|seed| seed.to_string())),
        ("hash of the scene", Some(scene_hash.clone())),
        ("hash of the GPU", Some(gpu_hash.clone())),
        ("hash of the costs", Some(costs_hash.clone())),
        ("hash of the energies", energy_hash.clone()),
        ("program", Some(report.tool.clone())),
    ];
    let sometimes = sometimes.into_iter().filter_map(|(term, text)| Some((term, text?)));
    terms(always.into_iter().filter(|(_, text)| !text.is_empty()).chain(sometimes))
}

/// What is not in the figures, what was forced, what is an estimate, and what was noticed.
pub(super) fn honesty(report: &Report) -> String {
    let left_out: Vec<String> =
        report.left_out.iter().map(|entry| format!("{}: {}", entry.what, entry.why)).collect();
    let forced = |Forced { what, choice, cost, .. }: &Forced| format!("{what}, forced {choice}: {cost}");
    let forced: Vec<String> = report.forced.iter().map(forced).collect();
    [
        ("Left out of these figures", &left_out),
        ("Forced against the needs of the scene", &forced),
        ("Estimates and assumptions", &report.assumptions),
        ("The scene", &report.notes),
    ]
    .map(|(title, texts)| sentences(title, texts.iter().map(String::as_str)))
    .concat()
}

pub(super) fn run(run: &Run) -> String {
    let Run {
        wall_s,
        peak_rss_bytes,
        fidelity,
        sampled_fraction,
        threads,
        load_s,
        build_s,
        replay_s,
        within,
    } = run;
    let part = if *sampled_fraction < 1.0 {
        format!("{} % of the tiles", units::digits(sampled_fraction * 100.0))
    } else {
        "every access".to_owned()
    };
    let build = build_s.map_or(String::new(), |s| format!(", build {s:.3} s"));
    let always = [
        ("rung of fidelity", format!("{}, {part}", fidelity.name())),
        ("wall time", format!("{wall_s:.3} s (load {load_s:.3} s{build}, trace and replay {replay_s:.3} s)")),
        ("threads", threads.to_string()),
    ];
    let memory = peak_rss_bytes.map(|bytes| {
        let (size, unit) = units::scale("B", bytes as f64);
        format!("{} {unit}", units::digits(bytes as f64 / size))
    });
    let sometimes = [("peak memory", memory), ("error", within.as_ref().map(crate::within::Within::text))];
    terms(always.into_iter().chain(sometimes.into_iter().filter_map(|(term, text)| Some((term, text?)))))
}
