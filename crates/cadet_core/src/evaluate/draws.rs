//! AP of draws of frames with replacement: what a bootstrap needs. Overlaps and each frame's first pass are computed once
//! and serve all draws.

use rayon::prelude::*;

use super::curves::{average_r11, average_r40};
use super::matching::FirstPass;
use super::metric::{Metric, Settings};
use super::objects::FramePair;
use super::prepared::{Prepared, Task};
use cadet_base::error::Error;
use cadet_base::parallel;

/// AP of one class, metric and level in each draw.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnAp {
    /// Index of the class in the settings.
    pub class: usize,
    /// The metric.
    pub metric: Metric,
    /// Index of the level in the settings.
    pub level: usize,
    /// With 11 and 40 recall positions, in percent; NaN where a draw has no object to find.
    pub ap: Vec<[f64; 2]>,
    /// Mean heading similarity with 11 and 40 recall positions, in percent; NaN where a draw has no object to find.
    /// None where [`super::Curve::heading`] is.
    pub heading: Option<Vec<[f64; 2]>>,
}

/// Compares detections with ground truth in draws of frames; a frame counts as often as it is drawn. `pause` is called
/// before each class, metric and level and may end it there.
///
/// A draw that holds each frame once has the AP of [`super::evaluate`], in any order.
///
/// # Errors
/// [`Error::OutOfRange`] for a draw of a frame that is not there, as [`super::evaluate`], and what `pause` returns.
///
/// # Determinism
/// The answer for a draw depends on nothing but the frames in it.
pub fn evaluate_draws<E: From<Error> + Send>(
    frames: &[FramePair],
    settings: &Settings,
    draws: &[Vec<u32>],
    mut pause: impl FnMut() -> Result<(), E> + Send,
) -> Result<Vec<DrawnAp>, E> {
    settings.check()?;
    if let Some(index) = draws.iter().flatten().find(|&&index| index as usize >= frames.len()) {
        let expected = format!("an index below the number of frames, {}", frames.len());
        return Err(Error::OutOfRange { what: "drawn frame", value: index.to_string(), expected }.into());
    }
    parallel::run(|| {
        let prepared = Prepared::new(frames, settings);
        let drawn = |task: &Task| {
            let (criteria, Task { class, metric, level }) = (prepared.criteria(task), *task);
            let passes = prepared.first_passes(&criteria, class);
            let has_heading = prepared.has_heading(metric);
            let values: Vec<([f64; 2], [f64; 2])> = draws
                .par_iter()
                .map(|draw| {
                    let found = draw.iter().fold(FirstPass::default(), |mut found, &index| {
                        let pass = &passes[index as usize];
                        found.num_valid += pass.num_valid;
                        found.scores.extend_from_slice(&pass.scores);
                        found
                    });
                    if found.num_valid == 0 {
                        return ([f64::NAN; 2], [f64::NAN; 2]);
                    }
                    let (thresholds, tally) = prepared.second_pass(&criteria, class, draw, found);
                    let means = |samples| [average_r11(&samples), average_r40(&samples)];
                    (means(tally.precision(thresholds.len())), means(tally.heading_similarity(thresholds.len())))
                })
                .collect();
            let (ap, heading): (Vec<_>, Vec<_>) = values.into_iter().unzip();
            DrawnAp { class, metric, level, ap, heading: has_heading.then_some(heading) }
        };
        prepared.tasks().iter().map(|task| pause().map(|()| drawn(task))).collect()
    })
}
