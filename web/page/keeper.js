// Keeps the game in play when the page is left, and goes on from there: a reload loses nothing. It also keeps the games
// that a link or a file has replaced, and gives them back.

import { button } from "./dom.js";
import { bytesOf } from "./files.js";
import { base64Of } from "./link.js";
import { read, write } from "./store.js";

const MOST_ASIDE = 8;

export class Keeper {
  #full = false;
  #aside = []; // games that were replaced, newest last, as `#present` describes them

  constructor(app) {
    this.app = app;
    this.name = `atari-envs:now${app.shelf.key && ":"}${app.shelf.key}`;
    // A frame of another page shows what that page says. It keeps nothing, so that several frames do not mix their games.
    this.keeps = window === window.top;
    this.element = button("Back to your game", "Go on with the game that was replaced", () => app.attempt(() => this.back()),
      { hidden: true });
    document.addEventListener("visibilitychange", () => document.hidden && this.keep());
    window.addEventListener("pagehide", () => this.keep());
  }

  keep() {
    const { app } = this;
    if (!this.keeps || !app.play || app.seeking !== null) return;
    try {
      write(this.name, { now: this.#present(), aside: this.#aside });
      this.#full = false;
    } catch (error) {
      if (!this.#full) app.say(error.message); // once, and not every few seconds
      this.#full = true;
    }
  }

  // What the page shows, as a value of JSON.
  #present() {
    const { play, replayBytes, shelf, speed, ahead, paused, sound } = this.app;
    const view = { speed, ahead, paused, panels: this.app.openPanels(), sound: sound.on };
    if (shelf.shown) return { show: shelf.shown, frame: play.frame, view };
    if (play.isReplay) return { replay: base64Of(replayBytes), frame: play.frame, view };
    const { session, changes, isPlayed } = play;
    return { replay: base64Of(session.replay()), state: base64Of(session.snapshot()), changes: changes.kept, isPlayed, view };
  }

  /** Puts the game in play aside, if the reader has played it: something else takes its place. */
  putAside() {
    if (this.app.play?.isPlayed) this.#setAside([...this.#aside, this.#present()]);
  }

  #setAside(games) {
    this.#aside = games.slice(-MOST_ASIDE);
    this.element.hidden = games.length === 0;
  }

  /** Goes on from what an earlier visit has kept. Unless `linked`, the page shows it at once. */
  async start(linked) {
    const { now, aside = [] } = (this.keeps && read(this.name)) || {};
    this.#setAside(now?.isPlayed ? [...aside, now] : aside);
    if (now && !linked) await this.#goOn(now);
  }

  /** Gives the newest game back that was put aside. */
  async back() {
    await this.#goOn(this.#aside.at(-1));
    this.app.setPaused(true);
    this.app.say("This is your game: press Play, or P.");
  }

  async #goOn(kept) {
    const { app } = this;
    if (kept.show) {
      await app.shelf.show(kept.show, kept.frame);
    } else {
      await app.watch(bytesOf(kept.replay));
      if (kept.state) await this.#goOnByHand(kept);
      else await app.seek(kept.frame);
    }
    this.#setAside(this.#aside.filter((one) => one !== kept));
    app.showView(kept.view);
    app.sound.on = kept.view.sound;
    app.setPaused(kept.view.paused);
  }

  async #goOnByHand({ state, changes, isPlayed }) {
    const { app } = this;
    await app.goOn(app.play.frames);
    const { play } = app;
    // A poke after the last frame is in the state alone.
    if (base64Of(play.session.snapshot()) !== state) play.session.restore(bytesOf(state));
    play.changes.takeOver(changes);
    play.acted = isPlayed;
  }
}
