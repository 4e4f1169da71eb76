// The configuration space and paths in it, as the daemon has them: straight segments, angles the short way round,
// rotations by their shortest arc. Positions along a path are parts of its length, from 0 to 1.

const TURN = 2 * Math.PI;

function shortestArc(from, to) {
  const arc = (to - from) % TURN;
  return arc > Math.PI ? arc - TURN : arc <= -Math.PI ? arc + TURN : arc;
}

/** Product of quaternions x y z w. */
function product([ax, ay, az, aw], [bx, by, bz, bw]) {
  return [
    aw * bx + ax * bw + ay * bz - az * by,
    aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw,
    aw * bw - ax * bx - ay * by - az * bz,
  ];
}

function log([x, y, z, w]) {
  const first = [x, y, z].find((part) => part !== 0) ?? 0;
  const sign = w < 0 || (w === 0 && first < 0) ? -1 : 1;
  const sine = Math.hypot(x, y, z);
  const factor = sign * (sine < 1e-12 ? 2 : (2 * Math.atan2(sine, sign * w)) / sine);
  return [x * factor, y * factor, z * factor];
}

function exp([x, y, z]) {
  const angle = Math.hypot(x, y, z);
  const factor = angle < 1e-12 ? 0.5 : Math.sin(angle / 2) / angle;
  const q = [x * factor, y * factor, z * factor, Math.cos(angle / 2)];
  const norm = Math.hypot(...q);
  return q.map((part) => part / norm);
}

export class Space {
  constructor(factors, weights) {
    this.factors = factors;
    this.weights = weights;
  }

  /** The velocity that leads from one configuration to another in unit time. */
  difference(to, from) {
    const velocity = [];
    for (const { kind, q, v } of this.factors) {
      if (kind === "line") velocity[v] = to[q] - from[q];
      else if (kind === "circle") velocity[v] = shortestArc(from[q], to[q]);
      else {
        const [x, y, z, w] = from.slice(q, q + 4);
        const turn = log(product([-x, -y, -z, w], to.slice(q, q + 4)));
        velocity.splice(v, 3, ...turn);
      }
    }
    return velocity;
  }

  /** The configuration at ratio t of the segment between two. */
  between(from, to, t) {
    if (t === 0) return [...from];
    const velocity = this.difference(to, from);
    const at = [...from];
    for (const { kind, q, v } of this.factors) {
      if (kind !== "rotation") at[q] = from[q] + t * velocity[v];
      else {
        const turn = exp(velocity.slice(v, v + 3).map((part) => part * t));
        product(from.slice(q, q + 4), turn).forEach((part, i) => (at[q + i] = part));
      }
    }
    return at;
  }

  distance(to, from) {
    return Math.hypot(...this.difference(to, from).map((part, v) => part * (this.weights[v] ?? 1)));
  }
}

export class Track {
  constructor(space, rows) {
    this.space = space;
    this.rows = rows;
    this.lengths = [0];
    for (let i = 1; i < rows.length; i++) {
      this.lengths.push(this.lengths[i - 1] + space.distance(rows[i], rows[i - 1]));
    }
    this.length = this.lengths[rows.length - 1];
  }

  /** Position of a place: a segment and the ratio on it. */
  position(segment, t) {
    const last = this.rows.length - 1;
    if (last === 0) return 0;
    const i = Math.min(segment, last - 1);
    // A path that stands still has no length: its segments then count alike.
    if (this.length === 0) return (i + t) / last;
    return (this.lengths[i] + t * (this.lengths[i + 1] - this.lengths[i])) / this.length;
  }

  /** The place at a position. */
  place(position) {
    const last = this.rows.length - 1;
    if (last === 0) return { segment: 0, t: 0 };
    if (this.length === 0) {
      const segment = Math.min(Math.floor(position * last), last - 1);
      return { segment, t: position * last - segment };
    }
    const along = position * this.length;
    let segment = 0;
    while (segment < last - 1 && this.lengths[segment + 1] < along) segment++;
    const own = this.lengths[segment + 1] - this.lengths[segment];
    return { segment, t: own > 0 ? Math.min(1, Math.max(0, (along - this.lengths[segment]) / own)) : 0 };
  }

  /** The configuration at a position. */
  at(position) {
    const { segment, t } = this.place(position);
    const [from, to] = [this.rows[segment], this.rows[Math.min(segment + 1, this.rows.length - 1)]];
    return t === 1 ? [...to] : this.space.between(from, to, t);
  }

  /** Positions that draw it well: all waypoints and `count` more in between. */
  samples(count) {
    const positions = this.rows.map((_, i) => this.position(Math.max(0, i - 1), i === 0 ? 0 : 1));
    for (let i = 0; i <= count; i++) positions.push(i / count);
    return [...new Set(positions)].sort((a, b) => a - b);
  }
}
