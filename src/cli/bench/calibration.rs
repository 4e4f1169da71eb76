//! A fixed piece of work whose time says how fast the machine is, so that figures of two machines
//! can be related.
//!
//! Per round: a step of a xorshift generator picks a number of a table of 4,096 (32 KiB, the
//! first-level cache of most machines), which goes through a multiplication, an addition and a
//! square root, and is written back. The chain of dependences, loads and stores is what a distance
//! query is made of too. The work is always the same, bit for bit.

use std::hint::black_box;

use super::run::thread_cpu;
use super::statistics::median;

const TABLE: usize = 4096;
const ROUNDS: u32 = 1_500_000;
const RUNS: usize = 5;

/// CPU time of the kernel on this machine, now: the median of five (s).
pub(super) fn seconds() -> f64 {
    let once = |_| {
        let start = thread_cpu();
        black_box(kernel(black_box(ROUNDS)));
        thread_cpu() - start
    };
    median((0..RUNS).map(once)).unwrap_or_default()
}

fn kernel(rounds: u32) -> f64 {
    let mut table: Vec<f64> = (0..TABLE).map(|index| index as f64).collect();
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut sum = 0.0_f64;
    for _ in 0..rounds {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        let place = state as usize % TABLE;
        sum = (table[place] * 0.75 + sum * 0.25 + 1.0).sqrt();
        table[place] = sum;
    }
    sum + table.iter().sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_work_is_always_the_same() {
        assert_eq!(kernel(1000).to_bits(), kernel(1000).to_bits());
        assert!(kernel(1000).is_finite() && seconds() > 0.0);
    }
}
