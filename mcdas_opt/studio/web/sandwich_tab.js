// The tab of the sandwich: sliders, the road from above with every planner's path, times to react, charts, words; and the closed loop.
(function () {
  "use strict";
  const { html, clear, shape, candidateLines, fillFiles, Outlook, Drives, Form, Knobs, SceneEditor, TimesToReact, Asking } = window.mcdas;

  const NOTHING_S = 0.15; // an answer within that needs no sign that one is waited for

  class SandwichTab {
    // setup: { knobs, planners, files, form, upload }; emit(name, payload) tells the server
    constructor(root, look, setup, emit) {
      Object.assign(this, { root, look, setup, emit });
      this.actions = []; // edits that the server has not been told yet
      this.turns = 0;
      this.plans = {};
      this.link = new URLSearchParams(window.location.hash.slice(1));
      this.hidden = new Set(setup.planners.filter((planner) => !planner.shown).map((planner) => planner.name));
      this.looks = Object.fromEntries(setup.planners.map((planner) => [planner.name, planner]));
      this.side = html("div", "mcdas-side", root);
      this.main = html("div", "mcdas-main", root);
      this.fillSide();
      this.fillMain();
      this.busy("opening");
      this.wanted = this.link.get("planners") || "";
      this.tick(this.wanted);
      this.offerOthers();
      this.asking = new Asking((question) => this.send(question), () => { this.busy(""); this.tellLatency(); });
      window.addEventListener("hashchange", () => this.linked());
      document.addEventListener("keydown", (event) => this.key(event));
      window.mcdas.studio = this;
    }

    // What is to be shown first.
    get first() { return { link: this.link.get("scene") || "" }; }

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
      this.saveToml = html("button", "", row, "Download");
      this.savePng = html("button", "", row, "PNG");
      for (const button of [this.saveToml, this.savePng]) button.type = "button";
      this.saveToml.title = "download this scene as it stands";
      this.savePng.title = "download what is shown as a picture";
      this.saveToml.addEventListener("click", () => this.emit("download", this.edits));
      this.savePng.addEventListener("click", () => this.png());
      this.saving = html("form", "mcdas-row", open);
      this.saveName = html("input", "mcdas-name", this.saving);
      this.saveName.setAttribute("aria-label", "name of the scene in the folder");
      this.saveHere = html("button", "", this.saving, "Save");
      this.saveHere.title = "write this scene into the folder that the studio was started with";
      this.saving.addEventListener("submit", (event) => { event.preventDefault(); this.save(false); });
      this.exists = html("div", "mcdas-exists", open);
      this.exists.hidden = true;
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
      this.knobs = new Knobs(this.side, this.setup.knobs, (key, value, stamp) => this.change({ [key]: value }, `${key} ${this.turns}`, stamp));
      for (const key in this.knobs.rows) this.knobs.rows[key].slider.addEventListener("change", () => { this.turns += 1; });
      this.keys = html("fieldset", "", this.side);
      html("legend", "", this.keys, "everything in the scene");
      this.form = new Form(this.keys, this.setup.form, (changes) => this.change(changes), () => this.editor.fresh());
    }

    fillMain() {
      this.problem = html("div", "mcdas-problem", this.main);
      this.problem.setAttribute("role", "alert");
      this.problem.hidden = true;
      const bar = html("div", "mcdas-row mcdas-bar", this.main);
      this.title = html("h2", "", bar);
      this.latency = html("span", "mcdas-latency", bar);
      this.waiting = html("span", "mcdas-busy", bar);
      this.waiting.setAttribute("role", "status");
      this.driver = html("select", "", bar);
      this.driver.setAttribute("aria-label", "who drives the closed loop");
      this.fillDrivers();
      this.go = html("button", "mcdas-strong", bar, "▶ Drive the closed loop");
      this.back = html("button", "", bar, "Back to the paths");
      this.stop = html("button", "", bar, "Stop");
      for (const button of [this.go, this.back, this.stop]) button.type = "button";
      this.stop.hidden = this.back.hidden = true;
      this.go.addEventListener("click", () => {
        const planners = this.driver.value ? [this.driver.value] : this.told().map((planner) => planner.name);
        if (!planners.length) { this.complain("tick a planner, or choose one to drive"); return; }
        this.stop.hidden = false;
        this.go.disabled = true;
        this.busy("driving");
        this.emit("drive", { planners, ...this.edits });
      });
      this.back.addEventListener("click", () => this.showPaths());
      this.stop.addEventListener("click", () => this.emit("stop", {}));
      this.progress = html("progress", "", bar);
      this.progress.hidden = true;

      this.paths = html("div", "mcdas-paths", this.main);
      this.stage = html("div", "mcdas-stage", this.paths);
      this.fillTools(html("div", "mcdas-row mcdas-tools", this.stage));
      const head = html("div", "mcdas-head", this.paths);
      this.badge = html("span", "mcdas-badge", head);
      this.words = html("span", "mcdas-words", head);
      this.words.setAttribute("aria-live", "polite");
      this.outlook = new Outlook(this.stage, this.look);
      this.editor = new SceneEditor(this.outlook.bird, this.look, {
        change: (changes, stroke) => this.change(changes, stroke),
        selected: (key) => this.selected(key),
      });
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
      this.drives = new Drives(this.loop, this.look);
      this.drives.transport.listen(() => !this.loop.hidden && this.loop.offsetParent !== null);
    }

    fillDrivers() {
      const before = this.driver.value;
      clear(this.driver);
      for (const planner of this.setup.planners) html("option", "", this.driver, `${planner.label} drives`).value = planner.name;
      html("option", "", this.driver, "all that are ticked, side by side").value = "";
      this.driver.value = before || "mpc";
    }

    // Above the picture: what is done to the scene.
    fillTools(row) {
      const button = (text, title, act) => {
        const made = html("button", "", row, text);
        made.type = "button";
        made.title = title;
        made.setAttribute("aria-label", title);
        made.addEventListener("click", act);
        return made;
      };
      this.undo = button("↶", "undo (Ctrl Z)", () => this.act({ do: "undo" }));
      this.redo = button("↷", "redo (Ctrl Shift Z)", () => this.act({ do: "redo" }));
      this.add = button("+ Car", "add a car (or double-click the road)", () => this.editor.add());
      this.away = button("Remove", "remove the chosen car (Delete)", () => this.editor.remove());
      this.share = button("Link", "copy a link to this scene", () => this.copy());
      this.chosen = html("label", "mcdas-chosen", row);
      this.chosenName = html("span", "", this.chosen);
      this.chosenSpeed = html("input", "", this.chosen);
      Object.assign(this.chosenSpeed, { type: "number", step: "any", min: 0 });
      this.chosenSpeed.setAttribute("aria-label", "speed of the chosen car [m/s]");
      html("span", "", this.chosen, "m/s");
      this.chosenSpeed.addEventListener("change", () => this.change({ [`${this.editor.selected}.speed_mps`]: Number(this.chosenSpeed.value) }));
      this.chosen.hidden = true;
      this.tools = row;
    }

    selected(key) {
      if (key && !this.form.box.contains(document.activeElement)) this.form.reveal(key);
      this.faceChosen();
    }

    faceChosen() {
      const key = this.editor.selected, handle = key && this.editor.handle(key);
      this.away.disabled = !handle || key === "host";
      this.chosen.hidden = !handle || handle.fixed;
      if (this.chosen.hidden) return;
      this.chosenName.textContent = handle.name;
      if (document.activeElement !== this.chosenSpeed) this.chosenSpeed.value = Number(this.form.at(`${key}.speed_mps`).toFixed(2));
    }

    // Edits of the same stroke are one step of the history. What is empty asks only.
    change(changes, stroke, stamp) {
      if (Object.keys(changes).length) this.faulted = false;
      const last = this.actions[this.actions.length - 1];
      if (last && stroke !== undefined && last.stroke === stroke) Object.assign(last.changes, changes);
      else if (Object.keys(changes).length) this.actions.push({ do: "edit", changes, stroke });
      this.showPaths();
      this.ask(stamp === undefined ? performance.now() : stamp);
    }

    act(action) {
      this.faulted = false;
      this.actions.push(action);
      this.showPaths();
      this.ask(performance.now());
    }

    key(event) {
      const on = document.activeElement, typing = on && (on.type === "number" || on.type === "text");
      if (!(event.ctrlKey || event.metaKey) || typing || !this.root.offsetParent) return;
      const letter = event.key.toLowerCase();
      if (letter === "z" && !event.shiftKey) this.act({ do: "undo" });
      else if (letter === "y" || letter === "z") this.act({ do: "redo" });
      else return;
      event.preventDefault();
    }

    send(question) {
      clearTimeout(this.late);
      this.late = setTimeout(() => { if (this.asking.busy) this.busy("planning"); }, 1000 * NOTHING_S);
      this.emit("ask", { ...question, ...this.edits });
    }

    // What the server has not been told yet; it is told with whatever is asked for next.
    get edits() { return { actions: this.actions.splice(0) }; }

    // A sign that something is waited for; none for an empty word.
    busy(word) {
      if (!word && !this.stop.hidden) word = "driving";
      this.waiting.textContent = word && `${word} …`;
      this.root.setAttribute("aria-busy", String(Boolean(word)));
    }

    open(what) {
      this.faulted = false;
      this.actions = [];
      this.busy("opening");
      this.emit("open", what);
    }

    // The address holds the scene and who is ticked.
    linked() {
      const now = new URLSearchParams(window.location.hash.slice(1));
      if (now.get("scene") && now.get("scene") !== this.link.get("scene")) this.open({ kind: "link", name: now.get("scene") });
      this.link = now;
      this.tick(now.get("planners") || "");
      this.offerOthers();
    }

    // Ticks the planners that are named, with commas, and no other; nothing for no name.
    tick(names) {
      const ticked = names.split(",").filter(Boolean);
      if (ticked.length) this.hidden = new Set(this.setup.planners.map((planner) => planner.name).filter((name) => !ticked.includes(name)));
    }

    address() {
      if (!this.state || !this.state.link) { window.history.replaceState(null, "", window.location.pathname); return; }
      this.link = new URLSearchParams({ planners: this.told().map((planner) => planner.name).join(","), scene: this.state.link });
      window.history.replaceState(null, "", `#${this.link}`);
    }

    async copy() {
      try {
        await navigator.clipboard.writeText(window.location.href);
        this.share.textContent = "Copied";
        setTimeout(() => { this.share.textContent = "Link"; }, 1500);
      } catch (error) {
        this.complain("the clipboard is closed to this page: copy its address instead");
      }
    }

    save(replace) {
      this.exists.hidden = true;
      this.emit("save", { name: this.saveName.value, replace, ...this.edits });
    }

    there(text) {
      clear(this.exists);
      html("span", "", this.exists, text);
      const yes = html("button", "", this.exists, "Replace it"), no = html("button", "", this.exists, "Cancel");
      yes.type = no.type = "button";
      yes.addEventListener("click", () => this.save(true));
      no.addEventListener("click", () => { this.exists.hidden = true; });
      this.exists.hidden = false;
      no.focus();
    }

    async upload(file) {
      this.busy("opening");
      if (file.size > this.setup.upload.most) { this.complain(`${file.name}: larger than ${this.setup.upload.most} bytes`); return; }
      try {
        const url = `${this.setup.upload.url}&name=${encodeURIComponent(file.name)}`;
        const answer = await fetch(url, { method: "POST", body: file });
        const said = await answer.json();
        if (said.error) this.complain(said.error);
        else { this.actions = []; this.emit("uploaded", { name: said.name }); }
      } catch (error) {
        this.complain(`${file.name}: could not be sent`);
      }
    }

    complain(text) {
      this.problem.textContent = text;
      this.problem.hidden = !text;
      if (text) { this.faulted = true; this.busy(""); }
    }

    ask(stamp) {
      const question = { planners: this.told().map((planner) => planner.name) };
      if (!this.moment.hidden) question.moment = Number(this.momentSlider.value);
      this.asking.ask(question, stamp);
    }

    // What the server says, a part at a time.
    hear(part) {
      if (part.part === "opened") this.opened(part);
      else if (part.part === "state") this.stated(part);
      else if (part.part === "planners") this.offer(part.planners);
      else if (part.part === "exists") this.there(part.text);
      else if (part.part === "saved") this.saved(part);
      else if (part.part === "picture") this.pictured(part);
      else if (part.part === "plan") { this.plans[part.planner] = { ...this.looks[part.planner], ...part }; this.soon(); }
      else if (part.part === "escapes") this.times.show(part.escapes);
      else if (part.part === "done") {
        if (!this.faulted) this.complain("");
        this.draw();
        this.editor.answered();
        this.asking.done(part.token);
      }
      else if (part.part === "waiting") this.busy(part.text);
      else if (part.part === "progress") this.driving(part.done, part.of);
      else if (part.part === "drive") this.driven(part);
      else if (part.part === "stopped") this.idle();
      else if (part.part === "problem") { this.complain(part.text); this.idle(); }
    }

    opened(part) {
      this.complain("");
      this.busy("");
      this.title.textContent = part.name;
      this.saveName.value = part.name;
      this.exists.hidden = true;
      this.plans = {};
      if (this.editor.selected) this.editor.select(null);
      this.outlook.lookAhead(0);
      const log = Boolean(part.moments);
      this.moment.hidden = !log;
      this.note.textContent = part.note || "";
      this.go.hidden = this.driver.hidden = this.tools.hidden = this.saving.hidden = this.keys.hidden = log;
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

    // The scene as the server has it.
    stated(part) {
      const newer = this.asking.wish || this.actions.length, held = document.activeElement;
      this.state = part;
      this.title.textContent = part.name;
      this.undo.disabled = !part.undo;
      this.redo.disabled = !part.redo;
      const stand = { ...part.positions };
      for (const key in this.knobs.rows) {
        const { slider } = this.knobs.rows[key];
        if (newer && slider === held && !slider.disabled) stand[key] = Number(slider.value); // it has been turned on since
      }
      this.knobs.put(stand);
      if (part.scene) this.form.put(part.scene);
      this.editor.show(part);
      this.faceChosen();
      this.address();
    }

    saved(part) {
      clear(this.files);
      fillFiles(this.files, part.files);
      const here = [...this.files.options].find((one) => one.dataset.kind === "scene" && one.dataset.name === part.name);
      if (here) here.selected = true;
      this.saveHere.textContent = "Saved";
      setTimeout(() => { this.saveHere.textContent = "Save"; }, 1500);
      this.ask(null);
    }

    // Those that can be built here; a planner is ticked as before.
    offer(planners) {
      const known = new Set(this.setup.planners.map((planner) => planner.name));
      for (const planner of planners) if (!planner.shown && !known.has(planner.name)) this.hidden.add(planner.name);
      this.setup.planners = planners;
      this.looks = Object.fromEntries(planners.map((planner) => [planner.name, planner]));
      clear(this.body);
      this.fillDrivers();
      this.tick(this.wanted);
      this.wanted = "";
      this.offerOthers();
      this.ask(null);
    }

    pictured(part) {
      if (this.editor.held && this.outlook.picture) part.view = this.outlook.picture.view; // the road does not move under the pointer
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
      this.editor.active = Boolean(this.state && this.state.handles);
      this.outlook.draw(this.shown());
      this.tell();
    }

    told() { return this.setup.planners.filter((planner) => !this.hidden.has(planner.name)); }

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
      html("td", "", row).appendChild(this.box(planner));
      const name = html("th", "", row);
      name.scope = "row";
      const sample = shape("svg", { width: 34, height: 8, "aria-hidden": "true" }, name);
      shape("path", { d: "M0 4H34", stroke: planner.colour, "stroke-width": 3, "stroke-dasharray": planner.dash || null }, sample);
      html("span", "", name, planner.label);
      for (let k = 0; k < 3; k++) html("td", "", row);
      return row;
    }

    // A box that shows a planner, or hides it; those that are not ours have theirs below the table until they are wanted.
    box(planner) {
      const check = html("input");
      check.type = "checkbox";
      check.checked = !this.hidden.has(planner.name);
      check.setAttribute("aria-label", `show ${planner.label}`);
      check.addEventListener("change", () => {
        this.wanted = "";
        if (check.checked) this.hidden.delete(planner.name); else this.hidden.add(planner.name);
        this.offerOthers();
        this.address();
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
        label.appendChild(this.box(planner)).setAttribute("aria-label", `also show ${planner.label}`);
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
      this.busy(this.asking.busy ? "planning" : "");
      if (!this.loop.hidden && this.came) this.play(); // all have come
      this.came = false;
    }

    play() {
      if (!window.matchMedia("(prefers-reduced-motion: reduce)").matches) this.drives.transport.play();
    }

    driven(part) {
      if (part.first) this.drives.clear();
      this.came = true;
      this.paths.hidden = true;
      this.loop.hidden = this.back.hidden = false;
      this.drives.add(this.looks[part.planner], part.drive);
    }

    showPaths() {
      this.drives.transport.pause();
      this.loop.hidden = this.back.hidden = true;
      this.paths.hidden = false;
    }

    png() {
      const strip = (one) => ({ svg: one.svg, caption: one.title.textContent });
      const name = `${this.title.textContent.replace(/[^\w.-]+/g, "-") || "scene"}.png`;
      if (!this.loop.hidden) {
        window.mcdas.savePng(name, this.title.textContent, "closed loop", [], this.drives.rows());
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
