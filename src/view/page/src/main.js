// The page: a picture that it holds, or those that its daemon gives.

import { Live } from "./live.js";
import { Space, Track } from "./motion.js";
import { Panel, amount, make, refused } from "./panel.js";
import { Stage } from "./stage.js";
import { Trajectory } from "./trajectory.js";

/** How long a whole path takes to play that has no times (ms). */
const PLAY_MS = 6000;

const KINDS = [
  ["traces", "Ways of the tips", true],
  ["ends", "Start and goal", true],
  ["before", "Robot on the path before", false],
  ["contacts", "Contacts", true],
  ["kept", "What it must keep", true],
  ["names", "Names of objects", null],
  ["through", "See through objects", false],
  ["collision", "Collision shapes", false],
];

class Page {
  constructor() {
    const get = (id) => document.getElementById(id);
    [this.slider, this.where, this.play] = ["slider", "where", "play"].map(get);
    this.stage = new Stage(get("canvas"), get("labels"));
    this.panel = new Panel(get("panel"), (position) => this.go(position));
    this.slider.addEventListener("input", () => this.go(Number(this.slider.value) / Number(this.slider.max)));
    this.play.addEventListener("click", () => this.run(!this.running));
    get("theme").addEventListener("click", () => this.theme(document.documentElement.dataset.theme !== "dark"));
    this.theme(matchMedia("(prefers-color-scheme: dark)").matches);
    addEventListener("keydown", (event) => {
      if (event.key !== " " || ["BUTTON", "SELECT", "INPUT"].includes(event.target.tagName) && event.target.type !== "range") return;
      event.preventDefault();
      this.run(!this.running);
    });
    this.boxes(get("show"));
    const key = [["before", "path before"], ["after", "path after"], ["object", "obstacle"], ["bad", "contact"],
      ["kept", "must be within"]];
    get("key").append(...key.map(([name, text]) => make("li", { className: `of-${name}` }, make("i", { className: `ink-${name}` }), text)));
    this.empty(true);
  }

  boxes(element) {
    this.kinds = Object.fromEntries(KINDS.map(([kind, text]) => {
      const box = make("input", { type: "checkbox", id: `show-${kind}` });
      box.addEventListener("change", () => {
        this.stage.toggle(kind, box.checked);
        this.go(this.position);
      });
      element.append(make("label", {}, box, ` ${text}`));
      return [kind, box];
    }));
  }

  empty(is) {
    document.getElementById("empty").hidden = !is;
    for (const id of ["bar", "show", "key", "panel"]) document.getElementById(id).hidden = is;
  }

  theme(dark) {
    document.documentElement.dataset.theme = dark ? "dark" : "light";
    this.stage.paint();
    this.stage.draw();
  }

  /** Shows a picture. */
  show(picture) {
    this.run(false);
    this.empty(false);
    const { result } = picture;
    document.title = `taut: ${result.name}`;
    document.querySelector("#key .of-after").hidden = refused(result);
    const keepsNothing = picture.kept.constraints.length === 0;
    for (const element of [document.querySelector("#key .of-kept"), this.kinds.kept.parentElement]) element.hidden = keepsNothing;
    const space = new Space(picture.factors, result.weights);
    Object.assign(this, { picture, before: new Track(space, result.path_before), after: new Track(space, result.path) });
    const found = result.times?.trajectory;
    this.timed = found && new Trajectory(found);
    this.slider.max = String(this.timed?.duration || 1);
    this.stage.show(picture, space, this.before, this.after, this.timed ?? this.after);
    this.panel.show(picture, this.before, this.after, this.timed, (contact) => this.mark(contact));
    for (const [kind, , on] of KINDS) {
      this.kinds[kind].checked = on ?? picture.objects.length <= 12;
      this.stage.toggle(kind, this.kinds[kind].checked);
    }
    if (refused(result)) {
      this.go(this.after.position(result.segment, result.t));
      this.mark(result);
    } else {
      this.go(0);
    }
  }

  /** Marks a contact or what is refused: its bodies, and what is to be said of it. */
  mark(contact) {
    this.marked = contact && this.position;
    this.stage.highlight(contact?.names ?? []);
    const text = contact && `${contact.names.join(" × ")} ${amount(contact)}`;
    this.stage.labels.only("bad", text, contact?.points[0]);
    this.stage.draw();
  }

  /** Goes to a position along the path. */
  go(position) {
    this.position = position;
    this.slider.value = String(position * Number(this.slider.max));
    if (this.marked !== null && this.marked !== undefined && this.marked !== position) this.mark(null);
    this.stage.at(position);
    this.panel.at(position);
    if (this.timed) {
      this.where.textContent = `${(position * this.timed.duration).toFixed(3)} s of ${this.timed.duration.toFixed(3)} s`;
      return;
    }
    const { segment, t } = this.after.place(position);
    const count = Math.max(1, this.after.rows.length - 1);
    this.where.textContent = `${(100 * position).toFixed(1)} %   segment ${segment + 1} of ${count}, t = ${t.toFixed(3)}`;
  }

  run(on) {
    this.running = on;
    this.play.textContent = on ? "Pause" : "Play";
    this.play.setAttribute("aria-pressed", String(on));
    if (!on) return;
    if (this.position >= 1) this.position = 0;
    const duration = this.timed ? Math.max(1, this.timed.duration * 1e3) : PLAY_MS;
    const begin = performance.now() - this.position * duration;
    const step = (now) => {
      if (!this.running) return;
      const position = Math.min(1, Math.max(0, (now - begin) / duration));
      this.go(position);
      if (position < 1) requestAnimationFrame(step);
      else this.run(false);
    };
    requestAnimationFrame(step);
  }
}

addEventListener("DOMContentLoaded", () => {
  const page = new Page();
  // For whoever looks from outside, tests among them.
  window.taut = page;
  if (document.documentElement.dataset.kind === "live") {
    page.live = new Live(document.getElementById("live"), (picture) => page.show(picture));
  } else {
    page.show(JSON.parse(document.getElementById("data").textContent));
  }
});
