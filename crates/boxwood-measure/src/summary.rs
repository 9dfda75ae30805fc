//! A report in sentences: who is fastest, and what keeps its figures from being taken at their word.

use crate::{
    contender::Mode,
    html::digits,
    report::{Cell, Report, Row},
    statistics::geometric_mean,
};

/// A figure whose rounds lie farther apart than this part of it was disturbed.
const BUSY: f64 = 0.2;

impl Cell {
    /// Whether the rounds lie so far apart that the figure says little.
    pub fn is_unsteady(&self) -> bool {
        self.noise > BUSY
    }
}

impl Report {
    /// Interrupted or not optimised: what a reader must know first. Empty as a rule.
    pub fn notices(&self) -> Vec<String> {
        let interrupted = "Interrupted: what is missing was not measured.";
        let debug = "This is a debug build: the figures are worthless.";
        let notices = [
            (!self.complete).then_some(interrupted),
            (!self.machine.optimised).then_some(debug),
        ];
        notices.into_iter().flatten().map(str::to_owned).collect()
    }

    /// The fastest contender on one thread for rays handed over in this way, and its rate: by the geometric mean over all sets
    /// that were measured, of those that have all of them.
    pub fn fastest(&self, mode: Mode) -> Option<(&Row, f64)> {
        let most = |row: &Row| row.rates(mode, true).len();
        let sets = self.rows.iter().map(most).max().filter(|sets| *sets > 0)?;
        let whole = self.rows.iter().filter(|row| most(row) == sets);
        whole
            .map(|row| (row, geometric_mean(row.rates(mode, true).into_values())))
            .max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Who is fastest, in a sentence; none of fewer than two contenders.
    pub fn verdict(&self) -> Option<String> {
        let of = |mode, name: &str| {
            let (row, mrays) = self.fastest(mode)?;
            Some(format!(
                "for {name} {} ({} Mrays/s)",
                row.name,
                digits(mrays)
            ))
        };
        let parts = [of(Mode::Single, "single rays"), of(Mode::Batch, "batches")];
        let parts: Vec<String> = parts.into_iter().flatten().collect();
        let raced = self.rows.iter().filter(|row| !row.cells.is_empty()).count();
        (raced > 1 && !parts.is_empty()).then(|| {
            let sets = self.measured_sets().len();
            let sets = if sets == 1 {
                "1 set".to_owned()
            } else {
                format!("{sets} sets")
            };
            format!(
                "Fastest on one thread, by the geometric mean over {sets}: {}.",
                parts.join(", ")
            )
        })
    }

    /// Whether others used the machine too; none if nothing shows of them.
    pub fn busy(&self) -> Option<String> {
        let all = self.cells().count();
        let unsteady = self.cells().filter(|cell| cell.is_unsteady()).count();
        (unsteady > 0).then(|| {
            format!(
                "The machine was busy: {unsteady} of {all} figures vary by more than {:.0} % (~).",
                BUSY * 100.0
            )
        })
    }

    /// What `est.` means here; none if nothing is estimated.
    pub fn estimates(&self) -> Option<String> {
        let all = self.scene.rays_per_set;
        let samples = || {
            self.cells()
                .map(|cell| cell.rays)
                .filter(|rays| *rays < all)
        };
        let (least, most) = (samples().min()?, samples().max()?);
        let range = if least == most {
            least.to_string()
        } else {
            format!("{least} to {most}")
        };
        Some(format!(
            "est.: asked about a sample, {range} of the {all} rays of a set."
        ))
    }

    /// What is to be thought of the estimated limit where figures are above it; none if none are.
    pub fn too_high<'a>(cells: impl Iterator<Item = &'a Cell>) -> Option<String> {
        let parts: Vec<f64> = cells.filter_map(|cell| cell.of_floor).collect();
        let above = parts.iter().filter(|part| **part > 1.0).count();
        (above > 0).then(|| {
            format!(
                "{above} of {} figures are above 1: the estimate is too high there.",
                parts.len()
            )
        })
    }

    /// All that was measured of rays.
    pub fn cells(&self) -> impl Iterator<Item = &Cell> {
        self.rows.iter().flat_map(|row| &row.cells)
    }

    /// Names of the sets of which anything was measured.
    pub fn measured_sets(&self) -> Vec<&str> {
        let is_measured = |set: &&str| self.cells().any(|cell| cell.set == *set);
        let sets = self.scene.sets.iter().map(|set| &**set);
        sets.filter(is_measured).collect()
    }

    /// The ways in which anything was asked: one thread before many, single rays before batches.
    pub fn measured_ways(&self) -> Vec<(Mode, usize)> {
        let mut threads = vec![1, self.threads];
        threads.dedup();
        let is_measured = |&(mode, threads): &(Mode, usize)| {
            self.cells()
                .any(|cell| (cell.mode, cell.threads) == (mode, threads))
        };
        threads
            .into_iter()
            .flat_map(|threads| Mode::ALL.map(|mode| (mode, threads)))
            .filter(is_measured)
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use crate::{Mode, Report, report::tests::report};

    #[test]
    fn the_fastest_is_so_over_all_sets() {
        let mut report = report(1.0);
        let (row, mrays) = report.fastest(Mode::Single).unwrap();
        assert_eq!(row.name, "bvh2");
        assert!((mrays - (3.0_f64 * 1.5).sqrt()).abs() < 1e-9);
        let verdict = report.verdict().unwrap();
        assert!(
            verdict.contains("2 sets: for single rays bvh2 (2.12 Mrays/s), for batches bvh2 (4.00"),
            "{verdict}"
        );
        // Fast, but only where it was asked.
        report.rows[1].cells.truncate(1);
        report.rows[1].cells[0].mrays = 1e6;
        assert_eq!(report.fastest(Mode::Single).unwrap().0.name, "bvh2");
        report.rows.truncate(1);
        assert_eq!(report.verdict(), None);
    }

    #[test]
    fn what_was_disturbed_sampled_or_beyond_the_estimate_is_counted() {
        let mut report = report(1.0);
        assert_eq!((report.busy(), report.estimates()), (None, None));
        assert_eq!(Report::too_high(report.cells()), None);
        report.rows[0].cells[0].noise = 0.3;
        report.rows[0].cells[1].rays = 64;
        report.rows[0].cells[2].of_floor = Some(1.2);
        assert!(report.busy().unwrap().contains("1 of 6 figures"));
        assert!(report.estimates().unwrap().contains("64 of the 4096 rays"));
        let too_high = Report::too_high(report.cells()).unwrap();
        assert!(too_high.contains("1 of 6 figures"), "{too_high}");
    }

    #[test]
    fn what_was_not_measured_is_left_out() {
        let mut report = report(1.0);
        assert_eq!(report.measured_sets(), ["primary", "random"]);
        let [single, batch] = Mode::ALL.map(|mode| (mode, 1));
        assert_eq!(report.measured_ways(), [single, batch]);
        assert!(report.notices().iter().all(|text| text.contains("debug")));
        report.complete = false;
        assert!(report.notices()[0].starts_with("Interrupted"));
        report.rows.iter_mut().for_each(|row| row.cells.truncate(1));
        assert_eq!(report.measured_sets(), ["primary"]);
        assert_eq!(report.measured_ways(), [single]);
    }
}
