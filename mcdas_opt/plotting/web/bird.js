// The road from above: asphalt, bodies, paths, tracks. One `show` replaces what was shown before.
(function () {
  "use strict";
  const { shape, set, html, clear, path, corners, Camera, fitted } = window.mcdas;

  const NAMED = 150; // [m] whoever is out of the picture and nearer than this is named at its edge
  const TALL = 15, LETTER = 6.6, EDGE = 5; // [px] of a word, and of one of its letters

  class Bird {
    // `state` as in `show`; `look` is the palette of plotting/web.py.
    constructor(parent, look, label) {
      this.look = look;
      this.box = html("div", "mcdas-bird", parent);
      this.svg = shape("svg", { class: "mcdas-picture", role: "img", "aria-label": label }, this.box);
      this.ground = shape("g", {}, this.svg);
      this.moving = shape("g", {}, this.svg);
      this.scale = shape("g", {}, this.svg);
      this.width = 0;
      fitted(this.box, (width) => { this.width = width; this.relay(); });
    }

    setRoad(road, view) {
      this.road = road;
      this.view = view;
      this.relay();
    }

    // Lays the road out anew, after a change of width or road.
    relay() {
      if (!this.road || !this.width) return;
      const most = (this.width < 620 ? 0.3 : 0.55) * window.innerHeight;
      const view = { ...this.view };
      const fewest = 5.5 * (view.back + view.ahead); // at least so many pixels a metre; what does not fit is cut off
      if (this.width < fewest) {
        const share = this.width / fewest;
        view.back *= share; view.ahead *= share;
      }
      const tall = (this.width * (view.left - view.right)) / (view.back + view.ahead);
      if (tall > most) {
        const middle = (view.left + view.right) / 2, half = ((view.left - view.right) / 2) * (most / tall);
        const low = Math.min(view.right, this.road.low), high = Math.max(view.left, this.road.high);
        view.left = Math.min(Math.max(middle + half, this.road.high + 1), high);
        view.right = Math.max(Math.min(middle - half, this.road.low - 1), low);
      }
      this.camera = new Camera(view, this.width);
      set(this.svg, { width: this.width, height: this.camera.height, viewBox: `0 0 ${this.width} ${this.camera.height}` });
      this.drawGround();
      this.drawScale();
      if (this.state) this.show(this.state);
    }

    drawGround() {
      const { look, road } = this, k = this.camera.scale;
      clear(this.ground);
      const raw = (points) => points.map((p, i) => (i ? "L" : "M") + p[0] + " " + p[1]).join("");
      const still = { "vector-effect": "non-scaling-stroke", fill: "none" };
      shape("path", { d: raw([...road.left, ...road.right.slice().reverse()]) + "Z", fill: look.asphalt }, this.ground);
      for (const side of [road.left, road.right]) {
        shape("path", { d: raw(side), stroke: look.edge, "stroke-width": 1.6, ...still }, this.ground);
      }
      for (const mark of road.marks) {
        const dash = `${3 * k} ${6 * k}`;
        shape("path", { d: raw(mark), stroke: look.marking, "stroke-width": 2.2, "stroke-dasharray": dash, ...still }, this.ground);
      }
      if (road.end) shape("path", { d: raw(road.end), stroke: look.danger, "stroke-width": 4, ...still }, this.ground);
    }

    drawScale() {
      clear(this.scale);
      const k = this.camera.scale, x = this.width - 14 - 10 * k, y = this.camera.height - 9;
      shape("path", { d: path([[x, y], [x + 10 * k, y]]), stroke: this.look.black, "stroke-width": 2, fill: "none" }, this.scale);
      this.word(this.scale, x - 5, y + 3.5, "10 m", { "text-anchor": "end", "font-size": 11 });
    }

    word(parent, x, y, text, extra) {
      const made = shape("text", {
        x, y, fill: this.look.ink, "font-size": 11.5, "paint-order": "stroke", stroke: this.look.paper, "stroke-width": 3, "stroke-linejoin": "round", ...extra,
      }, parent);
      made.textContent = text;
      return made;
    }

    // state: { camera: [x, y, theta], bodies, paths, tracks, ghosts, trail, from: [x, y] that distances are told from }
    show(state) {
      this.state = state;
      if (!this.camera) return;
      this.camera.at(...state.camera);
      set(this.ground, { transform: this.camera.matrix });
      clear(this.moving);
      if (state.trail && state.trail.length > 1) {
        this.line(state.trail, { stroke: this.look.black, "stroke-width": 1.4, opacity: 0.55 });
      }
      for (const one of state.paths || []) this.drawPath(one);
      for (const ghost of state.ghosts || []) this.drawBody(ghost, true);
      this.away = [];
      this.taken = []; // boxes of bodies and their names: [from, to, over, under]
      for (const body of state.bodies || []) this.drawBody(body, false);
      this.nameAtTheEdge(state);
      for (const track of state.tracks || []) this.drawTrack(track);
      if (this.dressed) this.dressed(); // whoever lays something over the picture
    }

    line(points, how) {
      return shape("path", {
        d: path(points.map((p) => this.camera.place(p))), fill: "none", "stroke-linejoin": "round", "stroke-linecap": "round", ...how,
      }, this.moving);
    }

    // { points, colour, dash, width, seconds }: a dot a second
    drawPath(one) {
      const width = one.width || 2.6;
      this.line(one.points, { stroke: this.look.paper, "stroke-width": width + 2.6, opacity: 0.75 });
      this.line(one.points, { stroke: one.colour, "stroke-width": width, "stroke-dasharray": one.dash || null, "stroke-linecap": one.dash ? "butt" : "round" });
      for (const point of one.seconds || []) {
        const [x, y] = this.camera.place(point);
        shape("circle", { cx: x, cy: y, r: 3.6, fill: one.colour, stroke: "#fff", "stroke-width": 1.2 }, this.moving);
      }
    }

    // { name, pose: [x, y, yaw], length, width, colour, struck }; a ghost that is `supposed` may be where it is, and is named below
    drawBody(body, ghost) {
      const [x, y, yaw] = body.pose;
      const points = corners(x, y, yaw, body.length, body.width).map((p) => this.camera.place(p));
      const [cx, cy] = this.camera.place([x, y]);
      const over = (axis, most) => points.some((p) => p[axis] > 0) && points.some((p) => p[axis] < most);
      if (!over(0, this.width) || !over(1, this.camera.height)) {
        if (!ghost && body.name) this.away.push({ name: body.name, x, y, cx, cy });
        return;
      }
      shape("path", {
        d: path(points) + "Z", "stroke-linejoin": "round", fill: ghost && !body.tinted ? "none" : body.colour, "fill-opacity": body.tinted ? 0.3 : null,
        stroke: body.struck ? this.look.danger : ghost ? body.colour : this.look.black,
        "stroke-width": body.struck ? 3.2 : ghost ? 1.8 : 1, "stroke-dasharray": ghost ? "4 2.5" : null,
      }, this.moving);
      if (ghost) {
        const low = Math.max(...points.map((p) => p[1]));
        if (body.supposed) this.word(this.moving, cx, low + 12, body.name, { "text-anchor": "middle" });
        return;
      }
      const screen = [0.4, -0.4].map((q) => {
        const a = 0.22 * body.length, b = q * body.width, c = Math.cos(yaw), s = Math.sin(yaw);
        return this.camera.place([x + c * a - s * b, y + s * a + c * b]);
      });
      shape("path", { d: path(screen), stroke: "#fff", "stroke-width": 2, fill: "none" }, this.moving);
      const top = Math.max(Math.min(...points.map((p) => p[1])), TALL);
      const half = (LETTER * (body.name || "").length) / 2;
      const within = Math.min(Math.max(cx, half), this.width - half); // where the body is partly out of the picture
      if (body.name) this.word(this.moving, within, top - 4, body.name, { "text-anchor": "middle" });
      const xs = points.map((p) => p[0]), low = Math.max(...points.map((p) => p[1]));
      this.taken.push([Math.min(within - half, ...xs), Math.max(within + half, ...xs), top - TALL, low]);
    }

    // Who is out of the picture, and how far from the host: the nearest first, above or below its place where that is taken.
    nameAtTheEdge(state) {
      const { taken, width } = this, { height } = this.camera, host = state.from || state.camera;
      const far = (body) => Math.hypot(body.x - host[0], body.y - host[1]);
      for (const body of this.away.sort((a, b) => far(a) - far(b))) {
        if (far(body) > NAMED) continue;
        const text = `${body.name} (${far(body).toFixed(0)} m)`, beside = body.cx < 0 || body.cx > width, right = beside && body.cx > width;
        const word = right ? `${text} ▶` : `${beside ? "◀" : body.cy < 0 ? "▲" : "▼"} ${text}`, wide = LETTER * word.length;
        const x = Math.min(Math.max(body.cx - wide / 2, EDGE), width - wide - EDGE);
        const y = Math.min(Math.max(body.cy - TALL / 2, EDGE), height - TALL - EDGE);
        const free = [0, 1, -1, 2, -2].map((k) => y + k * TALL).find((q) => q >= 0 && q <= height - TALL && !taken.some(
          (r) => x < r[1] && x + wide > r[0] && q < r[3] && q + TALL > r[2]));
        if (free === undefined) continue;
        taken.push([x, x + wide, free, free + TALL]);
        this.word(this.moving, right ? x + wide : x, free + TALL - 4, word, { "text-anchor": right ? "end" : "start", class: "mcdas-away" });
      }
    }

    // [x, y, semi-axis along, semi-axis across, angle]
    drawTrack(track) {
      const [x, y, a, b, angle] = track, c = Math.cos(angle), s = Math.sin(angle), points = [];
      for (let k = 0; k <= 32; k++) {
        const u = a * Math.cos((k * Math.PI) / 16), v = b * Math.sin((k * Math.PI) / 16);
        points.push([x + c * u - s * v, y + s * u + c * v]);
      }
      for (const [colour, width] of [[this.look.paper, 4], [this.look.track, 1.8]]) {
        this.line(points, { stroke: colour, "stroke-width": width });
        const [px, py] = this.camera.place([x, y]);
        shape("circle", { cx: px, cy: py, r: width / 2 + 1, fill: colour }, this.moving);
      }
    }
  }

  window.mcdas.Bird = Bird;
})();
