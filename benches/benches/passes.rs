//! The two passes along a path beside the convex program of Verscheure et al. (2009) on the same places:
//! `cargo bench -p taut-bench --bench passes`.
//!
//! Both find the fastest way along the same parabolas and lines, so their durations must agree; what each
//! takes is a median of one run, turn by turn.

use std::time::Instant;

use taut::path::Path;
use taut::timing::blend::{Corners, Stretch, distinct};
use taut::timing::{ColumnLimits, Fixed, Limits, Range, along, blend, limits, ramp};

#[path = "../../src/timing/testing.rs"]
#[allow(dead_code, reason = "tests ask it for more")]
mod convex;

/// Columns, and waypoints: each corner is a parabola of four intervals at least, each line of six.
const CASES: [[usize; 2]; 6] = [[6, 11], [7, 11], [33, 11], [6, 101], [7, 101], [33, 101]];
/// Runs of the convex program, of which the median counts; the passes run a hundred times as often.
const RUNS: usize = 3;
/// How far the durations may be apart.
const SAME: f64 = 1e-3;

fn main() {
    println!(
        "{:>7} {:>7} {:>12} {:>12} {:>12} {:>12} {:>8}",
        "columns", "places", "passes", "program", "duration s", "program s", "ratio"
    );
    for [columns, waypoints] in CASES {
        compare(columns, waypoints);
    }
}

fn compare(columns: usize, waypoints: usize) {
    let limits = limits_of(columns);
    let stretches = stretches(columns, waypoints, &limits);
    let places = along::fastest(&stretches, &limits);
    let own = convex::duration(&stretches, &places);
    let mut times = [Vec::new(), Vec::new()];
    let mut least = f64::INFINITY;
    for _ in 0..RUNS {
        for _ in 0..100 {
            let start = Instant::now();
            std::hint::black_box(along::fastest(&stretches, &limits));
            times[0].push(start.elapsed().as_secs_f64());
        }
        let start = Instant::now();
        least = convex::least(&stretches, &places, &limits);
        times[1].push(start.elapsed().as_secs_f64());
    }
    assert!(
        (own / least - 1.0).abs() < SAME,
        "{own} s by the passes, {least} s by the program"
    );
    let [passes, program] = times.map(median);
    println!(
        "{columns:>7} {:>7} {:>9.1} µs {:>9.1} ms {own:>12.6} {least:>12.6} {:>8.0}",
        places.len(),
        1e6 * passes,
        1e3 * program,
        program / passes
    );
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Each column as fast as it likes, with twice that per second.
fn limits_of(columns: usize) -> Limits {
    let mut random = fastrand::Rng::with_seed(3);
    let column = |_| {
        let most = 0.5 + 2.0 * random.f64();
        ColumnLimits {
            velocity: Range::symmetric(most),
            acceleration: Range::symmetric(2.0 * most),
        }
    };
    Limits::new((0..columns).map(column).collect())
}

/// A random walk, its corners rounded by half of what there is room for.
fn stretches(columns: usize, waypoints: usize, limits: &Limits) -> Vec<Stretch> {
    let mut random = fastrand::Rng::with_seed(8);
    let mut at = vec![0.0; columns];
    let mut rows = at.clone();
    for _ in 1..waypoints {
        at.iter_mut()
            .for_each(|value| *value += random.f64() - 0.4);
        rows.extend_from_slice(&at);
    }
    let path = Path::from_rows(columns, rows).expect("whole rows");
    let mut corners = Corners::new(distinct(&path, &Fixed::Ends, limits), limits);
    for waypoint in corners.inner() {
        let room = corners.room(waypoint);
        corners.round(waypoint, 0.5 * room);
    }
    corners.stretches()
}
