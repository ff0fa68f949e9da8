// Links that the page gives, and those that it follows. A link that has been followed leaves the address, so that a reload
// goes on from where the reader is.

import { h } from "./dom.js";
import { linkToMoment, linkToReplay, readLink } from "./link.js";
import { Play } from "./play.js";

export class Links {
  constructor(app) {
    this.app = app;
    this.element = h("input", { class: "address", readOnly: true, hidden: true, "aria-label": "Link" });
    window.addEventListener("hashchange", () => app.attempt(() => this.follow()));
  }

  /** Follows the link in the address, if there is one. */
  async follow() {
    const link = readLink(location.hash);
    if (!link) return;
    history.replaceState(null, "", location.href.split("#")[0]);
    await this.#show(link);
  }

  async #show(link) {
    const { app } = this;
    if (link.replay) return app.watch(link.replay);
    app.waiting = app.library.rom(link.game) ? null : () => this.#show(link);
    if (!link.state) return app.choose(link.game);
    app.show(Play.begin(...(await app.load(link.game)), link.settings, link.state));
    app.showView(link);
    app.setPaused(true);
    app.say("This is the moment of the link: press Play, or P.");
  }

  giveReplay() {
    const { play, replayBytes } = this.app;
    return this.#give(linkToReplay(play.isReplay ? replayBytes : play.session.replay()));
  }

  giveMoment() {
    const { app } = this;
    app.setPaused(true);
    return this.#give(linkToMoment(app.play, app.speed, app.openPanels()));
  }

  async #give(address) {
    this.element.value = address;
    this.element.hidden = false;
    this.element.select();
    const size = `The link has ${address.length} letters`;
    this.app.say(`${size}; it is selected, to be copied.`);
    const copied = navigator.clipboard?.writeText(address);
    await copied?.then(() => this.app.say(`${size}; it is copied.`), () => {}); // a browser may refuse
  }
}
