// Keyboard, touch and gamepads as actions of ALE for one or two players.

import { TouchStick } from "./touch.js";

// By `KeyboardEvent.code`: the place of a key, whatever the layout.
const ARROWS = { ArrowUp: "up", ArrowDown: "down", ArrowLeft: "left", ArrowRight: "right", Space: "fire" };
const LETTERS = { KeyW: "up", KeyS: "down", KeyA: "left", KeyD: "right", KeyF: "fire" };

const STICK = [[9, 5, 8], [4, 0, 3], [7, 2, 6]]; // by vertical and horizontal direction, each -1, 0, 1
const DEAD = 0.4; // a stick of a gamepad nearer to its centre is not moved

/** The number of an ALE action. */
export function actionOf(vertical, horizontal, fire) {
  const moved = STICK[vertical + 1][horizontal + 1];
  if (!fire) return moved;
  return moved === 0 ? 1 : moved + 8;
}

// In a frame of another page, keys are that page's until the reader has gone into this one: by a click, or by Tab to the stage.
class Entrance {
  open = window === window.top;
  constructor() {
    const enter = () => { this.open = true; };
    document.addEventListener("pointerdown", enter, { capture: true });
    document.addEventListener("focusin", ({ target }) => target.matches(".stage") && enter());
  }
}
const entrance = new Entrance();

/** Whether the browser or a field needs a key, so that the page may not have it. */
export function isTaken(event) {
  if (!entrance.open) return true;
  if (event.ctrlKey || event.altKey || event.metaKey || event.isComposing) return true;
  const { target, code } = event;
  if (target.matches("select, input:not([type=checkbox], [type=range])")) return true;
  if (target.matches("[type=range]")) return /^(Arrow|Page|Home|End)/.test(code);
  return target.matches("button, summary, input") && (code === "Space" || code === "Enter");
}

export class Input {
  #held = [new Set(), new Set()];

  constructor() {
    this.players = 1;
    this.touch = new TouchStick(() => {});
    document.addEventListener("keydown", (event) => this.#key(event, true));
    document.addEventListener("keyup", (event) => this.#key(event, false));
    window.addEventListener("blur", () => this.#held.forEach((keys) => keys.clear()));
  }

  #key(event, down) {
    const [name, player] = ARROWS[event.code] ? [ARROWS[event.code], 0] : [LETTERS[event.code], this.players - 1];
    if (!name) return;
    if (!down) {
      for (const keys of this.#held) keys.delete(event.code);
    } else if (!isTaken(event)) {
      event.preventDefault();
      this.#held[player].add(event.code);
    }
  }

  /** The actions of both players now. */
  actions() {
    const pads = gamepads();
    const ofPlayer = [pads.slice(0, this.players > 1 ? 1 : pads.length), this.players > 1 ? pads.slice(1) : []];
    return this.#held.map((keys, player) => {
      const names = new Set([...keys].map((code) => ARROWS[code] ?? LETTERS[code]));
      for (const pad of ofPlayer[player]) readPad(pad, names);
      const { vertical, horizontal, fire } = player === 0 ? this.touch : { vertical: 0, horizontal: 0, fire: false };
      return actionOf(
        Math.sign(names.has("up") - names.has("down") + vertical),
        Math.sign(names.has("right") - names.has("left") + horizontal),
        names.has("fire") || fire);
    });
  }
}

function gamepads() {
  try {
    return [...(navigator.getGamepads?.() ?? [])].filter((pad) => pad?.connected);
  } catch {
    return []; // a frame may forbid them
  }
}

function readPad({ axes, buttons }, names) {
  const pressed = (number) => buttons[number]?.pressed;
  if (axes[1] < -DEAD || pressed(12)) names.add("up");
  if (axes[1] > DEAD || pressed(13)) names.add("down");
  if (axes[0] < -DEAD || pressed(14)) names.add("left");
  if (axes[0] > DEAD || pressed(15)) names.add("right");
  if ([0, 1, 2, 3].some(pressed)) names.add("fire");
}
