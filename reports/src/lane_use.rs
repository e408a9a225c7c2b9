//! How full the lanes of warps are: those that trace reflection rays in lockstep, and those whose rays a ray unit tests together.

use crate::chart::{BarChart, Scale, Series};
use gpumodel::reflections::LaneSlots;
use gpumodel::{FrameCounters, IssueCounters, Pass};

/// A heat map's values ([`heat_map`](crate::heat_map)) of the lane slots that each pixel's warp wasted, in per cent, 0 to 100.
pub fn wasted_per_cent(lane_slots: &[Option<LaneSlots>]) -> Vec<u32> {
    let value = |slots: &Option<LaneSlots>| {
        slots.map_or(crate::heat_map::NO_VALUE, |slots| (100.0 * slots.wasted()).round() as u32)
    };
    lane_slots.iter().map(value).collect()
}

/// Nodes that a ray unit tested for the rays of a warp together, by how many rays those were.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnitOccupancy {
    warp_width: u32,
    passes: Vec<PassOccupancy>,
}

/// Of one pass.
#[derive(Clone, Debug, PartialEq, Eq)]
struct PassOccupancy {
    name: &'static str,
    /// What was tested, and nodes by quarters of the lanes of a warp.
    kinds: [(&'static str, [u64; 4]); 2],
}

/// The columns of [`UnitOccupancy::csv`].
const COLUMNS: [&str; 6] = ["pass", "tests", "rays_from", "rays_to", "nodes", "per_cent"];

impl UnitOccupancy {
    /// That of a frame's passes; none where no node was tested in a unit.
    pub fn of(counters: &FrameCounters, warp_width: u32) -> Option<Self> {
        let of_pass = |pass: Pass| {
            let IssueCounters {
                box_nodes_quarter,
                box_nodes_half,
                box_nodes_three_quarters,
                box_nodes_full,
                triangle_nodes_quarter,
                triangle_nodes_half,
                triangle_nodes_three_quarters,
                triangle_nodes_full,
                ..
            } = counters.pass(pass).issue;
            let boxes = [box_nodes_quarter, box_nodes_half, box_nodes_three_quarters, box_nodes_full];
            let triangles = [
                triangle_nodes_quarter,
                triangle_nodes_half,
                triangle_nodes_three_quarters,
                triangle_nodes_full,
            ];
            let any = boxes.iter().chain(&triangles).any(|&nodes| nodes > 0);
            any.then_some(PassOccupancy {
                name: pass.name(),
                kinds: [("boxes", boxes), ("triangles", triangles)],
            })
        };
        let passes: Vec<_> = Pass::ALL.into_iter().filter_map(of_pass).collect();
        (!passes.is_empty()).then_some(Self { warp_width, passes })
    }

    /// By bin, the rays that share a test: the least and the most.
    fn bins(&self) -> [[u32; 2]; 4] {
        [0, 1, 2, 3].map(|bin| [self.warp_width * bin / 4 + 1, self.warp_width * (bin + 1) / 4])
    }

    /// Shares of the nodes tested, in per cent, by how many rays were at a node together; by pass where several trace.
    pub fn chart(&self, subtitle: String) -> BarChart {
        let name = |kind: &str, pass: &str| match self.passes.len() {
            1 => kind.to_owned(),
            _ => format!("{kind}, {pass}"),
        };
        let series = self.passes.iter().flat_map(|pass| {
            pass.kinds.map(|(kind, nodes)| Series {
                name: name(kind, pass.name),
                values: nodes.map(|of_bin| per_cent(of_bin, nodes)).into(),
            })
        });
        BarChart {
            title: "Rays that the ray unit tests together".to_owned(),
            subtitle,
            value_label: "nodes tested (%)".to_owned(),
            groups: self
                .bins()
                .map(|[from, to]| format!("{from} to {to} of {} rays", self.warp_width))
                .into(),
            series: series.collect(),
            scale: Scale::Linear,
        }
    }

    /// The same as a table, with the nodes themselves; `per_cent` is empty where a pass tested none of a kind.
    pub fn csv(&self) -> String {
        let mut table = csv::Writer::from_writer(Vec::new());
        let mut write = |row: [String; 6]| {
            table.write_record(row).expect("memory takes every record, and all have as many columns");
        };
        write(COLUMNS.map(str::to_owned));
        for PassOccupancy { name, kinds } in &self.passes {
            for (kind, nodes) in kinds {
                for ([from, to], &of_bin) in self.bins().into_iter().zip(nodes) {
                    let share = per_cent(of_bin, *nodes).map_or(String::new(), |share| format!("{share:.3}"));
                    let [from, to, count] = [u64::from(from), u64::from(to), of_bin].map(|n| n.to_string());
                    write([(*name).to_owned(), (*kind).to_owned(), from, to, count, share]);
                }
            }
        }
        let bytes = table.into_inner().expect("memory takes every byte");
        String::from_utf8(bytes).expect("made of strings")
    }
}

fn per_cent(part: u64, all: [u64; 4]) -> Option<f64> {
    let sum: u64 = all.iter().sum();
    (sum > 0).then(|| 100.0 * part as f64 / sum as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::heat_map::NO_VALUE;

    fn counters(boxes: [u64; 4], shadows: bool) -> FrameCounters {
        let mut counters = FrameCounters::default();
        let issue = &mut counters.passes[Pass::Reflection as usize].issue;
        let [quarter, half, three_quarters, full] = boxes;
        issue.box_nodes_quarter = quarter;
        issue.box_nodes_half = half;
        issue.box_nodes_three_quarters = three_quarters;
        issue.box_nodes_full = full;
        if shadows {
            counters.passes[Pass::ReflectionShadow as usize].issue.triangle_nodes_full = 7;
        }
        counters
    }

    #[test]
    fn bars_are_shares_of_the_nodes_of_their_pass() {
        let occupancy = UnitOccupancy::of(&counters([10, 20, 30, 40], false), 16).expect("it tested nodes");
        let chart = occupancy.chart("a frame".to_owned());
        assert_eq!(chart.groups[0], "1 to 4 of 16 rays");
        assert_eq!(chart.groups[3], "13 to 16 of 16 rays");
        assert_eq!(chart.series[0].values, [10.0, 20.0, 30.0, 40.0].map(Some));
        assert_eq!(chart.series[0].name, "boxes");
        assert_eq!(chart.series[1].values, [None; 4]);
        assert!(chart.svg().is_ok() && chart.png().is_ok());
    }

    #[test]
    fn passes_stand_apart_in_chart_and_table() {
        let occupancy = UnitOccupancy::of(&counters([1, 0, 0, 1], true), 32).expect("it tested nodes");
        let names: Vec<String> = occupancy.chart(String::new()).series.into_iter().map(|s| s.name).collect();
        assert_eq!(names[0], "boxes, reflection rays");
        assert_eq!(names[3], "triangles, reflection shadow rays");
        let table = occupancy.csv();
        assert_eq!(table.lines().count(), 1 + 2 * 2 * 4);
        assert!(table.contains("\nreflection rays,boxes,25,32,1,50.000\n"), "{table}");
        assert!(table.contains("\nreflection shadow rays,boxes,1,8,0,\n"), "{table}");
    }

    #[test]
    fn without_a_unit_there_is_no_occupancy() {
        assert_eq!(UnitOccupancy::of(&FrameCounters::default(), 16), None);
    }

    #[test]
    fn pixels_without_a_ray_waste_nothing_that_could_be_shown() {
        let slots = |lanes, warp_steps, lane_steps| Some(LaneSlots { lanes, warp_steps, lane_steps });
        assert_eq!(wasted_per_cent(&[None, slots(2, 4, 5), slots(1, 9, 9)]), [NO_VALUE, 38, 0]);
    }
}
