// The controls around the screen: buttons, choices, and the keys that do the same.

import { button, h, setText } from "./dom.js";
import { isTaken } from "./input.js";

const SPEEDS = [0.25, 0.5, 1, 2, 4, 8];

// Keys by `KeyboardEvent.code`; they have no other use in the page, and none in browsers.
const KEYS = {
  KeyP: (app) => app.togglePause(),
  Period: (app) => app.stepFrame(),
  Enter: (app) => app.newGame(),
  KeyM: (app) => app.toggleSound(),
  KeyK: (app) => app.saveState(),
  KeyL: (app) => app.loadState(),
  KeyZ: (app) => app.undo(),
  KeyV: (app) => app.toggleFork(),
  KeyO: (app) => app.toggleObjects(),
};
const HELP = [
  ["Player 1", "arrow keys, Space; alone also W A S D, F"],
  ["Player 2", "W A S D, F"],
  ["Pause, one frame, new game", "P, full stop, Enter"],
  ["Rewind", "hold Backspace"],
  ["Sound", "M"],
  ["Save the state, load it", "K, L"],
  ["RAM: undo, objects, fork", "Z, O, V"],
];

/** A choice with its label. `options` are pairs of a value and a text. */
export function choice(label, options, chosen) {
  const select = h("select", { onchange: () => chosen(select.value) });
  fill(select, options);
  return { select, element: h("label", {}, h("span", {}, label), select) };
}

export function fill(select, options) {
  select.replaceChildren(...options.map(([value, text]) => h("option", { value: String(value) }, text)));
}

export class Controls {
  constructor(app) {
    this.app = app;
    const does = (text, title, call, properties) => button(text, title, () => app.attempt(call), properties);
    this.pause = does("Pause", "P", () => app.togglePause(), { class: "primary" });
    this.rewind = this.#hold(button("Rewind", "Hold, or hold Backspace", () => {}));
    this.step = does("Frame", "One frame: full stop", () => app.stepFrame());
    this.new = does("New game", "Enter", () => app.newGame());
    this.sound = does("Sound", "M", () => app.toggleSound());
    this.save = does("Save state", "K", () => app.saveState());
    this.load = does("Load state", "L", () => app.loadState());
    this.speed = choice("Speed", SPEEDS.map((speed) => [speed, `${speed}x`]), (value) => app.setSpeed(Number(value)));
    this.ahead = choice("Run-ahead", [0, 1, 2].map((frames) => [frames, frames === 1 ? "1 frame" : `${frames} frames`]),
      (value) => app.setAhead(Number(value)));
    this.ahead.element.title = "The screen shows this many frames ahead, so that the game seems to respond earlier";
    this.replay = does("Save replay", "A file that this page and atari replay read", () => app.saveReplay());
    this.replayLink = does("Link to replay", "A link that plays all of this game", () => app.links.giveReplay());
    this.moment = does("Link to this moment", "A link with the game and its present state", () => app.links.giveMoment());
    this.element = h("div", { class: "controls", role: "group", "aria-label": "Controls" },
      h("div", { class: "line" }, this.pause, this.step, this.rewind, this.new, this.sound, this.speed.element,
        this.ahead.element),
      h("div", { class: "line" }, this.save, this.load, this.replay, this.replayLink, this.moment));
    this.help = h("details", { class: "card", id: "keys" }, h("summary", {}, "Keys"),
      h("dl", {}, ...HELP.flatMap(([what, keys]) => [h("dt", {}, what), h("dd", {}, keys)])),
      h("p", {}, "A gamepad plays as soon as one of its buttons is pressed; a second one is player 2."));
    document.addEventListener("keydown", (event) => this.#key(event, true));
    document.addEventListener("keyup", (event) => this.#key(event, false));
  }

  #key(event, down) {
    if (event.code === "Backspace" && (!down || !isTaken(event))) {
      if (down) event.preventDefault();
      this.app.rewinding = down;
    } else if (down && KEYS[event.code] && !isTaken(event) && (!event.repeat || event.code === "Period")) {
      event.preventDefault();
      this.app.attempt(() => KEYS[event.code](this.app));
    }
  }

  #hold(element) {
    element.addEventListener("pointerdown", () => { this.app.rewinding = true; });
    for (const name of ["pointerup", "pointerleave", "pointercancel"])
      element.addEventListener(name, () => { this.app.rewinding = false; });
    return element;
  }

  draw({ play, paused, sound, speed, ahead }) {
    setText(this.pause, paused ? "Play" : "Pause");
    this.sound.setAttribute("aria-pressed", String(sound.on));
    this.speed.select.value = String(speed);
    this.ahead.select.value = String(ahead);
    this.ahead.select.disabled = play.isReplay;
    for (const element of [this.new, this.save, this.load, this.replay, this.moment]) element.disabled = play.isReplay;
  }
}
