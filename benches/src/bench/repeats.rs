//! From several runs of one request to the figures of one.

use super::curve::Curve;
use crate::statistics::median;

/// One run of a request.
#[derive(Clone, Debug)]
pub(super) struct Repeat {
    /// Content hash of its path's bits.
    pub hash: u64,
    /// Its lengths over time.
    pub curve: Curve,
    /// CPU time of its thread (s).
    pub cpu_s: f64,
    /// Time on the clock (s).
    pub time_s: f64,
}

/// What several runs amount to.
#[derive(Debug, PartialEq)]
pub(super) struct Combined {
    /// The run whose answer it is.
    pub run: usize,
    /// Number of runs.
    pub runs: usize,
    /// Its lengths over time.
    pub curve: Curve,
    /// CPU time (s).
    pub cpu_s: f64,
    /// Time on the clock (s).
    pub time_s: f64,
}

/// Runs that nothing interrupts give the same bits by the same steps; times are medians, of each
/// step too.
///
/// # Errors
/// Which run differs and how: then a promise of the core is broken, and no figure means anything.
pub(super) fn alike(repeats: &[Repeat]) -> Result<Combined, String> {
    let first = &repeats[0];
    for (index, other) in repeats.iter().enumerate() {
        check_alike(first, other, index + 1)?;
    }
    let of = |value: &dyn Fn(&Repeat) -> f64| median(repeats.iter().map(value)).unwrap_or_default();
    let time_of = |step: usize| of(&|repeat| repeat.curve.time_s(step));
    Ok(Combined {
        run: 0,
        runs: repeats.len(),
        curve: first.curve.at_times(time_of),
        cpu_s: of(&|repeat| repeat.cpu_s),
        time_s: of(&|repeat| repeat.time_s),
    })
}

fn check_alike(first: &Repeat, other: &Repeat, run: usize) -> Result<(), String> {
    if other.hash != first.hash {
        return Err(format!(
            "run {run} gave the path {:016x}, run 1 gave {:016x}",
            other.hash, first.hash
        ));
    }
    let [a, b] = [other, first].map(|repeat| repeat.curve.improvements());
    match a == b {
        true => Ok(()),
        false => Err(format!(
            "run {run} gave its path in {a} improvements, run 1 in {b}"
        )),
    }
}

/// Runs that a deadline ends may differ: the one of median length stands for all, of two the
/// shorter.
pub(super) fn middle(repeats: &[Repeat]) -> Combined {
    let mut order: Vec<usize> = (0..repeats.len()).collect();
    let remaining = |run: usize| repeats[run].curve.remaining_at_end();
    order.sort_by(|&a, &b| remaining(a).total_cmp(&remaining(b)));
    let run = order[(order.len() - 1) / 2];
    let Repeat {
        curve,
        cpu_s,
        time_s,
        ..
    } = repeats[run].clone();
    Combined {
        run,
        runs: repeats.len(),
        curve,
        cpu_s,
        time_s,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn repeat(hash: u64, steps: &[(f64, f64)], cpu_s: f64) -> Repeat {
        let mut curve = Curve::new(4.0);
        steps
            .iter()
            .for_each(|&(time_s, length)| curve.push(time_s, length));
        Repeat {
            hash,
            curve,
            cpu_s,
            time_s: 2.0 * cpu_s,
        }
    }

    #[test]
    fn the_time_of_each_step_is_its_median() {
        let runs = [
            repeat(7, &[(0.1, 3.0), (0.9, 2.0)], 5.0),
            repeat(7, &[(0.3, 3.0), (0.4, 2.0)], 1.0),
            repeat(7, &[(0.2, 3.0), (0.5, 2.0)], 2.0),
        ];
        let combined = alike(&runs).unwrap();
        assert_eq!(
            combined.curve,
            repeat(7, &[(0.2, 3.0), (0.5, 2.0)], 0.0).curve
        );
        assert_eq!(
            (combined.run, combined.runs, combined.cpu_s, combined.time_s),
            (0, 3, 2.0, 4.0)
        );
    }

    #[test]
    fn runs_that_differ_are_an_error() {
        let first = repeat(7, &[(0.1, 3.0)], 1.0);
        let other_bits = alike(&[first.clone(), repeat(8, &[(0.1, 3.0)], 1.0)]).unwrap_err();
        assert!(
            other_bits.starts_with("run 2 gave the path 0000000000000008"),
            "{other_bits}"
        );
        let other_way = alike(&[first, repeat(7, &[(0.1, 3.5), (0.2, 3.0)], 1.0)]).unwrap_err();
        assert_eq!(
            other_way,
            "run 2 gave its path in 2 improvements, run 1 in 1"
        );
    }

    #[test]
    fn under_a_deadline_the_run_of_median_length_stands_for_all() {
        let runs = [
            repeat(1, &[(0.1, 3.0)], 1.0),
            repeat(2, &[(0.1, 1.0)], 2.0),
            repeat(3, &[(0.1, 2.0)], 3.0),
        ];
        assert_eq!((middle(&runs).run, middle(&runs).cpu_s), (2, 3.0));
        assert_eq!(middle(&runs[..2]).run, 1);
    }
}
