// The answer in words, figures and plots.

import { number, plot } from "./plots.js";

export function length(metres) {
  const size = Math.abs(metres);
  if (size >= 1) return `${metres.toFixed(2)} m`;
  if (size >= 1e-4) return `${(metres * 1e3).toFixed(3)} mm`;
  return `${(metres * 1e6).toFixed(3)} µm`;
}

/** How much of something is kept: of a clearance the distance or the depth, of a constraint what is left of it. */
export function amount({ kind, unit, amount: value }) {
  const size = unit === "rad" ? `${Math.abs(value).toFixed(5)} rad` : length(Math.abs(value));
  if (kind === "clearance") return value < 0 ? `depth ${size}` : size;
  return value < 0 ? `outside by ${size}` : `${size} left`;
}

export function time(seconds) {
  if (seconds >= 1) return `${seconds.toFixed(2)} s`;
  if (seconds >= 1e-3) return `${(seconds * 1e3).toFixed(2)} ms`;
  return `${(seconds * 1e6).toFixed(1)} µs`;
}

export function make(name, attributes = {}, ...children) {
  const made = Object.assign(document.createElement(name), attributes);
  made.append(...children);
  return made;
}

function table(rows) {
  const row = ([head, ...cells]) => make("tr", {}, make("th", { scope: "row" }, head), make("td", {}, ...cells));
  return make("table", {}, ...rows.filter(Boolean).map(row));
}

export function refused(result) {
  return Boolean(result.reason);
}

/** What was proved or refused, in words. */
export function verdict(result) {
  if (refused(result)) {
    const count = Math.max(1, result.path_before.length - 1);
    return `${result.reason}: ${result.names.join(" × ")}, ${amount(result)}, segment ${result.segment + 1} of ${count}, t = ${result.t.toFixed(3)}`;
  }
  if (!result.proved) return `${result.code_name}: not proved in its time`;
  const claims = result.certificate?.segments.map(({ clearance_m }) => clearance_m).filter((claim) => claim !== null) ?? [];
  return claims.length ? `Proved collision-free, clearance ≥ ${length(Math.min(...claims))}` : "Proved collision-free, nothing near";
}

/** How long a trajectory takes, or why there is none. */
function duration({ status, message, trajectory }) {
  if (!trajectory) return `${status}: ${message}`;
  const { stops_s: stops, duration_s: now, duration_bound_s: bound, gap, stage } = trajectory;
  return `${stops.toFixed(3)} s → ${now.toFixed(3)} s, at least ${bound.toFixed(3)} s, gap ${(100 * gap).toFixed(1)} %, ${stage}`;
}

export class Panel {
  constructor(element, pick) {
    this.element = element;
    this.pick = pick;
    this.cursors = [];
  }

  /** Shows an answer. `show` is called with a contact that is chosen. */
  show(picture, before, after, timed, show) {
    const { result } = picture;
    this.cursors = [];
    this.timed = timed;
    this.find = timed && ((at) => timed.nearest(after.space, after.at(at)));
    const good = result.proved ? "good" : "bad";
    this.element.replaceChildren(
      make("h1", {}, result.name || "answer"),
      make("p", { className: `verdict ${good}` }, verdict(result)),
      this.figures(picture),
      ...(refused(result) && result.hint ? [make("p", { className: "note" }, result.hint)] : []),
      ...this.motors(result, timed),
      ...this.clearance(result, after),
      ...this.kept(picture, before, after),
      ...this.holds(result, after, show),
      ...this.lengths(result),
      ...this.joints(picture, before, after),
      ...this.stages(result),
      ...this.notes([...result.warnings, ...picture.notes]),
    );
  }

  figures({ result, kept }) {
    const change = result.length_after < result.length_before ? ` (−${(100 * (1 - result.length_after / result.length_before)).toFixed(1)} %)` : "";
    const { robot, scene } = result.subject;
    const file = (path) => path?.split("/").pop();
    const smallest = result.smallest_clearance;
    return table([
      ["Length", refused(result) ? result.length_before.toFixed(4) : `${result.length_before.toFixed(4)} → ${result.length_after.toFixed(4)}${change}`],
      ["At least", `${result.lower_bound.toFixed(4)}${result.gap === null ? "" : `, gap ${(100 * result.gap).toFixed(1)} %`}`],
      result.metric && ["Lengths in", result.metric],
      result.times && ["Duration", duration(result.times)],
      smallest && ["Nearest", `${smallest.names.join(" × ")}, ${amount(smallest)}`],
      kept.constraints.length > 0 && ["Must keep", [...new Set(kept.constraints.map(({ name }) => name))].join(", ")],
      ["Waypoints", refused(result) ? `${result.path.length}` : `${result.path_before.length} → ${result.path.length}`],
      ["Mode", `${result.mode}, ${result.termination}`],
      ["Time", `${time(result.time_s)}, ${result.iterations} iterations`],
      ["Robot", robot.label ?? file(robot.files?.urdf) ?? robot.hash],
      ["Scene", scene.label ? `${scene.label} v${scene.version}` : (file(scene.file) ?? "no obstacle")],
      result.request_id && ["Request", result.request_id],
    ]);
  }

  clearance(result, after) {
    const claims = result.certificate?.segments ?? [];
    if (refused(result) || claims.length === 0) return [];
    const lines = [];
    const values = [];
    claims.forEach(({ clearance_m }, segment) => {
      if (clearance_m === null || !(clearance_m > 0)) return;
      values.push(clearance_m * 1e3);
      const ends = [0, 1].map((t) => [after.position(segment, t), clearance_m * 1e3]);
      lines.push({ points: ends, kind: "after" });
    });
    const clearances = (result.holds ?? []).filter(({ kind }) => kind === "clearance");
    const dots = clearances.map((hold) => {
      values.push(hold.amount * 1e3);
      const text = `${hold.names.join(" × ")} ${amount(hold)}`;
      return { x: after.position(hold.segment, hold.t), y: hold.amount * 1e3, text };
    });
    if (values.length === 0) return [];
    const [low, high] = [Math.min(...values), Math.max(...values)];
    const chart = this.followed({ title: "Clearance along the path", lines, dots,
      x: { low: 0, high: 1, label: "part of the path" },
      y: { low: low * 0.8, high: high * 1.25, label: "mm", log: high > 8 * low } });
    return [make("h2", {}, "Clearance: proved, and contacts"), chart];
  }

  /** Velocity and acceleration of a joint over time, with their limits. */
  motors(result, timed) {
    if (!timed || timed.pieces.length === 0) return [];
    const { found, duration: high } = timed;
    const holder = make("div");
    const draw = (q) => {
      this.cursors = this.cursors.filter((svg) => ![...holder.children].includes(svg));
      const charts = [["velocity", 1, "per s"], ["acceleration", 2, "per s²"]].map(([name, order, label]) => {
        const points = timed.derivative(q, order);
        const limits = found.motors[q][name].filter((limit) => limit !== null);
        const values = [...points.map(([, value]) => value), ...limits];
        const [low, most] = [Math.min(...values), Math.max(...values)];
        const room = Math.max(0.06 * (most - low), 1e-3);
        const bounds = limits.map((limit) => ({ points: [[0, limit], [high, limit]], kind: "bound" }));
        const chart = plot({ title: `${name} of ${result.variables[q]} over time`, lines: [...bounds, { points, kind: "after" }],
          x: { low: 0, high, label: "s" }, y: { low: low - room, high: most + room, label },
          pick: (time) => this.pick(time / high) });
        const cursor = chart.cursor;
        chart.cursor = (position) => cursor(position * high);
        return chart;
      });
      this.cursors.push(...charts);
      holder.replaceChildren(...charts);
    };
    const most = Math.max(0, result.variables.indexOf(found.decides));
    const choice = make("select", { ariaLabel: "Motor" }, ...result.variables.map((name, q) => new Option(name, q, false, q === most)));
    choice.addEventListener("change", () => draw(Number(choice.value)));
    draw(most);
    return [make("h2", {}, "Velocity, acceleration, limits "), choice, holder];
  }

  /** What is read of each constraint along the path, and what may be. */
  kept(picture, before, after) {
    const { kept, result } = picture;
    const tracks = [[before, kept.before, "before"], ...(refused(result) ? [] : [[after, kept.after, "after"]])];
    return kept.constraints.flatMap((constraint) => {
      const { name, unit, is_left: isLeft, allowed } = constraint;
      const lines = allowed.map((value) => ({ points: [[0, value], [1, value]], kind: "bound" }));
      for (const [track, places, kind] of tracks) {
        lines.push({ kind, points: places.map(([segment, t], i) => [track.position(segment, t), constraint[kind][i]]) });
      }
      const values = lines.flatMap(({ points }) => points.map(([, value]) => value));
      const [low, high] = [Math.min(0, ...values), Math.max(0, ...values)];
      const chart = this.followed({ title: `${name} along the path`, lines,
        x: { low: 0, high: 1, label: "part of the path" },
        y: { low, high: high + 0.08 * (high - low), label: isLeft ? `${unit} left` : unit } });
      return [make("h2", {}, `Kept: ${name}`), chart];
    });
  }

  lengths(result) {
    const seen = result.lengths_over_time;
    if (seen.length === 0) return [];
    const end = Math.max(result.time_s, seen[seen.length - 1][0]);
    const [unit, factor] = end < 1 ? ["ms", 1e3] : ["s", 1];
    // Most is gained soon: the first is far from the last.
    const begin = Math.max(1e-6, Math.min(seen[0][0], end) * 0.5) * factor;
    const points = [[begin, result.length_before]];
    for (const [at, value] of seen) points.push([at * factor, points[points.length - 1][1]], [at * factor, value]);
    points.push([end * factor, points[points.length - 1][1]]);
    const bound = [[begin, result.lower_bound], [end * factor, result.lower_bound]];
    const chart = plot({ title: "Length over time", lines: [{ points: bound, kind: "bound" }, { points, kind: "after" }],
      x: { low: begin, high: end * factor, label: unit, log: true },
      y: { low: Math.min(result.lower_bound, result.length_after) * 0.97, high: result.length_before * 1.02, label: "length" } });
    return [make("h2", {}, "Length over time"), chart];
  }

  joints(picture, before, after) {
    const { result } = picture;
    const column = (track, q) => track.samples(160).map((position) => [position, track.at(position)[q]]);
    const holder = make("div");
    const draw = (q) => {
      // A refused path is the input still: there is nothing after it.
      const tracks = refused(result) ? [["before", before]] : [["before", before], ["after", after]];
      const lines = tracks.map(([kind, track]) => ({ kind, points: column(track, q) }));
      const values = lines.flatMap(({ points }) => points.map(([, value]) => value));
      const [low, high] = [Math.min(...values), Math.max(...values)];
      const room = Math.max((high - low) * 0.08, 1e-3);
      this.cursors = this.cursors.filter((svg) => svg !== holder.firstChild);
      holder.replaceChildren(this.followed({ title: `${result.variables[q]} along the path`, lines,
        x: { low: 0, high: 1, label: "part of the path" }, y: { low: low - room, high: high + room, label: "m or rad" } }));
    };
    const moved = result.variables.map((_, q) => Math.max(...before.rows.map((row) => Math.abs(row[q] - before.rows[0][q]))));
    const most = moved.indexOf(Math.max(...moved));
    const choice = make("select", { ariaLabel: "Joint" }, ...result.variables.map((name, q) => new Option(name, q, false, q === most)));
    choice.addEventListener("change", () => draw(Number(choice.value)));
    draw(most);
    return [make("h2", {}, "Joint "), choice, holder];
  }

  holds(result, after, show) {
    const found = refused(result) ? [] : (result.holds ?? []);
    if (found.length === 0) return [];
    const item = (hold) => {
      const place = `segment ${hold.segment + 1}, t = ${hold.t.toFixed(3)}`;
      const button = make("button", { type: "button" }, `${hold.names.join(" × ")}  ${amount(hold)}`, make("small", {}, place));
      button.addEventListener("click", () => {
        const at = after.position(hold.segment, hold.t);
        this.pick(this.find ? this.find(at) : at);
        show(hold);
      });
      return make("li", {}, button);
    };
    return [make("h2", {}, `What holds the path (${found.length})`), make("ul", { className: "plain" }, ...found.slice(0, 40).map(item))];
  }

  stages(result) {
    if (result.stages.length === 0) return [];
    const rows = result.stages.map(({ stage, gain, iterations }) => [stage, `−${number(gain)} in ${iterations} iterations`]);
    return [make("h2", {}, "Stages"), table(rows)];
  }

  notes(lines) {
    return lines.length ? [make("h2", {}, "Notes"), ...lines.map((line) => make("p", { className: "note" }, line))] : [];
  }

  followed(options) {
    // What moves by times is at no place of the path.
    if (this.timed) return plot(options);
    const chart = plot({ ...options, pick: this.pick });
    this.cursors.push(chart);
    return chart;
  }

  at(position) {
    this.cursors.forEach((chart) => chart.cursor(position));
  }
}
