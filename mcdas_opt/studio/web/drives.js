// Closed loops side by side, under one clock.
(function () {
  "use strict";
  const { html, clear, shape, Drive, Transport } = window.mcdas;

  class Drives {
    constructor(parent, look) {
      this.look = look;
      this.transport = new Transport(parent, (time) => { for (const drive of this.all) drive.show(Math.min(time, drive.drive.duration)); });
      this.grid = html("div", "mcdas-drives", parent);
      this.all = [];
    }

    clear() {
      this.transport.pause();
      this.all = [];
      clear(this.grid);
    }

    // planner: its label, colour and dashes
    add(planner, document) {
      const box = html("section", "mcdas-drive", this.grid), head = html("h3", "", box);
      const sample = shape("svg", { width: 34, height: 8, "aria-hidden": "true" }, head);
      shape("path", { d: "M0 4H34", stroke: planner.colour, "stroke-width": 3, "stroke-dasharray": planner.dash || null }, sample);
      html("span", "", head, planner.label);
      const drive = new Drive(box, this.look, this.transport);
      drive.planner = planner;
      drive.load(document);
      this.all.push(drive);
      this.grid.classList.toggle("many", this.all.length > 1);
      this.transport.load(Math.max(...this.all.map((one) => one.drive.duration)));
    }

    rows() {
      return this.all.flatMap((drive) => [
        [{ svg: drive.bird.svg, caption: `${drive.planner.label}: ${drive.words.textContent}` }],
        drive.strips.map((one) => ({ svg: one.svg, caption: one.title.textContent })),
      ]);
    }
  }

  window.mcdas.Drives = Drives;
})();
