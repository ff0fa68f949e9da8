// The table of games, which atari/web/table.py writes. The entry of a game is loaded when the game is played.

import { isInside, loadJson, ONE_FILE } from "./files.js";

export class Table {
  #entries = new Map();

  static async load() {
    const table = new Table();
    table.index = await loadJson("table/index.json");
    table.byMd5 = new Map(Object.entries(table.index.games).map(([id, { md5 }]) => [md5, id]));
    return table;
  }

  has(id) { return Object.hasOwn(this.index.games, id); }
  title(id) { return this.index.games[id].title; }

  /** The entry of a game. */
  async entry(id) {
    if (!this.#entries.has(id)) {
      const name = `table/games/${id}.json`;
      const found = ONE_FILE && !isInside(name) ? await this.#whole(id) : await loadJson(name);
      this.#entries.set(id, found);
    }
    return this.#entries.get(id);
  }

  async #whole(id) {
    const { games } = await loadJson("table/table.json");
    for (const entry of games) this.#entries.set(entry.id, entry);
    return this.#entries.get(id);
  }
}
