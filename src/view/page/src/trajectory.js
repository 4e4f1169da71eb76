// A trajectory as a controller executes it: a polynomial of time in each column between two points. Positions are parts
// of its duration, from 0 to 1.

const sum = (powers, t) => powers.reduceRight((value, factor) => value * t + factor, 0);
const slope = (powers) => powers.slice(1).map((factor, i) => factor * (i + 1));

/** The polynomial from one point to the next: straight, cubic or quintic, by what both points have. */
function powers(from, to, T) {
  const d = to.p - from.p;
  if (from.v === undefined) return [from.p, d / T];
  if (from.a === undefined) {
    return [from.p, from.v, (3 * d / T - 2 * from.v - to.v) / T, (from.v + to.v - 2 * d / T) / T ** 2];
  }
  const [v, a] = [[from.v, to.v], [from.a, to.a]];
  return [from.p, v[0], a[0] / 2,
    (20 * d - (8 * v[1] + 12 * v[0]) * T - (3 * a[0] - a[1]) * T ** 2) / (2 * T ** 3),
    (-30 * d + (14 * v[1] + 16 * v[0]) * T + (3 * a[0] - 2 * a[1]) * T ** 2) / (2 * T ** 4),
    (12 * d - 6 * (v[1] + v[0]) * T + (a[1] - a[0]) * T ** 2) / (2 * T ** 5)];
}

export class Trajectory {
  constructor(found) {
    const { positions, velocities, accelerations } = found;
    this.found = found;
    this.times = found.times_ns.map((ns) => ns * 1e-9);
    this.duration = found.duration_s;
    const state = (i, q) => ({ p: positions[i][q], v: velocities?.[i]?.[q], a: accelerations?.[i]?.[q] });
    this.pieces = this.times.slice(1).map((end, i) => positions[i].map((_, q) => powers(state(i, q), state(i + 1, q), end - this.times[i])));
  }

  /** The piece at a time (s), and the time since its begin. */
  piece(time) {
    let i = 0;
    while (i < this.pieces.length - 1 && this.times[i + 1] <= time) i++;
    return [this.pieces[i], Math.min(Math.max(0, time - this.times[i]), this.times[i + 1] - this.times[i])];
  }

  /** The configuration at a position. */
  at(position) {
    if (this.pieces.length === 0) return [...this.found.positions[0]];
    const [columns, t] = this.piece(position * this.duration);
    return columns.map((own) => sum(own, t));
  }

  /** Positions that draw it well. */
  samples(count) {
    const places = this.times.map((time) => (this.duration > 0 ? time / this.duration : 0));
    for (let i = 0; i <= count; i++) places.push(i / count);
    return [...new Set(places)].sort((a, b) => a - b);
  }

  /** The position where it is nearest to a configuration. */
  nearest(space, configuration) {
    const far = (position) => space.distance(this.at(position), configuration);
    return this.samples(400).reduce((best, position) => (far(position) < far(best) ? position : best), 0);
  }

  /** Points (s, value) of a column's velocity or acceleration, both ends of each piece: accelerations may jump. */
  derivative(q, order) {
    const count = order === 1 ? 6 : 3;
    return this.pieces.flatMap((columns, i) => {
      const own = order === 1 ? slope(columns[q]) : slope(slope(columns[q]));
      const T = this.times[i + 1] - this.times[i];
      return Array.from({ length: count + 1 }, (_, k) => [this.times[i] + T * k / count, sum(own, T * k / count)]);
    });
  }
}
