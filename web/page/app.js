// The page: it puts the parts together, and does what controls, keys and files say.

import { Controls } from "./controls.js";
import { button, h, setText } from "./dom.js";
import { download } from "./files.js";
import { GamePanel } from "./gamepanel.js";
import { Input } from "./input.js";
import { Keeper } from "./keeper.js";
import { Links } from "./links.js";
import { Loop } from "./loop.js";
import { openFiles } from "./opening.js";
import { Play, settingsOf } from "./play.js";
import { RamPanel } from "./ram.js";
import { ReplayBar } from "./replays.js";
import { Shelf } from "./shelf.js";
import { Sound } from "./sound.js";
import { Stage } from "./stage.js";
import { savedState, saveState } from "./store.js";

const KEEP_EVERY = 600; // frames
const pause = () => new Promise((resolve) => setTimeout(resolve));

export class App {
  play = null;
  paused = false;
  over = false;
  speed = 1;
  ahead = 0;
  rewinding = false;
  objectsShown = false;
  seeking = null; // the frame of a replay to which the page goes
  waiting = null; // {game, call}: a link, or a replay, that needs the ROM of a game
  replayBytes = null;
  #kept = 0;

  constructor(core, table, library, replays) {
    Object.assign(this, { core, table, library });
    this.sound = new Sound();
    this.input = new Input();
    this.stage = new Stage();
    this.controls = new Controls(this);
    this.bar = new ReplayBar(this);
    this.ram = new RamPanel(this);
    this.gamePanel = new GamePanel(this);
    this.links = new Links(this);
    this.shelf = new Shelf(this, replays);
    this.keeper = new Keeper(this);
    this.panels = [this.gamePanel.element, this.ram.element, this.controls.help];
    this.loop = new Loop(() => this.#runs, () => this.#frame(), () => this.#draw());
    this.#build();
    this.#listen();
  }

  #build() {
    const open = "ROM files, a zip or wheel with ROMs, or a replay; or drop them on the page";
    this.games = h("select", { "aria-label": "Game", onchange: () => this.attempt(() => this.choose(this.games.value)) });
    this.file = h("input", { type: "file", multiple: true, class: "hidden", tabIndex: -1, "aria-hidden": "true" });
    this.file.addEventListener("change", () => this.openFiles([...this.file.files]));
    this.facts = h("div", { class: "facts" });
    this.message = h("p", { class: "message", role: "status" });
    document.querySelector("main").replaceChildren(
      h("header", {}, h("h1", {}, "Atari"), this.games, this.shelf.element,
        button("Open files ...", open, () => this.file.click()),
        button("Empty the library", "Forget all ROM files", () => this.attempt(() => this.emptyLibrary())), this.file),
      this.stage.element, h("div", { class: "line below" }, this.facts, this.message, this.keeper.element), this.links.element, this.bar.element,
      this.input.touch.element, this.controls.element, h("div", { class: "panels" }, ...this.panels),
      h("footer", {}, "Files that you open stay in this browser. ",
        "Drop ROM files, a zip, a wheel of ale-py or a replay anywhere on the page."));
  }

  #listen() {
    for (const name of ["pointerup", "keydown"]) document.addEventListener(name, () => this.#wakeSound());
    this.#giveKeysBack();
    document.addEventListener("dragover", (event) => event.preventDefault());
    document.addEventListener("drop", (event) => {
      event.preventDefault();
      this.openFiles([...event.dataTransfer.files]);
    });
  }

  #wakeSound() {
    if (this.sound.on && this.sound.state !== "running") this.sound.start().catch((error) => this.say(error.message));
  }

  // After a use of the mouse, keys play and do not press the button again.
  #giveKeysBack() {
    let pointer = false;
    document.addEventListener("pointerdown", () => { pointer = true; });
    document.addEventListener("keydown", () => { pointer = false; });
    const give = (kinds) => ({ target }) => {
      if (pointer && target.closest(kinds)) this.stage.element.focus({ preventScroll: true });
    };
    document.addEventListener("click", give("button:not(.cell), summary"));
    document.addEventListener("change", give("select, input:not([type=number])"));
  }

  /** Says a sentence, as text. */
  say(text) { setText(this.message, text); }

  /** Calls, and says the sentence of an error. */
  async attempt(call) {
    this.say("");
    try {
      await call();
    } catch ({ message }) {
      this.say(`${message[0].toUpperCase()}${message.slice(1)}${message.endsWith(".") ? "" : "."}`);
    }
  }

  // Frames

  get #runs() { return this.play !== null && this.seeking === null && (!this.paused || this.rewinding); }

  #frame() {
    if (this.rewinding) {
      this.play.goBack();
      this.over = false;
      return;
    }
    if (!this.play.advance(this.input.actions())) return this.#end();
    this.sound.push(this.play.session.audio());
    this.#kept += 1;
    if (this.#kept % KEEP_EVERY === 0) this.keeper.keep();
  }

  #end() {
    this.over = true;
    if (this.play.isReplay) this.setPaused(true);
  }

  #draw() {
    const { play, stage } = this;
    if (!play) return;
    const ahead = this.paused || this.rewinding ? 0 : this.ahead;
    stage.draw(0, play.screen(ahead, this.input.actions()), this.objectsShown ? this.#objects() : []);
    if (play.fork) stage.draw(1, play.fork.screen(), []);
    const { score, lives, secondScore } = play.session.facts();
    const points = play.players > 1 ? `Score ${score} : ${secondScore}` : `Score ${score}`;
    setText(this.facts, `${points}   Lives ${lives}${this.over && !play.isReplay ? "   Game over: press Enter" : ""}`);
    for (const part of [this.controls, this.bar, this.ram]) part.draw(this);
    if (!performance.getEntriesByName("first-frame").length) performance.mark("first-frame");
  }

  #objects() {
    const { entry, objects } = this.play;
    return entry.objects.flatMap(({ name, width, height }, i) =>
      objects[i] ? [[name, objects[i].x, objects[i].y, width, height]] : []);
  }

  // Games

  /** Shows a play in place of the present one. */
  show(play) {
    this.keeper.putAside();
    this.play?.close();
    this.shelf.mark(null);
    Object.assign(this, { play, over: false, seeking: null });
    this.input.players = play.players;
    this.#pace();
    this.#prepare();
    if (this.ram.entry !== play.entry) for (const panel of [this.ram, this.gamePanel]) panel.show(play.entry);
    this.#listGames();
    document.title = `${play.entry.title}: Atari games`;
  }

  #prepare() {
    const { play } = this;
    this.stage.prepare(play.session.height, play.fork ? [play.entry.title, "Fork"] : [play.entry.title]);
  }

  #listGames() {
    const now = this.play?.entry.id;
    if (now === undefined) return;
    const ids = this.library.rom(now) ? this.library.ids : [now, ...this.library.ids]; // a film has no ROM
    this.games.replaceChildren(...ids.map((id) => h("option", { value: id }, this.table.title(id))));
    this.games.value = now;
  }

  #pace() {
    this.loop.rate = this.play.rate * this.speed;
    this.sound.pace(this.loop.rate);
  }

  async load(id) {
    if (!this.table.has(id)) throw new Error("The page has no such game.");
    const rom = this.library.rom(id);
    if (!rom) throw new Error(`This needs the ROM of ${this.table.title(id)}: drop its file on the page.`);
    return [this.core, await this.table.entry(id), rom];
  }

  async choose(id) {
    const loaded = await this.load(id);
    this.show(Play.begin(...loaded, settingsOf(loaded[1], 1)));
    this.setPaused(false);
  }

  /** Begins a game whose ROM comes with the page. */
  async chooseOwn() {
    const [id] = this.library.own;
    if (id === undefined) throw new Error("This page has no game of its own: drop a ROM file on it.");
    await this.choose(id);
  }

  /** Begins a new game with settings. */
  async restart(settings) {
    this.show(Play.begin(...(await this.load(this.play.entry.id)), settings));
    this.setPaused(false);
  }

  newGame() {
    if (this.play.isReplay) return;
    this.play.newGame();
    this.over = false;
    this.#prepare();
    this.setPaused(false);
  }

  async openFiles(files) {
    await this.attempt(async () => {
      const { ids, replay, problems } = await openFiles(files, this.library);
      this.#listGames();
      try {
        if (ids.length) await this.library.keep(ids);
      } catch (error) {
        problems.push(error.message);
      }
      if (replay) await this.watch(replay);
      else if (ids.includes(this.waiting?.game)) await this.waiting.call();
      else if (this.play?.isFilm && ids.includes(this.play.entry.id)) await this.#playFilmed();
      else if (ids.length) await this.choose(ids[0]);
      if (ids.length > 1) problems.unshift(`${ids.length} games are in the library.`);
      if (problems.length) this.say(problems.join(" "));
    });
    this.file.value = "";
  }

  async emptyLibrary() {
    await this.library.empty();
    if (!this.play.isFilm && !this.library.rom(this.play.entry.id)) await this.chooseOwn();
    this.#listGames();
    this.say("The library is empty.");
  }

  // Replays

  /** Makes a call when the reader has given the ROM of a game, if it is missing. */
  waitFor(game, call) { this.waiting = this.library.rom(game) ? null : { game, call }; }

  /** Plays a replay. Where its ROM is missing, it waits for it. */
  async watch(bytes) {
    const replay = this.core.replay(bytes);
    this.waitFor(replay.header.game, () => this.watch(bytes));
    try {
      this.show(Play.watch(...(await this.load(replay.header.game)), replay));
    } catch (error) {
      replay.close();
      throw error;
    }
    this.replayBytes = bytes;
    this.setPaused(false);
  }

  // The ROM of the film is there: its replay takes over at the same frame.
  async #playFilmed() {
    const { paused } = this;
    await this.shelf.show(this.shelf.shown, this.play.frame);
    this.setPaused(paused);
  }

  /** Begins a new game in place of a replay; without its ROM, of a game whose ROM comes with the page. */
  closeReplay() {
    const { id } = this.play.entry;
    return this.library.rom(id) ? this.choose(id) : this.chooseOwn();
  }

  async goOn(frame = this.play.frame) {
    this.seeking = frame;
    await this.attempt(async () => {
      await this.play.goOn(frame, pause);
      this.shelf.mark(null);
    });
    this.seeking = null;
    this.over = false;
    this.setPaused(false);
  }

  async seek(frame) {
    const busy = this.seeking !== null;
    const { play } = this;
    this.seeking = frame;
    if (busy) return;
    await this.attempt(async () => {
      for (let done = false; !done && this.play === play;) {
        const to = this.seeking;
        done = play.seek(to) && to === this.seeking;
        if (!done) await pause();
      }
    });
    if (this.play === play) this.seeking = null;
  }

  saveReplay() { download(this.play.session.replay(), `${this.play.entry.id}.a26r`); }

  openPanels() { return this.panels.filter((panel) => panel.open).map((panel) => panel.id); }

  /** Shows the panels, the speed and the run-ahead of a link, or of an earlier visit. */
  showView({ speed, panels, ahead = this.ahead }) {
    if (speed >= 0.25 && speed <= 8) this.setSpeed(speed);
    this.ahead = [0, 1, 2].includes(ahead) ? ahead : 0;
    for (const panel of this.panels) panel.open = panels.includes(panel.id);
  }

  // Controls. An error is said by `attempt`, which calls these.

  setPaused(paused) { this.paused = paused; }
  togglePause() { this.setPaused(!this.paused); }
  setAhead(frames) { this.ahead = frames; }
  toggleObjects() { this.objectsShown = !this.objectsShown; }

  setSpeed(speed) {
    this.speed = speed;
    this.#pace();
  }

  stepFrame() {
    this.setPaused(true);
    this.#frame();
  }

  toggleSound() {
    this.sound.on = !this.sound.on;
    return this.sound.on ? this.sound.start() : null;
  }

  saveState() {
    if (this.play.isReplay) return;
    saveState(this.play);
    this.say("The state is saved.");
  }

  loadState() {
    if (this.play.isReplay) return;
    const state = savedState(this.play);
    if (!state) throw new Error("There is no saved state of this game.");
    this.play.session.restore(state);
    this.over = false;
  }

  // RAM

  poke(index, value) { this.play.changes.poke(index, value); }
  undo() { this.play.changes.undo(); }

  toggleFreeze(index, value) {
    const { changes } = this.play;
    if (changes.has(String(index))) changes.remove(String(index));
    else changes.freeze(index, value);
  }

  toggleIntervention(name, writes) {
    const { changes } = this.play;
    if (changes.has(name)) changes.remove(name);
    else changes.add(name, writes);
  }

  toggleFork() {
    if (this.play.isReplay) return;
    if (this.play.fork) this.play.dropFork();
    else this.play.makeFork();
    this.#prepare();
  }
}
