// Strip charts: quantities over time with the limits that they should not cross; a cursor shows one time in all of them.
(function () {
  "use strict";
  const { shape, set, html, clear, path, fitted } = window.mcdas;
  const LEFT = 38, RIGHT = 8, TOP = 6, BOTTOM = 18, HEIGHT = 118;

  function ticks(low, high, count) {
    const raw = (high - low) / count, power = Math.pow(10, Math.floor(Math.log10(raw)));
    const step = [1, 2, 2.5, 5, 10].map((k) => k * power).find((s) => s >= raw) || raw;
    const found = [];
    for (let v = Math.ceil(low / step - 1e-9) * step; v <= high + 1e-9; v += step) found.push(Math.round(v / step) * step);
    return found;
  }

  const brief = (v) => (Math.abs(v) >= 100 ? v.toFixed(0) : String(Math.round(v * 100) / 100));

  class Strip {
    constructor(parent, look, choose) {
      this.look = look;
      this.box = html("figure", "mcdas-strip", parent);
      this.title = html("figcaption", "", this.box);
      this.frame = html("div", "", this.box);
      this.svg = shape("svg", { class: "mcdas-picture", role: "img", height: HEIGHT }, this.frame);
      this.base = shape("g", {}, this.svg);
      this.cursor = shape("g", {}, this.svg);
      this.width = 0;
      fitted(this.frame, (width) => { this.width = width; this.draw(); });
      if (choose) this.follow(choose);
    }

    // chart: { title, unit, low, high, duration, limits: [[value, word, danger]], lines: [{ t, v, colour, dash, faint }] }
    show(chart) {
      this.chart = chart;
      this.title.textContent = `${chart.title} [${chart.unit}]`;
      set(this.svg, { "aria-label": `${chart.title} over time` });
      this.draw();
    }

    follow(choose) {
      const pick = (event) => {
        if (!this.chart || !(event.buttons & 1 || event.type === "pointerdown")) return;
        const x = event.clientX - this.svg.getBoundingClientRect().left;
        const share = Math.min(Math.max((x - LEFT) / (this.width - LEFT - RIGHT), 0), 1);
        choose(share * this.chart.duration);
      };
      this.svg.addEventListener("pointerdown", (event) => { this.svg.setPointerCapture(event.pointerId); pick(event); });
      this.svg.addEventListener("pointermove", pick);
      this.svg.style.touchAction = "pan-y";
      this.svg.style.cursor = "crosshair";
    }

    x(t) { return LEFT + (t / this.chart.duration) * (this.width - LEFT - RIGHT); }
    y(v) {
      const { low, high } = this.chart;
      return TOP + ((high - Math.min(Math.max(v, low), high)) / (high - low)) * (HEIGHT - TOP - BOTTOM);
    }

    draw() {
      const { chart, look, width } = this;
      if (!chart || width < 60) return;
      set(this.svg, { width, viewBox: `0 0 ${width} ${HEIGHT}` });
      clear(this.base);
      const floor = HEIGHT - BOTTOM;
      const put = (x, y, text, extra) => {
        const made = shape("text", { x, y, "font-size": 10.5, fill: look.ink, ...extra }, this.base);
        made.textContent = text;
      };
      for (const v of ticks(chart.low, chart.high, 3)) {
        shape("path", { d: path([[LEFT, this.y(v)], [width - RIGHT, this.y(v)]]), stroke: look.grid, "stroke-width": 1 }, this.base);
        put(LEFT - 5, this.y(v) + 3.5, brief(v), { "text-anchor": "end" });
      }
      for (const t of ticks(0, chart.duration, Math.min(5, Math.floor(width / 55)))) {
        put(Math.min(this.x(t), width - 13), HEIGHT - 5, `${brief(t)} s`, { "text-anchor": "middle" });
        shape("path", { d: path([[this.x(t), floor], [this.x(t), floor + 3]]), stroke: look.grey, "stroke-width": 1 }, this.base);
      }
      for (const line of chart.lines) {
        const points = [];
        let most = 0, where = 0;
        line.t.forEach((t, k) => {
          const v = line.v[k];
          if (v === null) return;
          points.push([this.x(t), this.y(v)]);
          const beyond = Math.max(v - chart.high, chart.low - v);
          if (beyond > most) { most = beyond; where = k; }
        });
        shape("path", {
          d: path(points), fill: "none", stroke: line.colour, "stroke-width": line.faint ? 1.2 : 2, opacity: line.faint ? 0.35 : 1,
          "stroke-dasharray": line.dash || null, "stroke-linejoin": "round",
        }, this.base);
        if (most > 0) {
          const up = line.v[where] > chart.high, px = Math.min(this.x(line.t[where]) + 6, width - 58);
          put(px, up ? TOP + 9 : floor - 3, `${up ? "▲" : "▼"} ${brief(line.v[where])}`, {
            fill: line.colour, "font-weight": 600, "paint-order": "stroke", stroke: look.paper, "stroke-width": 3,
          });
        }
      }
      const words = [];
      for (const [value, word, danger] of chart.limits) {
        if (value < chart.low || value > chart.high) continue;
        const colour = danger ? look.danger : look.grey, y = this.y(value);
        shape("path", { d: path([[LEFT, y], [width - RIGHT, y]]), stroke: colour, "stroke-width": 1.3, "stroke-dasharray": "6 4" }, this.base);
        const low = y < 22 ? y + 11 : y - 3, beside = words.find((other) => Math.abs(other.low - low) < 12);
        const left = beside ? !beside.left : this.room(value, 0.0) > this.room(value, 0.75);
        words.push({ low, left });
        put(left ? LEFT + 3 : width - RIGHT - 2, low, word, {
          "text-anchor": left ? "start" : "end", fill: colour, "font-size": 10, "paint-order": "stroke", stroke: look.paper, "stroke-width": 3,
        });
      }
      if (this.time !== undefined) this.mark(this.time);
    }

    // How far the lines stay from a value over the quarter of the chart that begins at `from` [share of it].
    room(value, from) {
      const { lines, duration } = this.chart;
      let least = Infinity;
      for (const line of lines) {
        line.t.forEach((t, k) => {
          if (t >= from * duration && t <= (from + 0.25) * duration && line.v[k] !== null) least = Math.min(least, Math.abs(line.v[k] - value));
        });
      }
      return least;
    }

    mark(time) {
      this.time = time;
      clear(this.cursor);
      if (!this.chart || this.width < 60 || time === null) return;
      const x = this.x(Math.min(time, this.chart.duration));
      shape("path", { d: path([[x, TOP], [x, HEIGHT - BOTTOM]]), stroke: this.look.black, "stroke-width": 1, opacity: 0.6 }, this.cursor);
      for (const line of this.chart.lines) {
        if (line.faint) continue;
        const k = window.mcdas.at(line.t, time);
        if (line.v[k] === null || line.v[k] === undefined) continue;
        shape("circle", { cx: x, cy: this.y(line.v[k]), r: 3.4, fill: line.colour, stroke: "#fff", "stroke-width": 1 }, this.cursor);
      }
    }
  }

  window.mcdas.Strip = Strip;
})();
