// A film: pictures, facts and sound of the first part of a recording, for readers without the ROM. It has the face of a
// `Play` that shows a replay (play.js), without what needs the core. atari/web/film.py writes films.

import { load, unpack } from "./files.js";

const MAGIC = 0x41323646, VERSION = 1, HEAD = 20; // "A26F"
const WIDTH = 160, SAMPLES = 512, FACTS = 3;
const KEY = 300; // each such picture has all rows
const MOST = 1 << 27, MOST_ROWS = 512; // MOST: bytes unpacked
const NO_CHANGES = { has: () => false, undo() {}, canUndo: false, inForce: [] };

function check(fine) {
  if (!fine) throw new RangeError("damaged");
}

const bitsOf = (byte) => { let bits = 0; for (let left = byte; left; left >>= 1) bits += left & 1; return bits; };

/** The parts of an unpacked film, all of whose numbers are checked. */
function read(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  const colours = view.getUint8(5) + 1, height = view.getUint16(6, true);
  const frames = view.getUint32(8, true), whole = view.getUint32(12, true);
  const rate = view.getUint16(16, true) / 100, players = view.getUint8(18);
  check(view.getUint32(0) === MAGIC && view.getUint8(4) === VERSION && view.getUint8(19) === 0);
  check(height >= 1 && height <= MOST_ROWS && frames >= 1 && frames <= whole && rate >= 1 && [1, 2].includes(players));
  const palette = new Uint32Array(colours);
  for (let i = 0, at = HEAD; i < colours; i += 1, at += 3)
    palette[i] = 0xff000000 | bytes[at] | (bytes[at + 1] << 8) | (bytes[at + 2] << 16);
  const maskSize = Math.ceil(height / 8);
  const pictures = HEAD + 3 * colours;
  check(pictures + frames * (maskSize + 4 * FACTS + SAMPLES) <= bytes.length);
  const starts = new Uint32Array(frames);
  let at = pictures;
  for (let frame = 0; frame < frames; frame += 1) {
    starts[frame] = at;
    check(at + maskSize <= bytes.length);
    let rows = 0;
    for (const end = at + maskSize; at < end; at += 1) rows += bitsOf(bytes[at]);
    check((bytes[at - 1] & ((1 << (8 * maskSize - height)) - 1)) === 0); // no row below the last
    check(rows === height || frame % KEY !== 0);
    const end = at + rows * WIDTH;
    check(end <= bytes.length);
    for (; at < end; at += 1) check(bytes[at] < colours);
  }
  check(at + frames * (4 * FACTS + SAMPLES) === bytes.length);
  return { bytes, view, height, frames, whole, rate, players, palette, maskSize, starts, facts: at };
}

export class Film {
  isReplay = true;
  isFilm = true;
  fork = null;
  difference = null;
  changes = NO_CHANGES;
  frame = 0; // frames played so far
  #film;
  #picture = -1; // the number of the picture in #indices
  #indices;
  #colours;

  /** Loads the film of a replay of the shelf. `entry` is that of its game in the table. */
  static async open({ name, film }, entry) {
    const packed = await load(film);
    try {
      return new Film(read(await unpack(packed, "deflate", MOST)), entry);
    } catch {
      throw new Error(`The film ${name} is damaged.`);
    }
  }

  constructor(film, entry) {
    const { frames, whole, rate, players, height } = film;
    Object.assign(this, { entry, frames, whole, rate, players, height });
    this.#film = film;
    this.#indices = new Uint8Array(height * WIDTH);
    this.#colours = new Uint32Array(height * WIDTH);
  }

  get session() { return this; }
  get objects() { return this.entry.objects.map(() => null); }

  advance() {
    if (this.frame === this.frames) return false;
    this.frame += 1;
    return true;
  }

  goBack() { return this.seek(this.frame - 1); }

  seek(frame) {
    this.frame = Math.max(0, Math.min(frame, this.frames));
    return true;
  }

  /** The screen as `Session.screen` gives it. Before the first frame it is that of the first. */
  screen() {
    const to = this.#place;
    const key = to - (to % KEY);
    let next = this.#picture < key || this.#picture > to ? key : this.#picture + 1;
    for (; next <= to; next += 1) this.#draw(next);
    this.#picture = to;
    const { palette } = this.#film;
    const indices = this.#indices, colours = this.#colours;
    for (let i = 0; i < colours.length; i += 1) colours[i] = palette[indices[i]];
    return new Uint8ClampedArray(colours.buffer);
  }

  #draw(picture) {
    const { bytes, starts, maskSize, height } = this.#film;
    const mask = starts[picture];
    for (let row = 0, from = mask + maskSize; row < height; row += 1) {
      if (!(bytes[mask + (row >> 3)] & (128 >> (row & 7)))) continue;
      this.#indices.set(bytes.subarray(from, from + WIDTH), row * WIDTH);
      from += WIDTH;
    }
  }

  facts() {
    const { view, facts, frames } = this.#film;
    const [score, secondScore, lives] = [0, 1, 2].map((which) => view.getInt32(facts + 4 * (which * frames + this.#place), true));
    return { score, secondScore, lives };
  }

  audio() {
    const { bytes, facts, frames } = this.#film;
    const start = facts + 4 * FACTS * frames + SAMPLES * this.#place;
    return bytes.subarray(start, start + SAMPLES);
  }

  get #place() { return Math.max(this.frame - 1, 0); }

  close() {}
}
