// Sound: samples of the console go to a worklet. There is none before the first click or key.

import { scriptAddress } from "./files.js";

const SAMPLES = 512; // of a frame
const LATENCY = 3; // frames

export class Sound {
  #context = null;
  #node = null;
  #pace = null;
  on = true;

  /** Starts the sound: browsers permit it within a click or a key. */
  async start() {
    if (this.#context) return this.#context.resume();
    try {
      this.#context = new AudioContext({ latencyHint: "interactive" });
      await this.#context.audioWorklet.addModule(scriptAddress("worklet.js"));
    } catch {
      this.on = false;
      throw new Error("This browser plays no sound; the game goes on without.");
    }
    this.#node = new AudioWorkletNode(this.#context, "console-sound", { outputChannelCount: [2] });
    this.#node.connect(this.#context.destination);
    this.#node.port.postMessage(this.#pace);
  }

  /** "running", "suspended", or "none" before the start. */
  get state() { return this.#context?.state ?? "none"; }

  /** The frames a second that are played. */
  pace(frames) {
    this.#pace = { rate: SAMPLES * frames, target: SAMPLES * Math.max(LATENCY, (LATENCY * frames) / 60) };
    this.#node?.port.postMessage(this.#pace);
  }

  /** Plays the samples of a frame. */
  push(samples) {
    if (!this.#node || !this.on) return;
    const own = samples.slice();
    this.#node.port.postMessage(own, [own.buffer]);
  }
}
