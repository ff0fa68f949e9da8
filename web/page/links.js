// Links that the page gives, and those that it follows. A link that has been followed leaves the address, so that a reload
// goes on from where the reader is.

import { h } from "./dom.js";
import { linkToMoment, linkToReplay, linkToShown, readLink } from "./link.js";
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
    if (link.show) return app.shelf.show(link.show);
    app.waitFor(link.game, () => this.#show(link));
    if (!link.state) return app.choose(link.game);
    app.show(Play.begin(...(await app.load(link.game)), link.settings, link.state));
    app.showView(link);
    app.setPaused(true);
    app.say("This is the moment of the link: press Play, or P.");
  }

  giveReplay() {
    const { play, replayBytes, shelf } = this.app;
    if (shelf.shown) return this.#give(linkToShown(shelf.shown));
    return this.#give(linkToReplay(play.isReplay ? replayBytes : play.session.replay()));
  }

  giveMoment() {
    const { app } = this;
    app.setPaused(true);
    const left = app.play.changes.inForce.length ? " Frozen bytes and interventions are not in it." : "";
    return this.#give(linkToMoment(app.play, app.speed, app.openPanels()), left);
  }

  async #give(address, left = "") {
    this.element.value = address;
    this.element.hidden = false;
    this.element.select();
    const size = `The link has ${address.length} letters`;
    this.app.say(`${size}; it is selected, to be copied.${left}`);
    const copied = navigator.clipboard?.writeText(address);
    await copied?.then(() => this.app.say(`${size}; it is copied.${left}`), () => {}); // a browser may refuse
  }
}
