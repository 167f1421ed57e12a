// The tab of parking: a slot whose ends, kerb and opposite side can be dragged, and the start with them.
(function () {
  "use strict";
  const { html, clear, shape, fillFiles, Parking, Knobs, Asking } = window.mcdas;

  class ParkingTab {
    constructor(root, look, setup, emit) {
      Object.assign(this, { root, look, setup, emit });
      this.values = {};
      this.side = html("div", "mcdas-side", root);
      this.main = html("div", "mcdas-main", root);
      this.fillSide();
      this.problem = html("div", "mcdas-problem", this.main);
      this.problem.setAttribute("role", "alert");
      this.problem.hidden = true;
      const bar = html("div", "mcdas-row mcdas-bar", this.main);
      this.title = html("h2", "", bar);
      this.state = html("span", "mcdas-latency", bar);
      this.view = new Parking(this.main, look);
      this.view.yard.dressed = () => this.dress();
      this.view.transport.listen(() => this.root.offsetParent !== null);
      html("p", "mcdas-hint", this.main, "Drag the round handles: the slot's end, its kerb, the opposite side, the start. The two-arc path answers while you drag; the planner chosen on the left when you let go.");
      this.asking = new Asking((question) => emit("park", question), () => {});
      window.mcdas.parkingTab = this;
    }

    fillSide() {
      const open = html("fieldset", "", this.side);
      html("legend", "", open, "parking case");
      this.files = html("select", "mcdas-files", open);
      this.files.setAttribute("aria-label", "parking case");
      fillFiles(this.files, this.setup.files);
      this.files.addEventListener("change", () => {
        const { kind, name } = this.files.selectedOptions[0].dataset;
        this.values = {};
        this.emit("open", { kind, name });
      });
      this.planner = html("select", "mcdas-files", open);
      this.planner.setAttribute("aria-label", "parking planner");
      for (const name of this.setup.planners) html("option", "", this.planner, name).value = name;
      this.planner.addEventListener("change", () => this.ask(false));
      const row = html("div", "mcdas-row", open);
      const toml = html("button", "", row, "Save case"), png = html("button", "", row, "Save PNG"), back = html("button", "", row, "Back");
      for (const button of [toml, png, back]) button.type = "button";
      back.title = "sliders and handles back to the case";
      toml.addEventListener("click", () => this.emit("save", { values: this.values }));
      png.addEventListener("click", () => this.png());
      back.addEventListener("click", () => { this.values = {}; this.ask(false); });
      this.knobs = new Knobs(this.side, this.setup.knobs, (key, value) => { this.values[key] = value; this.ask(true); });
      for (const key in this.knobs.rows) this.knobs.rows[key].slider.addEventListener("change", () => this.ask(false));
    }

    ask(live) {
      this.live = live;
      if (!live) this.state.textContent = "planning …";
      this.asking.ask({ values: this.values, planner: this.planner.value, live }, performance.now());
    }

    hear(part) {
      if (part.part === "opened") {
        this.title.textContent = part.name;
        this.put(part);
        this.ask(false);
      } else if (part.part === "place") {
        this.problem.hidden = true;
        this.put(part);
      } else if (part.part === "parking") {
        const parking = part.parking;
        if (this.bounds && this.live) parking.yard.bounds = this.bounds; // the ground does not move under the pointer
        this.bounds = parking.yard.bounds;
        this.view.load(parking);
        this.state.textContent = `${part.planner}: ${part.seconds.toFixed(2)} s of computing`;
      } else if (part.part === "waiting") {
        this.state.textContent = `${part.text} …`;
      } else if (part.part === "problem") {
        this.problem.textContent = part.text;
        this.problem.hidden = false;
        this.state.textContent = "";
      } else if (part.part === "done") this.asking.done(part.token);
    }

    put(part) {
      this.handles = part.handles;
      const held = document.activeElement;
      for (const key in this.knobs.rows) {
        if (this.knobs.rows[key].slider === held && key in this.values) part.positions[key] = this.values[key];
      }
      this.knobs.put(part.positions);
      this.dress();
    }

    // Handles over the yard.
    dress() {
      const { yard } = this.view;
      if (!yard.yard || !this.handles || this.held) return; // a handle that is being dragged stays
      clear(yard.top);
      for (const handle of this.handles) {
        const [x, y] = yard.place(handle.at);
        const knob = shape("circle", {
          cx: x, cy: y, r: 10, fill: "#fff", "fill-opacity": 0.9, stroke: this.look.host, "stroke-width": 3, class: "mcdas-handle", "data-handle": handle.key,
        }, yard.top);
        shape("title", {}, knob).textContent = `drag: ${handle.key}`;
        knob.addEventListener("pointerdown", (event) => this.grab(event, handle, knob));
      }
    }

    grab(event, handle, knob) {
      event.preventDefault();
      knob.setPointerCapture(event.pointerId);
      this.held = handle;
      const { yard } = this.view;
      const box = yard.svg.getBoundingClientRect();
      const move = (moved) => {
        const [x, y] = yard.plane(moved.clientX - box.left, moved.clientY - box.top);
        let changed = false;
        handle.moves.forEach((key, axis) => {
          if (!key) return;
          const name = key.replace("-", ""), { knob: range } = this.knobs.rows[name];
          const raw = (key.startsWith("-") ? -1 : 1) * (axis ? y : x);
          const value = Math.min(Math.max(Math.round(raw / range.step) * range.step, range.low), range.high);
          if (Math.abs(value - (this.values[name] ?? NaN)) < 1e-9) return;
          this.values[name] = Number(value.toFixed(4));
          handle.at[axis] = (key.startsWith("-") ? -1 : 1) * value;
          changed = true;
        });
        const [px, py] = yard.place(handle.at);
        knob.setAttribute("cx", px);
        knob.setAttribute("cy", py);
        if (changed) this.ask(true);
      };
      const drop = () => {
        knob.removeEventListener("pointermove", move);
        this.held = null;
        this.ask(false);
      };
      knob.addEventListener("pointermove", move);
      knob.addEventListener("pointerup", drop, { once: true });
      knob.addEventListener("pointercancel", drop, { once: true });
    }

    png() {
      const name = `${this.title.textContent.replace(/[^\w.-]+/g, "-") || "case"}.png`;
      const legend = [["rear axle, forward", this.look.forward, ""], ["rear axle, in reverse", this.look.reverse, "7 4"]];
      const rows = [[{ svg: this.view.yard.svg }]];
      if (this.view.manoeuvre) rows.push(this.view.strips.map((one) => ({ svg: one.svg, caption: one.title.textContent })));
      window.mcdas.savePng(name, this.title.textContent, this.view.words.textContent, legend, rows);
    }
  }

  window.mcdas.ParkingTab = ParkingTab;
})();
