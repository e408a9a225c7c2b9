//! The errors as pictures.

use super::{Accuracy, Point, percent};
use crate::chart::{BarChart, MatrixChart, Scale, Series};

/// The charts with their subtitle: the signed error of every frame, and the mean of each scene on each GPU; of the latter no chart
/// where there are more GPUs than a chart of bars can tell apart.
pub fn charts(accuracy: &Accuracy, subtitle: &str) -> (MatrixChart, Option<BarChart>) {
    let Accuracy { ours, reference, points, limits } = accuracy;
    let frame = |point: &Point| format!("{} {}", point.scene, point.traversal);
    let frames = distinct(points.iter().map(frame));
    let gpus = distinct(points.iter().map(|point| point.gpu.clone()));
    let scenes = distinct(points.iter().map(|point| point.scene.clone()));
    let value = |frame_name: &String, gpu: &String| {
        let found = points.iter().find(|point| frame(point) == *frame_name && point.gpu == *gpu);
        found.map(|point| (1e3 * point.time_error()).round() / 10.0)
    };
    let matrix = MatrixChart {
        title: format!("Error of the frame time: '{ours}' against '{reference}'"),
        subtitle: format!("{subtitle}; limit {} either way", percent(limits.worst)),
        x_label: "GPU".to_owned(),
        y_label: "scene and traversal".to_owned(),
        value_label: "error (%)".to_owned(),
        values: frames.iter().map(|frame| gpus.iter().map(|gpu| value(frame, gpu)).collect()).collect(),
        xs: gpus.clone(),
        ys: frames,
    };
    let mean = |scene: &String, gpu: &String| {
        let of = points.iter().filter(|point| point.scene == *scene && point.gpu == *gpu);
        let errors: Vec<f64> = of.map(|point| point.time_error().abs()).collect();
        let mean = 100.0 * errors.iter().sum::<f64>() / errors.len() as f64;
        (!errors.is_empty()).then_some((10.0 * mean).round() / 10.0)
    };
    let series = |gpu: &String| Series {
        name: gpu.clone(),
        values: scenes.iter().map(|scene| mean(scene, gpu)).collect(),
    };
    let bars = BarChart {
        title: format!("Mean error of the frame time: '{ours}' against '{reference}'"),
        subtitle: format!(
            "{subtitle}; mean of the traversals; limit of the mean of all frames {}",
            percent(limits.mean)
        ),
        value_label: "magnitude of the error (%)".to_owned(),
        series: gpus.iter().map(series).collect(),
        groups: scenes,
        scale: Scale::Linear,
    };
    (matrix, (gpus.len() <= MOST_SERIES).then_some(bars))
}

const MOST_SERIES: usize = 16;

/// Each name once, in the order of their first places.
fn distinct(names: impl Iterator<Item = String>) -> Vec<String> {
    let mut distinct: Vec<String> = Vec::new();
    for name in names {
        if !distinct.contains(&name) {
            distinct.push(name);
        }
    }
    distinct
}
