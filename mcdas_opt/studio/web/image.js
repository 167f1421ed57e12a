// The view as one PNG: every picture that is visible, stacked, with its caption.
(function () {
  "use strict";

  function drawn(svg) {
    const copy = svg.cloneNode(true);
    copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
    copy.setAttribute("font-family", "DejaVu Sans, Verdana, sans-serif");
    const image = new Image();
    const done = new Promise((resolve, reject) => { image.onload = () => resolve(image); image.onerror = reject; });
    image.src = "data:image/svg+xml;charset=utf-8," + encodeURIComponent(new XMLSerializer().serializeToString(copy));
    return done;
  }

  // rows: lists of svg elements that stand side by side; lines: [text, colour, dash] of the legend
  async function picture(heading, words, legend, rows) {
    const width = Math.max(...rows.map((row) => row.reduce((sum, one) => sum + one.svg.clientWidth + 14, -14)), 300);
    const heights = rows.map((row) => Math.max(...row.map((one) => one.svg.clientHeight + (one.caption ? 18 : 0))) + 12);
    const scale = 2, top = 62 + 20 * Math.ceil(legend.length / 3);
    const canvas = document.createElement("canvas");
    canvas.width = scale * (width + 24);
    canvas.height = scale * (top + heights.reduce((a, b) => a + b, 0) + 8);
    const pen = canvas.getContext("2d");
    pen.scale(scale, scale);
    pen.fillStyle = "#fff";
    pen.fillRect(0, 0, canvas.width, canvas.height);
    pen.fillStyle = "#1a1a1a";
    const font = '"DejaVu Sans", Verdana, sans-serif';
    pen.font = `600 17px ${font}`;
    pen.fillText(heading, 12, 26, width);
    pen.font = `13px ${font}`;
    pen.fillText(words, 12, 46, width);
    legend.forEach(([text, colour, dash], k) => {
      const x = 12 + (k % 3) * (width / 3), y = 66 + 20 * Math.floor(k / 3);
      pen.strokeStyle = colour;
      pen.lineWidth = 3;
      pen.setLineDash(dash ? dash.split(" ").map(Number) : []);
      pen.beginPath(); pen.moveTo(x, y - 4); pen.lineTo(x + 34, y - 4); pen.stroke();
      pen.setLineDash([]);
      pen.fillText(text, x + 42, y, width / 3 - 50);
    });
    let y = top + 8;
    for (let k = 0; k < rows.length; k++) {
      let x = 12;
      for (const one of rows[k]) {
        if (one.caption) { pen.font = `600 12px ${font}`; pen.fillText(one.caption, x, y + 11); }
        pen.drawImage(await drawn(one.svg), x, y + (one.caption ? 16 : 0), one.svg.clientWidth, one.svg.clientHeight);
        x += one.svg.clientWidth + 14;
      }
      y += heights[k];
    }
    return canvas;
  }

  async function save(name, heading, words, legend, rows) {
    const canvas = await picture(heading, words, legend, rows);
    const blob = await new Promise((resolve) => canvas.toBlob(resolve, "image/png"));
    const link = document.createElement("a");
    link.href = URL.createObjectURL(blob);
    link.download = name;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  window.mcdas.savePng = save;
})();
