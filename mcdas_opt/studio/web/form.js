// A form for every key of a scene, made from what the server says of the keys. A changed field tells its key and its new value.
(function () {
  "use strict";
  const { html, clear } = window.mcdas;
  const NAMES = { neighbour: "cars", lane: "single lanes", motion: "manoeuvres" };
  const FRESH = { motion: { start_s: 1, acceleration_mps2: -3 }, lane: { lane: 1 } };

  const shape = (value) => (Array.isArray(value) ? `[${value.map(shape)}]` : value && typeof value === "object" ? `{${Object.values(value).map(shape)}}` : "");

  class Form {
    // tell(changes): keys with new values, null for a key that is taken away; fresh(): a new car
    constructor(parent, fields, tell, fresh) {
      Object.assign(this, { fields, tell, fresh });
      this.box = html("div", "mcdas-form", parent);
      this.open = new Set();
    }

    put(scene) {
      this.scene = scene;
      const now = shape(scene);
      if (now !== this.shaped) {
        this.shaped = now;
        const held = document.activeElement && document.activeElement.name;
        clear(this.box);
        this.inputs = {};
        const plain = this.fields.filter((field) => !field.fields), tables = this.fields.filter((field) => field.fields);
        for (const field of [...tables.sort((a, b) => (b.key === "neighbour") - (a.key === "neighbour"))]) this.table(this.box, field, field.key, scene[field.key]);
        const drive = this.section(this.box, "scene", "scene");
        for (const field of plain) this.row(drive, field, field.key, scene[field.key]);
        if (held && this.inputs[held]) this.inputs[held].input.focus();
      }
      for (const path in this.inputs) {
        const { input, read } = this.inputs[path];
        if (input !== document.activeElement) read(this.at(path));
      }
    }

    at(path) {
      return path.split(/[.[\]]+/).filter(Boolean).reduce((here, part) => (here === null || here === undefined ? here : here[part]), this.scene);
    }

    section(parent, path, title) {
      const made = html("details", "", parent);
      made.dataset.path = path;
      made.open = this.open.has(path);
      made.addEventListener("toggle", () => { if (made.open) this.open.add(path); else this.open.delete(path); });
      html("summary", "", made, title);
      return made;
    }

    reveal(path) {
      for (let k = path.length; k > 0; k = Math.max(path.lastIndexOf("[", k - 1), path.lastIndexOf(".", k - 1))) {
        const made = [...this.box.querySelectorAll("details")].find((one) => one.dataset.path === path.slice(0, k));
        if (made) made.open = true;
      }
    }

    table(parent, field, path, value) {
      const title = NAMES[field.key] || field.label;
      const box = this.section(parent, path, field.kind === "tables" && value ? `${title} (${value.length})` : title);
      if (field.kind === "table") {
        if (value) for (const inner of field.fields) this.inner(box, inner, `${path}.${inner.key}`, value[inner.key]);
        if (!field.needed && value === null) this.button(box, `Set a ${field.label}`, () => ({ [path]: {} }));
        if (value && path === "destination") this.button(box, "Take it away", () => ({ [path]: null }));
        return;
      }
      const many = value || [];
      many.forEach((one, k) => {
        const here = `${path}[${k}]`, item = this.section(box, here, one.name || `${field.label} ${one.lane ?? k + 1}`);
        for (const inner of field.fields) this.inner(item, inner, `${here}.${inner.key}`, one[inner.key]);
        this.button(item, "Remove", () => ({ [here]: null }));
      });
      this.button(box, "Add", () => ({ [`${path}[${many.length}]`]: field.key === "neighbour" ? this.fresh() : FRESH[field.key] || {} }));
    }

    inner(parent, field, path, value) {
      if (field.fields) this.table(parent, field, path, value);
      else this.row(parent, field, path, value);
    }

    button(parent, text, changes) {
      const made = html("button", "", parent, text);
      made.type = "button";
      made.addEventListener("click", () => this.tell(changes()));
    }

    row(parent, field, path, value) {
      const row = html("label", `mcdas-field ${field.kind}`, parent);
      html("span", "name", row, field.unit ? `${field.label} [${field.unit}]` : field.label);
      row.title = field.about;
      if (field.kind === "pairs") { this.pairs(html("span", "mcdas-pairs", row), field, path, value); return; }
      const input = html(field.kind === "word" ? "select" : "input", "", row);
      input.name = path;
      input.setAttribute("aria-label", `${path}: ${field.about}`);
      let read = (now) => { input.value = now === null || now === undefined ? "" : field.kind === "pair" ? now.join(" to ") : now; };
      let said = () => (input.value === "" ? null : input.value);
      if (field.kind === "word") {
        for (const word of [...new Set([...field.words, ...(value ? [value] : [])])]) html("option", "", input, word).value = word;
      } else if (field.kind === "flag") {
        input.type = "checkbox";
        read = (now) => { input.checked = Boolean(now); };
        said = () => input.checked;
      } else if (field.kind === "pair") {
        input.placeholder = "from to";
        said = () => (input.value.trim() ? numbers(input.value) : null);
      } else if (field.kind !== "text") {
        Object.assign(input, { type: "number", step: field.kind === "whole" ? 1 : "any" });
        for (const [bound, limit] of [["min", field.low], ["max", field.high]]) if (limit !== null && limit !== undefined) input[bound] = limit;
        said = () => (input.value === "" ? null : Number(input.value));
      }
      input.addEventListener("change", () => this.tell({ [path]: said() }));
      this.inputs[path] = { input, read };
      read(value);
    }

    // Knots: a row of two numbers each. A road's first knot stays: it says what the road is.
    pairs(box, field, path, value) {
      const pairs = Array.isArray(value) ? value : value === null || value === undefined ? [] : [[0, value]];
      const put = (all) => this.tell({ [path]: all.length ? all : null });
      pairs.forEach((pair, k) => {
        const row = html("span", "mcdas-pair", box);
        pair.forEach((number, j) => {
          const input = html("input", "", row);
          Object.assign(input, { type: "number", step: "any", value: number, name: `${path}[${k}][${j}]` });
          input.setAttribute("aria-label", `${path}[${k}]: ${field.about}`);
          input.addEventListener("change", () => put(pairs.map((one, m) => (m === k ? one.map((q, n) => (n === j ? Number(input.value) : q)) : one))));
          if (Array.isArray(value)) this.inputs[input.name] = { input, read: (now) => { input.value = now; } };
        });
        const away = html("button", "", row, "×");
        away.type = "button";
        away.setAttribute("aria-label", `remove ${path}[${k}]`);
        away.addEventListener("click", (event) => { event.preventDefault(); put(pairs.filter((_, m) => m !== k)); });
      });
      const last = pairs[pairs.length - 1];
      const add = html("button", "", box, "+ knot");
      add.type = "button";
      add.addEventListener("click", (event) => { event.preventDefault(); put([...pairs, last ? [last[0] + 50, last[1]] : [0, 0]]); });
    }
  }

  const numbers = (text) => (text.match(/-?\d+(\.\d+)?(e-?\d+)?/gi) || []).map(Number);

  window.mcdas.Form = Form;
})();
