// Reads zips, such as a wheel of ale-py: the files in it that can be ROMs or replays.

import { unpack } from "./files.js";

const END = 0x06054b50, ENTRY = 0x02014b50, MOST_FILES = 400;
const END_SIZE = 22, ENTRY_SIZE = 46, LOCAL_SIZE = 30;
const STORED = 0, DEFLATED = 8;

export const isZip = (bytes) => bytes.length > 4 && bytes[0] === 0x50 && bytes[1] === 0x4b && bytes[2] === 3;

/** The first files of at most `most` bytes whose names fit, as {name, bytes}. */
export async function readZip(bytes, fits, most) {
  try {
    const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
    const fitting = [...entries(view, bytes)].filter(({ name, size }) => size <= most && fits(name)).slice(0, MOST_FILES);
    const found = [];
    for (const entry of fitting) found.push({ name: entry.name, bytes: await contentOf(entry, view, bytes, most) });
    return found;
  } catch {
    throw new Error("The zip is damaged: it cannot be read.");
  }
}

function* entries(view, bytes) {
  let end = bytes.length - END_SIZE;
  while (view.getUint32(end, true) !== END) end -= 1; // a comment may follow it; before the start this throws
  let at = view.getUint32(end + 16, true);
  for (let left = view.getUint16(end + 10, true); left > 0; left -= 1) {
    if (view.getUint32(at, true) !== ENTRY) throw new RangeError("no entry");
    const [name, extra, comment] = [28, 30, 32].map((place) => view.getUint16(at + place, true));
    yield {
      name: new TextDecoder().decode(bytes.subarray(at + ENTRY_SIZE, at + ENTRY_SIZE + name)),
      method: view.getUint16(at + 10, true),
      packed: view.getUint32(at + 20, true),
      size: view.getUint32(at + 24, true),
      start: view.getUint32(at + 42, true),
    };
    at += ENTRY_SIZE + name + extra + comment;
  }
}

async function contentOf({ method, packed, size, start }, view, bytes, most) {
  const from = start + LOCAL_SIZE + view.getUint16(start + 26, true) + view.getUint16(start + 28, true);
  if (from + packed > bytes.length) throw new RangeError("the end is missing");
  const content = bytes.subarray(from, from + packed);
  const found = method === STORED ? content : method === DEFLATED ? await unpack(content, "deflate-raw", most) : null;
  if (found?.length !== size) throw new RangeError("the size differs");
  return found;
}
