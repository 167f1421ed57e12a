// A drive in closed loop that plays and scrubs: the document of plotting/player.py.
(function () {
  "use strict";
  const { html, at, Bands, Bird, Strip, Transport } = window.mcdas;

  function between(poses, times, time) {
    const k = at(times, time), p = poses[k], q = poses[Math.min(k + 1, poses.length - 1)];
    const gap = times[Math.min(k + 1, times.length - 1)] - times[k];
    const share = gap > 1e-9 ? Math.min(Math.max((time - times[k]) / gap, 0), 1) : 0;
    return p.map((value, i) => value + share * (q[i] - value));
  }

  class Drive {
    // transport: the clock of several drives; by default one of its own
    constructor(parent, look, transport) {
      this.look = look;
      this.head = html("div", "mcdas-head", parent);
      this.badge = html("span", "mcdas-badge", this.head);
      this.words = html("span", "mcdas-words", this.head);
      this.speed = html("span", "mcdas-speed", this.head);
      this.bird = new Bird(parent, look, "the drive from above");
      this.transport = transport || new Transport(parent, (time) => this.show(time));
      const choose = (t) => { this.transport.pause(); this.transport.go(t); };
      this.bands = new Bands(parent, look, choose);
      this.legend = html("div", "mcdas-legend", parent);
      const charts = html("div", "mcdas-strips", parent);
      this.strips = [];
      this.addStrip = () => this.strips.push(new Strip(charts, look, choose));
    }

    load(drive) {
      this.drive = null;
      this.bird.setRoad(drive.road, drive.view);
      while (this.strips.length < drive.charts.length) this.addStrip();
      this.strips.forEach((strip, k) => strip.show(drive.charts[k]));
      this.bands.show(drive.bands, drive.events, drive.duration);
      this.drive = drive;
      this.legend.textContent = "";
      for (const [kind, text] of [["plan", "plan, a dot a second"], ["driven", "driven"], ["track", "track with its 2.5 sigma"]]) {
        const item = html("span", "mcdas-key", this.legend);
        html("i", `mcdas-swatch ${kind}`, item);
        html("span", "", item, text);
      }
      this.transport.load(drive.duration);
    }

    show(time) {
      const drive = this.drive;
      if (!drive) return;
      const k = at(drive.t, time), cycle = drive.cycles[k], over = time >= drive.duration - 1e-6;
      const seen = drive.t[k];
      const struck = new Set(over ? drive.struck : []);
      const moved = (cycle.bodies || []).map((body, i) => {
        const [, , vx, vy] = cycle.tracks[i], [x, y, yaw] = body.pose;
        return { ...body, pose: [x + vx * (time - seen), y + vy * (time - seen), yaw] };
      });
      const bodies = moved.concat([...drive.others, drive.host].map((body) => ({
        ...body, pose: between(body.poses, drive.poses_t, time), struck: struck.has(body.name),
      })));
      this.bird.show({
        camera: between(drive.camera, drive.poses_t, time),
        from: between(drive.host.poses, drive.poses_t, time),
        bodies,
        tracks: cycle.tracks.map(([x, y, vx, vy, ...rest]) => [x + vx * (time - seen), y + vy * (time - seen), ...rest]),
        paths: [{ points: cycle.plan, seconds: cycle.seconds, colour: this.look.plan }],
        trail: drive.host.poses.slice(0, at(drive.poses_t, time) + 1),
      });
      this.badge.textContent = cycle.action;
      this.badge.className = `mcdas-badge ${cycle.sound ? cycle.status : "failed"}`;
      this.words.textContent = over && drive.outcome ? drive.outcome : cycle.words;
      this.words.classList.toggle("bad", over && !drive.safe);
      const v = between(drive.speed.map((q) => [q]), drive.poses_t, time)[0];
      this.speed.textContent = `${v.toFixed(1)} m/s (${(3.6 * v).toFixed(0)} km/h)`;
      for (const strip of this.strips) strip.mark(time);
      this.bands.mark(time);
    }
  }

  window.mcdas.Drive = Drive;
})();
