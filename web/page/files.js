// The files that come with the page: beside it on a site, or packed inside it where the page is one file.

const packed = (name) => document.getElementById(`file:${name}`);

/** Whether the page is one file that has this file in it. */
export const isInside = (name) => packed(name) !== null;

/** Whether the page is one file, which can be opened without a server. */
export const ONE_FILE = isInside("core.wasm");

export const bytesOf = (base64) => Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));

/** The bytes of a file of the page. */
export async function load(name) {
  const inside = packed(name);
  if (inside) return unpack(bytesOf(inside.textContent), "gzip", 1 << 24);
  const answer = ONE_FILE ? null : await fetch(name);
  if (!answer?.ok) throw new Error(`The page has no file ${name}; copy the whole folder of the page to the site.`);
  return new Uint8Array(await answer.arrayBuffer());
}

/** The object of a JSON file of the page. */
export async function loadJson(name) {
  return JSON.parse(new TextDecoder().decode(await load(name)));
}

/** An address from which a worklet can load a script of the page. */
export function scriptAddress(name) {
  const inside = packed(name);
  return inside ? `data:text/javascript;base64,${inside.textContent}` : name;
}

/** Unpacks a stream of the format "gzip", "deflate" or "deflate-raw" into at most `most` bytes. */
export async function unpack(bytes, format, most) {
  const reader = new Blob([bytes]).stream().pipeThrough(new DecompressionStream(format)).getReader();
  const parts = [];
  for (let size = 0; ;) {
    const { done, value } = await reader.read();
    if (done) return new Uint8Array(await new Blob(parts).arrayBuffer());
    size += value.length;
    if (size > most) {
      await reader.cancel();
      throw new Error(`a file is larger than ${most} bytes`);
    }
    parts.push(value);
  }
}

/** Lets the reader keep bytes as a file. */
export function download(bytes, name) {
  const address = URL.createObjectURL(new Blob([bytes], { type: "application/octet-stream" }));
  const link = document.createElement("a");
  link.href = address;
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}
