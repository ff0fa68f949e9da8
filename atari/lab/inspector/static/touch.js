// A stick and a fire button for fingers, shown where the pointer is coarse or the page is narrow.

import { h } from "./dom.js";

const DEAD = 0.25; // of the radius; nearer to the centre, the stick is not moved
const NEUTRAL = { vertical: 0, horizontal: 0 };

// The direction of a point at (x, y) from the stick's centre, y downwards: one of eight, each of 45 degrees.
export function direction(x, y, radius) {
  if (Math.hypot(x, y) < DEAD * radius) return NEUTRAL;
  const eighth = Math.round(Math.atan2(-y, x) / (Math.PI / 4));
  const sign = (value) => Math.sign(Math.round(value));
  return { vertical: sign(Math.sin((eighth * Math.PI) / 4) * 2), horizontal: sign(Math.cos((eighth * Math.PI) / 4) * 2) };
}

export class TouchStick {
  // `changed` is called after a finger has moved the stick, or pressed or released the button.
  constructor(changed) {
    Object.assign(this, { ...NEUTRAL, fire: false, changed });
    this.knob = h("span", { class: "knob" });
    this.pad = h("div", { class: "pad", role: "img", "aria-label": "Stick: drag" }, this.knob);
    this.button = h("div", { class: "fire", role: "img", "aria-label": "Fire: hold" }, "Fire");
    this.element = h("div", { class: "touch" }, this.pad, this.button);
    this.#follow(this.pad, (event) => this.#move(event), () => this.#set({ ...NEUTRAL }));
    this.#follow(this.button, () => this.#set({ fire: true }), () => this.#set({ fire: false }));
  }

  // The stick and the button each follow their own finger.
  #follow(element, down, up) {
    let finger = null;
    element.addEventListener("pointerdown", (event) => {
      if (finger !== null) return;
      event.preventDefault();
      finger = event.pointerId;
      element.setPointerCapture(finger);
      down(event);
    });
    element.addEventListener("pointermove", (event) => event.pointerId === finger && down(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
      element.addEventListener(name, (event) => {
        if (event.pointerId !== finger) return;
        finger = null;
        up();
      });
    }
  }

  #move({ clientX, clientY }) {
    const { left, top, width } = this.pad.getBoundingClientRect();
    this.#set(direction(clientX - left - width / 2, clientY - top - width / 2, width / 2));
  }

  #set(now) {
    if (Object.entries(now).every(([name, value]) => this[name] === value)) return;
    Object.assign(this, now);
    this.knob.style.transform = `translate(${this.horizontal * 60}%, ${-this.vertical * 60}%)`;
    this.button.classList.toggle("held", this.fire);
    this.changed();
  }
}
