//! A study of several poses: what its rows are worth over all of them.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use serde::Serialize;

use super::super::StudyError;
use super::super::store::write_json;
use super::figures::StudyReport;
use super::text::judged;
use crate::film::atomic;
use crate::metric::Fidelity;
use crate::run::format::three_digits;
use crate::setting::Given;

/// The figures of a study of several poses.
#[derive(Clone, Debug, Serialize)]
pub struct PosesReport {
    /// The scene file, as it was named.
    pub scene: String,
    /// The poses, in the order of the study.
    pub poses: Vec<Pose>,
    /// One entry for each run of a sensor.
    pub rows: Vec<PosesRow>,
}

/// A pose: the scene under some parameters.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pose {
    /// Its parameters.
    pub define: Given,
    /// The folder of its own report, beside this one.
    pub folder: String,
}

/// A run over all poses.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PosesRow {
    /// The sensor's id.
    pub sensor: String,
    /// The curve's name with the settings that are not defaults.
    pub label: String,
    /// Flux over the truth's; the worst is farthest from 1.
    pub energy: OverPoses,
    /// L1: Σ |d| / Σ r.
    pub l1: OverPoses,
    /// How far light is from its place, on average \[texels\].
    pub displaced: OverPoses,
}

/// A figure over all poses.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OverPoses {
    /// By pose; `None` if it is unknown there.
    pub by_pose: Vec<Option<f64>>,
    /// The mean of those that are known.
    pub mean: Option<f64>,
    /// The worst of them.
    pub worst: Option<f64>,
    /// Its pose, from 0.
    pub worst_pose: Option<usize>,
}

impl OverPoses {
    /// Figures whose ideal value is known.
    fn new(by_pose: Vec<Option<f64>>, ideal: f64) -> Self {
        let known = || by_pose.iter().enumerate();
        let known = || known().filter_map(|(pose, value)| Some((pose, (*value)?)));
        let count = known().count() as f64;
        let sum: f64 = known().map(|(_, value)| value).sum();
        let off = |value: f64| (value - ideal).abs();
        let worst = known().max_by(|a, b| off(a.1).total_cmp(&off(b.1)));
        Self {
            mean: (count > 0.0).then(|| sum / count),
            worst: worst.map(|(_, value)| value),
            worst_pose: worst.map(|(pose, _)| pose),
            by_pose,
        }
    }

    fn told(&self) -> [String; 2] {
        let told = |value: Option<f64>| value.map_or("-".to_owned(), three_digits);
        let pose = self.worst_pose.map_or(0, |pose| pose + 1);
        [
            told(self.mean),
            format!("{} (pose {pose})", told(self.worst)),
        ]
    }
}

impl PosesReport {
    /// The figures of some poses' reports.
    pub fn new(reports: &[(Pose, StudyReport)]) -> Self {
        let mut rows = Vec::new();
        let sensors = reports.iter().flat_map(|(_, report)| &report.sensors);
        for sensor in sensors {
            for row in &sensor.rows {
                let is_known =
                    |known: &PosesRow| known.sensor == sensor.sensor && known.label == row.label;
                if !rows.iter().any(is_known) {
                    rows.push(over_poses(reports, &sensor.sensor, &row.label));
                }
            }
        }
        Self {
            scene: reports
                .first()
                .map_or_else(String::new, |(_, report)| report.study.scene.clone()),
            poses: reports.iter().map(|(pose, _)| pose.clone()).collect(),
            rows,
        }
    }

    /// The summary for a reader.
    pub fn markdown(&self) -> String {
        let mut out = format!(
            "## nephroid validate: {}, {} poses\n",
            self.scene,
            self.poses.len()
        );
        for (number, pose) in (1..).zip(&self.poses) {
            // Writing to a string does not fail.
            let _ = writeln!(
                out,
                "\n{number}. {} (`{}`)",
                parameters(&pose.define),
                pose.folder
            );
        }
        out.push_str(
            "\n| sensor | run | energy | worst | L1 | worst | displaced [texels] | worst |\n\
             |---|---|--:|--:|--:|--:|--:|--:|\n",
        );
        for row in &self.rows {
            let figures = [&row.energy, &row.l1, &row.displaced].map(OverPoses::told);
            let _ = writeln!(
                out,
                "| {} | {} | {} |",
                row.sensor,
                row.label,
                figures.concat().join(" | ")
            );
        }
        out.push_str(
            "\nMeans over the poses, and the worst pose. Energy: flux over the truth's. L1: sum of absolute differences over the \
             truth's sum, as a fraction. Displaced: how far light is from its place, on average. Each pose has a truth of its own.\n",
        );
        out
    }

    /// Writes `poses.json` and `poses.md` into a folder that exists.
    ///
    /// # Errors
    ///
    /// If a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), StudyError> {
        write_json(&folder.join("poses.json"), self)?;
        let text = self.markdown();
        atomic::write(&folder.join("poses.md"), |file| {
            file.write_all(text.as_bytes())
        })?;
        Ok(())
    }
}

/// Parameters as people read them.
pub fn parameters(define: &Given) -> String {
    let told = define.iter().map(|(key, value)| format!("{key}={value}"));
    told.collect::<Vec<_>>().join(", ")
}

fn over_poses(reports: &[(Pose, StudyReport)], sensor: &str, label: &str) -> PosesRow {
    let figure = |ideal: f64, figure: fn(&Fidelity) -> Option<f64>| {
        let by_pose = reports.iter().map(|(_, report)| {
            let sensor = report.sensors.iter().find(|one| one.sensor == sensor)?;
            let row = sensor.rows.iter().find(|row| row.label == label)?;
            figure(&judged(row)?.fidelity)
        });
        OverPoses::new(by_pose.collect(), ideal)
    };
    PosesRow {
        sensor: sensor.to_owned(),
        label: label.to_owned(),
        energy: figure(1.0, |light| Some(light.energy?.value)),
        l1: figure(0.0, |light| Some(light.l1?.value)),
        displaced: figure(0.0, |light| Some(light.displaced.as_ref()?.texels.value)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_is_farthest_from_what_it_should_be_and_unknown_figures_do_not_count() {
        let energy = OverPoses::new(vec![Some(1.1), None, Some(0.7), Some(1.2)], 1.0);
        assert!((energy.mean.unwrap() - 1.0).abs() < 1e-15);
        assert_eq!((energy.worst, energy.worst_pose), (Some(0.7), Some(2)));
        let unknown = OverPoses::new(vec![None, None], 0.0);
        assert_eq!((unknown.mean, unknown.worst), (None, None));
    }
}
