// What plans look ahead to: the road from above with their paths, where everybody would be, and charts with limits.
// The documents are those of plotting/outlook.py.
(function () {
  "use strict";
  const { html, Bird, Strip, at } = window.mcdas;
  const NOW = 0.025;

  class Outlook {
    constructor(parent, look) {
      this.look = look;
      this.plans = [];
      this.time = 0;
      this.bird = new Bird(parent, look, "the road from above with the planners' paths");
      const ahead = html("div", "mcdas-ahead", parent);
      html("span", "", ahead, "look ahead");
      this.scrub = html("input", "", ahead);
      Object.assign(this.scrub, { type: "range", min: 0, max: 4, step: 0.05, value: 0 });
      this.scrub.setAttribute("aria-label", "look ahead in time, as predicted");
      this.scrubShown = html("span", "mcdas-clock", ahead);
      this.scrub.addEventListener("input", () => this.lookAhead(Number(this.scrub.value)));
    }

    // Room for the charts, wherever the page wants them.
    chartsInto(parent) {
      const strips = html("div", "mcdas-strips", parent);
      this.strips = [0, 1, 2, 3].map(() => new Strip(strips, this.look, (t) => this.lookAhead(t)));
    }

    setPicture(picture) {
      const before = this.picture;
      this.picture = picture;
      if (!before || JSON.stringify([before.road, before.view]) !== JSON.stringify([picture.road, picture.view])) {
        this.bird.setRoad(picture.road, picture.view);
      }
    }

    draw(plans) {
      this.plans = plans;
      this.duration = Math.max(1, ...plans.map((plan) => plan.t[plan.t.length - 1] || 0));
      this.scrub.max = this.duration;
      this.time = Math.min(this.time, this.duration);
      this.see();
      this.picture.charts.forEach((chart, k) => this.strips[k].show({
        ...chart, duration: this.duration,
        lines: plans.map((plan) => ({ t: plan.t, v: plan.lines[chart.key], colour: plan.colour, dash: plan.dash })),
      }));
    }

    lookAhead(time) {
      this.time = Math.min(Math.max(time, 0), this.duration || 4);
      this.scrub.value = this.time;
      this.see();
    }

    // Everybody where they are believed to be at the chosen time, and a ghost of the host for every path.
    see() {
      const { picture, plans, time } = this;
      if (!picture) return;
      const k = Math.round(time / picture.every), ahead = time >= NOW;
      const all = picture.bodies.map((body) => ({ ...body, pose: body.poses[Math.min(k, body.poses.length - 1)] }));
      const bodies = all.filter((body) => !body.supposed);
      const ghosts = !ahead ? [] : plans.map((plan) => ({
        ...picture.host, name: "", colour: plan.colour, tinted: true, pose: plan.poses[at(plan.t, time)],
      }));
      if (ahead) ghosts.unshift({ ...picture.host, name: "", colour: this.look.grey });
      if (ahead) ghosts.unshift(...all.filter((body) => body.supposed).map((body) => ({ ...body, tinted: true })));
      this.bird.show({
        camera: picture.cameras[Math.min(k, picture.cameras.length - 1)],
        from: ahead ? null : picture.host.pose,
        bodies: ahead ? bodies : [...bodies, picture.host],
        ghosts: ghosts.filter((ghost) => ghost.pose),
        paths: plans.map((plan) => ({ points: plan.poses, seconds: plan.seconds, colour: plan.colour, dash: plan.dash })),
      });
      this.scrubShown.textContent = ahead ? `in ${time.toFixed(2)} s, as predicted` : "now";
      this.scrub.setAttribute("aria-valuetext", this.scrubShown.textContent);
      for (const strip of this.strips) strip.mark(ahead ? time : null);
    }
  }

  // One plan on a page of its own: { picture, plan }.
  class PlanPage {
    constructor(parent, look) {
      const head = html("div", "mcdas-head", parent);
      this.badge = html("span", "mcdas-badge", head);
      this.words = html("span", "mcdas-words", head);
      this.outlook = new Outlook(parent, look);
      this.outlook.chartsInto(parent);
      this.candidates = html("ul", "mcdas-candidates", parent);
    }

    load({ picture, plan }) {
      this.badge.textContent = plan.doing;
      this.badge.className = `mcdas-badge ${plan.passed ? plan.status : "failed"}`;
      this.words.textContent = `${plan.words}${plan.warning ? "; the driver is warned" : ""}. Why: ${plan.reason}.`;
      this.outlook.setPicture(picture);
      this.outlook.draw([plan]);
      for (const line of window.mcdas.candidateLines(plan)) html("li", "", this.candidates, line);
    }
  }

  // The candidates of a plan, a line each.
  function candidateLines(plan) {
    return plan.candidates.map((c) => `${c.name}: ${c.refusal || `passed: ${c.passed}`}${c.cost === null ? "" : `, cost ${c.cost}`}`);
  }

  Object.assign(window.mcdas, { Outlook, PlanPage, candidateLines });
})();
