// What was decided over time: a band each for mode, status and alert, and the moments at which one of them changes.
(function () {
  "use strict";
  const { shape, set, html, clear, path, fitted } = window.mcdas;
  const LEFT = 48, RIGHT = 8, ROW = 17, GAP = 3;

  class Bands {
    constructor(parent, look, choose) {
      this.look = look;
      this.choose = choose;
      this.box = html("div", "mcdas-bands", parent);
      this.frame = html("div", "", this.box);
      this.svg = shape("svg", { class: "mcdas-picture", role: "img", "aria-label": "mode, status and alert over time" }, this.frame);
      this.base = shape("g", {}, this.svg);
      this.cursor = shape("g", {}, this.svg);
      this.jumps = html("div", "mcdas-jumps", this.box);
      this.before = this.button("◀ event", () => this.jump(-1));
      this.after = this.button("event ▶", () => this.jump(1));
      this.list = html("select", "", this.jumps);
      this.list.setAttribute("aria-label", "events");
      this.list.addEventListener("change", () => { if (this.list.value !== "") this.choose(Number(this.list.value)); });
      this.why = html("div", "mcdas-why", this.box);
      this.width = 0;
      this.time = 0;
      fitted(this.frame, (width) => { this.width = width; this.draw(); });
      const pick = (event) => {
        if (!(event.buttons & 1 || event.type === "pointerdown")) return;
        const x = event.clientX - this.svg.getBoundingClientRect().left;
        choose(Math.min(Math.max((x - LEFT) / (this.width - LEFT - RIGHT), 0), 1) * this.duration);
      };
      this.svg.addEventListener("pointerdown", (event) => { this.svg.setPointerCapture(event.pointerId); pick(event); });
      this.svg.addEventListener("pointermove", pick);
      this.svg.style.touchAction = "pan-y";
      this.svg.style.cursor = "crosshair";
    }

    button(text, does) {
      const made = html("button", "", this.jumps, text);
      made.type = "button";
      made.addEventListener("click", does);
      return made;
    }

    // rows: [{ name, spans: [[from, until, word, colour]] }]; events: [{ t, kind, word, why }] in time order
    show(rows, events, duration) {
      Object.assign(this, { rows, events, duration });
      this.list.textContent = "";
      const head = html("option", "", this.list, `${events.length} event${events.length === 1 ? "" : "s"}`);
      head.value = "";
      for (const event of events) html("option", "", this.list, `${event.t.toFixed(1)} s  ${event.kind}: ${event.word}`).value = event.t;
      this.jumps.hidden = events.length === 0;
      this.draw();
    }

    jump(step) {
      const times = this.events.map((event) => event.t);
      const next = step > 0 ? times.find((t) => t > this.time + 1e-6) : times.filter((t) => t < this.time - 1e-6).pop();
      if (next !== undefined) this.choose(next);
    }

    x(t) { return LEFT + (t / this.duration) * (this.width - LEFT - RIGHT); }

    draw() {
      if (!this.rows || this.width < 80) return;
      const tall = this.rows.length * (ROW + GAP), { look } = this;
      set(this.svg, { width: this.width, height: tall, viewBox: `0 0 ${this.width} ${tall}` });
      clear(this.base);
      this.rows.forEach((row, k) => {
        const y = k * (ROW + GAP);
        const put = (x, text, how) => {
          const made = shape("text", { x, y: y + 12.5, "font-size": 10.5, fill: look.ink, ...how }, this.base);
          made.textContent = text;
        };
        put(LEFT - 6, row.name, { "text-anchor": "end" });
        shape("rect", { x: LEFT, y, width: this.width - LEFT - RIGHT, height: ROW, fill: "none", stroke: look.grid }, this.base);
        for (const [from, until, word, colour] of row.spans) {
          if (!colour) continue;
          const wide = Math.max(this.x(until) - this.x(from), 1);
          const block = shape("rect", { x: this.x(from), y, width: wide, height: ROW, fill: colour }, this.base);
          shape("title", {}, block).textContent = `${word}, ${from.toFixed(1)} s to ${until.toFixed(1)} s`;
          if (wide > 7.2 * word.length) put(this.x(from) + wide / 2, word, { "text-anchor": "middle", fill: "#000" });
        }
      });
      this.mark(this.time);
    }

    mark(time) {
      this.time = time;
      clear(this.cursor);
      if (!this.rows || this.width < 80) return;
      const x = this.x(Math.min(time, this.duration)), tall = this.rows.length * (ROW + GAP);
      shape("path", { d: path([[x, 0], [x, tall]]), stroke: this.look.black, "stroke-width": 1.6 }, this.cursor);
      const last = this.events.filter((event) => event.t <= time + 1e-6).pop();
      this.list.value = last && Math.abs(last.t - time) < 1e-6 ? last.t : "";
      this.why.textContent = last ? `${last.t.toFixed(1)} s, ${last.kind} ${last.word}: ${last.why}` : "";
      this.before.disabled = !this.events.some((event) => event.t < time - 1e-6);
      this.after.disabled = !this.events.some((event) => event.t > time + 1e-6);
    }
  }

  window.mcdas.Bands = Bands;
})();
