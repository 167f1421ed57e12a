// Drawing on SVG: elements, a camera that looks down on the plane, and pictures that keep their looks when saved.
(function () {
  "use strict";
  const SPACE = "http://www.w3.org/2000/svg";
  const mcdas = (window.mcdas = window.mcdas || {});

  function shape(name, attributes, parent) {
    const made = document.createElementNS(SPACE, name);
    set(made, attributes);
    if (parent) parent.appendChild(made);
    return made;
  }

  function set(element, attributes) {
    for (const key in attributes) {
      const value = attributes[key];
      if (value === null || value === undefined) element.removeAttribute(key);
      else element.setAttribute(key, value);
    }
    return element;
  }

  function html(name, className, parent, text) {
    const made = document.createElement(name);
    if (className) made.className = className;
    if (text !== undefined) made.textContent = text;
    if (parent) parent.appendChild(made);
    return made;
  }

  function clear(element) {
    while (element.firstChild) element.removeChild(element.firstChild);
  }

  function path(points) {
    let text = "";
    for (let k = 0; k < points.length; k++) {
      text += (k ? "L" : "M") + points[k][0].toFixed(1) + " " + points[k][1].toFixed(1);
    }
    return text;
  }

  // Corners of a rectangle centred at (x, y), front left first.
  function corners(x, y, yaw, length, width) {
    const c = Math.cos(yaw), s = Math.sin(yaw), a = length / 2, b = width / 2;
    return [[a, b], [-a, b], [-a, -b], [a, -b]].map(([p, q]) => [x + c * p - s * q, y + s * p + c * q]);
  }

  // Looks down on the plane: the pose (x, y, theta) of the road lies at the origin and points to the right.
  class Camera {
    constructor(view, width) {
      this.view = view;
      this.scale = width / (view.back + view.ahead);
      this.height = this.scale * (view.left - view.right);
      this.at(0, 0, 0);
    }
    at(x, y, theta) {
      this.x = x; this.y = y; this.c = Math.cos(theta); this.s = Math.sin(theta);
    }
    place(point) {
      const dx = point[0] - this.x, dy = point[1] - this.y;
      const along = this.c * dx + this.s * dy, across = -this.s * dx + this.c * dy;
      return [(along + this.view.back) * this.scale, (this.view.left - across) * this.scale];
    }
    // The point of the plane at a place of the picture.
    plane(x, y) {
      const along = x / this.scale - this.view.back, across = this.view.left - y / this.scale;
      return [this.x + this.c * along - this.s * across, this.y + this.s * along + this.c * across];
    }
    // The same as an SVG matrix, for what stands still in the plane.
    get matrix() {
      const k = this.scale, [e, f] = this.place([0, 0]);
      return `matrix(${k * this.c} ${k * this.s} ${k * this.s} ${-k * this.c} ${e} ${f})`;
    }
  }

  // Calls `draw(width)` now and whenever the element's width changes.
  function fitted(element, draw) {
    let last = 0;
    const look = () => {
      const width = element.clientWidth;
      if (width > 0 && Math.abs(width - last) >= 1) { last = width; draw(width); }
    };
    new ResizeObserver(look).observe(element);
    look();
  }

  function at(times, time) {
    let low = 0, high = times.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= time + 1e-9) low = middle; else high = middle - 1;
    }
    return low;
  }

  Object.assign(mcdas, { shape, set, html, clear, path, corners, Camera, fitted, at });
})();
