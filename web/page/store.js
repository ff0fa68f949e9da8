// What the browser keeps beside the ROMs, as text of JSON: the game in play, so that a reload loses nothing, and one saved
// state of each game.

import { bytesOf } from "./files.js";
import { base64Of } from "./link.js";

const NOW = "atari-envs:now";
const stateName = (id) => `atari-envs:state:${id}`;

function write(name, value) {
  try {
    localStorage.setItem(name, JSON.stringify(value));
  } catch {
    throw new Error("The browser's storage is full or closed: a reload would lose this game; save its replay.");
  }
}

function read(name) {
  try {
    return JSON.parse(localStorage.getItem(name));
  } catch {
    return null;
  }
}

/** Keeps the game in play: `view` is what the page shows around it. */
export function keepNow(play, bytes, view) {
  const place = play.isReplay ? { frame: play.frame } : { state: base64Of(play.session.snapshot()) };
  const changes = play.changes.inForce;
  write(NOW, { game: play.entry.id, replay: base64Of(bytes), ...place, changes, view });
}

export function keptNow() {
  const kept = read(NOW);
  return kept && { ...kept, replay: bytesOf(kept.replay), state: kept.state && bytesOf(kept.state) };
}

export function saveState(play) {
  write(stateName(play.entry.id), { settings: play.settings, state: base64Of(play.session.snapshot()) });
}

/** Returns the bytes of the saved state of this game, which the session checks; null if there is none. */
export function savedState(play) {
  const kept = read(stateName(play.entry.id));
  return kept && bytesOf(kept.state);
}
