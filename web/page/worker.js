// The service worker of the site: after the first visit the page plays without a network. What has changed on the site is
// taken at the next visit with one.

const CACHE = "atari-envs";
const TABLE = "table/table.json.gz"; // all games
const ENTRY = /^table\/games\/(\w+)\.json$/;

self.addEventListener("install", (event) => event.waitUntil(fill()));
self.addEventListener("activate", (event) => event.waitUntil(self.clients.claim()));
self.addEventListener("fetch", (event) => {
  const { method, url } = event.request;
  if (method === "GET" && ofSite(url)) event.respondWith(answer(event.request));
});
self.addEventListener("message", (event) => event.waitUntil(keep(event.data)));

const ofSite = (address) => address.startsWith(self.registration.scope);

async function fill() {
  const files = await (await fetch("files.json")).json();
  await (await caches.open(CACHE)).addAll(files);
  await self.skipWaiting();
}

// Keeps what the page names in idle time.
async function keep(addresses) {
  const cache = await caches.open(CACHE);
  await Promise.allSettled(addresses.filter(ofSite).map((address) => cache.add(address)));
}

// The network first, so that page and core are always of one release.
async function answer(request) {
  const cache = await caches.open(CACHE);
  try {
    const found = await fetch(request);
    if (found.ok) await cache.put(request, found.clone());
    return found;
  } catch (error) {
    const kept = (await cache.match(request, { ignoreSearch: true })) ?? (await entryOf(request, cache));
    if (kept) return kept;
    throw error;
  }
}

// The entry of a game that was never played, from the table of all games.
async function entryOf({ url }, cache) {
  const id = ENTRY.exec(url.slice(self.registration.scope.length))?.[1];
  const kept = id && (await cache.match(TABLE));
  if (!kept) return null;
  const bytes = new Uint8Array(await kept.arrayBuffer());
  const packed = bytes[0] === 0x1f && bytes[1] === 0x8b; // some servers unpack it
  const stream = new Blob([bytes]).stream();
  const { games } = await new Response(packed ? stream.pipeThrough(new DecompressionStream("gzip")) : stream).json();
  const entry = games.find((game) => game.id === id);
  return entry ? new Response(JSON.stringify(entry), { headers: { "Content-Type": "application/json" } }) : null;
}
