// The start of the page: it loads the core and the table, and shows what the link says, what was played, or `catch`.

import { App, OWN } from "./app.js";
import { loadCore } from "./core.js";
import { h } from "./dom.js";
import { load, ONE_FILE } from "./files.js";
import { Library } from "./library.js";
import { Table } from "./table.js";

async function start() {
  if (typeof WebAssembly !== "object") throw new Error("This browser has no WebAssembly, which the emulator needs.");
  const [core, table, rom] = await Promise.all([load("core.wasm").then(loadCore), Table.load(), load("catch.bin")]);
  const library = new Library(core, table);
  library.add(rom);
  await library.open();
  const app = new App(core, table, library);
  window.atariPage = app; // for tests, and for readers who program
  await app.attempt(async () => {
    if (location.hash.length > 1) await app.links.follow();
    else await app.keeper.goOn();
  });
  if (!app.play) {
    const problem = app.message.textContent;
    await app.choose(OWN);
    app.say(problem);
  }
  if (!ONE_FILE && "serviceWorker" in navigator) navigator.serviceWorker.register("worker.js").catch(() => {});
}

start().catch(({ message }) => {
  document.querySelector("main").replaceChildren(h("p", { class: "starting", role: "alert" }, message));
});
