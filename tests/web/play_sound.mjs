// Runs the worklet of the page's sound for some seconds, while a loop gives it frames of a tone in time. Prints, for each
// case, how often the sound stopped, and the largest step between two samples.
import { readFileSync } from "node:fs";

const RATE = 48000, QUANTUM = 128, SAMPLES = 512, FRAMES = 60, TONE = 440;
const { seconds, cases } = JSON.parse(readFileSync(0, "utf8"));

globalThis.sampleRate = RATE;
globalThis.AudioWorkletProcessor = class { port = {}; };
let Worklet;
globalThis.registerProcessor = (_, Kind) => { Worklet = Kind; };
await import("../../web/page/worklet.js");

/** `drift` is how much slower the clock of the sound is; every `late` frames one comes a frame late, with the next. */
function heard({ drift, late }) {
  const worklet = new Worklet();
  let frames = 0, phase = 0, stops = 0, step = 0, before = 0;
  const tone = () => Uint8Array.from({ length: SAMPLES }, () => 128 + 60 * Math.sin((phase += (2 * Math.PI * TONE) / (FRAMES * SAMPLES))));
  for (let quantum = 0; quantum < (seconds * RATE) / QUANTUM; quantum += 1) {
    let due = Math.floor(((quantum * QUANTUM) / RATE) * FRAMES * drift);
    if (late && due % late === 0) due -= 1;
    for (; frames < due; frames += 1) worklet.take(tone());
    const was = worklet.playing;
    const channel = new Float32Array(QUANTUM);
    worklet.process([], [[channel]]);
    if (was && !worklet.playing) stops += 1;
    for (const sample of channel) {
      if (quantum > RATE / QUANTUM / 2) step = Math.max(step, Math.abs(sample - before));
      before = sample;
    }
  }
  return { stops, step };
}

console.log(JSON.stringify(cases.map(heard)));
