//! Better or worse than on another day?

use crate::{
    error::MeasureError,
    report::{Report, Row, SCHEMA},
};
use serde::Serialize;

/// One figure on both days.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// `bvh2 binned aabb`.
    pub contender: String,
    /// `primary, batch, 2 threads`, `build`, `memory`.
    pub what: String,
    /// As it was.
    pub before: f64,
    /// As it is.
    pub now: f64,
    /// `Mray/s`, `ms`, `bytes`.
    pub unit: &'static str,
    /// By which part it got better; negative: worse. What the yardstick says of the machine is taken out.
    pub better: f64,
    /// Changes up to this are noise: to `1 + noise` times as fast, or as slow.
    pub noise: f64,
}

impl Change {
    /// True if it got worse by more than noise.
    pub fn is_regression(&self) -> bool {
        1.0 + self.better < 1.0 / (1.0 + self.noise)
    }

    /// True if it got better by more than noise.
    pub fn is_improvement(&self) -> bool {
        self.better > self.noise
    }
}

/// Two runs side by side.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// When the earlier run was, and of which commit.
    pub baseline: String,
    /// How many times as fast the machine is now by the yardstick.
    pub machine_speed: f64,
    /// False if processor or system are others: then the figures say little.
    pub same_machine: bool,
    /// Every figure that both have.
    pub changes: Vec<Change>,
    /// Contenders of the earlier run that this one has not.
    pub missing: Vec<String>,
}

impl Comparison {
    /// What got worse by more than noise, the worst first.
    pub fn regressions(&self) -> Vec<&Change> {
        let mut worse: Vec<_> = self
            .changes
            .iter()
            .filter(|change| change.is_regression())
            .collect();
        worse.sort_by(|a, b| a.better.total_cmp(&b.better));
        worse
    }
}

/// Reads a saved report; `file` is its name, for the error.
///
/// # Errors
/// [`MeasureError::Report`] if it is none, or of another schema.
pub fn read(file: &str, text: &str) -> Result<Report, MeasureError> {
    let refused = |cause: String| MeasureError::Report {
        file: file.to_owned(),
        cause,
    };
    let value: serde_json::Value =
        serde_json::from_str(text).map_err(|error| refused(format!("is not JSON: {error}")))?;
    match value["schema"].as_u64() {
        Some(schema) if schema == u64::from(SCHEMA) => {}
        Some(schema) => {
            let cause = format!("has schema {schema}, this program knows {SCHEMA}");
            return Err(refused(cause));
        }
        None => return Err(refused("is not a report of measurements".to_owned())),
    }
    let report: Report = serde_json::from_value(value)
        .map_err(|error| refused(format!("is not a whole report: {error}")))?;
    match impossible(&report) {
        Some(who) => Err(refused(format!(
            "is not a whole report: a figure of {who} is not above 0"
        ))),
        None => Ok(report),
    }
}

/// A contender with a rate or time that nothing can be compared with.
fn impossible(report: &Report) -> Option<&str> {
    let is_above_0 = |x: f64| x > 0.0 && x.is_finite();
    let is_whole =
        |row: &Row| is_above_0(row.build_ms) && row.cells.iter().all(|cell| is_above_0(cell.mrays));
    let row = report.rows.iter().find(|row| !is_whole(row))?;
    Some(&row.name)
}

/// Compares `now` with `before`, whose file's name is for the error. A change counts if it is larger than `tolerance` and than
/// three times the spread of the rounds of both runs.
///
/// # Errors
/// [`MeasureError::Report`] if the scenes or the rays differ.
pub fn compare(
    now: &Report,
    before: &Report,
    file: &str,
    tolerance: f64,
) -> Result<Comparison, MeasureError> {
    let (a, b) = (&now.scene, &before.scene);
    if (a.triangles, a.rays_per_set, &a.sets) != (b.triangles, b.rays_per_set, &b.sets) {
        let of = |s: &crate::SceneInfo| {
            format!(
                "{} ({} triangles, {} rays a set)",
                s.name, s.triangles, s.rays_per_set
            )
        };
        return Err(MeasureError::Report {
            file: file.to_owned(),
            cause: format!("is of {}, not of {}", of(b), of(a)),
        });
    }
    let machine_speed = faster(before.yardstick_ns, now.yardstick_ns);
    let machine_noise = now.yardstick_noise.hypot(before.yardstick_noise);
    let mut changes = Vec::new();
    let mut missing = Vec::new();
    for old in &before.rows {
        let Some(new) = now.rows.iter().find(|row| row.name == old.name) else {
            missing.push(old.name.clone());
            continue;
        };
        let change =
            |what: String, unit, [before, now]: [f64; 2], better: f64, noise: f64| Change {
                contender: old.name.clone(),
                what,
                before,
                now,
                unit,
                better,
                noise,
            };
        let noise = |parts: &[f64]| {
            let sum: f64 = parts.iter().map(|part| part * part).sum();
            (3.0 * sum.sqrt()).max(tolerance)
        };
        for cell in &new.cells {
            let Some(earlier) = old.cell(&cell.set, cell.mode, cell.threads) else {
                continue;
            };
            let speed = faster(earlier.yardstick_ns, cell.yardstick_ns);
            let better = cell.mrays / earlier.mrays / speed - 1.0;
            let parts = [earlier, cell].map(|cell| cell.noise.hypot(cell.yardstick_noise));
            let values = [earlier.mrays, cell.mrays];
            changes.push(change(
                cell.label(),
                "Mray/s",
                values,
                better,
                noise(&parts),
            ));
        }
        let builds = [old.build_ms, new.build_ms];
        let better = builds[0] / builds[1] / machine_speed - 1.0;
        // Builds are few and long: there is less to take the median of.
        let build_noise = 2.0 * noise(&[new.build_noise, old.build_noise, machine_noise]);
        changes.push(change(
            "build, 1 thread".to_owned(),
            "ms",
            builds,
            better,
            build_noise,
        ));
        if let (Some(was), Some(is)) = (old.bytes, new.bytes) {
            let values = [was as f64, is as f64];
            changes.push(change(
                "memory".to_owned(),
                "bytes",
                values,
                was as f64 / is.max(1) as f64 - 1.0,
                0.01,
            ));
        }
    }
    Ok(Comparison {
        baseline: format!(
            "{} of {}",
            before
                .machine
                .commit
                .as_deref()
                .unwrap_or(&before.machine.version),
            before.date
        ),
        machine_speed,
        same_machine: (&now.machine.cpu, &now.machine.system)
            == (&before.machine.cpu, &before.machine.system),
        changes,
        missing,
    })
}

/// How many times as fast the machine is now by the yardstick; 1 where it was not measured.
fn faster(before_ns: f64, now_ns: f64) -> f64 {
    if before_ns > 0.0 && now_ns > 0.0 {
        before_ns / now_ns
    } else {
        1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::tests::report;

    #[test]
    fn the_same_again_is_no_regression() {
        let comparison = compare(&report(0.98), &report(1.0), "old.json", 0.05).unwrap();
        assert!(comparison.regressions().is_empty());
        assert_eq!(comparison.changes.len(), 2 * (3 + 2));
        assert!(comparison.same_machine);
    }

    #[test]
    fn a_slower_cell_is_found_and_named() {
        let mut slower = report(1.0);
        slower.rows[1].cells[1].mrays *= 0.8;
        let comparison = compare(&slower, &report(1.0), "old.json", 0.05).unwrap();
        let worse = comparison.regressions();
        assert_eq!(worse.len(), 1);
        assert_eq!(
            (&*worse[0].contender, &*worse[0].what),
            ("grid & co", "primary, batch, 1 thread")
        );
        assert!((worse[0].better + 0.2).abs() < 1e-9 && worse[0].noise == 0.05);
    }

    #[test]
    fn a_slower_machine_is_no_regression_but_a_noisy_cell_needs_more() {
        let mut slow = report(0.5);
        slow.yardstick_ns *= 2.0;
        for row in &mut slow.rows {
            row.build_ms *= 2.0;
            row.cells
                .iter_mut()
                .for_each(|cell| cell.yardstick_ns *= 2.0);
        }
        let comparison = compare(&slow, &report(1.0), "old.json", 0.05).unwrap();
        assert!(comparison.regressions().is_empty() && comparison.machine_speed == 0.5);
        let mut noisy = report(1.0);
        noisy.rows[0].cells[0].mrays *= 0.8;
        noisy.rows[0].cells[0].noise = 0.1;
        assert!(
            compare(&noisy, &report(1.0), "old.json", 0.05)
                .unwrap()
                .regressions()
                .is_empty()
        );
    }

    #[test]
    fn builds_memory_and_missing_contenders_count_too() {
        let mut worse = report(1.0);
        worse.rows[0].build_ms *= 1.5;
        worse.rows[0].bytes = Some(6000);
        worse.rows.pop();
        let comparison = compare(&worse, &report(1.0), "old.json", 0.05).unwrap();
        let whats: Vec<_> = comparison
            .regressions()
            .iter()
            .map(|c| c.what.clone())
            .collect();
        assert_eq!(whats, ["build, 1 thread", "memory"]);
        assert_eq!(comparison.missing, ["grid & co"]);
    }

    #[test]
    fn what_is_no_report_of_this_scene_is_refused_with_the_cause() {
        let refusal = |text: &str| read("old.json", text).unwrap_err().to_string();
        assert!(refusal("nonsense").starts_with("old.json: is not JSON"));
        assert!(refusal("{}").starts_with("old.json: is not a report"));
        assert!(refusal(r#"{"schema": 99}"#).contains("has schema 99"));
        assert!(refusal(r#"{"schema": 1}"#).contains("is not a whole report"));
        for rate in [-1.0, 0.0] {
            let mut broken = report(1.0);
            broken.rows[1].cells[0].mrays = rate;
            let text = serde_json::to_string(&broken).unwrap();
            assert!(
                refusal(&text).contains("grid & co is not above 0"),
                "{}",
                refusal(&text)
            );
        }
        let mut other = report(1.0);
        other.scene.triangles = 7;
        let error = compare(&report(1.0), &other, "old.json", 0.05)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("(7 triangles") && error.contains("--save"),
            "{error}"
        );
    }
}
