//! `--shard`: as typed, or as the farm's scheduler says.

use std::str::FromStr;

use boxwood_render::Shard;

use crate::output::Trouble;

/// As typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ShardChoice {
    Given(Shard),
    /// From the environment; it is looked at only then.
    Auto,
}

impl FromStr for ShardChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "auto" => Ok(Self::Auto),
            _ => text
                .parse()
                .map(Self::Given)
                .map_err(|error| format!("{error}, or auto")),
        }
    }
}

/// The variables of Slurm's job arrays.
const SLURM: &str = "SLURM_ARRAY_TASK_";
/// Of Kubernetes' indexed jobs, which do not tell how many there are.
const INDEX: &str = "JOB_COMPLETION_INDEX";
const COMPLETIONS: &str = "JOB_COMPLETIONS";

impl ShardChoice {
    /// `variable` gives the values of the environment.
    pub(super) fn resolve(
        self,
        variable: &dyn Fn(&str) -> Option<String>,
    ) -> Result<Shard, Trouble> {
        if let Self::Given(shard) = self {
            return Ok(shard);
        }
        let slurm = |name: &str| variable(&format!("{SLURM}{name}"));
        if slurm("COUNT").is_some_and(|count| count.trim() == "1") {
            return Err(Trouble::usage(
                "--shard auto: the Slurm array has one task, which cannot tell whose share it makes again",
                "to make a share again, give it, as in --shard 5/8; to make all in one task, leave out --shard",
            ));
        }
        if slurm("ID").is_some() {
            return of_slurm(&slurm).ok_or_else(|| {
                Trouble::usage(
                    "--shard auto: SLURM_ARRAY_TASK_ID, _MIN, _MAX and _COUNT are not those of an array with even steps",
                    "submit with --array=1-8 or the like, or give the share, as in --shard 2/8",
                )
            });
        }
        if variable(INDEX).is_some() {
            return of_kubernetes(variable).ok_or_else(|| {
                Trouble::usage(
                    format!("--shard auto: {INDEX} is set, but {COMPLETIONS} is not the number of all"),
                    format!("set {COMPLETIONS} in the job to the number of its `completions`, or give the share, as in --shard 2/8"),
                )
            });
        }
        Err(Trouble::usage(
            format!("--shard auto: neither {SLURM}ID nor {INDEX} is set"),
            "run it in a Slurm job array or an indexed Kubernetes job, or give the share, as in --shard 2/8",
        ))
    }
}

/// The place of this task in the array.
fn of_slurm(slurm: &dyn Fn(&str) -> Option<String>) -> Option<Shard> {
    let number = |name: &str| slurm(name)?.trim().parse::<i64>().ok();
    let (id, min, max) = (number("ID")?, number("MIN")?, number("MAX")?);
    let count = number("COUNT")?;
    if count < 2 {
        return None;
    }
    let step = (max.checked_sub(min)? / (count - 1)).max(1);
    let place = id.checked_sub(min)?;
    let even = min + step * (count - 1) == max && place % step == 0;
    even.then(|| shard(place / step, count)).flatten()
}

fn of_kubernetes(variable: &dyn Fn(&str) -> Option<String>) -> Option<Shard> {
    let number = |name: &str| variable(name)?.trim().parse::<i64>().ok();
    shard(number(INDEX)?, number(COMPLETIONS)?)
}

/// Counted from 0.
fn shard(index: i64, count: i64) -> Option<Shard> {
    format!("{}/{count}", index.checked_add(1)?).parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn auto(variables: &[(&str, &str)]) -> Result<String, String> {
        let of = |name: &str| {
            let found = variables.iter().find(|(known, _)| *known == name);
            found.map(|(_, value)| (*value).to_owned())
        };
        let shard = ShardChoice::Auto.resolve(&of);
        shard
            .map(|shard| shard.to_string())
            .map_err(|error| error.to_string())
    }

    fn slurm(id: &str, min: &str, max: &str, count: &str) -> Result<String, String> {
        auto(&[
            ("SLURM_ARRAY_TASK_ID", id),
            ("SLURM_ARRAY_TASK_MIN", min),
            ("SLURM_ARRAY_TASK_MAX", max),
            ("SLURM_ARRAY_TASK_COUNT", count),
        ])
    }

    #[test]
    fn slurms_arrays_count_from_anywhere_in_even_steps() {
        assert_eq!(slurm("1", "1", "8", "8").unwrap(), "1/8");
        assert_eq!(slurm("7", "0", "7", "8").unwrap(), "8/8");
        assert_eq!(slurm("20", "10", "30", "3").unwrap(), "2/3");
        // `sbatch --array=5`, to make one share of eight again.
        let alone = slurm("5", "5", "5", "1").unwrap_err();
        assert!(alone.contains("has one task"), "{alone}");
        for (id, min, max, count) in [
            ("3", "1", "7", "3"),
            ("9", "1", "8", "8"),
            ("x", "1", "8", "8"),
            ("1", "1", "8", "0"),
        ] {
            assert!(
                slurm(id, min, max, count)
                    .unwrap_err()
                    .contains("even steps"),
                "{id}"
            );
        }
        assert!(auto(&[("SLURM_ARRAY_TASK_ID", "1")]).is_err());
    }

    #[test]
    fn kubernetes_wants_to_be_told_how_many_there_are() {
        let index = ("JOB_COMPLETION_INDEX", "0");
        assert_eq!(auto(&[index, ("JOB_COMPLETIONS", "4")]).unwrap(), "1/4");
        assert!(auto(&[index]).unwrap_err().contains("JOB_COMPLETIONS"));
        assert!(auto(&[index, ("JOB_COMPLETIONS", "0")]).is_err());
        assert!(auto(&[]).unwrap_err().contains("neither"));
    }

    #[test]
    fn a_given_share_does_not_look_around() {
        let given: ShardChoice = "2/3".parse().unwrap();
        let shard = given.resolve(&|name| panic!("{name}")).unwrap();
        assert_eq!(shard.to_string(), "2/3");
        assert!("3/2".parse::<ShardChoice>().is_err());
    }
}
