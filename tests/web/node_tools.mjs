// What the tests under Node share: the core, the input of a test, CRC-32, and frames as ten bytes of text.
import { readFileSync } from "node:fs";
import { loadCore } from "../../web/core/core.js";

export const core = await loadCore(readFileSync(process.env.CORE_WASM));

/** The object of JSON that the test in Python has written to the standard input. */
export const input = JSON.parse(readFileSync(0, "utf8"));

export const bytesOf = (base64) => Uint8Array.from(Buffer.from(base64, "base64"));
export const base64Of = (bytes) => Buffer.from(bytes).toString("base64");

const TABLES = Array.from({ length: 4 }, () => new Uint32Array(256));
for (let byte = 0; byte < 256; byte += 1) {
  let sum = byte;
  for (let bit = 0; bit < 8; bit += 1) sum = (sum >>> 1) ^ (sum & 1 ? 0xedb88320 : 0);
  TABLES[0][byte] = sum;
}
for (let i = 1; i < 4; i += 1)
  for (let byte = 0; byte < 256; byte += 1) {
    const before = TABLES[i - 1][byte];
    TABLES[i][byte] = (before >>> 8) ^ TABLES[0][before & 0xff];
  }

/** The CRC-32 of zlib, continued from `sum`. The number of bytes is a multiple of four. */
export function crc32(sum, bytes) {
  const [first, second, third, fourth] = TABLES;
  let crc = ~sum;
  for (let i = 0; i < bytes.length; i += 4) {
    crc ^= bytes[i] | (bytes[i + 1] << 8) | (bytes[i + 2] << 16) | (bytes[i + 3] << 24);
    crc = fourth[crc & 0xff] ^ third[(crc >>> 8) & 0xff] ^ second[(crc >>> 16) & 0xff] ^ first[crc >>> 24];
  }
  return ~crc >>> 0;
}

/** Pseudo-random numbers below a bound, as the golden values use them. */
export function generator(seed) {
  let state = seed;
  return (bound) => {
    state = (Math.imul(1664525, state) + 1013904223) >>> 0;
    return (state >>> 16) % bound;
  };
}

/** Check sums of RAM, screen and sound. */
export class Sums {
  constructor() { this.sums = [0, 0, 0]; }
  add(session) {
    const parts = [session.ram(), session.framebuffer(), session.audio()];
    this.sums = parts.map((bytes, i) => crc32(this.sums[i], bytes));
    return this;
  }
  words() { return this.sums.map((sum) => sum.toString(16).padStart(8, "0")); }
}
