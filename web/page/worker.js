// The service worker of the site: after the first visit the page plays without a network. What has changed on the site is
// taken at the next visit with one.

const CACHE = "atari-envs";

self.addEventListener("install", (event) => event.waitUntil(fill()));
self.addEventListener("activate", (event) => event.waitUntil(self.clients.claim()));
self.addEventListener("fetch", (event) => {
  const { method, url } = event.request;
  if (method === "GET" && url.startsWith(self.registration.scope)) event.respondWith(answer(event.request));
});

async function fill() {
  const files = await (await fetch("files.json")).json();
  await (await caches.open(CACHE)).addAll(files);
  await self.skipWaiting();
}

// The network first, so that page and core are always of one release.
async function answer(request) {
  const cache = await caches.open(CACHE);
  try {
    const found = await fetch(request);
    if (found.ok) await cache.put(request, found.clone());
    return found;
  } catch (error) {
    const kept = await cache.match(request, { ignoreSearch: true });
    if (kept) return kept;
    throw error;
  }
}
