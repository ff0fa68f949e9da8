// The bar of a replay: how much is verified, any frame by a slider, and going on by hand.

import { button, h, setText } from "./dom.js";

export class ReplayBar {
  constructor(app) {
    this.app = app;
    this.slider = h("input", { type: "range", min: 0, value: 0, "aria-label": "Frame of the replay" });
    this.slider.addEventListener("input", () => app.seek(Number(this.slider.value)));
    this.state = h("span", { class: "verdict" });
    this.element = h("div", { class: "replay card", hidden: true }, this.slider,
      h("div", { class: "line" }, this.state,
        button("Go on by hand", "Play on from this frame", () => app.goOn(), { class: "primary" }),
        button("Close the replay", "Begin a new game", () => app.attempt(() => app.restart()))));
  }

  draw({ play, seeking }) {
    this.element.hidden = !play.isReplay;
    if (!play.isReplay) return;
    this.slider.max = play.frames;
    if (seeking === null) this.slider.value = play.frame;
    setText(this.state, `Frame ${play.frame} of ${play.frames}. ${verdict(play)}`);
    this.element.classList.toggle("wrong", play.difference !== null);
  }
}

function verdict({ difference, checked, frames }) {
  if (difference) return `It differs from the recording at frame ${difference.frame}: ${difference.what}.`;
  if (checked >= frames) return `Verified: all ${frames} frames are those of the recording.`;
  return `${checked} frames verified.`;
}
