// Keeps the game in play when the page is left, and goes on from there: a reload loses nothing.

import { keepNow, keptNow } from "./store.js";

export class Keeper {
  #full = false;

  constructor(app) {
    this.app = app;
    document.addEventListener("visibilitychange", () => document.hidden && this.keep());
    window.addEventListener("pagehide", () => this.keep());
  }

  keep() {
    const { app } = this;
    const { play, speed, ahead, paused } = app;
    if (!play || app.seeking !== null) return;
    const view = { speed, ahead, paused, panels: app.openPanels(), sound: app.sound.on };
    try {
      keepNow(play, play.isReplay ? app.replayBytes : play.session.replay(), view);
      this.#full = false;
    } catch (error) {
      if (!this.#full) app.say(error.message); // once, and not every few seconds
      this.#full = true;
    }
  }

  /** Goes on from what was kept, if there is anything. */
  async goOn() {
    const { app } = this;
    const kept = keptNow();
    if (!kept || !app.library.rom(kept.game)) return;
    await app.watch(kept.replay);
    const watching = kept.state === undefined;
    await app.seek(watching ? kept.frame : app.play.frames);
    if (!watching) await this.#goOnByHand(kept);
    app.showView(kept.view);
    app.sound.on = kept.view.sound;
    app.setPaused(kept.view.paused);
  }

  async #goOnByHand({ state, changes }) {
    const { app } = this;
    await app.goOn();
    const { session } = app.play;
    const now = session.snapshot();
    // A poke after the last frame is in the state alone.
    if (now.length !== state.length || now.some((byte, i) => byte !== state[i])) session.restore(state);
    app.play.changes.takeOver(changes);
  }
}
