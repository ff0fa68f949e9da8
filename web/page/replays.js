// The bar of a replay: how much is verified, any frame by a slider, and going on by hand. Of a film it says what is missing.

import { button, h, setText } from "./dom.js";

export class ReplayBar {
  constructor(app) {
    this.app = app;
    this.slider = h("input", { type: "range", min: 0, value: 0, "aria-label": "Frame of the replay" });
    this.slider.addEventListener("input", () => app.seek(Number(this.slider.value)));
    this.state = h("span", { class: "verdict" });
    this.goOn = button("Go on by hand", "Play on from this frame", () => app.goOn(), { class: "primary" });
    this.element = h("div", { class: "replay card", hidden: true }, this.slider,
      h("div", { class: "line" }, this.state,
        this.goOn, button("Close the replay", "Begin a new game", () => app.attempt(() => app.closeReplay()))));
  }

  draw({ play, seeking }) {
    this.element.hidden = !play.isReplay;
    this.app.input.touch.element.hidden = play.isReplay; // nothing is played
    if (!play.isReplay) return;
    this.slider.max = play.frames;
    if (seeking === null) this.slider.value = play.frame;
    setText(this.state, `Frame ${play.frame} of ${play.frames}. ${play.isFilm ? filmed(play) : verdict(play)}`);
    this.goOn.disabled = play.isFilm;
    this.element.classList.toggle("wrong", play.difference !== null);
  }
}

function filmed({ entry, frames, whole, rate }) {
  const part = frames < whole ? `, the first ${duration(frames / rate)} of ${duration(whole / rate)}` : "";
  return `Pictures and sound of the recording${part}. With the ROM of ${entry.title} the page verifies it and you can ` +
    "play on: drop the file, or a wheel of ale-py, on the page.";
}

function duration(exact) {
  const seconds = Math.round(exact);
  return seconds < 100 ? `${seconds} s` : `${Math.floor(seconds / 60)} min ${seconds % 60} s`;
}

function verdict({ difference, checked, frames }) {
  if (difference) return `It differs from the recording at frame ${difference.frame}: ${difference.what}.`;
  if (checked >= frames) return `Verified: all ${frames} frames are those of the recording.`;
  return `${checked} frames verified.`;
}
