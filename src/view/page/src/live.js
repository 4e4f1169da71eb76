// The daemon's own page: what runs, who asks, and the last answers, asked for every second while it is seen.

import { length, make, time } from "./panel.js";

const PERIOD_MS = 1000;

export class Live {
  constructor(element, open) {
    this.element = element;
    this.open = open;
    element.hidden = false;
    this.look();
  }

  async look() {
    if (!document.hidden) {
      try {
        const answer = await fetch("state");
        this.show(await answer.json());
      } catch {
        this.element.replaceChildren(make("h1", {}, "taut"), make("p", { className: "verdict bad" }, "The daemon does not answer."));
      }
    }
    setTimeout(() => this.look(), PERIOD_MS);
  }

  show(state) {
    this.state = state;
    const focused = document.activeElement?.dataset?.answer;
    const { stats, clients, running, answers } = state;
    this.element.replaceChildren(
      make("h1", {}, `taut: ${state.instance}`),
      this.figures(stats),
      make("h2", {}, `Running (${running.length})`),
      make("ul", { className: "plain", id: "running" }, ...running.map((run) => this.run(run))),
      make("h2", {}, `Clients (${clients.length})`),
      make("ul", { className: "plain" }, ...clients.map((client) => this.client(client))),
      make("h2", {}, "Answers, newest first"),
      make("ul", { className: "plain", id: "answers" }, ...answers.map((answer) => this.answer(answer))),
    );
    if (focused) this.element.querySelector(`[data-answer="${focused}"]`)?.focus();
  }

  figures(stats) {
    const ms = (name) => time((stats[name] ?? 0) * 1e-9);
    const rows = [
      ["Requests", `${stats.requests_received ?? 0}, ${stats.requests_running ?? 0} run, ${stats.requests_queued ?? 0} wait`],
      ["Answered", `${stats.requests_answered ?? 0}, refused ${stats.requests_refused ?? 0}`],
      ["Latency", `${ms("latency_p50_ns")}, p99 ${ms("latency_p99_ns")}`],
      ["Computing", `${ms("compute_p50_ns")}, p99 ${ms("compute_p99_ns")}`],
      ["Workers", `${stats.workers ?? 0}`],
    ];
    const row = ([head, text]) => make("tr", {}, make("th", { scope: "row" }, head), make("td", {}, text));
    return make("table", {}, ...rows.map(row));
  }

  run({ robot, scene, mode, pid, age_s, length_before, length: now }) {
    const lengths = now === null ? "no shorter path yet" : `${length_before.toFixed(3)} → ${now.toFixed(3)}`;
    return make("li", {}, `${robot} in ${scene}, ${mode}`, make("small", {}, `process ${pid}, ${time(age_s)}, ${lengths}`));
  }

  client({ pid, in_flight, served, refused, answered_per_second }) {
    return make("li", {}, `process ${pid}`, make("small", {}, `${in_flight} in flight, ${served} served, ${refused} refused, ${answered_per_second} per second`));
  }

  answer({ number, robot, scene, mode, code, proved, length_before, length_after, clearance_m }) {
    const said = proved ? `${length_before.toFixed(3)} → ${length_after.toFixed(3)}` : code;
    const near = clearance_m === null || !proved ? "" : `, ≥ ${length(clearance_m)}`;
    const button = make("button", { type: "button" }, `${robot} in ${scene}`, make("small", {}, `${mode}: ${said}${near}`));
    button.dataset.answer = number;
    if (this.chosen === number) button.setAttribute("aria-current", "true");
    button.addEventListener("click", () => this.choose(number));
    return make("li", {}, button);
  }

  async choose(number) {
    this.chosen = number;
    const answer = await fetch(`answer/${number}`);
    if (answer.ok) this.open(await answer.json());
    this.show(this.state);
  }
}
