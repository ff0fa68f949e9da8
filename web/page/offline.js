// Play without a network after the first visit of the site: worker.js keeps the files.

import { ONE_FILE } from "./files.js";

const TABLE = "table/table.json.gz"; // all games
const idle = window.requestIdleCallback ?? ((call) => setTimeout(call, 2000));

export async function keepOffline() {
  if (ONE_FILE) return;
  try {
    const { serviceWorker } = navigator; // a frame may forbid it
    await serviceWorker.register("worker.js");
    const { active } = await serviceWorker.ready;
    // The first visit has loaded its files before the worker was there.
    const loaded = performance.getEntriesByType("resource").map(({ name }) => name);
    idle(() => active.postMessage([...loaded, new URL(TABLE, location.href).href]));
  } catch {
    // The page plays while there is a network.
  }
}
