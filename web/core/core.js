// The core for the page: loads core.wasm, and gives its functions the types of JavaScript. The rules are in C++; this
// file moves bytes and numbers. It runs in browsers and in Node:
//
//   const core = await loadCore(await (await fetch("core.wasm")).arrayBuffer());
//   const session = core.game(entry.core, rom).play({ repeat_action_probability: 0 });  // the game's entry in the table
//   session.reset();
//   session.act(1);
//   const image = new ImageData(session.screen(), session.width, session.height);

/** The sentence of a call that failed. */
export class CoreError extends Error {}

const WIDTH = 160;
const FACTS = [
  "frame", "episodeFrame", "gameOver", "truncated", "mode", "difficulty",
  "reward", "secondReward", "lives", "secondLives", "score", "secondScore", "remembered",
];
const OUTCOMES = ["frame", "busy", "end"];

/** Loads the core from the bytes of core.wasm, or from the response of a fetch. */
export async function loadCore(source) {
  let memory;
  const imports = {
    env: { emscripten_notify_memory_growth() {} },
    wasi_snapshot_preview1: {
      proc_exit() { throw new CoreError("the core has stopped"); },
      // There are no environment variables.
      environ_sizes_get(count, size) {
        new DataView(memory.buffer).setUint32(count, 0, true);
        new DataView(memory.buffer).setUint32(size, 0, true);
        return 0;
      },
      environ_get: () => 0,
    },
  };
  const { instance } = await instantiated(source, imports);
  memory = instance.exports.memory;
  instance.exports._initialize();
  return new Core(instance.exports);
}

async function instantiated(source, imports) {
  try {
    return source instanceof Uint8Array || source instanceof ArrayBuffer
      ? await WebAssembly.instantiate(source, imports)
      : await WebAssembly.instantiateStreaming(source, imports);
  } catch (error) {
    if (typeof WebAssembly === "object" && !(error instanceof WebAssembly.CompileError)) throw error;
    throw new CoreError(
      "This browser cannot run the emulator, which needs WebAssembly with SIMD and exceptions: Chrome 95, Firefox 100, " +
      "Safari 16.4, or newer ones.");
  }
}

class Core {
  constructor(calls) {
    this.calls = calls;
  }

  get stateVersion() { return this.calls.state_version(); }
  get tableFormat() { return this.calls.table_format(); }

  /** The MD5 of a ROM image in hexadecimal digits, by which the table knows it. */
  md5(image) {
    return this.given([image], (...data) => this.text(this.calls.md5_of(...data)));
  }

  /** A game: the text `core` of its entry in the table, or of its entry for two players, and its ROM image. */
  game(text, image) {
    return new Game(this, this.given([text, image], (...data) => this.checked(this.calls.game_open(...data))));
  }

  /** A replay file, read and checked. */
  replay(bytes) {
    return new Replay(this, this.given([bytes], (...data) => this.checked(this.calls.replay_open(...data))));
  }

  // Copies texts and bytes into the core for a call, which gets an address and a size of each.
  given(values, call) {
    const all = values.map((value) => (typeof value === "string" ? new TextEncoder().encode(value) : value));
    const addresses = all.map((bytes) => this.calls.allocate(Math.max(bytes.length, 1)));
    try {
      if (addresses.includes(0)) throw new CoreError("there is not enough memory");
      all.forEach((bytes, i) => new Uint8Array(this.calls.memory.buffer).set(bytes, addresses[i]));
      return call(...all.flatMap((bytes, i) => [addresses[i], bytes.length]));
    } finally {
      addresses.forEach((address) => this.calls.release(address));
    }
  }

  // The result of a call; `failed` is an error.
  checked(result, failed = 0) {
    if (result === failed) throw new CoreError(this.errorText());
    return result;
  }

  errorText() {
    return this.text(this.calls.error_text());
  }

  // The bytes, or the text, that the last call returned.
  bytes(size) {
    const start = this.calls.result_data();
    return new Uint8Array(this.calls.memory.buffer).slice(start, start + size);
  }

  text(size) {
    return new TextDecoder().decode(this.bytes(size));
  }

  // A view of the core's memory, valid until the next call.
  view(Kind, address, length) {
    return new Kind(this.calls.memory.buffer, address, length);
  }
}

class Game {
  constructor(core, handle) {
    Object.assign(this, { core, handle });
  }

  /** Begins to play, with options as `NativeCore` has them: seed, repeat_action_probability, mode, difficulty, ... */
  play(options = {}) {
    const open = (...data) => this.core.checked(this.core.calls.session_open(this.handle, ...data));
    return new Session(this.core, this.core.given([JSON.stringify(options)], open));
  }

  /** Plays a replay of this game. */
  playReplay(replay) {
    return new Player(this.core, this.core.checked(this.core.calls.player_open(this.handle, replay.handle)));
  }

  close() {
    this.core.calls.game_close(this.handle);
  }
}

/** A game in play. Arrays that it returns are views, valid until the next call. */
class Session {
  constructor(core, handle) {
    Object.assign(this, { core, handle });
    this.height = core.calls.session_height(handle);
    this.width = WIDTH;
    this.buffer = core.calls.allocate(Math.max(4 * WIDTH * this.height, 1 << 14));
  }

  seed(seed) { this.call("seed", seed); }
  reset() { this.call("reset"); }
  setMode(mode) { this.call("mode", mode); }
  setDifficulty(difficulty) { this.call("difficulty", difficulty); }
  poke(index, value) { this.call("poke", index, value); }
  removeWrite(slot) { this.call("remove_write", slot); }
  budget(bytes) { this.core.calls.session_budget(this.handle, bytes); }

  /** Plays a frame with an action of each player, 0 to 17; returns false after the end of the game. */
  act(first, second = 0, strength = 1) {
    return this.core.checked(this.core.calls.session_act(this.handle, first, second, strength), -1) === 1;
  }

  /** Adds a write, an object as `Write.definition` in JSON, and returns its slot. */
  addWrite(definition, now = false) {
    const text = typeof definition === "string" ? definition : JSON.stringify(definition);
    return this.core.given([text], (...data) =>
      this.core.checked(this.core.calls.session_add_write(this.handle, ...data, now), -1));
  }

  /** Frame numbers, score, lives and ends: an object with the names in `FACTS`. */
  facts() {
    this.core.calls.session_facts(this.handle, this.buffer);
    const numbers = this.core.view(Int32Array, this.buffer, FACTS.length);
    const facts = Object.fromEntries(FACTS.map((name, i) => [name, numbers[i]]));
    return { ...facts, gameOver: facts.gameOver === 1, truncated: facts.truncated === 1 };
  }

  /** The screen as RGBA, for an `ImageData` of width x height. */
  screen() {
    this.core.calls.session_screen(this.handle, this.buffer);
    return this.core.view(Uint8ClampedArray, this.buffer, 4 * WIDTH * this.height);
  }

  /** The screen after `frames` more frames with these actions; nothing else changes. */
  screenAhead(frames, first, second = 0) {
    this.core.checked(this.core.calls.session_screen_ahead(this.handle, first, second, frames, this.buffer));
    return this.core.view(Uint8ClampedArray, this.buffer, 4 * WIDTH * this.height);
  }

  /** The screen as indices of the palette. */
  framebuffer() {
    this.core.calls.session_framebuffer(this.handle, this.buffer);
    return this.core.view(Uint8Array, this.buffer, WIDTH * this.height);
  }

  /** The 128 bytes of RAM. */
  ram() { return this.core.view(Uint8Array, this.core.calls.session_ram(this.handle), 128); }

  /** The 512 samples of the last frame, unsigned around 128, at 31400 Hz. */
  audio() { return this.core.view(Uint8Array, this.core.calls.session_audio(this.handle), 512); }

  /** The values of the game's `count` labels, null where one is not visible. */
  labels(count) {
    this.core.calls.session_labels(this.handle, this.buffer, this.buffer + 4 * count);
    const visible = this.core.view(Uint8Array, this.buffer + 4 * count, count);
    return Array.from(this.core.view(Int32Array, this.buffer, count), (value, i) => (visible[i] ? value : null));
  }

  /** The places of the game's `count` objects, null where one is not visible; x or y is null if it is not known. */
  objects(count) {
    this.core.calls.session_objects(this.handle, this.buffer);
    const numbers = this.core.view(Int32Array, this.buffer, 3 * count);
    const known = (value) => (value === -(2 ** 31) ? null : value);
    return Array.from({ length: count }, (_, i) =>
      numbers[3 * i] ? { x: known(numbers[3 * i + 1]), y: known(numbers[3 * i + 2]) } : null);
  }

  /** The byte that gives a label a value, or -1. */
  byteOf(label, value) { return this.core.calls.session_byte_of(this.handle, label, value); }

  /** The whole state as the bytes of `NativeCore.snapshot()`. */
  snapshot() { return this.core.bytes(this.core.checked(this.core.calls.session_snapshot(this.handle))); }

  restore(bytes) {
    this.core.given([bytes], (...data) => this.core.checked(this.core.calls.session_restore(this.handle, ...data)));
  }

  /** Keeps the present state, to which `goBack` returns. */
  remember() { this.call("remember"); }

  /** Returns to the newest kept state, and drops it; false if there is none. */
  goBack() { return this.core.checked(this.core.calls.session_go_back(this.handle), -1) === 1; }

  /** Records from now on; `release` is the version of the package that the file names. */
  record(release) {
    this.core.given([release], (...data) => this.core.checked(this.core.calls.session_record(this.handle, ...data)));
  }

  /** The bytes of a replay file of all that was recorded. */
  replay() { return this.core.bytes(this.core.checked(this.core.calls.session_replay(this.handle))); }

  close() {
    this.core.calls.release(this.buffer);
    this.core.calls.session_close(this.handle);
  }

  call(name, ...values) {
    return this.core.checked(this.core.calls[`session_${name}`](this.handle, ...values));
  }
}

class Replay {
  constructor(core, handle) {
    Object.assign(this, { core, handle });
    this.frames = core.calls.replay_frames(handle) >>> 0;
    this.header = JSON.parse(core.text(core.calls.replay_header(handle)));
    this.end = JSON.parse(core.text(core.calls.replay_end(handle)));
  }

  close() { this.core.calls.replay_close(this.handle); }
}

/** A replay in play. `session` shows the present frame. */
class Player {
  constructor(core, handle) {
    Object.assign(this, { core, handle });
    this.session = new Session(core, core.calls.player_session(handle));
  }

  /** Frames played so far. */
  get frame() { return this.core.calls.player_frame(this.handle) >>> 0; }

  /** The actions of the last frame. */
  get actions() { return [0, 1].map((which) => this.core.calls.player_action(this.handle, which)); }

  /** Plays until the next frame: "frame", "end", or "busy" after about `budget` frames' time without one. */
  advance(budget = 100) {
    return OUTCOMES[this.core.checked(this.core.calls.player_advance(this.handle, budget), -1)];
  }

  /** Goes to the state after `frame` frames; false if the budget was too small, and the same call goes on. */
  seek(frame, budget = 1000) {
    return this.core.checked(this.core.calls.player_seek(this.handle, frame, budget), -1) === 1;
  }

  /** The first difference from the hashes of the file, {frame, what}; null if there is none so far. */
  get difference() {
    const size = this.core.calls.player_difference(this.handle);
    const frame = this.core.calls.player_differing_frame(this.handle) >>> 0;
    return size ? { frame, what: this.core.text(size) } : null;
  }

  /** A player that records. Seek it to a frame, then `takeSession` goes on from there, and can go back for a minute. */
  recorded(release, frame) {
    return new Player(this.core, this.core.given([release], (...data) =>
      this.core.checked(this.core.calls.player_recorded(this.handle, ...data, frame))));
  }

  /** Closes the player, and returns its session. */
  takeSession() {
    this.core.calls.release(this.session.buffer);
    return new Session(this.core, this.core.calls.player_take_session(this.handle));
  }

  close() {
    this.core.calls.release(this.session.buffer);
    this.core.calls.player_close(this.handle);
  }
}
