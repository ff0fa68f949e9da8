// The library: the reader's ROM files, kept by the browser and sent nowhere. Their MD5 says which games they are.

const STORE = "roms";
export const MOST_ROM = 512 * 1024;

const done = (request) => new Promise((resolve, reject) => {
  request.onsuccess = () => resolve(request.result);
  request.onerror = () => reject(request.error);
});

async function openDatabase() {
  const request = indexedDB.open("atari-envs", 1);
  request.onupgradeneeded = () => request.result.createObjectStore(STORE);
  return done(request);
}

export class Library {
  own = []; // the ids of the games whose ROMs come with the page
  #roms = new Map(); // by the id of the game
  #database = null;

  constructor(core, table) {
    Object.assign(this, { core, table });
  }

  /** Adds the ROMs that the browser has kept. Without storage the library lasts as long as the page. */
  async open() {
    try {
      this.#database = await openDatabase();
      const kept = await done(this.#store("readonly").getAll());
      for (const bytes of kept) this.#take(bytes);
    } catch {
      this.#database = null;
    }
  }

  #store(mode) { return this.#database.transaction(STORE, mode).objectStore(STORE); }

  #take(bytes) {
    const id = this.table.byMd5.get(this.core.md5(bytes));
    if (id) this.#roms.set(id, bytes);
    return id;
  }

  /** Adds a ROM that comes with the page. */
  addOwn(bytes) {
    const id = this.#take(bytes);
    if (id) this.own.push(id);
  }

  /** Adds a ROM, and returns the id of its game; undefined if its bytes are of no game in the table. */
  add(bytes) { return this.#take(bytes); }

  /** Keeps the ROMs of some games for later visits. */
  async keep(ids) {
    if (!this.#database) throw new Error("This browser keeps no files; the games are here until you close the page.");
    try {
      const store = this.#store("readwrite");
      await Promise.all(ids.map((id) => done(store.put(this.#roms.get(id), id))));
    } catch {
      throw new Error("The browser's storage is full; the games are here until you close the page.");
    }
  }

  rom(id) { return this.#roms.get(id); }

  /** The ids of the games that can be played, by title. */
  get ids() {
    return [...this.#roms.keys()].sort((one, other) => this.table.title(one).localeCompare(this.table.title(other)));
  }

  /** Forgets all ROMs but those of the page. */
  async empty() {
    for (const id of [...this.#roms.keys()]) if (!this.own.includes(id)) this.#roms.delete(id);
    if (this.#database) await done(this.#store("readwrite").clear());
  }
}
