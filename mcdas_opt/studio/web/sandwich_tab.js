// The tab of the sandwich: sliders, the road from above with every planner's path, times to react, charts, words; and the closed loop.
(function () {
  "use strict";
  const { html, clear, shape, candidateLines, fillFiles, Outlook, Drive, Knobs, TimesToReact, Asking } = window.mcdas;

  class SandwichTab {
    // setup: { knobs, planners, files, upload }; emit(name, payload) tells the server
    constructor(root, look, setup, emit) {
      Object.assign(this, { root, look, setup, emit });
      this.values = {};
      this.plans = {};
      this.hidden = new Set(setup.planners.filter((planner) => !planner.shown).map((planner) => planner.name));
      this.looks = Object.fromEntries(setup.planners.map((planner) => [planner.name, planner]));
      this.side = html("div", "mcdas-side", root);
      this.main = html("div", "mcdas-main", root);
      this.fillSide();
      this.fillMain();
      this.offerOthers();
      this.asking = new Asking((question) => emit("ask", question), () => this.tellLatency());
      window.mcdas.studio = this;
    }

    fillSide() {
      const open = html("fieldset", "", this.side);
      html("legend", "", open, "what is looked at");
      this.files = html("select", "mcdas-files", open);
      this.files.setAttribute("aria-label", "scene, log or benchmark row");
      fillFiles(this.files, this.setup.files);
      this.files.addEventListener("change", () => {
        const chosen = this.files.selectedOptions[0];
        this.open({ kind: chosen.dataset.kind, name: chosen.dataset.name });
      });
      const row = html("div", "mcdas-row", open);
      const pick = html("label", "mcdas-button", row, "Load…");
      const file = html("input", "mcdas-file", pick);
      pick.title = "a scene (.toml), or a recording of radar (.log, .csv)";
      Object.assign(file, { type: "file", accept: ".toml,.log,.csv" });
      file.addEventListener("change", () => { if (file.files[0]) this.upload(file.files[0]); file.value = ""; });
      this.saveToml = html("button", "", row, "Save scene");
      this.savePng = html("button", "", row, "Save PNG");
      for (const button of [this.saveToml, this.savePng]) button.type = "button";
      this.saveToml.title = "download this scene with the sliders' values";
      this.savePng.title = "download what is shown as a picture";
      this.saveToml.addEventListener("click", () => this.emit("save", { values: this.values }));
      this.savePng.addEventListener("click", () => this.png());
      this.rows = html("select", "mcdas-files", open);
      this.rows.hidden = true;
      this.rows.setAttribute("aria-label", "row of the benchmark");
      this.rows.addEventListener("change", () => this.open({ kind: "row", name: this.rows.value }));
      this.moment = html("div", "mcdas-knob", open);
      html("span", "name", this.moment, "moment of the log");
      this.momentShown = html("span", "value", this.moment);
      this.momentSlider = html("input", "", this.moment);
      Object.assign(this.momentSlider, { type: "range", step: 1, min: 0 });
      this.momentSlider.setAttribute("aria-label", "moment of the log");
      this.momentSlider.addEventListener("input", () => {
        this.faceMoment();
        this.ask(performance.now());
      });
      this.moment.hidden = true;
      this.note = html("p", "mcdas-hint", open);
      this.knobs = new Knobs(this.side, this.setup.knobs, (key, value, stamp) => {
        this.values[key] = value;
        this.showPaths();
        this.ask(stamp);
      });
      this.reset = html("button", "", this.side, "Sliders back");
      this.reset.type = "button";
      this.reset.addEventListener("click", () => { this.values = {}; this.knobs.put(this.positions); this.showPaths(); this.ask(performance.now()); });
    }

    fillMain() {
      this.problem = html("div", "mcdas-problem", this.main);
      this.problem.setAttribute("role", "alert");
      this.problem.hidden = true;
      const bar = html("div", "mcdas-row mcdas-bar", this.main);
      this.title = html("h2", "", bar);
      this.latency = html("span", "mcdas-latency", bar);
      this.driver = html("select", "", bar);
      this.driver.setAttribute("aria-label", "who drives the closed loop");
      for (const planner of this.setup.planners) {
        const option = html("option", "", this.driver, `${planner.label} drives`);
        option.value = planner.name;
        option.selected = planner.name === "mpc";
      }
      this.go = html("button", "mcdas-strong", bar, "▶ Drive the closed loop");
      this.back = html("button", "", bar, "Back to the paths");
      this.stop = html("button", "", bar, "Stop");
      for (const button of [this.go, this.back, this.stop]) button.type = "button";
      this.stop.hidden = this.back.hidden = true;
      this.go.addEventListener("click", () => {
        this.stop.hidden = false;
        this.go.disabled = true;
        this.emit("drive", { planner: this.driver.value, values: this.values });
      });
      this.back.addEventListener("click", () => this.showPaths());
      this.stop.addEventListener("click", () => this.emit("stop", {}));
      this.progress = html("progress", "", bar);
      this.progress.hidden = true;

      this.paths = html("div", "mcdas-paths", this.main);
      const head = html("div", "mcdas-head", this.paths);
      this.badge = html("span", "mcdas-badge", head);
      this.words = html("span", "mcdas-words", head);
      this.words.setAttribute("aria-live", "polite");
      this.outlook = new Outlook(this.paths, this.look);
      this.table = html("table", "mcdas-verdicts", this.paths);
      html("caption", "", this.table, "who does what, and what the judge says");
      this.body = html("tbody", "", this.table);
      this.others = html("div", "mcdas-others", this.paths);
      this.times = new TimesToReact(this.paths, this.look);
      this.outlook.chartsInto(this.paths);
      this.details = html("details", "", this.paths);
      html("summary", "", this.details, "candidates of the MPC");
      this.candidates = html("ul", "", this.details);

      this.loop = html("div", "mcdas-loop", this.main);
      this.loop.hidden = true;
      this.drive = new Drive(this.loop, this.look);
      this.drive.transport.listen(() => !this.loop.hidden && this.loop.offsetParent !== null);
    }

    open(what) {
      this.values = {};
      this.emit("open", what);
    }

    async upload(file) {
      if (file.size > this.setup.upload.most) { this.complain(`${file.name}: larger than ${this.setup.upload.most} bytes`); return; }
      try {
        const url = `${this.setup.upload.url}&name=${encodeURIComponent(file.name)}`;
        const answer = await fetch(url, { method: "POST", body: file });
        const said = await answer.json();
        if (said.error) this.complain(said.error);
        else { this.values = {}; this.emit("uploaded", { name: said.name }); }
      } catch (error) {
        this.complain(`${file.name}: could not be sent`);
      }
    }

    complain(text) {
      this.problem.textContent = text;
      this.problem.hidden = !text;
    }

    ask(stamp) {
      const question = { values: this.values, planners: this.setup.planners.map((p) => p.name).filter((name) => !this.hidden.has(name)) };
      if (!this.moment.hidden) question.moment = Number(this.momentSlider.value);
      this.asking.ask(question, stamp);
    }

    // What the server says, a part at a time.
    hear(part) {
      if (part.part === "opened") this.opened(part);
      else if (part.part === "picture") this.pictured(part);
      else if (part.part === "plan") { this.plans[part.planner] = { ...this.looks[part.planner], ...part }; this.soon(); }
      else if (part.part === "escapes") this.times.show(part.escapes);
      else if (part.part === "done") { this.draw(); this.asking.done(part.token); }
      else if (part.part === "progress") this.driving(part.done, part.of);
      else if (part.part === "drive") this.driven(part.drive);
      else if (part.part === "stopped") this.idle();
      else if (part.part === "problem") { this.complain(part.text); this.idle(); }
    }

    opened(part) {
      this.complain("");
      this.title.textContent = part.name;
      this.positions = part.positions;
      this.knobs.put(part.positions);
      this.plans = {};
      this.outlook.lookAhead(0);
      const log = Boolean(part.moments);
      this.moment.hidden = !log;
      this.note.textContent = part.note || "";
      this.go.hidden = this.driver.hidden = log;
      this.saveToml.disabled = log;
      if (log) {
        this.moments = part.moments;
        this.momentSlider.max = part.moments.length - 1;
        this.momentSlider.value = part.moment;
        this.faceMoment();
      }
      this.rows.hidden = !part.rows;
      if (part.rows) {
        clear(this.rows);
        for (const [value, text] of part.rows) html("option", "", this.rows, text).value = value;
      }
      if (part.rows) this.rows.value = part.row;
      if (part.planner && [...this.driver.options].some((option) => option.value === part.planner)) this.driver.value = part.planner;
      this.showPaths();
      this.ask(null);
    }

    faceMoment() {
      this.momentShown.textContent = `${this.moments[Number(this.momentSlider.value)].toFixed(1)} s`;
      this.momentSlider.setAttribute("aria-valuetext", this.momentShown.textContent);
    }

    pictured(part) {
      this.complain("");
      this.outlook.setPicture(part);
      this.soon();
    }

    // Draws once before the next frame, however many parts have come.
    soon() {
      if (this.pending) return;
      this.pending = requestAnimationFrame(() => { this.pending = 0; this.draw(); });
    }

    draw() {
      if (this.pending) { cancelAnimationFrame(this.pending); this.pending = 0; }
      if (!this.outlook.picture) return;
      this.outlook.draw(this.shown());
      this.tell();
    }

    shown() {
      return this.setup.planners.map((planner) => this.plans[planner.name]).filter((plan) => plan && !this.hidden.has(plan.planner));
    }

    tell() {
      const best = this.plans.mpc || Object.values(this.plans)[0];
      if (best) {
        this.badge.textContent = best.doing;
        this.badge.className = `mcdas-badge ${best.passed ? best.status : "failed"}`;
        const said = `${best.label}: ${best.words}${best.warning ? "; the driver is warned" : ""}. Why: ${best.reason}.`;
        if (this.words.textContent !== said) this.words.textContent = said;
      }
      this.setup.planners.forEach((planner, k) => {
        const row = this.body.children[k] || this.addRow(planner), plan = this.plans[planner.name];
        const told = plan && !this.hidden.has(planner.name);
        row.hidden = !planner.shown && this.hidden.has(planner.name);
        row.classList.toggle("off", !told);
        if (!told) { for (const cell of [...row.children].slice(2)) cell.textContent = ""; return; }
        const [, , doing, verdict, took] = row.children;
        doing.textContent = plan.doing;
        verdict.textContent = plan.words;
        verdict.className = plan.passed ? "good" : "bad";
        took.textContent = `${plan.took_ms.toFixed(0)} ms`;
      });
      const lines = this.plans.mpc ? candidateLines(this.plans.mpc) : [];
      this.details.hidden = !lines.length;
      if (lines.join() !== this.candidateLines) {
        this.candidateLines = lines.join();
        clear(this.candidates);
        for (const line of lines) html("li", "", this.candidates, line);
      }
    }

    addRow(planner) {
      const row = html("tr", "", this.body);
      html("td", "", row).appendChild(this.tick(planner));
      const name = html("th", "", row);
      name.scope = "row";
      const sample = shape("svg", { width: 34, height: 8, "aria-hidden": "true" }, name);
      shape("path", { d: "M0 4H34", stroke: planner.colour, "stroke-width": 3, "stroke-dasharray": planner.dash || null }, sample);
      html("span", "", name, planner.label);
      for (let k = 0; k < 3; k++) html("td", "", row);
      return row;
    }

    // A box that shows a planner, or hides it; those that are not ours have theirs below the table until they are wanted.
    tick(planner) {
      const check = html("input");
      check.type = "checkbox";
      check.checked = !this.hidden.has(planner.name);
      check.setAttribute("aria-label", `show ${planner.label}`);
      check.addEventListener("change", () => {
        if (check.checked) this.hidden.delete(planner.name); else this.hidden.add(planner.name);
        this.offerOthers();
        if (check.checked) this.ask(null); else this.draw();
      });
      return check;
    }

    offerOthers() {
      clear(this.others);
      const offered = this.setup.planners.filter((planner) => !planner.shown && this.hidden.has(planner.name));
      if (offered.length) html("span", "", this.others, "also:");
      for (const planner of offered) {
        const label = html("label", "", this.others);
        label.appendChild(this.tick(planner)).setAttribute("aria-label", `also show ${planner.label}`);
        html("span", "", label, planner.label);
      }
      for (const [k, planner] of this.setup.planners.entries()) {
        const box = this.body.children[k] && this.body.children[k].querySelector("input");
        if (box) box.checked = !this.hidden.has(planner.name);
      }
    }

    tellLatency() {
      const median = this.asking.median;
      this.latency.textContent = median === null ? "" : `answers in ${median.toFixed(0)} ms (median)`;
    }

    driving(done, of) {
      this.progress.hidden = false;
      this.progress.max = of;
      this.progress.value = done;
    }

    idle() {
      this.progress.hidden = this.stop.hidden = true;
      this.go.disabled = false;
    }

    driven(drive) {
      this.idle();
      this.paths.hidden = true;
      this.loop.hidden = this.back.hidden = false;
      this.drive.load(drive);
      if (!window.matchMedia("(prefers-reduced-motion: reduce)").matches) this.drive.transport.play();
    }

    showPaths() {
      this.drive.transport.pause();
      this.loop.hidden = this.back.hidden = true;
      this.paths.hidden = false;
    }

    png() {
      const strip = (one) => ({ svg: one.svg, caption: one.title.textContent });
      const name = `${this.title.textContent.replace(/[^\w.-]+/g, "-") || "scene"}.png`;
      if (!this.loop.hidden) {
        window.mcdas.savePng(name, this.title.textContent, this.drive.words.textContent, [], [[{ svg: this.drive.bird.svg }], this.drive.strips.map(strip)]);
        return;
      }
      const legend = this.shown().map((plan) => [`${plan.label}: ${plan.doing}, ${plan.passed ? `passed${plan.end_known ? "" : ", end not looked at"}` : "failed"}`, plan.colour, plan.dash]);
      window.mcdas.savePng(name, this.title.textContent, this.words.textContent, legend, [
        [{ svg: this.outlook.bird.svg }],
        [{ svg: this.times.svg, caption: this.times.caption }],
        this.outlook.strips.map(strip),
      ]);
    }
  }

  window.mcdas.SandwichTab = SandwichTab;
})();
