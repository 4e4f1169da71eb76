// Small plots as SVG; a cursor follows the slider, and a click moves it.

const WIDTH = 316;
const HEIGHT = 124;
const LEFT = 46;
const BOTTOM = 26;
const TOP = 8;
const NAMESPACE = "http://www.w3.org/2000/svg";

function element(name, attributes, text) {
  const made = document.createElementNS(NAMESPACE, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

function steps(low, high, count) {
  const rough = (high - low) / count || 1;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough * 0.999);
  const found = [];
  for (let at = Math.ceil(low / step - 1e-9) * step; at <= high + step * 1e-9; at += step) found.push(at);
  return found;
}

function decades(low, high) {
  const found = [];
  for (let power = Math.ceil(Math.log10(low) - 1e-9); 10 ** power <= high * 1.001; power++) found.push(10 ** power);
  return found.length > 1 ? found : [low, high];
}

export function number(value) {
  const size = Math.abs(value);
  if (size === 0) return "0";
  if (size >= 1000 || size < 0.001) return value.toExponential(0);
  return String(Number(value.toPrecision(3)));
}

/**
 * A plot. `lines` are {points: [[x, y]], kind}, `dots` are {x, y, text}; `x` and `y` are {low, high, label, log};
 * `pick` hears where it was clicked, as x.
 */
export function plot({ title, lines, dots = [], x, y, pick }) {
  const svg = element("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": title });
  const part = (axis, value) => {
    const scale = axis.log ? (at) => Math.log10(Math.max(at, axis.low)) : (at) => at;
    return (scale(value) - scale(axis.low)) / (scale(axis.high) - scale(axis.low) || 1);
  };
  const along = (value) => LEFT + part(x, value) * (WIDTH - LEFT - 6);
  const up = (value) => HEIGHT - BOTTOM - part(y, value) * (HEIGHT - BOTTOM - TOP);
  for (const at of y.log ? decades(y.low, y.high) : steps(y.low, y.high, 3)) {
    svg.append(element("line", { class: "axis", x1: LEFT, x2: WIDTH - 6, y1: up(at), y2: up(at) }));
    svg.append(element("text", { x: LEFT - 5, y: up(at) + 3.5, "text-anchor": "end" }, number(at)));
  }
  for (const at of x.log ? decades(x.low, x.high) : steps(x.low, x.high, 4)) {
    svg.append(element("text", { x: along(at), y: HEIGHT - BOTTOM + 13, "text-anchor": "middle" }, number(at)));
  }
  svg.append(element("text", { x: WIDTH - 6, y: HEIGHT - 2, "text-anchor": "end" }, x.label));
  svg.append(element("text", { x: 0, y: HEIGHT - 2 }, y.label));
  for (const { points, kind } of lines) {
    const text = points.map(([px, py]) => `${along(px).toFixed(1)},${up(py).toFixed(1)}`).join(" ");
    svg.append(element("polyline", { class: kind, points: text }));
  }
  for (const dot of dots) {
    const mark = element("circle", { class: "dot", cx: along(dot.x), cy: up(dot.y), r: 3 });
    mark.append(element("title", {}, dot.text));
    svg.append(mark);
  }
  if (pick) {
    const cursor = element("line", { class: "cursor", y1: TOP, y2: HEIGHT - BOTTOM });
    svg.append(cursor);
    svg.cursor = (at) => ["x1", "x2"].forEach((end) => cursor.setAttribute(end, along(at)));
    svg.style.cursor = "pointer";
    svg.addEventListener("click", (event) => {
      const box = svg.getBoundingClientRect();
      const at = x.low + (((event.clientX - box.left) * (WIDTH / box.width) - LEFT) / (WIDTH - LEFT - 6)) * (x.high - x.low);
      pick(Math.min(x.high, Math.max(x.low, at)));
    });
  }
  return svg;
}
