// What the reader gives to the page: ROM files, zips with ROM files, and replays.

import { MOST_ROM } from "./library.js";
import { isZip, readZip } from "./zip.js";

const REPLAY = "ATARIRPL";
const MOST_FILE = 256 * 1024 * 1024;
const ROM_NAME = /\.(bin|a26|rom)$/i;

const isReplay = (bytes) => new TextDecoder("latin1").decode(bytes.subarray(0, REPLAY.length)) === REPLAY;

/** Reads files, adds their ROMs to the library, and returns {ids, replay, problems}: sentences of what was refused. */
export async function openFiles(files, library) {
  const found = { ids: [], replay: null, problems: [] };
  for (const file of files) {
    try {
      await openFile(file, library, found);
    } catch (error) {
      found.problems.push(`${file.name}: ${error.message}`);
    }
  }
  return found;
}

async function openFile(file, library, found) {
  if (file.size > MOST_FILE) throw new Error("The file is larger than 256 MB, and is no ROM, zip or replay.");
  const bytes = new Uint8Array(await file.arrayBuffer());
  if (isReplay(bytes)) {
    found.replay = bytes;
  } else if (isZip(bytes)) {
    const roms = await readZip(bytes, (name) => ROM_NAME.test(name), MOST_ROM);
    const ids = roms.map((rom) => library.add(rom.bytes)).filter(Boolean);
    if (!ids.length) throw new Error("The zip has no ROM of a game that the page has.");
    found.ids.push(...ids);
  } else {
    const id = bytes.length <= MOST_ROM ? library.add(bytes) : undefined;
    if (!id) throw new Error("This is no replay, no zip, and no ROM of a game that the page has.");
    found.ids.push(id);
  }
}
