// The loop: plays the frames that are due, at the rate of the game, when the browser draws.

export class Loop {
  #last = 0;
  #owed = 0;

  /** `runs` says whether frames are due, `frame` plays one, `draw` shows the last. */
  constructor(runs, frame, draw) {
    Object.assign(this, { runs, frame, draw, rate: 60 });
    const tick = (now) => {
      this.#tick(now);
      requestAnimationFrame(tick);
    };
    requestAnimationFrame(tick);
  }

  #tick(now) {
    let due = ((now - this.#last) / 1000) * this.rate;
    this.#last = now;
    if (this.runs()) {
      // A screen of nearly the game's rate shows each frame once; the sound follows (worklet.js).
      const whole = Math.round(due);
      if (Math.abs(due - whole) < 0.02 * whole) due = whole;
      // After a pause of the browser, frames are dropped.
      this.#owed = Math.min(this.#owed + due, 2 + this.rate / 15);
      for (; this.#owed >= 1 && this.runs(); this.#owed -= 1) this.frame();
    }
    this.draw();
  }
}
