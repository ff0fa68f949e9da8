// Binary messages, the screen with its overlay, and charts of bytes.

import { h } from "./dom.js";

export const COLUMNS = 160;
const HEAD = 32;

// The content of a binary message; protocol.py documents it. Arrays are views of the message.
export function parse(buffer, span) {
  const view = new DataView(buffer);
  const flags = view.getUint8(1);
  const height = view.getUint16(2, true);
  const frame = {
    playing: !!(flags & 1),
    byAgent: !!(flags & 2),
    over: !!(flags & 4),
    preview: !!(flags & 8),
    fork: null,
    height,
    at: view.getUint32(4, true),
    first: view.getUint32(8, true),
    end: view.getUint32(12, true),
    score: view.getInt32(16, true),
    lives: view.getUint16(24, true),
    version: view.getUint32(28, true),
    histories: new Map(),
  };
  let place = HEAD;
  const take = (size) => new Uint8Array(buffer, (place += size) - size, size);
  frame.ram = take(128);
  frame.screen = take(height * COLUMNS);
  if (flags & 16) {
    frame.fork = { score: view.getInt32(20, true), preview: !!(flags & 32), ram: take(128), screen: take(height * COLUMNS) };
  }
  for (let left = view.getUint16(26, true); left > 0; left--) {
    const [index, count] = take(2);
    frame.histories.set(index, take(span).subarray(0, count));
  }
  return frame;
}

export function bytesOf(base64) {
  return Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
}

export function paletteOf(base64) {
  const rgb = bytesOf(base64);
  const colours = new Uint32Array(256);
  for (let i = 0; i < 256; i++) {
    colours[i] = (255 << 24) | (rgb[3 * i + 2] << 16) | (rgb[3 * i + 1] << 8) | rgb[3 * i];
  }
  return colours;
}

// A screen of the console: each pixel is 2 x 1 pixels of the canvas, enlarged by a whole number.
export class Screen {
  constructor(height, palette, label) {
    Object.assign(this, { height, palette, mask: null });
    this.canvas = h("canvas", { width: 2 * COLUMNS, height, role: "img", "aria-label": label });
    this.context = this.canvas.getContext("2d", { alpha: false });
    this.image = this.context.createImageData(2 * COLUMNS, height);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.overlay = h("canvas", { class: "overlay" });
    this.over = this.overlay.getContext("2d");
    this.element = h("div", { class: "screen" }, this.canvas, this.overlay);
  }

  zoom(times) {
    this.element.style.width = `${2 * COLUMNS * times}px`;
    this.element.style.height = `${this.height * times}px`;
    const ratio = window.devicePixelRatio || 1;
    this.overlay.width = Math.round(2 * COLUMNS * times * ratio);
    this.overlay.height = Math.round(this.height * times * ratio);
    this.unit = times * ratio;
  }

  draw(indices) {
    const { pixels, palette } = this;
    for (let i = 0, j = 0; i < indices.length; i++, j += 2) {
      pixels[j] = pixels[j + 1] = palette[indices[i]];
    }
    this.context.putImageData(this.image, 0, 0);
  }

  // Light up pixels: the bits of a mask, the first pixel in the highest bit; or none with null.
  light(bits) {
    this.mask = bits && h("canvas", { width: COLUMNS, height: this.height });
    if (!bits) return;
    const context = this.mask.getContext("2d");
    const image = context.createImageData(COLUMNS, this.height);
    const pixels = new Uint32Array(image.data.buffer);
    for (let i = 0; i < pixels.length; i++) {
      pixels[i] = bits[i >> 3] & (128 >> (i & 7)) ? 0xffffe93a : 0x99000000; // cyan on a dark veil; bytes are A B G R
    }
    context.putImageData(image, 0, 0);
  }

  // The overlay: lit pixels, objects with their names, and a mark at the chosen pixel.
  drawOverlay(objects, mark, now) {
    const { over, overlay, unit } = this;
    over.clearRect(0, 0, overlay.width, overlay.height);
    if (this.mask) {
      over.imageSmoothingEnabled = false;
      over.globalAlpha = 0.75 + 0.2 * Math.sin(now / 160);
      over.drawImage(this.mask, 0, 0, overlay.width, overlay.height);
      over.globalAlpha = 1;
    }
    over.font = `${Math.max(10, 5 * unit)}px ui-monospace, monospace`;
    over.lineWidth = Math.max(1, unit / 2);
    for (const [name, x, y, width, height] of objects) {
      const left = (x ?? 0) * 2 * unit;
      const top = (y ?? 0) * unit;
      over.strokeStyle = over.fillStyle = "#7dff8a";
      if (width != null && height != null && x != null && y != null) {
        over.strokeRect(left, top, width * 2 * unit, height * unit);
      } else { // a cross; or a line, where a coordinate is not known
        const across = x == null ? [0, overlay.width] : [left - 4 * unit, left + 4 * unit];
        const down = y == null ? [0, overlay.height] : [top - 4 * unit, top + 4 * unit];
        if (y != null) over.stroke(new Path2D(`M ${across[0]} ${top} H ${across[1]}`));
        if (x != null) over.stroke(new Path2D(`M ${left} ${down[0]} V ${down[1]}`));
      }
      over.shadowColor = "#000";
      over.shadowBlur = 3 * unit;
      over.fillText(name, left + 2 * unit, Math.max(6 * unit, top - 2 * unit));
      over.shadowBlur = 0;
    }
    if (mark) {
      over.strokeStyle = "#ff4d6d";
      over.strokeRect((mark.x * 2 - 2) * unit, (mark.y - 2) * unit, 6 * unit, 5 * unit);
    }
  }

  // The pixel under a pointer.
  pixelAt(event) {
    const box = this.canvas.getBoundingClientRect();
    const x = Math.floor(((event.clientX - box.left) / box.width) * COLUMNS);
    const y = Math.floor(((event.clientY - box.top) / box.height) * this.height);
    return { x: Math.min(Math.max(x, 0), COLUMNS - 1), y: Math.min(Math.max(y, 0), this.height - 1) };
  }
}

// A chart of the values of a byte, the newest at the right edge.
export function drawHistory(canvas, values, span, colour, grid) {
  const ratio = window.devicePixelRatio || 1;
  const width = Math.round(canvas.clientWidth * ratio);
  const height = Math.round(canvas.clientHeight * ratio);
  if (canvas.width !== width || canvas.height !== height) {
    canvas.width = width;
    canvas.height = height;
  }
  const context = canvas.getContext("2d");
  context.clearRect(0, 0, width, height);
  if (!values?.length || !width) return null;
  const low = Math.min(...values);
  const high = Math.max(...values);
  const room = Math.max(high - low, 4);
  const base = Math.min(low, 255 - room);
  const margin = 3 * ratio;
  const y = (value) => height - margin - ((value - base) / room) * (height - 2 * margin);
  if (grid) {
    context.strokeStyle = grid;
    context.lineWidth = 1;
    for (const line of [base, base + room]) context.stroke(new Path2D(`M 0 ${y(line)} H ${width}`));
  }
  context.strokeStyle = colour;
  context.lineWidth = 1.5 * ratio;
  context.lineJoin = "round";
  context.beginPath();
  const step = width / (span - 1);
  const left = width - (values.length - 1) * step;
  for (let i = 0; i < values.length; i++) {
    const x = left + i * step;
    if (i === 0) context.moveTo(x, y(values[0]));
    else {
      context.lineTo(x, y(values[i - 1])); // bytes jump from frame to frame
      context.lineTo(x, y(values[i]));
    }
  }
  if (values.length === 1) context.lineTo(width, y(values[0]));
  context.stroke();
  return { low, high };
}
