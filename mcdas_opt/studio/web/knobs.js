// Sliders in groups. Every turn tells the new value and when it was turned.
(function () {
  "use strict";
  const { html } = window.mcdas;

  class Knobs {
    constructor(parent, knobs, tell) {
      this.rows = {};
      const groups = {};
      for (const knob of knobs) {
        if (!groups[knob.group]) {
          groups[knob.group] = html("fieldset", "", parent);
          html("legend", "", groups[knob.group], knob.group);
        }
        const row = html("div", "mcdas-knob", groups[knob.group]);
        html("span", "name", row, knob.label);
        const shown = html("span", "value", row);
        const slider = html("input", "", row);
        Object.assign(slider, { type: "range", min: knob.low, max: knob.high, step: knob.step, name: knob.key });
        slider.setAttribute("aria-label", `${knob.label} [${knob.unit}]`);
        slider.addEventListener("input", () => {
          this.face(knob.key);
          tell(knob.key, Number(slider.value), performance.now());
        });
        this.rows[knob.key] = { knob, slider, shown, row };
      }
    }

    // Where every knob stands; null greys one out.
    put(positions) {
      for (const key in this.rows) {
        const { slider, row } = this.rows[key], value = positions[key];
        slider.disabled = value === null || value === undefined;
        row.classList.toggle("off", slider.disabled);
        row.title = slider.disabled ? "there is nothing of that kind here to move" : "";
        if (!slider.disabled) {
          slider.min = Math.min(this.rows[key].knob.low, value);
          slider.max = Math.max(this.rows[key].knob.high, value);
          slider.value = value;
        }
        this.face(key);
      }
    }

    face(key) {
      const { knob, slider, shown } = this.rows[key];
      const value = Number(slider.value), digits = knob.step < 0.1 ? 2 : knob.step < 1 ? 1 : 0;
      const unit = knob.unit === "-" ? "" : ` ${knob.unit}`;
      const also = { kmh: ` (${(3.6 * value).toFixed(0)} km/h)`, deg: ` (${((180 / Math.PI) * value).toFixed(0)}°)` }[knob.also] || "";
      const text = slider.disabled ? "–" : `${value.toFixed(digits)}${unit}${also}`;
      shown.textContent = text;
      slider.setAttribute("aria-valuetext", text);
    }
  }

  window.mcdas.Knobs = Knobs;
})();
