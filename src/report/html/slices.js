"use strict";
// Slices anywhere: unpacked when the panel is opened, drawn without WebGL.
(() => {
  const panel = document.getElementById("volume"), source = document.getElementById("volume-data");
  if (!panel || !source || typeof DecompressionStream === "undefined") return;
  panel.hidden = false;
  const grid = JSON.parse(source.dataset.grid), [nx, ny, nz] = grid.dims;
  const TINT = { fail: "#a40e3a", warn: "#8a4f00", undecided: "#484aa0", error: "#a40e3a" };
  let density = null;

  const unpack = async () => {
    if (density) return;
    const bytes = await amcheck.inflate(source.textContent);
    for (let i = 1; i < bytes.length; i++) bytes[i] = (bytes[i] + bytes[i - 1]) & 255;
    density = bytes;
  };

  /** Draws the slice of a canvas; returns the share of material in it. */
  const draw = (canvas) => {
    const axis = +canvas.dataset.axis, [u, v] = [[1, 2], [0, 2], [0, 1]][axis];
    const slider = panel.querySelector(`input[data-axis="${axis}"]`), at = +slider.value;
    const step = [1, nx, nx * ny], w = grid.dims[u], h = grid.dims[v];
    const small = new OffscreenCanvas(w, h), brush = small.getContext("2d"), image = brush.createImageData(w, h);
    let solid = 0;
    for (let j = 0; j < h; j++) {
      for (let i = 0; i < w; i++) {
        const d = density[at * step[axis] + i * step[u] + (h - 1 - j) * step[v]] / 255, o = 4 * (j * w + i);
        image.data.set([120, 144, 163, 255 * d], o);
        solid += d;
      }
    }
    brush.putImageData(image, 0, 0);
    const zoom = Math.max(1, Math.min(8, Math.floor(Math.min(640 / w, 480 / h))));
    canvas.width = w * zoom;
    canvas.height = h * zoom;
    const to = canvas.getContext("2d");
    to.imageSmoothingEnabled = zoom < 3;
    to.drawImage(small, 0, 0, w * zoom, h * zoom);
    const place = grid.origin[axis] + at * grid.spacing;
    to.font = "bold 13px sans-serif";
    to.textAlign = "center";
    to.textBaseline = "middle";
    for (const pin of grid.pins) {
      if (Math.abs(pin.at[axis] - place) > 1.5 * grid.spacing) continue;
      const x = ((pin.at[u] - grid.origin[u]) / grid.spacing + 0.5) * zoom;
      const y = (h - 0.5 - (pin.at[v] - grid.origin[v]) / grid.spacing) * zoom;
      to.fillStyle = TINT[pin.state] ?? "#586370";
      to.strokeStyle = "#fff";
      to.lineWidth = 2;
      to.beginPath();
      to.arc(x, y, 11, 0, 7);
      to.fill();
      to.stroke();
      to.fillStyle = "#fff";
      to.fillText(pin.number, x, y + 1);
    }
    slider.nextElementSibling.textContent = Math.round(place * 100) / 100 + " mm";
    return solid / (w * h);
  };

  const canvases = [...panel.querySelectorAll("canvas")];
  canvases.forEach((canvas, axis) => {
    const slider = panel.querySelector(`input[data-axis="${axis}"]`), worst = grid.pins[0]?.at[axis];
    slider.max = grid.dims[axis] - 1;
    slider.value = Math.round(worst === undefined ? grid.dims[axis] / 2 : (worst - grid.origin[axis]) / grid.spacing);
    slider.addEventListener("input", () => density && draw(canvas));
  });
  const open = async () => {
    await unpack();
    return canvases.map(draw);
  };
  panel.addEventListener("toggle", () => panel.open && open());
  amcheck.slices = open;
})();
