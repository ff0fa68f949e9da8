// The end of the sound: a ring of samples, resampled to the rate of the output. It runs in the thread of the sound.

const SIZE = 1 << 15;
const MASK = SIZE - 1;

class ConsoleSound extends AudioWorkletProcessor {
  constructor() {
    super();
    Object.assign(this, { ring: new Float32Array(SIZE), written: 0, read: 0, playing: false, rate: 30720, target: 1536 });
    Object.assign(this, { sample: 0, before: 0, out: 0 });
    this.port.onmessage = ({ data }) => (data instanceof Uint8Array ? this.take(data) : Object.assign(this, data));
  }

  take(samples) {
    for (const sample of samples) this.ring[this.written++ & MASK] = (sample - 128) / 128;
    // Sound that comes too early would be heard too late.
    if (this.written - this.read > 4 * this.target) this.read = this.written - this.target;
  }

  process(_, [channels]) {
    const [channel] = channels;
    const fill = this.written - this.read;
    if (fill >= this.target) this.playing = true;
    // The clocks of sound and screen differ a little: read faster from a full ring, slower from an empty one.
    const lean = Math.max(-1, Math.min(1, (fill - this.target) / this.target));
    const step = (this.rate / sampleRate) * (1 + 0.01 * lean);
    for (let i = 0; i < channel.length; i += 1) {
      if (this.playing && this.written - this.read < 2 + step) this.playing = false;
      if (this.playing) this.sample = this.next(step);
      // A high-pass filter: where samples are missing, the output goes to zero without a click.
      this.out = this.sample - this.before + 0.996 * this.out;
      this.before = this.sample;
      channel[i] = 0.6 * this.out;
    }
    for (const other of channels.slice(1)) other.set(channel);
    return true;
  }

  next(step) {
    const place = Math.floor(this.read);
    const part = this.read - place;
    this.read += step;
    return this.ring[place & MASK] * (1 - part) + this.ring[(place + 1) & MASK] * part;
  }
}

registerProcessor("console-sound", ConsoleSound);
