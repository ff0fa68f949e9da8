// The shelf: replays that come with the page, and ROMs of its author's own games. shelf.json lists them.

import { h } from "./dom.js";
import { load } from "./files.js";
import { Film } from "./film.js";

/** Reads shelf.json: {replays, roms}. A page without one has no replays, and the ROM of `catch`. */
export async function readShelf() {
  const bytes = await load("shelf.json").catch(() => null);
  return bytes ? JSON.parse(new TextDecoder().decode(bytes)) : { replays: [], roms: ["catch.bin"] };
}

export class Shelf {
  /** The name of the replay that the page shows, or null. */
  shown = null;

  constructor(app, replays) {
    Object.assign(this, { app, replays });
    this.element = h("select", { "aria-label": "Replays", hidden: replays.length === 0 },
      h("option", { value: "", disabled: true }, "Replays"),
      ...replays.map(({ name, title }) => h("option", { value: name }, title)));
    this.element.addEventListener("change", () => app.attempt(() => this.show(this.element.value)));
    this.mark(null);
  }

  /** A text that pages with the same replays share. */
  get key() { return this.replays.map(({ name }) => name).join(","); }

  mark(name) {
    this.shown = name;
    this.element.value = name ?? "";
  }

  /** Shows a replay from a frame. Where its ROM is missing, its film plays. */
  async show(name, frame = 0) {
    const { app } = this;
    const found = this.replays.find((one) => one.name === name);
    if (!found) throw new Error(`The page has no replay ${name}.`);
    try {
      if (found.film && !app.library.rom(found.game))
        app.show(await Film.open(found, await app.table.entry(found.game)));
      else await app.watch(await load(found.replay));
      this.shown = name;
    } finally {
      this.mark(this.shown); // after an error the choice names what is still there
    }
    app.setPaused(false);
    if (frame) await app.seek(frame);
  }
}
