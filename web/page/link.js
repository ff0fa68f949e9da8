// Links: the part of an address after "#", which no server gets. A link to a moment has a game, its state, speed and open
// panels; a link to a replay has its bytes, or its name where it comes with the page. A link writes no RAM: it has no
// interventions.

import { bytesOf } from "./files.js";

const MOST = 100_000; // letters: longer addresses are cut off by programs that people send them with
const OPTIONS = ["repeat_action_probability", "mode", "difficulty", "max_num_frames_per_episode"];

export function base64Of(bytes) {
  let text = "";
  for (let at = 0; at < bytes.length; at += 4096) text += String.fromCharCode(...bytes.subarray(at, at + 4096));
  return btoa(text);
}

const packed = (bytes) => base64Of(bytes).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
const unpacked = (text) => bytesOf(text.replaceAll("-", "+").replaceAll("_", "/"));

function addressWith(values) {
  if (location.protocol === "about:") throw new Error("This frame has no address for a link; save the replay instead.");
  const address = `${location.href.split("#")[0]}#${new URLSearchParams(values)}`;
  if (address.length > MOST) throw new Error("This is too long for a link; save it as a file instead.");
  return address;
}

export const linkToReplay = (bytes) => addressWith({ replay: packed(bytes) });

/** A link to a replay that comes with the page. */
export const linkToShown = (name) => addressWith({ show: name });

/** A link to the present moment of a play. */
export function linkToMoment(play, speed, panels) {
  const { players, options } = play.settings;
  if (options.interventions?.length) throw new Error("A link has no interventions; save the replay instead.");
  const plain = Object.fromEntries(OPTIONS.filter((name) => options[name] != null).map((name) => [name, options[name]]));
  return addressWith({
    game: play.entry.id,
    players,
    options: JSON.stringify(plain),
    speed,
    panels: panels.join(" "),
    state: packed(play.session.snapshot()),
  });
}

/** What a link shows: {replay}, {show}, {game, settings, speed, panels, state}, {game} alone; null where there is no link. */
export function readLink(hash) {
  const values = new URLSearchParams(hash.replace(/^#/, ""));
  if (!["replay", "show", "game"].some((name) => values.has(name))) return null;
  if (values.has("show")) return { show: values.get("show") };
  try {
    if (values.has("replay")) return { replay: unpacked(values.get("replay")) };
    if (!values.has("state")) return { game: values.get("game") };
    return readMoment(values);
  } catch {
    throw new Error("The link is damaged: its end may be missing.");
  }
}

function readMoment(values) {
  const given = JSON.parse(values.get("options"));
  const options = { mode: null, difficulty: null };
  for (const name of OPTIONS) if (given[name] != null) options[name] = given[name];
  return {
    game: values.get("game"),
    settings: { players: values.get("players") === "2" ? 2 : 1, options },
    speed: Number(values.get("speed")),
    panels: (values.get("panels") ?? "").split(" "),
    state: unpacked(values.get("state")),
  };
}
