// A parking manoeuvre that plays and scrubs, among its obstacles.
(function () {
  "use strict";
  const { shape, set, html, clear, path, corners, fitted, at, Strip, Transport } = window.mcdas;

  // The plane with obstacles; also draws handles that can be dragged (the studio's slot).
  class Yard {
    constructor(parent, look) {
      this.look = look;
      this.box = html("div", "mcdas-yard", parent);
      this.svg = shape("svg", { class: "mcdas-picture", role: "img", "aria-label": "the parking place from above" }, this.box);
      this.ground = shape("g", {}, this.svg);
      this.moving = shape("g", {}, this.svg);
      this.top = shape("g", {}, this.svg);
      this.width = 0;
      fitted(this.box, (width) => { this.width = width; this.relay(); });
    }

    // yard: { obstacles, bounds: [x0, y0, x1, y1], car: { length, width, centre }, start, goal }
    load(yard) { this.yard = yard; this.relay(); }

    relay() {
      const { yard, look, width } = this;
      if (!yard || !width) return;
      const [x0, y0, x1, y1] = yard.bounds;
      this.scale = Math.min(width / (x1 - x0), (0.55 * window.innerHeight) / (y1 - y0));
      this.left = (width - this.scale * (x1 - x0)) / 2;
      const height = this.scale * (y1 - y0);
      set(this.svg, { width, height, viewBox: `0 0 ${width} ${height}` });
      clear(this.ground);
      shape("rect", { x: 0, y: 0, width, height, fill: look.asphalt }, this.ground);
      for (const outline of yard.obstacles) {
        shape("path", { d: path(outline.map((p) => this.place(p))) + "Z", fill: look.obstacle, stroke: look.edge, "stroke-width": 1.2 }, this.ground);
      }
      this.body(this.ground, yard.start, { fill: "none", stroke: look.grey, "stroke-dasharray": "4 3", "stroke-width": 1.4 });
      this.body(this.ground, yard.goal, { fill: look.safe, "fill-opacity": 0.18, stroke: look.safe, "stroke-width": 1.6 });
      this.word(this.ground, yard.start, "start");
      this.word(this.ground, yard.goal, "goal");
      if (this.again) this.again();
      if (this.dressed) this.dressed();
    }

    place([x, y]) {
      const [x0, , , y1] = this.yard.bounds;
      return [this.left + (x - x0) * this.scale, (y1 - y) * this.scale];
    }

    plane(px, py) {
      const [x0, , , y1] = this.yard.bounds;
      return [x0 + (px - this.left) / this.scale, y1 - py / this.scale];
    }

    // The car with its rear axle's midpoint at the pose.
    outline([x, y, yaw]) {
      const { length, width, centre } = this.yard.car;
      return corners(x + centre * Math.cos(yaw), y + centre * Math.sin(yaw), yaw, length, width).map((p) => this.place(p));
    }

    body(parent, pose, how) {
      const points = this.outline(pose);
      shape("path", { d: path(points) + "Z", "stroke-linejoin": "round", ...how }, parent);
      shape("path", { d: path([points[0], points[3]]), stroke: how.stroke, "stroke-width": 3, fill: "none" }, parent);
    }

    word(parent, pose, text) {
      const points = this.outline(pose);
      const x = points.reduce((sum, p) => sum + p[0], 0) / 4, y = points.reduce((sum, p) => sum + p[1], 0) / 4;
      shape("text", { x, y: y + 4, "text-anchor": "middle", "font-size": 11.5, fill: this.look.ink }, parent).textContent = text;
    }

    line(points, how) {
      shape("path", { d: path(points.map((p) => this.place(p))), fill: "none", "stroke-linecap": "round", "stroke-linejoin": "round", ...how }, this.moving);
    }

    // manoeuvre: { t, poses, gears, ... }, up to a time; `trace` draws the swept body
    show(manoeuvre, time) {
      this.again = () => this.show(manoeuvre, time);
      if (!this.yard || !this.width) return;
      clear(this.moving);
      if (!manoeuvre) return;
      const { look } = this, now = at(manoeuvre.t, time), colours = { 1: look.forward, "-1": look.reverse };
      const step = Math.max(1, Math.round(manoeuvre.t.length / 70));
      for (let k = 0; k < manoeuvre.t.length; k += step) {
        const points = this.outline(manoeuvre.poses[k]);
        shape("path", { d: path(points) + "Z", fill: "none", stroke: colours[manoeuvre.gears[k]], "stroke-width": 0.7, opacity: k <= now ? 0.5 : 0.15 }, this.moving);
      }
      for (let from = 0; from < manoeuvre.t.length - 1;) {
        let to = from + 1;
        while (to < manoeuvre.t.length - 1 && manoeuvre.gears[to] === manoeuvre.gears[from]) to++;
        const reverse = manoeuvre.gears[from] < 0;
        this.line(manoeuvre.poses.slice(from, to + 1), {
          stroke: colours[manoeuvre.gears[from]], "stroke-width": 2.6, "stroke-dasharray": reverse ? "7 4" : null, "stroke-linecap": "butt",
        });
        from = to;
      }
      for (const person of this.yard.people || []) {
        if (time < person.from || time >= person.until) continue;
        shape("path", { d: path(person.outline.map((p) => this.place(p))) + "Z", fill: look.danger, stroke: look.black }, this.moving);
      }
      const colour = colours[manoeuvre.gears[now]];
      this.body(this.moving, manoeuvre.poses[now], { fill: colour, "fill-opacity": 0.6, stroke: look.black, "stroke-width": 1.2 });
    }
  }

  class Parking {
    constructor(parent, look) {
      this.look = look;
      this.head = html("div", "mcdas-head", parent);
      this.badge = html("span", "mcdas-badge", this.head);
      this.words = html("span", "mcdas-words", this.head);
      this.speed = html("span", "mcdas-speed", this.head);
      this.yard = new Yard(parent, look);
      this.transport = new Transport(parent, (time) => this.show(time));
      this.legend = html("div", "mcdas-legend", parent);
      for (const [kind, text] of [["forward", "rear axle, forward"], ["reverse", "rear axle, in reverse"]]) {
        const item = html("span", "mcdas-key", this.legend);
        html("i", `mcdas-swatch ${kind}`, item);
        html("span", "", item, text);
      }
      const strips = html("div", "mcdas-strips", parent);
      this.strips = [0, 1].map(() => new Strip(strips, look, (t) => { this.transport.pause(); this.transport.go(t); }));
    }

    load(parking) {
      this.manoeuvre = null;
      this.yard.load(parking.yard);
      this.words.textContent = parking.words;
      this.words.classList.toggle("bad", !parking.sound);
      this.badge.textContent = parking.status;
      this.badge.className = `mcdas-badge ${parking.sound ? "planned" : "failed"}`;
      this.manoeuvre = parking.manoeuvre;
      this.yard.show(this.manoeuvre, 0);
      for (const part of [this.transport.bar, this.legend, ...this.strips.map((s) => s.box)]) part.hidden = !this.manoeuvre;
      if (!this.manoeuvre) { this.speed.textContent = ""; return; }
      this.strips.forEach((strip, k) => strip.show(parking.charts[k]));
      this.transport.load(parking.duration);
    }

    show(time) {
      const manoeuvre = this.manoeuvre;
      if (!manoeuvre) return;
      this.yard.show(manoeuvre, time);
      const k = at(manoeuvre.t, time), v = manoeuvre.speed[k];
      this.speed.textContent = `${v < 0 ? "reverse" : "forward"} ${Math.abs(v).toFixed(1)} m/s, gear changes so far: ${manoeuvre.changes[k]}`;
      for (const strip of this.strips) strip.mark(time);
    }
  }

  Object.assign(window.mcdas, { Yard, Parking });
})();
