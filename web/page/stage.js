// The stage: the screen of the game, and that of its fork, enlarged by whole numbers. A pixel of the console is two wide.

import { h } from "./dom.js";
import { Screen } from "./screen.js";

class RgbaScreen extends Screen {
  /** Draws a screen of the core, four bytes a pixel. */
  draw(rgba) {
    const colours = new Uint32Array(rgba.buffer, rgba.byteOffset, rgba.length / 4);
    for (let i = 0, j = 0; i < colours.length; i += 1, j += 2) this.pixels[j] = this.pixels[j + 1] = colours[i];
    this.context.putImageData(this.image, 0, 0);
  }
}

export class Stage {
  constructor() {
    this.element = h("div", { class: "stage", tabIndex: 0, role: "group", "aria-label": "Screen" });
    this.screens = [];
    new ResizeObserver(() => this.#fit()).observe(this.element);
    window.addEventListener("resize", () => this.#fit()); // its height
  }

  /** Makes empty screens of a height, one for each label. */
  prepare(height, labels) {
    this.screens = labels.map((label) => new RgbaScreen(height, null, label));
    this.element.replaceChildren(...this.screens.map((screen, i) =>
      h("figure", {}, screen.element, labels.length > 1 ? h("figcaption", {}, labels[i]) : null)));
    this.#fit();
  }

  draw(number, rgba, objects) {
    const screen = this.screens[number];
    screen.draw(rgba);
    screen.drawOverlay(objects, null, 0);
  }

  // Below a factor of one the screens stand one below the other.
  #fit() {
    if (!this.screens.length) return;
    const gap = 12;
    const count = this.element.clientWidth < 320 * this.screens.length + gap ? 1 : this.screens.length;
    const across = (this.element.clientWidth - gap * (count - 1)) / count / 320;
    const around = parseInt(getComputedStyle(this.element).getPropertyValue("--around"), 10); // pixels above and below it
    const down = Math.max(innerHeight - around, 190) / this.screens[0].height;
    const ratio = window.devicePixelRatio || 1;
    // Whole pixels of the device, if there is room for one.
    const fits = Math.min(across, down);
    const zoom = Math.floor(fits * ratio) / ratio || fits;
    for (const screen of this.screens) screen.zoom(zoom);
  }
}
