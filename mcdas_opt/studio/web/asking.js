// One question at a time: while an answer is under way only the newest wish is kept. Times from the user's event to the painted answer.
(function () {
  "use strict";

  class Asking {
    constructor(send, shown) {
      this.send = send;
      this.shown = shown;
      this.wish = null;
      this.busy = false;
      this.token = 0;
      this.latencies = [];
    }

    ask(question, stamp) {
      this.wish = { question, stamp };
      if (!this.busy) this.next();
    }

    next() {
      if (!this.wish) return;
      const { question, stamp } = this.wish;
      this.wish = null;
      this.busy = true;
      this.stamp = stamp;
      this.token += 1;
      this.send({ ...question, token: this.token });
    }

    // The last part of the answer `token` has been put on the page.
    done(token) {
      if (token !== this.token || !this.busy) return;
      const stamp = this.stamp;
      requestAnimationFrame(() => {
        const channel = new MessageChannel(); // its message arrives after the frame has been painted
        channel.port1.onmessage = () => {
          if (stamp !== null && stamp !== undefined) {
            this.latencies.push(performance.now() - stamp);
            if (this.latencies.length > 200) this.latencies.shift();
          }
          this.busy = false;
          this.shown();
          this.next();
        };
        channel.port2.postMessage(null);
      });
    }

    get median() {
      const sorted = this.latencies.slice(-50).sort((a, b) => a - b), n = sorted.length;
      return n ? (n % 2 ? sorted[(n - 1) / 2] : (sorted[n / 2 - 1] + sorted[n / 2]) / 2) : null;
    }
  }

  window.mcdas.Asking = Asking;
})();
