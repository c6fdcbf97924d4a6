"use strict";
(() => {
  for (const box of document.querySelectorAll(".switches input")) {
    const apply = () => document.getElementById("gallery").classList.toggle("no-" + box.name, !box.checked);
    box.addEventListener("change", () => { apply(); draw(); });
    apply();
  }

  const canvas = document.getElementById("cloud");
  const select = document.getElementById("cloud-frame");
  if (!canvas || !select) return;
  const context = canvas.getContext("2d");
  const view = { yaw: 0, pitch: 0.45, distance: 40 };
  const LOOKED_AT = [12, 0, -1];
  const FOCAL = 1.1;
  const EDGES = [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7], [0, 5], [1, 4]];
  let cloud = null;
  let waiting = false;

  function load(id) {
    const data = JSON.parse(document.getElementById("cloud-" + id).textContent);
    const bytes = Uint8Array.from(atob(data.points), (letter) => letter.charCodeAt(0));
    const count = bytes.length / 7;
    const steps = new DataView(bytes.buffer);
    const xyz = new Float32Array(3 * count);
    for (let i = 0; i < 3 * count; i++) xyz[i] = steps.getInt16(2 * i, true) / data.steps;
    cloud = { xyz, count, boxes: data.boxes, colors: colorsOf(xyz, bytes.subarray(6 * count)) };
    draw();
  }

  // Height as hue from the road's blue to yellow 3 m above it; what returns more light is lighter.
  function colorsOf(xyz, intensity) {
    const colors = new Uint32Array(intensity.length);
    for (let i = 0; i < intensity.length; i++) {
      const share = Math.min(1, Math.max(0, (xyz[3 * i + 2] + 2) / 4));
      const light = 0.7 + 0.3 * Math.sqrt(intensity[i] / 255);
      const red = 255 * light * Math.min(1, 0.25 + 1.5 * share * share);
      const green = 255 * light * (0.45 + 0.45 * share);
      const blue = 255 * light * (1 - 0.75 * share);
      colors[i] = (255 << 24) | (blue << 16) | (green << 8) | red;
    }
    return colors;
  }

  // The camera circles the place looked at; x ahead, y left, z up. Returns [right, down, depth].
  function toView(x, y, z, turn) {
    const dx = x - LOOKED_AT[0], dy = y - LOOKED_AT[1], dz = z - LOOKED_AT[2];
    const ahead = turn.cosYaw * dx + turn.sinYaw * dy;
    const left = turn.cosYaw * dy - turn.sinYaw * dx;
    return [-left, -(turn.cosPitch * dz + turn.sinPitch * ahead), turn.cosPitch * ahead - turn.sinPitch * dz + view.distance];
  }

  function draw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; paint(); });
  }

  function paint() {
    if (!cloud) return;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
    const turn = {
      cosYaw: Math.cos(view.yaw), sinYaw: Math.sin(view.yaw), cosPitch: Math.cos(view.pitch), sinPitch: Math.sin(view.pitch),
    };
    const focal = FOCAL * Math.min(width, height * 1.6);
    const image = context.createImageData(width, height);
    const pixels = new Uint32Array(image.data.buffer);
    pixels.fill(0xff14100d);
    const size = Math.max(1, Math.round(1.8 * ratio));
    for (let i = 0; i < cloud.count; i++) {
      const [right, down, depth] = toView(cloud.xyz[3 * i], cloud.xyz[3 * i + 1], cloud.xyz[3 * i + 2], turn);
      if (depth < 0.5) continue;
      const u = Math.round(width / 2 + focal * right / depth), v = Math.round(height / 2 + focal * down / depth);
      for (let dv = 0; dv < size; dv++) {
        for (let du = 0; du < size; du++) {
          if (u + du >= 0 && u + du < width && v + dv >= 0 && v + dv < height) pixels[(v + dv) * width + u + du] = cloud.colors[i];
        }
      }
    }
    context.putImageData(image, 0, 0);
    if (!document.getElementById("gallery").classList.contains("no-box3d")) paintBoxes(turn, focal, width, height, ratio);
  }

  function paintBoxes(turn, focal, width, height, ratio) {
    context.lineWidth = 1.3 * ratio;
    for (const box of cloud.boxes) {
      const corners = box.corners.map(([x, y, z]) => toView(x, y, z, turn));
      if (corners.some((corner) => corner[2] < 0.5)) continue;
      context.strokeStyle = box.color;
      context.beginPath();
      for (const [a, b] of EDGES) {
        for (const [index, corner] of [corners[a], corners[b]].entries()) {
          const u = width / 2 + focal * corner[0] / corner[2], v = height / 2 + focal * corner[1] / corner[2];
          if (index) context.lineTo(u, v); else context.moveTo(u, v);
        }
      }
      context.stroke();
    }
  }

  function turnBy(yaw, pitch) {
    view.yaw += yaw;
    view.pitch = Math.min(1.55, Math.max(0.02, view.pitch + pitch));
    draw();
  }

  function zoomBy(factor) {
    view.distance = Math.min(120, Math.max(6, view.distance * factor));
    draw();
  }

  const fingers = new Map();
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const apart = () => { const [a, b] = [...fingers.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
    const was = fingers.size === 2 ? apart() : 0;
    fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (fingers.size === 2) zoomBy(was / Math.max(1, apart()));
    else turnBy((before[0] - event.clientX) * 0.008, (event.clientY - before[1]) * 0.006);
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  canvas.addEventListener("wheel", (event) => {
    // Who only scrolls past is not held up.
    if (document.activeElement !== canvas) return;
    event.preventDefault();
    zoomBy(Math.exp(event.deltaY * 0.001));
  }, { passive: false });
  canvas.addEventListener("keydown", (event) => {
    const keys = {
      ArrowLeft: () => turnBy(0.1, 0), ArrowRight: () => turnBy(-0.1, 0), ArrowUp: () => turnBy(0, 0.08),
      ArrowDown: () => turnBy(0, -0.08), "+": () => zoomBy(0.85), "-": () => zoomBy(1.18),
    };
    if (keys[event.key]) { event.preventDefault(); keys[event.key](); }
  });
  const VIEWS = { behind: [0, 0.45], above: [0, 1.55], side: [Math.PI / 2, 0.3] };
  for (const button of document.querySelectorAll("[data-view]")) {
    button.addEventListener("click", () => { [view.yaw, view.pitch] = VIEWS[button.dataset.view]; view.distance = 40; draw(); });
  }
  for (const button of document.querySelectorAll("[data-cloud]")) {
    button.addEventListener("click", () => {
      select.value = button.dataset.cloud;
      load(select.value);
      canvas.scrollIntoView({ block: "center" });
    });
  }
  select.addEventListener("change", () => load(select.value));
  window.addEventListener("resize", draw);
  load(select.value);
})();
