// The start of the page: it loads the core and the table, and shows what the link says, what was played, a replay of the
// shelf, or a game whose ROM comes with the page.

import { App } from "./app.js";
import { loadCore } from "./core.js";
import { h } from "./dom.js";
import { load } from "./files.js";
import { Library } from "./library.js";
import { keepOffline } from "./offline.js";
import { readShelf } from "./shelf.js";
import { Table } from "./table.js";

async function start() {
  if (typeof WebAssembly !== "object") throw new Error("This browser has no WebAssembly, which the emulator needs.");
  const readPage = async () => {
    const { replays, roms } = await readShelf();
    return [replays, await Promise.all(roms.map(load))];
  };
  const [core, table, [replays, roms]] = await Promise.all([load("core.wasm").then(loadCore), Table.load(), readPage()]);
  const library = new Library(core, table);
  for (const rom of roms) library.addOwn(rom);
  await library.open();
  const app = new App(core, table, library, replays);
  window.atariPage = app; // for tests, and for readers who program
  const linked = location.hash.length > 1;
  const ways = [
    () => app.keeper.start(linked),
    () => app.links.follow(),
    () => replays.length > 0 && app.shelf.show(replays[0].name),
    () => app.chooseOwn(),
  ];
  const said = [];
  for (const way of ways) {
    if (app.play) break;
    await app.attempt(way);
    said.push(app.message.textContent);
  }
  app.say(said.filter(Boolean).join(" "));
  await keepOffline();
}

start().catch(({ message }) => {
  document.querySelector("main").replaceChildren(h("p", { class: "starting", role: "alert" }, message));
});
