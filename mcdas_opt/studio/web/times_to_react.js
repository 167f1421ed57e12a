// Until when each of the four manoeuvres can begin, as a timeline, and what closes it.
(function () {
  "use strict";
  const { shape, set, html, clear, fitted } = window.mcdas;
  const LEFT = 82, RIGHT = 14, ROW = 25, TOP = 4, MOST = 10;
  const NAMES = { brake: "brake", accelerate: "accelerate", left: "steer left", right: "steer right" };

  class TimesToReact {
    constructor(parent, look) {
      this.look = look;
      this.box = html("figure", "mcdas-escapes", parent);
      this.caption = "time to react: the last moment to begin [s]";
      html("figcaption", "", this.box, this.caption);
      this.frame = html("div", "", this.box);
      this.svg = shape("svg", { class: "mcdas-picture", role: "img", "aria-label": "times to react" }, this.frame);
      this.width = 0;
      fitted(this.frame, (width) => { this.width = width; this.draw(); });
    }

    show(escapes) { this.escapes = escapes; this.draw(); }

    draw() {
      if (!this.escapes || this.width < 120) return;
      const { look, width } = this, height = TOP + 4 * ROW + 20;
      set(this.svg, { width, height, viewBox: `0 0 ${width} ${height}` });
      clear(this.svg);
      const x = (t) => LEFT + (t / MOST) * (width - LEFT - RIGHT);
      const put = (px, py, text, extra) => {
        const made = shape("text", { x: px, y: py, "font-size": 11.5, fill: "#222", ...extra }, this.svg);
        made.textContent = text;
        return made;
      };
      for (let t = 0; t <= MOST; t += 2) {
        shape("path", { d: `M${x(t)} ${TOP}V${TOP + 4 * ROW}`, stroke: "#e2e2e2" }, this.svg);
        put(x(t), height - 6, `${t} s`, { "text-anchor": "middle", "font-size": 10.5, fill: "#444" });
      }
      Object.keys(NAMES).forEach((key, k) => {
        const found = this.escapes[key], top = TOP + k * ROW + 4, tall = ROW - 8, middle = top + tall / 2 + 4;
        put(LEFT - 8, middle, NAMES[key], { "text-anchor": "end" });
        const until = found.last_moment_s;
        const by = found.closed_by ? ` by ${found.closed_by}` : "";
        const asks = found.demand_mps2 === null || found.demand_mps2 === undefined ? "" : `, asks ${found.demand_mps2.toFixed(1)} m/s² now`;
        let text, from = x(0);
        if (until === null || until === undefined) {
          text = `closed${by}`;
          shape("rect", { x: x(0), y: top, width: x(MOST) - x(0), height: tall, fill: "#f3e3da", stroke: look.danger, "stroke-width": 1, "stroke-dasharray": "3 3" }, this.svg);
        } else {
          const end = Math.max(x(until), x(0) + 2);
          shape("rect", { x: x(0), y: top, width: end - x(0), height: tall, fill: look.safe, "fill-opacity": 0.35, stroke: look.safe, "stroke-width": 1.2 }, this.svg);
          shape("path", { d: `M${end} ${top - 2}V${top + tall + 2}`, stroke: look.black, "stroke-width": 2 }, this.svg);
          text = until >= MOST - 1e-6 ? `open${asks}` : `${until.toFixed(1)} s, then closed${by}${asks}`;
          if (!asks) text = `not just now; ${text}`;
          from = end;
        }
        const inside = text.length * 6.4 > x(MOST) - from - 8;
        put(inside ? x(0) + 6 : from + 7, middle, text, { "paint-order": "stroke", stroke: "#fff", "stroke-width": inside ? 2.5 : 0 });
      });
    }
  }

  window.mcdas.TimesToReact = TimesToReact;
})();
