// Cars on the road from above: dragged, moved by the arrow keys, added, removed. What is edited is told as keys of the scene's file.
(function () {
  "use strict";
  const { html, shape, set, clear, path, corners } = window.mcdas;
  const SNAP_M = 0.3, FAR_M = [-120, 320], CLEAR_M = [8, 2.4];

  class SceneEditor {
    // tell: { change(changes, stroke), selected(key) }
    constructor(bird, look, tell) {
      Object.assign(this, { bird, look, tell });
      this.layer = shape("g", {}, bird.svg);
      this.grips = {};
      this.strokes = 0;
      bird.dressed = () => this.draw();
      bird.svg.addEventListener("dblclick", (event) => this.addAt(event));
    }

    show(state) {
      this.state = state;
      if (this.selected && !this.handle(this.selected)) this.select(null);
      this.draw();
    }

    handle(key) { return ((this.state && this.state.handles) || []).find((one) => one.key === key); }

    select(key) {
      this.selected = key;
      this.tell.selected(key);
      this.draw();
    }

    // (s, d) of somebody, as the scene says
    place(key) {
      const { scene } = this.state;
      if (key === "host") return [0, scene.host.d_m];
      const car = scene.neighbour[Number(key.match(/\d+/)[0])];
      return [car.s_m, car.d_m || 0];
    }

    draw() {
      const handles = this.active ? (this.state && this.state.handles) || [] : [], { camera } = this.bird;
      if (!camera) return;
      for (const key in this.grips) {
        if (!handles.some((one) => one.key === key)) { this.grips[key].box.remove(); delete this.grips[key]; }
      }
      for (const handle of handles) {
        const grip = this.grips[handle.key] || this.grip(handle);
        grip.box.setAttribute("class", `mcdas-grip${handle.key === this.selected ? " selected" : ""}${handle.fixed ? " fixed" : ""}`);
        const [s, d] = handle.fixed ? [0, 0] : this.place(handle.key);
        const where = handle.key === "host" ? "" : `, ${Math.abs(s).toFixed(1)} m ${s < 0 ? "behind" : "ahead"}`;
        grip.box.setAttribute("aria-label", `${handle.name}${where}, ${d.toFixed(2)} m to the left: drag, or arrow keys`);
        if (this.held !== handle.key) this.lay(grip, handle, handle.pose);
      }
    }

    lay(grip, { length, width }, [x, y, yaw]) {
      const { camera } = this.bird, [cx, cy] = camera.place([x, y]);
      set(grip.outline, { d: path(corners(x, y, yaw, length, width).map((p) => camera.place(p))) + "Z" });
      set(grip.touch, { cx, cy });
    }

    grip({ key }) {
      const box = shape("g", { tabindex: 0, role: "button", "data-grip": key }, this.layer);
      const grip = { box, touch: shape("circle", { r: 15, fill: "transparent" }, box), outline: shape("path", {}, box) };
      shape("title", {}, box).textContent = "drag along and across the road; arrow keys move it, Delete removes it";
      box.addEventListener("pointerdown", (event) => this.grab(event, key, grip));
      box.addEventListener("focus", () => { if (this.selected !== key) this.select(key); });
      box.addEventListener("keydown", (event) => this.key(event, key));
      box.addEventListener("dblclick", (event) => event.stopPropagation());
      this.grips[key] = grip;
      return grip;
    }

    // s, d and yaw of the road at a point of the window
    pointed(event) {
      const box = this.bird.svg.getBoundingClientRect(), [x, y] = this.bird.camera.plane(event.clientX - box.left, event.clientY - box.top);
      const { axis } = this.state;
      if (!axis.length) return [x, y, 0, [x, y]];
      let best = axis[0], least = Infinity;
      for (const one of axis) {
        const away = (one[1] - x) ** 2 + (one[2] - y) ** 2;
        if (away < least) { least = away; best = one; }
      }
      const [s, ax, ay, yaw] = best, c = Math.cos(yaw), n = Math.sin(yaw);
      return [s + c * (x - ax) + n * (y - ay), -n * (x - ax) + c * (y - ay), yaw, [x, y]];
    }

    grab(event, key, grip) {
      const handle = this.handle(key);
      if (!handle) return;
      event.preventDefault();
      grip.box.focus();
      this.select(key);
      if (handle.fixed) return;
      grip.box.setPointerCapture(event.pointerId);
      this.held = key;
      const stroke = `drag ${++this.strokes}`, [s0, d0] = this.place(key), from = this.pointed(event);
      let moved = false;
      const move = (now) => {
        const at = this.pointed(now), free = now.shiftKey;
        if (!moved && Math.hypot(at[0] - from[0], at[1] - from[1]) < 0.15) return;
        moved = true;
        const s = key === "host" ? 0 : s0 + at[0] - from[0], d = this.snapped(d0 + at[1] - from[1], free);
        const ahead = s - s0 - (at[0] - from[0]), across = d - d0 - (at[1] - from[1]), c = Math.cos(at[2]), n = Math.sin(at[2]);
        const offset = [handle.pose[0] - from[3][0], handle.pose[1] - from[3][1]];
        this.lay(grip, handle, [at[3][0] + offset[0] + c * ahead - n * across, at[3][1] + offset[1] + n * ahead + c * across, at[2]]);
        this.move(key, s, d, stroke);
      };
      const drop = () => {
        grip.box.removeEventListener("pointermove", move);
        this.held = null;
        if (moved) this.tell.change({}, stroke); // asks once more, and the picture takes its place
        this.draw();
      };
      grip.box.addEventListener("pointermove", move);
      grip.box.addEventListener("pointerup", drop, { once: true });
      grip.box.addEventListener("pointercancel", drop, { once: true });
    }

    snapped(d, free) {
      const lane = this.state.lanes.find((middle) => Math.abs(middle - d) < SNAP_M);
      return lane === undefined || free ? Math.round(20 * d) / 20 : lane;
    }

    move(key, s, d, stroke) {
      const near = Math.min(Math.max(Math.round(10 * s) / 10, FAR_M[0]), FAR_M[1]);
      this.tell.change(key === "host" ? { "host.d_m": d } : { [`${key}.s_m`]: near, [`${key}.d_m`]: d }, stroke);
    }

    key(event, key) {
      const handle = this.handle(key), step = event.shiftKey ? 5 : 0.5;
      const by = { ArrowRight: [step, 0], ArrowLeft: [-step, 0], ArrowUp: [0, step / 5], ArrowDown: [0, -step / 5] }[event.key];
      if (event.key === "Delete" || event.key === "Backspace") this.remove();
      else if (by && handle && !handle.fixed) {
        const [s, d] = this.pending && this.pending.key === key ? this.pending.at : this.place(key);
        this.pending = { key, at: [s + by[0], Number((d + by[1]).toFixed(2))] };
        this.move(key, ...this.pending.at, `keys ${key} ${Math.floor(performance.now() / 1500)}`);
      } else return;
      event.preventDefault();
    }

    answered() { this.pending = null; }

    remove() {
      if (!this.selected || this.selected === "host") return;
      const key = this.selected;
      this.select(null);
      this.tell.change({ [key]: null });
    }

    // A car of the host's speed, at the first free place.
    fresh(at) {
      const cars = this.state.scene.neighbour, taken = this.state.handles.map((one) => (one.fixed ? [1e9, 0] : this.place(one.key)));
      const free = ([s, d]) => taken.every(([q, e]) => Math.abs(q - s) > CLEAR_M[0] || Math.abs(e - d) > CLEAR_M[1]);
      const places = [25, -25, 40, -40, 12, -12, 60, -60, 80, 100, 130].flatMap((s) => [...this.state.lanes].sort((a, b) => Math.abs(a) - Math.abs(b)).map((d) => [s, d]));
      const [s, d] = at || places.find(free) || [150, 0];
      let number = cars.length + 1;
      while (cars.some((car) => car.name === `car ${number}`)) number++;
      return { name: `car ${number}`, s_m: s, d_m: d, speed_mps: this.state.scene.host.speed_mps };
    }

    add(at) {
      if (!this.state || !this.state.scene) return;
      const key = `neighbour[${this.state.scene.neighbour.length}]`;
      this.selected = key;
      this.tell.change({ [key]: this.fresh(at) });
      this.tell.selected(key);
    }

    addAt(event) {
      if (!this.active || !this.state.scene) return;
      const [s, d] = this.pointed(event);
      this.add([Math.round(10 * s) / 10, this.snapped(d, event.shiftKey)]);
    }
  }

  window.mcdas.SceneEditor = SceneEditor;
})();
