// What the browser keeps beside the ROMs, as text of JSON: the games in play (keeper.js), and one saved state of each game.

import { bytesOf } from "./files.js";
import { base64Of } from "./link.js";

const stateName = (id) => `atari-envs:state:${id}`;

/** Keeps a value of JSON under a name. */
export function write(name, value) {
  try {
    localStorage.setItem(name, JSON.stringify(value));
  } catch {
    throw new Error("The browser's storage is full or closed: a reload would lose this game; save its replay.");
  }
}

/** The value of a name; null if there is none. */
export function read(name) {
  try {
    return JSON.parse(localStorage.getItem(name));
  } catch {
    return null;
  }
}

export function saveState(play) {
  write(stateName(play.entry.id), { settings: play.settings, state: base64Of(play.session.snapshot()) });
}

/** Returns the bytes of the saved state of this game, which the session checks; null if there is none. */
export function savedState(play) {
  const kept = read(stateName(play.entry.id));
  return kept && bytesOf(kept.state);
}
