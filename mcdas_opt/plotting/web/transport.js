// Play, pause and scrub: a clock that tells its listener the time; keys: space, arrows, Home, End.
(function () {
  "use strict";
  const { html } = window.mcdas;

  class Transport {
    constructor(parent, tell) {
      this.tell = tell;
      this.time = 0; this.duration = 1; this.rate = 1; this.playing = false;
      this.bar = html("div", "mcdas-transport", parent);
      this.button = html("button", "mcdas-play", this.bar);
      this.button.type = "button";
      this.slider = html("input", "", this.bar);
      Object.assign(this.slider, { type: "range", min: 0, step: 0.01, value: 0 });
      this.slider.setAttribute("aria-label", "time");
      this.clock = html("span", "mcdas-clock", this.bar);
      this.speed = html("select", "", this.bar);
      this.speed.setAttribute("aria-label", "playing speed");
      for (const rate of [0.1, 0.25, 0.5, 1, 2, 4]) {
        const option = html("option", "", this.speed, `× ${rate}`);
        option.value = rate;
        option.selected = rate === 1;
      }
      this.button.addEventListener("click", () => this.toggle());
      this.slider.addEventListener("input", () => { this.pause(); this.go(Number(this.slider.value)); });
      this.speed.addEventListener("change", () => { this.rate = Number(this.speed.value); });
      this.face();
    }

    load(duration) {
      this.pause();
      this.duration = duration;
      this.slider.max = duration;
      this.go(0);
    }

    toggle() { if (this.playing) this.pause(); else this.play(); }

    play() {
      if (this.time >= this.duration - 1e-6) this.go(0);
      this.playing = true;
      this.face();
      let before = performance.now();
      const turn = (now) => {
        if (!this.playing) return;
        const next = this.time + (this.rate * (now - before)) / 1000;
        before = now;
        if (next >= this.duration) { this.go(this.duration); this.pause(); return; }
        this.go(next);
        requestAnimationFrame(turn);
      };
      requestAnimationFrame(turn);
    }

    pause() { this.playing = false; this.face(); }

    go(time) {
      this.time = Math.min(Math.max(time, 0), this.duration);
      this.slider.value = this.time;
      this.clock.textContent = `${this.time.toFixed(2)} s of ${this.duration.toFixed(2)} s`;
      this.slider.setAttribute("aria-valuetext", this.clock.textContent);
      this.tell(this.time);
    }

    face() {
      this.button.textContent = this.playing ? "❚❚ Pause" : "▶ Play";
      this.button.setAttribute("aria-pressed", String(this.playing));
    }

    // Keys for the whole page, but not while another control than the slider has the keyboard.
    listen(active) {
      document.addEventListener("keydown", (event) => {
        const on = document.activeElement, busy = on && on !== this.slider && /^(INPUT|SELECT|BUTTON|TEXTAREA)$/.test(on.tagName);
        if (busy || event.altKey || event.ctrlKey || event.metaKey || !active()) return;
        const step = event.shiftKey ? 1 : 0.1;
        if (event.key === " ") this.toggle();
        else if (event.key === "ArrowRight") { this.pause(); this.go(this.time + step); }
        else if (event.key === "ArrowLeft") { this.pause(); this.go(this.time - step); }
        else if (event.key === "Home") this.go(0);
        else if (event.key === "End") this.go(this.duration);
        else return;
        event.preventDefault();
      });
    }
  }

  window.mcdas.Transport = Transport;
})();
